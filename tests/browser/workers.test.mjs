// Several workers give what one gives, begin with what is in view, and go on without one that is lost.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, test } from "node:test";
import { close, DENSE, EPW, go, inlined, open, PAGE } from "./harness.mjs";
import { closeServers, serve } from "./server.mjs";

const MOMENT = "#show=moment&light=own&sun=angles&azimuth=200&altitude=30&dni=650&dhi=80";
const RECEIVERS = 2035;
after(async () => {
  await close();
  closeServers();
});

/** Of all receivers: a moment as stored and with another reflectance, a moment of the weather, sums of a month, hours of sun, words for the card. */
function everything(page) {
  return page.evaluate(async (receivers) => {
    const { engine } = window.heliotile;
    const tiles = Array.from({ length: Math.ceil(receivers / 64) }, (_, tile) => tile);
    const nothing = { reflectance: [], transmittance: [] };
    const light = { kind: "sun", azimuth: 200, altitude: 30, dni: 650, dhi: 80 };
    const common = { sky: "perez", components: ["sun_direct", "total"], tiles };
    const found = {};
    const fail = (tile, message) => {
      throw new Error(message);
    };
    const gather = async (name, ask) => {
      const values = (found[name] = Array(receivers).fill(null));
      const isDone = await ask(({ first, values: columns }) => columns[0].forEach((_, row) => (values[first + row] = columns.map((column) => column[row]))));
      if (!isDone) throw new Error(`${name} was given up`);
    };
    await gather("moment", (onTile) => engine.moment({ light, changes: nothing, ...common }, onTile, fail));
    await gather("changed", (onTile) => engine.moment({ light, changes: { reflectance: [["WallSurface", 0.7]], transmittance: [] }, ...common }, onTile, fail));
    await gather("weather", (onTile) => engine.moment({ light: { kind: "weather", hour: 4094 }, changes: nothing, ...common }, onTile, fail));
    await gather("sums", (onTile) => engine.sums({ span: { kind: "month", month: 4 }, changes: nothing, ...common }, onTile, fail));
    await gather("minutes", (onTile) => engine.sunMinutes({ dayOfYear: 80, inMirrors: false, tiles }, onTile, fail));
    found.words = Array(tiles.length).fill(0);
    await engine.textures({ changes: nothing, tiles }, ({ tile, words }) => (found.words[tile] = words.reduce((sum, word) => (Math.imul(sum, 31) + word) | 0, 0)), fail);
    return found;
  }, RECEIVERS);
}

test("Moments, also by weather and with another reflectance, sums, hours of sun and textures of 2,035 receivers are the same by 1 and by 3 workers.", async () => {
  const found = [];
  for (const workers of [1, 3]) {
    const page = await open();
    await go(page, `${inlined("workers", DENSE, EPW)}?workers=${workers}${MOMENT}`);
    found.push(await everything(page));
    assert.equal(page.workers().length, workers);
    assert.deepEqual(page.complaints, []);
    await page.close();
  }
  const [one, three] = found;
  assert.deepEqual(Object.keys(one), Object.keys(three));
  for (const name of Object.keys(one)) assert.deepEqual(three[name], one[name], name);
  assert.ok(one.moment.every((values) => values?.[1] > 0) && one.sums.every((values) => values?.[1] > 0) && one.words.every((sum) => sum !== 0));
});

test("Workers are started for many tiles only, and not where a server sends whole files alone.", async () => {
  const page = await open();
  await go(page, `${inlined("workers", DENSE)}${MOMENT}`);
  assert.equal(page.workers().length, 1);
  const server = await serve({ "/page.html": Buffer.from(PAGE), "/site.helio": readFileSync(DENSE) }, { ranges: false });
  await go(page, `${server.address}/page.html?url=site.helio&workers=3${MOMENT}`);
  assert.equal(page.workers().length, 1);
  assert.equal(server.asked.filter(({ path }) => path === "/site.helio").length, 1);
  assert.deepEqual(page.complaints, []);
});

