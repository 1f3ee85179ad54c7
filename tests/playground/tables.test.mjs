// The page reads tables as the Python package does: the same columns to the last bit, and the same refusals.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { after, before, test } from "node:test";
import { gzipSync } from "node:zlib";
import { launch, open } from "./browser.mjs";
import { valuesOf } from "./python.mjs";

const CORPUS = JSON.parse(await readFile(new URL("../tables/corpus.json", import.meta.url), "utf8"));
let browser;
before(async () => (browser = await launch()));
after(() => browser.close());

/** The files of the corpus in base 64. */
const files = Object.entries(CORPUS).map(([name, { file, text, encoding = "utf8" }]) => {
  const bytes = encoding === "gzip" ? gzipSync(text) : Buffer.from(text, encoding);
  return { name, file, bytes: bytes.toString("base64") };
});

/** Reads files in the page: what is in each, with the bits of its numbers, or its refusal. */
function inPage(files) {
  const bits = (value) => {
    const view = new DataView(new ArrayBuffer(8));
    view.setFloat64(0, value);
    return Number.isNaN(value) ? "nan" : view.getBigUint64(0).toString(16).padStart(16, "0");
  };
  return files.map(({ file, bytes }) => {
    try {
      const given = Uint8Array.from(atob(bytes), (character) => character.charCodeAt(0));
      const table = globalThis.pneumaticServo.readTable(file, given);
      const { header, names, units, first } = table;
      const columns = table.columns.map((column) => Array.from(column, bits));
      const [faults, clocks] = [table.faults, table.clocks].map((of) => [...of]);
      return { header, names, units, first, columns, lines: [...table.lines], faults, clocks, gaps: [...table.gaps] };
    } catch (error) {
      return { refused: error.message };
    }
  });
}

/** The same by the Python package. */
const PROGRAM = `
import base64, json, struct
from pathlib import Path
from pneumatic_servo.tables import read_table

def read(file, data):
    Path(file).write_bytes(base64.b64decode(data))
    try:
        table = read_table(file)
    except ValueError as error:
        return {"refused": str(error)}
    bits = lambda value: struct.pack(">d", value).hex() if value == value else "nan"
    return {
        "header": table.header, "names": table.names, "units": table.units, "first": table.first,
        "columns": [[bits(value) for value in column] for column in table.values.T.tolist()],
        "lines": table.lines.tolist(), "faults": sorted(map(list, table.faults.items())),
        "clocks": sorted(map(list, table.clocks.items())), "gaps": sorted(table.gaps),
    }

files = json.loads(Path("files.json").read_text())
print(json.dumps([read(each["file"], each["bytes"]) for each in files]))
`;

test("page and Python read the same columns, to the last bit, or refuse in the same words", async () => {
  const { page, close } = await open(browser, "#view=fit");
  const found = await page.evaluate(inPage, files);
  const expected = await valuesOf({ name: "files.json", text: JSON.stringify(files) }, PROGRAM);
  for (const [place, { name }] of files.entries()) assert.deepEqual(found[place], expected[place], name);
  const refused = found.filter((each) => "refused" in each).length;
  assert.ok(refused > 15 && found.length - refused > 40, `${refused} of ${found.length} files are refused`);
  await close();
});
