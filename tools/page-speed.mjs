// What a site costs in the browser: node tools/page-speed.mjs ADDRESS, with `heliotile view SITE.helio --weather FILE` at that address, of a
// site with a place. Prints times to the first picture, to all receivers, of three suns and of a year's sums, bytes, requests, memory.
import { chromium } from "../src/viewer/node_modules/playwright-core/index.mjs";

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--disable-background-networking", "--disable-component-update", "--no-first-run"],
});
const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
page.on("pageerror", (error) => console.log("error", error.message));
const traffic = () => page.evaluate(() => window.heliotile.engine.traffic());
const report = async (what, began) => console.log(`${what}: ${Date.now() - began} ms, ${JSON.stringify(await traffic())}`);
let began = Date.now();
await page.goto(`${process.argv[2]}#show=reference`);
await page.waitForFunction(() => window.heliotile && !document.getElementById("legend").hidden, null, { timeout: 120_000 });
await report("first picture", began);
const show = async (what, hash) => {
  if (hash) {
    began = Date.now();
    await page.evaluate((text) => { location.hash = text; }, hash);
    await page.waitForTimeout(50);
  }
  await page.evaluate(() => window.heliotile.ready);
  await report(what, began);
};
await show("all receivers", null);
for (const minutes of [600, 660, 900]) await show(`sun at ${minutes / 60} h`, `show=moment&light=clear&dayOfYear=172&minutes=${minutes}`);
await show("sums of a year", "show=year");
console.log(`heap of the page: ${await page.evaluate(() => performance.memory?.usedJSHeapSize)} bytes`);
await browser.close();
