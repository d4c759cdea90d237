// The worker: takes calls, answers them by `Tasks`.

import { failureOf } from "./failure";
import type { Call, FromWorker, ToWorker } from "./messages";
import { Tasks } from "./tasks";
import type { ComfortAsk, MinutesAsk, MomentAsk, SumAsk, TileValues } from "./types";

interface Scope {
  onmessage: ((event: MessageEvent<ToWorker>) => void) | null;
  postMessage(message: FromWorker, transfer?: Transferable[]): void;
}

const scope = globalThis as unknown as Scope;
let tasks: Tasks | undefined;

/** Lets messages in that wait. */
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
  const onTile = (tile: TileValues): void =>
    scope.postMessage({ number, tile }, transferable(tile));
  const onDamage = (damaged: number, message: string): void => scope.postMessage({ number, damaged, message });
  switch (call) {
    case "moment":
      return tasks.moment(args[0] as MomentAsk, onTile, onDamage);
    case "sums":
      return tasks.sums(args[0] as SumAsk, onTile, onDamage);
    case "sunMinutes":
      return tasks.sunMinutes(args[0] as MinutesAsk, onTile, onDamage);
    case "comfort":
      return tasks.comfort(args[0] as ComfortAsk, onTile, onDamage);
    default: {
      const method = tasks[call] as (...args: unknown[]) => unknown;
      return await method.apply(tasks, args);
    }
  }
}

/** Memory of arrays that is given away with a message, each once. */
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
