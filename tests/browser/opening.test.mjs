// Where archives come from, and what is said when they do not.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { after, test } from "node:test";
import { close, EPW, go, HAGUE, heliotile, inlined, open, out, PAGE, path, ready, valuesOnPage } from "./harness.mjs";
import { later } from "./engine/blake3.mjs";
import { closeServers, serve } from "./server.mjs";

after(async () => {
  await close();
  closeServers();
});
const site = readFileSync(HAGUE);
const SMALL = path("tests/data/archives/v1.7-mirrors.helio");
const files = { "/page.html": Buffer.from(PAGE), "/site.helio": site, "/x.epw": readFileSync(EPW), "/text.helio": Buffer.from("no archive at all, only words ".repeat(400)), "/cut.helio": site.subarray(0, site.length >> 1), "/later.helio": later(site) };

/** The page's message for an archive at an address. */
async function messageFor(query, server) {
  const page = await open();
  await go(page, `${server.address}/page.html${query}`);
  const [kind, text] = await page.$eval(".message.bad", (message) => [message.dataset.kind, message.textContent]);
  assert.equal(page.complaints.length, 0, page.complaints.join("\n"));
  await page.close();
  return { kind, text };
}

test("A page with its archive inside opens from a file, and loads nothing from elsewhere.", async () => {
  const page = await open();
  const requests = [];
  page.on("request", (request) => requests.push(request.url()));
  await go(page, inlined("inside", HAGUE));
  assert.equal(await page.textContent("#site-name"), "site.helio");
  assert.match(await page.textContent("#site-line"), /1,228 receivers/);
  assert.deepEqual(requests.filter((url) => !/^(file|blob|data):/.test(url)), []);
  assert.deepEqual(page.complaints, []);
});

test("A page inside a cell of a notebook shows its archive, and moves without an address.", async () => {
  const page = await open();
  const cell = `${out}notebook.html`;
  const quoted = readFileSync(new URL(inlined("cell", HAGUE, EPW)), "utf8").replaceAll("&", "&amp;").replaceAll('"', "&quot;");
  writeFileSync(cell, `<iframe srcdoc="${quoted}" style="width: 100%; height: 640px"></iframe>`);
  await page.goto(`file://${cell}`);
  const frame = page.frames()[1];
  await frame.waitForFunction(() => document.querySelector("#site-line")?.textContent.includes("1,228 receivers"));
  await frame.selectOption("#show-component", "sun_direct");
  await page.waitForTimeout(600);
  assert.deepEqual(page.complaints, []);
});

test("A server with ranges is read by ranges, with weather by address.", async () => {
  const server = await serve(files, { ranges: true });
  const page = await open();
  await go(page, `${server.address}/page.html?url=site.helio&weather=x.epw#receiver=2.2`);
  assert.equal(await page.inputValue("#show-what"), "year");
  assert.ok((await valuesOnPage(page)).total > 100);
  const ofSite = server.asked.filter(({ path }) => path === "/site.helio");
  assert.ok(ofSite.length > 0 && ofSite.every(({ range }) => range !== null), JSON.stringify(ofSite));
  assert.deepEqual(page.complaints, []);
});

test("A pointer leads to its archive; one to an archive of another length, or to itself, does not.", async () => {
  const pointer = (name, length) => Buffer.from(`{"heliotile_pointer":1,"name":"${name}","length":${length},"root":"00"}`);
  const pointed = { ...files, "/a.helio": pointer("site.helio", site.length), "/b.helio": pointer("site.helio", 7), "/c.helio": pointer("c.helio", 7) };
  const server = await serve(pointed, { ranges: true });
  const page = await open();
  await go(page, `${server.address}/page.html?url=a.helio`);
  assert.match(await page.textContent("#site-line"), /1,228 receivers/);
  assert.deepEqual(page.complaints, []);
  assert.match((await messageFor("?url=b.helio", server)).text, /points to an archive of another length/);
  assert.equal((await messageFor("?url=c.helio", server)).kind !== undefined, true);
});

test("A server without ranges works too, for archives below 50 MB.", async () => {
  const server = await serve(files, { ranges: false });
  const page = await open();
  await go(page, `${server.address}/page.html?url=site.helio`);
  assert.match(await page.textContent("#site-line"), /1,228 receivers/);
  assert.deepEqual(page.complaints, []);
});

test("A slow server shows the site all the same.", async () => {
  const server = await serve(files, { ranges: true, slow: 300 });
  const page = await open();
  await go(page, `${server.address}/page.html?url=site.helio`);
  assert.match(await page.textContent("#site-line"), /1,228 receivers/);
});

test("What is missing, no archive, cut off or of a later format is told as such, and what to do.", async () => {
  const server = await serve(files, { ranges: true });
  for (const [name, kinds] of [["none.helio", /not-found/], ["text.helio", /no-archive/], ["cut.helio", /cut|damaged/], ["later.helio", /version/]]) {
    const { kind, text } = await messageFor(`?url=${name}`, server);
    assert.match(kind, kinds, `${name}: ${text}`);
    assert.match(text, /Check|Open|Copy|verify/);
  }
  const dead = await messageFor("?url=http://127.0.0.1:9/site.helio", server);
  assert.equal(dead.kind, "network");
});

