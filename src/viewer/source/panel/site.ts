// The open archives in words: names, sizes, sources, and the relation of two archives.

import type { Partners } from "../change";
import { byId, el } from "../dom";
import type { Site, WeatherInfo } from "../engine/client";
import { bytes } from "../words";
import type { Messages } from "./messages";

function addFact(name: string, value: string): void {
  byId("site-facts", HTMLElement).append(el("dt", { text: name }), el("dd", { text: value }));
}

/** Describes an archive, and the one beside it. */
export function describe(site: Site, after: Site | null = null): void {
  const all = after ? [site, after] : [site];
  const name = all.map((one) => one.name).join(" → ");
  document.title = `${name} – heliotile`;
  byId("site-name", HTMLElement).textContent = name;
  const receivers = all.map((one) => one.receivers.toLocaleString("en")).join(" → ");
  byId("site-line", HTMLElement).textContent = `${receivers} receivers, ${bytes(all.reduce((sum, one) => sum + one.bytes, 0))}`;
  byId("site-facts", HTMLElement).replaceChildren();
  addFact("Root", `${site.root.slice(0, 16)}…`);
  if (after) addFact("Root after", `${after.root.slice(0, 16)}…`);
  addFact("Written by", `${site.creator}, format ${site.formatVersion}`);
  if (site.place) addFact("Place", `${site.place.latitude.toFixed(3)}°, ${site.place.longitude.toFixed(3)}°${site.place.crs ? `, ${site.place.crs}` : ""}`);
  addFact("Error", site.accuracy ?? "not estimated");
  if (after && after.accuracy !== site.accuracy) addFact("Error after", after.accuracy ?? "not estimated");
}

export function describeWeather({ name, place }: WeatherInfo): void {
  addFact("Weather", [name, place].filter((text) => text !== "").join(", "));
}

/** Reports what cannot be compared. */
export function tellOf({ count }: Partners, before: Site, after: Site, messages: Messages): void {
  if (before.root === after.root) messages.tell(["The two archives are equal: nothing changes.", "Choose the archive of another variant."], false, "equal");
  else if (count === 0) messages.tell(["The two archives have no receiver in common: no change can be shown.", "Before and After can be viewed one at a time. To compare them, build both with receivers at the same places."], false, "no-common");
}
