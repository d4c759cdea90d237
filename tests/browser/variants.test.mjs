// Two archives on one page: before, after and the change, which is that of the program's numbers.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { after, test } from "node:test";
import { AFTER, close, EPW, go, HAGUE, heliotile, inlined, open, out, PAGE, parseCsv, path, random, ready, savedCsv, wish } from "./harness.mjs";
import { closeServers, serve } from "./server.mjs";

const COMPONENTS = ["sun_direct", "sky_direct", "sun_reflected", "sky_reflected", "sun_mirrored", "sky_mirrored", "total"];
/** Of the largest value: both round to six or seven figures. */
const WITHIN = 1e-4;
const programs = [];
after(async () => {
  for (const program of programs) program.kill("SIGKILL");
  await close();
  closeServers();
});

const state = (page) => page.evaluate(() => ({ ...window.heliotile.state }));
const sunOf = (sun) => Object.entries(sun).map(([name, value]) => [name, String(value)]);
const NOON = [["show", "moment"], ["light", "own"], ["sun", "angles"], ...sunOf({ azimuth: 200, altitude: 40, dni: 700, dhi: 90 })];

/** Chooses one of the three by a click. */
async function show(page, variant) {
  await page.click(`#variant label:has([value=${variant}])`);
  await ready(page);
}

/** Receivers of an archive by name: place and normal. */
const receiversOf = (page, which) =>
  page.evaluate(async (which) => {
    const all = [];
    for (let tile = 0; ; tile++) {
      try {
        all.push(...(await window.heliotile[which].receivers(tile)));
      } catch {
        return all.map(({ id, position, normal }) => ({ id, position, normal }));
      }
    }
  }, which);

/** Name of the receiver before that stands where one after does, or none. */
function partnerOf(receiver, before) {
  const apart = (other) => Math.hypot(...receiver.position.map((metres, axis) => metres - other.position[axis]));
  const along = (other) => receiver.normal.reduce((sum, part, axis) => sum + part * other.normal[axis], 0);
  return before.find((other) => apart(other) <= 0.01 && along(other) > 0.9999)?.id ?? null;
}

function queried(archive, { azimuth, altitude, dni, dhi }) {
  writeFileSync(`${out}conditions.csv`, `condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\nc,${azimuth},${altitude},${dni},${dhi}\n`);
  const rows = parseCsv(heliotile("replay", archive, "--conditions", `${out}conditions.csv`, "-o", "-"));
  return new Map(rows.map((row) => [row.receiver, row]));
}

test("The change of every receiver under 5 suns is after minus before of `replay`; those without a partner have none.", async (t) => {
  const page = await open();
  await go(page, `${inlined("change", HAGUE, null, AFTER)}#variant=change&show=moment&light=own&sun=angles`);
  assert.ok(await page.isVisible("#variant"));
  const [before, latter] = [await receiversOf(page, "engine"), await receiversOf(page, "after")];
  const partners = new Map(latter.map((receiver) => [receiver.id, partnerOf(receiver, before)]));
  const pairs = [...partners.values()].filter((id) => id !== null).length;
  const next = random(5);
  let [worst, compared, alone] = [0, 0, 0];
  for (let at = 0; at < 5; at++) {
    const sun = { azimuth: Math.floor(150 + 120 * next()), altitude: Math.floor(10 + 50 * next()), dni: Math.floor(200 + 700 * next()), dhi: Math.floor(20 + 200 * next()) };
    await wish(page, [["variant", "change"], ["show", "moment"], ["light", "own"], ["sun", "angles"], ...sunOf(sun)]);
    const rows = parseCsv(await savedCsv(page));
    const [one, other] = [queried(HAGUE, sun), queried(AFTER, sun)];
    const most = Math.max(...[...one.values()].map((row) => Number(row.total)));
    assert.equal(rows.length, latter.length + before.length - pairs);
    for (const [number, row] of rows.entries()) {
      const isAfter = number < latter.length;
      const partner = isAfter ? partners.get(row.receiver) : row.receiver;
      for (const name of COMPONENTS) {
        const [from, to] = [partner === null ? NaN : Number(one.get(partner)[name]), isAfter ? Number(other.get(row.receiver)[name]) : NaN];
        const found = [row[`before_${name}`], row[`after_${name}`], row[`change_${name}`]];
        for (const [place, expected] of [from, to, to - from].entries()) {
          if (Number.isNaN(expected)) {
            assert.equal(found[place], "", `${row.receiver} ${name}`);
            alone += 1;
            continue;
          }
          worst = Math.max(worst, Math.abs(Number(found[place]) - expected) / most);
          compared += 1;
        }
      }
    }
  }
  t.diagnostic(`${pairs} pairs of ${before.length} and ${latter.length} receivers; ${compared} numbers within ${worst.toExponential(1)} of the largest total, ${alone} empty`);
  assert.ok(pairs > 1000 && pairs < before.length && pairs < latter.length);
  assert.ok(worst < WITHIN && compared > 100_000, `${worst} ${compared}`);
  assert.deepEqual(page.complaints, []);
});

