// The archives that are open on the page: one, or two of them, before and after; with their colours
// and panels. In: sessions. All of it is freed when another archive is opened.

import { Vector3 } from "three";
import { readOptions } from "./blocks";
import { BUDGET_MB } from "./card/card";
import { changeOf, matched, type Partners } from "./change";
import type { Legend } from "./colour/legend";
import { PUOR } from "../../results/page/puor";
import { autoRange, symmetricRange } from "./colour/range";
import { STRESS_RANGE, bandsAmong, bandsOf, stressMap } from "./colour/stress";
import { VIRIDIS } from "../../results/page/viridis";
import { byId } from "./dom";
import { Layer, type Progress } from "./layer";
import type { LightPanel } from "./panel/light";
import type { Messages } from "./panel/messages";
import type { ShowPanel } from "./panel/show";
import type { VariantPanel } from "./panel/variant";
import type { Quantity } from "./quantity";
import { ReceiverPanel, type Side } from "./receiver/panel";
import type { Session } from "./session";
import { isOfSun, isSum, type Place, type State, type Store, type Variant } from "./state";
import { Overlay } from "./view/overlay";
import { Picker } from "./view/pick";
import { corners, type Stage } from "./view/stage";
import { number } from "./words";

/**
 * Where drawing takes longer (ms), as without a graphics card, the engine gets that many times as
 * long between two pictures.
 */
const SLOW = 50;
const PAINT_SHARE = 10;

export interface Page {
  store: Store;
  stage: Stage;
  legend: Legend;
  messages: Messages;
  show: ShowPanel;
  light: LightPanel;
  variant: VariantPanel;
  playing: () => boolean;
  say: (text: string) => void;
  openTab: (part: string) => void;
}

export class OpenedSite {
  readonly before: Layer;
  /** Layer of the archive after, if there is one. */
  after: Layer | null = null;
  /** Receivers that both archives have in common; known when all names of both are read. */
  partners: Partners | null = null;
  readonly receiver: ReceiverPanel;
  private readonly picker: Picker;
  private readonly overlay: Overlay;
  private readonly stop: () => void;
  private readonly reading = new Map<Layer, Progress>();
  /** Time of the last drawing of colours, and its duration, ms. */
  private painted = 0;
  private paintCost = 0;
  private repaintAsked = false;
  /** Number of the timer of a repaint that waits; 0: none. */
  private repaintLater = 0;
  /** Range of what is shown when it last had settled. */
  private settledRange: readonly [number, number] | null = null;
  private rangeOf = "";

  constructor(
    private readonly page: Page,
    readonly session: Session,
  ) {
    const { stage, store, messages, say } = page;
    this.picker = new Picker(stage.renderer);
    this.overlay = new Overlay(stage, session.site.northDeg);
    this.before = this.layer(session, null);
    this.receiver = new ReceiverPanel(store, {
      sides: (place) => this.sides(place),
      isWhole: () => this.after === null || this.partners !== null,
      spoken: (sides) => this.spoken(sides),
      settling: () => this.settling(),
      onError: (what, error) => messages.error(what, error),
      say,
    });
    this.stop = store.subscribe((changed) => this.follow(changed));
  }

  /** Frees everything on the page and on the graphics card. */
  close(): void {
    this.stop();
    this.receiver.close();
    this.overlay.close();
    for (const layer of this.layers) layer.close();
    this.page.variant.close();
    this.page.stage.draw();
  }

  get layers(): Layer[] {
    return this.after ? [this.before, this.after] : [this.before];
  }

  /** Variant that can be shown, as far as the archives are read. */
  get variant(): Variant {
    const { variant } = this.page.store.state;
    if (!this.after?.session.ready) return "before";
    return variant === "change" && !this.partners?.count ? "after" : variant;
  }

  /** The archive whose surfaces are shown. */
  get shown(): Layer {
    return this.variant === "before" ? this.before : (this.after ?? this.before);
  }

  /** Returns the quantity that colours and legend show. */
  quantity(): Quantity {
    const { partners, shown } = this;
    if (this.variant !== "change" || !partners) return shown.quantity();
    return changeOf(this.before.quantity(), shown.quantity(), partners, this.page.store.state.percent);
  }

