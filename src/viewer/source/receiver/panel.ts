// The panel of the chosen receiver: its name, its values, its surface and building, months and day,
// its view; and a second one beside it.

import { byId, el } from "../dom";
import type { Fisheye, ReceiverInfo, Series } from "../engine/client";
import type { Layer } from "../layer";
import type { Quantity } from "../quantity";
import type { Place, State, Store } from "../state";
import { dayName, KWH_M2, MONTHS, W_M2 } from "../words";
import { drawChart, key, topOf } from "./chart";
import { SIDE, Sight } from "./fisheye";
import { Groups } from "./groups";
import { changedSums, changes, facts, letter, sums, tag, values, type ChangedSum, type NamedSum, type When } from "./tables";

/** A receiver in one archive. */
export interface Side {
  layer: Layer;
  index: number;
  tile: number;
  row: number;
  /** Before or after; null if one archive is open. */
  when: When | null;
}

interface Site {
  /** Returns the receiver in each archive that has it. */
  sides(place: Place): Side[];
  /** Returns true if it is known which receivers of two archives are the same. */
  isWhole(): boolean;
  /** Returns the shown value of a receiver in words. */
  spoken(sides: readonly Side[]): string;
  settling(): Promise<void>;
  onError(what: string, error: unknown): void;
  say(text: string): void;
}

/** A chosen receiver: A or B. */
interface Chosen {
  which: number;
  sides: (Side & { info: ReceiverInfo })[];
}

/** Time for which a slider has to rest before charts follow it, ms. */
const REST = 250;

