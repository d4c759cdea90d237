// Do moments have the numbers of `heliotile replay` and of the hours of `heliotile replay`?
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";

import { Differences, UNCHANGED, WORK, all, conditionsFile, opened, program, random } from "./engine.mjs";

const HAGUE = join(WORK, "hague.sun/site.helio");
const SMALL = (name) => `tests/data/archives/v1.7-${name}.helio`;
const WEATHER = "tests/data/weather/golden_tmy3.epw";

async function compared(archive, suns, sky, changes, options) {
  const { tasks, site, tiles } = await opened(readFileSync(archive));
  const expected = program("replay", archive, ["--conditions", conditionsFile(suns), "--sky", sky, ...options], suns.length);
  const found = new Differences();
  for (const [label, sun] of suns.entries()) {
    const ask = { light: { kind: "sun", ...sun }, sky, changes, components: site.components };
    const { columns, done } = await all(tasks, "moment", ask, tiles);
    assert.equal(done, true);
    columns.forEach((column, c) => column.forEach((value, receiver) => found.add(value, expected(receiver, label, c))));
    assert.equal(columns[0].length, site.receivers);
  }
  return found;
}

function suns(count, seed) {
  const next = random(seed);
  return Array.from({ length: count }, () => ({ azimuth: 360 * next(), altitude: 80 * next() - 5, dni: 900 * next(), dhi: 300 * next() }));
}

test("20 suns on 1,228 receivers under 4 skies have the values of replay within 1e-4 of the largest, 171,920 a sky", async () => {
  for (const sky of ["perez", "perez1990", "uniform", "cie:12"]) {
    const found = await compared(HAGUE, suns(20, 7), sky, UNCHANGED, []);
    assert.equal(found.count, 171_920);
    assert.ok(found.share < 1e-4, `${sky}: ${found.share}`);
  }
});

test("3 changed reflectances have the values of replay within 1e-4 of the largest, 42,980 each", async () => {
  for (const [name, value] of [["ground", 0.6], ["obstruction", 0.05], ["ground", 0.9]]) {
    const changes = { reflectance: [[name, value]], transmittance: [] };
    const found = await compared(HAGUE, suns(5, 11), "perez", changes, ["--reflectance", `${name}=${value}`]);
    assert.equal(found.count, 42_980);
    assert.ok(found.share < 1e-4, `${name}=${value}: ${found.share}`);
  }
});

test("2 archives with mirrors and canopies have the values of replay within 1e-4, leaves at 0.2 and as stored", async () => {
  for (const name of ["box", "mirrors"]) {
    const { site } = await opened(readFileSync(SMALL(name)));
    const canopy = site.groups.find(({ kind }) => kind === "canopy");
    const leaves = canopy ? [[{ reflectance: [], transmittance: [[canopy.name, 0.2]] }, ["--transmittance", `${canopy.name}=0.2`]]] : [];
    for (const [changes, options] of [[UNCHANGED, []], ...leaves]) {
      const found = await compared(SMALL(name), suns(10, 3), "perez", changes, options);
      assert.ok(found.count >= 200 && found.share < 1e-4, `${name}: ${found.count} ${found.share}`);
    }
  }
});

test("24 hours of a weather file on 1,228 receivers have the values of replay within 1e-4 of the largest, 206,304", async () => {
  const { tasks, site, tiles } = await opened(readFileSync(HAGUE));
  const info = await weatherOf(tasks);
  const rows = [...info.labels.keys()].filter((row) => info.month[row] === 6 && info.day[row] === 21);
  assert.equal(rows.length, 24);
  const expected = program("replay", HAGUE, ["--weather", WEATHER, "--from", "06-21", "--to", "06-21"], 24);
  const found = new Differences();
  for (const [label, hour] of rows.entries()) {
    const ask = { light: { kind: "weather", hour }, sky: "perez", changes: UNCHANGED, components: site.components };
    const { columns } = await all(tasks, "moment", ask, tiles);
    columns.forEach((column, c) => column.forEach((value, receiver) => found.add(value, expected(receiver, label, c))));
  }
  assert.equal(found.count, 206_304);
  assert.ok(found.share < 1e-4, `${found.share}`);
  // The day of one receiver, by columns.
  const day = tasks.day({ tile: 1, row: 5, dayOfYear: 172, sky: "perez", changes: UNCHANGED });
  const one = new Differences();
  day.values.forEach((column, c) => column.forEach((value, label) => one.add(value, expected(69, label, c))));
  assert.equal(one.count, 7 * 24);
  assert.ok(one.share < 1e-6, `${one.share}`);
});

test("a newer moment supersedes an older one, which gives false and fewer than its 20 tiles", async () => {
  const { tasks, site, tiles } = await opened(readFileSync(HAGUE));
  const ask = (azimuth) => ({
    light: { kind: "sun", azimuth, altitude: 30, dni: 800, dhi: 100 }, sky: "perez", changes: UNCHANGED, components: ["total"], tiles,
  });
  let first = 0;
  const older = tasks.moment(ask(120), () => first++, assert.fail);
  let second = 0;
  const newer = tasks.moment(ask(121), () => second++, assert.fail);
  assert.deepEqual([await older, await newer, second, site.tiles], [false, true, 20, 20]);
  assert.ok(first < 20, `${first}`);
});

async function weatherOf(tasks) {
  const bytes = readFileSync(WEATHER);
  return tasks.loadWeather("golden_tmy3.epw", bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
}

test("sums of 12 months are those of replay --every month within 1e-6 of the largest, of tiles and of one receiver", async () => {
  const { tasks, site, tiles } = await opened(readFileSync(HAGUE));
  await weatherOf(tasks);
  const expected = program("replay", HAGUE, ["--weather", WEATHER, "--every", "month"], 12);
  const found = new Differences();
  for (let month = 1; month <= 12; month++) {
    const ask = { span: { kind: "month", month }, sky: "perez", changes: UNCHANGED, components: site.components };
    const { columns } = await all(tasks, "sums", ask, tiles);
    columns.forEach((column, c) => column.forEach((value, receiver) => found.add(value, expected(receiver, month - 1, c))));
  }
  assert.equal(found.count, 103_152);
  assert.ok(found.share < 1e-6, `${found.share}`);
  const months = tasks.months({ tile: 2, row: 9, sky: "perez", changes: UNCHANGED });
  const one = new Differences();
  months.values.forEach((column, c) => column.forEach((value, month) => one.add(value, expected(137, month, c))));
  assert.deepEqual([one.count, months.labels.length], [84, 12]);
  assert.ok(one.share < 1e-6, `${one.share}`);
});