  /**
   * Reads scene and receivers. Resolves when all of it is on the screen, but for values that are
   * still computed.
   */
  async read(): Promise<void> {
    const { stage, store } = this.page;
    const { before } = this;
    const box = before.bounds;
    const { camera } = store.state;
    if (camera) {
      stage.setRadius(box);
      stage.look(new Vector3(camera[0], camera[1], camera[2]), new Vector3(camera[3], camera[4], camera[5]));
    } else stage.frame([corners(box)], box, box);
    const started = stage.camera.position.clone();
    const sceneDone = before.readScene();
    await before.readTiles();
    if (this.session.closed) return;
    // The camera frames the receivers, but not if the user has moved it.
    if (camera === null && stage.camera.position.equals(started) && !before.patchBox.isEmpty()) stage.frame(before.patchPoints(), before.patchBox, box);
    this.follow(new Set(["selected", "pinned"]));
    this.repaint();
    before.asker.update();
    await sceneDone;
  }

  /** Removes the archive beside the first. */
  dropAfter(): void {
    if (!this.after) return;
    this.after.close();
    this.reading.delete(this.after);
    [this.after, this.partners] = [null, null];
    this.before.visible = true;
    this.page.variant.close();
    this.follow(new Set(["selected"]));
  }

  /**
   * Puts another archive beside it, and finds out which receivers are the same; the camera stays.
   */
  async compareWith(session: Session): Promise<Partners> {
    const { show, stage, variant } = this.page;
    const after = this.layer(session, this.before);
    this.after = after;
    this.follow(new Set(["variant"]));
    const sceneDone = after.readScene();
    await after.readTiles();
    if (!session.closed) {
      after.asker.update();
      const box = after.patchBox.union(this.before.patchBox);
      if (!box.isEmpty()) stage.setHome([...this.before.patchPoints(), corners(after.patchBox)], box, this.before.bounds.union(after.bounds));
      variant.open(null);
      this.follow(new Set(["variant"]));
    }
    await sceneDone;
    const partners = await matched(this.session, session);
    if (session.closed) return partners;
    this.partners = partners;
    after.paint.compareWith(partners.ofAfter);
    variant.open(partners.count > 0 ? partners : null);
    show.compare(partners);
    this.follow(new Set(["variant", "selected"]));
    return partners;
  }

  /** Resolves when values and the chosen receiver on the page show the state. */
  async settled(): Promise<void> {
    await this.settling();
    await this.receiver.choosing;
    if (!this.session.closed) this.paintNow();
  }

  /** Resolves when the values of all archives are those of the newest state. */
  async settling(): Promise<void> {
    await Promise.all(this.layers.map(({ asker }) => asker.settling()));
  }

  /** Resolves when the colours show the newest state, even if not all numbers do. */
  async seeing(): Promise<void> {
    await Promise.all(this.layers.map(({ asker }) => asker.seeing()));
  }

  /** Chooses the receiver that is drawn at a place of the canvas. */
  pick(x: number, y: number): void {
    const { stage, store, say, openTab } = this.page;
    const { canvas } = stage;
    const { shown } = this;
    const index = this.picker.at(stage.scene, stage.camera, shown.patchGroup, x, y, canvas.clientWidth, canvas.clientHeight);
    const place = index === null ? null : this.placeOf(shown, index);
    if (place) {
      store.set({ selected: place });
      openTab("receiver");
    } else say("There is no receiver at this point.");
  }

  /** Shows the people, once it is known if receivers are people. */
  takePeople(): void {
    this.page.show.refresh();
    this.page.light.renew();
    for (const { asker } of this.layers) asker.update();
    this.repaint();
  }

  /** Shows new values, since weather or clouds changed. */
  renew(): void {
    this.page.light.renew();
    this.page.show.refresh();
    for (const { asker } of this.layers) asker.renew();
    this.receiver.drawLater(0, true);
  }