export class ReceiverPanel {
  private readonly body = byId("receiver-body", HTMLElement);
  private readonly parts: Record<"title" | "facts" | "values" | "sums" | "charts" | "sight", HTMLElement>;
  private sights: { sight: Sight; layer: Layer }[] = [];
  private readonly groups = new Map<Layer, Groups>();
  /** Resolves when the receiver chosen last is on the page. */
  choosing: Promise<void> = Promise.resolve();
  private chosen: Chosen[] = [];
  private turn = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly store: Store,
    private readonly site: Site,
  ) {
    const part = (): HTMLElement => el("div");
    this.parts = { title: part(), facts: part(), values: part(), sums: part(), charts: part(), sight: part() };
    this.parts.title.className = "title";
    this.body.replaceChildren(...Object.values(this.parts));
  }

  close(): void {
    this.turn += 1;
    clearTimeout(this.timer);
    this.chosen = [];
    this.sights = [];
    this.body.replaceChildren();
  }

  choose(): void {
    this.choosing = this.readChosen();
  }

  private async readChosen(): Promise<void> {
    const { selected, pinned } = this.store.state;
    const turn = ++this.turn;
    const places = [selected, pinned].filter((place) => place !== null);
    const chosen: Chosen[] = [];
    for (const [which, place] of places.entries()) {
      const sides: Chosen["sides"] = [];
      for (const side of this.site.sides(place)) {
        try {
          const info = (await side.layer.session.table(side.tile))[side.row];
          if (info) sides.push({ ...side, info });
        } catch (error) {
          if (turn === this.turn) this.site.onError("reading the receiver", error);
        }
        if (turn !== this.turn) return;
      }
      if (sides.length > 0) chosen.push({ which, sides });
    }
    this.chosen = chosen;
    byId("receiver-none", HTMLElement).hidden = chosen.length > 0;
    this.body.hidden = chosen.length === 0;
    if (chosen.length === 0) return;
    this.drawTitle(pinned !== null);
    this.parts.facts.replaceChildren(facts(chosen.map(({ sides }) => sides.map(({ info, layer, index }) => ({ info, skyView: layer.session.skyView[index]! })))));
    this.showValues();
    this.speak();
    for (const { layer, index } of chosen[0]!.sides) void this.groupsOf(layer).readAll(middleOf(layer, index), () => this.showSums());
    this.drawLater(0, true);
  }

  /** Clouds before the sky that it sees, as the state has them. */
  showClouds(): void {
    for (const { sight, layer } of this.sights) sight.draw(layer.session.clouds?.map ?? null, layer.session.cloudsTop(this.store.state));
  }

  /** Values of what is shown have come, or another quantity is shown. */
  showValues(): void {
    if (this.chosen.length === 0) return;
    const { title, components, unit: ofShown, wholeUnit } = this.quantity();
    // Each number of people has a unit of its own.
    const unit = wholeUnit === null ? "" : ofShown;
    const all = this.chosen.map(({ sides }) => sides.map(({ layer, index, when }) => ({ when, values: layer.quantity().of(index) })));
    const tables = this.isPair
      ? all.map((sides, which) => {
          const of = (wanted: When) => sides.find(({ when }) => when === wanted);
          const heading = [...this.letters(which), title];
          return changes(heading, unit, components, this.site.isWhole(), { before: of("before")?.values, after: of("after")?.values });
        })
      : [values(title, unit, components, all.map(([side]) => side!.values))];
    this.parts.values.replaceChildren(...tables);
    this.showSums();
  }

  /** The charts follow weather, changes and day. */
  drawLater(wait = REST, withSight = false): void {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => void this.drawCharts(withSight), wait);
  }

  /** Announces the first chosen receiver and its value to screen readers. */
  speak(): void {
    const [first] = this.chosen;
    if (!first) return;
    const value = this.site.spoken(first.sides);
    this.site.say(`${first.sides[0]!.info.id}${value === "" ? "" : `, ${value}`}`);
  }

  /** Returns the quantity of the archive that has the receiver, or of one of the two. */
  private quantity(): Quantity {
    return this.chosen[0]!.sides[0]!.layer.quantity();
  }

  private get isPair(): boolean {
    return this.chosen.some(({ sides }) => sides.some(({ when }) => when !== null));
  }

  private groupsOf(layer: Layer): Groups {
    let groups = this.groups.get(layer);
    if (!groups) this.groups.set(layer, (groups = new Groups(layer.session)));
    return groups;
  }

  /** Returns the letter A or B, if two receivers are chosen. */
  private letters(which: number): HTMLElement[] {
    return this.chosen.length > 1 ? [letter(this.chosen[which]!.which)] : [];
  }

  /** Returns the name of a side, if there are several. */
  private tags(which: number, when: When | null): HTMLElement[] {
    return [...this.letters(which), ...(when ? [tag(when)] : [])];
  }

  private drawTitle(pinned: boolean): void {
    const names = this.chosen.map(({ which, sides }) => el("h2", {}, ...(pinned ? [letter(which)] : []), sides[0]!.info.id));
    const close = el("button", { type: "button", class: "bare", "aria-label": "Close", title: "Close (Escape)", text: "×" });
    const pin = el("button", { type: "button", id: "pin", "aria-pressed": String(pinned), text: pinned ? "Stop comparing" : "Pin to compare" });
    close.addEventListener("click", () => this.store.set({ selected: null, pinned: null }));
    pin.addEventListener("click", () => this.store.set({ pinned: pinned ? null : this.store.state.selected }));
    const [a, b] = this.chosen.map(({ sides }) => `${sides[0]!.when} ${sides[0]!.index}`);
    const note = a !== undefined && a === b ? [el("p", { class: "note", text: "Now pick another receiver: it becomes A and stands beside this one." })] : [];
    this.parts.title.replaceChildren(el("div", {}, ...names, ...note), close, el("p", { class: "buttons" }, pin));
  }

  private showSums(): void {
    if (this.chosen.length === 0) return;
    const { shownTitle, unit, wholeUnit } = this.quantity();
    if (wholeUnit === null) return this.parts.sums.replaceChildren();
    const tables = this.chosen.flatMap(({ sides }, which) => {
      const found = sides.map((side) => ({ ...side, rows: this.sumsOf(side) }));
      if (found.every(({ rows }) => rows.length === 0)) return [];
      const share = Math.min(...sides.map(({ layer }) => this.groupsOf(layer).share));
      if (!this.isPair) return [...this.letters(which), sums(unit, wholeUnit, found[0]!.rows, share)];
      const kinds = new Map<string, ChangedSum>();
      for (const { when, rows } of found) {
        for (const { kind, name, sum } of rows) kinds.set(kind, { ...kinds.get(kind), name, [when ?? "before"]: sum });
      }
      return [...this.letters(which), changedSums(unit, [...kinds], share)];
    });
    const title = el("h3", { text: `Surface and building: ${shownTitle}` });
    this.parts.sums.replaceChildren(...(tables.length > 0 ? [title, ...tables] : []));
  }

  /** Returns the sums of the surface, object and building of a receiver. */
  private sumsOf({ layer, info }: Chosen["sides"][number]): NamedSum[] {
    const { column } = layer.quantity();
    if (!column) return [];
    return (["surface", "object", "building"] as const).flatMap((kind) => {
      const name = info[kind];
      if (!name || (kind === "object" && name === info.building)) return [];
      const sum = this.groupsOf(layer).sum(kind, name, column);
      return sum && Number.isFinite(sum.mean) ? [{ kind, name, sum }] : [];
    });
  }

  private async drawCharts(withSight: boolean): Promise<void> {
    const turn = this.turn;
    const state: State = { ...this.store.state };
    const { chosen } = this;
    if (chosen.length === 0) return;
    if (state.show === "moment") await this.site.settling();
    const sides = chosen.flatMap(({ sides }, which) => sides.map((side) => ({ ...side, which })));
    try {
      if (sides.every(({ layer }) => layer.session.weather)) {
        const months: TaggedSeries[] = [];
        const days: TaggedSeries[] = [];
        for (const { layer, tile, row, which, when } of sides) {
          const { engine } = layer.session;
          layer.session.turnClouds(this.store.state);
          const ask = { tile, row, sky: state.sky, changes: layer.session.changes(state) };
          const tagged = { components: layer.session.site.components, tags: () => this.tags(which, when) };
          months.push({ ...(await engine.months(ask)), ...tagged });
          days.push({ ...(await engine.day({ ...ask, dayOfYear: state.dayOfYear })), ...tagged });
          if (turn !== this.turn) return;
        }
        this.drawSeries(months, days, state.dayOfYear);
      } else {
        this.parts.charts.replaceChildren(el("h3", { text: "Months and day" }), el("p", { class: "note", text: "Open a weather file to see months and the hours of a day." }));
      }
      if (!withSight) return;
      const sights: typeof this.sights = [];
      for (const { layer, tile, row, which, when, info } of sides) {
        const seen: Fisheye = await layer.session.engine.fisheye({ tile, row, side: SIDE });
        if (turn !== this.turn) return;
        const sight = new Sight(seen, info.id, layer.session.site.northDeg);
        sight.figure.prepend(...this.tags(which, when));
        sights.push({ sight, layer });
      }
      this.sights = sights;
      this.showClouds();
      const pictures = sights.map(({ sight }) => sight.figure);
      const note = el("p", { class: "note", text: "The upper hemisphere as on a map, zenith in the middle; lines: paths of the sun." });
      this.parts.sight.replaceChildren(el("h3", { text: "What the receiver sees" }), el("div", { class: pictures.length > 1 ? "fishes" : "fishes single" }, ...pictures), note);
    } catch (error) {
      if (turn === this.turn) this.site.onError("reading the receiver", error);
    }
  }

  private drawSeries(months: TaggedSeries[], days: TaggedSeries[], dayOfYear: number): void {
    const open = [...this.parts.charts.querySelectorAll("details")].map((details) => details.open);
    const draw = (series: TaggedSeries[], title: string, unit: string, labels: (s: Series) => string[], labelled: (bar: number, bars: number) => string | null): HTMLElement[] => {
      const top = Math.max(...series.map((one) => topOf(one.components, one.values)));
      return series.map((one) => {
        const figure = drawChart({ title, unit, labels: labels(one), labelled: (bar) => labelled(bar, one.labels.length), components: one.components, values: one.values, top });
        figure.prepend(...one.tags());
        return figure;
      });
    };
    const hour = (bar: number, bars: number): string | null => (((bar * 24) / bars) % 3 === 0 ? String((bar * 24) / bars) : null);
    this.parts.charts.replaceChildren(
      el("h3", { text: "Months" }),
      ...draw(months, "Sums", KWH_M2, (one) => one.labels.map((label, at) => (one.labels.length === 12 ? MONTHS[at]! : label)), (bar) => MONTHS[bar]?.slice(0, 1) ?? null),
      el("h3", { text: dayName(dayOfYear) }),
      ...draw(days, "Irradiance by clock time", W_M2, (one) => one.labels, hour),
      key(months[0]?.components ?? [], [...months, ...days].map((one) => one.values)),
    );
    [...this.parts.charts.querySelectorAll("details")].forEach((details, at) => (details.open = open[at] ?? false));
  }
}

/** A chart's values, with what it is called. */
interface TaggedSeries extends Series {
  components: readonly string[];
  tags: () => HTMLElement[];
}

function middleOf(layer: Layer, index: number): [number, number, number] {
  const [x = 0, y = 0, z = 0] = layer.session.middles.subarray(3 * index, 3 * index + 3);
  return [x, y, z];
}
