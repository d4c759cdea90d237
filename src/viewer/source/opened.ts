// One opened site on the page: its meshes, colours, panels. In: a session. Everything here goes when another archive is opened.

import { Box3, type BufferGeometry, Group, LineSegments, Mesh, Vector3 } from "three";
import { Asker } from "./asker";
import { BUDGET_MB, Card } from "./card/card";
import { autoRange } from "./colour/range";
import type { Legend } from "./colour/legend";
import { readOptions } from "./blocks";
import { byId } from "./dom";
import type { LightPanel } from "./panel/light";
import type { Messages } from "./panel/messages";
import type { ShowPanel } from "./panel/show";
import { quantityOf, type Quantity } from "./quantity";
import { ReceiverPanel } from "./receiver/panel";
import type { Session } from "./session";
import { isSum, type State, type Store } from "./state";
import { Overlay } from "./view/overlay";
import { Paint } from "./view/paint";
import { Patches } from "./view/patches";
import { Picker } from "./view/pick";
import { Scenery } from "./view/scenery";
import { corners, type Stage } from "./view/stage";
import { number } from "./words";

/** Where drawing takes longer (ms), as without a graphics card, the engine gets that many times as long between two pictures. */
const SLOW = 50;
const PAINT_SHARE = 3;

export interface Page {
  store: Store;
  stage: Stage;
  legend: Legend;
  messages: Messages;
  show: ShowPanel;
  light: LightPanel;
  playing: () => boolean;
  say: (text: string) => void;
  openTab: (part: string) => void;
}

export class OpenedSite {
  readonly asker: Asker;
  readonly receiver: ReceiverPanel;
  private readonly root = new Group();
  private readonly patchGroup = new Group();
  private readonly paint: Paint;
  private readonly patches: Patches;
  private readonly picker: Picker;
  private readonly overlay: Overlay;
  private readonly stop: () => void;
  /** When colours were last on the screen, and what that took, ms. */
  private painted = 0;
  private paintCost = 0;
  private repaintAsked = false;
  /** Range of what is shown when it last had settled. */
  private settledRange: readonly [number, number] | null = null;
  private rangeOf = "";

  constructor(
    private readonly page: Page,
    readonly session: Session,
  ) {
    const { stage, store, messages } = page;
    const { site } = session;
    this.paint = new Paint(site.receivers);
    this.patches = new Patches(this.patchGroup, this.paint.material);
    this.picker = new Picker(stage.renderer);
    this.overlay = new Overlay(stage, site.northDeg);
    this.root.add(this.patchGroup);
    stage.scene.add(this.root);
    // Where the processor has to do the work of a card, the core is faster at it.
    const budgetMb = readOptions().card ?? (stage.software ? 0 : BUDGET_MB);
    const card = Card.of(stage.renderer, this.paint.texture, site.receivers, budgetMb);
    this.asker = new Asker(session, store, {
      target: () => stage.controls.target.toArray(),
      onShine: (shine) => {
        page.light.showShine(shine);
        this.overlay.showSun(shine.altitude > 0 && store.state.light !== "overcast" ? shine.azimuth : null);
      },
      onValues: (progress) => {
        this.progress(progress && isSum(store.state.show) ? progress : null);
        this.repaint();
      },
      onCard: () => {
        this.paint.use(card?.values ?? null);
        stage.draw();
      },
      onDamage: (tile, message) => messages.lost(tile, message),
      onError: (error) => messages.error("replaying the archive", error),
    }, card);
    this.receiver = new ReceiverPanel(session, store, this.asker, () => this.quantity(), (what, error) => messages.error(what, error), page.say);
    this.stop = store.subscribe((changed) => this.follow(changed));
  }

  /** Lets go of everything that stands on the page and on the graphics card. */
  close(): void {
    this.session.closed = true;
    this.stop();
    this.asker.close();
    this.receiver.close();
    this.overlay.close();
    this.page.stage.scene.remove(this.root);
    this.root.traverse((object) => {
      if (object instanceof Mesh || object instanceof LineSegments) (object.geometry as BufferGeometry).dispose();
    });
    this.asker.card?.dispose();
    this.paint.dispose();
    this.page.stage.draw();
  }

  quantity(): Quantity {
    return quantityOf(this.page.store.state, this.session, this.asker);
  }

  /** Reads what there is to see; resolves when all of it is on the screen. */
  async read(): Promise<void> {
    const { stage, store, messages } = this.page;
    const { site } = this.session;
    const box = new Box3(new Vector3(...site.bounds[0]), new Vector3(...site.bounds[1])).translate(new Vector3(...site.origin).negate());
    const { camera } = store.state;
    if (camera) {
      stage.setRadius(box);
      stage.look(new Vector3(camera[0], camera[1], camera[2]), new Vector3(camera[3], camera[4], camera[5]));
    } else stage.frame([corners(box)], box, box);
    let framed = camera !== null;
    const started = stage.camera.position.clone();
    const sceneDone = this.readScene();
    await this.session.readTiles(
      (tile, overview) => {
        this.patches.add(overview, this.session.tiles[tile]!.first);
        this.progress({ done: this.session.tiles[tile]!.first, of: site.receivers });
        this.repaint();
      },
      (tile, error) => messages.lost(tile, error),
    );
    if (this.session.closed) return;
    this.patches.flush();
    this.progress(null);
    // The receivers are what is looked at; nobody who has moved is moved.
    if (!framed && stage.camera.position.equals(started) && !this.patches.box.isEmpty()) {
      stage.frame(this.patches.points(), this.patches.box, box);
      framed = true;
    }
    this.follow(new Set(["selected", "pinned"]));
    this.repaint();
    this.asker.update();
    await sceneDone;
    await this.asker.settling();
    if (!this.session.closed) this.paintNow();
  }

