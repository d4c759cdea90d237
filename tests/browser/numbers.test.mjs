// Numbers on the page are those of the program.
import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { after, test } from "node:test";
import { close, EPW, go, HAGUE, heliotile, inlined, open, out, parseCsv, random, savedCsv, valuesOnPage, wish } from "./harness.mjs";

const COMPONENTS = ["sun_direct", "sky_direct", "sun_reflected", "sky_reflected", "sun_mirrored", "sky_mirrored", "total"];
/** Of the largest value: both round to six or seven figures. */
const WITHIN = 1e-4;
after(close);

/** The largest difference of two tables by receiver, as a share of the largest value. */
function apart(page, program, suffix = "") {
  const byId = new Map(program.map((row) => [row.receiver, row]));
  assert.equal(page.length, program.length);
  let [most, difference] = [0, 0];
  for (const row of page) {
    for (const name of COMPONENTS) {
      const [a, b] = [Number(row[name + suffix]), Number(byId.get(row.receiver)[name + suffix])];
      assert.ok(Number.isFinite(a) && Number.isFinite(b), `${row.receiver} ${name}: ${a}, ${b}`);
      most = Math.max(most, b);
      difference = Math.max(difference, Math.abs(a - b));
    }
  }
  return { most, share: difference / most };
}

test("Under 20 random suns, skies and reflectances, all receivers of the page's CSV have the values of `replay`.", async (t) => {
  const page = await open();
  await go(page, inlined("numbers", HAGUE));
  const next = random(7);
  const skies = ["perez", "perez1990", "uniform", "cie:1", "cie:12"];
  let worst = 0;
  for (let at = 0; at < 20; at++) {
    const sun = { azimuth: Math.floor(720 * next()) / 2, altitude: Math.floor(2 + 170 * next()) / 2, dni: Math.floor(900 * next()), dhi: Math.floor(20 + 300 * next()) };
    const sky = skies[at % skies.length];
    const [ground, obstruction] = [Math.floor(100 * next()) / 100, Math.floor(95 * next()) / 100];
    await wish(page, [
      ["show", "moment"], ["light", "own"], ["sun", "angles"], ["sky", sky], ["reflectance", `TINRelief=${ground}`], ["reflectance", `WallSurface=${obstruction}`],
      ...Object.entries(sun).map(([name, value]) => [name, String(value)]),
    ]);
    const text = await savedCsv(page);
    assert.match(text, new RegExp(`# sky: ${sky}`));
    writeFileSync(`${out}conditions.csv`, `condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\nc,${sun.azimuth},${sun.altitude},${sun.dni},${sun.dhi}\n`);
    const program = heliotile("replay", HAGUE, "--conditions", `${out}conditions.csv`, "--sky", sky, "--reflectance", `TINRelief=${ground}`, "--reflectance", `WallSurface=${obstruction}`, "-o", "-");
    const { most, share } = apart(parseCsv(text), parseCsv(program));
    assert.ok(most > 1, `${most} W/m2`);
    worst = Math.max(worst, share);
  }
  t.diagnostic(`largest difference: ${worst.toExponential(1)} of the largest value`);
  assert.ok(worst < WITHIN, `${worst}`);
  assert.deepEqual(page.complaints, []);
});

test("The table of a chosen receiver shows what `replay` says of it, and moves with the sun's sliders.", async () => {
  const page = await open();
  await go(page, `${inlined("table", HAGUE)}#show=moment&light=own&sun=angles&azimuth=200&altitude=40&dni=700&dhi=90&receiver=3.7`);
  const id = await page.textContent("#receiver h2");
  for (const altitude of [40, 25.5]) {
    await page.$eval("#altitude", (slider, value) => {
      slider.value = value;
      slider.dispatchEvent(new Event("input", { bubbles: true }));
    }, altitude);
    await page.evaluate(() => window.heliotile.ready);
    writeFileSync(`${out}conditions.csv`, `condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\nc,200,${altitude},700,90\n`);
    const program = parseCsv(heliotile("replay", HAGUE, "--conditions", `${out}conditions.csv`, "-o", "-")).find((row) => row.receiver === id);
    const shown = await valuesOnPage(page);
    for (const name of COMPONENTS) assert.ok(Math.abs(shown[name] - Number(program[name])) < 0.05, `${name} at ${altitude}: ${shown[name]}, ${program[name]}`);
    assert.ok(shown.total > 50);
  }
});

