// Pictures of the page: node tools/screenshots/pictures.mjs FOLDER OUTPUT, with FOLDER/{block,lake,alps,change}.html.
import { chromium } from "../../src/viewer/node_modules/playwright-core/index.mjs";

const [folder, output] = process.argv.slice(2);
const shown = {
  block: "show=year&receiver=3.10",
  lake: "show=moment&light=clear&dayOfYear=172&minutes=600",
  alps: "show=year&camera=118,-44,-112,80,-84,-121",
  change: "variant=change&show=year&receiver=10.22&camera=-67,-123,88,-110,-34,18",
};
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--disable-background-networking", "--disable-component-update", "--no-first-run"],
});
for (const [name, hash] of Object.entries(shown)) {
  for (const [width, height] of [[1280, 800], [390, 844]]) {
    const page = await browser.newPage({ viewport: { width, height } });
    await page.goto(`file://${folder}/${name}.html#${hash}`);
    await page.waitForFunction(() => window.heliotile);
    await page.evaluate(() => window.heliotile.ready);
    // What the weather's place is said to be far from does not matter here.
    for (const button of await page.$$('#messages button')) await button.click().catch(() => {});
    await page.waitForTimeout(1000);
    await page.screenshot({ path: `${output}/page-${name}-${width}.png` });
    await page.close();
  }
}
await browser.close();
