// A module of the page by itself, without a browser.
import { createRequire } from "node:module";
import { fileURLToPath } from "node:url";

const SOURCES = new URL("../../web/playground/", import.meta.url);
const { buildSync } = createRequire(new URL("package.json", SOURCES))("esbuild");

export async function part(name) {
  const entry = fileURLToPath(new URL(`page/${name}.ts`, SOURCES));
  const { outputFiles } = buildSync({ entryPoints: [entry], bundle: true, format: "esm", write: false });
  return import(`data:text/javascript;base64,${Buffer.from(outputFiles[0].text).toString("base64")}`);
}
