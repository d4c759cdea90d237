// Does the engine give people the numbers of `heliotile comfort`?
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";

import { YEAR, people } from "../people.mjs";
import { UNCHANGED, WORK, memoryOf, opened, random } from "./engine.mjs";

const FOUR = people(WORK);
const GRID = people(WORK, "8m");
const NUMBERS = 15;

/** Numbers of the program, f32 with all digits: `[point][row][number]`. */
function comfort(archive, options, rows, numbers) {
  const npy = join(WORK, "comfort.npy");
  execFileSync(process.env.HELIOTILE, ["comfort", archive, "--weather", YEAR, ...options, "-o", npy, "--quiet"], { stdio: ["ignore", "ignore", "pipe"] });
  const bytes = readFileSync(npy);
  const values = new Float32Array(memoryOf(bytes.subarray(10 + bytes.readUInt16LE(8))));
  return (point, row, number) => values[(point * rows + row) * numbers + number];
}

/** An engine with people and weather: `felt(ask)` gives `[point][number]`, of the receivers that look up. */
async function ofPeople(archive) {
  const { tasks, tiles } = await opened(readFileSync(archive));
  const weather = await tasks.loadWeather("golden_tmy3.epw", memoryOf(readFileSync(YEAR)));
  const found = tasks.people();
  const felt = async (ask, names, order = tiles) => {
    const receivers = [];
    const onTile = ({ first, values }) => values[0].forEach((_, row) => (receivers[first + row] = values.map((column) => column[row])));
    assert.ok(await tasks.comfort({ sky: "perez", changes: UNCHANGED, ...ask, names, tiles: order }, onTile, assert.fail));
    assert.equal(receivers.length, found.up.length);
    receivers.forEach((numbers, at) => assert.ok(numbers, `receiver ${at}`));
    return { receivers, points: receivers.filter((_, at) => found.up[at] === 1) };
  };
  return { tasks, tiles, weather, found, felt };
}

/** The largest difference, none where both have no value. */
const apart = (a, b) => (Number.isNaN(a) && Number.isNaN(b) ? 0 : Number.isFinite(a - b) ? Math.abs(a - b) : Infinity);

test("in 60 hours of a year UTCI, MRT and PET of 4 people are those of comfort within 0.01 K, and 12 irradiances within 0.1 W/m2", async () => {
  const { weather, found, felt } = await ofPeople(FOUR);
  assert.deepEqual([found.count, found.moment.length, found.up.length], [4, NUMBERS, 24]);
  const expected = comfort(FOUR, ["--columns", "utci,mrt,pet,shortwave,longwave"], weather.rows, NUMBERS);
  const next = random(5);
  let [kelvin, flux, most, without] = [0, 0, 0, 0];
  for (let at = 0; at < 60; at++) {
    // Half of them between ten and four.
    const day = Math.floor(365 * next());
    const hour = 24 * day + (at % 2 ? 10 + Math.floor(6 * next()) : Math.floor(24 * next()));
    const { points } = await felt({ of: "moment", light: { kind: "weather", hour }, air: { kind: "weather", hour } }, found.moment);
    points.forEach((numbers, point) => numbers.forEach((value, number) => {
      const other = expected(point, hour, number);
      if (number < 3) kelvin = Math.max(kelvin, apart(value, other));
      else flux = Math.max(flux, apart(value, other));
      if (number === 1) most = Math.max(most, other);
      if (Number.isNaN(other)) without += 1;
    }));
  }
  assert.ok(most > 50 && without < 12, `${most} ${without}`);
  assert.ok(kelvin < 0.01, `${kelvin} K`);
  assert.ok(flux < 0.1, `${flux} W/m2`);
});

test("people whose planes lie in two tiles have the values of comfort too, whichever tile is asked for first, and all planes those of their point", async (t) => {
  const { tasks, tiles, weather, found, felt } = await ofPeople(GRID);
  assert.ok(tiles.length > 3 && found.count > 40, `${tiles.length} tiles, ${found.count} people`);
  const expected = comfort(GRID, ["--columns", "utci,mrt,pet,shortwave,longwave"], weather.rows, NUMBERS);
  const hour = 24 * 171 + 13;
  let worst = 0;
  for (const order of [tiles, [...tiles].reverse(), [2, 0, ...tiles.filter((tile) => tile !== 2 && tile !== 0)]]) {
    const ask = { of: "moment", light: { kind: "weather", hour }, air: { kind: "weather", hour } };
    // Another ask in between: nothing is left of the former order.
    await felt({ ...ask, air: { kind: "own", temperature: 20, humidity: 40, wind: 2, cover: 0 } }, found.moment);
    const { receivers, points } = await felt(ask, found.moment, order);
    points.forEach((numbers, point) => [0, 1, 2].forEach((number) => (worst = Math.max(worst, apart(numbers[number], expected(point, hour, number))))));
    const names = tiles.flatMap((tile) => tasks.receivers(tile).map(({ id }) => id));
    const upOf = new Map(names.map((id, at) => [id, receivers[at]]));
    names.forEach((id, at) => assert.deepEqual(receivers[at], upOf.get(id.replace(/\/(down|north|east|south|west)$/, ""))));
  }
  assert.ok(worst < 0.01, `${worst} K`);
  const cost = async (times, ask, names) => {
    const began = performance.now();
    for (let at = 0; at < times; at++) await felt(ask(at), names);
    return (performance.now() - began) / times / found.count;
  };
  const moment = await cost(20, (at) => ({ of: "moment", light: { kind: "weather", hour: hour + at }, air: { kind: "weather", hour: hour + at } }), found.moment);
  const year = await cost(1, () => ({ of: "span", span: { kind: "year" } }), found.sums);
  t.diagnostic(`a person costs ${moment.toFixed(2)} ms a moment and ${year.toFixed(0)} ms a year`);
});