test("The three have one camera, one receiver and one sun; the address keeps which is shown, and brings it back.", async () => {
  const page = await open();
  const address = inlined("three", HAGUE, EPW, AFTER);
  await go(page, `${address}#${new URLSearchParams(NOON)}&receiver=3.7`);
  assert.equal((await state(page)).variant, "before");
  await page.focus("#view");
  await page.keyboard.press("ArrowLeft");
  await page.keyboard.press("+");
  const kept = ({ camera, selected, altitude, show: shown }) => ({ camera, selected, altitude, shown });
  const before = kept(await state(page));
  assert.ok(before.camera && before.selected);
  const titles = [];
  const pictures = [];
  for (const variant of ["after", "change", "before", "change"]) {
    await show(page, variant);
    const now = await state(page);
    assert.equal(now.variant, variant);
    assert.deepEqual(kept(now), before);
    titles.push(await page.textContent("#legend-title"));
    // Without what lies on the view at its edges.
    pictures.push((await page.screenshot({ clip: { x: 420, y: 100, width: 440, height: 500 } })).toString("base64"));
  }
  assert.deepEqual(titles, ["This moment, total W/m²", "Change: This moment, total W/m²", "This moment, total W/m²", "Change: This moment, total W/m²"]);
  assert.ok(new Set(pictures.slice(0, 3)).size === 3 && pictures[1] === pictures[3]);
  const ticks = await page.$$eval("#legend-ticks span", (all) => all.map((tick) => [tick.textContent, tick.className]));
  assert.ok(ticks.some(([text, name]) => text === "0" && name === "zero") && ticks[0][0] === `−${ticks.at(-1)[0]}`, JSON.stringify(ticks));
  await page.check("#show-percent");
  await ready(page);
  assert.match(await page.textContent("#legend-title"), /% of before$/);
  await page.waitForFunction(() => location.hash.includes("variant=change") && location.hash.includes("percent"));
  const again = await open();
  await go(again, `${address}${await page.evaluate(() => location.hash)}`);
  const brought = await state(again);
  assert.deepEqual([brought.variant, brought.percent, brought.selected, brought.altitude], ["change", true, before.selected, before.altitude]);
  brought.camera.forEach((metres, at) => assert.ok(Math.abs(metres - before.camera[at]) < 0.02));
  assert.match(await again.textContent("#legend-title"), /% of before$/);
  assert.deepEqual([...page.complaints, ...again.complaints], []);
});

