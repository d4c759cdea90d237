// The workers of an archive: the first answers every question, and helpers compute tiles beside it.
// In: queries for tiles. Out: their answers, from whichever worker has a tile or is free. A worker
// keeps the tiles that it made, so a tile stays with its first worker.

import { EngineError } from "./failure";
import type { Call, TileCall } from "./messages";
import { EngineThread, type Listener } from "./thread";
import type { Site, Source } from "./types";

/**
 * Number of tiles that a worker is given at a time. It is small, since the order of tiles may
 * change meanwhile.
 */
const PART = 8;

/** Number of parts that wait at a worker: the page may be busy with a picture when one is done. */
const AHEAD = 3;

/** Largest number of workers. Each takes some 50 MB besides its share of the common memory. */
const MOST = 4;

/** Number of tiles for which one more worker is worth its start. */
const WORTH = 32;

/** Query that is under way. */
interface Ask {
  /** Tiles that no worker was given yet, the next one first. */
  left: number[];
  /** True if the first worker computes all tiles. */
  readonly isAlone: boolean;
}

/** Archive that is open. */
interface Opened {
  source: Source;
  site: Site;
  /** Helpers; null until they are needed. */
  helpers: Promise<EngineThread | null>[] | null;
}

export class EnginePool {
  /** Called once for each helper that is lost; the others compute its tiles. */
  onLost: (error: unknown) => void = () => undefined;
  private opened: Opened | null = null;
  private helpers: EngineThread[] = [];
  /** First worker of each tile. */
  private owners = new Map<number, EngineThread>();
  /** Newest query of each kind, which supersedes those before. */
  private readonly asks = new Map<TileCall, Ask>();
  private turn = 0;
  /** Last call of each kind that a worker needs before it is asked. */
  private readonly told = new Map<Call, unknown[]>();

  /** `workers` is the number of workers; by default it depends on the processor and the archive. */
  constructor(
    readonly first: EngineThread,
    private readonly start: () => Promise<EngineThread>,
    private readonly workers: number | undefined,
  ) {}

  /** Opens an archive with the first worker; helpers open it when there is work for them. */
  async open(source: Source, beside: Pick<Site, "place"> | null): Promise<Site> {
    for (const ask of this.asks.values()) ask.left = [];
    this.turn += 1;
    const site = await this.first.call<Site>("open", [source, beside]);
    for (const helper of this.helpers) helper.end("another archive was opened");
    [this.helpers, this.owners] = [[], new Map()];
    this.told.clear();
    // All workers read one file, while bytes would be copied for each.
    const shared = "bytes" in source ? { file: new File([source.bytes], source.name) } : source;
    this.opened = { source: shared, site, helpers: null };
    return site;
  }

  end(why: string): void {
    this.opened = null;
    for (const thread of [this.first, ...this.helpers]) thread.end(why);
  }

  /** Starts no helpers for this archive from now on. */
  stayAlone(): void {
    if (this.opened) this.opened.helpers ??= [];
  }

  /**
   * Sends a call to all workers, also to those that start later. It replaces the last such call and
   * the last calls of `gone`.
   */
  async tell<T>(call: Call, args: unknown[], gone: Call[] = []): Promise<T> {
    const before = [...this.told];
    for (const other of [call, ...gone]) this.told.delete(other);
    this.told.set(call, args);
    // Helpers fail as the first worker does, which reports the failure.
    for (const helper of this.helpers) helper.call(call, args).catch(() => undefined);
    try {
      return await this.first.call<T>(call, args);
    } catch (error) {
      this.told.clear();
      for (const [other, its] of before) this.told.set(other, its);
      throw error;
    }
  }

  /** Calls every worker. */
  all<T>(call: Call): Promise<T[]> {
    return Promise.all([this.first, ...this.helpers].map((thread) => thread.call<T>(call, [])));
  }

  /** Sets the order of the tiles that no worker was given yet. */
  prefer(tiles: readonly number[]): void {
    const places = new Map(tiles.map((tile, place) => [tile, place]));
    const placeOf = (tile: number): number => places.get(tile) ?? tiles.length;
    for (const { left } of this.asks.values()) left.sort((a, b) => placeOf(a) - placeOf(b));
  }

