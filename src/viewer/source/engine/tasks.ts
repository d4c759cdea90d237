// The work of the worker, one task at a time. In: calls of the client. Out: their results. Long
// work goes tile by tile and lets messages in between, so that newer calls supersede it.

import { FileBytes, MemoryBytes, type Bytes } from "./bytes";
import { EngineError } from "./failure";
import type { TileCall } from "./messages";
import type {
  Air, AirAsk, ClearSky, ComfortAsk, Fisheye, LightTexels, Matching, MinutesAsk, MomentAsk, Overview, People, ReceiverInfo, ReceiverAsk, ReceiverPlace,
  Scene, Series, Site, Source, SumAsk, Sun, TextureAsk, TileTextures, TileValues, Traffic, WeatherInfo,
} from "./types";
import type { WeatherOptions } from "./options";
import { UrlBytes } from "./url";
import { Wasm, type Answer } from "./wasm";

/** Time after which work lets messages in, ms. */
const SLICE_MS = 12;

/**
 * Number of tiles that the engine is given ahead: it reads neighbours together, and solves for
 * their light together where it has to.
 */
const NEXT = 8;

export type OnTile = (tile: TileValues) => void;
export type OnTextures = (tile: TileTextures) => void;
export type OnDamage = (tile: number, message: string) => void;

export class Tasks {
  private wasm: Wasm | undefined;
  private bytes: Bytes | undefined;
  /** Columns of the open archive. */
  private components: string[] = [];
  /** Numbers of the last calls, which supersede those before. */
  private readonly newest = { moment: 0, textures: 0, sums: 0, sunMinutes: 0, comfort: 0, open: 0 };

  constructor(private readonly module: WebAssembly.Module, private readonly pause: () => Promise<void>) {}

  /**
   * Opens an archive in a fresh engine; if that succeeds the former one is forgotten, its weather
   * too.
   */
  async open(source: Source, beside: Pick<Site, "place"> | null = null): Promise<Site> {
    const turn = ++this.newest.open;
    this.newest.moment++;
    this.newest.textures++;
    this.newest.sums++;
    this.newest.sunMinutes++;
    this.newest.comfort++;
    const bytes = await bytesOf(source);
    const wasm = await Wasm.start(this.module, bytes);
    const { value } = wasm.call({ request: "open", name: bytes.name, bytes: bytes.length, beside });
    if (turn !== this.newest.open) throw new EngineError({ kind: "other", message: "another archive was opened", hint: "" });
    [this.wasm, this.bytes] = [wasm, bytes];
    const site = { ...(value as Omit<Site, "isDivisible">), isDivisible: bytes.isDivisible };
    this.components = site.components;
    return site;
  }

  /** Divides the memory for tiles by the number of workers. */
  share(workers: number): void {
    this.call({ request: "share", workers });
    this.bytes?.share(workers);
  }

  match(before: readonly ReceiverPlace[], after: readonly ReceiverPlace[]): Matching {
    const { value, arrays } = this.call({ request: "match", before, after });
    return { ...(value as { moved: number }), partners: arrays["partners"] as Uint32Array };
  }

  scene(chunk: number): Scene {
    return this.call({ request: "scene", chunk }).arrays as unknown as Scene;
  }

  overview(tile: number): Overview {
    return this.call({ request: "overview", tile }).arrays as unknown as Overview;
  }

  receivers(tile: number): ReceiverInfo[] {
    return this.call({ request: "receivers", tile }).value as ReceiverInfo[];
  }

  async loadWeather(name: string, bytes: ArrayBuffer, options: WeatherOptions = {}): Promise<WeatherInfo> {
    const unpacked = await unpack(bytes);
    const { value, arrays } = this.engine().call({ request: "loadWeather", name, options }, unpacked);
    return { ...(value as object), ...arrays } as unknown as WeatherInfo;
  }

  clouds(side: number, levels: Uint8Array, map: number): Uint8Array {
    return this.engine().call({ request: "clouds", side, map }, levels).arrays["hidden"] as Uint8Array;
  }

  turnClouds(top: number | null): void {
    this.call({ request: "turnClouds", top });
  }

  sun(dayOfYear: number, minutes: number): Sun {
    return this.call({ request: "sun", dayOfYear, minutes }).value as Sun;
  }

  clear(dayOfYear: number, minutes: number): ClearSky {
    return this.call({ request: "clear", dayOfYear, minutes }).value as ClearSky;
  }

  moment(ask: MomentAsk, onTile: OnTile, onDamage: OnDamage, turn?: number): Promise<boolean> {
    return this.values("moment", ask, ask.components, onTile, onDamage, turn);
  }

  light(ask: MomentAsk): LightTexels {
    const { value, arrays } = this.call({ request: "light", ask });
    return { ...(value as Omit<LightTexels, "numbers">), numbers: arrays["numbers"] as Float32Array };
  }

