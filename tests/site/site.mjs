// The site as it was built, and Chromium to open it with, from a folder.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { readdir } from "node:fs/promises";
import path from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

export const SITE = path.resolve(process.env.SITE ?? "../../target/site");
const FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"];

export const launch = () => chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: FLAGS });

/** Every page, by its path in the site; rustdoc has its own tests. */
export async function pages() {
  const files = await readdir(SITE, { recursive: true });
  return files.filter((file) => file.endsWith(".html") && !file.startsWith("rust/") && !file.startsWith("site/") && file !== "playground.html").sort();
}

/** Opens a page, and tells which files it has asked for; `close` fails if there was an error in the console or a request left the site. */
export async function open(browser, name, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1200, height: 900 }, ...options });
  // It says that something hangs, not that a machine is slow.
  context.setDefaultTimeout(600_000);
  const page = await context.newPage();
  const problems = [];
  const asked = new Set();
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type())) problems.push(`${name}: ${message.type()}: ${message.text()}`);
  });
  page.on("pageerror", (error) => problems.push(`${name}: ${error.stack}`));
  page.on("request", (request) => {
    const { protocol, pathname } = new URL(request.url());
    if (["data:", "blob:"].includes(protocol)) return;
    asked.add(decodeURI(pathname));
    if (protocol !== "file:" || !decodeURI(pathname).startsWith(SITE)) problems.push(`${name}: asks for ${request.url()}`);
  });
  assert.ok(existsSync(path.join(SITE, name)), `${name}: build the site first`);
  await page.goto(pathToFileURL(path.join(SITE, name)).href, { waitUntil: "load" });
  const close = async () => {
    await context.close();
    assert.deepEqual(problems, []);
  };
  return { page, asked, close };
}

/** The frame in which the plant runs, once it does. */
export async function plant(page) {
  const frame = await (await page.waitForSelector("#plant")).contentFrame();
  await frame.waitForSelector("html[data-ready]");
  return frame;
}
