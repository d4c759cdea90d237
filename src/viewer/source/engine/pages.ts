// Cache of the pages of a file that is fetched by ranges. In: ranges. Out: their bytes. Fetched
// pages are kept, and the least recently used goes first. One request fetches pages that lie side
// by side.

/** Function that fetches bytes from a position on. */
export type Fetch = (offset: number, length: number) => Uint8Array;

/** Bytes of a page. Pages are aligned, so that neighbouring ranges share them. */
export const PAGE = 1 << 17;

/** Largest number of bytes that are kept. */
const LIMIT = 32 << 20;

/** Largest number of bytes of one request. */
const LONGEST = 16 << 20;

/**
 * Number of pages in a row, read one after the other, after which the cache fetches twice as far
 * ahead.
 */
const AHEAD = 8;

export class Pages {
  /** Kept pages by number, the least recently used first. */
  private readonly kept = new Map<number, Uint8Array>();
  /** Page behind the last that was fetched, and how far to fetch ahead there. */
  private next = -1;
  private ahead = 1;

  constructor(private readonly length: number, private readonly fetch: Fetch, private limit = LIMIT) {}

  /** Keeps bytes from another source, such as the first answer of a server. */
  put(offset: number, bytes: Uint8Array): void {
    for (let at = 0; at < bytes.length; at += PAGE) {
      const part = bytes.subarray(at, at + PAGE);
      const whole = part.length === PAGE || offset + at + part.length === this.length;
      if ((offset + at) % PAGE === 0 && whole) this.keep((offset + at) / PAGE, part.slice());
    }
  }

  /** Divides the memory for pages by the number of workers. */
  share(workers: number): void {
    this.limit /= workers;
  }

  read(offset: number, into: Uint8Array): void {
    const [first, last] = [Math.floor(offset / PAGE), Math.floor((offset + into.length - 1) / PAGE)];
    for (let page = first; page <= last; page++) {
      const bytes = this.kept.get(page) ?? this.load(page, last);
      this.keep(page, bytes);
      const [from, to] = [Math.max(offset, page * PAGE), Math.min(offset + into.length, (page + 1) * PAGE)];
      into.set(bytes.subarray(from - page * PAGE, to - page * PAGE), from - offset);
    }
  }

  /** Fetches a range that will be read soon, with as few requests as possible. */
  expect(offset: number, length: number): void {
    const last = Math.floor((Math.min(offset + length, this.length) - 1) / PAGE);
    for (let page = Math.floor(offset / PAGE); page <= last; page++) if (!this.kept.has(page)) this.load(page, last);
  }

  /**
   * Fetches a page and the missing pages behind it, up to the last that is asked for or that comes
   * next in order.
   */
  private load(page: number, last: number): Uint8Array {
    this.ahead = page === this.next ? Math.min(2 * this.ahead, AHEAD) : 1;
    const end = Math.min(Math.max(last + 1, page + this.ahead), Math.ceil(this.length / PAGE), page + LONGEST / PAGE);
    let missing = page + 1;
    while (missing < end && !this.kept.has(missing)) missing++;
    const bytes = this.fetch(page * PAGE, Math.min(missing * PAGE, this.length) - page * PAGE);
    this.next = missing;
    for (let other = page; other < missing; other++) {
      this.keep(other, bytes.slice((other - page) * PAGE, (other - page + 1) * PAGE));
    }
    return bytes.subarray(0, PAGE);
  }

  private keep(page: number, bytes: Uint8Array): void {
    this.kept.delete(page);
    this.kept.set(page, bytes);
    for (const oldest of this.kept.keys()) {
      if (this.kept.size * PAGE <= this.limit) break;
      this.kept.delete(oldest);
    }
  }
}
