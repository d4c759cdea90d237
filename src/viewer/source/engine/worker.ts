// The worker: takes calls, answers them by `Tasks`.

import { failureOf } from "./failure";
import { isTileCall, type Call, type FromWorker, type ToWorker } from "./messages";
import { Tasks } from "./tasks";
import type { Tile } from "./types";

interface Scope {
  onmessage: ((event: MessageEvent<ToWorker>) => void) | null;
  postMessage(message: FromWorker, transfer?: Transferable[]): void;
}

const scope = globalThis as unknown as Scope;
let tasks: Tasks | undefined;

/** Channel that lets waiting messages in. */
const channel = new MessageChannel();
const waiting: (() => void)[] = [];
channel.port1.onmessage = () => waiting.shift()?.();
const pause = (): Promise<void> =>
  new Promise((resolve) => {
    waiting.push(resolve);
    channel.port2.postMessage(0);
  });

scope.onmessage = ({ data }) => {
  if ("module" in data) {
    tasks = new Tasks(data.module, pause);
    scope.postMessage({ ready: true });
    return;
  }
  const { number, call, args } = data;
  answer(number, call, args).then(
    (value) => scope.postMessage({ number, value }, transferable(value)),
    (error: unknown) => scope.postMessage({ number, failure: failureOf(error) }),
  );
};

async function answer(number: number, call: Call, args: unknown[]): Promise<unknown> {
  if (tasks === undefined) throw new Error("the engine has not started");
  const method = tasks[call] as (...args: unknown[]) => unknown;
  if (!isTileCall(call)) return await method.apply(tasks, args);
  const [ask, turn] = args;
  const onTile = (tile: Tile): void => scope.postMessage({ number, tile }, transferable(tile));
  const onDamage = (damaged: number, message: string): void => scope.postMessage({ number, damaged, message });
  return await method.apply(tasks, [ask, onTile, onDamage, turn]);
}

/** Returns the memory of arrays that is transferred with a message, each once. */
function transferable(value: unknown): ArrayBuffer[] {
  const found = new Set<ArrayBuffer>();
  const look = (part: unknown): void => {
    if (ArrayBuffer.isView(part)) {
      if (part.buffer instanceof ArrayBuffer) found.add(part.buffer);
    } else if (typeof part === "object" && part !== null) {
      Object.values(part).forEach(look);
    }
  };
  look(value);
  return [...found];
}
