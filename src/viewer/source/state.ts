// The choices of the user, and their listeners. All of them go into the address and come back from
// there (address.ts).

export type Show = "sky" | "reference" | "sunlight" | "glare" | "year" | "month" | "day" | "moment";
export type LightFrom = "weather" | "clear" | "overcast" | "own";
/** Variant of two archives that is shown: one of them, or the change. */
export type Variant = "before" | "after" | "change";
export interface Place {
  tile: number;
  row: number;
  /** True for a receiver of the archive after; else it is of the one before, or of the only one. */
  after?: true;
}

export interface State {
  show: Show;
  component: string;
  month: number;
  dayOfYear: number;
  minutes: number;
  /** Source of the sun's position: the clock, or its own angles. */
  sunBy: "clock" | "angles";
  azimuth: number;
  altitude: number;
  light: LightFrom;
  dni: number;
  dhi: number;
  /** Air of people without a weather file: °C, %, m/s at 10 m. */
  air: number;
  humidity: number;
  wind: number;
  sky: string;
  /** Azimuth of the top of the picture of clouds, degrees; none: no clouds. */
  clouds: number | null;
  /** Changed values by name of a group; only values that differ from the archive's. */
  reflectance: Readonly<Record<string, number>>;
  transmittance: Readonly<Record<string, number>>;
  /** Range of the legend; null: chosen from the values. */
  range: readonly [number, number] | null;
  /** Position and target, m from the scene's origin. */
  camera: readonly number[] | null;
  selected: Place | null;
  pinned: Place | null;
  /** Part of an atlas. */
  part: string | null;
  /** Variant that is shown if two archives are open. */
  variant: Variant;
  /** True if the change is shown in percent of the value before. */
  percent: boolean;
}

export const DEFAULTS: Readonly<State> = {
  show: "reference",
  component: "total",
  month: 6,
  dayOfYear: 172,
  minutes: 720,
  sunBy: "clock",
  azimuth: 180,
  altitude: 45,
  light: "clear",
  dni: 800,
  dhi: 120,
  air: 25,
  humidity: 50,
  wind: 1,
  sky: "perez",
  clouds: null,
  reflectance: {},
  transmittance: {},
  range: null,
  camera: null,
  selected: null,
  pinned: null,
  part: null,
  variant: "before",
  percent: false,
};

type Listener = (changed: ReadonlySet<keyof State>) => void;

export class Store {
  readonly state: State = { ...DEFAULTS };
  private readonly listeners = new Set<Listener>();

  set(changes: Partial<State>): void {
    const changed = new Set<keyof State>();
    for (const key of Object.keys(changes) as (keyof State)[]) {
      if (JSON.stringify(this.state[key]) !== JSON.stringify(changes[key])) changed.add(key);
    }
    if (changed.size === 0) return;
    Object.assign(this.state, changes);
    for (const listener of this.listeners) listener(changed);
  }

  /** Adds a listener. Returns a function that removes it. */
  subscribe(listener: Listener): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }
}

/** Returns true for hours of sun on a day or minutes of sun in mirrors. */
export function isOfSun(show: Show): show is "sunlight" | "glare" {
  return show === "sunlight" || show === "glare";
}

export function isSum(show: Show): boolean {
  return show === "year" || show === "month" || show === "day";
}
