// One archive on the stage: its meshes, its values, their colours. In: a session. The opened site
// decides what is shown of it, and beside which other archive.

import { Box3, type BufferGeometry, Group, LineSegments, Mesh, Vector3 } from "three";
import { Asker } from "./asker";
import { Card } from "./card/card";
import type { Air } from "./engine/client";
import type { Shine } from "./light";
import type { Messages } from "./panel/messages";
import { quantityOf, type Quantity } from "./quantity";
import type { Session } from "./session";
import type { Store } from "./state";
import { Paint } from "./view/paint";
import { Patches } from "./view/patches";
import { Scenery } from "./view/scenery";
import type { Stage } from "./view/stage";

export interface Progress {
  done: number;
  of: number;
}

interface Setting {
  store: Store;
  stage: Stage;
  messages: Messages;
  /** Memory of the graphics card, MB. */
  cardMb: number;
  /** Name of the archive in reports of damage; "" if there is only one. */
  name: string;
}

interface Hooks {
  onShine(shine: Shine): void;
  /** Called with the air of people in the chosen moment. */
  onAir(air: Air): void;
  /** Called while tiles are read or values arrive; null when that is over. */
  onProgress(progress: Progress | null): void;
  /** Called when there is something new to colour. */
  onChange(): void;
  /** Called when tiles that were in view at the time of the query have values. */
  onInView(): void;
}

export class Layer {
  readonly asker: Asker;
  readonly paint: Paint;
  /** Patches of its receivers. */
  readonly patchGroup = new Group();
  private readonly root = new Group();
  private readonly patches: Patches;

  /** `before` is the layer that this one may be compared with. */
  constructor(
    private readonly setting: Setting,
    readonly session: Session,
    private readonly hooks: Hooks,
    before: Layer | null = null,
  ) {
    const { stage, store, messages, cardMb } = setting;
    const { site } = session;
    this.paint = new Paint(site.receivers, before?.paint);
    this.patches = new Patches(this.patchGroup, this.paint.material);
    this.root.position.set(...session.shift);
    this.root.visible = before === null;
    this.root.add(this.patchGroup);
    stage.scene.add(this.root);
    const card = Card.of(stage.renderer, this.paint.texture, site.receivers, cardMb);
    this.asker = new Asker(session, store, {
      view: () => stage.view(),
      onShine: hooks.onShine,
      onAir: hooks.onAir,
      onValues: (progress) => {
        hooks.onProgress(progress);
        hooks.onChange();
      },
      onInView: hooks.onInView,
      onCard: () => {
        this.paint.use(card?.values ?? null);
        stage.draw();
      },
      onDamage: (tile, message) => messages.lost(tile, message, setting.name),
      onError: (error) => messages.error("replaying the archive", error),
    }, card);
  }

  /** Frees everything on the stage and on the graphics card. */
  close(): void {
    this.session.closed = true;
    this.asker.close();
    this.setting.stage.scene.remove(this.root);
    this.root.traverse((object) => {
      if (object instanceof Mesh || object instanceof LineSegments) (object.geometry as BufferGeometry).dispose();
    });
    this.asker.card?.dispose();
    this.paint.dispose();
  }

  get visible(): boolean {
    return this.root.visible;
  }

  set visible(visible: boolean) {
    this.root.visible = visible;
  }

  /** Box of the whole scene, m from the origin of the page. */
  get bounds(): Box3 {
    const { bounds, origin } = this.session.site;
    const [low, high] = bounds.map((corner) => new Vector3(...corner));
    return new Box3(low, high).translate(new Vector3(...this.session.shift).sub(new Vector3(...origin)));
  }

  /** Box of the receivers' patches, m from the origin of the page. */
  get patchBox(): Box3 {
    return this.patches.box.clone().translate(this.root.position);
  }

  /** Returns all corners of the patches, m from the origin of the scene. */
  patchPoints(): ArrayLike<number>[] {
    return this.patches.points();
  }

  quantity(): Quantity {
    return quantityOf(this.setting.store.state, this.session, this.asker);
  }

  /** Reads places and patches of all receivers. */
  async readTiles(): Promise<void> {
    const { session, hooks, setting } = this;
    await session.readTiles(
      (tile, overview) => {
        const { first } = session.tiles[tile]!;
        this.patches.add(overview, first);
        hooks.onProgress({ done: first, of: session.site.receivers });
        hooks.onChange();
      },
      (tile, error) => setting.messages.lost(tile, error, setting.name),
    );
    if (session.closed) return;
    this.patches.flush();
    hooks.onProgress(null);
  }

  /** Reads the scene's triangles. */
  async readScene(): Promise<void> {
    const { engine, site } = this.session;
    const scenery = new Scenery(this.root, site.materials);
    for (let chunk = 0; chunk < site.sceneChunks; chunk++) {
      try {
        const read = await engine.scene(chunk);
        if (this.session.closed) return;
        scenery.add(read);
        this.setting.stage.draw();
      } catch (error) {
        if (this.session.closed) return;
        this.setting.messages.error("reading the scene's triangles", error);
      }
    }
  }

  /** Brings the newest values to the colours. */
  colour(): void {
    const quantity = this.quantity();
    const { column } = quantity;
    if (this.byCard(quantity) || !column) return;
    this.paint.use(null);
    this.paint.show(column);
  }

  /**
   * Returns true if the card has the newest colours. Then only the values of receivers that the
   * card leaves to the core are uploaded.
   */
  private byCard(quantity: Quantity): boolean {
    const { card } = this.asker;
    if (!card?.shown || !quantity.column || this.setting.store.state.show !== "moment") return false;
    const { light, component } = card.shown;
    const same = component === quantity.shown;
    if (card.complete && card.whole && same) return true;
    if (!card.serves(card.changes, quantity.shown)) return false;
    this.paint.show(quantity.column);
    card.draw(light, quantity.shown);
    this.paint.use(card.values);
    return true;
  }
}