  /** Resolves when values and the chosen receiver on the page are those that the state wishes for. */
  async settled(): Promise<void> {
    await this.asker.settling();
    await this.receiver.choosing;
    if (!this.session.closed) this.paintNow();
  }

  /** What is drawn at a place of the canvas becomes the chosen receiver. */
  pick(x: number, y: number): void {
    const { stage, store, say, openTab } = this.page;
    const { canvas } = stage;
    const index = this.picker.at(stage.scene, stage.camera, this.patchGroup, x, y, canvas.clientWidth, canvas.clientHeight);
    const place = index === null ? null : this.session.placeOf(index);
    if (place) {
      store.set({ selected: place });
      openTab("receiver");
    } else say("There is no receiver.");
  }

  /** The weather is another one. */
  renewWeather(): void {
    this.page.light.renew();
    this.page.show.refresh();
    this.asker.renew();
    this.receiver.drawLater(0, true);
  }

  private async readScene(): Promise<void> {
    const { site, engine } = this.session;
    const scenery = new Scenery(this.root, site.materials);
    for (let chunk = 0; chunk < site.sceneChunks; chunk++) {
      try {
        scenery.add(await engine.scene(chunk));
        this.page.stage.draw();
      } catch (error) {
        this.page.messages.error("reading the scene's triangles", error);
      }
    }
  }

  private follow(changed: ReadonlySet<keyof State>): void {
    const { store, stage } = this.page;
    const { selected, pinned, camera } = store.state;
    // Who moved by hand is there already; this is a new address.
    if (changed.has("camera") && camera) {
      const [position, target] = [new Vector3(...camera.slice(0, 3)), new Vector3(...camera.slice(3))];
      if (position.distanceTo(stage.camera.position) > 0.02 || target.distanceTo(stage.controls.target) > 0.02) stage.look(position, target);
    }
    if (changed.has("selected") || changed.has("pinned")) {
      const places = [selected, pinned].map((place) => (place ? this.session.indexOf(place) : null));
      const [a, b] = [places[0] ?? -1, places[1] ?? -1];
      this.paint.mark(a, b);
      const middles = [a, b].map((index): [number, number, number] | null =>
        index < 0 ? null : [this.session.middles[3 * index]!, this.session.middles[3 * index + 1]!, this.session.middles[3 * index + 2]!],
      );
      this.overlay.pin(0, middles[0] ?? null);
      this.overlay.pin(1, pinned && a !== b ? (middles[1] ?? null) : null);
      document.body.dataset["receiver"] = selected || pinned ? "open" : "closed";
      this.receiver.choose();
      stage.draw();
    }
    if (["show", "component", "range", "month"].some((key) => changed.has(key as keyof State))) this.repaint();
    if (["sky", "reflectance", "transmittance", "dayOfYear"].some((key) => changed.has(key as keyof State))) this.receiver.drawLater();
  }

  private progress(progress: { done: number; of: number } | null): void {
    const box = byId("progress", HTMLElement);
    box.hidden = progress === null || progress.of === 0;
    if (!progress) return;
    byId("progress-bar", HTMLElement).style.width = `${(100 * progress.done) / progress.of}%`;
    byId("progress-text", HTMLElement).textContent = `${number(progress.done)} of ${number(progress.of)} receivers`;
  }

  /** However many tiles came, colours and numbers follow once a frame. */
  private repaint(): void {
    if (this.repaintAsked) return;
    this.repaintAsked = true;
    const paint = (): void => {
      this.repaintAsked = false;
      if (this.session.closed) return;
      const began = performance.now();
      this.paintNow();
      requestAnimationFrame(() => requestAnimationFrame((now) => ([this.painted, this.paintCost] = [now, now - began])));
    };
    const wait = this.asker.settled ? 0 : this.painted + PAINT_SHARE * this.paintCost - performance.now();
    if (this.paintCost > SLOW && wait > 0) setTimeout(paint, wait);
    else requestAnimationFrame(paint);
  }

  private paintNow(): void {
    const { store, legend, stage, show, playing } = this.page;
    const quantity = this.quantity();
    const { column } = quantity;
    if (!this.byCard(quantity) && column) {
      this.paint.use(null);
      this.paint.show(column);
    }
    const range = this.rangeFor(quantity, playing());
    this.paint.range(range[0], range[1]);
    legend.show(quantity.shownTitle, quantity.unit, range);
    show.showRange(range);
    if (store.state.selected) this.receiver.showValues();
    stage.draw();
  }

  /** Whether the card has the newest colours: then no value of a receiver is touched but those that it leaves to the core. */
  private byCard(quantity: Quantity): boolean {
    const { card } = this.asker;
    if (!card?.shown || !quantity.column || this.page.store.state.show !== "moment") return false;
    const { light, component } = card.shown;
    const same = component === quantity.shown;
    if (card.complete && card.whole && same) return true;
    if (!card.serves(card.changes, quantity.shown)) return false;
    this.paint.show(quantity.column);
    card.draw(light, quantity.shown);
    this.paint.use(card.values);
    return true;
  }

  /** By hand, else from the values; while the sun moves it stands still, so that one sees light change and not the legend. */
  private rangeFor(quantity: Quantity, playing: boolean): readonly [number, number] {
    const { range } = this.page.store.state;
    if (range) return range;
    if (quantity.title === "Sky view") return [0, 100];
    const what = `${quantity.shownTitle}`;
    const fresh = what !== this.rangeOf || this.settledRange === null;
    if (quantity.column && (fresh || (this.asker.settled && !playing) || isSum(this.page.store.state.show))) {
      const found = autoRange(quantity.column);
      if (found) [this.settledRange, this.rangeOf] = [found, what];
    }
    return this.settledRange ?? [0, 1];
  }
}