test("Sums of the year, the months of a receiver and sums of its building are those of `replay`.", async () => {
  const page = await open();
  await go(page, `${inlined("year", HAGUE, EPW)}#show=year&receiver=3.7`);
  const id = await page.textContent("#receiver h2");
  const year = apart(parseCsv(await savedCsv(page)), parseCsv(heliotile("replay", HAGUE, "--weather", EPW, "--every", "year", "-o", "-")), "_kwh_m2");
  assert.ok(year.most > 1000 && year.share < WITHIN, `${year.share} of ${year.most}`);

  const months = parseCsv(heliotile("replay", HAGUE, "--weather", EPW, "--every", "month", "-o", "-")).filter((row) => row.receiver === id);
  await page.waitForSelector("#receiver figure table", { state: "attached" });
  const shown = await page.$$eval("#receiver figure:first-of-type table", ([table]) =>
    [...table.querySelectorAll("tbody tr")].map((row) => [...row.querySelectorAll("td")].map((cell) => Number(cell.dataset.value))));
  assert.equal(shown.length, 12);
  months.forEach((row, month) => assert.ok(Math.abs(shown[month].at(-1) - Number(row.total_kwh_m2)) < 0.02, `month ${month + 1}: ${shown[month].at(-1)}, ${row.total_kwh_m2}`));

  await page.waitForFunction(() => document.querySelectorAll(".receiver-sums tr[data-kind]").length > 1 && !document.querySelector("#receiver .receiver-sums + .note"));
  const building = (await page.getAttribute("#receiver .receiver-sums tr[data-kind=building] th", "title")) ?? "";
  const [mean, whole] = await page.$$eval(".receiver-sums tr[data-kind=building] [data-value]", (cells) => cells.map((cell) => Number(cell.dataset.value)));
  const row = parseCsv(heliotile("replay", HAGUE, "--weather", EPW, "--every", "year", "--by", "building", "-o", "-")).find((found) => found.building === building);
  assert.ok(Math.abs(mean / Number(row.total_kwh_m2) - 1) < 1e-4, `${mean}, ${row.total_kwh_m2}`);
  assert.ok(Math.abs(whole / Number(row.total_kwh) - 1) < 1e-4, `${whole}, ${row.total_kwh}`);
  assert.deepEqual(page.complaints, []);
});

/** Of a street between a mirror and a wall, 52 N. */
function street() {
  const square = (x, y, z, wide, high) => `v ${x} ${y} ${z}\nv ${x + wide} ${y} ${z}\nv ${x + wide} ${y} ${z + high}\nv ${x} ${y} ${z + high}\nf -4 -3 -2 -1\n`;
  const ground = "v -90 -90 0\nv 90 -90 0\nv 90 90 0\nv -90 90 0\nf -4 -3 -2 -1\n";
  writeFileSync(`${out}street.obj`, `usemtl ground\n${ground}usemtl wall\n${square(-30, -12, 0, 40, 9)}usemtl mirror\n${square(-8, 10, 0, 16, 12)}`);
  writeFileSync(`${out}street.toml`, "[ground]\ndiffuse = 0.2\n[wall]\ndiffuse = 0.3\n[mirror]\ndiffuse = 0.0\nspecular = 0.8\n");
  heliotile("receivers", `${out}street.obj`, "-m", `${out}street.toml`, "--on", "ground", "--spacing", "9m", "--quiet", "-o", `${out}street.csv`);
  heliotile("build", `${out}street.obj`, "-m", `${out}street.toml`, "-r", `${out}street.csv`, "--latitude", "52", "--longitude", "5", "--quiet", "-o", `${out}street.helio`);
  return `${out}street.helio`;
}

test("Hours of sun, and minutes of sun in mirrors, are those of `sunlight` and `glare` on three days.", async () => {
  const page = await open();
  const archive = street();
  await go(page, inlined("street", archive));
  for (const [day, date] of [[80, "03-21"], [172, "06-21"], [355, "12-21"]]) {
    for (const [show, column, command, unit] of [["sunlight", "sun_hours", "sunlight", 60], ["glare", "glare_minutes", "glare", 1]]) {
      await wish(page, [["show", show], ["dayOfYear", String(day)]]);
      const shown = parseCsv(await savedCsv(page));
      const rows = parseCsv(heliotile(command, archive, "--dates", date, "--every", "day", "--year", "2021", "--quiet", "-o", "-"));
      const byId = new Map(rows.map((row) => [row.receiver, Number(row[command === "glare" ? "glare_minutes" : "sun_minutes"])]));
      assert.equal(shown.length, rows.length);
      for (const row of shown) assert.ok(Math.abs(unit * Number(row[column]) - byId.get(row.receiver)) < 0.02, `${show} ${date} ${row.receiver}: ${row[column]}, ${byId.get(row.receiver)}`);
      assert.ok(Math.max(...byId.values()) > 30, `${show} ${date}`);
    }
  }
  assert.match(await page.textContent("#show-note"), /21 December/);
  assert.deepEqual(page.complaints, []);
});
