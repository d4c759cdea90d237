// The parts of an atlas: those that `view` serves, and those of a catalogue on a static server.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { existsSync, readdirSync, readFileSync, rmSync } from "node:fs";
import { after, before, test } from "node:test";
import { close, go, heliotile, open, out, path, ready } from "./harness.mjs";
import { closeServers, serve } from "./server.mjs";

const ATLAS = `${out}atlas`;
const BUILT = ["x1749_y10176", "x1750_y10176", "x1750_y10177"];
const programs = [];

before(() => {
  rmSync(ATLAS, { recursive: true, force: true });
  const cut = ["--crs", "EPSG:28992", "--spacing", "4m", "--quality", "draft", "--part-size", "45m", "--sample", "0", "-o", ATLAS];
  heliotile("--quiet", "atlas", "partition", path("tests/data/cityjson/hague.city.json"), ...cut);
  for (const part of BUILT) heliotile("--quiet", "build", ATLAS, "--part", part);
  heliotile("--quiet", "atlas", "catalogue", ATLAS);
});
after(async () => {
  // One that goes on would keep this file from ending.
  for (const program of programs) program.kill("SIGKILL");
  await close();
  closeServers();
});

/** Address that `view` prints. */
async function viewed(...args) {
  const program = spawn(process.env.HELIOTILE, ["view", ...args, "--port", "0"], { stdio: ["ignore", "pipe", "inherit"] });
  programs.push(program);
  for await (const chunk of program.stdout) {
    const address = /http:\/\/[^/]+/.exec(String(chunk))?.[0];
    if (address) return address;
  }
  throw new Error("view printed no address");
}

/** Opens another part by a click on its square. */
async function click(page, part) {
  const square = page.locator("#part-plan rect", { hasText: part });
  await square.click();
  await ready(page);
}

const state = (page) => page.evaluate(() => ({ ...window.heliotile.state }));

test("view of an atlas opens the first part that is built; a click opens another, and light, side and reflectances stay.", async () => {
  const address = await viewed(ATLAS);
  const page = await open();
  await go(page, `${address}/`);
  assert.equal(await page.textContent("#site-name"), BUILT[0]);
  assert.equal(await page.textContent("#part-note"), "3 of 4 built; one is open at a time");
  const receivers = await page.textContent("#site-line");
  await page.screenshot({ path: `${out}parts-1280.png` });
  await page.evaluate(() => (location.hash = "#part=x1749_y10176&show=moment&light=own&sun=angles&altitude=41&dni=700&receiver=0.0"));
  await page.waitForFunction(() => window.heliotile.state.altitude === 41);
  await ready(page);
  await page.focus("#view");
  for (let turn = 0; turn < 5; turn++) await page.keyboard.press("ArrowLeft");
  const side = async () => {
    const [x, y, , tx, ty] = (await state(page)).camera;
    return Math.atan2(y - ty, x - tx);
  };
  const before = await side();
  await click(page, BUILT[1]);
  const now = await state(page);
  assert.deepEqual([now.part, now.show, now.altitude, now.dni, now.selected], [BUILT[1], "moment", 41, 700, null]);
  assert.equal(await page.textContent("#site-name"), BUILT[1]);
  assert.notEqual(await page.textContent("#site-line"), receivers);
  assert.ok(Math.abs((await side()) - before) < 0.01, `${await side()} ${before}`);
  await page.selectOption("#part-list", BUILT[2]);
  await ready(page);
  assert.equal(await page.textContent("#site-name"), BUILT[2]);
  assert.equal(await page.locator("#part-plan rect[data-open]").count(), 1);
  // The part that is not built cannot be chosen.
  assert.ok(await page.$eval("#part-list option[value=x1749_y10177]", (option) => option.disabled));
  await page.locator("#part-plan rect.missing").click();
  assert.equal((await state(page)).part, BUILT[2]);
  assert.deepEqual(page.complaints, []);
});

test("Two parts asked for at once end with the second, without a complaint; the address gives the same again.", async () => {
  const address = await viewed(ATLAS, "--weather", path("tests/data/weather/golden_tmy3.epw"));
  const page = await open({ width: 390, height: 800 });
  await go(page, `${address}/`);
  assert.equal((await state(page)).show, "year");
  await page.click('#tabs [data-tab="site"]');
  await page.selectOption("#part-list", BUILT[1]);
  await page.selectOption("#part-list", BUILT[2]);
  await ready(page);
  await page.waitForFunction(() => document.querySelector("#site-name").textContent === "x1750_y10177");
  await ready(page);
  // Weather goes with it.
  assert.equal((await state(page)).show, "year");
  await page.screenshot({ path: `${out}parts-390.png` });
  // The weather is of another place, and that is told once.
  assert.deepEqual(await page.$$eval(".message", (messages) => messages.map((message) => message.dataset.kind)), ["weather"]);
  await page.waitForFunction(() => location.hash.includes("part=x1750_y10177"));
  const again = await open();
  await go(again, await page.evaluate(() => location.href));
  assert.equal(await again.textContent("#site-name"), BUILT[2]);
  assert.deepEqual([...page.complaints, ...again.complaints], []);
});

test("An item's link leads to its part on any server with ranges; a list that is none, or leads off the web, is told.", async () => {
  const files = {};
  const add = (name) => (files[`/${name}`] = readFileSync(`${ATLAS}/${name}`));
  ["view.html", "parts.json", "collection.json"].forEach(add);
  for (const part of readdirSync(`${ATLAS}/parts`)) if (existsSync(`${ATLAS}/parts/${part}/item.json`)) ["site.helio", "item.json"].forEach((name) => add(`parts/${part}/${name}`));
  const server = await serve(files, { ranges: true });
  const item = `${server.address}/parts/${BUILT[2]}/item.json`;
  const links = JSON.parse(files[`/parts/${BUILT[2]}/item.json`]).links;
  const page = await open();
  await go(page, new URL(links.find(({ rel }) => rel === "alternate").href, item).href);
  assert.equal(await page.textContent("#site-name"), BUILT[2]);
  assert.ok(server.asked.filter(({ path }) => path.endsWith(".helio")).every(({ range }) => range !== null));
  assert.deepEqual(page.complaints, []);
  const told = async (list) => {
    const other = await serve({ ...files, "/parts.json": Buffer.from(list) }, { ranges: true });
    await go(page, `${other.address}/view.html`);
    return page.textContent(".message.bad");
  };
  const part = { name: "<b>x</b>", state: "built", low: [0, 0], high: [1, 1] };
  for (const archive of ["javascript:alert(1)", "data:,x", "file:///etc/passwd", "blob:x"]) {
    assert.match(await told(JSON.stringify({ parts: [{ ...part, archive }] })), /not a list of the parts/);
  }
  assert.match(await told("{}"), /not a list of the parts/);
  assert.match(await told(JSON.stringify({ parts: [{ ...part, archive: "no.helio" }] })), /<b>x<\/b>.*is not there/);
});
