// Cures of hunting as switches, and a table that has them side by side.

import type { Context } from "./context";
import { element } from "./dom";
import { coupled, judged, loopMembers } from "./position-loop";
import { MM } from "./quantities";
import { Run, STEP } from "./run";
import { CONTROLLER, CYLINDER } from "./settings";
import { model, variable } from "./tables";

/** Amplitude of the dither in V, and the error in m below which the integral part is held. */
const [DITHER, STOP] = [1, 1e-3];
/** Slots of the plants that are compared. */
const SLOT = 4;
/** In s: how long each runs, and the end of it that is judged. */
const [LONG, JUDGED] = [24, 8];
/** Steps between two pictures. */
const SLICE = 200;

const DEAD_ZONE = "valve.deadZone";

export class Cures {
  readonly root = element("div", { class: "cures", role: "group", "aria-label": "Cures of hunting" });
  private readonly table = element("tbody", {});
  private readonly result = element("div", { class: "wide", hidden: true });
  private readonly compare = element("button", { type: "button", title: "Run the loop with each of them and judge its end", onclick: () => void this.run() }, "Compare");

  /** `restart` begins the run anew. */
  constructor(
    private readonly context: Context,
    restart: () => void,
  ) {
    const { settings } = context;
    const box = (label: string, title: string, isOn: boolean, put: (isOn: boolean) => void) => {
      const input = element("input", { type: "checkbox", onchange: () => put(input.checked) });
      input.checked = isOn;
      return element("label", { class: "cure", title }, input, label);
    };
    const own = (key: "dither" | "integralStop", value: number) => (isOn: boolean) => {
      settings[key] = isOn ? value : 0;
      context.changed();
      restart();
    };
    const head = ["", "RMS error", "Swing of the error"].map((text) => element("th", { scope: "col" }, text));
    this.result.append(element("table", {}, element("thead", {}, element("tr", {}, ...head)), this.table));
    this.root.append(
      element("span", { class: "title" }, "Against hunting"),
      box("Dead-zone compensation", "The controller jumps over the dead zone of the valve", this.deadZone > 0, (isOn) =>
        context.change(CONTROLLER, DEAD_ZONE, isOn ? this.ofPlant : 0),
      ),
      box("Integral stop", `The integral part is held while the error is below ${STOP * MM} mm`, settings.integralStop > 0, own("integralStop", STOP)),
      box("Dither", `A square wave of ±${DITHER} V and 25 Hz on the voltage`, settings.dither > 0, own("dither", DITHER)),
      this.compare,
      this.result,
    );
  }

  /** What is done in the present run. */
  get present() {
    const { dither, integralStop } = this.context.settings;
    return { dither, integralStop, gain: this.value(CONTROLLER, "gain.integral") };
  }

  private get deadZone(): number {
    return this.value(CONTROLLER, DEAD_ZONE);
  }

  /** The dead zone of the valve. */
  private get ofPlant(): number {
    return this.value(CYLINDER, DEAD_ZONE);
  }

  private value(of: string, name: string): number {
    const { settings, library } = this.context;
    return settings.values[of].get(name) ?? variable(model(library.tables, of), name).start ?? 0;
  }

  /** Runs the loop with each cure, a little at a time, and fills the table. */
  private async run(): Promise<void> {
    const { settings, library } = this.context;
    const signal = { ...settings.signal };
    const { gain } = this.present;
    const cases: [string, number, number, number][] = [
      ["None", 0, 0, 0],
      ["Dead-zone compensation", this.ofPlant, 0, 0],
      ["… with integral stop", this.ofPlant, STOP, 0],
      ["… with dither", this.ofPlant, 0, DITHER],
    ];
    this.compare.disabled = true;
    this.result.hidden = false;
    const cells = cases.map(([label]) => [element("td", {}), element("td", {}), label] as const);
    this.table.replaceChildren(...cells.map(([rms, swing, label]) => element("tr", {}, element("th", { scope: "row" }, label), rms, swing)));
    for (const [index, [, deadZone, integralStop, dither]] of cases.entries()) {
      const controller = new Map([...settings.values[CONTROLLER], [DEAD_ZONE, deadZone]]);
      const exchange = coupled(() => signal, () => ({ dither, integralStop, gain }), () => []);
      const run = new Run(library, loopMembers(settings.values[CYLINDER], controller, signal), exchange, SLOT);
      while (run.time < LONG) {
        for (let step = 0; step < SLICE; step += 1) run.step();
        await new Promise((resolve) => setTimeout(resolve));
        if (!this.root.isConnected) return;
      }
      const { rms, swing } = judged(run.recording, run.recording.rows - Math.ceil(JUDGED / STEP));
      [rms, swing].forEach((value, cell) => ((cells[index][cell] as HTMLElement).textContent = `${(value * MM).toFixed(3)} mm`));
    }
    this.compare.disabled = false;
  }
}
