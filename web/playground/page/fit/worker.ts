// The worker that reads tables, checks records and fits, so that the page never waits for any of these.

import { Library } from "../library";
import { fit } from "./fit";
import type { Request, Reply } from "./job";

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
  const library = await Library.of(request.module);
  if (request.kind === "read") {
    const table = library.readTable(request.file.name, new Uint8Array(await request.file.arrayBuffer()));
    tell({ kind: "table", table }, [table.lines.buffer, ...table.columns.map((column) => column.buffer)]);
    return;
  }
  if (request.kind === "check") {
    const { table, columns, experiment, law, known } = request;
    tell({ kind: "findings", findings: library.findings(table, columns, experiment, law, known) });
    return;
  }
  const found = fit(library, request.question, throttled((progress) => tell({ kind: "progress", progress })));
  tell({ kind: "answer", answer: found });
}

self.addEventListener("message", ({ data }: MessageEvent<Request>) => {
  answer(data).catch((error: unknown) => {
    tell({ kind: "problem", text: error instanceof Error ? error.message : String(error) });
  });
});
