// Sun, picking, keys, address, narrow windows.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { after, test } from "node:test";
import { close, EPW, go, HAGUE, inlined, open, out, ready, valuesOnPage, wish } from "./harness.mjs";

after(close);
const MOMENT = "#show=moment&light=own&sun=angles&azimuth=180&altitude=45&dni=800&dhi=100";

/** Mean colour of the middle of the view. */
async function middleColour(page) {
  const shot = await page.locator("#view").screenshot();
  return page.evaluate(async (base64) => {
    const picture = await createImageBitmap(new Blob([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))], { type: "image/png" }));
    const canvas = new OffscreenCanvas(picture.width, picture.height);
    const draw = canvas.getContext("2d");
    draw.drawImage(picture, 0, 0);
    const { data } = draw.getImageData(picture.width / 4, picture.height / 4, picture.width / 2, picture.height / 2);
    const mean = [0, 0, 0];
    data.forEach((value, at) => at % 4 < 3 && (mean[at % 4] += (4 * value) / data.length));
    return mean;
  }, shot.toString("base64"));
}

test("Another sun changes colours, and values within the legend's range.", async () => {
  const page = await open();
  await go(page, `${inlined("sun", HAGUE)}${MOMENT}&range=0,1000`);
  const noon = await middleColour(page);
  await page.focus("#altitude");
  for (let press = 0; press < 5; press++) await page.keyboard.press("PageDown");
  await ready(page);
  const evening = await middleColour(page);
  const moved = Math.hypot(...noon.map((value, at) => value - evening[at]));
  assert.ok(moved > 4, `colours moved by ${moved}`);
  assert.ok((await page.evaluate(() => window.heliotile.state.altitude)) < 45);
});

test("A click on a roof and Enter in the middle choose receivers, Escape lets them go.", async () => {
  const page = await open();
  await go(page, `${inlined("pick", HAGUE)}${MOMENT}`);
  // A camera that looks straight at a receiver.
  const camera = await page.evaluate(async () => {
    const { middle, normal } = await window.heliotile.engine.overview(5);
    const place = [...middle.slice(0, 3)];
    return [...place.map((metres, axis) => metres + 3 * normal[axis] + (axis === 1 ? -0.2 : 0)), ...place];
  });
  await wish(page, `${MOMENT.slice(1)}&camera=${camera.map((metres) => metres.toFixed(2))}`);
  await page.focus("#view");
  await page.keyboard.press("Enter");
  await ready(page);
  assert.deepEqual(await page.evaluate(() => ({ ...window.heliotile.state.selected })), { tile: 5, row: 0 });
  await page.keyboard.press("Escape");
  await page.keyboard.press("Home");
  await page.focus("#view");
  for (let press = 0; press < 4; press++) await page.keyboard.press("+");
  // Somewhere within the frame there is a receiver: the middle, or what lies about it.
  const box = await page.locator("#view").boundingBox();
  for (let at = 0; at < 60 && (await page.evaluate(() => window.heliotile.state.selected)) === null; at++) {
    await page.mouse.click(box.x + box.width * (0.2 + 0.6 * ((at * 0.37) % 1)), box.y + box.height * (0.3 + 0.4 * ((at * 0.23) % 1)));
  }
  await ready(page);
  assert.ok(await page.isVisible("#receiver"));
  assert.ok((await valuesOnPage(page)).total > 0);
  assert.match(await page.textContent("#live"), /W\/m²/);
  await page.click("#pin");
  assert.equal(await page.$$eval("#receiver h2", (all) => all.length), 2);
  await page.keyboard.press("Escape");
  assert.ok(!(await page.isVisible("#receiver")));
});

test("Arrow keys turn the view, plus comes nearer, and the address follows and brings it back.", async () => {
  const page = await open();
  const address = inlined("address", HAGUE);
  await go(page, `${address}${MOMENT}`);
  const camera = () => page.evaluate(() => [...window.heliotile.state.camera]);
  const distance = (c) => Math.hypot(c[0] - c[3], c[1] - c[4], c[2] - c[5]);
  await page.focus("#view");
  const before = await page.evaluate(() => window.heliotile.state.camera && [...window.heliotile.state.camera]);
  await page.keyboard.press("ArrowLeft");
  await page.keyboard.press("ArrowUp");
  const turned = await camera();
  assert.notDeepEqual(turned, before);
  await page.keyboard.press("+");
  const near = await camera();
  assert.ok(Math.abs(distance(near) / distance(turned) - 1 / 1.15) < 1e-3);
  await page.selectOption("#show-component", "sky_direct");
  await page.fill("#range-high", "150");
  await page.press("#range-high", "Enter");
  await page.$eval('[data-group="TINRelief"] input', (slider) => {
    slider.value = "0.5";
    slider.dispatchEvent(new Event("input", { bubbles: true }));
  });
  await page.waitForFunction(() => location.hash.includes("TINRelief=0.5") || location.hash.includes("TINRelief%3D0.5"));
  const hash = await page.evaluate(() => location.hash);
  const again = await open();
  await go(again, `${address}${hash}`);
  const state = await again.evaluate(() => ({ ...window.heliotile.state }));
  assert.equal(state.component, "sky_direct");
  assert.equal(state.range[1], 150);
  assert.equal(state.reflectance.TINRelief, 0.5);
  near.forEach((metres, at) => assert.ok(Math.abs(state.camera[at] - metres) < 0.02));
  assert.deepEqual([...page.complaints, ...again.complaints], []);
});

