// The worker that runs a cylinder under a visitor's controller, without access to page and network.

import { Library, type Values } from "../library";
import { Run, type Member } from "../run";
import { LONGEST, VOLTS } from "./rules";

export interface Task {
  module: WebAssembly.Module;
  values: Values;
  watched: readonly string[];
}

/** Columns of the run, time first, then the watched variables in their order; or the reason why there are none. */
export type Answer = { columns: Float64Array[] } | { problem: string };

type Control = (time: number, position: number, velocity: number) => unknown;
/** Stands before this program, in the same text. */
declare const visitorsControl: Control;

function race(library: Library, { values, watched }: Task): Float64Array[] {
  const first = new Map([["valveVoltage", (VOLTS[0] + VOLTS[1]) / 2]]);
  const member: Member = { prefix: "", model: "PneumaticServoCylinder", values, first, watched };
  const places = ["position", "velocity"].map((name) => watched.indexOf(name));
  const run = new Run(library, [member], (time, running) => {
    const shown = running.read(0);
    const wanted = visitorsControl(time, shown[places[0]], shown[places[1]]);
    if (typeof wanted !== "number" || !Number.isFinite(wanted)) {
      throw new Error(`control(${time}, ...) returned ${String(wanted)}: it must be a voltage in V`);
    }
    running.set(0, new Map([["valveVoltage", Math.min(Math.max(wanted, VOLTS[0]), VOLTS[1])]]));
  });
  while (run.time < LONGEST) run.step();
  return ["time", ...watched].map((name) => run.recording.column(name).slice());
}

self.addEventListener("message", ({ data }: MessageEvent<Task>) => {
  Library.of(data.module)
    .then((library) => {
      const columns = race(library, data);
      self.postMessage({ columns } satisfies Answer, { transfer: columns.map(({ buffer }) => buffer as ArrayBuffer) });
    })
    .catch((error: unknown) => {
      self.postMessage({ problem: error instanceof Error ? error.message : String(error) } satisfies Answer);
    });
});
