// The library run natively, for comparison.
import { spawnSync } from "node:child_process";
import assert from "node:assert/strict";

/** Asks the program `replay`; returns the bits of the outputs, row by row. */
export function replay(runs) {
  const lines = runs.flatMap(({ model, values, inputs, outputs, rows }) => [
    `model ${model}`,
    ...Object.entries(values).map(([name, value]) => `set ${name} ${value}`),
    `inputs ${inputs.join(" ")}`,
    `outputs ${outputs.join(" ")}`,
    ...rows.map((row) => `row ${row.join(" ")}`),
  ]);
  const program = process.env.REPLAY ?? "../../target/debug/examples/replay";
  const answer = spawnSync(program, { input: `${lines.join("\n")}\n`, encoding: "utf8", maxBuffer: 1 << 30 });
  assert.equal(answer.status, 0, answer.stderr || String(answer.error));
  return answer.stdout.trimEnd().split("\n");
}

/** The bits of a number, as the program prints them. */
export function bits(value) {
  const view = new DataView(new ArrayBuffer(8));
  view.setFloat64(0, value);
  return view.getBigUint64(0).toString(16).padStart(16, "0");
}
