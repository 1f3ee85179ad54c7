// Parameters that a fit usually estimates.

import { lawGroup, type Model } from "../tables";

/**
 * The parameters of a law that a fit usually frees: forces, stiffnesses, dampings, velocities and lengths; of elements those
 * that there are; of GMS their shares; of Dahl and Leuven the exponent. Forces that are 0 by default stay as they are.
 */
export function usual(of: Model, law: number, known: ReadonlyMap<string, number>): string[] {
  const group = `${lawGroup(of, law)}.`;
  const elements = of.variables.find((entry) => entry.name === `${group}N`);
  const number = elements ? (known.get(elements.name) ?? elements.start ?? 0) : 0;
  const units = ["N", "N/m", "N.s/m", "m/s", "1/m", "m"];
  const names = of.variables
    .filter(({ name, of: unit, role, kind, start }) => {
      if (!name.startsWith(group) || kind !== "Real" || (role !== "fixed" && role !== "tunable")) return false;
      const hasNoUnit = name.startsWith(`${group}alpha[`) || name === `${group}n`;
      if ((!units.includes(unit ?? "") && !hasNoUnit) || /(stribeck\.FsInf|revisedLuGre\.v0)$/.test(name)) return false;
      // Of a table the forces at its speeds; viscous friction is part of these.
      const table = /^(.*\.)force\[(\d+)\]$/.exec(name);
      if (group === "friction.table.") return table !== null && Number(table[2]) <= (known.get(`${table[1]}points`) ?? 11);
      const element = /\[(\d+)\]/.exec(name);
      if (element && Number(element[1]) > number) return false;
      return !(start === 0 && (element || unit === "N"));
    })
    .map(({ name }) => name);
  // The shares multiply the level, so that one of both stays as it is.
  return names.filter((name) => !(names.includes(`${group}alpha[1]`) && name === `${group}Fc`));
}
