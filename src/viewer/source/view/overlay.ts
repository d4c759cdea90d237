// Overlay of the 3D view in page pixels: north arrow with the sun, scale bar, letters at chosen
// receivers.

import { Vector3 } from "three";
import { byId } from "../dom";
import type { Stage } from "./stage";

const LONGEST_BAR = 130;

export class Overlay {
  private readonly north = byId("north", SVGGElement);
  private readonly sun = byId("north-sun", SVGElement);
  private readonly scaleBar = byId("scale-bar", HTMLElement);
  private readonly scaleText = byId("scale-text", HTMLElement);
  private readonly pins = [byId("pin-a", HTMLElement), byId("pin-b", HTMLElement)];
  private readonly points: (Vector3 | null)[] = [null, null];
  private readonly stop: () => void;
  private sunAzimuth: number | null = null;

  constructor(
    private readonly stage: Stage,
    private readonly northDeg: number,
  ) {
    this.stop = stage.onDraw(() => this.place());
  }

  close(): void {
    this.stop();
    for (const pin of this.pins) pin.hidden = true;
  }

  /** Puts a letter A or B at a point, m from the scene's origin. */
  pin(which: 0 | 1, point: readonly [number, number, number] | null): void {
    this.points[which] = point ? new Vector3(...point) : null;
    this.place();
  }

  /** Shows the sun's azimuth, degrees from true north; null while there is no sun. */
  showSun(azimuth: number | null): void {
    this.sunAzimuth = azimuth;
    this.place();
  }

  private place(): void {
    const turned = this.northDeg - this.stage.heading();
    this.north.setAttribute("transform", `rotate(${turned.toFixed(1)})`);
    this.sun.setAttribute("transform", `rotate(${(turned + (this.sunAzimuth ?? 0)).toFixed(1)})`);
    this.sun.setAttribute("visibility", this.sunAzimuth === null ? "hidden" : "visible");
    const perPixel = this.stage.metresPerPixel();
    const longest = LONGEST_BAR * perPixel;
    const power = 10 ** Math.floor(Math.log10(longest));
    const metres = power * ([5, 2, 1].find((step) => step * power <= longest) ?? 1);
    this.scaleBar.style.width = `${Math.round(metres / perPixel)}px`;
    this.scaleText.textContent = metres >= 1000 ? `${metres / 1000} km` : metres >= 1 ? `${metres} m` : `${Math.round(metres * 100)} cm`;
    this.pins.forEach((pin, which) => {
      const point = this.points[which];
      const seen = point ? this.stage.project(point) : null;
      pin.hidden = seen === null;
      if (seen) pin.style.transform = `translate(${seen.x.toFixed(1)}px, ${seen.y.toFixed(1)}px)`;
    });
  }
}
