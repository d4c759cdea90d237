// The engine as the page calls it: everything runs in one worker, calls are promises.

import { EngineError } from "./failure";
import type { Call, FromWorker, ToWorker } from "./messages";
import type {
  Air, AirAsk, Changes, ClearSky, Clock, ComfortAsk, Fisheye, LightTexels, Matching, MinutesAsk, MomentAsk, Overview, People, ReceiverInfo, ReceiverAsk, ReceiverPlace,
  Scene, Series, Site, Source, SumAsk, Sun, TileTextures, TileValues, Traffic, WeatherInfo,
} from "./types";

export { EngineError } from "./failure";
export type { Kind } from "./failure";
export { NO_PARTNER } from "./types";
export type {
  Air, AirAsk, Changes, ClearSky, Clock, ComfortAsk, Fisheye, Group, Light, LightTexels, Matching, Material, MomentAsk, Overview, People, ReceiverInfo, ReceiverAsk,
  ReceiverPlace, Scene, Series, Site, SitePlace, Sky, Source, Span, Stress, SumAsk, Sun, TileTextures, TileValues, Traffic, Vector, WeatherInfo,
} from "./types";

/** Nothing is changed. */
export const UNCHANGED: Changes = { reflectance: [], transmittance: [] };

interface Pending {
  resolve(value: unknown): void;
  reject(error: EngineError): void;
  onTile?: (tile: TileValues) => void;
  onDamage?: (tile: number, message: string) => void;
}

export class Engine {
  private readonly pending = new Map<number, Pending>();
  private last = 0;

  private constructor(private readonly worker: Worker) {}

  /** Starts the engine in a worker of the script at an address. */
  static async start(script: string, module: WebAssembly.Module): Promise<Engine> {
    const started = new Worker(script);
    const engine = new Engine(started);
    await new Promise<void>((resolve, reject) => {
      started.onerror = (event) =>
        reject(new EngineError({ kind: "other", message: `the engine does not start: ${event.message}`, hint: "" }));
      started.onmessage = () => resolve();
      started.postMessage({ module } satisfies ToWorker);
    });
    started.onmessage = ({ data }: MessageEvent<FromWorker>) => engine.take(data);
    started.onerror = (event) => engine.failAll(`the engine stopped: ${event.message}`);
    return engine;
  }

  /**
   * Opens an archive. The former one is closed, and weather has to be loaded again. `beside`: the archive that it is shown with; one of another
   * site is refused.
   */
  open(source: Source, beside: Pick<Site, "place"> | null = null): Promise<Site> {
    const absolute = "url" in source ? { url: new URL(source.url, document.baseURI).href } : source;
    return this.call("open", [absolute, beside]);
  }

  /** Which receivers of two archives are the same ones. */
  match(before: readonly ReceiverPlace[], after: readonly ReceiverPlace[]): Promise<Matching> {
    return this.call("match", [before, after]);
  }

  /** Ends the worker and lets go of its memory; what was asked fails. */
  close(): void {
    this.worker.terminate();
    this.failAll("the archive was closed");
  }

  scene(chunk: number): Promise<Scene> {
    return this.call("scene", [chunk]);
  }

  overview(tile: number): Promise<Overview> {
    return this.call("overview", [tile]);
  }

  receivers(tile: number): Promise<ReceiverInfo[]> {
    return this.call("receivers", [tile]);
  }

  /** A weather file, packed with gzip or not. */
  loadWeather(name: string, bytes: ArrayBuffer, clock: Clock = {}): Promise<WeatherInfo> {
    return this.call("loadWeather", [name, bytes, clock]);
  }

  /**
   * Takes a picture of clouds, of red, green, blue and opacity; of 0 pixels a side, takes it away. Resolves with how much each point of a map
   * hides, 0 to 255. It stands before the sky once it is turned.
   */
  clouds(side: number, levels: Uint8Array, map: number): Promise<Uint8Array> {
    return this.call("clouds", [side, levels, map]);
  }

  /** Puts the picture before the sky, with its top at an azimuth, or takes it away from there. */
  turnClouds(top: number | null): Promise<void> {
    return this.call("turnClouds", [top]);
  }

  /** At the place and by the clock of the weather file, or else of the site. */
  sun(dayOfYear: number, minutes: number): Promise<Sun> {
    return this.call("sun", [dayOfYear, minutes]);
  }

  /** Under a clear sky at that time. */
  clear(dayOfYear: number, minutes: number): Promise<ClearSky> {
    return this.call("clear", [dayOfYear, minutes]);
  }

  /** Tiles at one moment, in the order asked for; false if a newer moment came before all were done. Damaged tiles are told, the rest goes on. */
  moment(
    ask: MomentAsk, onTile: (tile: TileValues) => void, onDamage: (tile: number, message: string) => void,
  ): Promise<boolean> {
    return this.call("moment", [ask], { onTile, onDamage });
  }

  /** The light of a moment for the graphics card; tiles do not matter. */
  light(ask: MomentAsk): Promise<LightTexels> {
    return this.call("light", [ask]);
  }

  /** A tile for the graphics card, for moments with `Light` of kind `sun`. */
  textures(ask: { changes: Changes; tile: number; next: number[] }): Promise<TileTextures> {
    return this.call("textures", [ask]);
  }

  /** Sums over the weather file, likewise. */
  sums(ask: SumAsk, onTile: (tile: TileValues) => void, onDamage: (tile: number, message: string) => void): Promise<boolean> {
    return this.call("sums", [ask], { onTile, onDamage });
  }

  /** Minutes of sun on a day, likewise. */
  sunMinutes(ask: MinutesAsk, onTile: (tile: TileValues) => void, onDamage: (tile: number, message: string) => void): Promise<boolean> {
    return this.call("sunMinutes", [ask], { onTile, onDamage });
  }

  /** Whether the receivers are people, and what can be asked of them. */
  people(): Promise<People> {
    return this.call("people", []);
  }

  /** What is known of the air of a moment. */
  air(air: AirAsk): Promise<Air> {
    return this.call("air", [air]);
  }

  /** What people feel, likewise; each receiver gets the numbers of its point. */
  comfort(ask: ComfortAsk, onTile: (tile: TileValues) => void, onDamage: (tile: number, message: string) => void): Promise<boolean> {
    return this.call("comfort", [ask], { onTile, onDamage });
  }

  /** Sums of one receiver by month. */
  months(ask: ReceiverAsk): Promise<Series> {
    return this.call("months", [ask]);
  }

  /** The hours of a day of one receiver. */
  day(ask: ReceiverAsk & { dayOfYear: number }): Promise<Series> {
    return this.call("day", [ask]);
  }

  fisheye(ask: { tile: number; row: number; side: number }): Promise<Fisheye> {
    return this.call("fisheye", [ask]);
  }

  traffic(): Promise<Traffic> {
    return this.call("traffic", []);
  }

  private call<T>(call: Call, args: unknown[], tell: Pick<Pending, "onTile" | "onDamage"> = {}): Promise<T> {
    const number = ++this.last;
    return new Promise<T>((resolve, reject) => {
      this.pending.set(number, { resolve: resolve as (value: unknown) => void, reject, ...tell });
      this.worker.postMessage({ number, call, args } satisfies ToWorker);
    });
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

  private failAll(message: string): void {
    for (const { reject } of this.pending.values()) reject(new EngineError({ kind: "other", message, hint: "" }));
    this.pending.clear();
  }
}
