// Change of a quantity from one archive to another. In: the quantity in both, and which receivers
// are the same. Out: the change, by receivers of the archive after.

import { type Matching, NO_PARTNER, type ReceiverPlace } from "./engine/client";
import type { Quantity } from "./quantity";
import type { Session } from "./session";
import { CELSIUS, signed } from "./words";

/** Receivers of two archives that are the same ones; -1 stands for none. */
export class Partners {
  /** [receiver after]: the receiver before. */
  readonly ofAfter: Int32Array;
  /** [receiver before]: the receiver after. */
  readonly ofBefore: Int32Array;
  readonly count: number;

  constructor(pairs: readonly (readonly [before: number, after: number])[], before: number, after: number, readonly moved: number) {
    this.ofAfter = new Int32Array(after).fill(-1);
    this.ofBefore = new Int32Array(before).fill(-1);
    for (const [one, other] of pairs) [this.ofAfter[other], this.ofBefore[one]] = [one, other];
    this.count = pairs.length;
  }
}

/**
 * Returns the properties by which receivers of an archive are recognised, with their rows.
 * Receivers of damaged tiles are missing.
 */
async function placesOf(session: Session): Promise<{ places: ReceiverPlace[]; rows: number[] }> {
  const [places, rows]: [ReceiverPlace[], number[]] = [[], []];
  for (const [tile, { first }] of session.tiles.entries()) {
    if (session.closed) break;
    try {
      (await session.table(tile)).forEach(({ id, position, normal }, row) => {
        places.push({ id, position, normal });
        rows.push(first + row);
      });
    } catch {
      // The request for its values reports a damaged tile.
    }
  }
  return { places, rows };
}

/** Lets the engine find the receivers that two archives have in common. */
export async function matched(before: Session, after: Session): Promise<Partners> {
  const [one, other] = await Promise.all([placesOf(before), placesOf(after)]);
  const { partners, moved }: Matching = await after.engine.match(one.places, other.places);
  const pairs: [number, number][] = [];
  partners.forEach((partner, at) => {
    if (partner !== NO_PARTNER) pairs.push([one.rows[partner]!, other.rows[at]!]);
  });
  return new Partners(pairs, before.site.receivers, after.site.receivers, moved);
}

/** Returns the change in percent of the value before; NaN if that is 0. */
export function percentOf(before: number, after: number): number {
  return before === 0 ? NaN : (100 * (after - before)) / before;
}

/** Returns the change by receivers of the archive after; NaN for a receiver without a partner. */
export function changeOf(before: Quantity, after: Quantity, partners: Partners, percent: boolean): Quantity {
  // A temperature has no meaningful percentage.
  const isShare = percent && after.unit !== CELSIUS;
  const differ = (one: number, other: number): number => (isShare ? percentOf(one, other) : other - one);
  const unit = isShare ? "% of before" : after.unit === "%" ? "% points" : after.unit === CELSIUS ? "K" : after.unit;
  // Comfort before and light after cannot be compared.
  if (before.unit !== after.unit || before.shown !== after.shown) return { ...after, shownTitle: "No change to show: two different quantities", column: null, of: () => null };
  const [from, to] = [before.column, after.column];
  const column = from && to && to.map((value, row) => (partners.ofAfter[row]! < 0 ? NaN : differ(from[partners.ofAfter[row]!]!, value)));
  return {
    ...after,
    shownTitle: `Change: ${after.shownTitle}`,
    unit,
    column,
    of: (row) => {
      const partner = partners.ofAfter[row]!;
      const [one, other] = [partner < 0 ? null : before.of(partner), after.of(row)];
      return one && other && other.map((value, at) => differ(one[at]!, value));
    },
    label: (value) => `${signed(value)} ${unit}`,
  };
}
