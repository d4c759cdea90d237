// What the tests share: the browser, pages with an archive inside, the program's answers.
import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";

const top = new URL("../../", import.meta.url);
const { chromium } = createRequire(new URL("src/viewer/package.json", top))("playwright-core");

export const path = (relative) => new URL(relative, top).pathname;
export const out = path("target/browser/");
export const PAGE = readFileSync(path("src/results/page/page.html"), "utf8");
export const HAGUE = path("target/browser/hague.sun/site.helio");
/** With 2,035 receivers. */
export const DENSE = path("target/browser/dense.sun/site.helio");
/** The block after a house became a tower (variant.mjs). */
export const AFTER = path("target/browser/after.sun/site.helio");
export const EPW = path("tests/data/weather/golden_tmy3.epw");
mkdirSync(out, { recursive: true });

const FLAGS = ["--no-sandbox", "--disable-background-networking", "--disable-component-update", "--no-first-run"];
let browser = null;

export async function open({ width = 1280, height = 800 } = {}) {
  browser ??= await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: FLAGS });
  const context = await browser.newContext({ viewport: { width, height }, acceptDownloads: true });
  const page = await context.newPage();
  page.complaints = [];
  page.on("console", (message) => {
    const text = message.text();
    // Software rendering tells of its slowness; a 404 is told by the page too.
    if (["error", "warning"].includes(message.type()) && !/GPU stall|GL Driver|Failed to load resource/.test(text)) page.complaints.push(text);
  });
  page.on("pageerror", (error) => page.complaints.push(String(error)));
  page.setDefaultTimeout(60_000);
  return page;
}

export async function close() {
  await browser?.close();
  browser = null;
}

function block(id, file, name) {
  return `<script type="application/octet-stream" id="${id}" data-name="${name}">${readFileSync(file).toString("base64")}</script>`;
}

/** A page with an archive, and weather, and the archive after, inside; its address. */
export function inlined(name, archive, weather = null, after = null) {
  const data = block("archive", archive, "site.helio") + (weather ? block("weather", weather, "golden_tmy3.epw") : "");
  writeFileSync(`${out}${name}.html`, PAGE.replace("<!-- heliotile: data -->", data).replace("<!-- heliotile: later -->", after ? block("after", after, "after.helio") : ""));
  return pathToFileURL(`${out}${name}.html`).href;
}

export const ready = (page) => page.evaluate(() => window.heliotile.ready);

export async function go(page, address) {
  await page.goto(address);
  await ready(page);
}

/** Sets the part of the address behind `#`, and waits for the page to follow. */
export async function wish(page, parameters) {
  const hash = `#${new URLSearchParams(parameters)}`;
  await page.evaluate(
    (hash) =>
      new Promise((resolve) => {
        addEventListener("hashchange", () => setTimeout(resolve), { once: true });
        location.hash = hash;
      }),
    hash,
  );
  await ready(page);
}

/** Numbers in the table of the chosen receiver: by component. */
export function valuesOnPage(page) {
  return page.$$eval("#receiver-values tbody tr", (rows) =>
    Object.fromEntries(rows.map((row) => [row.dataset.component, Number(row.querySelector("[data-value]")?.dataset.value ?? NaN)])),
  );
}

export function heliotile(...args) {
  return execFileSync(process.env.HELIOTILE, args, { encoding: "utf8", stdio: ["ignore", "pipe", "pipe"], maxBuffer: 1 << 30 });
}

/** Rows of a CSV without quotes in what is compared; lines with # on top are left out. */
export function parseCsv(text) {
  const [head, ...lines] = text.split("\n").filter((line) => line !== "" && !line.startsWith("#"));
  const names = head.split(",");
  return lines.map((line) => Object.fromEntries(line.split(",").map((cell, at) => [names[at], cell])));
}

/** Saves the page's CSV and reads it. */
export async function savedCsv(page) {
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("#save-csv")]);
  return readFileSync(await download.path(), "utf8");
}

/** Numbers that repeat: mulberry32. */
export function random(seed) {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
  };
}