test("Of 60 MB on a server without ranges the page says that they are too large before a tenth of them has come.", async () => {
  const server = await serve({ "/page.html": Buffer.from(PAGE), "/site.helio": Buffer.alloc(60e6) }, { ranges: false, pace: 4e6 });
  const { kind, text } = await messageFor("?url=site.helio", server);
  assert.equal(kind, "too-large");
  assert.match(text, /sends no ranges/);
  const { sent } = server.asked.find(({ path }) => path === "/site.helio");
  assert.ok(sent < 6e6, `${sent} bytes`);
});

test("An archive that cannot be opened leaves the one before it as it was.", async () => {
  const page = await open();
  await go(page, `${inlined("before", HAGUE)}#show=moment&light=own&sun=angles&receiver=0.0`);
  writeFileSync(`${out}text.helio`, files["/text.helio"]);
  await page.setInputFiles("#file-archive", `${out}text.helio`);
  await page.waitForSelector(".message.bad");
  await page.evaluate(() => (location.hash = "#show=moment&light=own&sun=angles&altitude=41&receiver=0.0"));
  await page.waitForFunction(() => Number(document.querySelector("#receiver-values tr.total [data-value]")?.dataset.value) > 0);
  assert.match(await page.textContent("#site-line"), /1,228 receivers/);
  assert.deepEqual(page.complaints, []);
});

test("Without an archive there is a picker, and a file that is chosen opens; a second one takes its place.", async () => {
  const page = await open();
  const server = await serve(files, { ranges: true });
  await go(page, `${server.address}/page.html`);
  assert.ok(await page.isVisible("#welcome-open"));
  await page.setInputFiles("#file-archive", HAGUE);
  await page.waitForSelector('body[data-state="open"]');
  await ready(page);
  assert.match(await page.textContent("#site-line"), /1,228 receivers/);
  await page.setInputFiles("#file-weather", EPW);
  await page.waitForFunction(() => window.heliotile.state.show === "year");
  await ready(page);
  await page.setInputFiles("#file-archive", SMALL);
  await page.waitForFunction(() => !document.querySelector("#site-line").textContent.includes("1,228"));
  await ready(page);
  assert.match(await page.textContent("#site-line"), /\d+ receivers/);
  assert.deepEqual(page.complaints, []);
});

test("A damaged block is named on the page, and the other receivers are shown.", async () => {
  // Some byte that lies in a block of one tile.
  let name = null;
  const damaged = Buffer.from(site);
  for (let share = 0.02; share < 0.98 && name === null; share += 0.02) {
    const at = Math.floor(site.length * share);
    damaged[at] ^= 1;
    writeFileSync(`${out}damaged.helio`, damaged);
    try {
      heliotile("archive", "verify", `${out}damaged.helio`);
    } catch (error) {
      name = /^(response\/\d+)/m.exec(`${error.stdout}${error.stderr}`)?.[1] ?? null;
    }
    if (name === null) damaged[at] ^= 1;
  }
  assert.ok(name, "no byte of a response was found");
  const page = await open();
  await go(page, `${inlined("damaged", `${out}damaged.helio`)}#show=moment&light=own&sun=angles`);
  await page.waitForSelector("#damage-list li", { state: "attached" });
  assert.match(await page.textContent("#damage-list"), new RegExp(name.replace("/", "\\D*")));
  assert.match(await page.textContent(".message.bad"), /repair/);
  const tile = Number(name.split("/")[1]);
  await page.evaluate((tile) => (location.hash = `#show=moment&light=own&sun=angles&receiver=${tile === 0 ? 1 : 0}.0`), tile);
  await page.waitForFunction(() => Number(document.querySelector("#receiver-values tr.total [data-value]")?.dataset.value) > 0);
  assert.deepEqual(page.complaints, []);
});

test("Names of an archive are shown as text, whatever they hold, and the policy holds.", async () => {
  const evil = '<script>window.evil=1</script><img src=x onerror="window.evil=2">';
  const quoted = `"${evil.replaceAll('"', '""')}"`;
  writeFileSync(`${out}evil.csv`, `receiver,x,y,z,nx,ny,nz,area,surface\n${quoted},78716.2410,458018.2889,10.7447,0.545236,0.347669,0.762787,15,${quoted}\n`);
  heliotile("--quiet", "build", path("tests/data/hague/scene.obj"), "-m", path("tests/data/hague/materials.toml"), "-r", `${out}evil.csv`, "-o", `${out}evil.helio`);
  const page = await open();
  await go(page, `${inlined("evil", `${out}evil.helio`)}#show=moment&light=own&sun=angles&receiver=0.0`);
  assert.equal(await page.textContent("#receiver h2"), evil);
  await page.waitForSelector("#receiver canvas");
  assert.equal(await page.evaluate(() => window.evil), undefined);
  assert.deepEqual(page.complaints, []);
  // Scripts that come into the page do not run.
  await page.evaluate(() => {
    const script = document.createElement("script");
    script.textContent = "window.evil = 3";
    document.body.append(script);
  });
  assert.equal(await page.evaluate(() => window.evil), undefined);
  assert.match(page.complaints.join("\n"), /Content Security Policy/);
});
