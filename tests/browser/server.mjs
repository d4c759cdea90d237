// A static server of some files in memory, with byte ranges or without. Keeps a list of what was asked.
import { createServer } from "node:http";

const servers = new Set();

/** Ends all servers, also those of tests that failed. */
export function closeServers() {
  for (const server of servers) {
    server.closeAllConnections();
    server.close();
  }
  servers.clear();
}

/** Sends a file little by little, and notes how much. */
function paced(response, body, pace, note) {
  note.sent = 0;
  const timer = setInterval(() => {
    response.write(body.subarray(note.sent, note.sent + pace));
    note.sent += pace;
    if (note.sent >= body.length) response.end();
    if (note.sent >= body.length) clearInterval(timer);
  }, 100);
  response.on("close", () => clearInterval(timer));
}

/** `files`: path -> Buffer. `ranges`: whether ranges are answered; `slow`: ms before an answer; `pace`: bytes of a whole file each tenth of a
 * second. */
export async function serve(files, { ranges, slow = 0, pace = Infinity }) {
  const asked = [];
  const server = createServer(async (request, response) => {
    const path = new URL(request.url, "http://x").pathname;
    const body = files[path];
    const note = { path, range: request.headers.range ?? null };
    asked.push(note);
    if (slow) await new Promise((resolve) => setTimeout(resolve, slow));
    if (!body) return response.writeHead(404).end("not here");
    const headers = { "Content-Type": path.endsWith(".html") ? "text/html" : "application/octet-stream", ETag: '"1"' };
    const range = /^bytes=(\d+)-(\d*)$/.exec(request.headers.range ?? "");
    if (!ranges || !range) {
      response.writeHead(200, { ...headers, "Content-Length": body.length });
      return pace === Infinity ? response.end(body) : paced(response, body, pace, note);
    }
    const from = Number(range[1]);
    const to = Math.min(range[2] === "" ? Infinity : Number(range[2]), body.length - 1);
    if (from > to) return response.writeHead(416, { "Content-Range": `bytes */${body.length}` }).end();
    const part = body.subarray(from, to + 1);
    response.writeHead(206, { ...headers, "Content-Length": part.length, "Content-Range": `bytes ${from}-${to}/${body.length}` }).end(part);
  });
  servers.add(server);
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return { address: `http://127.0.0.1:${server.address().port}`, asked };
}
