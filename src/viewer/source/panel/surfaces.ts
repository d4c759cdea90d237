// A slider for the reflectance of each group and the transmittance of each canopy; the archive's own value is marked and can be had back.

import type { Site } from "../engine/client";
import { byId, el } from "../dom";
import type { Store } from "../state";

type Group = Site["groups"][number];

function keyOf(group: Group): "reflectance" | "transmittance" {
  return group.kind === "canopy" ? "transmittance" : "reflectance";
}

export class SurfacesPanel {
  private readonly box = byId("groups", HTMLElement);
  private rows: { group: Group; refresh: () => void }[] = [];

  constructor(private readonly store: Store) {
    store.subscribe((changed) => {
      if (changed.has("reflectance") || changed.has("transmittance")) for (const row of this.rows) row.refresh();
    });
  }

  open(site: Site): void {
    this.rows = [];
    const canopies = site.groups.some((group) => group.kind === "canopy");
    this.box.replaceChildren(...site.groups.map((group, at) => this.row(group, at, canopies)));
    if (site.groups.length === 0) this.box.append(el("p", { class: "note", text: "This archive has no surface whose reflectance can change." }));
  }

  private row(group: Group, at: number, canopies: boolean): HTMLElement {
    const id = `group-${at}`;
    const quantity = group.kind === "canopy" ? "transmittance" : "reflectance";
    const output = el("output", { for: id });
    const reset = el("button", { type: "button", class: "bare", "aria-label": `Reset ${quantity} of ${group.name}`, title: `Back to ${group.value}`, text: "↺" });
    const slider = el("input", { type: "range", id, min: 0, max: 1, step: 0.01, "aria-describedby": `${id}-stored` });
    const stored = el("span", { class: "stored", title: `In the archive: ${group.value}` });
    // The thumb's middle runs from half its width to that from the end.
    stored.style.left = `calc(8px + (100% - 16px) * ${group.value})`;
    const row = el(
      "div",
      { class: "group", "data-group": group.name },
      el("label", { for: id, text: canopies ? `${group.name}, ${quantity}` : group.name }),
      output,
      reset,
      el("span", { class: "track" }, slider, stored, el("span", { class: "unseen", id: `${id}-stored`, text: `stored: ${group.value}` })),
    );
    const refresh = (): void => {
      const changed = this.store.state[keyOf(group)][group.name];
      slider.value = String(changed ?? group.value);
      output.textContent = (changed ?? group.value).toFixed(2);
      row.classList.toggle("changed", changed !== undefined);
      reset.disabled = changed === undefined;
    };
    const set = (value: number | null): void => {
      const { [group.name]: _, ...others } = this.store.state[keyOf(group)];
      this.store.set({ [keyOf(group)]: value === null ? others : { ...others, [group.name]: value } });
    };
    slider.addEventListener("input", () => set(slider.valueAsNumber));
    reset.addEventListener("click", () => set(null));
    this.rows.push({ group, refresh });
    refresh();
    return row;
  }
}
