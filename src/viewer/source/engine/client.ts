// The engine as the page calls it: everything runs in workers, calls are promises.

import type { Call, TileCall } from "./messages";
import { EnginePool } from "./pool";
import { EngineThread } from "./thread";
import type {
  Air, AirAsk, Changes, ClearSky, Clock, ComfortAsk, Fisheye, LightTexels, Matching, MinutesAsk, MomentAsk, Overview, People, ReceiverInfo, ReceiverAsk, ReceiverPlace,
  Scene, Series, Site, Source, SumAsk, Sun, TextureAsk, TileTextures, TileValues, Traffic, WeatherInfo,
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

type OnTile = (tile: TileValues) => void;
type OnDamage = (tile: number, message: string) => void;

export class Engine {
  private constructor(private readonly pool: EnginePool) {}

  /** Starts the engine in a worker of the script at an address; `workers`: as many in all, or else as many as suit the archive that is opened. */
  static async start(script: string, module: WebAssembly.Module, workers?: number): Promise<Engine> {
    const start = (): Promise<EngineThread> => EngineThread.start(script, module);
    return new Engine(new EnginePool(await start(), start, workers));
  }

  /** Who is told why a worker was lost beside the first, without which it goes on. */
  set onLost(listener: (error: unknown) => void) {
    this.pool.onLost = listener;
  }

  /**
   * Opens an archive. The former one is closed, and weather has to be loaded again. `beside`: the archive that it is shown with; one of another
   * site is refused.
   */
  open(source: Source, beside: Pick<Site, "place"> | null = null): Promise<Site> {
    const absolute = "url" in source ? { url: new URL(source.url, document.baseURI).href } : source;
    return this.pool.open(absolute, beside);
  }

  /** Which receivers of two archives are the same ones. */
  match(before: readonly ReceiverPlace[], after: readonly ReceiverPlace[]): Promise<Matching> {
    return this.call("match", [before, after]);
  }

  /** Ends the workers and lets go of their memory; what was asked fails. */
  close(): void {
    this.pool.end("the archive was closed");
  }

  /** What of asks for tiles is still to be begun comes in this order. */
  prefer(tiles: readonly number[]): void {
    this.pool.prefer(tiles);
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
    return this.pool.tell("loadWeather", [name, bytes, clock]);
  }

  /**
   * Takes a picture of clouds, of red, green, blue and opacity; of 0 pixels a side, takes it away. Resolves with how much each point of a map
   * hides, 0 to 255. It stands before the sky once it is turned.
   */
  clouds(side: number, levels: Uint8Array, map: number): Promise<Uint8Array> {
    return this.pool.tell("clouds", [side, levels, map], ["turnClouds"]);
  }

  /** Puts the picture before the sky, with its top at an azimuth, or takes it away from there. */
  turnClouds(top: number | null): Promise<void> {
    return this.pool.tell("turnClouds", [top]);
  }

  /** At the place and by the clock of the weather file, or else of the site. */
  sun(dayOfYear: number, minutes: number): Promise<Sun> {
    return this.call("sun", [dayOfYear, minutes]);
  }

  /** Under a clear sky at that time. */
  clear(dayOfYear: number, minutes: number): Promise<ClearSky> {
    return this.call("clear", [dayOfYear, minutes]);
  }

  /**
   * Tiles at one moment, about in the order asked for; false if a newer moment came before all were done. Damaged tiles are told, the rest goes
   * on.
   */
  moment(ask: MomentAsk, onTile: OnTile, onDamage: OnDamage): Promise<boolean> {
    return this.values("moment", ask, onTile, onDamage);
  }

  /** The light of a moment for the graphics card; tiles do not matter. */
  light(ask: MomentAsk): Promise<LightTexels> {
    return this.call("light", [ask]);
  }

  /** Tiles for the graphics card, for moments with `Light` of kind `sun`, likewise. */
  textures({ tiles, ...ask }: TextureAsk, onTile: (tile: TileTextures) => void, onDamage: OnDamage): Promise<boolean> {
    return this.pool.tiles("textures", ask, tiles, { onTile: (tile) => onTile(tile as TileTextures), onDamage });
  }

  /** Sums over the weather file, likewise. */
  sums(ask: SumAsk, onTile: OnTile, onDamage: OnDamage): Promise<boolean> {
    return this.values("sums", ask, onTile, onDamage);
  }

  /** Minutes of sun on a day, likewise. */
  sunMinutes(ask: MinutesAsk, onTile: OnTile, onDamage: OnDamage): Promise<boolean> {
    return this.values("sunMinutes", ask, onTile, onDamage);
  }

  /** Whether the receivers are people, and what can be asked of them. */
  async people(): Promise<People> {
    const people = await this.call<People>("people", []);
    if (people.count > 0) this.pool.stayAlone();
    return people;
  }

  /** What is known of the air of a moment. */
  air(air: AirAsk): Promise<Air> {
    return this.call("air", [air]);
  }

  /** What people feel, likewise; each receiver gets the numbers of its point. */
  comfort(ask: ComfortAsk, onTile: OnTile, onDamage: OnDamage): Promise<boolean> {
    return this.values("comfort", ask, onTile, onDamage);
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

  /** Of all workers together. */
  async traffic(): Promise<Traffic> {
    const each = await this.pool.all<Traffic>("traffic");
    return each.reduce((a, b) => ({ requests: a.requests + b.requests, bytes: a.bytes + b.bytes, memory: a.memory + b.memory }));
  }

  private call<T>(call: Call, args: unknown[]): Promise<T> {
    return this.pool.first.call(call, args);
  }

  /** Values of tiles, by all workers. */
  private values(call: Exclude<TileCall, "textures">, ask: { tiles: number[] }, onTile: OnTile, onDamage: OnDamage): Promise<boolean> {
    const { tiles, ...rest } = ask;
    // The planes of a person may lie in several tiles, which one worker has to have.
    return this.pool.tiles(call, rest, tiles, { onTile: (tile) => onTile(tile as TileValues), onDamage }, call === "comfort");
  }
}
