// What goes between the page and the worker.

import type { Failure } from "./failure";
import type { TileValues } from "./types";

/** Calls by name, with their arguments: those of `Tasks`. */
export type Call =
  | "open" | "match" | "scene" | "overview" | "receivers" | "loadWeather" | "clouds" | "turnClouds" | "sun" | "clear" | "moment" | "light" | "textures" | "sums" | "sunMinutes" | "people" | "air" | "comfort" | "months" | "day" | "fisheye" | "traffic";

/** To the worker: first the module, then calls. */
export type ToWorker = { module: WebAssembly.Module } | { number: number; call: Call; args: unknown[] };

/** From the worker. */
export type FromWorker =
  | { ready: true }
  | { number: number; tile: TileValues }
  | { number: number; damaged: number; message: string }
  | { number: number; value: unknown }
  | { number: number; failure: Failure };
