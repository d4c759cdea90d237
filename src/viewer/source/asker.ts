// Keeps values in step with the state. One query runs at a time: newer states wait meanwhile, and
// only the newest of them is asked for.

import type { Card } from "./card/card";
import { Loader } from "./card/loader";
import type { Air } from "./engine/client";
import type { Session } from "./session";
import { shineOf, type Shine } from "./light";
import { airOf, comfortOf, namesOf } from "./people";
import { isOfSun, isSum, type State, type Store } from "./state";
import type { View } from "./view/stage";
import { Values } from "./values";

/**
 * Time after which a sun that does not move is at rest, ms: then the core's values replace the
 * card's.
 */
const REST_MS = 180;

/** Shortest time between two changes of the order of tiles by a moving camera, ms. */
const TURN_MS = 100;

interface Hooks {
  /** The present view: its tiles come first. */
  view(): View;
  onShine(shine: Shine): void;
  /** Called with the air of people in the chosen moment. */
  onAir(air: Air): void;
  /** Called when values arrived or are about to be asked for; null when that is over. */
  onValues(progress: { done: number; of: number } | null): void;
  /** Called when all tiles in view at the time of the query have values. */
  onInView(): void;
  /** Called when the card has the colours of the newest light. */
  onCard(): void;
  onDamage(tile: number, message: string): void;
  onError(error: unknown): void;
}

/** Returns the part of the state on which values depend, as a key. */
function wish(state: State, session: Session): string {
  const weather = session.weather !== null;
  const isFelt = comfortOf(state, session.people) !== null;
  const changes = [state.reflectance, state.transmittance, state.sky, session.cloudsTop(state), isFelt];
  switch (state.show) {
    case "sky":
    case "reference":
      return state.show;
    case "sunlight":
    case "glare":
      return JSON.stringify([state.show, weather, state.dayOfYear]);
    case "year":
      return JSON.stringify([state.show, weather, changes]);
    case "month":
      return JSON.stringify([state.show, weather, changes, state.month]);
    case "day":
      return JSON.stringify([state.show, weather, changes, state.dayOfYear]);
    case "moment": {
      const sun = state.sunBy === "angles" ? [state.azimuth, state.altitude] : [state.dayOfYear, state.minutes];
      return JSON.stringify([state.show, weather, changes, state.light, sun, state.dni, state.dhi, isFelt && airOf(state, session.weather)]);
    }
  }
}

export class Asker {
  readonly values: Values;
  /** Minutes of the sun on a day, or of the sun in mirrors. */
  readonly minutes: Values;
  /** True when all available values of the newest state are known. */
  settled = true;
  shine: Shine | null = null;
  /** Air of the last moment that people were asked for. */
  air: Air | null = null;
  /** Values of people, by the names of the numbers. */
  private readonly ofPeople = new Map<string, Values>();
  private readonly stop: () => void;
  private wished = "";
  /** Number of the newest state that was asked for. */
  private wishes = 0;
  private shown = "";
  private ask = 0;
  private waiting = false;
  private isTurning = false;
  /** True when the card has drawn the newest state. */
  private drawn = false;
  private whenSettled: (() => void)[] = [];
  private whenSeen: (() => void)[] = [];
  private readonly loader: Loader | null;

  constructor(
    private readonly session: Session,
    private readonly store: Store,
    private readonly hooks: Hooks,
    readonly card: Card | null,
  ) {
    this.loader = card && new Loader(card, session);
    this.values = new Values(session.site.components, session.site.receivers);
    this.minutes = new Values(["minutes"], session.site.receivers);
    this.stop = store.subscribe((changed) => {
      if (changed.has("camera")) this.preferInView();
      this.update();
    });
  }

  /** Returns the numbers of people with these names. */
  felt(names: readonly string[]): Values {
    const key = names.join();
    let values = this.ofPeople.get(key);
    if (!values) this.ofPeople.set(key, (values = new Values(names, this.session.site.receivers)));
    return values;
  }

  private valuesOf(state: State): Values {
    if (isOfSun(state.show)) return this.minutes;
    return comfortOf(state, this.session.people) === null ? this.values : this.felt(namesOf(state, this.session.people));
  }

