// Data in the page itself, as `<script type="application/octet-stream">`: the engine, and data that
// the program embedded.

import type { WeatherOptions } from "./engine/options";

/**
 * Returns the bytes of a block, unpacked if it is packed, or null if the page has no such block.
 * The text of the block is freed.
 */
export async function takeBlock(id: string): Promise<{ bytes: ArrayBuffer; name: string } | null> {
  const block = document.getElementById(id);
  const text = block?.textContent?.trim();
  if (!block || !text) return null;
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  block.textContent = "";
  const name = block.dataset["name"] ?? id;
  if (block.dataset["packed"] !== "gzip") return { bytes: packed.buffer, name };
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return { bytes: await new Response(stream).arrayBuffer(), name };
}

/**
 * Returns the bytes of a block behind the script of the page, which may still be loading, as
 * `takeBlock` does.
 */
export async function takeLaterBlock(id: string): Promise<{ bytes: ArrayBuffer; name: string } | null> {
  if (document.readyState === "loading") await new Promise((resolve) => document.addEventListener("DOMContentLoaded", resolve, { once: true }));
  return takeBlock(id);
}

export interface Options {
  archive?: string;
  /** Address of an archive that is shown beside the first. */
  after?: string;
  /** Address of the list of an atlas' parts, in place of an archive. */
  parts?: string;
  weather?: string;
  /** Name of the weather file, if not the end of its address. */
  weatherName?: string;
  /** How the weather that comes with the page is read. */
  weatherOptions: WeatherOptions;
  /**
   * Largest memory of the graphics card for textures of receivers, MB; 0: none. By default it
   * depends on the card.
   */
  card?: number;
  /** Number of workers that compute values. By default it depends on processor and archive. */
  workers?: number;
}

/** Workers that an address can ask for. */
const MOST_WORKERS = 64;

/** Addresses of archive and weather: those of the page's own options, else those in its address. */
export function readOptions(): Options {
  const found: Options = { weatherOptions: {} };
  const text = document.getElementById("options")?.textContent;
  if (text) {
    const parsed: unknown = JSON.parse(text);
    if (typeof parsed === "object" && parsed !== null) {
      if ("archive" in parsed && typeof parsed.archive === "string") found.archive = parsed.archive;
      if ("after" in parsed && typeof parsed.after === "string") found.after = parsed.after;
      if ("parts" in parsed && typeof parsed.parts === "string") found.parts = parsed.parts;
      if ("weatherName" in parsed && typeof parsed.weatherName === "string") found.weatherName = parsed.weatherName;
      if ("weatherOptions" in parsed && typeof parsed.weatherOptions === "object" && parsed.weatherOptions !== null) found.weatherOptions = parsed.weatherOptions;
      if ("weather" in parsed && typeof parsed.weather === "string") found.weather = parsed.weather;
    }
  }
  const query = new URLSearchParams(location.search);
  const [url, after, weather] = [query.get("url"), query.get("with"), query.get("weather")];
  if (url && !found.archive) found.archive = url;
  if (after && !found.after) found.after = after;
  if (weather && !found.weather) found.weather = weather;
  const card = Number.parseFloat(query.get("card") ?? "");
  if (card >= 0) found.card = card;
  const workers = Number.parseInt(query.get("workers") ?? "", 10);
  if (workers >= 1) found.workers = Math.min(workers, MOST_WORKERS);
  return found;
}
