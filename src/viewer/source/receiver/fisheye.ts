// What a receiver sees of the upper hemisphere, from below as a map: north up, east right, the horizon round it; with the ways of the sun.

import type { Fisheye } from "../engine/client";
import { el } from "../dom";

const CLASSES = [
  { name: "outside", rgb: [251, 252, 252] },
  { name: "sky", rgb: [198, 224, 242] },
  { name: "ground", rgb: [196, 182, 154] },
  { name: "obstruction", rgb: [120, 126, 133] },
  { name: "mirror", rgb: [86, 178, 186] },
  { name: "leaves", rgb: [128, 170, 108] },
  { name: "behind the surface", rgb: [58, 63, 70] },
] as const;

/** Points a side that are asked of the engine, and drawn. */
export const SIDE = 256;
const DRAWN = 512;
const RIM = 30;

export function drawFisheye(seen: Fisheye, caption: string, northDeg: number): HTMLElement {
  const small = new OffscreenCanvas(seen.side, seen.side);
  const pixels = new ImageData(seen.side, seen.side);
  const counts = new Uint32Array(CLASSES.length);
  seen.classes.forEach((kind, at) => {
    const { rgb } = CLASSES[kind] ?? CLASSES[0];
    pixels.data.set([...rgb, kind === 0 ? 0 : 255], 4 * at);
    counts[kind]! += 1;
  });
  small.getContext("2d")?.putImageData(pixels, 0, 0);

  const there = CLASSES.map(({ name }, kind) => ({ name, kind })).filter(({ kind }) => kind > 0 && counts[kind]! > 0);
  const canvas = el("canvas", { width: DRAWN, height: DRAWN, role: "img", "aria-label": `Upper hemisphere of ${caption}: ${there.map(({ name }) => name).join(", ")}.` });
  const draw = canvas.getContext("2d");
  if (draw) {
    const radius = DRAWN / 2 - RIM;
    draw.translate(DRAWN / 2, DRAWN / 2);
    draw.save();
    draw.beginPath();
    draw.arc(0, 0, radius, 0, 2 * Math.PI);
    draw.clip();
    draw.drawImage(small, -radius, -radius, 2 * radius, 2 * radius);
    draw.restore();
    draw.strokeStyle = "#5b6772";
    draw.lineWidth = 1.5;
    draw.beginPath();
    draw.arc(0, 0, radius, 0, 2 * Math.PI);
    draw.stroke();
    for (const { label, points } of seen.paths) {
      const hour = /^\d+$/.test(label);
      draw.strokeStyle = hour ? "#c9820088" : "#c97a00";
      draw.lineWidth = hour ? 1.2 : 2.6;
      draw.beginPath();
      for (let at = 0; at < points.length; at += 2) draw.lineTo(radius * points[at]!, -radius * points[at + 1]!);
      draw.stroke();
    }
    draw.fillStyle = "#1f2933";
    draw.font = "600 22px system-ui, sans-serif";
    draw.textAlign = "center";
    draw.textBaseline = "middle";
    ["N", "E", "S", "W"].forEach((letter, quarter) => {
      const angle = ((northDeg + 90 * quarter) * Math.PI) / 180;
      draw.fillText(letter, (radius + 15) * Math.sin(angle), -(radius + 15) * Math.cos(angle));
    });
  }
  const key = there.map(({ name, kind }) => {
    const box = el("span", { class: "swatch" });
    box.style.background = `rgb(${CLASSES[kind]!.rgb.join(",")})`;
    return el("li", {}, box, name);
  });
  return el("figure", {}, canvas, el("ul", { class: "key" }, ...key));
}
