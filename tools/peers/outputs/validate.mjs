// Khronos' glTF validator. In: a .glb. Out: its report as JSON on standard output.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const require = createRequire(`${process.cwd()}/target/peers/outputs/npm/`);
const report = await require("gltf-validator").validateBytes(new Uint8Array(readFileSync(process.argv[2])), { maxIssues: 100 });
console.log(JSON.stringify(report));
