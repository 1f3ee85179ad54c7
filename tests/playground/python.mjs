// The Python programs of the page, run beside their files.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtemp, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";

/** A Python that has the package. */
const PYTHON = process.env.PYTHON ?? "python3";

/** Runs a program beside the file of its run; returns the list that it prints. */
export async function valuesOf(csv, program) {
  const folder = await mkdtemp(join(tmpdir(), "playground-"));
  try {
    await writeFile(join(folder, csv.name), csv.text);
    const answer = spawnSync(PYTHON, ["-c", program], { cwd: folder, encoding: "utf8", maxBuffer: 1 << 26 });
    assert.equal(answer.status, 0, `${answer.stderr}\n${program}`);
    return JSON.parse(answer.stdout.trimEnd().split("\n").at(-1) ?? "");
  } finally {
    await rm(folder, { recursive: true });
  }
}
