// A slider for the reflectance of each group and the transmittance of each canopy; the archive's
// own value is marked and can be had back.

import type { Site } from "../engine/client";
import { byId, el } from "../dom";
import { nameOf } from "../session";
import type { Store } from "../state";

type Group = Site["groups"][number];

/** Group with its value in the archive beside the first one. */
type SharedGroup = Group & { after: number };

/** Returns the groups that both archives have. A group that only one has keeps its value. */
function shared(before: readonly Group[], after: readonly Group[]): SharedGroup[] {
  const groupIn = (groups: readonly Group[], group: Group): Group | undefined => groups.find((other) => nameOf(other) === nameOf(group));
  const both = before.map((group) => ({ ...group, after: groupIn(after, group)?.value ?? group.value }));
  return [...both, ...after.filter((group) => !groupIn(before, group)).map((group) => ({ ...group, after: group.value }))];
}

function keyOf(group: Group): "reflectance" | "transmittance" {
  return group.kind === "canopy" ? "transmittance" : "reflectance";
}

export class SurfacesPanel {
  private readonly box = byId("groups", HTMLElement);
  private rows: { group: SharedGroup; refresh: () => void }[] = [];

  constructor(private readonly store: Store) {
    store.subscribe((changed) => {
      if (changed.has("reflectance") || changed.has("transmittance")) for (const row of this.rows) row.refresh();
    });
  }

  /** Groups of an archive, and of one that is beside it: a slider sets both. */
  open(site: Site, after: Site | null = null): void {
    this.rows = [];
    const groups = shared(site.groups, after?.groups ?? site.groups);
    const canopies = groups.some((group) => group.kind === "canopy");
    this.box.replaceChildren(...groups.map((group, at) => this.row(group, at, canopies)));
    if (groups.length === 0) this.box.append(el("p", { class: "note", text: "This archive has no surface whose reflectance can change." }));
  }

  private row(group: SharedGroup, at: number, canopies: boolean): HTMLElement {
    const id = `group-${at}`;
    const values = [...new Set([group.value, group.after])];
    const quantity = group.kind === "canopy" ? "transmittance" : "reflectance";
    const output = el("output", { for: id });
    const reset = el("button", { type: "button", class: "bare", "aria-label": `Reset ${quantity} of ${group.name}`, title: `Back to ${values.join(" and ")}`, text: "↺" });
    const slider = el("input", { type: "range", id, min: 0, max: 1, step: 0.01, "aria-describedby": `${id}-stored` });
    const marks = values.map((value) => {
      const mark = el("span", { class: "stored", title: `In the archive: ${value}` });
      // The thumb's middle runs from half its width to that from the end.
      mark.style.left = `calc(8px + (100% - 16px) * ${value})`;
      return mark;
    });
    const row = el(
      "div",
      { class: "group", "data-group": group.name },
      el("label", { for: id, text: canopies ? `${group.name}, ${quantity}` : group.name }),
      output,
      reset,
      el("span", { class: "track" }, slider, ...marks, el("span", { class: "unseen", id: `${id}-stored`, text: `stored: ${values.join(", after ")}` })),
    );
    const refresh = (): void => {
      const changed = this.store.state[keyOf(group)][group.name];
      slider.value = String(changed ?? group.value);
      output.textContent = (changed === undefined ? values : [changed]).map((value) => value.toFixed(2)).join(" → ");
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
