// Looks at the site that tools/site/run built: searches it, and draws some pages at two widths. In: the folder of the site, a folder for pictures.
// Out: the pages that a search for each of some words finds first; pictures.
// Usage: node tools/site/look.mjs target/book OUT        (playwright-core of src/viewer/node_modules; CHROMIUM or /usr/bin/chromium)
import { createRequire } from "node:module";
import { mkdirSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";

const require = createRequire(new URL("../../src/viewer/package.json", import.meta.url));
const { chromium } = require("playwright-core");
const [site, out] = process.argv.slice(2).map((path) => resolve(path));
mkdirSync(out, { recursive: true });
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox"] });
const address = (page) => pathToFileURL(`${site}/${page}`).href;
let failed = false;
for (const width of [1280, 390]) {
  const page = await browser.newPage({ viewport: { width, height: 900 } });
  for (const name of ["index", "gallery", "gallery/tower", "comfort", "accuracy", "schema/heliotile-1", "live/index"]) {
    await page.goto(address(`${name}.html`));
    if (name === "live/index") await page.waitForTimeout(4000);
    await page.screenshot({ path: `${out}/${name.replace("/", "-")}-${width}.png` });
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    if (wide > 1) { console.log(`${name} is ${wide} pixels too wide at ${width}`); failed = true; }
  }
  await page.close();
}
const page = await browser.newPage({ viewport: { width: 1280, height: 900 } });
for (const words of ["sun hours", "snow", "EnergyPlus"]) {
  await page.goto(address("index.html"));
  await page.locator("#mdbook-search-toggle").click();
  await page.locator("#mdbook-searchbar").pressSequentially(words);
  await page.locator("#mdbook-searchresults li").first().waitFor();
  const found = await page.locator("#mdbook-searchresults li a").evaluateAll((links) => links.slice(0, 3).map((link) => link.textContent.trim()));
  console.log(`${words}: ${found.join(" | ")}`);
  failed ||= found.length === 0;
}
await browser.close();
process.exit(failed ? 1 : 0);
