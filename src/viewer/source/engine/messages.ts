// Messages between the page and the worker.

import type { Failure } from "./failure";
import type { Tile } from "./types";

/**
 * Calls that go tile by tile, with a query and the number of its turn. A later turn supersedes
 * earlier ones.
 */
const TILE_CALLS = ["moment", "textures", "sums", "sunMinutes", "comfort"] as const;
export type TileCall = (typeof TILE_CALLS)[number];

export function isTileCall(call: Call): call is TileCall {
  return (TILE_CALLS as readonly Call[]).includes(call);
}

/** Names of calls; their arguments are those of `Tasks`. */
export type Call =
  | TileCall | "open" | "share" | "match" | "scene" | "overview" | "receivers" | "loadWeather" | "clouds" | "turnClouds" | "sun" | "clear" | "light" | "people" | "air" | "months" | "day" | "fisheye" | "traffic";

/** Message to the worker: first the module, then calls. */
export type ToWorker = { module: WebAssembly.Module } | { number: number; call: Call; args: unknown[] };

/** Message from the worker. */
export type FromWorker =
  | { ready: true }
  | { number: number; tile: Tile }
  | { number: number; damaged: number; message: string }
  | { number: number; value: unknown }
  | { number: number; failure: Failure };
