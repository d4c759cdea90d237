// A small sky: zenith in the middle, horizon round it, north up. Shows the sun and its way on that
// day; dragging moves the sun.

import { CLOUD_OPACITY } from "../clouds";
import { byId, svg } from "../dom";

const HORIZON = 46;

interface Direction {
  azimuth: number;
  altitude: number;
}

function place({ azimuth, altitude }: Direction): [number, number] {
  const radius = (HORIZON * (90 - altitude)) / 90;
  const angle = (azimuth * Math.PI) / 180;
  return [radius * Math.sin(angle), -radius * Math.cos(angle)];
}

export class Dial {
  private readonly box = byId("dial", SVGSVGElement);
  private readonly clouds = svg("image", { x: -HORIZON, y: -HORIZON, width: 2 * HORIZON, height: 2 * HORIZON, opacity: CLOUD_OPACITY, visibility: "hidden" });
  private readonly way = svg("path", { fill: "none", stroke: "#d9a400", "stroke-width": 1.5 });
  private readonly sun = svg("circle", { r: 5.5, fill: "#f2b705", stroke: "#7a5b00" });

  constructor(onDrag: (direction: Direction) => void) {
    const ring = (altitude: number): SVGCircleElement =>
      svg("circle", { r: (HORIZON * (90 - altitude)) / 90, fill: altitude === 0 ? "#e6f0f7" : "none", stroke: "#a9b8c4", "stroke-width": altitude === 0 ? 1 : 0.5 });
    const letters = ["N", "E", "S", "W"].map((text, quarter) => {
      const [x, y] = place({ azimuth: 90 * quarter, altitude: -14 });
      return svg("text", { x, y: y + 3.5, "text-anchor": "middle", "font-size": 9.5, fill: "#5b6772", text });
    });
    this.box.append(ring(0), this.clouds, ring(30), ring(60), ...letters, this.way, this.sun);
    const drag = (event: PointerEvent): void => {
      const frame = this.box.getBoundingClientRect();
      const x = ((event.clientX - frame.left) / frame.width) * 120 - 60;
      const y = ((event.clientY - frame.top) / frame.height) * 120 - 60;
      const altitude = Math.max(0, 90 - (Math.hypot(x, y) / HORIZON) * 90);
      const azimuth = ((Math.atan2(x, -y) * 180) / Math.PI + 360) % 360;
      onDrag({ azimuth: Math.round(azimuth * 2) / 2, altitude: Math.round(altitude * 2) / 2 });
    };
    this.box.addEventListener("pointerdown", (event) => {
      this.box.setPointerCapture(event.pointerId);
      drag(event);
    });
    this.box.addEventListener("pointermove", (event) => {
      if (this.box.hasPointerCapture(event.pointerId)) drag(event);
    });
  }

  showSun(direction: Direction): void {
    const [x, y] = place(direction);
    this.sun.setAttribute("cx", x.toFixed(1));
    this.sun.setAttribute("cy", y.toFixed(1));
    this.sun.setAttribute("visibility", direction.altitude > 0 ? "visible" : "hidden");
  }

  /** Shows a map of clouds; the state has the azimuth of its top. */
  showClouds(map: HTMLCanvasElement | null): void {
    if (map) this.clouds.setAttribute("href", map.toDataURL());
    else this.clouds.removeAttribute("href");
  }

  turnClouds(top: number | null): void {
    this.clouds.setAttribute("visibility", top === null ? "hidden" : "visible");
    this.clouds.setAttribute("transform", `rotate(${top ?? 0})`);
  }

  showWay(directions: readonly Direction[]): void {
    let pen = "M";
    const steps: string[] = [];
    for (const direction of directions) {
      if (direction.altitude < 0) {
        pen = "M";
        continue;
      }
      steps.push(`${pen}${place(direction).map((length) => length.toFixed(1)).join(" ")}`);
      pen = "L";
    }
    this.way.setAttribute("d", steps.join(""));
  }
}