  private layer(session: Session, before: Layer | null): Layer {
    const { page } = this;
    const { stage, store, messages } = page;
    // If the processor draws in place of a card, the core is faster. A second archive gets half as
    // much memory.
    const cardMb = (readOptions().card ?? (stage.software ? 0 : BUDGET_MB)) / (before ? 2 : 1);
    const layer = new Layer({ store, stage, messages, cardMb, name: before ? "the archive “After”" : "" }, session, {
      onShine: (shine) => {
        if (before) return;
        page.light.showShine(shine);
        this.overlay.showSun(shine.altitude > 0 && store.state.light !== "overcast" ? shine.azimuth : null);
      },
      onAir: (air) => {
        if (!before) page.light.showAir(air);
      },
      onProgress: (progress) => {
        const told = progress && (isSum(store.state.show) || isOfSun(store.state.show) || !session.ready) ? progress : null;
        if (told) this.reading.set(layer, told);
        else this.reading.delete(layer);
        this.showProgress();
      },
      onChange: () => this.repaint(),
      onInView: () => this.repaintSoon(),
    }, before);
    return layer;
  }

  /**
   * A receiver in the words of the address: that of the archive before, where it has a partner
   * there.
   */
  private placeOf(layer: Layer, index: number): Place | null {
    if (layer === this.before) return layer.session.placeOf(index);
    const partner = this.partners?.ofAfter[index] ?? -1;
    const place = partner >= 0 ? this.session.placeOf(partner) : layer.session.placeOf(index);
    return place && (partner >= 0 ? place : { ...place, after: true });
  }

  /** A receiver in each archive that has it. */
  private sides(place: Place): Side[] {
    const { before, after, partners } = this;
    const side = (layer: Layer | null, index: number | null | undefined): Side[] => {
      const there = layer && index !== null && index !== undefined && index >= 0 ? layer.session.placeOf(index) : null;
      return layer && there ? [{ layer, index: index!, ...there, when: after ? (layer === before ? "before" : "after") : null }] : [];
    };
    const own = (place.after ? after : before)?.session.indexOf(place) ?? null;
    if (own === null) return [];
    return place.after ? [...side(before, partners?.ofAfter[own]), ...side(after, own)] : [...side(before, own), ...side(after, partners?.ofBefore[own])];
  }

  /** Returns the values of a chosen receiver in words. */
  private spoken(sides: readonly Side[]): string {
    const quantity = this.quantity();
    const index = sides.find(({ layer }) => layer === this.shown)?.index;
    const value = index === undefined ? undefined : quantity.of(index)?.[quantity.components.indexOf(quantity.shown)];
    return value === undefined ? "" : quantity.label(value);
  }

  private follow(changed: ReadonlySet<keyof State>): void {
    const { store, stage } = this.page;
    const { selected, pinned, camera } = store.state;
    // If the user moved the camera, it is there already; this is a new address.
    if (changed.has("camera") && camera) {
      const [position, target] = [new Vector3(...camera.slice(0, 3)), new Vector3(...camera.slice(3))];
      if (position.distanceTo(stage.camera.position) > 0.02 || target.distanceTo(stage.controls.target) > 0.02) stage.look(position, target);
    }
    if (changed.has("variant") && this.after) {
      for (const layer of this.layers) layer.visible = layer === this.shown;
      this.page.show.refresh();
    }
    if (changed.has("selected") || changed.has("pinned") || changed.has("variant")) {
      const chosen = [selected, pinned].map((place) => (place ? this.sides(place) : []));
      for (const layer of this.layers) {
        const [a, b] = chosen.map((sides) => sides.find((side) => side.layer === layer)?.index ?? -1);
        layer.paint.mark(a!, b!);
      }
      const middles = chosen.map((sides): [number, number, number] | null => {
        const side = sides.find(({ layer }) => layer === this.shown) ?? sides[0];
        const [x = NaN, y = NaN, z = NaN] = side ? side.layer.session.middles.subarray(3 * side.index, 3 * side.index + 3) : [];
        return side ? [x, y, z] : null;
      });
      const same = JSON.stringify(selected) === JSON.stringify(pinned);
      this.overlay.pin(0, middles[0] ?? null);
      this.overlay.pin(1, same ? null : (middles[1] ?? null));
      document.body.dataset["receiver"] = selected || pinned ? "open" : "closed";
      if (changed.has("selected") || changed.has("pinned")) this.receiver.choose();
      stage.draw();
    }
    if (changed.has("clouds")) this.receiver.showClouds();
    if (["show", "component", "range", "month", "variant", "percent"].some((key) => changed.has(key as keyof State))) this.repaint();
    if (["sky", "reflectance", "transmittance", "clouds", "dayOfYear"].some((key) => changed.has(key as keyof State))) this.receiver.drawLater();
  }

