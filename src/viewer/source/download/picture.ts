// The 3D view with its legend, as PNG. In: the canvas as it is drawn, words of the legend, what it
// was made of.

import type { Key } from "../colour/legend";
import { legendTicks } from "../colour/range";
import type { Band } from "../colour/stress";
import { number } from "../words";

const FOOT = 84;

export async function picture(view: HTMLCanvasElement, scale: number, key: Key, lines: readonly string[]): Promise<Blob> {
  const canvas = document.createElement("canvas");
  canvas.width = view.width;
  canvas.height = view.height + Math.round(FOOT * scale);
  const draw = canvas.getContext("2d");
  if (!draw) throw new Error("this browser cannot draw pictures");
  draw.fillStyle = "#fff";
  draw.fillRect(0, 0, canvas.width, canvas.height);
  draw.drawImage(view, 0, 0);
  draw.translate(0, view.height);
  draw.scale(scale, scale);
  const width = canvas.width / scale;
  const [left, bar] = [16, Math.min(300, width / 2 - 40)];
  draw.fillStyle = "#1f2933";
  draw.font = "600 13px system-ui, sans-serif";
  draw.fillText(`${key.title} ${key.unit}`, left, 22);
  const bands = key.bands ?? [];
  if (bands.length > 0) drawBands(draw, bands, left, bar);
  else {
    for (let x = 0; x < bar; x++) {
      draw.fillStyle = key.map.css(x / (bar - 1));
      draw.fillRect(left + x, 32, 1.5, 12);
    }
  }
  draw.font = "11px system-ui, sans-serif";
  draw.textAlign = "center";
  draw.fillStyle = "#1f2933";
  const [low, high] = key.range;
  for (const value of bands.length > 0 ? [] : legendTicks(low, high)) draw.fillText(number(value), left + (bar * (value - low)) / (high - low), 58);
  draw.textAlign = "left";
  draw.fillStyle = "#5b6772";
  const from = left + bar + 32;
  lines.slice(0, 5).forEach((line, at) => draw.fillText(line, from, 20 + 14 * at, Math.max(10, width - from - 10)));
  return new Promise((resolve, reject) => canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("the picture could not be written"))), "image/png"));
}

/** Draws the meaning of the colours, cold to hot: a box each, and the limits between them. */
function drawBands(draw: CanvasRenderingContext2D, bands: readonly Band[], left: number, width: number): void {
  const wide = width / bands.length;
  draw.font = "11px system-ui, sans-serif";
  bands.forEach(({ colour, to }, at) => {
    draw.fillStyle = colour;
    draw.fillRect(left + at * wide, 32, wide, 12);
    draw.fillStyle = "#1f2933";
    draw.textAlign = "center";
    if (to !== null) draw.fillText(number(to), left + (at + 1) * wide, 58);
  });
  draw.textAlign = "left";
  const names = bands.length > 1 ? `${bands[0]!.name} to ${bands.at(-1)!.name}` : bands[0]!.name;
  draw.fillText(names, left, 74, width);
}
