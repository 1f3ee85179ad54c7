// Takes the picture of the README, and others to look at: `npm run pictures -- <folder>`.
import { launch, open, VIEWS } from "./browser.mjs";

const folder = process.argv[2];
/** In s: where friction holds the carriage. */
const INSTANT = 4.5;
const browser = await launch();
const LOOKS = [
  ["", { viewport: { width: 1440, height: 1180 } }],
  ["-dark", { viewport: { width: 1440, height: 1180 }, colorScheme: "dark" }],
  ["-narrow", { viewport: { width: 400, height: 1400 }, hasTouch: true, isMobile: true }],
];
for (const view of VIEWS) {
  for (const [suffix, options] of LOOKS) {
    const { page, close } = await open(browser, `#view=${view}`, options);
    const reached = (end) => Number(document.querySelector("[data-status]")?.dataset.time ?? end) >= end;
    await page.waitForFunction(reached, INSTANT);
    await page.keyboard.press("Space");
    await page.waitForTimeout(400);
    await page.screenshot({ path: `${folder}/${view}${suffix}.png` });
    await close();
  }
}
await browser.close();
