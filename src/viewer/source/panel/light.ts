// Controls of sun and sky. In: the state. Out: the state. The engine says where the sun stands.

import { byId, el, options } from "../dom";
import type { Air } from "../engine/client";
import { knowsClearSkies, type Shine } from "../light";
import { airOf, comfortOf } from "../people";
import type { Session } from "../session";
import { isOfSun, isSum, type LightFrom, type Store } from "../state";
import { CELSIUS, clock, dayName, skyLabel, W_M2 } from "../words";
import { Dial } from "./dial";

const SLIDERS = ["day", "clock", "azimuth", "altitude", "dni", "dhi"] as const;
const AIR_SLIDERS = ["air", "humidity", "wind"] as const;
const KEYS = { day: "dayOfYear", clock: "minutes", azimuth: "azimuth", altitude: "altitude", dni: "dni", dhi: "dhi" } as const;

export class LightPanel {
  private readonly from = byId("light-from", HTMLSelectElement);
  private readonly sky = byId("sky-model", HTMLSelectElement);
  private readonly radios = [...document.querySelectorAll<HTMLInputElement>('input[name="sun-by"]')];
  private readonly facts = byId("sun-facts", HTMLElement);
  private readonly cloudsTop = byId("clouds-top", HTMLInputElement);
  private readonly dial: Dial;
  private session: Session | null = null;
  private wayOf = "";

  constructor(private readonly store: Store, onRemove: () => void) {
    this.dial = new Dial((direction) => this.change({ ...direction, ...this.anglesNeed() }));
    for (const id of SLIDERS) {
      const slider = byId(id, HTMLInputElement);
      slider.addEventListener("input", () => this.change({ [KEYS[id]]: slider.valueAsNumber }));
    }
    for (const id of AIR_SLIDERS) {
      const slider = byId(id, HTMLInputElement);
      slider.addEventListener("input", () => store.set({ [id]: slider.valueAsNumber }));
    }
    this.from.addEventListener("change", () => {
      const light = this.from.value as LightFrom;
      this.change(light === "weather" || light === "clear" ? { light, sunBy: "clock" } : { light });
    });
    this.sky.addEventListener("change", () => store.set({ sky: this.sky.value }));
    for (const radio of this.radios) {
      radio.addEventListener("change", () => this.change(radio.value === "angles" ? this.anglesNeed() : { sunBy: "clock" }));
    }
    this.cloudsTop.addEventListener("input", () => this.turnClouds(this.cloudsTop.valueAsNumber));
    byId("remove-clouds", HTMLButtonElement).addEventListener("click", onRemove);
    store.subscribe(() => this.refresh());
  }

  open(session: Session): void {
    this.session = session;
    this.renew();
  }

  /** Shows new sun and sky, since weather or clouds changed. */
  renew(): void {
    this.wayOf = "";
    this.dial.showClouds(this.session?.clouds?.map ?? null);
    this.refresh();
  }

  /** Turns the clouds; what is shown stays where it depends on them. */
  turnClouds(clouds: number): void {
    if (isSum(this.store.state.show)) this.store.set({ clouds });
    else this.change({ clouds });
  }

  showShine(shine: Shine): void {
    this.dial.showSun(shine);
    const rows: [string, string][] = [
      ["Azimuth", `${shine.azimuth.toFixed(1)}°`],
      ["Altitude", `${shine.altitude.toFixed(1)}°`],
      ["DNI", `${Math.round(shine.dni)} ${W_M2}`],
      ["DHI", `${Math.round(shine.dhi)} ${W_M2}`],
    ];
    if (shine.label !== null) rows.push(["Hour", shine.label.replace("T", " ")]);
    this.facts.replaceChildren(...rows.flatMap(([name, value]) => [el("dt", { text: name }), el("dd", { text: value })]));
  }

  /** The air of the moment for people outdoors. */
  showAir({ temperature, humidity, wind, sky }: Air): void {
    const { state } = this.store;
    const own = airOf(state, this.session?.weather ?? null).kind === "own";
    const rows: [string, number | null, string][] = own ? [] : [["Air", temperature, CELSIUS], ["Humidity", humidity, "%"], ["Wind", wind, "m/s"]];
    rows.push([own ? `Longwave of ${state.light === "overcast" ? "an overcast" : "a clear"} sky` : "Longwave of the sky", sky, W_M2]);
    const texts = rows.map(([name, value, unit]): [string, string] => [name, value === null ? "not known" : `${value.toFixed(unit === "%" || unit === W_M2 ? 0 : 1)} ${unit}`]);
    byId("air-facts", HTMLElement).replaceChildren(...texts.flatMap(([name, value]) => [el("dt", { text: name }), el("dd", { text: value })]));
  }

  /** Shows the source of the air of people. */
  private refreshAir(session: Session): void {
    const { state } = this.store;
    const isAsked = state.show === "moment" && comfortOf(state, session.people) !== null;
    byId("air-box", HTMLElement).hidden = !isAsked;
    if (!isAsked) return;
    byId("own-air", HTMLElement).hidden = airOf(state, session.weather).kind !== "own";
    const texts = { air: `${state.air} ${CELSIUS}`, humidity: `${state.humidity} %`, wind: `${state.wind} m/s` };
    for (const id of AIR_SLIDERS) {
      const slider = byId(id, HTMLInputElement);
      slider.value = String(state[id]);
      slider.setAttribute("aria-valuetext", texts[id]);
      byId(`${id}-text`, HTMLOutputElement).textContent = texts[id];
    }
  }

