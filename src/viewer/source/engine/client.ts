// The engine as the page calls it: all work runs in workers, and calls return promises.

import type { Call, TileCall } from "./messages";
import { EnginePool } from "./pool";
import { EngineThread } from "./thread";
import type {
  Air, AirAsk, Changes, ClearSky, ComfortAsk, Fisheye, LightTexels, Matching, MinutesAsk, MomentAsk, Overview, People, ReceiverInfo, ReceiverAsk, ReceiverPlace,
  Scene, Series, Site, Source, SumAsk, Sun, TextureAsk, TileTextures, TileValues, Traffic, WeatherInfo,
} from "./types";
import type { WeatherOptions } from "./options";

export { EngineError } from "./failure";
export type { Kind } from "./failure";
export { NO_PARTNER } from "./types";
export type {
  Air, AirAsk, Changes, ClearSky, ComfortAsk, Fisheye, Group, Light, LightTexels, Matching, Material, MomentAsk, Overview, People, ReceiverInfo, ReceiverAsk,
  ReceiverPlace, Scene, Series, Site, SitePlace, Sky, Source, Span, Stress, SumAsk, Sun, TileTextures, TileValues, Traffic, Vector, WeatherInfo,
} from "./types";

/** Nothing is changed. */
export const UNCHANGED: Changes = { reflectance: [], transmittance: [] };

type OnTile = (tile: TileValues) => void;
type OnDamage = (tile: number, message: string) => void;

export class Engine {
  private constructor(private readonly pool: EnginePool) {}

  /**
   * Starts the engine in a worker of the script at an address. `workers` is the number of workers
   * in all; by default it depends on the archive that is opened.
   */
  static async start(script: string, module: WebAssembly.Module, workers?: number): Promise<Engine> {
    const start = (): Promise<EngineThread> => EngineThread.start(script, module);
    return new Engine(new EnginePool(await start(), start, workers));
  }

  /**
   * Sets the listener for the loss of a worker other than the first, without which the engine goes
   * on.
   */
  set onLost(listener: (error: unknown) => void) {
    this.pool.onLost = listener;
  }

  /**
   * Opens an archive. The former one is closed, and weather has to be loaded again. `beside` is the
   * archive that it is shown with; an archive of another site is refused.
   */
  open(source: Source, beside: Pick<Site, "place"> | null = null): Promise<Site> {
    const absolute = "url" in source ? { url: new URL(source.url, document.baseURI).href } : source;
    return this.pool.open(absolute, beside);
  }

  /** Finds the receivers that two archives have in common. */
  match(before: readonly ReceiverPlace[], after: readonly ReceiverPlace[]): Promise<Matching> {
    return this.call("match", [before, after]);
  }

  /** Ends the workers and frees their memory. Calls under way fail. */
  close(): void {
    this.pool.end("the archive was closed");
  }

  /** Sets the order of tiles for all queries: tiles that are not begun yet come in this order. */
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

  /** Loads a weather file, packed with gzip or not. */
  loadWeather(name: string, bytes: ArrayBuffer, options: WeatherOptions = {}): Promise<WeatherInfo> {
    return this.pool.tell("loadWeather", [name, bytes, options]);
  }

  /**
   * Takes a picture of clouds, of red, green, blue and opacity; a picture of 0 pixels a side
   * removes it. Resolves with the hidden share at each point of a map, 0 to 255. The picture stands
   * before the sky once it is turned.
   */
  clouds(side: number, levels: Uint8Array, map: number): Promise<Uint8Array> {
    return this.pool.tell("clouds", [side, levels, map], ["turnClouds"]);
  }

  /** Puts the picture before the sky, with its top at an azimuth, or removes it from there. */
  turnClouds(top: number | null): Promise<void> {
    return this.pool.tell("turnClouds", [top]);
  }

