// Types that the page and the engine share. Angles are degrees, irradiances W/m2, sums kWh/m2. Only
// heliotile-core computes numbers.

/** Source of an archive. */
export type Source = { url: string } | { file: File } | { bytes: ArrayBuffer; name: string };

export interface Material {
  name: string;
  group: string;
  class: string;
  reflectance: number;
  changeable: boolean;
  canopy: boolean;
  transmittance: number | null;
  mirror: boolean;
}

/** Name that changes take, with the mean value of the materials that it stands for. */
export interface Group {
  name: string;
  kind: "opaque" | "canopy";
  value: number;
  materials: number;
}

export type Vector = [number, number, number];

export interface SitePlace {
  latitude: number;
  longitude: number;
  /** Angle of y from true north, degrees clockwise. */
  convergence: number;
  crs?: string;
}

export interface Site {
  name: string;
  root: string;
  formatVersion: string;
  creator: string;
  bytes: number;
  receivers: number;
  tiles: number;
  tileSize: number;
  /** Input coordinates of the scene's origin. */
  origin: Vector;
  /** Input coordinates. */
  bounds: [Vector, Vector];
  place: SitePlace | null;
  /** Azimuth of true north from +y, clockwise; 0 where it is not known. */
  northDeg: number;
  materials: Material[];
  groups: Group[];
  /** Columns of light; the last is the total. */
  components: string[];
  patches: number;
  accuracy: string | null;
  /** 0: the archive holds no triangles. */
  sceneChunks: number;
  hasReference: boolean;
  /** Names that `sky` takes. */
  skies: string[];
  /** Skies that no clouds can stand before. */
  cloudlessSkies: string[];
  /** True if more workers can read the archive without loading all of it. */
  isDivisible: boolean;
}

/** Name of a sky, as the option --sky takes it. */
export type Sky = string;

export type Light =
  | { kind: "weather"; hour: number }
  | { kind: "sun"; azimuth: number; altitude: number; dni: number; dhi: number };

export interface Changes {
  reflectance: [string, number][];
  transmittance: [string, number][];
}

export type Span =
  | { kind: "year" }
  | { kind: "month"; month: number }
  | { kind: "day"; dayOfYear: number };

export interface WeatherInfo {
  name: string;
  rows: number;
  /** Starts of the intervals. */
  labels: string[];
  month: Uint8Array;
  day: Uint8Array;
  /** Middle of the interval, minutes of the clock. */
  minutes: Uint16Array;
  dayOfYear: Uint16Array;
  dni: Float32Array;
  dhi: Float32Array;
  /** The sun at the middle of the interval. */
  azimuth: Float32Array;
  altitude: Float32Array;
  warnings: string[];
  latitude: number;
  longitude: number;
  zone: number;
  place: string;
}

export interface Scene {
  vertices: Float32Array;
  corners: Uint32Array;
  materials: Uint16Array;
}

/**
 * Places are relative to the scene's origin, metres, x east, y north, z up; row by row of a tile's
 * receivers.
 */
export interface Overview {
  middle: Float32Array;
  normal: Float32Array;
  points: Float32Array;
  corners: Uint32Array;
  /** Row of the receiver of each triangle. */
  owner: Uint32Array;
  sky: Float32Array;
  reference: Float32Array;
}

export interface ReceiverInfo {
  id: string;
  position: Vector;
  normal: Vector;
  area: number | null;
  surface: string | null;
  object: string;
  building: string;
  kind: string;
  objectType: string;
  face: string;
  tilt: number;
  /** Azimuth from true north. */
  azimuth: number;
  /** Shares of the hemisphere: sky, ground, obstructions. */
  views: Vector;
}

/** Properties by which a receiver is recognised in another archive. */
export type ReceiverPlace = Pick<ReceiverInfo, "id" | "position" | "normal">;

/** Receivers that two archives have in common. */
export interface Matching {
  /** [receiver after]: the receiver before; `NO_PARTNER` where there is none. */
  partners: Uint32Array;
  /** Pairs that only the name makes: the receiver stands elsewhere, or looks another way. */
  moved: number;
}

