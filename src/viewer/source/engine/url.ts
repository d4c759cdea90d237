// An archive on a web server, read by ranges. A GET that is answered with 206 shows that the server
// has ranges. A server without them sends the whole file, which is kept if it is small; a large
// file is refused before it has come. A file that changes in the meantime is an error.

import type { Bytes } from "./bytes";
import { EngineError } from "./failure";
import { PAGE, Pages } from "./pages";

/** Largest file that is taken without ranges, bytes. */
const WHOLE_LIMIT = 50e6;

/** Bytes of the first request: enough for the header, and for a small archive. */
const FIRST = PAGE;

export class UrlBytes implements Bytes {
  readonly name: string;
  readonly length: number;
  readonly isDivisible: boolean;
  requests = 0;
  received = 0;
  private readonly etag: string | null;
  private readonly pages: Pages;

  /**
   * Requests the first bytes; a server without ranges sends all. A pointer is followed, once
   * (schema/pointer.md).
   */
  static async open(url: string, isFollowed = false): Promise<UrlBytes> {
    const refuse = refusing(url);
    const first = await fetch(url, { headers: { Range: `bytes=0-${FIRST - 1}` } }).catch(() => refuse("network", ...UNREACHED));
    check(first.status, first.statusText, refuse);
    const total = totalOf(first.headers.get("Content-Range"));
    const ranges = first.status === 206;
    if (ranges && total === undefined) refuse("network", "is sent without its length", "let the server expose the header Content-Range (CORS)");
    const parts: Uint8Array[] = [];
    let length = 0;
    const reader = first.body?.getReader();
    const tooLarge = (bytes: number): boolean => !ranges && bytes > WHOLE_LIMIT;
    for (let all = reader === undefined; !all; ) {
      if (tooLarge(Math.max(length, Number(first.headers.get("Content-Length") ?? 0)))) {
        await reader!.cancel();
        refuse("too-large", "is larger than 50 MB, and its server sends no ranges", "use a server with byte ranges, or open the file from disk");
      }
      const { done, value } = await reader!.read().catch(() => refuse("network", "was cut off during the transfer", "load the page again"));
      all = done;
      if (value) [length] = [length + value.length, parts.push(value)];
    }
    const body = new Uint8Array(length);
    parts.reduce((at, part) => (body.set(part, at), at + part.length), 0);
    const pointer = isFollowed ? undefined : pointedAt(body, total ?? length);
    if (pointer !== undefined) {
      const archive = await UrlBytes.open(new URL(encodeURIComponent(pointer.name), url).href, true);
      if (archive.length !== pointer.length) refuse("network", "points to an archive of another length", "load the page again");
      return archive;
    }
    return new UrlBytes(url, total ?? length, first.headers.get("ETag"), body, ranges);
  }

  private constructor(private readonly url: string, length: number, etag: string | null, first: Uint8Array, ranges: boolean) {
    [this.name, this.length, this.etag] = [nameOf(url), length, etag];
    [this.requests, this.received] = [1, first.length];
    this.isDivisible = ranges;
    this.pages = new Pages(length, (offset, count) => this.range(offset, count), ranges ? undefined : Infinity);
    this.pages.put(0, first);
  }

  read(offset: number, into: Uint8Array): void {
    this.pages.read(offset, into);
  }

  expect(offset: number, length: number): void {
    this.pages.expect(offset, length);
  }

  share(workers: number): void {
    this.pages.share(workers);
  }

  private range(offset: number, length: number): Uint8Array {
    const refuse = refusing(this.url);
    const request = new XMLHttpRequest();
    request.open("GET", this.url, false);
    request.responseType = "arraybuffer";
    request.setRequestHeader("Range", `bytes=${offset}-${offset + length - 1}`);
    this.requests += 1;
    try {
      request.send();
    } catch {
      refuse("network", ...UNREACHED);
    }
    check(request.status, request.statusText, refuse);
    const [etag, total] = [request.getResponseHeader("ETag"), totalOf(request.getResponseHeader("Content-Range"))];
    const body = bytesOf(request);
    this.received += body.length;
    if (request.status !== 206 || etag !== this.etag || total !== this.length || body.length !== length) {
      refuse("network", "has changed on the server", "load the page again");
    }
    return body;
  }
}

/** Largest number of bytes of a pointer. */
const MAX_POINTER = 4096;

/** Beginning of a pointer. */
const POINTER = '{"heliotile_pointer":';

/**
 * Returns the archive that a pointer leads to, in the pointer's folder, or undefined if the bytes
 * are no pointer of layout 1.
 */
function pointedAt(body: Uint8Array, length: number): { name: string; length: number } | undefined {
  if (length > MAX_POINTER || body.length !== length) return undefined;
  const text = new TextDecoder().decode(body);
  if (!text.startsWith(POINTER)) return undefined;
  try {
    const pointer = JSON.parse(text) as { heliotile_pointer?: unknown; name?: unknown; length?: unknown };
    const { name, length: bytes } = pointer;
    const isName = typeof name === "string" && /^(?!\.{1,2}$)[^/\\?#%:]+$/.test(name);
    return pointer.heliotile_pointer === 1 && isName && typeof bytes === "number" ? { name, length: bytes } : undefined;
  } catch {
    return undefined;
  }
}

type Refuse = (kind: "network" | "not-found" | "too-large", what: string, hint: string) => never;

const UNREACHED = ["cannot be reached", "is the server there, and does it let this page read it (CORS)?"] as const;

function refusing(url: string): Refuse {
  return (kind, what, hint) => {
    throw new EngineError({ kind, message: `${url} ${what}`, hint });
  };
}

function check(status: number, text: string, refuse: Refuse): void {
  if (status === 404 || status === 410) refuse("not-found", "is not there (404)", "is the address right?");
  if (status !== 200 && status !== 206) refuse("network", `cannot be loaded: the server answers ${status} ${text}`.trimEnd(), "");
}

function bytesOf(request: XMLHttpRequest): Uint8Array {
  const body: unknown = request.response;
  return body instanceof ArrayBuffer ? new Uint8Array(body) : new Uint8Array(0);
}

/** Returns the length of the whole file by `Content-Range: bytes 0-99/1234`. */
function totalOf(range: string | null): number | undefined {
  const total = /\/(\d+)$/.exec(range ?? "")?.[1];
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
