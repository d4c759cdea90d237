// Brings tiles to the graphics card, the nearest first, while nothing else is asked of the engine.

import type { Changes } from "../engine/client";
import type { Session } from "../session";
import type { Card } from "./card";

/** Tiles that the engine is told of at a time, as of moments. */
const NEXT = 4;

export class Loader {
  private turn = 0;
  /** Tiles that the core has to serve. */
  private left: number[] = [];

  constructor(
    private readonly card: Card,
    private readonly session: Session,
  ) {}

  /** Tiles that are not on the card. */
  get missing(): readonly number[] {
    return this.left;
  }

  stop(): void {
    this.turn += 1;
  }

  /** Goes on where it was stopped, or begins anew for other changes; resolves when done or stopped. */
  async load(changes: Changes, target: [number, number, number]): Promise<void> {
    const turn = ++this.turn;
    const { card, session } = this;
    const key = JSON.stringify(changes);
    if (card.changes !== key) {
      card.reset();
      card.changes = key;
      this.left = session.tilesNear(target);
    }
    if (card.complete) return;
    const waiting = [...this.left];
    const refused: number[] = [];
    while (waiting.length > 0) {
      const tile = waiting.shift()!;
      try {
        const textures = await session.engine.textures({ changes, tile, next: waiting.slice(0, NEXT - 1) });
        if (turn !== this.turn || session.closed || card.changes !== key) return;
        if (card.put(textures)) this.left = this.left.filter((other) => other !== tile);
        else refused.push(tile);
        if (card.full) break;
      } catch {
        // A damaged tile is told of by the moments.
        if (turn !== this.turn || session.closed) return;
        refused.push(tile);
      }
    }
    this.left = [...refused, ...waiting];
    card.complete = true;
  }
}
