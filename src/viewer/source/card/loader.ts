// Loads tiles to the graphics card while the engine has no other work, in about the order of
// moments.

import type { Changes, TileTextures } from "../engine/client";
import type { Session } from "../session";
import type { Card } from "./card";

export class Loader {
  private turn = 0;
  /** Tiles that the core has to compute. */
  private readonly left = new Set<number>();
  isLoading = false;

  constructor(
    private readonly card: Card,
    private readonly session: Session,
  ) {}

  /** Tiles that are not on the card. */
  get missing(): readonly number[] {
    return [...this.left];
  }

  stop(): void {
    this.turn += 1;
    const nothing = (): void => undefined;
    if (this.isLoading) this.session.engine.textures({ changes: { reflectance: [], transmittance: [] }, tiles: [] }, nothing, nothing).catch(nothing);
    this.isLoading = false;
  }

  /**
   * Continues an interrupted load, or begins anew for other changes, with these tiles. Resolves
   * when it is done or stopped.
   */
  async load(changes: Changes, tiles: readonly number[]): Promise<void> {
    const turn = ++this.turn;
    const { card, session, left } = this;
    const key = JSON.stringify(changes);
    if (card.changes !== key) {
      card.reset();
      card.changes = key;
      left.clear();
      for (const tile of tiles) left.add(tile);
    }
    if (card.complete) return;
    const isStopped = (): boolean => turn !== this.turn || session.closed || card.changes !== key;
    const onTile = (textures: TileTextures): void => {
      if (isStopped() || card.full) return;
      if (card.put(textures)) left.delete(textures.tile);
      if (!card.full) return;
      this.stop();
      card.complete = true;
    };
    this.isLoading = true;
    try {
      // Queries for moments report damaged tiles.
      await session.engine.textures({ changes, tiles: tiles.filter((tile) => left.has(tile)) }, onTile, () => undefined);
    } catch {
      // They report other errors, too; the core computes the remaining tiles.
    }
    if (isStopped()) return;
    this.isLoading = false;
    card.complete = true;
  }
}
