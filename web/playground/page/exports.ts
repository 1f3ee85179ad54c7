// The files of a run at one instant, which belong together.

import type { Files } from "./context";
import { Refusal } from "./library";
import { ROWS, type Recording } from "./record";
import { STEP } from "./run";

/**
 * The files of a run. Their name depends on every value of the run, so that a program never reads the file of another run or
 * instant; `program` writes the one that reads the file of a name.
 */
export function filesOfRun(
  kind: string,
  recording: Recording,
  program: (csv: string) => string,
  others: Pick<Files, "ssv" | "charts">,
): Files {
  const csv = recording.csv();
  const name = `${kind}-${checksum(csv)}`;
  return {
    ...others,
    name,
    csv,
    get python() {
      if (!recording.isCut) return program(`${name}.csv`);
      const begin = recording.at("time", 0);
      throw new Refusal(
        `No program can repeat this run: the page keeps the last ${ROWS * STEP} s of inputs at most, and has those from ` +
          `${begin} s on. Restart, and export within ${ROWS * STEP} s.`,
      );
    },
  };
}

/** The 32-bit hash FNV-1a of a text in ASCII, as eight digits. */
function checksum(text: string): string {
  let hash = 0x811c9dc5;
  for (let place = 0; place < text.length; place += 1) hash = Math.imul(hash ^ text.charCodeAt(place), 0x01000193);
  return (hash >>> 0).toString(16).padStart(8, "0");
}
