// Asks the WebAssembly module for the rows of a query and compares them with those of `heliotile query`: names with its CSV, values with
// its .npy, which has all digits. Usage: node compare.mjs MODULE.wasm SITE.helio CONDITIONS.csv EXPECTED.csv EXPECTED.npy; exit code 1 if
// a value differs by more than 1e-6 of the largest one.
import { readFileSync } from "node:fs";

const [, , module, site, conditions, expected, digits] = process.argv;
const TOLERANCE = 1e-6;

const code = readFileSync(module);
const compiled = new WebAssembly.Module(code);
const imports = WebAssembly.Module.imports(compiled);
if (imports.length > 0) {
  console.error(`the module asks its host for ${imports.map((i) => `${i.module}.${i.name}`).join(", ")}, it should need nothing`);
  process.exit(1);
}
const { exports: core } = new WebAssembly.Instance(compiled);

function ask(archive) {
  const put = (bytes, buffer) => {
    const place = buffer(bytes.length);
    new Uint8Array(core.memory.buffer, place, bytes.length).set(bytes);
  };
  put(archive, core.archive_buffer);
  put(readFileSync(conditions), core.conditions_buffer);
  const failed = core.query();
  const text = new TextDecoder().decode(new Uint8Array(core.memory.buffer, core.text(), core.text_length()));
  return { failed, text };
}

const archive = readFileSync(site);
const started = performance.now();
const { failed, text } = ask(archive);
const seconds = (performance.now() - started) / 1000;
if (failed) {
  console.error(text);
  process.exit(1);
}

const table = (text) => text.trimEnd().split("\n").map((line) => line.split(","));
const [ours, theirs] = [table(text), table(readFileSync(expected, "utf8"))];
const problems = [];
if (ours[0].join() !== theirs[0].join()) problems.push(`columns ${ours[0].join()} instead of ${theirs[0].join()}`);
if (ours.length !== theirs.length) problems.push(`${ours.length - 1} rows instead of ${theirs.length - 1}`);
// [receiver][condition][column], f32, little-endian, behind a header whose length stands at byte 8.
const npy = readFileSync(digits);
const start = 10 + npy.readUInt16LE(8);
const columns = theirs[0].length - 2;
if (npy.length - start !== 4 * columns * (theirs.length - 1)) problems.push(`${digits} holds another number of values`);
let largest = 0;
let difference = 0;
let values = 0;
for (let row = 1; row < Math.min(ours.length, theirs.length); row++) {
  if (ours[row].slice(0, 2).join() !== theirs[row].slice(0, 2).join()) problems.push(`row ${row} is ${ours[row].slice(0, 2)}`);
  for (let column = 0; column < columns; column++) {
    const [a, b] = [Number(ours[row][column + 2]), npy.readFloatLE(start + 4 * ((row - 1) * columns + column))];
    largest = Math.max(largest, Math.abs(b));
    // Not a number must not pass for a small difference.
    difference = Math.max(difference, Number.isFinite(a - b) ? Math.abs(a - b) : Infinity);
    values += 1;
  }
}
const relative = difference / largest;
if (!(relative <= TOLERANCE)) problems.push(`a value differs by ${difference} W/m2`);

// A changed byte of the archive must be an error with a name, not other numbers and not the end of the module.
const damaged = Uint8Array.from(archive);
damaged[8256] ^= 1;
const answer = ask(damaged);
if (!/at byte \d+: found/.test(answer.text)) problems.push(`a damaged archive gave: ${answer.text.slice(0, 200)}`);

console.log(
  `${(code.length / 1e6).toFixed(2)} MB of wasm, imports nothing; ${seconds.toFixed(3)} s to verify, open and replay ${archive.length} bytes; ` +
    `${theirs.length - 1} rows, ${values} values compared; largest difference ${difference.toExponential(1)} W/m2, ` +
    `${relative.toExponential(1)} of the largest value ${largest.toFixed(3)}`,
);
for (const problem of problems) console.error(problem);
process.exit(problems.length > 0 ? 1 : 0);
