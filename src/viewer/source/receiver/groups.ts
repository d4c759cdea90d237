// Sums of a surface and of a building: means of their receivers, weighted by area. In: names and
// areas, values. Names of all tiles are needed for that; they are read once, those near by first.

import type { ReceiverInfo } from "../engine/client";
import type { Session } from "../session";

export interface Sum {
  receivers: number;
  /** Sum of areas, m2; null if a receiver has no area: then all receivers count the same. */
  area: number | null;
  mean: number;
  /** mean x area. */
  whole: number | null;
}

export type Grouping = "surface" | "object" | "building";

export class Groups {
  /** Rows in the archive and areas, by name. */
  private readonly members: Record<Grouping, Map<string, { rows: number[]; areas: (number | null)[] }>> = {
    surface: new Map(), object: new Map(), building: new Map(),
  };
  private reading: Promise<void> | null = null;
  private done = 0;

  constructor(private readonly session: Session) {}

  /** Share of the tiles whose names are known. */
  get share(): number {
    return this.done / Math.max(1, this.session.site.tiles);
  }

  /** Reads all names; `onProgress` is called now and then. */
  readAll(near: readonly [number, number, number], onProgress: () => void): Promise<void> {
    this.reading ??= this.read(near, onProgress);
    return this.reading;
  }

  sum(grouping: Grouping, name: string, values: Float32Array): Sum | null {
    const found = this.members[grouping].get(name);
    if (!found) return null;
    const areas = found.areas.every((area) => area !== null);
    let [weight, sum] = [0, 0];
    found.rows.forEach((row, at) => {
      const area = areas ? found.areas[at]! : 1;
      weight += area;
      sum += area * values[row]!;
    });
    return { receivers: found.rows.length, area: areas ? weight : null, mean: sum / weight, whole: areas ? sum : null };
  }

  private async read(near: readonly [number, number, number], onProgress: () => void): Promise<void> {
    for (const tile of this.session.tilesNear(near)) {
      if (this.session.closed) return;
      let table: ReceiverInfo[] = [];
      try {
        table = await this.session.table(tile);
      } catch {
        // A damaged tile has no values either; it is listed where they are asked for.
      }
      const first = this.session.tiles[tile]?.first;
      this.done += 1;
      if (first !== undefined) table.forEach((receiver, row) => this.take(receiver, first + row));
      if (this.done % 64 === 0) onProgress();
    }
    onProgress();
  }

  private take(receiver: ReceiverInfo, row: number): void {
    for (const grouping of ["surface", "object", "building"] as const) {
      const name = receiver[grouping];
      if (!name) continue;
      let group = this.members[grouping].get(name);
      if (!group) this.members[grouping].set(name, (group = { rows: [], areas: [] }));
      group.rows.push(row);
      group.areas.push(receiver.area);
    }
  }
}
