// Values of all receivers for what is shown now: a column a component, filled tile by tile.

import type { TileValues } from "./engine/client";

export class Values {
  readonly columns: Float32Array[];
  /** Number of the query that each receiver's values came from; 0: none yet. */
  private readonly askOf: Uint32Array;
  private ask = 0;
  private freshCount = 0;

  constructor(
    readonly components: readonly string[],
    readonly receivers: number,
  ) {
    this.columns = components.map(() => new Float32Array(receivers).fill(NaN));
    this.askOf = new Uint32Array(receivers);
  }

  /**
   * Begins a new query. Old values stay until new ones arrive, or go at once if they mean something
   * else.
   */
  begin(forget: boolean): void {
    this.ask += 1;
    this.freshCount = 0;
    if (forget) for (const column of this.columns) column.fill(NaN);
  }

  put(tile: TileValues): void {
    const count = tile.values[0]?.length ?? 0;
    tile.values.forEach((values, component) => this.columns[component]?.set(values, tile.first));
    for (let index = tile.first; index < tile.first + count; index++) {
      if (this.askOf[index] !== this.ask) this.freshCount += 1;
      this.askOf[index] = this.ask;
    }
  }

  /** Marks the values of a damaged tile as missing. */
  lose(first: number, count: number): void {
    for (const column of this.columns) column.fill(NaN, first, first + count);
  }

  isFresh(index: number): boolean {
    return this.ask > 0 && this.askOf[index] === this.ask;
  }

  /** Number of receivers that have values of the newest query. */
  get fresh(): number {
    return this.freshCount;
  }

  column(component: string): Float32Array | null {
    return this.columns[this.components.indexOf(component)] ?? null;
  }

  /** Returns all components of a receiver, or null until the newest query has given them. */
  of(index: number): number[] | null {
    return this.isFresh(index) ? this.columns.map((column) => column[index]!) : null;
  }
}
