// State -> the light that the engine is asked for. Suns and clear skies come from the engine;
// nothing is computed here.

import type { Engine, Light, WeatherInfo } from "./engine/client";
import type { State } from "./state";

/** Returns the row of a weather file nearest to a day and a clock time. */
export function weatherRow(weather: WeatherInfo, dayOfYear: number, minutes: number): number {
  let best = 0;
  let least = Infinity;
  for (let row = 0; row < weather.rows; row++) {
    const days = Math.abs(weather.dayOfYear[row]! - dayOfYear);
    const distance = Math.min(days, 365 - days) * 1440 + Math.abs(weather.minutes[row]! - minutes);
    // At the border of two intervals, the one that begins there is taken.
    if (distance <= least) [best, least] = [row, distance];
  }
  return best;
}

interface KnowsClearSkies {
  clear(dayOfYear: number, minutes: number): Promise<{ dni: number; dhi: number }>;
}

/** Returns true if this engine offers clear skies. */
export function knowsClearSkies(engine: object): engine is KnowsClearSkies {
  return "clear" in engine && typeof engine.clear === "function";
}

/** Sun and irradiances of a light, for display. */
export interface Shine {
  light: Light;
  azimuth: number;
  altitude: number;
  dni: number;
  dhi: number;
  /** Interval of a weather file, else null. */
  label: string | null;
}

export async function shineOf(engine: Engine, state: State, weather: WeatherInfo | null): Promise<Shine> {
  if (state.light === "weather" && weather) {
    const hour = weatherRow(weather, state.dayOfYear, state.minutes);
    return {
      light: { kind: "weather", hour },
      azimuth: weather.azimuth[hour]!,
      altitude: weather.altitude[hour]!,
      dni: weather.dni[hour]!,
      dhi: weather.dhi[hour]!,
      label: weather.labels[hour] ?? null,
    };
  }
  const { azimuth, altitude } = state.sunBy === "angles" ? state : await engine.sun(state.dayOfYear, state.minutes);
  let { dni, dhi } = state;
  if (state.light === "clear" && state.sunBy === "clock" && knowsClearSkies(engine)) ({ dni, dhi } = await engine.clear(state.dayOfYear, state.minutes));
  if (state.light === "overcast") dni = 0;
  if (altitude <= 0) dni = 0;
  return { light: { kind: "sun", azimuth, altitude, dni, dhi }, azimuth, altitude, dni, dhi, label: null };
}
