// Brings tiles to the graphics card while nothing else is asked of the engine, in about the order of moments.

import type { Changes, TileTextures } from "../engine/client";
import type { Session } from "../session";
import type { Card } from "./card";

export class Loader {
  private turn = 0;
  /** Tiles that the core has to serve. */
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

  /** Goes on where it was stopped, or begins anew for other changes, with these tiles of all; resolves when done or stopped. */
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
      // A damaged tile is told of by the moments.
      await session.engine.textures({ changes, tiles: tiles.filter((tile) => left.has(tile)) }, onTile, () => undefined);
    } catch {
      // So is what else is wrong; the core serves what is left.
    }
    if (isStopped()) return;
    this.isLoading = false;
    card.complete = true;
  }
}
