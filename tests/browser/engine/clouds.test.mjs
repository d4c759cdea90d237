// Does a picture of clouds give the numbers of `--clouds`?
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";

import { png } from "../png.mjs";
import { Differences, UNCHANGED, WORK, all, conditionsFile, opened, program, random } from "./engine.mjs";

const HAGUE = join(WORK, "hague.sun/site.helio");
const WEATHER = "tests/data/weather/golden_tmy3.epw";
const MASK = join(WORK, "clouds.png");
const SIDE = 300;
/** Bands of clouds that no quarter of a turn brings to themselves, in three colours. */
const levelsAt = (column, row) => {
  const hidden = Math.sin(column / 23) * Math.cos((row + 0.4 * column) / 31);
  return [255 * Math.max(0, hidden), 128 + 127 * hidden, row < SIDE / 2 ? 40 : 230].map(Math.round);
};
writeFileSync(MASK, png(SIDE, SIDE, levelsAt));
const LEVELS = new Uint8Array(4 * SIDE * SIDE);
for (let at = 0; at < SIDE * SIDE; at++) LEVELS.set([...levelsAt(at % SIDE, Math.floor(at / SIDE)), 255], 4 * at);

const SUNS = (() => {
  const next = random(13);
  return Array.from({ length: 10 }, () => ({ azimuth: 360 * next(), altitude: 80 * next() - 5, dni: 900 * next(), dhi: 300 * next() }));
})();

async function withWeather(tasks) {
  const bytes = readFileSync(WEATHER);
  await tasks.loadWeather("golden_tmy3.epw", bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
}

test("10 suns behind clouds at 3 tops and under 3 skies have the values of replay within 1e-4 of the largest, on 1,228 receivers", async () => {
  const { tasks, site, tiles } = await opened(readFileSync(HAGUE));
  tasks.clouds(SIDE, LEVELS, 0);
  for (const [top, sky] of [[0, "perez"], [90, "cie:12"], [217, "uniform"]]) {
    tasks.turnClouds(top);
    const expected = program("replay", HAGUE, ["--conditions", conditionsFile(SUNS), "--sky", sky, "--clouds", MASK, "--image-top", `${top}`], SUNS.length);
    const found = new Differences();
    for (const [label, sun] of SUNS.entries()) {
      const { columns } = await all(tasks, "moment", { light: { kind: "sun", ...sun }, sky, changes: UNCHANGED, components: site.components }, tiles);
      columns.forEach((column, c) => column.forEach((value, receiver) => found.add(value, expected(receiver, label, c))));
    }
    assert.equal(found.count, 85_960);
    assert.ok(found.share < 1e-4, `${top} ${sky}: ${found.share}`);
  }
});

test("months behind clouds are those of replay within 1e-6 of the largest, of tiles and of one receiver, and so is a day", async () => {
  const { tasks, site, tiles } = await opened(readFileSync(HAGUE));
  await withWeather(tasks);
  tasks.clouds(SIDE, LEVELS, 0);
  tasks.turnClouds(40);
  const options = ["--weather", WEATHER, "--clouds", MASK, "--image-top", "40"];
  const expected = program("replay", HAGUE, [...options, "--every", "month"], 12);
  const found = new Differences();
  for (const month of [3, 6]) {
    const { columns } = await all(tasks, "sums", { span: { kind: "month", month }, sky: "perez", changes: UNCHANGED, components: site.components }, tiles);
    columns.forEach((column, c) => column.forEach((value, receiver) => found.add(value, expected(receiver, month - 1, c))));
  }
  const months = tasks.months({ tile: 2, row: 9, sky: "perez", changes: UNCHANGED });
  months.values.forEach((column, c) => column.forEach((value, month) => found.add(value, expected(137, month, c))));
  assert.equal(found.count, 2 * 8596 + 84);
  assert.ok(found.share < 1e-6, `${found.share}`);
  const hours = program("replay", HAGUE, [...options, "--from", "06-21", "--to", "06-21"], 24);
  const day = new Differences();
  tasks.day({ tile: 1, row: 5, dayOfYear: 172, sky: "perez", changes: UNCHANGED }).values.forEach((column, c) => column.forEach((value, label) => day.add(value, hours(69, label, c))));
  assert.ok(day.count === 168 && day.largest > 100 && day.share < 1e-6, `${day.share}`);
});

test("clouds that are taken away leave the bits of before, and hide nothing before they are turned to a place", async () => {
  const { tasks, site, tiles } = await opened(readFileSync(HAGUE));
  const ask = { light: { kind: "sun", ...SUNS[0], altitude: 40 }, sky: "perez", changes: UNCHANGED, components: site.components };
  const { columns: before } = await all(tasks, "moment", ask, tiles);
  const map = tasks.clouds(SIDE, LEVELS, 64);
  assert.deepEqual((await all(tasks, "moment", ask, tiles)).columns, before);
  tasks.turnClouds(0);
  assert.notDeepEqual((await all(tasks, "moment", ask, tiles)).columns, before);
  tasks.turnClouds(null);
  assert.deepEqual((await all(tasks, "moment", ask, tiles)).columns, before);
  tasks.turnClouds(0);
  tasks.clouds(0, new Uint8Array(), 0);
  assert.deepEqual((await all(tasks, "moment", ask, tiles)).columns, before);
  // A map has east on the right, where the picture has it on the left; beyond the horizon nothing hides.
  const share = ([red, green, blue]) => (0.265 * red + 0.67 * green + 0.065 * blue) / 255;
  const hidden = (column, row) => 255 * (1 - share(levelsAt(SIDE - 1 - column, row)));
  assert.ok(Math.abs(map[64 * 20 + 40] - hidden(Math.floor(40.5 / 64 * SIDE), Math.floor(20.5 / 64 * SIDE))) < 12);
  assert.deepEqual([map.length, map[0], map[63]], [4096, 0, 0]);
});

test("perez1990 behind clouds and pixels that are no square are refused", async () => {
  const { tasks, tiles } = await opened(readFileSync(HAGUE));
  tasks.clouds(SIDE, LEVELS, 0);
  tasks.turnClouds(0);
  const ask = { light: { kind: "sun", ...SUNS[0] }, sky: "perez1990", changes: UNCHANGED, components: ["total"] };
  await assert.rejects(all(tasks, "moment", ask, tiles), /perez1990.*a file of skies or clouds cannot change/);
  assert.throws(() => tasks.light({ ...ask, tiles: [] }), /perez1990/);
  assert.throws(() => tasks.clouds(SIDE - 1, LEVELS, 0), /299 x 299/);
});

test("of 3 sums that are asked for at once, the last alone is made", async () => {
  const { tasks, tiles } = await opened(readFileSync(HAGUE));
  await withWeather(tasks);
  const ask = (month) => ({ span: { kind: "month", month }, sky: "perez", changes: UNCHANGED, components: ["total"], tiles });
  const counts = [0, 0, 0];
  const done = await Promise.all(counts.map((_, at) => tasks.sums(ask(at + 1), () => counts[at]++, assert.fail)));
  assert.deepEqual([done, counts], [[false, false, true], [0, 0, 20]]);
});
