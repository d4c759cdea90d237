// Colours that the graphics card makes of textures are those of the core.
import assert from "node:assert/strict";
import { after, test } from "node:test";
import { close, DENSE, go, HAGUE, inlined, open, path, random, ready, valuesOnPage, wish } from "./harness.mjs";

const COMPONENTS = ["sun_direct", "sky_direct", "sun_reflected", "sky_reflected", "total"];
const OWN = [["show", "moment"], ["light", "own"], ["sun", "angles"]];
after(close);

/** All receivers are on the card, for the reflectances that are shown. */
const loaded = (page) => page.waitForFunction(() => window.heliotile.card.complete);

const parameters = (sun) => Object.entries(sun).map(([name, value]) => [name, String(value)]);

/** What the card drew last beside the core's values of the same moment: largest total, largest difference, how many are off by 1e-3 of the former. */
function differences(page, sun, sky, changes, component, count = 1228) {
  return page.evaluate(async ({ sun, sky, changes, component, count }) => {
    const { card, engine } = window.heliotile;
    const drawn = card.read();
    const tiles = Array.from({ length: Math.ceil(count / 64) }, (_, tile) => tile);
    const core = [];
    await engine.moment({ light: { kind: "sun", ...sun }, sky, changes, components: [component, "total"], tiles }, (tile) => core.push(tile), () => {});
    const found = { receivers: 0, most: 0, largest: 0, beyond: 0 };
    for (const { values: [, totals] } of core) for (const total of totals) found.most = Math.max(found.most, total);
    for (const { first, values: [values] } of core) {
      values.forEach((value, row) => {
        const off = Math.abs(drawn[first + row] - value);
        found.receivers += 1;
        found.largest = Math.max(found.largest, off);
        found.beyond += off > 1e-3 * found.most;
      });
    }
    return found;
  }, { sun, sky, changes, component, count });
}

test("Under 20 suns the card's values of 2,035 receivers, single components and totals, are the core's within 0.1 % of the largest total.", async (t) => {
  const page = await open();
  await go(page, `${inlined("card", DENSE)}?card=256#show=moment&light=own&sun=angles`);
  await loaded(page);
  const next = random(21);
  const skies = ["perez", "perez1990", "uniform", "cie:12"];
  let [worst, beyond, compared] = [0, 0, 0];
  for (let at = 0; at < 20; at++) {
    const sun = { azimuth: Math.floor(720 * next()) / 2, altitude: Math.floor(2 + 160 * next()) / 2, dni: at % 5 === 4 ? 0 : Math.floor(900 * next()), dhi: Math.floor(20 + 300 * next()) };
    const [sky, component] = [skies[at % 4], at % 2 ? "total" : COMPONENTS[(at / 2) % 5]];
    await wish(page, [...OWN, ["sky", sky], ["component", component], ...parameters(sun)]);
    const found = await differences(page, sun, sky, { reflectance: [], transmittance: [] }, component, 2035);
    assert.equal(found.receivers, 2035);
    [worst, beyond, compared] = [Math.max(worst, found.largest / found.most), beyond + found.beyond, compared + found.receivers];
    assert.ok(found.largest < 1e-3 * found.most, `${JSON.stringify(sun)} ${sky} ${component}: ${found.largest} of ${found.most}`);
  }
  t.diagnostic(`largest difference ${worst.toExponential(1)} of the largest total; ${beyond} of ${compared} beyond 1e-3`);
  assert.deepEqual(page.complaints, []);
});

test("Other reflectances come to the card anew; where software draws, the core serves.", async (t) => {
  const page = await open();
  const sun = { azimuth: 150, altitude: 35, dni: 700, dhi: 90 };
  await go(page, `${inlined("card", HAGUE)}?card=256#show=moment&light=own&sun=angles`);
  await loaded(page);
  await wish(page, [...OWN, ["reflectance", "TINRelief=0.8"], ["reflectance", "WallSurface=0.6"], ...parameters(sun)]);
  await loaded(page);
  const moved = { ...sun, altitude: 40 };
  await wish(page, [...OWN, ["reflectance", "TINRelief=0.8"], ["reflectance", "WallSurface=0.6"], ...parameters(moved)]);
  const changes = { reflectance: [["TINRelief", 0.8], ["WallSurface", 0.6]], transmittance: [] };
  const found = await differences(page, moved, "perez", changes, "total");
  t.diagnostic(`largest difference ${(found.largest / found.most).toExponential(1)}`);
  assert.ok(found.receivers === 1228 && found.largest < 1e-3 * found.most, JSON.stringify(found));

  // By itself no card is asked for where software draws.
  await go(page, `${inlined("card", HAGUE)}#show=moment&light=own&sun=angles`);
  assert.equal(await page.evaluate(() => window.heliotile.card), null);
  await ready(page);
  assert.deepEqual(page.complaints, []);
});

