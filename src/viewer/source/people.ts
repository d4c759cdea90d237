// Comfort of people as it is shown: which of the engine's numbers, and in which air. Nothing is
// computed here.

import type { AirAsk, People, WeatherInfo } from "./engine/client";
import { weatherRow } from "./light";
import { isSum, type State } from "./state";

/** Number that an archive of people shows first. */
export const FIRST = "utci_c";
/** Numbers that can be chosen; the planes of a point stand in its table. */
const CHOSEN = /^(utci|mrt|pet)_/;
/** Tenths of the sky that clouds hide where it is overcast. */
const OVERCAST = 10;

/** Returns true if a name is a number of comfort. */
export function isOfComfort(component: string): boolean {
  return CHOSEN.test(component);
}

/** Returns the names of the numbers of the chosen quantity, if people have some of it. */
export function namesOf({ show }: State, people: People | null): readonly string[] {
  return people === null ? [] : show === "moment" ? people.moment : isSum(show) ? people.sums : [];
}

/** Returns the numbers that colours can show. */
export function choicesOf(state: State, people: People | null): string[] {
  return namesOf(state, people).filter(isOfComfort);
}

/**
 * Returns the number of comfort that colours show, if any: the chosen one, or its counterpart in a
 * moment or over a span.
 */
export function comfortOf(state: State, people: People | null): string | null {
  const choices = choicesOf(state, people);
  const { component } = state;
  if (choices.length === 0 || !isOfComfort(component)) return null;
  const [stem] = component.split("_");
  return choices.find((name) => name === component) ?? choices.find((name) => name.startsWith(`${stem}_`)) ?? choices[0]!;
}

/**
 * Returns the air of a moment: from the weather file if the sun stands by its clock, else from the
 * numbers of the state, below a clear or an overcast sky.
 */
export function airOf(state: State, weather: WeatherInfo | null): AirAsk {
  if (weather && state.sunBy === "clock") return { kind: "weather", hour: weatherRow(weather, state.dayOfYear, state.minutes) };
  return { kind: "own", temperature: state.air, humidity: state.humidity, wind: state.wind, cover: state.light === "overcast" ? OVERCAST : 0 };
}
