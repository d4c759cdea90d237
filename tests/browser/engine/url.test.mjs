// How archives are read from servers: ranges, whole files, files that change, what is not there. The server is a stand-in for fetch and XMLHttpRequest.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";

import { UNCHANGED, WORK, all, engineOf } from "./engine.mjs";

const { UrlBytes } = await import(join(WORK, "url.mjs"));
const HAGUE = readFileSync(join(WORK, "hague.sun/site.helio"));

/** A server of one file. */
function serve({ bytes = HAGUE, ranges = true, etag = () => '"a"', status, down = false, length = bytes.length } = {}) {
  globalThis.XMLHttpRequest = class {
    open(method, url) {
      assert.equal(method, "GET");
      this.url = url;
    }
    setRequestHeader(name, value) {
      assert.equal(name, "Range");
      [this.from, this.to] = /^bytes=(\d+)-(\d+)$/.exec(value).slice(1).map(Number);
    }
    send() {
      if (down) throw new Error("NetworkError");
      this.headers = { ETag: etag(), "Content-Length": String(length) };
      this.status = status ?? (ranges ? 206 : 200);
      this.statusText = "";
      let body = bytes;
      if (this.status === 206) {
        body = bytes.subarray(this.from, this.to + 1);
        this.headers["Content-Range"] = `bytes ${this.from}-${this.from + body.length - 1}/${bytes.length}`;
      }
      this.response = body.buffer.slice(body.byteOffset, body.byteOffset + body.length);
    }
    getResponseHeader(name) {
      return this.headers[name] ?? null;
    }
  };
  // The first bytes are asked for without waiting.
  globalThis.fetch = async (url, { headers }) => {
    const request = new XMLHttpRequest();
    request.open("GET", url);
    request.setRequestHeader("Range", headers.Range);
    request.send();
    return new Response(request.response, { status: request.status, headers: request.headers });
  };
}

const ask = {
  light: { kind: "sun", azimuth: 180, altitude: 50, dni: 800, dhi: 100 }, sky: "perez", changes: UNCHANGED, components: ["total"],
};

test("an archive of 2.4 MB is opened by at most 3 requests and 0.6 MB, and all of it is had by at most 20; without ranges by 1", async () => {
  const totals = [];
  for (const [ranges, most] of [[true, 20], [false, 1]]) {
    serve({ ranges });
    const tasks = engineOf();
    const site = await tasks.open({ url: "http://127.0.0.1/a%20b/site.helio?x=1" });
    const { requests, bytes } = tasks.traffic();
    if (ranges) assert.ok(requests <= 3 && bytes < 600_000, `${requests} ${bytes}`);
    const { columns } = await all(tasks, "moment", ask, [...Array(site.tiles).keys()]);
    assert.deepEqual([site.name, columns[0].length], ["site.helio", 1228]);
    assert.ok(tasks.traffic().requests <= most, `${tasks.traffic().requests}`);
    totals.push(columns[0].reduce((sum, value) => sum + value, 0));
  }
  assert.equal(totals[0], totals[1]);
});

test("5 ways of a server to fail have their kinds, and each message names the address", async () => {
  let asked = 0;
  const cases = [
    [{ status: 404 }, "not-found"],
    [{ status: 503 }, "network"],
    [{ down: true }, "network"],
    [{ ranges: false, length: 60e6 }, "too-large"],
    [{ etag: () => `"${asked++}"` }, "network", /has changed on the server/],
  ];
  for (const [server, kind, message = /./] of cases) {
    serve(server);
    const failure = await engineOf().open({ url: "http://127.0.0.1/site.helio" }).then(assert.fail, (error) => error);
    assert.equal(failure.kind, kind, failure.message);
    assert.match(failure.message, /^http:\/\/127.0.0.1\/site.helio /);
    assert.match(failure.message, message);
  }
});

test("200 random ranges over pages have the bytes of the file, of which each is fetched once", async () => {
  serve();
  const bytes = await UrlBytes.open("http://127.0.0.1/site.helio");
  for (let i = 0; i < 200; i++) {
    const offset = (i * 982_451_653) % (HAGUE.length - 1);
    const part = new Uint8Array(Math.min(1 + ((i * 7919) % 300_000), HAGUE.length - offset));
    bytes.read(offset, part);
    assert.ok(HAGUE.subarray(offset, offset + part.length).equals(part), `${offset}`);
  }
  assert.equal(bytes.received, HAGUE.length);
});
