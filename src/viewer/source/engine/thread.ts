// One worker of the browser with an engine in it. In: calls. Out: promises of their results. Once
// it has ended, calls fail.

import { EngineError } from "./failure";
import type { Call, FromWorker, ToWorker } from "./messages";
import type { Tile } from "./types";

/** Listener for tiles while a call is under way. */
export interface Listener {
  onTile(tile: Tile): void;
  onDamage(tile: number, message: string): void;
}

interface Pending extends Partial<Listener> {
  resolve(value: unknown): void;
  reject(error: EngineError): void;
}

export class EngineThread {
  /** Reason why the worker ended; null as long as it works. */
  ended: EngineError | null = null;
  /** Called if the worker ends by itself. */
  onLost: () => void = () => undefined;
  private readonly pending = new Map<number, Pending>();
  private last = 0;

  private constructor(private readonly worker: Worker) {}

  /** Starts an engine in a worker of the script at an address. */
  static async start(script: string, module: WebAssembly.Module): Promise<EngineThread> {
    const worker = new Worker(script);
    await new Promise<void>((resolve, reject) => {
      worker.onerror = (event) => reject(new EngineError({ kind: "other", message: `the engine does not start: ${event.message}`, hint: "" }));
      worker.onmessage = () => resolve();
      worker.postMessage({ module } satisfies ToWorker);
    });
    const thread = new EngineThread(worker);
    worker.onmessage = ({ data }: MessageEvent<FromWorker>) => thread.take(data);
    const lose = (why: string): void => {
      thread.end(`the engine stopped: ${why}`);
      thread.onLost();
    };
    worker.onerror = (event) => lose(event.message);
    worker.onmessageerror = () => lose("its answer cannot be read");
    return thread;
  }

  call<T>(call: Call, args: unknown[], listener: Partial<Listener> = {}): Promise<T> {
    if (this.ended) return Promise.reject(this.ended);
    const number = ++this.last;
    return new Promise<T>((resolve, reject) => {
      this.pending.set(number, { resolve: resolve as (value: unknown) => void, reject, ...listener });
      this.worker.postMessage({ number, call, args } satisfies ToWorker);
    });
  }

  /** Ends the worker and frees its memory. Calls under way fail. */
  end(why: string): void {
    this.worker.terminate();
    this.ended ??= new EngineError({ kind: "other", message: why, hint: "" });
    for (const { reject } of this.pending.values()) reject(this.ended);
    this.pending.clear();
  }

  private take(message: FromWorker): void {
    if ("ready" in message) return;
    const pending = this.pending.get(message.number);
    if (pending === undefined) return;
    if ("tile" in message) return pending.onTile?.(message.tile);
    if ("damaged" in message) return pending.onDamage?.(message.damaged, message.message);
    this.pending.delete(message.number);
    if ("failure" in message) pending.reject(new EngineError(message.failure));
    else pending.resolve(message.value);
  }
}
