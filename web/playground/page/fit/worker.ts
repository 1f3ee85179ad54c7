// The worker that reads tables and fits, so that the page never waits for either.

import { Library } from "../library";
import { fit } from "./fit";
import type { Request, Reply } from "./job";
import { readTable } from "./table";
import { plain } from "../units";

/** Progress is told at most so often, in ms. */
const OFTEN = 80;

const tell = (reply: Reply, transfer: Transferable[] = []) => self.postMessage(reply, { transfer });

/** A function that passes on what it is given, but not too often. */
function throttled<T>(pass: (value: T) => void): (value: T) => void {
  let last = 0;
  return (value) => {
    const now = performance.now();
    if (now - last < OFTEN) return;
    last = now;
    pass(value);
  };
}

async function answer(request: Request): Promise<void> {
  if (request.kind === "read") {
    const units = new Set(request.units);
    const progress = throttled((share: number) => tell({ kind: "read", share }));
    const table = await readTable(request.file.name, request.file, (text) => units.has(plain(request.spellings, text)), progress);
    tell({ kind: "table", table }, [table.lines.buffer, ...table.columns.map((column) => column.buffer)]);
    return;
  }
  const library = await Library.of(request.module);
  const found = fit(library, request.question, throttled((progress) => tell({ kind: "progress", progress })));
  tell({ kind: "answer", answer: found });
}

self.addEventListener("message", ({ data }: MessageEvent<Request>) => {
  answer(data).catch((error: unknown) => {
    tell({ kind: "problem", text: error instanceof Error ? error.message : String(error) });
  });
});
