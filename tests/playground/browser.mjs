// The page in headless Chromium, watched for errors and requests.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

/** The page as a visitor opens it: a file. */
export const PAGE = pathToFileURL(process.env.PLAYGROUND ?? "../../target/playground/index.html").href;
const FLAGS = [
  "--headless",
  "--no-sandbox",
  "--disable-gpu",
  "--disable-quic",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
];

/** In ms: how long a test waits for what must come. It says that something hangs, not that a machine is slow. */
export const PATIENCE = 600_000;

/** The pages on which something runs. */
export const VIEWS = ["stick-slip", "two-laws", "presliding", "closed-loop"];

export const launch = () => chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: FLAGS });

/** Opens the page at a query and a fragment; `close` fails if there was an error in the console or a request left the page. */
export async function open(browser, fragment = "", options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 }, ...options });
  context.setDefaultTimeout(PATIENCE);
  const page = await context.newPage();
  if (options.language) {
    await page.addInitScript((language) => Object.defineProperty(navigator, "language", { value: language, configurable: true }), options.language);
  }
  const problems = [];
  const note = (kind, text) => problems.push(`${kind}: ${text}`);
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type())) note(message.type(), message.text());
  });
  page.on("pageerror", (error) => note("error", error.stack));
  page.on("request", (request) => {
    const address = request.url();
    if (!["file:", "data:", "blob:"].includes(new URL(address).protocol)) note("request", address);
    if (address.startsWith("file:") && address.split(/[?#]/)[0] !== PAGE) note("request", address);
  });
  await page.goto(PAGE + fragment);
  await page.waitForSelector("html[data-ready]");
  const close = async () => {
    await context.close();
    assert.deepEqual(problems, []);
  };
  return { page, close };
}

/** The settings in the address. */
export async function fragment(page) {
  await page.waitForTimeout(500); // The address follows with a delay.
  return new URLSearchParams(new URL(page.url()).hash.slice(1));
}

/** Presses one of the buttons for files, and returns name and text of the file. */
export async function download(page, button) {
  const [file] = await Promise.all([
    page.waitForEvent("download"),
    page.locator("#files").getByRole("button", { name: button }).click(),
  ]);
  return { name: file.suggestedFilename(), text: await readFile(await file.path(), "utf8") };
}

/** Waits until a number of seconds is simulated. */
export async function reached(page, seconds) {
  const isReached = (end) => Number(document.querySelector("[data-status]").dataset.time) >= end;
  await page.waitForFunction(isReached, seconds);
}

/** Waits until a number of seconds is simulated, and pauses. */
export async function runFor(page, seconds) {
  await reached(page, seconds);
  await page.getByRole("button", { name: "Pause" }).click();
}
