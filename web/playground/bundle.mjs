// Makes the page one file: `node bundle.mjs <plant.wasm> <licences.txt> <index.html>`.
import { readFile, writeFile } from "node:fs/promises";
import { gzipSync } from "node:zlib";
import { build } from "esbuild";

const [plant, licences, page] = process.argv.slice(2);
const folder = new URL("page/", import.meta.url);

/** The bundled text of an entry and of everything it imports. */
async function bundled(entry) {
  const result = await build({
    entryPoints: [new URL(entry, folder).pathname],
    bundle: true,
    minify: true,
    write: false,
    format: "iife",
    target: "es2022",
    charset: "utf8",
    legalComments: "none", // the licences are in the page as a text
  });
  return result.outputFiles[0].text;
}

/** A text as the contents of an element. */
const escaped = (text) => text.replaceAll("&", "&amp;").replaceAll("<", "&lt;");

/** A program as the contents of an element, which a closing tag inside a string would end. */
const script = async (entry) => (await bundled(entry)).replaceAll("</script", "<\\/script");

const compressed = async (file) => gzipSync(await readFile(file), { level: 9 }).toString("base64");

/** The packages whose code is in the page. */
const PACKAGES = ["uplot"];
const line = "=".repeat(80);
const packages = PACKAGES.map(async (name) => {
  const licence = await readFile(new URL(`node_modules/${name}/LICENSE`, import.meta.url), "utf8");
  return `${line}\n${name}\n\n${licence}`;
});
const parts = {
  STYLE: await bundled("style.css"),
  SCRIPT: await script("main.ts"),
  WORKER: await script("fit/worker.ts"),
  RACER: await script("race/worker.ts"),
  EXAMPLE: await compressed(new URL("../../examples/rig.csv", import.meta.url)),
  PLANT: await compressed(plant),
  LICENCES: escaped([await readFile(licences, "utf8"), ...(await Promise.all(packages))].join("\n")),
};
const template = await readFile(new URL("index.html", folder), "utf8");
await writeFile(page, template.replace(/\{\{([A-Z]+)\}\}/g, (_, name) => parts[name]));
