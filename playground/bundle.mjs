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

const uplot = await readFile(new URL("node_modules/uplot/LICENSE", import.meta.url), "utf8");
const line = "=".repeat(80);
const parts = {
  STYLE: await bundled("style.css"),
  // A closing tag inside a string would end the element.
  SCRIPT: (await bundled("main.ts")).replaceAll("</script", "<\\/script"),
  PLANT: gzipSync(await readFile(plant), { level: 9 }).toString("base64"),
  LICENCES: escaped(`${await readFile(licences, "utf8")}\n${line}\nuPlot\n\n${uplot}`),
};
const template = await readFile(new URL("index.html", folder), "utf8");
await writeFile(page, template.replace(/\{\{([A-Z]+)\}\}/g, (_, name) => parts[name]));
