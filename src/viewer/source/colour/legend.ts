// The legend on the 3D view: colour bar, ticks, title with unit.

import { byId, el } from "../dom";
import { legendTicks } from "./range";
import { limitsOf, type Band } from "./stress";
import { number } from "../words";
import type { ColourMap } from "./map";
import { VIRIDIS } from "../../../results/page/viridis";

/** Content of the legend. */
export interface Key {
  title: string;
  unit: string;
  range: readonly [number, number];
  map: ColourMap;
  /** Meaning of the colours, in place of the bar. */
  bands?: readonly Band[];
}

export class Legend {
  private key: Key = { title: "", unit: "", range: [0, 1], map: VIRIDIS };
  private readonly box = byId("legend", HTMLElement);
  private readonly heading = byId("legend-title", HTMLElement);
  private readonly bar = byId("legend-bar", HTMLElement);
  private readonly labels = byId("legend-ticks", HTMLElement);

  get shown(): Key {
    return this.key;
  }

  show(key: Key): void {
    const same = (["title", "unit", "map"] as const).every((part) => key[part] === this.key[part]) && String(key.range) === String(this.key.range) && named(key) === named(this.key);
    if (same && !this.box.hidden) return;
    this.key = key;
    this.box.hidden = false;
    this.bar.hidden = key.bands !== undefined;
    this.labels.className = key.bands ? "bands" : "";
    if (key.bands) {
      // Hot bands stand on top, as on a thermometer.
      const rows = [...key.bands].reverse().map((band) => {
        const swatch = el("i", {});
        swatch.style.background = band.colour;
        return el("p", {}, swatch, el("b", { text: band.name }), limitsOf(band));
      });
      this.heading.replaceChildren(key.title, " ", el("span", { class: "unit", text: key.unit }));
      this.labels.replaceChildren(...rows);
      return;
    }
    const stops = Array.from({ length: 17 }, (_, step) => key.map.css(step / 16));
    this.bar.style.background = `linear-gradient(to right, ${stops.join(", ")})`;
    this.heading.replaceChildren(key.title, " ", el("span", { class: "unit", text: key.unit }));
    const [low, high] = key.range;
    this.labels.replaceChildren(
      ...legendTicks(low, high).map((value) => {
        // In a diverging colour map, the mark at zero crosses the bar.
        const label = el("span", { text: number(value), class: low < 0 && value === 0 ? "zero" : "" });
        label.style.left = `${(100 * (value - low)) / (high - low)}%`;
        return label;
      }),
    );
  }
}

function named({ bands }: Key): string {
  return bands?.map(({ name }) => name).join() ?? "";
}
