// Clouds of a picture before the sky, and what the program says behind the same ones.
import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { after, test } from "node:test";
import { AFTER, close, EPW, go, HAGUE, heliotile, inlined, open, out, parseCsv, ready, savedCsv, wish } from "./harness.mjs";
import { png } from "./png.mjs";

const COMPONENTS = ["sun_direct", "sky_direct", "sun_reflected", "sky_reflected", "sun_mirrored", "sky_mirrored", "total"];
/** Of the largest value: both round to six or seven figures, and half a sky without the sun is packed as coarsely as a whole one with it. */
const WITHIN = 2e-4;
const SUN = { azimuth: 200, altitude: 40, dni: 700, dhi: 90 };
const OWN = [["show", "moment"], ["light", "own"], ["sun", "angles"], ...Object.entries(SUN).map(([name, value]) => [name, String(value)])];
const HASH = `#${new URLSearchParams(OWN)}`;
const SIDE = 512;
/** Hides the south where its top is the north, with a soft edge. */
const MASK = png(SIDE, SIDE, (column, row) => [Math.round(255 * Math.min(1, Math.max(0, (SIDE / 2 - row) / 40 + 0.5)))]);
after(close);

/** Gives the page a picture, and waits for it to follow. */
async function openClouds(page, name, buffer) {
  await page.setInputFiles("#file-clouds", { name, mimeType: "image/png", buffer });
  await ready(page);
}

/** Moves the slider, as a hand does. */
async function turn(page, top) {
  await page.$eval("#clouds-top", (slider, value) => {
    slider.value = value;
    slider.dispatchEvent(new Event("input", { bubbles: true }));
  }, String(top));
  await ready(page);
}

function queried(archive, picture, top, sun = SUN) {
  writeFileSync(`${out}clouds.png`, picture);
  writeFileSync(`${out}conditions.csv`, `condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\nc,${sun.azimuth},${sun.altitude},${sun.dni},${sun.dhi}\n`);
  return parseCsv(heliotile("replay", archive, "--conditions", `${out}conditions.csv`, "--clouds", `${out}clouds.png`, "--image-top", String(top), "-o", "-"));
}

/** The largest difference of receivers on the page from the program's, as a share of the largest value of these. */
function apart(page, program, prefix = "", suffix = "") {
  const byId = new Map(program.map((row) => [row.receiver, row]));
  const most = Math.max(...program.map((row) => Number(row[`total${suffix}`])));
  let difference = 0;
  for (const row of page) {
    for (const name of COMPONENTS) {
      const [a, b] = [Number(row[prefix + name + suffix]), Number(byId.get(row.receiver)[name + suffix])];
      assert.ok(Number.isFinite(a) && Number.isFinite(b), `${row.receiver} ${name}: ${a}, ${b}`);
      difference = Math.max(difference, Math.abs(a - b));
    }
  }
  return { most, share: difference / most };
}

test("Behind a mask that hides the sun's half of the sky, and turned by 180 degrees, all receivers have the values of `replay`; without it those of before.", async (t) => {
  const page = await open();
  const address = inlined("clouds", HAGUE);
  await go(page, `${address}${HASH}`);
  const clear = await savedCsv(page);
  assert.ok(!(await page.isVisible("#row-turn")) && !(await page.isVisible("#remove-clouds")));
  await openClouds(page, "south.png", MASK);
  const direct = [];
  for (const top of [0, 180, 93]) {
    await turn(page, top);
    const text = await savedCsv(page);
    assert.match(text, new RegExp(`# clouds: south.png\n# image_top_deg: ${top}\n`));
    const rows = parseCsv(text);
    const { most, share } = apart(rows, queried(HAGUE, MASK, top));
    assert.equal(rows.length, 1228);
    assert.ok(most > 10 && share < WITHIN, `${top}: ${share} of ${most}`);
    direct.push(Math.max(...rows.map((row) => Number(row.sun_direct))));
    t.diagnostic(`top ${top}: ${share.toExponential(1)} of the largest value, sun ${direct.at(-1)} W/m2`);
  }
  assert.ok(direct[0] === 0 && direct[1] > 600, direct.join());
  assert.equal(await page.textContent("#clouds-top-text"), "93°");
  // The address has the turn, and brings no clouds where there is no picture.
  await page.waitForFunction(() => location.hash.includes("clouds=93"));
  const other = await open();
  await go(other, `${address}${await page.evaluate(() => location.hash)}`);
  assert.equal(await savedCsv(other), clear);
  assert.ok(await other.isVisible("#clouds-note"));
  await openClouds(other, "south.png", MASK);
  assert.equal(await savedCsv(other), await savedCsv(page));
  await page.click("#remove-clouds");
  await ready(page);
  assert.equal(await savedCsv(page), clear);
  assert.ok(!(await page.isVisible("#row-turn")));
  await page.waitForFunction(() => !location.hash.includes("clouds="));
  assert.deepEqual([...page.complaints, ...other.complaints], []);
});