  /** Touching the sun or the sky shows the moment, unless sums are shown that depend on it. */
  private change(changes: Parameters<Store["set"]>[0]): void {
    const { show } = this.store.state;
    const ofDay = (show === "day" || isOfSun(show)) && Object.keys(changes).every((key) => key === "dayOfYear");
    this.store.set(ofDay ? changes : { ...changes, show: "moment", ...(show === "moment" ? {} : { range: null }) });
  }

  /**
   * A sun by angles has no hour of a weather file and no clear sky of a date: it shines by DNI and
   * DHI.
   */
  private anglesNeed(): Parameters<Store["set"]>[0] {
    const { light } = this.store.state;
    return { sunBy: "angles", light: light === "overcast" ? light : "own" };
  }

  private refresh(): void {
    const { session } = this;
    if (!session) return;
    const { state } = this.store;
    const placed = session.site.place !== null || session.weather !== null;
    options(this.from, [
      { value: "weather", label: session.weather ? "Hour of the weather file" : "Hour of a weather file – open one first", disabled: !session.weather },
      ...(knowsClearSkies(session.engine) ? [{ value: "clear", label: placed ? "Clear sky" : "Clear sky – needs a place", disabled: !placed }] : []),
      { value: "overcast", label: "Overcast: no sun" },
      { value: "own", label: "Own DNI and DHI" },
    ]);
    this.from.value = state.light;
    if (state.show !== "moment") this.facts.replaceChildren(el("dt", { class: "hint", text: "Move the sun to see one moment." }));
    this.showClouds(session);
    this.refreshAir(session);
    for (const radio of this.radios) {
      radio.checked = radio.value === state.sunBy;
      radio.disabled = radio.value === "clock" && !placed;
    }
    const byClock = state.sunBy === "clock";
    byId("by-clock", HTMLElement).hidden = !byClock;
    byId("by-angles", HTMLElement).hidden = byClock;
    byId("own-light", HTMLElement).hidden = state.light === "weather" || state.light === "clear";
    byId("row-dni", HTMLElement).hidden = state.light === "overcast";
    byId("play", HTMLElement).hidden = !byClock;
    const texts = {
      day: dayName(state.dayOfYear),
      clock: clock(state.minutes),
      azimuth: `${state.azimuth}°`,
      altitude: `${state.altitude}°`,
      dni: `${state.dni} ${W_M2}`,
      dhi: `${state.dhi} ${W_M2}`,
    };
    for (const id of SLIDERS) {
      const slider = byId(id, HTMLInputElement);
      slider.value = String(state[KEYS[id]]);
      slider.setAttribute("aria-valuetext", texts[id]);
      byId(`${id}-text`, HTMLOutputElement).textContent = texts[id];
    }
    void this.followSun(session, placed);
  }

  /** Shows the clouds, and which skies they can stand before. */
  private showClouds(session: Session): void {
    const { state } = this.store;
    const top = session.cloudsTop(state);
    const barred = new Set(top === null ? [] : session.site.cloudlessSkies);
    options(this.sky, session.site.skies.map((value) => ({ value, label: barred.has(value) ? `${skyLabel(value)} – not with clouds` : skyLabel(value), disabled: barred.has(value) })));
    this.sky.value = state.sky;
    const name = byId("clouds-name", HTMLElement);
    name.textContent = session.clouds?.name ?? "";
    byId("remove-clouds", HTMLButtonElement).hidden = byId("row-turn", HTMLElement).hidden = name.hidden = top === null;
    byId("clouds-note", HTMLElement).hidden = state.clouds === null || session.clouds !== null;
    this.dial.turnClouds(top);
    if (top === null) return;
    const text = `${top}°`;
    this.cloudsTop.value = String(top);
    this.cloudsTop.setAttribute("aria-valuetext", text);
    byId("clouds-top-text", HTMLOutputElement).textContent = text;
  }

  /** The way of the sun on the chosen day, and the sun where no moment is asked for. */
  private async followSun(session: Session, placed: boolean): Promise<void> {
    const { state } = this.store;
    if (state.sunBy === "angles") {
      this.dial.showSun(state);
      this.dial.showWay([]);
      this.wayOf = "";
      return;
    }
    if (!placed || this.wayOf === String(state.dayOfYear)) return;
    const day = state.dayOfYear;
    this.wayOf = String(day);
    const halfHours = Array.from({ length: 49 }, (_, at) => Math.min(1439, 30 * at));
    try {
      const way = await Promise.all(halfHours.map((minutes) => session.engine.sun(day, minutes)));
      if (this.wayOf === String(day)) this.dial.showWay(way);
      if (state.show !== "moment") this.dial.showSun(await session.engine.sun(day, state.minutes));
    } catch {
      this.dial.showWay([]);
    }
  }
}
