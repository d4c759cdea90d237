// The panel of the chosen receiver: who it is, its values, its surface and building, months and day, what it sees; and a second one beside it.

import type { Asker } from "../asker";
import { byId, el } from "../dom";
import type { Fisheye, ReceiverInfo, Series } from "../engine/client";
import type { Quantity } from "../quantity";
import type { Session } from "../session";
import type { Place, State, Store } from "../state";
import { dayName, KWH_M2, MONTHS, W_M2 } from "../words";
import { drawChart, key, topOf } from "./chart";
import { drawFisheye, SIDE } from "./fisheye";
import { Groups } from "./groups";
import { facts, letter, sums, values } from "./tables";

interface Chosen {
  place: Place;
  index: number;
  info: ReceiverInfo;
}

/** Charts follow a slider when it has rested for that long, ms. */
const REST = 250;

export class ReceiverPanel {
  private readonly body = byId("receiver-body", HTMLElement);
  private readonly parts: Record<"title" | "facts" | "values" | "sums" | "charts" | "sight", HTMLElement>;
  private readonly groups: Groups;
  /** Resolves when who was chosen last is on the page. */
  choosing: Promise<void> = Promise.resolve();
  private chosen: Chosen[] = [];
  private turn = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly session: Session,
    private readonly store: Store,
    private readonly asker: Asker,
    private readonly quantity: () => Quantity,
    private readonly onError: (what: string, error: unknown) => void,
    private readonly say: (text: string) => void,
  ) {
    this.groups = new Groups(session);
    const part = (): HTMLElement => el("div");
    this.parts = { title: part(), facts: part(), values: part(), sums: part(), charts: part(), sight: part() };
    this.parts.title.className = "title";
    this.body.replaceChildren(...Object.values(this.parts));
  }

  close(): void {
    this.turn += 1;
    clearTimeout(this.timer);
    this.chosen = [];
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
    for (const place of places) {
      const index = this.session.indexOf(place);
      try {
        const info = (await this.session.table(place.tile))[place.row];
        if (index !== null && info) chosen.push({ place, index, info });
      } catch (error) {
        this.onError("reading the receiver", error);
      }
      if (turn !== this.turn) return;
    }
    this.chosen = chosen;
    byId("receiver-none", HTMLElement).hidden = chosen.length > 0;
    this.body.hidden = chosen.length === 0;
    const [first] = chosen;
    if (!first) return;
    this.drawTitle(pinned !== null);
    this.parts.facts.replaceChildren(facts(chosen.map(({ info }) => info), chosen.map(({ index }) => this.session.skyView[index]!)));
    this.showValues();
    this.speak();
    void this.groups.readAll(this.middleOf(first), () => this.showSums());
    this.drawLater(0, true);
  }

  /** Values of what is shown have come, or another quantity is shown. */
  showValues(): void {
    if (this.chosen.length === 0) return;
    const quantity = this.quantity();
    const columns = this.chosen.map(({ index }) => quantity.of(index));
    this.parts.values.replaceChildren(values(quantity.title, quantity.unit, quantity.components, columns));
    this.showSums();
  }

  /** The charts follow weather, changes and day. */
  drawLater(wait = REST, withSight = false): void {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => void this.drawCharts(withSight), wait);
  }

  /** What was picked, for those who listen. */
  speak(): void {
    const [first] = this.chosen;
    if (!first) return;
    const quantity = this.quantity();
    const all = quantity.of(first.index);
    const value = all?.[quantity.components.indexOf(quantity.shown)];
    const text = value === undefined ? "" : `, ${quantity.label(value)}`;
    this.say(`${first.info.id}${text}`);
  }

  private middleOf({ index }: Chosen): [number, number, number] {
    const [x = 0, y = 0, z = 0] = this.session.middles.subarray(3 * index, 3 * index + 3);
    return [x, y, z];
  }

  private drawTitle(pinned: boolean): void {
    const names = this.chosen.map(({ info }, which) => el("h2", {}, ...(pinned ? [letter(which)] : []), info.id));
    const close = el("button", { type: "button", class: "bare", "aria-label": "Close", title: "Close (Escape)", text: "×" });
    const pin = el("button", { type: "button", id: "pin", "aria-pressed": String(pinned), text: pinned ? "Stop comparing" : "Pin to compare" });
    close.addEventListener("click", () => this.store.set({ selected: null, pinned: null }));
    pin.addEventListener("click", () => this.store.set({ pinned: pinned ? null : this.store.state.selected }));
    const both = this.chosen.length > 1 && this.chosen[0]!.index === this.chosen[1]!.index;
    const note = both ? [el("p", { class: "note", text: "Now pick another receiver: it becomes A and stands beside this one." })] : [];
    this.parts.title.replaceChildren(el("div", {}, ...names, ...note), close, el("p", { class: "buttons" }, pin));
  }

  private showSums(): void {
    const quantity = this.quantity();
    const column = quantity.column;
    if (this.chosen.length === 0 || !column) return;
    const tables = this.chosen.flatMap(({ info }, which) => {
      const rows = (["surface", "object", "building"] as const).flatMap((kind) => {
        const name = info[kind];
        if (!name || (kind === "object" && name === info.building)) return [];
        const sum = this.groups.sum(kind, name, column);
        return sum && Number.isFinite(sum.mean) ? [{ kind, name, sum }] : [];
      });
      if (rows.length === 0) return [];
      return [...(this.chosen.length > 1 ? [letter(which)] : []), sums(quantity.unit, quantity.wholeUnit, rows, this.groups.share)];
    });
    const title = el("h3", { text: `Surface and building: ${quantity.shownTitle}` });
    this.parts.sums.replaceChildren(...(tables.length > 0 ? [title, ...tables] : []));
  }

  private async drawCharts(withSight: boolean): Promise<void> {
    const turn = this.turn;
    const { engine, site, weather } = this.session;
    const state: State = { ...this.store.state };
    const chosen = this.chosen;
    if (chosen.length === 0) return;
    if (this.store.state.show === "moment") await this.asker.settling();
    const changes = { reflectance: Object.entries(state.reflectance), transmittance: Object.entries(state.transmittance) };
    try {
      if (weather) {
        const months: Series[] = [];
        const days: Series[] = [];
        for (const { place } of chosen) {
          const ask = { ...place, sky: state.sky, changes };
          months.push(await engine.months(ask));
          days.push(await engine.day({ ...ask, dayOfYear: state.dayOfYear }));
          if (turn !== this.turn) return;
        }
        this.drawSeries(months, days, state.dayOfYear);
      } else {
        this.parts.charts.replaceChildren(el("h3", { text: "Months and day" }), el("p", { class: "note", text: "Open a weather file to see months and the hours of a day." }));
      }
      if (!withSight) return;
      const seen: Fisheye[] = [];
      for (const { place } of chosen) seen.push(await engine.fisheye({ ...place, side: SIDE }));
      if (turn !== this.turn) return;
      const pictures = seen.map((one, which) => {
        const figure = drawFisheye(one, chosen[which]!.info.id, site.northDeg);
        if (chosen.length > 1) figure.prepend(letter(which));
        return figure;
      });
      const note = el("p", { class: "note", text: "The upper hemisphere as on a map, zenith in the middle; lines: ways of the sun." });
      this.parts.sight.replaceChildren(el("h3", { text: "What it sees" }), el("div", { class: chosen.length > 1 ? "fishes" : "fishes single" }, ...pictures), note);
    } catch (error) {
      if (turn === this.turn) this.onError("reading the receiver", error);
    }
  }

  private drawSeries(months: Series[], days: Series[], dayOfYear: number): void {
    const { components } = this.session.site;
    const open = [...this.parts.charts.querySelectorAll("details")].map((details) => details.open);
    const draw = (series: Series[], title: string, unit: string, labels: (s: Series) => string[], labelled: (bar: number, bars: number) => string | null): HTMLElement[] => {
      const top = Math.max(...series.map((one) => topOf(components, one.values)));
      return series.map((one, which) => {
        const figure = drawChart({ title, unit, labels: labels(one), labelled: (bar) => labelled(bar, one.labels.length), components, values: one.values, top });
        if (series.length > 1) figure.prepend(letter(which));
        return figure;
      });
    };
    const hour = (bar: number, bars: number): string | null => (((bar * 24) / bars) % 3 === 0 ? String((bar * 24) / bars) : null);
    this.parts.charts.replaceChildren(
      el("h3", { text: "Months" }),
      ...draw(months, "Sums", KWH_M2, (one) => one.labels.map((label, at) => (one.labels.length === 12 ? MONTHS[at]! : label)), (bar) => MONTHS[bar]?.slice(0, 1) ?? null),
      el("h3", { text: dayName(dayOfYear) }),
      ...draw(days, "Irradiance by the clock", W_M2, (one) => one.labels, hour),
      key(components, [...months, ...days].map((one) => one.values)),
    );
    [...this.parts.charts.querySelectorAll("details")].forEach((details, at) => (details.open = open[at] ?? false));
  }
}
