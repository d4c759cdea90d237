// An archive on a web server, read by ranges. Ranges are found out by a GET that is answered 206; a server without them sends all at once,
// which is kept if it is small. A file that changes in the meantime is an error.

import type { Bytes } from "./bytes";
import { EngineError } from "./failure";
import { PAGE, Pages } from "./pages";

/** Without ranges, larger files are not taken. */
const WHOLE_LIMIT = 50e6;

/** Bytes of the first request: enough for the header, and for a small archive. */
const FIRST = PAGE;

export class UrlBytes implements Bytes {
  readonly name: string;
  readonly length: number;
  requests = 0;
  received = 0;
  private readonly etag: string | null;
  private readonly pages: Pages;

  constructor(private readonly url: string) {
    this.name = nameOf(url);
    const first = this.get(`bytes=0-${FIRST - 1}`);
    const body = bytesOf(first);
    this.etag = first.getResponseHeader("ETag");
    if (first.status === 206) {
      this.length = totalOf(first) ?? this.refuse("network", "does not say how long it is", "let the server expose Content-Range");
    } else {
      this.length = body.length;
    }
    this.pages = new Pages(this.length, (offset, length) => this.range(offset, length), first.status === 206 ? undefined : Infinity);
    this.pages.put(0, body);
  }

  read(offset: number, into: Uint8Array): void {
    this.pages.read(offset, into);
  }

  private range(offset: number, length: number): Uint8Array {
    const answer = this.get(`bytes=${offset}-${offset + length - 1}`);
    const [etag, total] = [answer.getResponseHeader("ETag"), totalOf(answer)];
    const body = bytesOf(answer);
    if (answer.status !== 206 || etag !== this.etag || total !== this.length || body.length !== length) {
      this.refuse("network", "has changed on the server", "load the page again");
    }
    return body;
  }

  private get(range: string): XMLHttpRequest {
    const request = new XMLHttpRequest();
    request.open("GET", this.url, false);
    request.responseType = "arraybuffer";
    request.setRequestHeader("Range", range);
    this.requests += 1;
    try {
      request.send();
    } catch {
      this.refuse("network", "cannot be reached", "is the server there, and does it let this page read it (CORS)?");
    }
    if (request.status === 404 || request.status === 410) this.refuse("not-found", "is not there (404)", "is the address right?");
    if (request.status !== 200 && request.status !== 206) {
      this.refuse("network", `cannot be had: the server answers ${request.status} ${request.statusText}`.trimEnd(), "");
    }
    if (request.status === 200 && Number(request.getResponseHeader("Content-Length") ?? 0) > WHOLE_LIMIT) {
      this.refuse("too-large", "is larger than 50 MB, and its server sends no ranges", "use a server with byte ranges, or open the file from disk");
    }
    const body = bytesOf(request);
    this.received += body.length;
    if (request.status === 200 && body.length > WHOLE_LIMIT) {
      this.refuse("too-large", "is larger than 50 MB, and its server sends no ranges", "use a server with byte ranges, or open the file from disk");
    }
    return request;
  }

  private refuse(kind: "network" | "not-found" | "too-large", what: string, hint: string): never {
    throw new EngineError({ kind, message: `${this.url} ${what}`, hint });
  }
}

function bytesOf(request: XMLHttpRequest): Uint8Array {
  const body: unknown = request.response;
  return body instanceof ArrayBuffer ? new Uint8Array(body) : new Uint8Array(0);
}

/** Length of the whole by `Content-Range: bytes 0-99/1234`. */
function totalOf(request: XMLHttpRequest): number | undefined {
  const total = /\/(\d+)$/.exec(request.getResponseHeader("Content-Range") ?? "")?.[1];
  return total === undefined ? undefined : Number(total);
}

function nameOf(url: string): string {
  const path = url.split(/[?#]/)[0] ?? url;
  const last = path.split("/").pop() ?? "";
  try {
    return decodeURIComponent(last) || "archive";
  } catch {
    return last || "archive";
  }
}