test("Five kinds of PNG, also with opacity and an exponent, have the levels that `--clouds` reads.", async (t) => {
  const page = await open();
  await go(page, `${inlined("clouds-kinds", HAGUE)}${HASH}`);
  const grey = (column, row) => (37 * column + 101 * row) % 256;
  const kinds = {
    grey: png(48, 48, (column, row) => [grey(column, row)]),
    gamma: png(48, 48, (column, row) => [grey(column, row)], 1),
    veiled: png(48, 48, (column, row) => [grey(column, row), (column * 5) % 256]),
    colours: png(48, 48, (column, row) => [grey(column, row), (row * 5) % 256, (column * 5) % 256], 0.3),
    "veiled colours": png(48, 48, (column, row) => [grey(column, row), (row * 5) % 256, 90, (column % 3) * 80]),
  };
  for (const [name, picture] of Object.entries(kinds)) {
    await openClouds(page, `${name}.png`, picture);
    const { most, share } = apart(parseCsv(await savedCsv(page)), queried(HAGUE, picture, 0));
    t.diagnostic(`${name}: ${share.toExponential(1)}`);
    assert.ok(most > 10 && share < WITHIN, `${name}: ${share} of ${most}`);
  }
  assert.deepEqual(page.complaints, []);
});

test("A picture that is not square and a file that is none are refused with words; so is Perez 1990 behind clouds.", async () => {
  const page = await open();
  await go(page, `${inlined("clouds-refused", HAGUE)}${HASH}`);
  const told = () => page.$$eval(".message.bad", (all) => all.map((one) => one.textContent));
  await openClouds(page, "wide.png", png(30, 20, () => [9]));
  assert.match((await told()).join(), /Reading wide\.png: the picture of 30 x 20 pixels is not square.*Crop it to the square/);
  await openClouds(page, "broken.png", Buffer.from("no picture"));
  assert.match((await told()).join(), /Reading broken\.png: this browser cannot read the file as a picture/);
  assert.ok(!(await page.isVisible("#row-turn")));
  await openClouds(page, "south.png", MASK);
  assert.ok(await page.$eval('#sky-model option[value="perez1990"]', (option) => option.disabled));
  await wish(page, [...OWN, ["sky", "perez1990"], ["clouds", "0"]]);
  assert.match((await told()).join(), /perez1990.*choose another sky/);
  assert.ok(parseCsv(await savedCsv(page)).every(({ total }) => total === ""));
  await wish(page, [...OWN, ["sky", "cie:12"], ["clouds", "0"]]);
  assert.ok(parseCsv(await savedCsv(page)).every(({ total }) => Number(total) >= 0 && total !== ""));
  assert.deepEqual(page.complaints, []);
});

test("A picture that is dropped on two archives hides both, and their sums of a year too.", async (t) => {
  const page = await open();
  await go(page, `${inlined("clouds-two", HAGUE, EPW, AFTER)}${HASH}&variant=change`);
  await page.evaluate((bytes) => {
    const transfer = new DataTransfer();
    transfer.items.add(new File([Uint8Array.from(bytes)], "south.png", { type: "image/png" }));
    dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, cancelable: true }));
  }, [...MASK]);
  await page.waitForSelector("#row-turn:not([hidden])");
  await turn(page, 30);
  // Who is only in the archive before has its own name in the row.
  const alone = (row, suffix) => row[`after_total${suffix}`] === "";
  const compared = async (suffix, programs) => {
    const rows = parseCsv(await savedCsv(page));
    const [after, before] = [rows.filter((row) => !alone(row, suffix)), rows.filter((row) => alone(row, suffix))];
    assert.ok(after.length > 1000 && before.length > 0);
    for (const [some, prefix, program] of [[before, "before_", programs[0]], [after, "after_", programs[1]]]) {
      const { most, share } = apart(some, program, prefix, suffix);
      t.diagnostic(`${prefix}total${suffix}: ${some.length} receivers within ${share.toExponential(1)} of ${most}`);
      assert.ok(share < WITHIN, `${prefix} ${share}`);
    }
  };
  await compared("", [HAGUE, AFTER].map((archive) => queried(archive, MASK, 30)));
  await wish(page, [["show", "year"], ["clouds", "30"]]);
  const options = ["--weather", EPW, "--every", "year", "--clouds", `${out}clouds.png`, "--image-top", "30", "-o", "-"];
  await compared("_kwh_m2", [HAGUE, AFTER].map((archive) => parseCsv(heliotile("replay", archive, ...options))));
  assert.deepEqual(page.complaints, []);
});