test("The card of a receiver has before, after and change of `replay`; one of the tower has no before.", async () => {
  const page = await open();
  await go(page, `${inlined("card-change", HAGUE, null, AFTER)}#${new URLSearchParams([["variant", "after"], ...NOON])}&receiver=3.7`);
  const sun = { azimuth: 200, altitude: 40, dni: 700, dhi: 90 };
  const [one, other] = [queried(HAGUE, sun), queried(AFTER, sun)];
  const [before, latter] = [await receiversOf(page, "engine"), await receiversOf(page, "after")];
  const partners = new Map(latter.map((receiver) => [partnerOf(receiver, before), receiver.id]));
  const cells = () => page.$$eval(".receiver-changes tbody tr", (rows) => rows.map((row) => [row.dataset.component, ...[...row.querySelectorAll("td")].map((cell) => (cell.dataset.value === undefined ? cell.textContent : Number(cell.dataset.value)))]));
  const id = await page.textContent("#receiver h2");
  assert.equal((await cells()).length, COMPONENTS.length);
  for (const [name, from, to, change, percent] of await cells()) {
    const [a, b] = [Number(one.get(id)[name]), Number(other.get(partners.get(id))[name])];
    for (const [found, expected] of [[from, a], [to, b], [change, b - a]]) assert.ok(Math.abs(found - expected) < 0.05, `${name}: ${found}, ${expected}`);
    assert.ok(a === 0 || Math.abs(percent - (100 * (b - a)) / a) < 0.1, `${name}: ${percent} %`);
  }
  assert.equal(await page.$$eval("#receiver figure canvas", (all) => all.length), 2);

  // A wall of the tower.
  const tower = latter.findIndex((receiver) => receiver.position[2] > 20);
  const place = await page.evaluate(async (id) => {
    for (let tile = 0; ; tile++) {
      const row = (await window.heliotile.after.receivers(tile)).findIndex((receiver) => receiver.id === id);
      if (row >= 0) return `after.${tile}.${row}`;
    }
  }, latter[tower].id);
  await wish(page, [["variant", "change"], ...NOON, ["receiver", place]]);
  assert.equal(await page.textContent("#receiver h2"), latter[tower].id);
  const [total] = (await cells()).filter(([name]) => name === "total");
  assert.deepEqual([total[1], total[3], total[4]], ["–", "–", "–"]);
  assert.ok(Math.abs(total[2] - Number(other.get(latter[tower].id).total)) < 0.05);
  assert.match(await page.textContent("#show-note"), /receivers are in both archives; \d+ only after, grey; \d+ only before, not shown\./);
  assert.deepEqual(page.complaints, []);
});

test("Colours of the change are violet where the tower takes the sun, nearly white where nothing changes, and grey on the tower.", async () => {
  const page = await open();
  const sun = { azimuth: 225, altitude: 30, dni: 800, dhi: 60 };
  const parameters = [["variant", "change"], ["show", "moment"], ["light", "own"], ["sun", "angles"], ["range", "-500,500"], ...sunOf(sun)];
  await go(page, `${inlined("colours", HAGUE, null, AFTER)}#${new URLSearchParams(parameters)}`);
  const rows = parseCsv(await savedCsv(page)).filter((row) => row.after_total !== "");
  const latter = await receiversOf(page, "after");
  const origin = await page.evaluate(async () => (await window.heliotile.engine.overview(0)).middle.slice(0, 3));
  const first = await page.evaluate(async () => (await window.heliotile.engine.receivers(0))[0].position);
  const zero = first.map((metres, axis) => metres - origin[axis]);
  const loss = rows.findIndex((row) => Number(row.change_total) < -400);
  const flat = rows.map((row, at) => ({ ...row, at })).filter((row) => row.change_total !== "" && Math.abs(Number(row.change_total)) < 0.5 && Number(row.tilt_deg) < 50);
  // Nothing stands before the highest.
  const { at: same } = flat.sort((a, b) => Number(b.z) - Number(a.z))[0];
  const grey = rows.findIndex((row, at) => row.before_total === "" && latter[at].position[2] > 20 && Number(row.tilt_deg) > 80);
  const colours = [];
  for (const at of [loss, same, grey]) {
    const { position, normal } = latter[at];
    const target = position.map((metres, axis) => metres - zero[axis]);
    const camera = [...target.map((metres, axis) => metres + 2 * normal[axis] + (axis === 1 ? -0.05 : 0)), ...target];
    await wish(page, [...parameters, ["camera", camera.map((metres) => metres.toFixed(2)).join(",")]]);
    const box = await page.locator("#view").boundingBox();
    const shot = await page.screenshot({ clip: { x: box.x + box.width / 2 - 20, y: box.y + box.height / 2 - 20, width: 8, height: 8 } });
    colours.push(await page.evaluate(async (base64) => {
      const picture = await createImageBitmap(new Blob([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))], { type: "image/png" }));
      const canvas = new OffscreenCanvas(8, 8);
      const draw = canvas.getContext("2d");
      draw.drawImage(picture, 0, 0);
      return [...draw.getImageData(4, 4, 1, 1).data.slice(0, 3)];
    }, shot.toString("base64")));
  }
  const [violet, white, none] = colours;
  assert.ok(violet[2] > violet[1] + 40 && violet[2] > violet[0], JSON.stringify(colours));
  assert.ok(Math.min(...white) > 205 && Math.max(...white) - Math.min(...white) < 12, JSON.stringify(colours));
  assert.ok(none.every((part, channel) => Math.abs(part - [184, 189, 194][channel]) < 22), JSON.stringify(colours));
  assert.deepEqual(page.complaints, []);
});