test("means and hours above 26, 32, 38 and 46 of a year and of July are those of comfort: 0.01 K and at most one hour, whose UTCI lies at a threshold", async () => {
  const { found, felt } = await ofPeople(FOUR);
  assert.deepEqual(found.sums, ["mrt_mean_c", "utci_mean_c", "utci_max_c", ...[26, 32, 38, 46].map((limit) => `utci_above_${limit}_h`)]);
  for (const [span, options] of [[{ kind: "year" }, ["--every", "total"]], [{ kind: "month", month: 7 }, ["--from", "07-01", "--to", "07-31", "--every", "total"]]]) {
    const expected = comfort(FOUR, ["--columns", "mrt,utci", ...options], 1, 7);
    const { points } = await felt({ of: "span", span }, found.sums);
    points.forEach((numbers, point) => numbers.forEach((value, number) => {
      const off = apart(value, expected(point, 0, number));
      assert.ok(off < (number < 3 ? 0.01 : 1.01), `${span.kind} ${point} ${found.sums[number]}: ${value}, ${expected(point, 0, number)}`);
    }));
    assert.ok(points[0][3] > 50 && points[0][3] < 1500);
  }
});

test("air by numbers is taken below a clear and an overcast sky, and what is missing or out of range is refused by name", async () => {
  const { tasks, tiles } = await opened(readFileSync(FOUR));
  const { moment: names } = tasks.people();
  const [clear, overcast] = [0, 10].map((cover) => ({ kind: "own", temperature: 25, humidity: 50, wind: 1, cover }));
  const { temperature, humidity, wind, sky } = tasks.air(clear);
  // Clark and Allen by hand: 0.787 + 0.764 ln(287.01 / 273.15) = 0.8248, times 448.07 W/m2.
  assert.deepEqual([temperature, wind], [25, 1]);
  assert.ok(Math.abs(humidity - 50) < 0.1 && Math.abs(sky - 369.57) < 0.1, `${humidity} ${sky}`);
  assert.ok(tasks.air(overcast).sky > sky + 50);
  const ask = (light, air) => tasks.comfort({ of: "moment", light, air, sky: "perez", changes: UNCHANGED, names, tiles }, () => undefined, assert.fail);
  const sun = { kind: "sun", azimuth: 180, altitude: 60, dni: 800, dhi: 100 };
  assert.ok(await ask(sun, clear));
  await assert.rejects(ask(sun, { ...clear, humidity: 0 }), /humidity is 0/);
  await assert.rejects(ask(sun, { kind: "weather", hour: 3 }), /weather/);
  const dry = "time,ghi,dni,dhi,temp_air,wind_speed,longwave_down\n2019-07-01T12:00,800,700,100,25,2,350\n2019-07-01T13:00,800,700,100,25,2,350\n";
  await tasks.loadWeather("dry.csv", memoryOf(Buffer.from(dry)), { time_zone: "-7" });
  await assert.rejects(ask(sun, { kind: "weather", hour: 0 }), /humidity is missing in the hour 2019-07-01T12:00/);
});

test("people are drawn as boxes of six faces of 0.36 m2, each 0.3 m from the point to where it looks, besides the patches of the ground", async () => {
  for (const archive of [FOUR, GRID]) {
    const { tasks, tiles } = await opened(readFileSync(archive));
    let faces = 0;
    for (const tile of tiles) {
      const { middle, normal, points, corners, owner } = tasks.overview(tile);
      const at = (array, row) => [...array.subarray(3 * row, 3 * row + 3)];
      owner.forEach((row, triangle) => {
        const [a, b, c] = at(corners, triangle).map((corner) => at(points, corner));
        const [u, v] = [b, c].map((other) => other.map((metres, axis) => metres - a[axis]));
        const cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        const off = at(middle, row).map((metres, axis) => a[axis] - metres).reduce((sum, metres, axis) => sum + metres * at(normal, row)[axis], 0);
        // Patches lie on the ground, 1.1 m below.
        if (at(normal, row)[2] > 0.99 && off < -0.5) return;
        faces += 0.5;
        assert.ok(Math.abs(off - 0.3) < 2e-3 && Math.abs(Math.hypot(...cross) / 2 - 0.18) < 2e-3, `${tile} ${row}: ${off}`);
      });
    }
    assert.equal(faces, 6 * tasks.people().count);
  }
});

test("an archive without people offers nothing and is not asked", async () => {
  const { tasks, tiles } = await opened(readFileSync(join(WORK, "hague.sun/site.helio")));
  const found = tasks.people();
  assert.deepEqual([found.count, found.up.length, found.stress.length, found.stress[5]], [0, 0, 10, { name: "no thermal stress", to: 26 }]);
  const ask = { of: "span", span: { kind: "year" }, sky: "perez", changes: UNCHANGED, names: found.sums, tiles };
  await assert.rejects(tasks.comfort(ask, () => undefined, assert.fail), /no people/);
});
