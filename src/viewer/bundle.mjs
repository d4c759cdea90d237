// Puts styles, scripts and the engine into one page. In: the folder of a built engine, or none: then the engine of the present page stays.
// Usage: node bundle.mjs [ENGINE.wasm]. Equal inputs give equal bytes.
import { createHash } from "node:crypto";
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { gunzipSync, gzipSync } from "node:zlib";
import { build } from "esbuild";

const here = new URL(".", import.meta.url);
const read = (path) => readFileSync(new URL(path, here), "utf8");
const page = new URL("../results/page/page.html", here);

async function bundled(entry, format) {
  const { outputFiles } = await build({
    absWorkingDir: here.pathname, entryPoints: [entry], bundle: true, write: false, minify: true, format, target: "es2022",
    charset: "utf8", legalComments: "none", logLevel: "warning",
  });
  return outputFiles[0].text.trimEnd();
}

// The same engine keeps its packed text: another version of zlib would pack it otherwise.
function engineText() {
  const [, , path] = process.argv;
  const old = existsSync(page) ? (/id="engine"[^>]*>([^<]*)</.exec(readFileSync(page, "utf8"))?.[1] ?? null) : null;
  if (path === undefined) {
    if (old === null) throw new Error("there is no page.html whose engine could be taken: build the engine");
    return old;
  }
  const engine = readFileSync(path);
  if (old !== null && gunzipSync(Buffer.from(old, "base64")).equals(engine)) return old;
  return gzipSync(engine, { level: 9 }).toString("base64");
}

const style = await bundled("source/page.css");
const script = await bundled("source/main.ts", "iife");
const worker = await bundled("source/engine/worker.ts", "iife");
for (const text of [style, script]) if (/<\/(script|style)/i.test(text)) throw new Error("a script or style would end early");

const hash = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;
const policy = [
  "default-src 'none'", `script-src ${hash(script)} 'wasm-unsafe-eval'`, "worker-src blob:", `style-src ${hash(style)}`,
  "img-src data: blob:", "connect-src * data: blob:", "base-uri 'none'", "form-action 'none'",
].join("; ");
const licences = "three.js: MIT, copyright 2010-2026 three.js authors. Colour map viridis: CC0. Colour map PuOr: includes color specifications and designs developed by Cynthia Brewer (colorbrewer2.org), Apache-style licence.";
const blocks = [
  `<script type="application/octet-stream" id="worker">${Buffer.from(worker).toString("base64")}</script>`,
  `<script type="application/octet-stream" id="engine" data-packed="gzip">${engineText()}</script>`,
].join("\n");
const parts = {
  "<!-- page: policy -->": `<meta http-equiv="Content-Security-Policy" content="${policy}">\n<!-- ${licences} -->`,
  "<!-- page: style -->": style,
  "<!-- page: engine -->": blocks,
  "<!-- page: script -->": script,
};
let html = read("source/page.html");
for (const [marker, part] of Object.entries(parts)) {
  if (html.split(marker).length !== 2) throw new Error(`source/page.html must hold ${marker} once`);
  html = html.replace(marker, () => part);
}
for (const marker of ["<!-- heliotile: data -->", "<!-- heliotile: later -->"]) {
  if (html.split(marker).length !== 2) throw new Error(`${marker} must stand once in the page`);
}
writeFileSync(page, html);
const kB = (text) => `${Math.round(Buffer.byteLength(text) / 1000)} kB`;
console.log(`src/results/page/page.html: ${kB(html)}; script ${kB(script)}, worker ${kB(worker)}, style ${kB(style)}, engine ${kB(blocks)} packed`);