  /**
   * Returns the position of the sun, at the place and by the clock of the weather file, or else of
   * the site.
   */
  sun(dayOfYear: number, minutes: number): Promise<Sun> {
    return this.call("sun", [dayOfYear, minutes]);
  }

  /** Returns DNI and DHI under a clear sky at that time. */
  clear(dayOfYear: number, minutes: number): Promise<ClearSky> {
    return this.call("clear", [dayOfYear, minutes]);
  }

  /**
   * Computes tiles at one moment, about in the order asked for. Resolves with false if a newer
   * moment came before all were done. Damaged tiles are reported, and the others go on.
   */
  moment(ask: MomentAsk, onTile: OnTile, onDamage: OnDamage): Promise<boolean> {
    return this.values("moment", ask, onTile, onDamage);
  }

  /** Returns the light of a moment for the graphics card; its tiles do not matter. */
  light(ask: MomentAsk): Promise<LightTexels> {
    return this.call("light", [ask]);
  }

  /**
   * Computes tiles for the graphics card, for moments with `Light` of kind `sun`; resolves as
   * `moment` does.
   */
  textures({ tiles, ...ask }: TextureAsk, onTile: (tile: TileTextures) => void, onDamage: OnDamage): Promise<boolean> {
    return this.pool.tiles("textures", ask, tiles, { onTile: (tile) => onTile(tile as TileTextures), onDamage });
  }

  /** Computes sums over the weather file; resolves as `moment` does. */
  sums(ask: SumAsk, onTile: OnTile, onDamage: OnDamage): Promise<boolean> {
    return this.values("sums", ask, onTile, onDamage);
  }

  /** Computes minutes of sun on a day; resolves as `moment` does. */
  sunMinutes(ask: MinutesAsk, onTile: OnTile, onDamage: OnDamage): Promise<boolean> {
    return this.values("sunMinutes", ask, onTile, onDamage);
  }

  /**
   * Returns the people of the archive, if its receivers are people, and the numbers that they have.
   */
  async people(): Promise<People> {
    const people = await this.call<People>("people", []);
    if (people.count > 0) this.pool.stayAlone();
    return people;
  }

  /** Returns the known values of the air of a moment. */
  air(air: AirAsk): Promise<Air> {
    return this.call("air", [air]);
  }

  /**
   * Computes the comfort of people; resolves as `moment` does. Each receiver gets the numbers of
   * its point.
   */
  comfort(ask: ComfortAsk, onTile: OnTile, onDamage: OnDamage): Promise<boolean> {
    return this.values("comfort", ask, onTile, onDamage);
  }

  /** Returns sums of one receiver by month. */
  months(ask: ReceiverAsk): Promise<Series> {
    return this.call("months", [ask]);
  }

  /** Returns the hours of a day of one receiver. */
  day(ask: ReceiverAsk & { dayOfYear: number }): Promise<Series> {
    return this.call("day", [ask]);
  }

  fisheye(ask: { tile: number; row: number; side: number }): Promise<Fisheye> {
    return this.call("fisheye", [ask]);
  }

  /** Returns the traffic of all workers together. */
  async traffic(): Promise<Traffic> {
    const each = await this.pool.all<Traffic>("traffic");
    return each.reduce((a, b) => ({ requests: a.requests + b.requests, bytes: a.bytes + b.bytes, memory: a.memory + b.memory }));
  }

  private call<T>(call: Call, args: unknown[]): Promise<T> {
    return this.pool.first.call(call, args);
  }

  /** Computes values of tiles with all workers. */
  private values(call: Exclude<TileCall, "textures">, ask: { tiles: number[] }, onTile: OnTile, onDamage: OnDamage): Promise<boolean> {
    const { tiles, ...rest } = ask;
    // The planes of a person may lie in several tiles, and one worker needs all of them.
    return this.pool.tiles(call, rest, tiles, { onTile: (tile) => onTile(tile as TileValues), onDamage }, call === "comfort");
  }
}
