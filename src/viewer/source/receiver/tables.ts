// Tables of the chosen receiver, and of a second one beside it.

import { percentOf } from "../change";
import { el } from "../dom";
import type { ReceiverInfo } from "../engine/client";
import { bearing, comfortUnit, componentLabel, number, signed } from "../words";
import { swatch } from "./chart";
import type { Grouping, Sum } from "./groups";

export type When = "before" | "after";

/** Sum over the receivers with this name. */
export interface NamedSum {
  kind: Grouping;
  name: string;
  sum: Sum;
}

/** Sum before and after, as far as both exist. */
export interface ChangedSum {
  name: string;
  before?: Sum;
  after?: Sum;
}

/** Returns the name of a number, with its unit if the table has no common unit. */
function labelOf(name: string, unit: string): string {
  return unit === "" ? `${componentLabel(name)}, ${comfortUnit(name)}` : componentLabel(name);
}

export function letter(which: number): HTMLElement {
  return el("span", { class: which === 0 ? "letter" : "letter second", text: which === 0 ? "A" : "B" });
}

/** Returns the mark for before or after. */
export function tag(when: When): HTMLElement {
  return el("span", { class: `tag ${when}`, text: when });
}

function head(first: string, count: number): HTMLElement {
  const letters = count > 1 ? [el("th", { scope: "col" }, letter(0)), el("th", { scope: "col" }, letter(1))] : [el("th", { scope: "col" })];
  return el("thead", {}, el("tr", {}, el("th", { scope: "col", text: first }), ...letters));
}

/** Returns a name without the beginning that stands in the row above. */
function beyond(name: string, above: string): string {
  return above !== "" && name !== above && name.startsWith(above) ? `…${name.slice(above.length)}` : name === above ? "" : name;
}

/** Share of the hemisphere below which a difference is rounding. */
const NOTHING = 0.005;

/**
 * Returns the shares of the hemisphere by name. Directions that are neither sky nor met are
 * nothing: below the horizon, where the scene ends.
 */
function views(receiver: ReceiverInfo): [string, number][] {
  const known = ["sky", "ground", "obstructions"].map((name, at): [string, number] => [name, receiver.views[at]!]);
  const nothing = 1 - known.reduce((sum, [, share]) => sum + share, 0);
  return nothing > NOTHING ? [...known, ["nothing", nothing]] : known;
}

/** A receiver in one archive. */
interface Known {
  info: ReceiverInfo;
  skyView: number;
}

/**
 * Makes the table of names, places and directions of receivers: [receiver][archive that has it].
 */
export function facts(receivers: readonly (readonly Known[])[]): HTMLTableElement {
  const level = (r: ReceiverInfo): boolean => r.tilt < 0.05 || r.tilt > 179.95;
  const rows: [string, (r: ReceiverInfo, skyView: number) => string][] = [
    ["Building", (r) => r.building],
    ["Object", (r) => beyond(r.object, r.building)],
    ["Surface", (r) => beyond(r.surface ?? "", r.object)],
    ["Kind", (r) => [r.kind, r.objectType].filter((word) => word !== "").join(", ")],
    ["Area", (r) => (r.area === null ? "" : `${number(r.area)} m²`)],
    ["Tilt", (r) => `${r.tilt.toFixed(1)}°`],
    ["Azimuth", (r) => (level(r) ? "–" : `${r.azimuth.toFixed(1)}° (${bearing(r.azimuth)})`)],
    ["Sky view", (_, skyView) => (Number.isFinite(skyView) ? `${(100 * skyView).toFixed(1)} %` : "")],
    ["Sees", (r) => views(r).map(([name, share]) => `${name}\u00a0${(100 * share).toFixed(0)}\u00a0%`).join(", ")],
  ];
  const body = rows
    .map(([name, text]) => ({ name, texts: receivers.map((sides) => [...new Set(sides.map(({ info, skyView }) => text(info, skyView)))].join(" → ")) }))
    .filter(({ texts }) => texts.some((text) => text !== ""))
    .map(({ name, texts }) => el("tr", {}, el("th", { scope: "row", text: name }), ...texts.map((text) => el("td", { class: "text", text }))));
  return el("table", { id: "receiver-facts" }, ...(receivers.length > 1 ? [head("", receivers.length)] : []), el("tbody", {}, ...body));
}