test("While the sun moves the graphics card colours the change as the core does at rest.", async (t) => {
  const page = await open();
  const parameters = [["variant", "change"], ["show", "moment"], ["light", "own"], ["sun", "angles"], ["range", "-500,500"]];
  const address = `${inlined("moving", HAGUE, null, AFTER)}?card=256`;
  await go(page, `${address}#${new URLSearchParams([...parameters, ...sunOf({ azimuth: 150, altitude: 50, dni: 500, dhi: 90 })])}`);
  await page.waitForFunction(() => window.heliotile.card.complete);
  // Textures of the archive after are asked for meanwhile; then the cores are kept from answering for all.
  await page.waitForTimeout(3000);
  await page.evaluate(() => {
    for (const engine of [window.heliotile.engine, window.heliotile.after]) {
      const moment = engine.moment.bind(engine);
      engine.moment = (ask, ...rest) => (ask.tiles.length > 2 ? new Promise(() => {}) : moment(ask, ...rest));
    }
  });
  const sun = [...parameters, ...sunOf({ azimuth: 225, altitude: 30, dni: 800, dhi: 60 })];
  await page.evaluate((hash) => (location.hash = hash), `#${new URLSearchParams(sun)}`);
  await page.waitForFunction(() => window.heliotile.card.shown !== null);
  await page.waitForTimeout(1000);
  const byCard = (await page.locator("#view").screenshot()).toString("base64");
  const other = await open();
  await go(other, `${address}#${new URLSearchParams(sun)}`);
  await other.waitForTimeout(300);
  const byCore = (await other.locator("#view").screenshot()).toString("base64");
  const [apart, pixels] = await other.evaluate(async (pictures) => {
    const [a, b] = await Promise.all(pictures.map(async (base64) => {
      const picture = await createImageBitmap(new Blob([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))], { type: "image/png" }));
      const draw = new OffscreenCanvas(picture.width, picture.height).getContext("2d");
      draw.drawImage(picture, 0, 0);
      return draw.getImageData(0, 0, picture.width, picture.height).data;
    }));
    let apart = 0;
    for (let at = 0; at < a.length; at += 4) apart += [0, 1, 2].some((channel) => Math.abs(a[at + channel] - b[at + channel]) > 6);
    return [apart, a.length / 4];
  }, [byCard, byCore]);
  t.diagnostic(`${apart} of ${pixels} pixels differ`);
  assert.ok(apart < 0.002 * pixels, `${apart} of ${pixels}`);
  assert.deepEqual([...page.complaints, ...other.complaints], []);
});

