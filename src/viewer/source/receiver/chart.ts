// Bars stacked by component, with axes and units, and the same as a table for those who do not see
// bars.

import { el, svg } from "../dom";
import { niceStep, ticks } from "../colour/range";
import { COMPONENT_COLOURS, componentLabel, number } from "../words";

export interface Chart {
  title: string;
  unit: string;
  /** Label of each bar. */
  labels: string[];
  /** Bars whose label stands below the axis. */
  labelled: (bar: number) => string | null;
  components: readonly string[];
  /** [component][bar]. */
  values: readonly Float32Array[];
  /** Top of the axis, so that two charts can be compared. */
  top: number;
}

const [WIDTH, HEIGHT, LEFT, TOP, BOTTOM] = [340, 150, 40, 8, 20];

/** Returns the parts that add up to the total, in the order in which they are stacked. */
function parts(chart: Pick<Chart, "components">): { name: string; at: number }[] {
  return chart.components.map((name, at) => ({ name, at })).filter(({ name }) => name in COMPONENT_COLOURS);
}

/** Returns the height of the highest bar, rounded up. */
export function topOf(components: readonly string[], values: readonly Float32Array[]): number {
  const bars = values[0]?.length ?? 0;
  let most = 0;
  for (let bar = 0; bar < bars; bar++) {
    most = Math.max(most, parts({ components }).reduce((sum, { at }) => sum + Math.max(0, values[at]![bar]!), 0));
  }
  const step = niceStep(most / 4);
  return most > 0 ? step * Math.ceil(most / step - 1e-6) : 1;
}

export function drawChart(chart: Chart): HTMLElement {
  const bars = chart.labels.length;
  const x = (bar: number): number => LEFT + ((WIDTH - LEFT - 4) * bar) / bars;
  const y = (value: number): number => HEIGHT - BOTTOM - ((HEIGHT - BOTTOM - TOP) * value) / chart.top;
  const round = (length: number): string => length.toFixed(1);
  const axis = ticks(0, chart.top).flatMap((value) => [
    svg("line", { x1: LEFT, x2: WIDTH - 4, y1: y(value), y2: y(value), stroke: value === 0 ? "#5b6772" : "#e1e6ea" }),
    svg("text", { x: LEFT - 5, y: y(value) + 3.5, "text-anchor": "end", "font-size": 10, fill: "#5b6772", text: number(value) }),
  ]);
  const base = new Float32Array(bars);
  const gap = bars > 60 ? 0 : 0.12;
  const width = round((x(1) - x(0)) * (1 - 2 * gap));
  const stacks = parts(chart).map(({ name, at }) => {
    let path = "";
    for (let bar = 0; bar < bars; bar++) {
      const value = Math.max(0, chart.values[at]![bar]!);
      if (value === 0) continue;
      path += `M${round(x(bar + gap))} ${round(y(base[bar]!))}h${width}V${round(y(base[bar]! + value))}h-${width}z`;
      base[bar]! += value;
    }
    return svg("path", { d: path, fill: COMPONENT_COLOURS[name] ?? "#888" });
  });
  const below = chart.labels.flatMap((_, bar) => {
    const text = chart.labelled(bar);
    return text === null ? [] : [svg("text", { x: x(bar + 0.5), y: HEIGHT - 6, "text-anchor": "middle", "font-size": 10, fill: "#5b6772", text })];
  });
  const total = chart.components.indexOf("total");
  const sums = chart.values[total] ?? base;
  const best = sums.indexOf(Math.max(...sums));
  const summary = `${chart.title}, ${chart.unit}: most in ${chart.labels[best] ?? "–"}, ${number(sums[best] ?? NaN)}; all values are in the table.`;
  return el(
    "figure",
    {},
    el("figcaption", { text: `${chart.title}, ${chart.unit}` }),
    svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": summary }, ...axis.slice(2), ...stacks, ...axis.slice(0, 2), ...below),
    el("details", {}, el("summary", { text: "Table" }), el("div", { class: "scroll" }, table(chart))),
  );
}

function table(chart: Chart): HTMLTableElement {
  const head = el("tr", {}, el("th", { scope: "col", text: chart.unit }), ...chart.components.map((name) => el("th", { scope: "col", text: componentLabel(name) })));
  const rows = chart.labels.map((label, bar) =>
    el("tr", {}, el("th", { scope: "row", text: label }), ...chart.values.map((values) => el("td", { "data-value": values[bar]!, text: number(values[bar]!) }))),
  );
  return el("table", {}, el("thead", {}, head), el("tbody", {}, ...rows));
}

/** Returns the key of colours of the components that are present. */
export function key(components: readonly string[], values: readonly (readonly Float32Array[])[]): HTMLElement {
  const there = parts({ components }).filter(({ at }) => values.some((columns) => columns[at]?.some((value) => value !== 0)));
  return el("ul", { class: "key" }, ...there.map(({ name }) => el("li", {}, swatch(name), componentLabel(name))));
}

export function swatch(component: string): HTMLElement {
  const box = el("span", { class: "swatch" });
  box.style.background = COMPONENT_COLOURS[component] ?? "transparent";
  return box;
}
