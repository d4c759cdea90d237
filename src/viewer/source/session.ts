// One opened archive: its tiles as they arrive, names of receivers, weather. In: the engine. Out:
// plain arrays by receiver.

import { cloudsOf, type CloudPicture, type Clouds } from "./clouds";
import type { Changes, Engine, Group, Overview, People, ReceiverInfo, Site, Vector, WeatherInfo } from "./engine/client";
import type { Place, State } from "./state";
import type { View } from "./view/stage";

export interface Tile {
  /** Row in the archive of the tile's first receiver. */
  first: number;
  count: number;
  /** Middle of its receivers, m from the origin of the page; none where it could not be read. */
  middle: [number, number, number] | null;
  /** Radius of a sphere about the middle that holds the middles of all its receivers, m. */
  radius: number;
}

/** A name that changes take, with what it changes. */
export function nameOf({ kind, name }: Pick<Group, "kind" | "name">): string {
  return `${kind} ${name}`;
}

/** Classes of surfaces, which every archive knows. */
const CLASSES: readonly string[] = ["ground", "obstruction"];

/** Names that changes take in one archive and not in another. */
export function namesBeyond(site: Site, other: Site): ReadonlySet<string> {
  const known = new Set(other.groups.map(nameOf));
  return new Set(site.groups.filter(({ name }) => !CLASSES.includes(name)).map(nameOf).filter((name) => !known.has(name)));
}

/**
 * Number of overviews under way at once: enough to hide the time of messages to the worker and
 * back.
 */
const AHEAD = 16;

/** Number of neighbouring tiles of the archive that are read together. */
const NEIGHBOURS = 16;

export class Session {
  readonly tiles: Tile[] = [];
  /** Sky view by receiver; NaN until read. */
  readonly skyView: Float32Array;
  readonly reference: Float32Array;
  /** x, y, z by receiver, m from the origin of the page. */
  readonly middles: Float32Array;
  /**
   * Place of the scene's origin on the page, m. It is not in the page's middle if another archive
   * was open first.
   */
  readonly shift: Vector;
  /** The overviews of all tiles are read. */
  ready = false;
  /** True once another archive is open: then the session asks nothing any more. */
  closed = false;
  weather: WeatherInfo | null = null;
  /** People of an archive of people. */
  people: People | null = null;
  /** The picture that its engine has. */
  clouds: Clouds | null = null;
  /** Names that changes take and only the other archive has, by `nameOf`. */
  foreign: ReadonlySet<string> = new Set();
  /** Azimuth of the top of the clouds in the engine. */
  private turned: number | null = null;
  private readonly tables = new Map<number, Promise<ReceiverInfo[]>>();

  /**
   * `first` is the session that was open before this one was put beside it. Its engine says where
   * the sun stands for both.
   */
  constructor(
    readonly engine: Engine,
    readonly site: Site,
    private readonly first: Session | null = null,
  ) {
    const origin = first?.site.origin ?? site.origin;
    this.shift = [site.origin[0] - origin[0], site.origin[1] - origin[1], site.origin[2] - origin[2]];
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
        this.tiles.push({ first, count, middle: null, radius: 0 });
        onDamage(tile, error);
        first += count;
        continue;
      }
      const count = overview.sky.length;
      this.skyView.set(overview.sky, first);
      this.reference.set(overview.reference, first);
      const middle: Vector = [0, 0, 0];
      overview.middle.forEach((metres, at) => {
        const onPage = metres + this.shift[at % 3]!;
        this.middles[3 * first + at] = onPage;
        middle[at % 3]! += onPage / count;
      });
      const middles = this.middles.subarray(3 * first, 3 * (first + count));
      let radius = 0;
      for (let at = 0; at < 3 * count; at += 3) radius = Math.max(radius, Math.hypot(...middle.map((metres, axis) => middles[at + axis]! - metres)));
      this.tiles.push({ first, count, middle, radius });
      onTile(tile, overview);
      first += count;
    }
    this.ready = true;
  }

  /** Finds out whether the receivers are people; a damaged archive has none. */
  async readPeople(): Promise<void> {
    try {
      const people = await this.engine.people();
      this.people = people.count > 0 ? people : null;
    } catch {
      // Queries for the values report the damage.
    }
  }

  /** Engine that says where the sun stands. */
  get suns(): Engine {
    return this.first?.engine ?? this.engine;
  }

  /** Changes of the state, but those of names that only the other archive has. */
  changes({ reflectance, transmittance }: State): Changes {
    const own = (kind: Group["kind"], changes: Readonly<Record<string, number>>): [string, number][] =>
      Object.entries(changes).filter(([name]) => !this.foreign.has(nameOf({ kind, name })));
    return { reflectance: own("opaque", reflectance), transmittance: own("canopy", transmittance) };
  }

  /** Gives a picture of clouds to the engine, in place of the former; none takes that away. */
  async takeClouds(picture: CloudPicture | null): Promise<void> {
    if (!picture && !this.clouds) return;
    this.clouds = this.turned = null;
    if (picture) this.clouds = await cloudsOf(this.engine, picture);
    else await this.engine.clouds(0, new Uint8Array(), 0);
  }

  /** Lets the engine have its clouds as a state has them, before it is asked for light. */
  turnClouds(state: State): void {
    const top = this.cloudsTop(state);
    if (top === this.turned) return;
    this.turned = top;
    // The next query reports the engine's error.
    this.engine.turnClouds(top).catch(() => undefined);
  }

  /**
   * Returns the azimuth of the top of the clouds before the sky, or null if there are no clouds.
   */
  cloudsTop({ clouds }: State): number | null {
    return this.clouds && clouds;
  }

  /**
   * Returns tiles in the order of queries, and how many are in view. Tiles in view come first, by
   * neighbours in the archive, the nearest to the target first.
   */
  tilesInOrder({ target, isSeen }: View): { tiles: number[]; seen: number } {
    const [seen, others]: [Map<number, number[]>, Map<number, number[]>] = [new Map(), new Map()];
    for (const tile of this.tilesNear(target)) {
      const { middle = null, radius = 0 } = this.tiles[tile] ?? {};
      const found = middle && isSeen(middle, radius) ? seen : others;
      const neighbours = Math.floor(tile / NEIGHBOURS);
      found.set(neighbours, [...(found.get(neighbours) ?? []), tile]);
    }
    const inOrder = (found: number[]): number[] => found.sort((a, b) => a - b);
    const first = [...seen.values()].flatMap(inOrder);
    return { tiles: [...first, ...[...others.values()].flatMap(inOrder)], seen: first.length };
  }

  /** Returns the tiles, those nearest to a point first. */
  tilesNear(point: readonly [number, number, number]): number[] {
    const distance = (tile: number): number => {
      const middle = this.tiles[tile]?.middle;
      return middle ? Math.hypot(middle[0] - point[0], middle[1] - point[1], middle[2] - point[2]) : Infinity;
    };
    const near = Array.from({ length: this.site.tiles }, (_, tile) => ({ tile, metres: distance(tile) }));
    near.sort((a, b) => (a.metres === b.metres ? a.tile - b.tile : a.metres - b.metres));
    return near.map(({ tile }) => tile);
  }

  /** Returns names, areas and places of the receivers of a tile; they are read once. */
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
