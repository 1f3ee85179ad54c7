// "Your FMU": a released FMU comes back with the values of the page. It stays in this page.

import { save } from "./downloads";
import { choice, element } from "./dom";
import { fileDrop } from "./file-drop";
import { fitSection } from "./fit/section";
import { fittedValues } from "./fit/files";
import type { FitContext } from "./fit/study";
import { Refusal, type Machine, type Values } from "./library";
import { CONTROLLER, CYLINDER } from "./settings";

const PRESETS = [
  ["minimal", "The fewest"],
  ["rig", "Those that count"],
  ["all", "All"],
] as const;
const KEPT = ["inputs", "outputs", "parameters"] as const;

/** Components of the drive, and their models. */
const PARTS = { plant: CYLINDER, controller: CONTROLLER };

/** Fills a place with what asks for an FMU, and gives it back as the visitor's own. */
export function offerFmu(place: HTMLElement, context: FitContext): void {
  let preset: (typeof PRESETS)[number][0] = "minimal";
  const field = (label: string, value: string, placeholder = "") =>
    element("input", { type: "text", value, placeholder, autocomplete: "off", spellcheck: "false", "aria-label": label });
  const name = field("Name of the machine", "Axis7");
  const lists = KEPT.map((kind) => field(kind, "", "as chosen above"));
  const problem = element("p", { class: "problem", role: "alert", hidden: true });
  const told = element("output", { class: "muted" });
  const tell = (refusal: string, made: string) => {
    problem.textContent = refusal;
    problem.hidden = refusal === "";
    told.textContent = made;
  };
  const row = (label: string, input: HTMLElement) => element("label", { class: "choice" }, element("span", {}, label), input);

  const make = async (file: File): Promise<void> => {
    tell("", "");
    try {
      const source = new Uint8Array(await file.arrayBuffer());
      const kept = KEPT.map((kind, index) => [kind, words(lists[index].value)] as const);
      const machine: Machine = {
        name: name.value.trim(),
        preset,
        ...Object.fromEntries(kept.filter(([, names]) => names.length)),
        parts: PARTS,
        ...configured(context),
      };
      const made = context.library.ownFmu(machine, source);
      const ending = /\.ssp$/i.test(file.name) ? "ssp" : "fmu";
      save(`${machine.name}.${ending}`, made, "application/octet-stream");
      tell("", `${machine.name}.${ending}: ${(made.length / 1e6).toFixed(2)} MB, made of ${file.name}.`);
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
      tell(error.message, "");
    }
  };

  place.append(
    row("Name", name),
    choice("Variables that stay", PRESETS.map(([key, label]) => [key, label] as const), preset, (chosen) => (preset = chosen)),
    element(
      "details",
      {},
      element("summary", {}, "Name the variables"),
      element("p", { class: "muted" }, "Names with commas between them take the place of the choice above."),
      ...KEPT.map((kind, index) => row(`${kind[0].toUpperCase()}${kind.slice(1)}`, lists[index])),
    ),
    fileDrop({ label: "Released FMU", text: "Drop PneumaticServoCylinder.fmu here", accept: ".fmu,.ssp", open: (file) => void make(file) }),
    problem,
    told,
  );
}

const words = (text: string): string[] => text.split(/[\s,]+/).filter(Boolean);

/** Values by model, and what the documentation page says beside them: of a fit that is shown, or of the settings. */
function configured(context: FitContext): Pick<Machine, "values" | "sections"> {
  const { settings, study } = context;
  const values: Record<string, Values> = { ...settings.values };
  if (settings.view !== "fit" || !study.found) return { values, sections: "" };
  values[study.modelName] = fittedValues(context, study.found);
  return { values, sections: fitSection(context, study.found) };
}
