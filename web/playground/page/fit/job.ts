// Jobs, each in a worker of its own, so that it can be ended at any time.

import { byId } from "../dom";
import type { Columns } from "./columns";
import type { Finding } from "./findings";
import type { Answer, Progress, Question } from "./fit";
import type { Table } from "./table";

export type Request =
  | { kind: "read"; module: WebAssembly.Module; file: File }
  | { kind: "check"; module: WebAssembly.Module; table: Table; columns: Columns; experiment: string; law: number; known: ReadonlyMap<string, number> }
  | { kind: "fit"; module: WebAssembly.Module; question: Question };

export type Reply =
  | { kind: "table"; table: Table }
  | { kind: "findings"; findings: Finding[] }
  | { kind: "progress"; progress: Progress }
  | { kind: "answer"; answer: Answer }
  | { kind: "problem"; text: string };

/** The program of the worker, which is a text in the page: a page that is a file may load no other one. */
let program: string | null = null;

/** Begins a piece of work; returns what ends it. */
export function begin(request: Request, take: (reply: Reply) => void): () => void {
  program ??= URL.createObjectURL(new Blob([byId("worker").textContent ?? ""], { type: "text/javascript" }));
  const worker = new Worker(program);
  worker.addEventListener("message", ({ data }: MessageEvent<Reply>) => {
    if (data.kind !== "progress") worker.terminate();
    take(data);
  });
  worker.addEventListener("error", (event) => {
    worker.terminate();
    take({ kind: "problem", text: event.message || "the worker could not be started" });
  });
  worker.postMessage(request);
  return () => worker.terminate();
}