/** Makes the table of all components of receivers, with exact numbers in `data-value`. */
export function values(caption: string, unit: string, components: readonly string[], columns: readonly (readonly number[] | null)[]): HTMLTableElement {
  const pair = columns.length > 1;
  const body = components.map((name, at) => {
    const cells = columns.map((column) => {
      const value = column?.[at];
      return value === undefined ? el("td", { text: "…" }) : el("td", { "data-value": value, text: number(value) });
    });
    const [a, b] = columns.map((column) => column?.[at]);
    if (pair) cells.push(el("td", { text: a !== undefined && b !== undefined ? number(a - b) : "…" }));
    return el("tr", { "data-component": name, class: name === "total" ? "total" : "part" }, el("th", { scope: "row" }, swatch(name), labelOf(name, unit)), ...cells);
  });
  const heading = head(unit, columns.length);
  if (pair) heading.firstElementChild?.append(el("th", { scope: "col", text: "A − B" }));
  return el("table", { id: "receiver-values" }, el("caption", { text: caption }), heading, el("tbody", {}, ...body));
}

/**
 * Makes the table of all components of a receiver before and after, and their change. A receiver
 * that an archive is known not to have has no values there.
 */
export function changes(
  heading: (Node | string)[], unit: string, components: readonly string[], isKnown: boolean, sides: Record<When, readonly number[] | null | undefined>,
): HTMLTableElement {
  const body = components.map((name, at) => {
    const [before, after] = [sides.before?.[at], sides.after?.[at]];
    const cell = (value: number | undefined, text: (value: number) => string, isMissing: boolean): HTMLElement =>
      value === undefined ? el("td", { text: isMissing && isKnown ? "–" : "…" }) : el("td", { "data-value": value, text: text(value) });
    const isMissing = sides.before === undefined || sides.after === undefined;
    const change = before === undefined || after === undefined ? [undefined, undefined] : [after - before, percentOf(before, after)];
    return el(
      "tr",
      { "data-component": name, class: name === "total" ? "total" : "part" },
      el("th", { scope: "row" }, swatch(name), labelOf(name, unit)),
      cell(before, number, sides.before === undefined),
      cell(after, number, sides.after === undefined),
      cell(change[0], signed, isMissing),
      cell(change[1], signed, isMissing),
    );
  });
  const titles = [unit, "before", "after", "change", "%"];
  return el(
    "table",
    { class: "receiver-changes" },
    el("caption", {}, ...heading),
    el("thead", {}, el("tr", {}, ...titles.map((text) => el("th", { scope: "col", text })))),
    el("tbody", {}, ...body),
  );
}

function titleOf(kind: string): string {
  return `${kind[0]!.toUpperCase()}${kind.slice(1)}`;
}

function soFar(part: number): HTMLElement[] {
  return part < 1 ? [el("p", { class: "note", text: `Sums of the ${Math.floor(100 * part)} % of the receivers that are read so far.` })] : [];
}

/** Makes the table of surface and building, and shows how many of the names were read so far. */
function sumsTable(titles: readonly string[], body: readonly HTMLElement[], part: number): HTMLElement {
  const table = el(
    "table",
    { class: "receiver-sums" },
    el("thead", {}, el("tr", {}, ...titles.map((text) => el("th", { scope: "col", text })))),
    el("tbody", {}, ...body),
  );
  return el("div", {}, table, ...soFar(part));
}

/** Makes the table of means of surface and building before and after, and of their change. */
export function changedSums(unit: string, kinds: readonly (readonly [kind: string, sum: ChangedSum])[], part: number): HTMLElement {
  const cell = (value: number | undefined, text: (value: number) => string): HTMLElement =>
    value === undefined ? el("td", { text: "–" }) : el("td", { "data-value": value, text: text(value) });
  const body = kinds.map(([kind, { name, before, after }]) =>
    el(
      "tr",
      { "data-kind": kind },
      el("th", { scope: "row", title: name, text: titleOf(kind) }),
      cell(before?.mean, number),
      cell(after?.mean, number),
      cell(before && after && after.mean - before.mean, signed),
    ),
  );
  const titles = [`mean, ${unit}`, "before", "after", "change"];
  return sumsTable(titles, body, part);
}

/** Makes the table of means and sums of surface and building. */
export function sums(unit: string, wholeUnit: string, rows: readonly NamedSum[], part: number): HTMLElement {
  const body = rows.map(({ kind, name, sum }) =>
    el(
      "tr",
      { "data-kind": kind },
      el("th", { scope: "row", title: name, text: titleOf(kind) }),
      el("td", { text: String(sum.receivers) }),
      el("td", { text: sum.area === null ? "–" : `${number(sum.area)}` }),
      el("td", { "data-value": sum.mean, text: number(sum.mean) }),
      el("td", { "data-value": sum.whole ?? NaN, text: sum.whole === null ? "–" : number(sum.whole) }),
    ),
  );
  const titles = ["", "receivers", "m²", `mean, ${unit}`, wholeUnit];
  return sumsTable(titles, body, part);
}
