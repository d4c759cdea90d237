// One opened archive: its tiles as they arrive, names of receivers, weather. In: the engine. Out: plain arrays by receiver.

import type { Engine, Overview, ReceiverInfo, Site, WeatherInfo } from "./engine/client";
import type { Place } from "./state";

export interface Tile {
  /** Row in the archive of its first receiver. */
  first: number;
  count: number;
  /** Middle of its receivers, m from the scene's origin; none where it could not be read. */
  middle: [number, number, number] | null;
}

/** Overviews under way at once: enough to hide the way to the worker and back. */
const AHEAD = 16;

export class Session {
  readonly tiles: Tile[] = [];
  /** By receiver; NaN until read. */
  readonly skyView: Float32Array;
  readonly reference: Float32Array;
  /** x, y, z by receiver, m from the scene's origin. */
  readonly middles: Float32Array;
  /** Another archive is open: nothing is asked any more. */
  closed = false;
  weather: WeatherInfo | null = null;
  private readonly tables = new Map<number, Promise<ReceiverInfo[]>>();

  constructor(
    readonly engine: Engine,
    readonly site: Site,
  ) {
    this.skyView = new Float32Array(site.receivers).fill(NaN);
    this.reference = new Float32Array(site.receivers).fill(NaN);
    this.middles = new Float32Array(3 * site.receivers).fill(NaN);
  }

  /** Reads the overviews of all tiles, in their order. */
  async readTiles(onTile: (tile: number, overview: Overview) => void, onDamage: (tile: number, error: unknown) => void): Promise<void> {
    const { site } = this;
    const ask = (tile: number) => this.engine.overview(tile).then(
      (overview) => ({ overview, error: null }),
      (error: unknown) => ({ overview: null, error }),
    );
    const asked: ReturnType<typeof ask>[] = [];
    let first = 0;
    for (let tile = 0; tile < site.tiles; tile++) {
      while (asked.length < Math.min(site.tiles, tile + AHEAD)) asked.push(ask(asked.length));
      const { overview, error } = await asked[tile]!;
      if (this.closed) return;
      if (!overview) {
        const count = Math.min(site.tileSize, site.receivers - first);
        this.tiles.push({ first, count, middle: null });
        onDamage(tile, error);
        first += count;
        continue;
      }
      const count = overview.sky.length;
      this.skyView.set(overview.sky, first);
      this.reference.set(overview.reference, first);
      this.middles.set(overview.middle, 3 * first);
      const middle: [number, number, number] = [0, 0, 0];
      overview.middle.forEach((metres, at) => (middle[at % 3]! += metres / count));
      this.tiles.push({ first, count, middle });
      onTile(tile, overview);
      first += count;
    }
  }

  /** Tiles, those nearest to a point first. */
  tilesNear(point: readonly [number, number, number]): number[] {
    const distance = (tile: number): number => {
      const middle = this.tiles[tile]?.middle;
      return middle ? Math.hypot(middle[0] - point[0], middle[1] - point[1], middle[2] - point[2]) : Infinity;
    };
    const near = Array.from({ length: this.site.tiles }, (_, tile) => ({ tile, metres: distance(tile) }));
    near.sort((a, b) => (a.metres === b.metres ? a.tile - b.tile : a.metres - b.metres));
    return near.map(({ tile }) => tile);
  }

  /** Names, areas and places of the receivers of a tile; read once. */
  table(tile: number): Promise<ReceiverInfo[]> {
    let table = this.tables.get(tile);
    if (!table) {
      table = this.engine.receivers(tile);
      table.catch(() => this.tables.delete(tile));
      this.tables.set(tile, table);
    }
    return table;
  }

  indexOf(place: Place): number | null {
    const tile = this.tiles[place.tile];
    return tile && place.row < tile.count ? tile.first + place.row : null;
  }

  placeOf(index: number): Place | null {
    let [low, high] = [0, this.tiles.length];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.tiles[middle]!.first <= index) low = middle;
      else high = middle;
    }
    const tile = this.tiles[low];
    return tile && index >= tile.first && index < tile.first + tile.count ? { tile: low, row: index - tile.first } : null;
  }
}