test("`view --with` serves both by ranges; the second one comes when the first is on the screen.", async () => {
  const program = spawn(process.env.HELIOTILE, ["view", HAGUE, "--with", AFTER, "--port", "0"], { stdio: ["ignore", "pipe", "inherit"] });
  programs.push(program);
  const address = await new Promise((resolve) => program.stdout.on("data", (chunk) => resolve(/http:\/\/[^/]+/.exec(String(chunk))[0])));
  const page = await open();
  const requests = [];
  page.on("request", (request) => requests.push(new URL(request.url()).pathname));
  await go(page, `${address}/`);
  assert.equal(await page.textContent("#site-name"), "site.helio → after.helio");
  assert.match(await page.textContent("#site-line"), /1,228 → [\d,]+ receivers/);
  const [one, other] = ["/site.helio", "/after.helio"].map((name) => requests.indexOf(name));
  assert.ok(one >= 0 && other > one + 2, requests.join());
  await show(page, "change");
  assert.equal(await page.textContent("#legend-title"), "Change: Sky view % points");
  assert.deepEqual(page.complaints, []);
});

test("A second archive is opened by hand, and by the address; one that takes the place of the first ends the comparison.", async () => {
  const files = { "/page.html": Buffer.from(PAGE), "/site.helio": readFileSync(HAGUE), "/after.helio": readFileSync(AFTER) };
  const server = await serve(files, { ranges: true });
  const page = await open({ width: 390, height: 844 });
  await go(page, `${server.address}/page.html?url=site.helio&with=after.helio#variant=after`);
  assert.equal((await state(page)).variant, "after");
  assert.ok(await page.isVisible("#variant"));
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
  await go(page, `${server.address}/page.html?url=site.helio#show=sky`);
  assert.ok(!(await page.isVisible("#variant")));
  await page.setInputFiles("#file-after", AFTER);
  await page.waitForFunction(() => !document.querySelector("#variant [value=change]").disabled);
  await ready(page);
  await show(page, "change");
  assert.equal(await page.textContent("#legend-title"), "Change: Sky view % points");
  await page.setInputFiles("#file-archive", AFTER);
  await page.waitForFunction(() => document.querySelector("#variant").hidden);
  await ready(page);
  assert.equal(await page.evaluate(() => window.heliotile.after), null);
  assert.deepEqual(page.complaints, []);
});

test("Equal archives, such without a common receiver and of another coordinate system are told in plain words.", async () => {
  const told = async (one, other) => {
    const page = await open();
    await go(page, inlined("told", one, null, other));
    const [kind, text] = await page.$eval(".message", (message) => [message.dataset.kind, message.textContent]);
    const found = { kind, text, switched: await page.isVisible("#variant"), change: await page.isEnabled("#variant [value=change]") };
    assert.deepEqual(page.complaints, []);
    await page.close();
    return found;
  };
  const equal = await told(HAGUE, HAGUE);
  assert.deepEqual([equal.kind, equal.switched, equal.change], ["equal", true, true]);
  assert.match(equal.text, /equal: nothing changes/);
  const strange = await told(HAGUE, path("tests/data/archives/v1.7-mirrors.helio"));
  assert.deepEqual([strange.kind, strange.switched, strange.change], ["no-common", true, false]);
  assert.match(strange.text, /no receiver in common/);
  writeFileSync(`${out}one.csv`, "receiver,x,y,z,nx,ny,nz\na,78716.2410,458018.2889,30,0,0,1\n");
  for (const [name, crs] of [["here", "EPSG:28992"], ["elsewhere", "EPSG:25832"]]) {
    const built = ["-m", path("tests/data/hague/materials.toml"), "-r", `${out}one.csv`, "--crs", crs, "-o", `${out}${name}.helio`];
    heliotile("--quiet", "build", path("tests/data/hague/scene.obj"), ...built);
  }
  const elsewhere = await told(`${out}here.helio`, `${out}elsewhere.helio`);
  assert.deepEqual([elsewhere.kind, elsewhere.switched], ["other-place", false]);
  assert.match(elsewhere.text, /different places.*EPSG:25832/);
});