export const NO_PARTNER = 0xffffffff;

export interface Sun {
  azimuth: number;
  altitude: number;
}

/** Irradiances under a clear sky, W/m2. */
export interface ClearSky {
  dni: number;
  dhi: number;
}

export interface MomentAsk {
  light: Light;
  sky: Sky;
  changes: Changes;
  components: string[];
  tiles: number[];
}

/** A light for the graphics card, as the core's `moments` make it. */
export interface LightTexels {
  numbers: Float32Array;
  parts: number;
  reflected: [number, number];
  field: number;
  radiances: [number, number];
}

/** Query for tiles for the graphics card. */
export interface TextureAsk {
  changes: Changes;
  tiles: number[];
}

/** Tile for the graphics card. */
export interface TileTextures {
  tile: number;
  first: number;
  /** False if mirrors or canopies take part, so that the engine has to compute the tile. */
  served: boolean;
  /**
   * Texels of patches, response, groups of base texels; side of one, and words of the steps of one
   * in part.
   */
  shape: [number, number, number, number, number];
  words: Uint32Array;
  starts: Uint32Array;
}

export interface SumAsk {
  span: Span;
  sky: Sky;
  changes: Changes;
  components: string[];
  tiles: number[];
}

/** Query for the minutes of sun on a day. */
export interface MinutesAsk {
  dayOfYear: number;
  /** True for the sun in mirrors, false for the sun itself. */
  inMirrors: boolean;
  tiles: number[];
}

/** Numbers that an archive of people offers, and the receivers that stand for the people. */
export interface People {
  /** Points with six planes; 0: the receivers are no people. */
  count: number;
  /** Names of the numbers of a moment, and of a span of weather. */
  moment: string[];
  sums: string[];
  /** Classes of the UTCI, from cold to hot, each with its upper limit, °C; the last has none. */
  stress: Stress[];
  /** [receiver]: 1 for those that look up, one a point. */
  up: Uint8Array;
}

export interface Stress {
  name: string;
  to: number | null;
}

/**
 * The air of a moment: a row of the weather file, or °C, %, m/s at 10 m and tenths of the sky that
 * clouds hide.
 */
export type AirAsk =
  | { kind: "weather"; hour: number }
  | { kind: "own"; temperature: number; humidity: number; wind: number; cover: number };

/** Known values of the air; `sky` is its longwave irradiance, W/m2. */
export interface Air {
  temperature: number | null;
  humidity: number | null;
  wind: number | null;
  sky: number | null;
}

/** Query for comfort; `names` are the wanted numbers, of those that `People` offers. */
export type ComfortAsk = { sky: Sky; changes: Changes; names: readonly string[]; tiles: number[] } & (
  | { of: "moment"; light: Light; air: AirAsk }
  | { of: "span"; span: Span }
);

export interface TileValues {
  tile: number;
  /** Number of the tile's first receiver in the archive. */
  first: number;
  /** One array for each column asked for, with one value a receiver. */
  values: Float32Array[];
}

/** Results of queries that go tile by tile. */
export type Tile = TileValues | TileTextures;

export interface ReceiverAsk {
  tile: number;
  row: number;
  sky: Sky;
  changes: Changes;
}

/** Columns of one receiver: `[component][label]`. */
export interface Series {
  labels: string[];
  values: Float32Array[];
}

export interface Fisheye {
  side: number;
  /**
   * By rows from the top: 0 outside, 1 sky, 2 ground, 3 obstruction, 4 mirror, 5 canopy, 6 behind
   * the surface.
   */
  classes: Uint8Array;
  /**
   * Runs of the sun's paths above the horizon: pairs of x to the right and y up, -1 to 1. A label
   * may have several.
   */
  paths: { label: string; points: Float32Array }[];
}

export interface Traffic {
  /** Number of requests since the archive was opened. */
  requests: number;
  bytes: number;
  /** Memory of the engine, bytes. */
  memory: number;
}
