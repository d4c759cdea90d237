// What people of an archive feel, as far as it is shown: which of the engine's numbers, and in which air. Nothing is computed here.

import type { AirAsk, People, WeatherInfo } from "./engine/client";
import { weatherRow } from "./light";
import { isSum, type State } from "./state";

/** What an archive of people shows at first. */
export const FIRST = "utci_c";
/** Numbers that can be chosen; the planes of a point stand in its table. */
const CHOSEN = /^(utci|mrt|pet)_/;
/** Tenths of the sky that clouds hide where it is overcast. */
const OVERCAST = 10;

/** Whether a name is one of comfort. */
export function isOfComfort(component: string): boolean {
  return CHOSEN.test(component);
}

/** The numbers of what is shown, if people have some of it. */
export function namesOf({ show }: State, people: People | null): readonly string[] {
  return people === null ? [] : show === "moment" ? people.moment : isSum(show) ? people.sums : [];
}

/** Those that colours can show. */
export function choicesOf(state: State, people: People | null): string[] {
  return namesOf(state, people).filter(isOfComfort);
}

/** The number of comfort that colours show, if any: what was chosen, or what stands for it in a moment or over a span. */
export function comfortOf(state: State, people: People | null): string | null {
  const choices = choicesOf(state, people);
  const { component } = state;
  if (choices.length === 0 || !isOfComfort(component)) return null;
  const [stem] = component.split("_");
  return choices.find((name) => name === component) ?? choices.find((name) => name.startsWith(`${stem}_`)) ?? choices[0]!;
}

/** The air of a moment: that of the weather file where the sun stands by its clock, else the numbers of the state, below a clear or an overcast sky. */
export function airOf(state: State, weather: WeatherInfo | null): AirAsk {
  if (weather && state.sunBy === "clock") return { kind: "weather", hour: weatherRow(weather, state.dayOfYear, state.minutes) };
  return { kind: "own", temperature: state.air, humidity: state.humidity, wind: state.wind, cover: state.light === "overcast" ? OVERCAST : 0 };
}