test("Where the card has room for a part, the core serves the rest, also while the sun is dragged.", async (t) => {
  const page = await open();
  await go(page, `${inlined("card", HAGUE)}?card=5#show=moment&light=own&sun=angles`);
  await loaded(page);
  const sun = { azimuth: 200, altitude: 30, dni: 650, dhi: 80 };
  const some = await page.evaluate(() => ({ receivers: window.heliotile.card.receivers, ...window.heliotile.card.bytes }));
  t.diagnostic(`${some.receivers} of 1228 receivers in ${some.taken} bytes`);
  assert.ok(some.receivers > 300 && some.receivers < 1000 && some.taken <= 5e6, JSON.stringify(some));
  await page.evaluate(() => {
    const { engine } = window.heliotile;
    const moment = engine.moment.bind(engine);
    window.asked = [];
    engine.moment = (ask, ...rest) => (window.asked.push(ask.tiles.length), moment(ask, ...rest));
  });
  await wish(page, [...OWN, ...parameters(sun)]);
  const asked = await page.evaluate(() => window.asked);
  assert.ok(asked[0] > 3 && asked[0] < 17 && asked.at(-1) === 20, asked.join());
  // Once more with the core's values of this light in place.
  await page.evaluate(async (sun) => {
    const { card, engine } = window.heliotile;
    card.draw(await engine.light({ light: { kind: "sun", ...sun }, sky: "perez", changes: { reflectance: [], transmittance: [] }, components: ["total"], tiles: [] }), "total");
  }, sun);
  const found = await differences(page, sun, "perez", { reflectance: [], transmittance: [] }, "total");
  assert.ok(found.receivers === 1228 && found.largest < 1e-3 * found.most, JSON.stringify(found));
  assert.deepEqual(page.complaints, []);
});

test("Tiles with mirrors or leaves before the sky stay with the core, and colours come all the same.", async () => {
  const page = await open();
  await go(page, `${inlined("mirrors", path("tests/data/archives/v1.7-box.helio"))}?card=256#show=moment&light=own&sun=angles`);
  await loaded(page);
  assert.equal(await page.evaluate(() => window.heliotile.card.receivers), 0);
  await wish(page, [...OWN, ["receiver", "0.0"], ...parameters({ azimuth: 170, altitude: 50, dni: 800, dhi: 100 })]);
  assert.ok((await valuesOnPage(page)).total > 0);
  assert.deepEqual(page.complaints, []);
});

test("While the sun is dragged no receiver is asked of the core but those in tables; once it rests, all are.", async (t) => {
  const page = await open();
  await go(page, `${inlined("card", HAGUE)}?card=256#show=moment&light=own&sun=angles&altitude=40&dni=700&dhi=90&receiver=3.7`);
  await loaded(page);
  const seen = await page.evaluate(async () => {
    const { card, engine } = window.heliotile;
    const asked = [];
    const moment = engine.moment.bind(engine);
    engine.moment = (ask, ...rest) => (asked.push(ask.tiles.length), moment(ask, ...rest));
    const slider = document.getElementById("azimuth");
    const [frames, drawn] = [[], new Set()];
    let last = performance.now();
    for (let frame = 0; frame < 40; frame++) {
      slider.value = String(100 + 2 * frame);
      slider.dispatchEvent(new Event("input", { bubbles: true }));
      await new Promise(requestAnimationFrame);
      frames.push(performance.now() - last);
      last = performance.now();
      if (card.shown) drawn.add(card.shown.light);
    }
    const dragging = [...asked];
    await window.heliotile.ready;
    delete engine.moment;
    return { dragging, after: asked.slice(dragging.length), frames: frames.sort((a, b) => a - b), drawn: drawn.size, bytes: card.bytes, receivers: card.receivers };
  });
  t.diagnostic(`${seen.drawn} lights in 40 frames, median ${seen.frames[20].toFixed(0)} ms, longest ${seen.frames[39].toFixed(0)}; ${Math.round(seen.bytes.used / seen.receivers)} bytes a receiver`);
  assert.ok(seen.drawn > 5);
  assert.ok(seen.dragging.every((tiles) => tiles <= 1), seen.dragging.join());
  assert.ok(seen.after.includes(20), seen.after.join());
});
