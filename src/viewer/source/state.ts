// What the user has chosen, and who wants to know. All of it goes into the address and comes back from there (address.ts).

export type Show = "sky" | "reference" | "sunlight" | "glare" | "year" | "month" | "day" | "moment";
export type LightFrom = "weather" | "clear" | "overcast" | "own";
/** Which of two archives is shown, or what one has more than the other. */
export type Variant = "before" | "after" | "change";
export interface Place {
  tile: number;
  row: number;
  /** Of the archive after; else of the one before, or of the only one. */
  after?: true;
}

export interface State {
  show: Show;
  component: string;
  month: number;
  dayOfYear: number;
  minutes: number;
  /** Where the sun stands by: the clock, or its own angles. */
  sunBy: "clock" | "angles";
  azimuth: number;
  altitude: number;
  light: LightFrom;
  dni: number;
  dhi: number;
  /** Air of people where no weather file says: °C, %, m/s at 10 m. */
  air: number;
  humidity: number;
  wind: number;
  sky: string;
  /** Azimuth of the top of the picture of clouds, degrees; none: no clouds. */
  clouds: number | null;
  /** By name of a group; only what differs from the archive's values. */
  reflectance: Readonly<Record<string, number>>;
  transmittance: Readonly<Record<string, number>>;
  /** None: chosen from the values. */
  range: readonly [number, number] | null;
  /** Position and target, m from the scene's origin. */
  camera: readonly number[] | null;
  selected: Place | null;
  pinned: Place | null;
  /** Of an atlas. */
  part: string | null;
  /** Where two archives are open. */
  variant: Variant;
  /** Whether the change is shown in percent of what was before. */
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

  /** Returns how to stop. */
  subscribe(listener: Listener): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }
}

/** Hours of sun on a day, or minutes of sun in mirrors. */
export function isOfSun(show: Show): show is "sunlight" | "glare" {
  return show === "sunlight" || show === "glare";
}

export function isSum(show: Show): boolean {
  return show === "year" || show === "month" || show === "day";
}