  textures({ tiles, changes }: TextureAsk, onTile: OnTextures, onDamage: OnDamage, turn?: number): Promise<boolean> {
    const made = (tile: number, { value, arrays }: Answer): void =>
      onTile({ tile, ...(value as Omit<TileTextures, "tile" | "words" | "starts">), words: arrays["words"] as Uint32Array, starts: arrays["starts"] as Uint32Array });
    return this.each("textures", { changes }, tiles, made, onDamage, turn);
  }

  sums(ask: SumAsk, onTile: OnTile, onDamage: OnDamage, turn?: number): Promise<boolean> {
    return this.values("sums", ask, ask.components, onTile, onDamage, turn);
  }

  sunMinutes(ask: MinutesAsk, onTile: OnTile, onDamage: OnDamage, turn?: number): Promise<boolean> {
    return this.values("sunMinutes", ask, ["minutes"], onTile, onDamage, turn);
  }

  people(): People {
    const { value, arrays } = this.call({ request: "people" });
    return { ...(value as Omit<People, "up">), up: arrays["up"] as Uint8Array };
  }

  air(air: AirAsk): Air {
    return this.call({ request: "air", air }).value as Air;
  }

  comfort({ names, ...ask }: ComfortAsk, onTile: OnTile, onDamage: OnDamage, turn?: number): Promise<boolean> {
    return this.values("comfort", ask, names, onTile, onDamage, turn);
  }

  months(ask: ReceiverAsk): Series {
    return this.series(this.call({ request: "months", ...ask }));
  }

  day(ask: ReceiverAsk & { dayOfYear: number }): Series {
    return this.series(this.call({ request: "day", ...ask }));
  }

  fisheye(ask: { tile: number; row: number; side: number }): Fisheye {
    const { value, arrays } = this.call({ request: "fisheye", ...ask });
    const { side, paths } = value as { side: number; paths: [string, number, number][] };
    const points = arrays["points"] as Float32Array;
    const path = ([label, first, count]: [string, number, number]) => ({ label, points: points.slice(first, first + count) });
    return { side, classes: arrays["classes"] as Uint8Array, paths: paths.map(path) };
  }

  traffic(): Traffic {
    const { bytes, wasm } = this;
    return { requests: bytes?.requests ?? 0, bytes: bytes?.received ?? 0, memory: wasm?.memory ?? 0 };
  }

  private values(
    request: TileCall, { tiles, ...ask }: { tiles: number[] }, columns: readonly string[], onTile: OnTile, onDamage: OnDamage, turn?: number,
  ): Promise<boolean> {
    const made = (tile: number, { value, arrays }: Answer): void =>
      onTile({ tile, first: (value as { first: number }).first, values: columns.map((name) => arrays[name] as Float32Array) });
    return this.each(request, { ask }, tiles, made, onDamage, turn);
  }

  /**
   * Computes the tiles of a request one after the other, until a request of a later turn comes.
   * Several requests of one turn go side by side.
   */
  private async each(
    request: TileCall, rest: object, tiles: number[], made: (tile: number, answer: Answer) => void, onDamage: OnDamage, turn = this.newest[request] + 1,
  ): Promise<boolean> {
    this.newest[request] = Math.max(turn, this.newest[request]);
    // Sums are slow to begin: if several wait, as behind a slider, only the newest begins.
    if (request === "sums" || request === "comfort") await this.pause();
    if (turn !== this.newest[request]) return false;
    let started = performance.now();
    for (const [place, tile] of tiles.entries()) {
      try {
        made(tile, this.call({ request, ...rest, tile, next: tiles.slice(place + 1, place + NEXT) }));
      } catch (error) {
        if (!(error instanceof EngineError) || error.kind !== "damaged") throw error;
        onDamage(tile, error.message);
      }
      if (performance.now() - started > SLICE_MS) {
        await this.pause();
        started = performance.now();
      }
      if (turn !== this.newest[request]) return false;
    }
    return true;
  }

  private series({ value, arrays }: Answer): Series {
    const { labels } = value as { labels: string[] };
    return { labels, values: this.components.map((name) => arrays[name] as Float32Array) };
  }

  private engine(): Wasm {
    if (this.wasm === undefined) throw new EngineError({ kind: "other", message: "no archive is open", hint: "" });
    return this.wasm;
  }

  private call(request: Record<string, unknown>): Answer {
    return this.engine().call(request);
  }
}

async function bytesOf(source: Source): Promise<Bytes> {
  if ("url" in source) return UrlBytes.open(source.url);
  if ("file" in source) return new FileBytes(source.file);
  return new MemoryBytes(source.name, source.bytes);
}

/** Unpacks gzip. */
async function unpack(bytes: ArrayBuffer): Promise<Uint8Array> {
  const [first, second] = new Uint8Array(bytes, 0, Math.min(2, bytes.byteLength));
  if (first !== 0x1f || second !== 0x8b) return new Uint8Array(bytes);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
