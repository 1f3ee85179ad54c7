// Takes pictures of every page to look at, wide and narrow, light and dark: `npm run pictures -- <folder> [part of a name]`.
import { mkdir } from "node:fs/promises";
import { launch, open, pages, plant } from "./site.mjs";

const [folder, part = ""] = process.argv.slice(2);
await mkdir(folder, { recursive: true });
const browser = await launch();
for (const name of (await pages()).filter((candidate) => candidate.includes(part))) {
  for (const width of [1200, 400]) {
    for (const colorScheme of ["light", "dark"]) {
      const { page, close } = await open(browser, name, { colorScheme, viewport: { width, height: 1400 } });
      if (name === "index.html") {
        const frame = await plant(page);
        await frame.waitForFunction(() => Number(document.querySelector("[data-status]").dataset.time) > 1.5);
      }
      const file = `${folder}/${name.replaceAll("/", "-").replace(".html", "")}-${width}-${colorScheme}.png`;
      await page.screenshot({ path: file });
      await close();
    }
  }
}
await browser.close();
