// One engine in WebAssembly with the bytes of its archive. In: requests. Out: values with their
// arrays, or an EngineError.

import type { Bytes } from "./bytes";
import { EngineError, type Kind } from "./failure";

type Numbers = Float32Array | Uint32Array | Uint16Array | Uint8Array;

/** An answer: its value, and its arrays by name. */
export interface Answer {
  value: unknown;
  arrays: Record<string, Numbers>;
  /** The memory of all arrays. */
  memory: ArrayBuffer;
}

interface Exports {
  memory: WebAssembly.Memory;
  request_buffer(length: number): number;
  bytes_buffer(length: number): number;
  answer_request(): number;
  text(): number;
  text_length(): number;
  arrays(): number;
  arrays_length(): number;
}

/** Failure of a request; `source` if the host could not provide bytes. */
interface Refusal {
  kind: Kind | "source";
  message: string;
  hint: string;
}

interface Told {
  value: unknown;
  arrays: [string, string, number, number][];
}

export class Wasm {
  private failed: unknown;

  private constructor(private readonly exports: Exports) {}

  /** Starts a fresh engine over some bytes. Its memory is freed with it. */
  static async start(module: WebAssembly.Module, bytes: Bytes): Promise<Wasm> {
    let wasm: Wasm | undefined;
    const read = (offset: number, to: number, length: number): number => {
      if (wasm === undefined) return 1;
      try {
        bytes.read(offset, new Uint8Array(wasm.exports.memory.buffer, to, length));
        return 0;
      } catch (error) {
        wasm.failed = error;
        return 1;
      }
    };
    const expect = (offset: number, length: number): void => {
      try {
        bytes.expect(offset, length);
      } catch {
        // `error` reports why the bytes cannot be read.
      }
    };
    const instance = await WebAssembly.instantiate(module, { host: { read, expect } });
    wasm = new Wasm(instance.exports as unknown as Exports);
    return wasm;
  }

  /** Bytes of the engine's memory. */
  get memory(): number {
    return this.exports.memory.buffer.byteLength;
  }

  call(request: Record<string, unknown>, bytes?: Uint8Array): Answer {
    const { exports } = this;
    const text = new TextEncoder().encode(JSON.stringify(request));
    const place = exports.request_buffer(text.length);
    new Uint8Array(exports.memory.buffer, place, text.length).set(text);
    if (bytes !== undefined) {
      const at = exports.bytes_buffer(bytes.length);
      new Uint8Array(exports.memory.buffer, at, bytes.length).set(bytes);
    }
    this.failed = undefined;
    const code = exports.answer_request();
    const told = JSON.parse(
      new TextDecoder().decode(new Uint8Array(exports.memory.buffer, exports.text(), exports.text_length())),
    ) as Told;
    if (code !== 0) throw this.error(told.value as Refusal);
    const [first, length] = [exports.arrays(), exports.arrays_length()];
    // This is a copy, since the next request writes there.
    const memory = exports.memory.buffer.slice(first, first + length) as ArrayBuffer;
    const arrays: Record<string, Numbers> = {};
    for (const [name, kind, at, count] of told.arrays) arrays[name] = numbers(kind, memory, at, count);
    return { value: told.value, arrays, memory };
  }

  /** Returns the error of a failure. Only the host knows why it could not provide bytes. */
  private error({ kind, message, hint }: Refusal): unknown {
    if (kind !== "source") return new EngineError({ kind, message, hint });
    return this.failed ?? new EngineError({ kind: "network", message, hint });
  }
}

function numbers(kind: string, memory: ArrayBuffer, at: number, count: number): Numbers {
  switch (kind) {
    case "f32":
      return new Float32Array(memory, at, count);
    case "u32":
      return new Uint32Array(memory, at, count);
    case "u16":
      return new Uint16Array(memory, at, count);
    default:
      return new Uint8Array(memory, at, count);
  }
}