test("Tiles in view come first, and those that a camera brings into view come next.", async () => {
  const page = await open();
  await go(page, `${inlined("workers", DENSE)}?workers=1#show=sky`);
  const middles = await page.evaluate(async (receivers) => {
    const { engine } = window.heliotile;
    const all = [];
    for (let tile = 0; tile < Math.ceil(receivers / 64); tile++) {
      const { middle } = await engine.overview(tile);
      all.push([0, 1, 2].map((axis) => middle.reduce((sum, metres, at) => sum + (at % 3 === axis ? metres / (middle.length / 3) : 0), 0)));
    }
    return all;
  }, RECEIVERS);
  // Two tiles far apart, each looked at from 12 m above it.
  const far = [...middles.keys()].sort((a, b) => middles[a][0] - middles[b][0]);
  const above = ([x, y, z]) => [x, y - 1, z + 12, x, y, z].map((metres) => metres.toFixed(2)).join();
  const [west, east] = [far[0], far.at(-1)];
  await page.evaluate(() => {
    const { engine } = window.heliotile;
    const [moment, prefer] = [engine.moment.bind(engine), engine.prefer.bind(engine)];
    window.noted = { asked: [], preferred: [] };
    engine.moment = (ask, ...rest) => (window.noted.asked.push(ask.tiles), moment(ask, ...rest));
    engine.prefer = (tiles) => (window.noted.preferred.push(tiles), prefer(tiles));
  });
  // Another reflectance takes seconds: the camera moves meanwhile.
  const hash = (tile) => `#${new URLSearchParams([...new URLSearchParams(MOMENT.slice(1)), ["reflectance", "GroundSurface=0.34"], ["camera", above(middles[tile])]])}`;
  await page.evaluate((hash) => (location.hash = hash), hash(west));
  await page.waitForFunction(() => window.noted.asked.length > 0);
  await page.evaluate((hash) => (location.hash = hash), hash(east));
  await page.waitForFunction(([east, west]) => window.noted.preferred.some((tiles) => tiles.indexOf(east) < tiles.indexOf(west)), [east, west]);
  const { asked } = await page.evaluate(() => window.noted);
  const place = (tiles, tile) => tiles.indexOf(tile);
  assert.equal(asked[0].length, middles.length);
  assert.ok(place(asked[0], west) < place(asked[0], east), asked[0].join());

  // The order that is preferred later is that of the answers, but for what was under way.
  const came = await page.evaluate(async (count) => {
    const { engine } = window.heliotile;
    const forth = Array.from({ length: count }, (_, tile) => tile);
    const order = [];
    const asking = engine.moment({ light: { kind: "sun", azimuth: 10, altitude: 5, dni: 1, dhi: 1 }, sky: "perez", changes: { reflectance: [["GroundSurface", 0.33]], transmittance: [] }, components: ["total"], tiles: forth }, ({ tile }) => order.push(tile), () => undefined);
    engine.prefer([...forth].reverse());
    await asking;
    return order;
  }, middles.length);
  assert.equal(new Set(came).size, middles.length);
  const late = came.slice(24);
  assert.deepEqual(late, [...late].sort((a, b) => b - a), came.join());
});

/** Lets the worker of a number be lost when its first tile is on its way to the page; others by `lose`. */
function losing(page, number) {
  return page.addInitScript((number) => {
    window.started = [];
    window.Worker = class extends Worker {
      constructor(...args) {
        super(...args);
        window.started.push(this);
        if (window.started.length !== number) return;
        this.addEventListener("message", (event) => {
          if (!("tile" in event.data)) return;
          event.stopImmediatePropagation();
          this.lose();
        });
      }

      lose() {
        this.terminate();
        this.dispatchEvent(new ErrorEvent("error", { message: "it was taken away" }));
      }
    };
  }, number);
}

test("Workers that are lost beside the first are said, one while tiles are asked for, one before; the others make the tiles.", async () => {
  const address = (workers) => `${inlined("workers", DENSE, EPW)}?workers=${workers}${MOMENT}`;
  const whole = await open();
  await go(whole, address(1));
  const { moment: expected } = await everything(whole);
  const page = await open();
  await losing(page, 0);
  await go(page, address(3));
  await page.waitForFunction(() => window.started.length === 3);
  for (const left of [2, 1]) {
    const asked = everything(page);
    await page.evaluate((left) => window.started[left].lose(), left);
    assert.match(await page.textContent(".message.bad"), /several workers.*it was taken away/i);
    assert.deepEqual((await asked).moment, expected);
    assert.equal(page.workers().length, left);
    await page.click(".message.bad button");
  }
  assert.deepEqual((await everything(page)).moment, expected);
  assert.deepEqual(page.complaints, []);
});

test("If the first worker is lost the page says so, and nothing waits for it.", async () => {
  const page = await open();
  await losing(page, 1);
  await go(page, `${inlined("workers", DENSE, EPW)}?workers=3${MOMENT}`);
  assert.match(await page.textContent(".message.bad"), /the engine stopped: it was taken away/i);
});
