// The part of papaparse that this page uses; its own types require Node's.
declare module "papaparse" {
  interface Chunk {
    data: string[][];
    errors: { type: string; code: string; message: string; row?: number }[];
    /** `cursor`: characters that are done. */
    meta: { cursor: number };
  }
  interface Settings {
    delimiter: string;
    newline: "\n" | "\r";
    chunk(rows: Chunk, parser: { abort(): void }): void;
    complete(): void;
    error?(problem: Error): void;
  }
  const Papa: {
    parse(text: string | Blob, settings: Settings): void;
    parse(text: string, settings: { delimiter: string }): { data: string[][] };
  };
  export default Papa;
}