  /** Discards all answers that still come. */
  close(): void {
    this.stop();
    this.loader?.stop();
    this.ask += 1;
    for (const resolve of [...this.whenSettled.splice(0), ...this.whenSeen.splice(0)]) resolve();
  }

  /** Asks again if the state needs other values. */
  update(): void {
    const now = wish(this.store.state, this.session);
    if (now === this.wished) return;
    this.wished = now;
    this.wishes += 1;
    this.settled = this.drawn = false;
    this.loader?.stop();
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      void this.run();
    });
  }

  /** Asks again for all values that depend on weather or clouds, since these changed. */
  renew(): void {
    this.wished = "";
    this.shown = "";
    this.update();
  }

  settling(): Promise<void> {
    return this.settled ? Promise.resolve() : new Promise((resolve) => this.whenSettled.push(resolve));
  }

  /** Resolves when the colours show the newest state, even if not all numbers do. */
  seeing(): Promise<void> {
    return this.settled || this.drawn ? Promise.resolve() : new Promise((resolve) => this.whenSeen.push(resolve));
  }

  private async run(): Promise<void> {
    const ask = ++this.ask;
    const { wishes } = this;
    try {
      const done = await this.askEngine(() => ask === this.ask);
      if (!done || ask !== this.ask) return;
    } catch (error) {
      if (ask !== this.ask) return;
      // Values shown before belong to another query.
      const values = this.valuesOf(this.store.state);
      if (values.fresh === 0) values.begin(true);
      this.hooks.onError(error);
    }
    // A newer state may wait for the next picture.
    if (wishes !== this.wishes || this.wished !== wish(this.store.state, this.session)) return;
    this.settled = true;
    if (this.card) this.card.shown = null;
    this.hooks.onValues(null);
    this.load();
    for (const resolve of [...this.whenSettled.splice(0), ...this.whenSeen.splice(0)]) resolve();
  }

  /** Returns true if the query was completed, false if a newer one replaced it. */
  private async askEngine(isNewest: () => boolean): Promise<boolean> {
    const { session, hooks } = this;
    const { engine, site } = session;
    const state: State = { ...this.store.state };
    const kind = state.show;
    const values = this.valuesOf(state);
    const isFelt = comfortOf(state, session.people) !== null;
    const asked = isFelt ? `felt ${kind}` : kind;
    const forget = asked !== this.shown;
    // The engine drops queries of another kind, whose values are no longer needed.
    if (forget && isSum(this.shown as State["show"]) && (isFelt || !isSum(kind))) void this.drop("sums");
    if (forget && isOfSun(this.shown as State["show"]) && !isOfSun(kind)) void this.drop("sunMinutes");
    if (forget && this.shown === "moment") void this.drop("moment");
    if (forget && this.shown.startsWith("felt") && !isFelt) void this.drop("comfort");
    const sums = isSum(kind);
    if (!sums && !isOfSun(kind) && kind !== "moment") {
      this.shown = kind;
      return true;
    }
    session.turnClouds(state);
    const changes = session.changes(state);
    const common = { sky: state.sky, changes, components: [...site.components] };
    const { tiles, seen } = session.tilesInOrder(hooks.view());
    const inView = new Set(tiles.slice(0, seen));
    const begin = (): void => {
      values.begin(forget);
      this.shown = asked;
      hooks.onValues({ done: 0, of: site.receivers });
    };
    const onTile = (tile: Parameters<Values["put"]>[0]): void => {
      if (!isNewest()) return;
      values.put(tile);
      hooks.onValues({ done: values.fresh, of: site.receivers });
      if (inView.delete(tile.tile) && inView.size === 0) hooks.onInView();
    };
    const onDamage = (tile: number, message: string): void => {
      if (!isNewest()) return;
      const lost = session.tiles[tile];
      if (lost) values.lose(lost.first, lost.count);
      hooks.onDamage(tile, message);
    };
    if (isOfSun(kind)) {
      begin();
      return engine.sunMinutes({ dayOfYear: state.dayOfYear, inMirrors: kind === "glare", tiles }, onTile, onDamage);
    }
    if (sums) {
      begin();
      if (!session.weather) return true;
      const span = kind === "month" ? { kind, month: state.month } : kind === "day" ? { kind, dayOfYear: state.dayOfYear } : { kind: "year" as const };
      if (isFelt) return engine.comfort({ of: "span", span, sky: state.sky, changes, names: values.components, tiles }, onTile, onDamage);
      return engine.sums({ span, ...common, tiles }, onTile, onDamage);
    }
    if (state.light === "weather" && !session.weather) {
      begin();
      return true;
    }
    const shine = await shineOf(session.suns, state, session.weather);
    if (!isNewest()) return false;
    this.shine = shine;
    hooks.onShine(shine);
    const { card } = this;
    if (isFelt) {
      if (card) card.shown = null;
      begin();
      const air = airOf(state, session.weather);
      const known = await engine.air(air);
      if (!isNewest()) return false;
      this.air = known;
      hooks.onAir(known);
      return engine.comfort({ of: "moment", light: shine.light, air, sky: state.sky, changes, names: values.components, tiles }, onTile, onDamage);
    }
    const ask = { light: shine.light, ...common };
    if (card && this.loader && !forget && shine.light.kind === "sun" && card.serves(JSON.stringify(changes), state.component)) {
      begin();
      // Only what the card does not have, and what is read in tables, keeps in step with a sun that
      // moves.
      const chosen = [state.selected, state.pinned].flatMap((place) => (place ? [place.tile] : []));
      const some = engine.moment({ ...ask, tiles: [...new Set([...chosen, ...this.loader.missing])] }, onTile, onDamage);
      // The failure is reported where the result is awaited.
      some.catch(() => undefined);
      const light = await engine.light({ ...ask, tiles: [] });
      if (!isNewest()) return false;
      // The user may have chosen another component since.
      const { component } = this.store.state;
      if (card.serves(JSON.stringify(changes), component)) {
        card.draw(light, component);
        hooks.onCard();
      }
      if (!(await some) || !isNewest()) return false;
      this.drawn = true;
      for (const resolve of this.whenSeen.splice(0)) resolve();
      await new Promise((resolve) => setTimeout(resolve, REST_MS));
      if (!isNewest()) return false;
    } else {
      if (card) card.shown = null;
      begin();
    }
    return engine.moment({ ...ask, tiles }, onTile, onDamage);
  }

  /** Loads receivers to the card for the next time that the sun moves. */
  private load(): void {
    const { state } = this.store;
    if (!this.loader || state.show !== "moment" || state.light === "weather" || comfortOf(state, this.session.people) !== null) return;
    void this.loader.load(this.session.changes(state), this.session.tilesInOrder(this.hooks.view()).tiles);
  }

  /** Asks for tiles that come into view first. */
  private preferInView(): void {
    if (this.isTurning || (this.settled && !this.loader?.isLoading)) return;
    this.isTurning = true;
    setTimeout(() => {
      this.isTurning = false;
      if (!this.session.closed) this.session.engine.prefer(this.session.tilesInOrder(this.hooks.view()).tiles);
    }, TURN_MS);
  }

  private async drop(what: "sums" | "sunMinutes" | "moment" | "comfort"): Promise<void> {
    const nothing = { sky: this.store.state.sky, changes: { reflectance: [], transmittance: [] }, components: ["total"], tiles: [] };
    const ignore = (): void => undefined;
    try {
      if (what === "sunMinutes") await this.session.engine.sunMinutes({ dayOfYear: 1, inMirrors: false, tiles: [] }, ignore, ignore);
      else if (what === "comfort") await this.session.engine.comfort({ of: "span", span: { kind: "year" }, ...nothing, names: [] }, ignore, ignore);
      else if (what === "sums") await this.session.engine.sums({ span: { kind: "year" }, ...nothing }, ignore, ignore);
      else await this.session.engine.moment({ light: { kind: "sun", azimuth: 0, altitude: -1, dni: 0, dhi: 0 }, ...nothing }, ignore, ignore);
    } catch {
      // The next query reports the engine's error.
    }
  }
}
