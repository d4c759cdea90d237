// What the page is told of archives: geometry, what is seen, damage, and what is no archive.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";

import { UNCHANGED, WORK, all, engineOf, memoryOf, opened } from "./engine.mjs";
import { later } from "./blake3.mjs";

const HAGUE = readFileSync(join(WORK, "hague.sun/site.helio"));
const noon = { light: { kind: "sun", azimuth: 180, altitude: 50, dni: 800, dhi: 100 }, sky: "perez", changes: UNCHANGED, components: ["total"] };

/** Where a block stands: by the directory, whose place stands in the header. */
function block(bytes, kind, tile) {
  const [directory, length] = [Number(bytes.readBigUInt64LE(48)), Number(bytes.readBigUInt64LE(56))];
  for (let at = directory; at < directory + length; at += 80) {
    if (bytes.readUInt32LE(at) === kind && bytes.readUInt32LE(at + 4) === tile) return Number(bytes.readBigUInt64LE(at + 8));
  }
  throw new Error(`no block ${kind}/${tile}`);
}

test("one flipped bit in the sky of tile 3 names block sky/3, and the 19 other tiles go on with their values", async () => {
  const whole = await opened(HAGUE);
  const before = await all(whole.tasks, "moment", noon, whole.tiles);
  const bytes = Buffer.from(HAGUE);
  bytes[block(bytes, 2, 3) + 40] ^= 4;
  const { tasks, tiles } = await opened(bytes);
  const { columns, damaged, done } = await all(tasks, "moment", noon, tiles);
  assert.deepEqual([damaged.length, damaged[0][0], done], [1, 3, true]);
  assert.match(damaged[0][1], /block sky\/3 at byte \d+ is damaged/);
  const kept = columns[0].filter((value, row) => value === before.columns[0][row]);
  assert.equal(kept.length, 1228 - 64);
});

test("5 things that are no whole archive of this format are refused with their kinds and a hint where one helps", async () => {
  const header = Buffer.from(HAGUE);
  header[20] ^= 1;
  header[4096 + 20] ^= 1;
  const cases = [
    [Buffer.alloc(20_000, "text"), "no-archive", /is not a heliotile archive/],
    [Buffer.from("short"), "no-archive", /5 bytes/],
    [HAGUE.subarray(0, 900_000), "cut", /truncated/],
    [later(HAGUE), "version", /found format 2\.\d+, this release supports format 1/],
    [header, "damaged", /block header/],
  ];
  for (const [bytes, kind, message] of cases) {
    const failure = await engineOf().open({ bytes: memoryOf(bytes), name: "x.helio" }).then(assert.fail, (error) => error);
    assert.equal(failure.kind, kind, failure.message);
    assert.match(failure.message, message);
    assert.doesNotMatch(failure.message, /to fix/);
  }
});

test("an archive without geometry gives each receiver a square of its area about its place, and its view of the sky", async () => {
  const { tasks, site, tiles } = await opened(readFileSync("tests/data/archives/v1.7-mirrors.helio"));
  assert.deepEqual([site.sceneChunks, site.hasReference, site.formatVersion], [0, false, "1.7"]);
  let receivers = 0;
  for (const tile of tiles) {
    const { middle, normal, points, corners, owner, sky, reference } = tasks.overview(tile);
    const rows = tasks.receivers(tile);
    receivers += rows.length;
    assert.deepEqual([middle.length, normal.length, points.length, corners.length, owner.length], [3, 3, 12, 6, 2].map((n) => n * rows.length));
    for (const [row, receiver] of rows.entries()) {
      const at = (corner) => [0, 1, 2].map((axis) => points[3 * corners[corner] + axis]);
      let area = 0;
      const mean = [0, 0, 0];
      for (const t of [2 * row, 2 * row + 1]) {
        assert.equal(owner[t], row);
        const [a, b, c] = [at(3 * t), at(3 * t + 1), at(3 * t + 2)];
        const [u, v] = [b, c].map((p) => p.map((x, i) => x - a[i]));
        const cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        area += Math.hypot(...cross) / 2;
        assert.ok(cross.every((x, i) => Math.abs(x / Math.hypot(...cross) - receiver.normal[i]) < 1e-3));
        [a, b, c].forEach((p) => p.forEach((x, i) => (mean[i] += x / 6)));
      }
      assert.ok(Math.abs(area / (receiver.area ?? 1) - 1) < 3e-3, `${area}`);
      assert.ok(mean.every((x, i) => Math.abs(x + site.origin[i] - receiver.position[i]) < 0.5), `${mean}`);
      assert.ok([0, 1, 2].every((i) => Math.abs(middle[3 * row + i] + site.origin[i] - receiver.position[i]) < 0.01));
      assert.ok(sky[row] === Math.fround(receiver.views[0]) && Number.isNaN(reference[row]));
    }
  }
  assert.equal(receivers, site.receivers);
});

