// State <-> the part of the address behind `#`, so that an address gives the same view again.

import { DEFAULTS, type Place, type Show, type State, type Store, type Variant } from "./state";

const SHOWS: readonly string[] = ["sky", "reference", "sunlight", "glare", "year", "month", "day", "moment"] satisfies Show[];
const LIGHTS: readonly string[] = ["weather", "clear", "overcast", "own"];
const VARIANTS: readonly string[] = ["before", "after", "change"] satisfies Variant[];
/** Prefix of the place of a receiver of the archive after. */
const AFTER = "after.";
/** Bounds of what the address may set. */
const NUMBERS = {
  month: [1, 12], dayOfYear: [1, 366], minutes: [0, 1439], azimuth: [0, 360], clouds: [0, 359], altitude: [-90, 90], dni: [0, 1500], dhi: [0, 1500], air: [-40, 50], humidity: [1, 100], wind: [0, 17],
} as const;

function list(text: string, count: number): number[] | null {
  const numbers = text.split(",").map(Number);
  return numbers.length === count && numbers.every(Number.isFinite) ? numbers : null;
}

function changes(parameters: URLSearchParams, key: string): Record<string, number> {
  const found: Record<string, number> = {};
  for (const text of parameters.getAll(key)) {
    const cut = text.lastIndexOf("=");
    const value = Number(text.slice(cut + 1));
    if (cut > 0 && value >= 0 && value <= 1) found[text.slice(0, cut)] = value;
  }
  return found;
}

function place(text: string | null): Place | null {
  const after = text?.startsWith(AFTER) ?? false;
  const numbers = text === null ? null : list(text.slice(after ? AFTER.length : 0).replace(".", ","), 2);
  if (!numbers) return null;
  const [tile = -1, row = -1] = numbers;
  if (!Number.isInteger(tile) || !Number.isInteger(row) || tile < 0 || row < 0) return null;
  return after ? { tile, row, after } : { tile, row };
}

function formatPlace({ tile, row, after }: Place): string {
  return `${after ? AFTER : ""}${tile}.${row}`;
}

/**
 * Returns the parts of a state that the text after `#` holds; unknown and invalid parts are left
 * out.
 */
export function parseAddress(hash: string): Partial<State> {
  const parameters = new URLSearchParams(hash.replace(/^#/, ""));
  const found: Partial<State> = {};
  const text = (key: string) => parameters.get(key);
  const show = text("show");
  if (show !== null && SHOWS.includes(show)) found.show = show as Show;
  const light = text("light");
  if (light !== null && LIGHTS.includes(light)) found.light = light as State["light"];
  const by = text("sun");
  if (by === "clock" || by === "angles") found.sunBy = by;
  // Hours of a weather file and clear skies go by the clock.
  if (light === "weather" || light === "clear") found.sunBy = "clock";
  for (const key of Object.keys(NUMBERS) as (keyof typeof NUMBERS)[]) {
    const value = Number(text(key) ?? "no");
    if (value >= NUMBERS[key][0] && value <= NUMBERS[key][1]) found[key] = value;
  }
  const component = text("component");
  if (component) found.component = component;
  const sky = text("sky");
  if (sky) found.sky = sky;
  const range = list(text("range") ?? "", 2);
  if (range && range[0]! < range[1]!) found.range = [range[0]!, range[1]!];
  const camera = list(text("camera") ?? "", 6);
  if (camera) found.camera = camera;
  if (parameters.has("reflectance")) found.reflectance = changes(parameters, "reflectance");
  if (parameters.has("transmittance")) found.transmittance = changes(parameters, "transmittance");
  const selected = place(text("receiver"));
  if (selected) found.selected = selected;
  const pinned = place(text("pinned"));
  if (pinned) found.pinned = pinned;
  const part = text("part");
  if (part) found.part = part;
  const variant = text("variant");
  if (variant !== null && VARIANTS.includes(variant)) found.variant = variant as Variant;
  if (parameters.has("percent")) found.percent = true;
  return found;
}

/**
 * Returns the part of the address that holds a state: only the values that differ from the initial
 * state.
 */
export function formatAddress(state: State): string {
  const parameters = new URLSearchParams();
  if (state.part !== null) parameters.set("part", state.part);
  if (state.variant !== DEFAULTS.variant) parameters.set("variant", state.variant);
  if (state.percent) parameters.set("percent", "");
  parameters.set("show", state.show);
  if (state.component !== DEFAULTS.component) parameters.set("component", state.component);
  parameters.set("light", state.light);
  parameters.set("sun", state.sunBy);
  for (const key of Object.keys(NUMBERS) as (keyof typeof NUMBERS)[]) {
    if (state[key] !== DEFAULTS[key]) parameters.set(key, String(state[key]));
  }
  if (state.sky !== DEFAULTS.sky) parameters.set("sky", state.sky);
  if (state.range) parameters.set("range", state.range.join(","));
  if (state.camera) parameters.set("camera", state.camera.map((metres) => Number(metres.toFixed(2))).join(","));
  for (const key of ["reflectance", "transmittance"] as const) {
    for (const [name, value] of Object.entries(state[key])) parameters.append(key, `${name}=${value}`);
  }
  if (state.selected) parameters.set("receiver", formatPlace(state.selected));
  if (state.pinned) parameters.set("pinned", formatPlace(state.pinned));
  return `#${parameters.toString().replaceAll("%2C", ",").replaceAll("%3A", ":")}`;
}

/**
 * Keeps the address up to date, a few times a second at most, and follows it when the user changes
 * it. A page in a notebook's cell has no address.
 */
export function keepAddress(store: Store): void {
  if (location.protocol === "about:") return;
  let timer: ReturnType<typeof setTimeout> | undefined;
  let written = location.hash;
  store.subscribe(() => {
    clearTimeout(timer);
    timer = setTimeout(() => {
      // A change by hand takes precedence; its event follows.
      if (location.hash !== written) return;
      history.replaceState(null, "", formatAddress(store.state));
      written = location.hash;
    }, 300);
  });
  addEventListener("hashchange", () => {
    if (location.hash === written) return;
    written = location.hash;
    const found = parseAddress(location.hash);
    const { part, camera } = store.state;
    // If no camera is given, the view shows another part as a whole.
    const elsewhere = found.part !== undefined && found.part !== part;
    if (Object.keys(found).length > 0) store.set({ ...DEFAULTS, part, camera: elsewhere ? null : camera, ...found });
  });
}