test("Every control has a name, and all of them are reached by the Tab key.", async () => {
  const page = await open();
  await go(page, `${inlined("names", HAGUE, EPW)}#receiver=1.1`);
  const nameless = await page.$$eval("button, input:not([hidden]), select", (all) =>
    all.filter((one) => one.offsetParent !== null && !one.getAttribute("aria-label") && !one.labels?.length && !one.textContent.trim()).map((one) => one.outerHTML));
  assert.deepEqual(nameless, []);
  const wanted = await page.$$eval("button, input, select, canvas[tabindex], summary", (all) =>
    all.filter((one) => one.offsetParent !== null && !one.disabled && (one.type !== "radio" || one.checked)).length);
  const reached = new Set();
  await page.evaluate(() => document.activeElement.blur());
  for (let press = 0; press < wanted + 8; press++) {
    await page.keyboard.press("Tab");
    reached.add(await page.evaluate(() => {
      const one = document.activeElement;
      one.dataset.seen ??= String(Math.random());
      return one === document.body ? "" : one.dataset.seen;
    }));
  }
  reached.delete("");
  assert.ok(reached.size >= wanted, `${reached.size} of ${wanted}`);
});

test("The picture holds view and legend; pictures of a wide and of a narrow window are in target/browser.", async () => {
  const address = inlined("pictures", HAGUE, EPW);
  const page = await open();
  await go(page, `${address}#receiver=3.7`);
  await page.waitForSelector("#receiver figure canvas");
  await page.screenshot({ path: `${out}wide.png` });
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("#save-picture")]);
  const png = readFileSync(await download.path());
  assert.equal(png.readUInt32BE(16), (await page.locator("#view").boundingBox()).width);
  assert.ok(png.length > 10_000);
  const narrow = await open({ width: 390, height: 800 });
  await go(narrow, address);
  for (const tab of ["light", "surfaces", "site", "receiver", "show"]) {
    await narrow.click(`#tabs [data-tab=${tab}]`);
    assert.equal(await narrow.evaluate(() => document.documentElement.scrollWidth), 390);
    await narrow.screenshot({ path: `${out}narrow-${tab}.png` });
  }
  await narrow.click("#tabs [data-tab=show]");
  const view = await narrow.locator("#view").boundingBox();
  assert.ok(view.height > 700, `folded, the view is ${view.height} high`);
  assert.deepEqual([...page.complaints, ...narrow.complaints], []);
});

test("Playing a day moves the clock, and stops.", async () => {
  const page = await open();
  await go(page, `${inlined("play", HAGUE, EPW)}#show=moment&light=weather&dayOfYear=100&minutes=600`);
  await page.click("#play");
  await page.waitForFunction(() => window.heliotile.state.minutes >= 720, null, { timeout: 60_000 });
  await page.click("#play");
  const stopped = await page.evaluate(() => window.heliotile.state.minutes);
  await page.waitForTimeout(500);
  assert.ok(Math.abs((await page.evaluate(() => window.heliotile.state.minutes)) - stopped) <= 60);
  assert.equal(await page.getAttribute("#play", "aria-pressed"), "false");
});

test("One finger turns the view, two that part come nearer.", async () => {
  const page = await open();
  await go(page, `${inlined("touch", HAGUE)}${MOMENT}`);
  const cdp = await page.context().newCDPSession(page);
  const touch = (type, ...points) => cdp.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  const camera = () => page.evaluate(() => [...(window.heliotile.state.camera ?? [])]);
  const distance = (c) => Math.hypot(c[0] - c[3], c[1] - c[4], c[2] - c[5]);
  const settled = async (before) => {
    await page.waitForFunction((old) => JSON.stringify(window.heliotile.state.camera) !== old, JSON.stringify(before), { timeout: 10_000 });
    return camera();
  };
  // A key says where the view is.
  await page.focus("#view");
  await page.keyboard.press("ArrowLeft");
  const before = await camera();
  await touch("touchStart", [600, 400]);
  for (let at = 1; at <= 10; at++) await touch("touchMove", [600 + 12 * at, 400]);
  await touch("touchEnd");
  const turned = await settled(before);
  assert.ok(Math.abs(distance(turned) / distance(before) - 1) < 0.01);
  await touch("touchStart", [580, 400], [620, 400]);
  for (let at = 1; at <= 10; at++) await touch("touchMove", [580 - 10 * at, 400], [620 + 10 * at, 400]);
  await touch("touchEnd");
  const near = await settled(turned);
  assert.ok(distance(near) < 0.8 * distance(turned), `${distance(near)} of ${distance(turned)} m`);
  assert.deepEqual(page.complaints, []);
});

test("Who asked for less motion gets a day by the hour, slowly: no more than 3 steps in 2 seconds.", async () => {
  const page = await open();
  await page.emulateMedia({ reducedMotion: "reduce" });
  await go(page, `${inlined("calm", HAGUE, EPW)}#show=moment&light=clear&dayOfYear=172&minutes=600`);
  await page.click("#play");
  await page.waitForFunction(() => window.heliotile.state.minutes > 600);
  const first = await page.evaluate(() => window.heliotile.state.minutes);
  await page.waitForTimeout(2000);
  const steps = ((await page.evaluate(() => window.heliotile.state.minutes)) - first) / 60;
  await page.click("#play");
  assert.ok(first === 660 && Number.isInteger(steps) && steps <= 3, `${first} ${steps}`);
});
