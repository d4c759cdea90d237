// The parts of an atlas as a plan to click and a list, north up as far as the axes are. One of them
// is open.

import { byId, el, svg } from "../dom";
import type { Part } from "../parts";

const WORDS: Record<Part["state"], string> = { built: "", empty: ", no receivers", missing: ", not built" };

export class PartsPanel {
  private readonly list = byId("part-list", HTMLSelectElement);
  private readonly squares = new Map<string, SVGElement>();

  constructor(readonly parts: readonly Part[], choose: (name: string) => void) {
    const plan = byId("part-plan", SVGSVGElement);
    const [west, south, east, north] = parts.reduce<[number, number, number, number]>(
      ([w, s, e, n], { low, high }) => [Math.min(w, low[0]), Math.min(s, low[1]), Math.max(e, high[0]), Math.max(n, high[1])],
      [Infinity, Infinity, -Infinity, -Infinity],
    );
    plan.setAttribute("viewBox", `0 0 ${east - west} ${north - south}`);
    for (const { name, state, low, high, archive } of parts) {
      const [width, height] = [high[0] - low[0], high[1] - low[1]];
      const square = svg("rect", { x: low[0] - west, y: north - high[1], width, height, class: state }, svg("title", { text: `${name}${WORDS[state]}` }));
      if (archive !== null) square.addEventListener("click", () => choose(name));
      this.squares.set(name, square);
      plan.append(square);
    }
    this.list.replaceChildren(...parts.map(({ name, state, archive }) => el("option", { value: name, text: `${name}${WORDS[state]}`, disabled: archive === null })));
    this.list.addEventListener("change", () => choose(this.list.value));
    const built = parts.filter(({ archive }) => archive !== null).length;
    byId("part-note", HTMLElement).textContent = `${built} of ${parts.length} built; one is open at a time`;
    byId("part-parts", HTMLElement).hidden = false;
  }

  /** Marks the part that is open. */
  mark(open: string | null): void {
    for (const [name, square] of this.squares) square.toggleAttribute("data-open", name === open);
    this.list.value = open ?? "";
  }
}