  /**
   * Computes tiles in this order, as far as several workers keep one. Resolves with false if a
   * newer query of the kind came before all were done.
   */
  async tiles(call: TileCall, rest: object, tiles: readonly number[], listener: Listener, isAlone = false): Promise<boolean> {
    const turn = ++this.turn;
    const former = this.asks.get(call);
    if (former) former.left = [];
    const ask: Ask = { left: [...tiles], isAlone };
    this.asks.set(call, ask);
    const isNewest = (): boolean => this.asks.get(call) === ask;
    const give = (thread: EngineThread, part: number[], to: Listener): Promise<boolean> => thread.call(call, [{ ...rest, tiles: part }, turn], to);
    // An empty query supersedes those before, so workers stop their work.
    if (tiles.length === 0) return (await Promise.all([this.first, ...this.helpers].map((thread) => give(thread, [], listener)))).every(Boolean);
    const joined: Promise<boolean>[] = [];
    const work = async (thread: EngineThread): Promise<boolean> => {
      for (let part = this.take(ask, thread); part.length > 0; part = this.take(ask, thread)) {
        const missing = new Set(part);
        const to: Listener = {
          onTile: (tile) => (missing.delete(tile.tile), listener.onTile(tile)),
          onDamage: (tile, message) => (missing.delete(tile), listener.onDamage(tile, message)),
        };
        try {
          if (!(await give(thread, part, to))) return false;
        } catch (error) {
          const isLost = thread !== this.first && thread.ended !== null;
          if (!isLost || !isNewest()) ask.left = [];
          if (!isLost) throw error;
          ask.left.unshift(...missing);
          join(this.first);
        }
        if (!isNewest()) return false;
      }
      return true;
    };
    const join = (thread: EngineThread): void => {
      for (let place = 0; place < AHEAD; place++) {
        const working = work(thread);
        // The failure is reported where the result is awaited.
        working.catch(() => undefined);
        joined.push(working);
      }
    };
    join(this.first);
    const helpers = isAlone ? [] : tiles.length > PART ? this.startHelpers() : (this.opened?.helpers ?? []);
    for (const helper of helpers) void helper.then((thread) => thread && isNewest() && join(thread));
    // More workers may join while these are awaited.
    for (let place = 0; place < joined.length; place++) if (!(await joined[place]!)) return false;
    return true;
  }

  /**
   * Returns the next tiles of a query for a worker: tiles that it had before, and tiles that no
   * worker had.
   */
  private take(ask: Ask, thread: EngineThread): number[] {
    const part: number[] = [];
    if (thread.ended && thread !== this.first) return part;
    ask.left = ask.left.filter((tile) => {
      const owner = this.owners.get(tile) ?? thread;
      if (part.length === PART || (owner !== thread && !ask.isAlone)) return true;
      this.owners.set(tile, owner);
      part.push(tile);
      return false;
    });
    return part;
  }

  private startHelpers(): Promise<EngineThread | null>[] {
    const { opened } = this;
    if (!opened) return [];
    const suitable = Math.min(navigator.hardwareConcurrency, MOST, Math.floor(opened.site.tiles / WORTH));
    const workers = opened.site.isDivisible ? (this.workers ?? Math.max(1, suitable)) : 1;
    if (opened.helpers === null && workers > 1) this.first.call("share", [workers]).catch(() => undefined);
    return (opened.helpers ??= Array.from({ length: workers - 1 }, () => this.helper(opened, workers)));
  }

  /** Starts a helper. Resolves with null if that fails. */
  private async helper(opened: Opened, workers: number): Promise<EngineThread | null> {
    let thread: EngineThread | null = null;
    const isWanted = (): boolean => this.opened === opened;
    try {
      thread = await this.start();
      const { root, name } = await thread.call<Site>("open", [opened.source]);
      if (root !== opened.site.root) throw new EngineError({ kind: "network", message: `${name} has changed since it was opened`, hint: "load the page again" });
      await thread.call("share", [workers]);
      if (!isWanted()) throw new EngineError({ kind: "other", message: "another archive was opened", hint: "" });
      for (const [call, args] of this.told) thread.call(call, args).catch(() => undefined);
      const helper = thread;
      helper.onLost = () => this.lose(helper);
      this.helpers.push(helper);
      return helper;
    } catch (error) {
      thread?.end("the engine is of no use");
      if (isWanted()) this.onLost(error);
      return null;
    }
  }

  private lose(thread: EngineThread): void {
    if (!this.helpers.includes(thread)) return;
    this.helpers = this.helpers.filter((other) => other !== thread);
    for (const [tile, owner] of this.owners) if (owner === thread) this.owners.delete(tile);
    this.onLost(thread.ended);
  }
}
