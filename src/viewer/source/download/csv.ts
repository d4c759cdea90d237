// The shown values as CSV: a row a receiver, columns named as `replay` and `compare` name
// them, and the inputs of the result on top.

import { percentOf, type Partners } from "../change";
import type { ReceiverInfo } from "../engine/client";
import type { Layer } from "../layer";
import { comfortOf } from "../people";
import type { Session } from "../session";
import { isOfSun, isSum, type State } from "../state";

/** One archive, or two of which one is before. */
interface Site {
  before: Layer;
  after: Layer | null;
  partners: Partners | null;
}

/** Returns the inputs of a result, a line each. */
export function provenance(state: State, { before, after }: Site): string[] {
  const { site, weather } = before.session;
  const { shine } = before.asker;
  const lines = [`archive: ${site.name}`, `root: ${site.root}`, `written by: ${site.creator}`];
  if (after) lines.push(`archive after: ${after.session.site.name}`, `root after: ${after.session.site.root}`, `written after by: ${after.session.site.creator}`);
  const shown: Record<State["show"], string> = {
    sky: "sky view, share of an open sky", reference: "a clear year, kWh/m2", year: "sums of the year, kWh/m2",
    sunlight: `hours of possible sun on day ${state.dayOfYear} of the year`, glare: `minutes of sun in mirrors on day ${state.dayOfYear} of the year`,
    month: `sums of month ${state.month}, kWh/m2`, day: `sums of day ${state.dayOfYear} of the year, kWh/m2`, moment: "irradiance of a moment, W/m2",
  };
  const isFelt = comfortOf(state, before.session.people) !== null;
  lines.push(`shown: ${isFelt ? shown[state.show].replace(/^irradiance|^sums/, "comfort of people").replace(/, (kWh|W)\/m2$/, "") : shown[state.show]}`);
  if (state.show === "sky" || state.show === "reference" || isOfSun(state.show)) return lines;
  if (weather && (isSum(state.show) || state.light === "weather")) lines.push(`weather: ${weather.name}, ${weather.place}`);
  if (state.show === "moment" && shine) {
    if (shine.label !== null) lines.push(`hour: ${shine.label}`);
    lines.push(`sun: azimuth ${shine.azimuth} deg, altitude ${shine.altitude} deg`, `dni_w_m2: ${shine.dni}`, `dhi_w_m2: ${shine.dhi}`);
  }
  const { air } = before.asker;
  if (isFelt && state.show === "moment" && air) {
    const known = [["air_c", air.temperature], ["humidity_percent", air.humidity], ["wind_m_s", air.wind], ["sky_longwave_w_m2", air.sky]] as const;
    for (const [name, value] of known) if (value !== null) lines.push(`${name}: ${figures(value)}`);
  }
  lines.push(`sky: ${state.sky}`);
  const top = before.session.cloudsTop(state);
  if (top !== null) lines.push(`clouds: ${before.session.clouds!.name}`, `image_top_deg: ${top}`);
  for (const key of ["reflectance", "transmittance"] as const) {
    for (const [name, value] of Object.entries(state[key])) lines.push(`${key}: ${name}=${value}`);
  }
  return lines;
}

function cell(text: string): string {
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

function figures(value: number): string {
  return Number.isFinite(value) ? String(Number(value.toPrecision(7))) : "";
}

/**
 * Returns the names of columns. For two archives they are before, after, change and percent of each
 * component.
 */
function columnsOf(components: readonly string[], suffix: string, isPair: boolean): string[] {
  return components.flatMap((name) => {
    const whole = name + suffix;
    return isPair ? [`before_${whole}`, `after_${whole}`, `change_${whole}`, `change_${name}_percent`] : [whole];
  });
}

/** Returns the values of these columns; empty where there is none. */
function cells(components: readonly string[], before: readonly number[] | null, after: readonly number[] | null): string[] {
  return components.flatMap((_, at) => {
    const [one, other] = [before?.[at] ?? NaN, after?.[at] ?? NaN];
    return [one, other, other - one, percentOf(one, other)].map(figures);
  });
}

/**
 * Makes the CSV. `onProgress` gets the share done, since names of all receivers may have to be
 * read.
 */
export async function csv(state: State, site: Site, onProgress: (share: number) => void): Promise<Blob> {
  const { before, after, partners } = site;
  const pair = after && partners;
  const [former, latter] = [before.quantity(), (after ?? before).quantity()];
  const { components } = former;
  // Comfort before and light after cannot be compared.
  const compares = former.unit === latter.unit && former.shown === latter.shown;
  const columns = columnsOf(components, former.suffix, pair !== null);
  const chunks = [...provenance(state, site).map((line) => `# ${line.replaceAll(/[\r\n]+/g, " ")}\n`)];
  chunks.push(`${["receiver", "surface", "object", "building", "area_m2", "x", "y", "z", "tilt_deg", "azimuth_deg", "sky_view", ...columns].join(",")}\n`);
  // With two archives, the receivers after come first, then those that only the archive before has.
  const archives = pair ? [after, before] : [before];
  for (const [which, layer] of archives.entries()) {
    const { session } = layer;
    const { isRow } = layer === before ? former : latter;
    const valuesOf = (index: number): string[] | null => {
      if (!pair) return components.map((_, at) => figures(former.of(index)?.[at] ?? NaN));
      if (layer === before) return partners.ofBefore[index]! >= 0 ? null : cells(components, former.of(index), null);
      const partner = partners.ofAfter[index]!;
      return cells(components, partner < 0 ? null : former.of(partner), compares ? latter.of(index) : null);
    };
    for (const [number, tile] of session.tiles.entries()) {
      onProgress((which + number / session.tiles.length) / archives.length);
      let table;
      try {
        table = await session.table(number);
      } catch (error) {
        chunks.push(`# tile ${number} is damaged: ${(error instanceof Error ? error.message : String(error)).replaceAll(/[\r\n]+/g, " ")}\n`);
        continue;
      }
      const rows = table.flatMap((receiver, row) => {
        const index = tile.first + row;
        const values = (isRow?.(index) ?? true) ? valuesOf(index) : null;
        return values ? [`${[...about(receiver, session, index), ...values].join(",")}\n`] : [];
      });
      chunks.push(rows.join(""));
    }
  }
  onProgress(1);
  return new Blob(chunks, { type: "text/csv" });
}

/** Returns the columns that identify a receiver and its place. */
function about(receiver: ReceiverInfo, session: Session, index: number): string[] {
  return [
    cell(receiver.id), cell(receiver.surface ?? ""), cell(receiver.object), cell(receiver.building), receiver.area === null ? "" : figures(receiver.area),
    ...receiver.position.map((metres) => metres.toFixed(4)), receiver.tilt.toFixed(3), receiver.azimuth.toFixed(3), figures(session.skyView[index]!),
  ];
}
