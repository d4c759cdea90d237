// A variant of the block of The Hague: one of its houses becomes a tower of 40 m: node tests/browser/variant.mjs CITY.city.json OUTPUT.city.json
import { readFileSync, writeFileSync } from "node:fs";

const HOUSE = "GUID_C03EF5C6-4B5A-49C8-BA5A-2412549D9AD7";
const [LOW, HIGH] = [[78714, 457944, 3.7], [78723, 457952, 43.7]];

const [from, to] = process.argv.slice(2);
const city = JSON.parse(readFileSync(from, "utf8"));
if (!(HOUSE in city.CityObjects)) throw new Error(`${from} has no ${HOUSE}`);
delete city.CityObjects[HOUSE];
const { scale, translate } = city.transform;
const first = city.vertices.length;
for (const z of [LOW[2], HIGH[2]]) {
  for (const [x, y] of [[LOW[0], LOW[1]], [HIGH[0], LOW[1]], [HIGH[0], HIGH[1]], [LOW[0], HIGH[1]]]) {
    city.vertices.push([x, y, z].map((metres, axis) => Math.round((metres - translate[axis]) / scale[axis])));
  }
}
const faces = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
const shell = faces.map((face) => [face.map((corner) => first + corner)]);
const kinds = ["GroundSurface", "RoofSurface", "WallSurface"];
const semantics = { surfaces: kinds.map((type) => ({ type })), values: [[0, 1, 2, 2, 2, 2]] };
city.CityObjects.tower = { type: "Building", geometry: [{ type: "Solid", lod: "2", boundaries: [shell], semantics }] };
writeFileSync(to, JSON.stringify(city));
