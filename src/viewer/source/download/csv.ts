// What is shown, as CSV: a row a receiver, columns named as `query` and `replay` name them; what it was made of stands on top.

import type { Quantity } from "../quantity";
import type { Shine } from "../light";
import type { Session } from "../session";
import { isSum, type State } from "../state";

/** What a result was made of, a line each. */
export function provenance(state: State, session: Session, shine: Shine | null): string[] {
  const { site, weather } = session;
  const lines = [`archive: ${site.name}`, `root: ${site.root}`, `written by: ${site.creator}`];
  const shown: Record<State["show"], string> = {
    sky: "sky view, share of an open sky", reference: "a clear year, kWh/m2", year: "sums of the year, kWh/m2",
    month: `sums of month ${state.month}, kWh/m2`, day: `sums of day ${state.dayOfYear} of the year, kWh/m2`, moment: "irradiance of a moment, W/m2",
  };
  lines.push(`shown: ${shown[state.show]}`);
  if (state.show === "sky" || state.show === "reference") return lines;
  if (weather && (isSum(state.show) || state.light === "weather")) lines.push(`weather: ${weather.name}, ${weather.place}`);
  if (state.show === "moment" && shine) {
    if (shine.label !== null) lines.push(`hour: ${shine.label}`);
    lines.push(`sun: azimuth ${shine.azimuth} deg, altitude ${shine.altitude} deg`, `dni_w_m2: ${shine.dni}`, `dhi_w_m2: ${shine.dhi}`);
  }
  lines.push(`sky: ${state.sky}`);
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

/** `onProgress` gets the share done: names of all receivers may have to be read. */
export async function csv(state: State, session: Session, quantity: Quantity, shine: Shine | null, onProgress: (share: number) => void): Promise<Blob> {
  const suffix = isSum(state.show) ? "_kwh_m2" : "";
  const columns = quantity.components.map((name) => name + (name.endsWith("_m2") ? "" : suffix));
  const chunks = [...provenance(state, session, shine).map((line) => `# ${line.replaceAll(/[\r\n]+/g, " ")}\n`)];
  chunks.push(`${["receiver", "surface", "object", "building", "area_m2", "x", "y", "z", "tilt_deg", "azimuth_deg", "sky_view", ...columns].join(",")}\n`);
  for (const [number, tile] of session.tiles.entries()) {
    onProgress(number / session.tiles.length);
    let table;
    try {
      table = await session.table(number);
    } catch (error) {
      chunks.push(`# tile ${number} is damaged: ${(error instanceof Error ? error.message : String(error)).replaceAll(/[\r\n]+/g, " ")}\n`);
      continue;
    }
    const rows = table.map((receiver, row) => {
      const index = tile.first + row;
      const place = receiver.position.map((metres) => metres.toFixed(4));
      const values = quantity.of(index);
      return [
        cell(receiver.id), cell(receiver.surface ?? ""), cell(receiver.object), cell(receiver.building), receiver.area === null ? "" : figures(receiver.area), ...place,
        receiver.tilt.toFixed(3), receiver.azimuth.toFixed(3), figures(session.skyView[index]!), ...columns.map((_, at) => figures(values?.[at] ?? NaN)),
      ].join(",");
    });
    chunks.push(`${rows.join("\n")}\n`);
  }
  onProgress(1);
  return new Blob(chunks, { type: "text/csv" });
}
