// The landing page in browsers other than Chromium, where they are installed: the plant runs in each, also where the locale is C.UTF-8.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { existsSync } from "node:fs";
import path from "node:path";
import { setTimeout as sleep } from "node:timers/promises";
import { pathToFileURL } from "node:url";
import { test } from "node:test";
import puppeteer from "puppeteer-core";
import { SITE } from "./site.mjs";

const FIREFOX = ["/usr/bin/firefox-esr", "/usr/bin/firefox"].find(existsSync);
const WEBKIT = ["/usr/bin/WebKitWebDriver", "/usr/bin/Xvfb"];
const MINI_BROWSER = ["/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu"]
  .flatMap((folder) => ["4.1", "4.0"].map((version) => `${folder}/webkit2gtk-${version}/MiniBrowser`))
  .find(existsSync);
/** The plant by itself, so that the page can be asked without its frame. */
const PAGE = `${pathToFileURL(path.join(SITE, "playground.html")).href}?embedded`;
const LANDING = pathToFileURL(path.join(SITE, "index.html")).href;
/** In s of the plant's time. */
const RUNS = 0.2;
/** Query of the page: the plant's time, or nothing. */
const TIME = 'return Number(document.querySelector("[data-status]")?.dataset.time ?? NaN)';

/** Asks until a plant has moved. */
async function moves(ask) {
  for (let wait = 0; wait < 120; wait += 1) {
    if ((await ask()) > RUNS) return;
    await sleep(500);
  }
  assert.fail("the plant does not move");
}

test("the plant runs on the landing page in Firefox", { skip: FIREFOX ? false : "Firefox is not installed" }, async () => {
  const browser = await puppeteer.launch({ browser: "firefox", executablePath: FIREFOX, headless: true });
  try {
    const page = await browser.newPage();
    const problems = [];
    page.on("console", (message) => message.type() === "error" && problems.push(message.text()));
    page.on("pageerror", (error) => problems.push(String(error)));
    await page.goto(LANDING);
    const frame = await (await page.waitForSelector("#plant")).contentFrame();
    await moves(() => frame.evaluate(new Function(TIME)));
    assert.deepEqual(problems, []);
  } finally {
    await browser.close();
  }
});

const lacking = [...WEBKIT.filter((file) => !existsSync(file)), ...(MINI_BROWSER ? [] : ["MiniBrowser"])];
test("the plant runs in WebKit with the locale C.UTF-8", { skip: lacking.length ? `not installed: ${lacking}` : false }, async () => {
  const started = [];
  const start = (program, words, environment = {}) => {
    const child = spawn(program, words, { env: { ...process.env, ...environment }, stdio: ["ignore", "pipe", "ignore"] });
    started.push(child);
    return child;
  };
  try {
    // The X server chooses a free display and writes its number.
    const server = spawn("/usr/bin/Xvfb", ["-displayfd", "1", "-screen", "0", "1280x1024x24"], { stdio: ["ignore", "pipe", "ignore"] });
    started.push(server);
    const [display] = await once(server.stdout, "data");
    const port = 4400 + (process.pid % 1000);
    const environment = { DISPLAY: `:${String(display).trim()}`, LC_ALL: "C.UTF-8", WEBKIT_DISABLE_SANDBOX_THIS_IS_DANGEROUS: "1" };
    start(WEBKIT[0], [`--port=${port}`], environment);
    const ask = async (method, address, body) => {
      const answer = await fetch(`http://127.0.0.1:${port}${address}`, { method, body: body && JSON.stringify(body) });
      const { value } = await answer.json();
      assert.ok(answer.ok, JSON.stringify(value));
      return value;
    };
    for (let wait = 0; wait < 40 && !(await fetch(`http://127.0.0.1:${port}/status`).catch(() => null)); wait += 1) await sleep(250);
    const options = { binary: MINI_BROWSER, args: ["--automation"] };
    const { sessionId } = await ask("POST", "/session", { capabilities: { alwaysMatch: { "webkitgtk:browserOptions": options } } });
    await ask("POST", `/session/${sessionId}/url`, { url: PAGE });
    await moves(() => ask("POST", `/session/${sessionId}/execute/sync`, { script: TIME, args: [] }));
    await ask("DELETE", `/session/${sessionId}`);
  } finally {
    for (const child of started.reverse()) child.kill();
  }
});
