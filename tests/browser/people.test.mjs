// People of an archive: mean radiant temperature, UTCI and PET on the page are those of `comfort`.
import assert from "node:assert/strict";
import { after, test } from "node:test";
import { close, EPW, go, HAGUE, heliotile, inlined, open, out, parseCsv, ready, savedCsv, valuesOnPage, wish } from "./harness.mjs";
import { people } from "./people.mjs";

after(close);
const FOUR = people(out);
const GRID = people(out, "8m");
/** Of a table with two decimals. */
const WITHIN = 0.016;

/** Rows of `comfort` by point. */
function comfort(archive, ...options) {
  const rows = parseCsv(heliotile("comfort", archive, "--weather", EPW, "--columns", "utci,mrt,pet,shortwave,longwave", ...options, "-o", "-"));
  return new Map(rows.map((row) => [row.receiver, row]));
}

const shownLegend = (page) => page.$$eval("#legend-ticks.bands b", (all) => all.map((one) => one.textContent));

test("People are shown by their UTCI at first; in two hours the page's CSV has the numbers of comfort, one row a point, and says which air.", async () => {
  const page = await open();
  await go(page, inlined("people", GRID, EPW));
  assert.deepEqual([await page.inputValue("#show-what"), await page.inputValue("#show-component")], ["moment", "utci_c"]);
  for (const [dayOfYear, minutes, hour] of [[172, 810, "06-21T13:00"], [15, 630, "01-15T10:00"]]) {
    await wish(page, [["show", "moment"], ["component", "utci_c"], ["light", "weather"], ["dayOfYear", dayOfYear], ["minutes", minutes]]);
    const text = await savedCsv(page);
    const shown = parseCsv(text);
    const [date] = hour.split("T");
    const rows = comfort(GRID, "--from", date, "--to", date);
    const program = parseCsv(heliotile("comfort", GRID, "--weather", EPW, "--columns", "air,utci,mrt,pet,shortwave,longwave", "--from", date, "--to", date, "-o", "-")).filter(({ time }) => time.includes(hour));
    assert.equal(shown.length, program.length);
    assert.equal(rows.size, program.length);
    const byId = new Map(program.map((row) => [row.receiver, row]));
    for (const row of shown) {
      for (const name of ["utci_c", "mrt_c", "pet_c"]) {
        const [a, b] = [row[name], byId.get(row.receiver)[name]];
        assert.ok((a === "" && b === "") || Math.abs(Number(a) - Number(b)) < WITHIN, `${hour} ${row.receiver} ${name}: ${a}, ${b}`);
      }
      assert.ok(Math.abs(Number(row.longwave_up) - Number(byId.get(row.receiver).longwave_up)) < 0.1);
    }
    assert.match(text, /# shown: comfort of people of a moment/);
    assert.match(text, new RegExp(`# air_c: ${Number(program[0].air_c)}\n`));
  }
  assert.deepEqual(page.complaints, []);
});

test("The table of a point has its UTCI, temperatures and twelve irradiances; the legend names its category of stress.", async () => {
  const page = await open();
  await go(page, `${inlined("point", FOUR, EPW)}#show=moment&component=utci_c&light=weather&sun=clock&dayOfYear=182&minutes=810&receiver=0.0`);
  const id = (await page.textContent("#receiver h2")).trim();
  const row = parseCsv(heliotile("comfort", FOUR, "--weather", EPW, "--columns", "utci,mrt,pet,shortwave,longwave", "--from", "07-01", "--to", "07-01", "-o", "-")).find(({ receiver, time }) => receiver === id.replace(/\/\w+$/, "") && time.includes("T13:00"));
  const values = await valuesOnPage(page);
  assert.equal(Object.keys(values).length, 15);
  for (const name of ["utci_c", "mrt_c", "pet_c"]) assert.ok(Math.abs(values[name] - Number(row[name])) < WITHIN, `${name}: ${values[name]}, ${row[name]}`);
  for (const name of Object.keys(values).filter((name) => /wave/.test(name))) assert.ok(Math.abs(values[name] - Number(row[name])) < 0.1, `${name}: ${values[name]}, ${row[name]}`);
  assert.match(await page.textContent("#receiver-values"), /UTCI, °C.*Shortwave, up, W\/m²/s);
  const bands = await shownLegend(page);
  assert.ok(bands.includes("no thermal stress") && bands.length < 5, bands.join());
  assert.match(await page.textContent("#air-facts"), /Air.*°C.*Humidity.*%.*Wind.*m\/s.*Longwave of the sky/s);
  assert.ok(!(await page.isVisible("#own-air")));
  // A range of one's own has colours without steps.
  await page.fill("#range-high", "40");
  await page.press("#range-high", "Enter");
  await page.waitForFunction(() => document.querySelectorAll("#legend-ticks.bands b").length === 0);
  assert.deepEqual(page.complaints, []);
});

test("Hours above 32 degrees of a year are those of comfort, and what is chosen stands for itself in a month and a moment.", async () => {
  const page = await open();
  await go(page, `${inlined("hours", FOUR, EPW)}#show=year&component=utci_above_32_h`);
  const total = parseCsv(heliotile("comfort", FOUR, "--weather", EPW, "--every", "total", "-o", "-"));
  const shown = new Map(parseCsv(await savedCsv(page)).map((row) => [row.receiver, row]));
  assert.equal(shown.size, 4);
  for (const row of total) {
    const found = shown.get(row.receiver);
    assert.ok(Math.abs(Number(found.utci_above_32_h) - Number(row.utci_above_32_h)) <= 1, `${row.receiver}: ${found.utci_above_32_h}, ${row.utci_above_32_h}`);
    assert.ok(Math.abs(Number(found.mrt_mean_c) - Number(row.mrt_mean_c)) < WITHIN);
  }
  await page.selectOption("#show-what", "month");
  await ready(page);
  assert.equal(await page.inputValue("#show-component"), "utci_above_32_h");
  await page.selectOption("#show-what", "moment");
  await ready(page);
  assert.equal(await page.inputValue("#show-component"), "utci_c");
  await page.selectOption("#show-component", "total");
  await ready(page);
  assert.match(await page.textContent("#legend-title"), /W\/m²/);
  assert.deepEqual(page.complaints, []);
});

test("Without weather the air is of sliders, which stand in the address and come back from there; warmer air is warmer for people.", async () => {
  const page = await open();
  const address = inlined("dry", FOUR);
  await go(page, `${address}#show=moment&component=utci_c&light=own&sun=angles&azimuth=180&altitude=55&receiver=0.0`);
  assert.ok(await page.isVisible("#own-air"));
  const before = await valuesOnPage(page);
  for (const [id, value] of [["air", "34"], ["humidity", "70"], ["wind", "0.5"]]) {
    await page.$eval(`#${id}`, (slider, value) => {
      slider.value = value;
      slider.dispatchEvent(new Event("input", { bubbles: true }));
    }, value);
  }
  await ready(page);
  const warm = await valuesOnPage(page);
  assert.ok(warm.utci_c > before.utci_c + 8 && warm.mrt_c > before.mrt_c + 5, `${before.utci_c} ${warm.utci_c}`);
  await page.waitForFunction(() => /air=34&humidity=70&wind=0.5/.test(location.hash));
  const again = await open();
  await go(again, `${address}${await page.evaluate(() => location.hash)}`);
  assert.deepEqual(await valuesOnPage(again), warm);
  assert.match(await again.textContent("#air-facts"), /Longwave of a clear sky/);
  await again.selectOption("#light-from", "overcast");
  await ready(again);
  assert.match(await again.textContent("#air-facts"), /Longwave of an overcast sky/);
  assert.deepEqual([...page.complaints, ...again.complaints], []);
});

test("An archive without people offers no comfort, whatever the address asks for.", async () => {
  const page = await open();
  await go(page, `${inlined("plain", HAGUE, EPW)}#show=moment&component=utci_c&light=weather&sun=clock&receiver=3.7`);
  assert.equal(await page.inputValue("#show-component"), "total");
  const names = await page.$$eval("#show-component option", (all) => all.map(({ value }) => value));
  assert.deepEqual(names.filter((name) => /utci|mrt|pet/.test(name)), []);
  assert.ok(!(await page.isVisible("#air-box")) && (await valuesOnPage(page)).total > 0);
  assert.deepEqual(page.complaints, []);
});

test("Two archives of people show the change of the UTCI in kelvin: none between equal ones.", async () => {
  const page = await open();
  await go(page, `${inlined("same", FOUR, EPW, FOUR)}#show=moment&component=utci_c&light=weather&sun=clock&dayOfYear=182&minutes=810&variant=change`);
  assert.match(await page.textContent("#legend-title"), /Change: .*UTCI K/);
  assert.deepEqual(await shownLegend(page), []);
  const rows = parseCsv(await savedCsv(page));
  assert.equal(rows.length, 4);
  for (const row of rows) assert.equal(Number(row.change_utci_c), 0);
});

test("Pictures of the page at 1280 and 390 pixels.", async () => {
  for (const [name, archive, width, height] of [["grid", GRID, 1280, 800], ["grid", GRID, 390, 844], ["four", FOUR, 1280, 800], ["four", FOUR, 390, 844]]) {
    const page = await open({ width, height });
    await go(page, `${inlined(`people-${name}`, archive, EPW)}#show=moment&component=utci_c&light=weather&sun=clock&dayOfYear=182&minutes=810&receiver=0.0`);
    if (width < 760) await page.click('#tabs [data-tab="show"]');
    await page.screenshot({ path: `${out}people-${name}-${width}.png` });
    assert.ok(await page.isVisible("#legend"));
    await page.close();
  }
});
