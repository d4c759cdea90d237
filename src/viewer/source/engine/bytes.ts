// Bytes of an archive in memory, in a file or on a server. They are read by ranges and
// synchronously, since the engine reads in the middle of its work.

import { EngineError } from "./failure";
import { Pages } from "./pages";

export interface Bytes {
  readonly name: string;
  readonly length: number;
  /** Fills `into` from a position; throws an EngineError if it cannot. */
  read(offset: number, into: Uint8Array): void;
  /** True if other workers can read the bytes by ranges, too. */
  readonly isDivisible: boolean;
  /** Announces a range that will be read soon. */
  expect(offset: number, length: number): void;
  /** Divides the memory for read bytes by the number of workers that read the same archive. */
  share(workers: number): void;
  /** Number of requests so far. */
  readonly requests: number;
  readonly received: number;
}

/** Bytes in memory. */
export class MemoryBytes implements Bytes {
  readonly isDivisible = true;
  readonly requests = 0;
  readonly received = 0;
  private readonly bytes: Uint8Array;

  constructor(readonly name: string, bytes: ArrayBuffer | Uint8Array) {
    this.bytes = bytes instanceof Uint8Array ? bytes : new Uint8Array(bytes);
  }

  get length(): number {
    return this.bytes.length;
  }

  read(offset: number, into: Uint8Array): void {
    into.set(this.bytes.subarray(offset, offset + into.length));
  }

  expect(): void {
    // All bytes are in memory already.
  }

  share(): void {
    // This class keeps no copies of bytes.
  }
}

/** Class of workers only, which the types of the page do not know. */
declare class FileReaderSync {
  readAsArrayBuffer(blob: Blob): ArrayBuffer;
}

/** A file that the user chose, or bytes that all workers have in common. */
export class FileBytes implements Bytes {
  readonly isDivisible = true;
  requests = 0;
  received = 0;
  private readonly reader = new FileReaderSync();
  private readonly pages: Pages;

  constructor(private readonly file: File) {
    this.pages = new Pages(file.size, (offset, length) => this.range(offset, length));
  }

  get name(): string {
    return this.file.name;
  }

  get length(): number {
    return this.file.size;
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
    try {
      const part = this.reader.readAsArrayBuffer(this.file.slice(offset, offset + length));
      this.requests += 1;
      this.received += length;
      return new Uint8Array(part);
    } catch (error) {
      throw new EngineError({
        kind: "not-found",
        message: `${this.name} cannot be read any more (${error instanceof Error ? error.message : String(error)})`,
        hint: "choose the file again: it was moved or changed",
      });
    }
  }
}
