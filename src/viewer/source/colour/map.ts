// A colour map as the page uses it. In: its stops, six hexadecimal digits each. Out: bytes for the
// graphics card, and colours of CSS.

export const STEPS = 256;

export interface ColourMap {
  /** [step][red, green, blue, 255], 0..255. */
  readonly bytes: Uint8Array;
  /** Returns the CSS colour at a share 0..1 of the map. */
  css(share: number): string;
}

/** Makes the colour map of stops in sRGB, linear between them. */
export function colourMap(hex: string): ColourMap {
  const last = hex.length / 6 - 1;
  const stop = (at: number, channel: number): number => parseInt(hex.slice(6 * at + 2 * channel, 6 * at + 2 * channel + 2), 16);
  const bytes = new Uint8Array(STEPS * 4).fill(255);
  for (let step = 0; step < STEPS; step++) {
    const place = (last * step) / (STEPS - 1);
    const low = Math.min(Math.floor(place), last - 1);
    for (let channel = 0; channel < 3; channel++) {
      const from = stop(low, channel);
      bytes[4 * step + channel] = Math.round(from + (stop(low + 1, channel) - from) * (place - low));
    }
  }
  const css = (share: number): string => {
    const at = 4 * Math.round(Math.min(1, Math.max(0, share)) * (STEPS - 1));
    return `rgb(${bytes[at]}, ${bytes[at + 1]}, ${bytes[at + 2]})`;
  };
  return { bytes, css };
}