  private showProgress(): void {
    const all = [...this.reading.values()];
    const [done, of] = [all.reduce((sum, one) => sum + one.done, 0), all.reduce((sum, one) => sum + one.of, 0)];
    byId("progress", HTMLElement).hidden = of === 0;
    if (of === 0) return;
    byId("progress-bar", HTMLElement).style.width = `${(100 * done) / of}%`;
    byId("progress-text", HTMLElement).textContent = `${number(done)} of ${number(of)} receivers`;
  }

  private get isSettled(): boolean {
    return this.layers.every(({ asker }) => asker.settled);
  }

  /**
   * Draws colours and numbers once a frame, however many tiles came; less often if more are to come
   * and drawing takes long.
   */
  private repaint(): void {
    const isWhole = this.isSettled && this.reading.size === 0;
    const wait = isWhole || this.paintCost <= SLOW ? 0 : this.painted + PAINT_SHARE * this.paintCost - performance.now();
    if (wait > 0) {
      this.repaintLater ||= window.setTimeout(() => this.repaintSoon(), wait);
    } else this.repaintSoon();
  }

  private repaintSoon(): void {
    clearTimeout(this.repaintLater);
    this.repaintLater = 0;
    if (this.repaintAsked) return;
    this.repaintAsked = true;
    requestAnimationFrame(async () => {
      this.repaintAsked = false;
      if (this.session.closed) return;
      const began = performance.now();
      this.paintNow();
      await this.page.stage.drawn();
      this.painted = performance.now();
      this.paintCost = this.painted - began;
    });
  }

  private paintNow(): void {
    const { store, legend, stage, show, playing } = this.page;
    const { shown } = this;
    const isChange = this.variant === "change";
    for (const layer of isChange ? this.layers : [shown]) layer.colour();
    const quantity = this.quantity();
    // The classes of the UTCI have colours of their own, unless the user set a range.
    const stress = isChange || store.state.range ? undefined : quantity.stress;
    const map = isChange ? PUOR : stress ? stressMap(stress) : VIRIDIS;
    shown.paint.shows(isChange ? (store.state.percent ? "percent" : "change") : "values", map);
    const range = this.rangeFor(quantity, playing());
    const [low, high] = stress ? STRESS_RANGE : range;
    shown.paint.range(low, high);
    const columns = this.layers.map((layer) => layer.quantity().column).filter((column) => column !== null);
    const bands = stress ? { bands: bandsAmong(bandsOf(stress), columns) } : {};
    legend.show({ title: quantity.shownTitle, unit: quantity.unit, range, map, ...bands });
    show.showRange(range);
    if (store.state.selected) this.receiver.showValues();
    stage.draw();
  }

  /**
   * Returns the range set by hand, else the range of the values. While the sun moves the range
   * stays, so that changes of colour show changes of light.
   */
  private rangeFor(quantity: Quantity, playing: boolean): readonly [number, number] {
    const { range, show } = this.page.store.state;
    if (range) return range;
    const isChange = this.variant === "change";
    if (quantity.title === "Sky view" && !isChange) return [0, 100];
    const what = `${quantity.shownTitle} ${quantity.unit} ${this.layers.length}`;
    const fresh = what !== this.rangeOf || this.settledRange === null;
    if (quantity.column && (fresh || (this.isSettled && !playing) || isSum(show) || isOfSun(show))) {
      // Before and after share one range of colours.
      const columns = this.layers.map((layer) => layer.quantity().column).filter((column) => column !== null);
      const found = isChange ? symmetricRange(quantity.column) : autoRange(...columns);
      if (found) [this.settledRange, this.rangeOf] = [found, what];
    }
    return this.settledRange ?? [0, 1];
  }
}