test("patches of 1,228 receivers have their areas within 1 % and face as they do, sums of a clear year are 10 to 2,500 kWh/m2", async () => {
  const { tasks, site, tiles } = await opened(HAGUE);
  assert.equal(site.hasReference, true);
  let receivers = 0;
  for (const tile of tiles) {
    const { points, corners, owner, reference } = tasks.overview(tile);
    const rows = tasks.receivers(tile);
    const areas = rows.map(() => 0);
    owner.forEach((row, t) => {
      const [a, b, c] = [0, 1, 2].map((k) => [0, 1, 2].map((axis) => points[3 * corners[3 * t + k] + axis]));
      const [u, v] = [b, c].map((p) => p.map((x, i) => x - a[i]));
      const cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
      const along = cross.reduce((sum, x, i) => sum + x * rows[row].normal[i], 0);
      // Of slivers the rounding to mm decides.
      assert.ok(along > 0.9 * Math.hypot(...cross) || Math.hypot(...cross) < 0.02, rows[row].id);
      areas[row] += Math.hypot(...cross) / 2;
    });
    rows.forEach((receiver, row) => assert.ok(Math.abs(areas[row] / receiver.area - 1) < 0.01, `${receiver.id}: ${areas[row]} of ${receiver.area}`));
    reference.forEach((sum, row) => assert.ok(sum > 10 && sum < 2500, `${rows[row].id}: ${sum}`));
    receivers += rows.length;
  }
  assert.equal(receivers, 1228);
  const { altitude } = tasks.sun(172, 720);
  const { dni, dhi } = tasks.clear(172, 720);
  assert.ok(altitude > 55 && altitude < 62 && dni > 850 && dni < 970 && dhi > 100 && dhi < 120, `${altitude} ${dni} ${dhi}`);
  assert.deepEqual(tasks.clear(172, 0), { dni: 0, dhi: 0 });
});

test("a fisheye of 101 points has 7,845 in the disc, sky in the share that a horizontal receiver sees, and paths that stay inside", async () => {
  const { tasks, tiles } = await opened(HAGUE);
  const rows = tiles.flatMap((tile) => tasks.receivers(tile).map((receiver, row) => ({ tile, row, ...receiver })));
  const flat = rows.find(({ tilt, views }) => tilt < 1 && views[0] < 0.9);
  const { side, classes } = tasks.fisheye({ tile: flat.tile, row: flat.row, side: 101 });
  let [inside, sky, all] = [0, 0, 0];
  classes.forEach((code, i) => {
    const r = Math.hypot((i % side) - 50, Math.floor(i / side) - 50) / 50.5;
    if (code !== 0) inside += 1;
    // Of an equidistant disc: solid angle times cosine.
    const zenith = (r * Math.PI) / 2;
    const weight = r > 0 && r <= 1 ? (Math.sin(zenith) * Math.cos(zenith)) / r : 0;
    all += weight;
    if (code === 1) sky += weight;
  });
  assert.ok(Math.abs(inside - Math.PI * 50.5 ** 2) < 60, `${inside}`);
  assert.ok(Math.abs(sky / all - flat.views[0]) < 0.02, `${sky / all} ${flat.views[0]}`);
  const small = await opened(readFileSync("tests/data/archives/v1.7-box.helio"));
  const { paths } = small.tasks.fisheye({ tile: 0, row: 0, side: 9 });
  assert.ok(["21 Jun", "20 Mar", "21 Dec", "12"].every((label) => paths.some((path) => path.label === label)));
  for (const { points } of paths) {
    for (let i = 0; i < points.length; i += 2) assert.ok(Math.hypot(points[i], points[i + 1]) < 1 + 1e-6);
  }
});

test("what an engine cannot do is said: a tile that is not there, an unknown group with those that are, weather that is missing", async () => {
  const { tasks } = await opened(HAGUE);
  assert.throws(() => tasks.overview(20), /no tile 20 of 20/);
  const wrong = { ...noon, changes: { reflectance: [["roofs", 0.5]], transmittance: [] } };
  await assert.rejects(all(tasks, "moment", wrong, [0]), (error) => /no group and no material `roofs`/.test(error.message) && /name a group/.test(error.hint));
  await assert.rejects(all(tasks, "moment", { ...noon, light: { kind: "weather", hour: 3 } }, [0]), /there is none/);
  const nowhere = await opened(readFileSync("tests/data/archives/v1.7-mirrors.helio"));
  assert.throws(() => nowhere.tasks.sun(172, 720), /where on Earth/);
});

test("of 1,228 receivers that come in another order under other names, without the first 5 and with one 2 m away, 1,223 find themselves, one by its name", async () => {
  const { tasks, tiles } = await opened(HAGUE);
  const before = tiles.flatMap((tile) => tasks.receivers(tile)).map(({ id, position, normal }) => ({ id, position, normal }));
  const after = before.slice(5).reverse().map(({ position, normal }, at) => ({ id: `n${at}`, position, normal }));
  const [east, ...rest] = after[0].position;
  after[0] = { ...after[0], id: before.at(-1).id, position: [east + 2, ...rest] };
  const { partners, moved } = tasks.match(before, after);
  assert.deepEqual([partners.length, moved], [1223, 1]);
  // Of two receivers at one place either may be the partner.
  partners.forEach((partner, at) => at > 0 && assert.deepEqual(before[partner].position, after[at].position));
  assert.equal(partners[0], 1227);
  assert.deepEqual([...tasks.match(before.slice(0, 1), after.slice(9, 10)).partners], [0xffffffff]);
  await assert.rejects(engineOf().open({ bytes: memoryOf(HAGUE), name: "x.helio" }, { place: { latitude: 52, longitude: 4, convergence: 0, crs: "EPSG:28992" } }), (error) => error.kind === "other-place");
});
