// What the tests share: engines over archives in memory, and the program beside them.
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { gunzipSync } from "node:zlib";

export const WORK = process.env.WORK;
export const UNCHANGED = { reflectance: [], transmittance: [] };
const { Tasks } = await import(join(WORK, "tasks.mjs"));
const page = "src/results/page/page.html";
const engine = process.env.ENGINE
  ? readFileSync(process.env.ENGINE)
  : gunzipSync(Buffer.from(/id="engine"[^>]*>([^<]*)</.exec(readFileSync(page, "utf8"))[1], "base64"));
const module = await WebAssembly.compile(engine);

/** An engine that has no archive; messages get in between tiles as in the worker. */
export const engineOf = () => new Tasks(module, () => new Promise((resolve) => setImmediate(resolve)));

/** An engine over an archive in memory, with its site. */
export async function opened(bytes, name = "site.helio") {
  const tasks = engineOf();
  const site = await tasks.open({ bytes: memoryOf(bytes), name });
  return { tasks, site, tiles: [...Array(site.tiles).keys()] };
}

export const memoryOf = (bytes) => bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length);

/** `[component][receiver]` of all tiles, and the tiles that are damaged. */
export async function all(tasks, call, ask, tiles) {
  const columns = ask.components.map(() => []);
  const damaged = [];
  const onTile = ({ first, values }) =>
    values.forEach((column, i) => column.forEach((value, row) => (columns[i][first + row] = value)));
  const done = await tasks[call]({ ...ask, tiles }, onTile, (tile, message) => damaged.push([tile, message]));
  return { columns, damaged, done };
}

/** Values of the program, f32 with all digits: `[receiver][label][component]`. */
export function program(command, archive, options, labels) {
  const npy = join(WORK, "program.npy");
  execFileSync(process.env.HELIOTILE, [command, archive, ...options, "-o", npy, "--quiet"], { stdio: ["ignore", "ignore", "pipe"] });
  const bytes = readFileSync(npy);
  const start = 10 + bytes.readUInt16LE(8);
  const values = new Float32Array(memoryOf(bytes.subarray(start)));
  return (receiver, label, component) => values[(receiver * labels + label) * 7 + component];
}

export const conditionsFile = (suns) => {
  const path = join(WORK, "conditions.csv");
  const lines = suns.map(({ azimuth, altitude, dni, dhi }, i) => `c${i},${azimuth},${altitude},${dni},${dhi}`);
  writeFileSync(path, ["condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2", ...lines, ""].join("\n"));
  return path;
};

/** Numbers from 0 to 1, always the same ones (mulberry32). */
export function random(seed) {
  return () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

/** Largest difference of what was found from what was expected, as a share of the largest value, and how many there were. */
export class Differences {
  count = 0;
  worst = 0;
  largest = 0;
  add(found, expected) {
    this.count += 1;
    // Not a number must not pass for a small difference.
    this.worst = Math.max(this.worst, Number.isFinite(found - expected) ? Math.abs(found - expected) : Infinity);
    this.largest = Math.max(this.largest, Math.abs(expected));
  }
  get share() {
    return this.worst / this.largest;
  }
}