test("Behind clouds a day is played and the sun is dragged as before them, and opening them shows the moment.", async () => {
  const page = await open();
  await go(page, `${inlined("clouds-play", HAGUE, EPW)}#show=sky&light=clear&dayOfYear=172&minutes=600`);
  await openClouds(page, "south.png", MASK);
  assert.equal(await page.evaluate(() => window.heliotile.state.show), "moment");
  await page.click("#play");
  await page.waitForFunction(() => window.heliotile.state.minutes >= 640);
  await page.click("#play");
  const box = await page.locator("#dial").boundingBox();
  await page.mouse.click(box.x + box.width / 2, box.y + 0.3 * box.height);
  await ready(page);
  const { azimuth, altitude, dni, dhi } = await page.evaluate(() => window.heliotile.state);
  const { most, share } = apart(parseCsv(await savedCsv(page)), queried(HAGUE, MASK, 0, { azimuth, altitude, dni, dhi }));
  assert.ok((azimuth < 5 || azimuth > 355) && altitude > 30 && most > 500 && share < WITHIN, `${azimuth} ${altitude}: ${share} of ${most}`);
  assert.deepEqual(page.complaints, []);
});

test("While the slider is dragged the view follows, with and without the card, whose colours are the core's; the dial and what a receiver sees turn along.", async (t) => {
  const big = png(1024, 1024, (column, row) => [Math.round(127 + 127 * Math.sin(column / 40) * Math.cos(row / 55))]);
  for (const mb of [0, 256]) {
    const page = await open();
    await go(page, `${inlined("clouds-drag", HAGUE)}?card=${mb}${HASH}&receiver=3.7`);
    if (mb > 0) await page.waitForFunction(() => window.heliotile.card.complete);
    await page.waitForSelector("#receiver figure canvas");
    await openClouds(page, "waves.png", big);
    const sight = () => page.$eval("#receiver .fishes canvas", (canvas) => canvas.toDataURL());
    const before = await sight();
    const seen = await page.evaluate(async () => {
      const { engine } = window.heliotile;
      const [frames, done] = [[], []];
      const asks = engine.moment.bind(engine);
      engine.moment = (...ask) => asks(...ask).then((whole) => (done.push(whole), whole));
      const slider = document.getElementById("clouds-top");
      let last = performance.now();
      const began = last;
      for (let frame = 0; frame < 40; frame++) {
        slider.value = String(3 * frame);
        slider.dispatchEvent(new Event("input", { bubbles: true }));
        await new Promise(requestAnimationFrame);
        frames.push(performance.now() - last);
        last = performance.now();
      }
      const drag = last - began;
      const whole = done.filter((one) => one).length;
      await window.heliotile.ready;
      delete engine.moment;
      return { frames: frames.sort((a, b) => a - b), drag, whole, rest: performance.now() - last };
    });
    t.diagnostic(`card of ${mb} MB: 40 steps in ${seen.drag.toFixed(0)} ms, median ${seen.frames[20].toFixed(0)}, longest ${seen.frames[39].toFixed(0)}; ${seen.whole} whole moments meanwhile, rest after ${seen.rest.toFixed(0)} ms`);
    assert.ok(seen.whole > 3 && seen.rest < 3000, JSON.stringify(seen));
    assert.notEqual(await sight(), before);
    assert.equal(await page.getAttribute("#dial image", "transform"), "rotate(117)");
    const found = await page.evaluate(async ({ sun, mb }) => {
      const { card, engine } = window.heliotile;
      const ask = { light: { kind: "sun", ...sun }, sky: "perez", changes: { reflectance: [], transmittance: [] }, components: ["total"] };
      if (mb === 0) return { most: 1, largest: 0 };
      card.draw(await engine.light({ ...ask, tiles: [] }), "total");
      const drawn = card.read();
      const found = { most: 0, largest: 0 };
      await engine.moment({ ...ask, tiles: Array.from({ length: 20 }, (_, tile) => tile) }, ({ first, values: [values] }) => values.forEach((value, row) => {
        found.most = Math.max(found.most, value);
        found.largest = Math.max(found.largest, Math.abs(value - drawn[first + row]));
      }), () => {});
      return found;
    }, { sun: SUN, mb });
    assert.ok(found.most > 0 && found.largest < 1e-3 * found.most, JSON.stringify(found));
    assert.deepEqual(page.complaints, []);
  }
});
