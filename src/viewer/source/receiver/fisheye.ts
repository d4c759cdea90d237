// View of a receiver over the upper hemisphere, from below as a map: north up, east right, the
// horizon round it; with the paths of the sun.

import { CLOUD_OPACITY, CLOUD_RGB } from "../clouds";
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

/** Number of points to a side, as computed by the engine and drawn. */
export const SIDE = 256;
const DRAWN = 512;
const RIM = 30;
const RADIUS = DRAWN / 2 - RIM;
/** The class of the sky. */
const SKY = 1;

/** Picture of the view; it is drawn anew when clouds turn. */
export class Sight {
  readonly figure: HTMLElement;
  private readonly canvas: HTMLCanvasElement;
  private readonly classes: OffscreenCanvas;
  /** Mask of the visible sky. */
  private readonly sky: OffscreenCanvas;
  private readonly cloudKey = el("li", {}, swatch(CLOUD_RGB), "clouds");

  constructor(
    private readonly seen: Fisheye,
    caption: string,
    private readonly northDeg: number,
  ) {
    const counts = new Uint32Array(CLASSES.length);
    for (const kind of seen.classes) counts[kind]! += 1;
    this.classes = pixelsOf(seen, (kind) => [...(CLASSES[kind] ?? CLASSES[0]).rgb, kind === 0 ? 0 : 255]);
    this.sky = pixelsOf(seen, (kind) => [0, 0, 0, kind === SKY ? 255 : 0]);
    const there = CLASSES.map(({ name, rgb }, kind) => ({ name, rgb, kind })).filter(({ kind }) => kind > 0 && counts[kind]! > 0);
    this.canvas = el("canvas", { width: DRAWN, height: DRAWN, role: "img", "aria-label": `Upper hemisphere of ${caption}: ${there.map(({ name }) => name).join(", ")}.` });
    const key = there.map(({ name, rgb }) => el("li", {}, swatch(rgb), name));
    this.figure = el("figure", {}, this.canvas, el("ul", { class: "key" }, ...key, this.cloudKey));
  }

  /** Draws the view, with a map of clouds whose top lies at an azimuth. */
  draw(clouds: HTMLCanvasElement | null, top: number | null): void {
    const { northDeg } = this;
    const draw = this.canvas.getContext("2d");
    const veil = clouds && top !== null ? this.behind(clouds, northDeg + top) : null;
    this.cloudKey.hidden = veil === null;
    if (!draw) return;
    draw.setTransform(1, 0, 0, 1, DRAWN / 2, DRAWN / 2);
    draw.clearRect(-DRAWN / 2, -DRAWN / 2, DRAWN, DRAWN);
    draw.save();
    draw.beginPath();
    draw.arc(0, 0, RADIUS, 0, 2 * Math.PI);
    draw.clip();
    draw.drawImage(this.classes, -RADIUS, -RADIUS, 2 * RADIUS, 2 * RADIUS);
    draw.globalAlpha = CLOUD_OPACITY;
    if (veil) draw.drawImage(veil, -RADIUS, -RADIUS);
    draw.restore();
    draw.strokeStyle = "#5b6772";
    draw.lineWidth = 1.5;
    draw.beginPath();
    draw.arc(0, 0, RADIUS, 0, 2 * Math.PI);
    draw.stroke();
    for (const { label, points } of this.seen.paths) {
      const hour = /^\d+$/.test(label);
      draw.strokeStyle = hour ? "#c9820088" : "#c97a00";
      draw.lineWidth = hour ? 1.2 : 2.6;
      draw.beginPath();
      for (let at = 0; at < points.length; at += 2) draw.lineTo(RADIUS * points[at]!, -RADIUS * points[at + 1]!);
      draw.stroke();
    }
    draw.fillStyle = "#1f2933";
    draw.font = "600 22px system-ui, sans-serif";
    draw.textAlign = "center";
    draw.textBaseline = "middle";
    ["N", "E", "S", "W"].forEach((letter, quarter) => {
      const angle = ((northDeg + 90 * quarter) * Math.PI) / 180;
      draw.fillText(letter, (RADIUS + 15) * Math.sin(angle), -(RADIUS + 15) * Math.cos(angle));
    });
  }

  /** Returns the clouds in the visible sky, turned clockwise. */
  private behind(clouds: HTMLCanvasElement, degrees: number): OffscreenCanvas {
    const veil = new OffscreenCanvas(2 * RADIUS, 2 * RADIUS);
    const draw = veil.getContext("2d");
    if (!draw) return veil;
    draw.drawImage(this.sky, 0, 0, 2 * RADIUS, 2 * RADIUS);
    draw.globalCompositeOperation = "source-in";
    draw.translate(RADIUS, RADIUS);
    draw.rotate((degrees * Math.PI) / 180);
    draw.drawImage(clouds, -RADIUS, -RADIUS, 2 * RADIUS, 2 * RADIUS);
    return veil;
  }
}

function swatch(rgb: readonly number[]): HTMLElement {
  const box = el("span", { class: "swatch" });
  box.style.background = `rgb(${rgb.join(",")})`;
  return box;
}

function pixelsOf({ side, classes }: Fisheye, rgba: (kind: number) => number[]): OffscreenCanvas {
  const canvas = new OffscreenCanvas(side, side);
  const pixels = new ImageData(side, side);
  classes.forEach((kind, at) => pixels.data.set(rgba(kind), 4 * at));
  canvas.getContext("2d")?.putImageData(pixels, 0, 0);
  return canvas;
}
