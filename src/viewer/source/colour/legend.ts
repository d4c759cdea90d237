// The legend on the 3D view: colour bar, ticks, title with unit.

import { byId, el } from "../dom";
import { legendTicks } from "./range";
import { number } from "../words";
import { viridisCss } from "./viridis";

export class Legend {
  title = "";
  unit = "";
  range: readonly [number, number] = [0, 1];
  private readonly box = byId("legend", HTMLElement);
  private readonly heading = byId("legend-title", HTMLElement);
  private readonly bar = byId("legend-bar", HTMLElement);
  private readonly labels = byId("legend-ticks", HTMLElement);

  constructor() {
    const stops = Array.from({ length: 17 }, (_, step) => viridisCss(step / 16));
    this.bar.style.background = `linear-gradient(to right, ${stops.join(", ")})`;
  }

  show(title: string, unit: string, range: readonly [number, number]): void {
    if (title === this.title && unit === this.unit && String(range) === String(this.range) && !this.box.hidden) return;
    [this.title, this.unit, this.range] = [title, unit, range];
    this.box.hidden = false;
    this.heading.replaceChildren(title, " ", el("span", { class: "unit", text: unit }));
    const [low, high] = range;
    this.labels.replaceChildren(
      ...legendTicks(low, high).map((value) => {
        const label = el("span", { text: number(value) });
        label.style.left = `${(100 * (value - low)) / (high - low)}%`;
        return label;
      }),
    );
  }
}
