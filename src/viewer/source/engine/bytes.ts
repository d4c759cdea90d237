// Bytes of an archive, wherever they are held, read by ranges without waiting: the engine asks in the middle of its work.

import { EngineError } from "./failure";

export interface Bytes {
  readonly name: string;
  readonly length: number;
  /** Fills `into` from a position; throws an EngineError if it cannot. */
  read(offset: number, into: Uint8Array): void;
  /** What was asked of others so far. */
  readonly requests: number;
  readonly received: number;
}

/** Bytes in memory. */
export class MemoryBytes implements Bytes {
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
}

/** Of workers only, which the types of the page do not know. */
declare class FileReaderSync {
  readAsArrayBuffer(blob: Blob): ArrayBuffer;
}

/** A file that the user chose. */
export class FileBytes implements Bytes {
  requests = 0;
  received = 0;
  private readonly reader = new FileReaderSync();

  constructor(private readonly file: File) {}

  get name(): string {
    return this.file.name;
  }

  get length(): number {
    return this.file.size;
  }

  read(offset: number, into: Uint8Array): void {
    try {
      const part = this.reader.readAsArrayBuffer(this.file.slice(offset, offset + into.length));
      into.set(new Uint8Array(part));
    } catch (error) {
      throw new EngineError({
        kind: "not-found",
        message: `${this.name} cannot be read any more (${error instanceof Error ? error.message : String(error)})`,
        hint: "choose the file again: it was moved or changed",
      });
    }
    this.requests += 1;
    this.received += into.length;
  }
}
