// What a site costs in the browser: node tools/page-speed.mjs ADDRESS [WORKERS ...], with `heliotile view SITE.helio --weather FILE` at that
// address, of a site with a place. Prints, for each number of workers or for as many as the page takes by itself, seconds to the first picture and to
// all receivers; of the first sun to the receivers in view of a street and to all; of two more suns, and of a year's sums; then bytes, requests, memory.
import { chromium } from "../src/viewer/node_modules/playwright-core/index.mjs";

const [address, ...numbers] = process.argv.slice(2);
const HOURS = [600, 660, 900];
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--disable-background-networking", "--disable-component-update", "--no-first-run"],
});

/** Notes when the values of each tile of a moment arrive. */
function listen() {
  const { engine } = window.heliotile;
  const moment = engine.moment.bind(engine);
  engine.moment = (ask, onTile, onDamage) => {
    window.arrived = new Map();
    return moment(ask, (tile) => (window.arrived.set(tile.tile, performance.now()), onTile(tile)), onDamage);
  };
}

/** When the last tile of those arrived that have a receiver in the window, and how many these are; `camera`: x, y, z from there to there. */
async function seen([camera, aspect]) {
  const [from, to] = [camera.slice(0, 3), camera.slice(3)];
  const dot = (a, b) => a.reduce((sum, x, axis) => sum + x * b[axis], 0);
  const unit = (a) => a.map((x) => x / Math.hypot(...a));
  const ahead = unit(to.map((x, axis) => x - from[axis]));
  const right = unit([ahead[1], -ahead[0], 0]);
  const up = [right[1] * ahead[2], -right[0] * ahead[2], right[0] * ahead[1] - right[1] * ahead[0]];
  const tall = Math.tan((20 * Math.PI) / 180);
  const [arrived, found] = [new Map(window.arrived), { last: 0, tiles: 0 }];
  for (const [tile, at] of arrived) {
    const { middle } = await window.heliotile.engine.overview(tile);
    const isSeen = (row) => {
      const away = from.map((x, axis) => middle[3 * row + axis] - x);
      const depth = dot(away, ahead);
      return depth > 0 && Math.abs(dot(away, up)) < depth * tall && Math.abs(dot(away, right)) < depth * tall * aspect;
    };
    if (!Array.from({ length: middle.length / 3 }, (_, row) => row).some(isSeen)) continue;
    [found.last, found.tiles] = [Math.max(found.last, at), found.tiles + 1];
  }
  return found;
}

async function measure(workers) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  page.on("pageerror", (error) => console.log("error", error.message));
  const report = (what, ms) => console.log(`${what}: ${(ms / 1000).toFixed(2)} s`);
  const ready = () => page.evaluate(() => window.heliotile.ready);
  console.log(workers === undefined ? "as the page is" : `workers: ${workers}`);
  let began = Date.now();
  const url = new URL(address);
  if (workers !== undefined) url.searchParams.set("workers", workers);
  url.hash = "show=reference";
  await page.goto(url.href);
  await page.waitForFunction(() => window.heliotile && !document.getElementById("legend").hidden, null, { timeout: 120_000 });
  report("first picture", Date.now() - began);
  await ready();
  report("all receivers", Date.now() - began);
  // From 60 m above the middle over the houses before it, to the north.
  const camera = [0, -100, 90, 0, 0, 0];
  await page.evaluate(listen);
  for (const [number, minutes] of HOURS.entries()) {
    const asked = await page.evaluate((hash) => ((location.hash = hash), performance.now()), `show=moment&light=clear&dayOfYear=172&minutes=${minutes}&camera=${camera}`);
    await page.waitForTimeout(20);
    await ready();
    const all = (await page.evaluate(() => performance.now())) - asked;
    if (number === 0) {
      const aspect = await page.$eval("#view", (canvas) => canvas.clientWidth / canvas.clientHeight);
      const { last, tiles } = await page.evaluate(seen, [camera, aspect]);
      if (tiles > 0) report(`first sun, ${tiles} tiles in view`, last - asked);
    }
    report(number === 0 ? "first sun, all" : `sun at ${minutes / 60} h`, all);
  }
  began = Date.now();
  await page.evaluate(() => (location.hash = "show=year"));
  await page.waitForTimeout(20);
  await ready();
  report("sums of a year", Date.now() - began);
  console.log(JSON.stringify(await page.evaluate(() => window.heliotile.engine.traffic())));
  await page.close();
}

for (const workers of numbers.length > 0 ? numbers : [undefined]) await measure(workers);
await browser.close();
