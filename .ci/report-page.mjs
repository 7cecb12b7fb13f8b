#!/usr/bin/env node
// Looks at report.html of a run in headless Chromium: no message on its console, no request to a
// network, pictures that are not empty, a player that moves them, no overflow on a narrow screen.
//
// Usage: node .ci/report-page.mjs REPORT.html [--out DIR] [--axe AXE.min.js]
// --out keeps screenshots. --axe also checks accessibility with a copy of axe-core, in light and
// dark colours. Without Chromium it says so and passes.
import { spawn, spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync, mkdirSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";

const [page, ...options] = process.argv.slice(2);
const option = (name) => (options.includes(name) ? options[options.indexOf(name) + 1] : undefined);
const [out, axe] = [option("--out"), option("--axe")];
if (!page) {
  console.error("usage: node .ci/report-page.mjs REPORT.html [--out DIR] [--axe AXE.min.js]");
  process.exit(2);
}
const browser = ["chromium", "chromium-browser", "google-chrome"]
  .find((name) => spawnSync(name, ["--version"]).status === 0);
if (!browser) {
  console.error("warning: skipped: there is no Chromium, so the page is not tested");
  process.exit(0);
}

const profile = mkdtempSync(join(tmpdir(), "report-page-"));
const child = spawn(browser, ["--headless=new", "--no-sandbox", "--remote-debugging-pipe",
  "--enable-unsafe-swiftshader", "--use-gl=angle", "--use-angle=swiftshader", "--hide-scrollbars",
  `--user-data-dir=${profile}`], { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
// A browser that stops answering must not stop the checks for ever.
const LONGEST = 300;
setTimeout(() => {
  console.error(`error: Chromium took more than ${LONGEST} s`);
  child.kill("SIGKILL");
  process.exit(1);
}, 1000 * LONGEST).unref();
let isOpen = true;
child.on("exit", () => {
  if (!isOpen) return;
  console.error("error: Chromium ended early");
  process.exit(1);
});
const problems = [];
const waiting = new Map();
let buffer = "", count = 0;

child.stdio[4].on("data", (chunk) => {
  const texts = (buffer + chunk).split("\0");
  buffer = texts.pop();
  for (const text of texts) {
    const message = JSON.parse(text);
    if (waiting.has(message.id)) {
      waiting.get(message.id)(message);
      waiting.delete(message.id);
    } else if (message.method === "Runtime.exceptionThrown") {
      const { text, exception } = message.params.exceptionDetails;
      problems.push(`exception: ${exception?.description ?? text}`);
    } else if (message.method === "Log.entryAdded" || message.method === "Runtime.consoleAPICalled") {
      const entry = message.params.entry?.text ?? JSON.stringify(message.params.args);
      // Reading back pixels, as screenshots do, is slow without a graphics card.
      if (!/GPU stall due to ReadPixels/.test(entry)) problems.push(`console: ${entry}`);
    } else if (message.method === "Network.requestWillBeSent") {
      const { url } = message.params.request;
      if (!/^(file|data|blob):/.test(url)) problems.push(`request: ${url}`);
    }
  }
});
const send = (method, params = {}, sessionId) => new Promise((done) => {
  count += 1;
  waiting.set(count, done);
  child.stdio[3].write(`${JSON.stringify({ id: count, method, params, sessionId })}\0`);
});

const { targetId } = (await send("Target.createTarget", { url: "about:blank" })).result;
const { sessionId } = (await send("Target.attachToTarget", { targetId, flatten: true })).result;
const tell = (method, params) => send(method, params, sessionId);
const value = async (expression) => {
  const { result } = await tell("Runtime.evaluate", { expression, awaitPromise: true, returnByValue: true });
  if (result.exceptionDetails) throw new Error(result.exceptionDetails.exception?.description);
  return result.result.value;
};
const pause = (seconds) => new Promise((done) => setTimeout(done, 1000 * seconds));
/** Waits until an expression holds, for a minute at most. */
const until = async (expression) => {
  for (let k = 0; k < 120 && !await value(expression); k++) await pause(0.5);
};
const require = (holds, what) => { if (!holds) problems.push(what); };
const size = (width, height) => tell("Emulation.setDeviceMetricsOverride",
  { width, height, deviceScaleFactor: 1, mobile: false });
const colours = (scheme) => tell("Emulation.setEmulatedMedia",
  { features: [{ name: "prefers-color-scheme", value: scheme }] });
const screenshot = async (name) => {
  if (!out) return;
  mkdirSync(out, { recursive: true });
  const { result } = await tell("Page.captureScreenshot", { captureBeyondViewport: true,
    clip: { x: 0, y: 0, scale: 1, ...(await value("({ width: innerWidth, height: document.documentElement.scrollHeight })")) } });
  writeFileSync(join(out, `${name}.png`), Buffer.from(result.data, "base64"));
};
/** Number of different colours of a canvas. */
const colourCount = (id) => value(`(() => {
  const copy = document.createElement("canvas");
  const source = document.getElementById("${id}");
  [copy.width, copy.height] = [source.width, source.height];
  const context = copy.getContext("2d");
  context.drawImage(source, 0, 0);
  const { data } = context.getImageData(0, 0, copy.width, copy.height);
  const seen = new Set();
  for (let k = 0; k < data.length; k += 4) seen.add((data[k] << 16) | (data[k + 1] << 8) | data[k + 2]);
  return seen.size;
})()`);
const violations = async (scheme) => {
  if (!axe) return;
  await value(readFileSync(axe, "utf8") + "; true");
  const found = await value("axe.run().then((r) => r.violations.map((v) => `${v.id}: ${v.nodes.map((n) => n.target).join(' ')}`))");
  for (const violation of found) problems.push(`axe, ${scheme}: ${violation}`);
  console.log(`axe, ${scheme}: ${found.length} violations`);
};

for (const domain of ["Page", "Runtime", "Log", "Network"]) await tell(`${domain}.enable`);
await size(1280, 900);
await tell("Page.navigate", { url: `file://${resolve(page)}` });
await until("document.readyState === 'complete' && document.querySelector('#plots svg') !== null");
await pause(1);
require(await colourCount("view3d") > 200, "the view in three dimensions is empty");
const hasFlow = await value("run.slices.length > 0");
require(!hasFlow || await colourCount("slice") > 200, "the picture of the flow is empty");
require(await value("document.querySelectorAll('#plots svg .curve').length") > 0, "there are no curves");
await screenshot("light");
await violations("light");
await value("document.querySelector('details').open = true");

// A view that follows a single body does not change.
await value("document.getElementById('follow').checked && document.getElementById('follow').click()");
const before = await value("document.getElementById('view3d').toDataURL()");
await value("document.getElementById('play').click()");
await until("player.time > 0.05 * run.duration");
require(await value("player.time") > 0, "the player does not move");
await value("player.play(false)");
require(await value("document.getElementById('view3d').toDataURL()") !== before, "the bodies do not move");
await value("player.set(0.4 * run.duration)");
await screenshot("played");
const turned = await value("document.getElementById('view3d').toDataURL()");
await value("document.getElementById('view3d').focus()");
await tell("Input.dispatchKeyEvent", { type: "keyDown", key: "ArrowLeft", code: "ArrowLeft" });
require(await value("document.getElementById('view3d').toDataURL()") !== turned, "arrow keys do not turn the view");

await colours("dark");
await pause(0.5);
await screenshot("dark");
await violations("dark");
await size(390, 800);
await pause(0.5);
require(await value("document.documentElement.scrollWidth <= innerWidth"), "the page is wider than a narrow screen");
await screenshot("narrow");

isOpen = false;
const closed = new Promise((done) => child.on("exit", done));
await send("Browser.close");
await closed;
rmSync(profile, { recursive: true, force: true });
problems.forEach((problem) => console.error(`error: ${problem}`));
console.log(problems.length === 0 ? "the page draws, plays and has no errors" : `${problems.length} problems`);
process.exit(problems.length === 0 ? 0 : 1);
