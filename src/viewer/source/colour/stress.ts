// Colours of thermal stress: the classes of the UTCI, in steps. Blue is cold, red is hot; the steps
// differ in lightness too, for colour-blind readers.

import type { Stress } from "../engine/client";
import { STEPS, type ColourMap } from "./map";

/** From extreme cold stress to extreme heat stress; the sixth is none. */
const COLOURS = ["08306b", "2159a0", "4287bf", "7cb3d8", "bbd9ea", "b5dca0", "fdd783", "f79a4a", "d93a28", "7d0a24"];
/** The map is in steps of half a degree, so that round limits lie between two of them. */
const STEP_C = 0.5;
const LOW_C = -50.25;

/**
 * Band of one colour, from a limit to a limit; the coldest has no lower and the hottest no upper
 * limit.
 */
export interface Band {
  name: string;
  from: number | null;
  to: number | null;
  colour: string;
}

/** Values at both ends of the map. */
export const STRESS_RANGE: readonly [number, number] = [LOW_C, LOW_C + STEP_C * (STEPS - 1)];

export function bandsOf(stress: readonly Stress[]): Band[] {
  return stress.map(({ name, to }, at) => ({ name, from: stress[at - 1]?.to ?? null, to, colour: `#${COLOURS[at] ?? "888888"}` }));
}

/** Returns the bands from the coldest to the hottest of some values. */
export function bandsAmong(bands: readonly Band[], columns: readonly Float32Array[]): Band[] {
  let [low, high] = [bands.length, -1];
  for (const column of columns) {
    for (const value of column) {
      if (!Number.isFinite(value)) continue;
      const at = bands.findIndex(({ to }) => to === null || value <= to);
      [low, high] = [Math.min(low, at), Math.max(high, at)];
    }
  }
  return bands.slice(low, high + 1);
}

let made: { of: readonly Stress[]; map: ColourMap } | null = null;

/** Returns the colour map of the classes, in steps over `STRESS_RANGE`. */
export function stressMap(stress: readonly Stress[]): ColourMap {
  if (made?.of === stress) return made.map;
  const bands = bandsOf(stress);
  const colourAt = (step: number): string => {
    const value = LOW_C + STEP_C * step;
    return bands.find(({ to }) => to === null || value <= to)?.colour ?? "#888888";
  };
  const bytes = new Uint8Array(STEPS * 4).fill(255);
  for (let step = 0; step < STEPS; step++) {
    for (let channel = 0; channel < 3; channel++) bytes[4 * step + channel] = parseInt(colourAt(step).slice(1 + 2 * channel, 3 + 2 * channel), 16);
  }
  const map = { bytes, css: (share: number) => colourAt(Math.round(Math.min(1, Math.max(0, share)) * (STEPS - 1))) };
  made = { of: stress, map };
  return map;
}

/** Returns the limits of a band in words. */
export function limitsOf({ from, to }: Band): string {
  const shown = (value: number): string => String(value).replace("-", "−");
  if (from === null) return to === null ? "" : `≤ ${shown(to)}`;
  return to === null ? `> ${shown(from)}` : `${shown(from)} to ${shown(to)}`;
}
