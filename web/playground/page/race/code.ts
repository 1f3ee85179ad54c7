// A visitor's controller, run in a worker of its own: it ends with an answer, a problem, or when it takes too long.

import { byId } from "../dom";
import type { Answer, Task } from "./worker";

/** Time in ms after which a controller is taken to have no end. */
const PATIENCE = 10_000;

/** The columns of the run under a controller; rejects with an `Error` that says what is wrong with it. */
export function raced(code: string, task: Task): Promise<Float64Array[]> {
  const text = `const visitorsControl = (() => {"use strict";\n${code}\nreturn control;\n})();\n${byId("racer").textContent ?? ""}`;
  const address = URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
  const worker = new Worker(address);
  return new Promise<Float64Array[]>((resolve, reject) => {
    const late = setTimeout(() => reject(new Error(`there is no answer after ${PATIENCE / 1000} s: does a loop have no end?`)), PATIENCE);
    worker.onmessage = ({ data }: MessageEvent<Answer>) => {
      clearTimeout(late);
      if ("columns" in data) resolve(data.columns);
      else reject(new Error(data.problem));
    };
    worker.onerror = (event) => {
      event.preventDefault();
      clearTimeout(late);
      // The first line of the text is not the visitor's.
      const lines = code.split("\n").length;
      const place = event.lineno > 1 && event.lineno <= lines + 1 ? `line ${event.lineno - 1}: ` : "";
      reject(new Error(place + event.message));
    };
    worker.postMessage(task);
  }).finally(() => {
    worker.terminate();
    URL.revokeObjectURL(address);
  });
}
