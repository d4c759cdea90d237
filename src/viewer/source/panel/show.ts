// Controls of what is shown: quantity, component, range of the legend.

import type { Partners } from "../change";
import { byId, options } from "../dom";
import { choicesOf, comfortOf } from "../people";
import type { Session } from "../session";
import { isSum, type Show, type Store } from "../state";
import { comfortUnit, componentLabel, dayName, KWH_M2, MONTHS, number, W_M2 } from "../words";

export class ShowPanel {
  private readonly what = byId("show-what", HTMLSelectElement);
  private readonly component = byId("show-component", HTMLSelectElement);
  private readonly month = byId("show-month", HTMLSelectElement);
  private readonly low = byId("range-low", HTMLInputElement);
  private readonly high = byId("range-high", HTMLInputElement);
  private readonly auto = byId("range-auto", HTMLInputElement);
  private readonly percent = byId("show-percent", HTMLInputElement);
  private readonly note = byId("show-note", HTMLElement);
  private session: Session | null = null;
  private partners: Partners | null = null;
  private offered = "";

  constructor(private readonly store: Store) {
    options(this.month, MONTHS.map((label, at) => ({ value: String(at + 1), label })));
    this.what.addEventListener("change", () => store.set({ show: this.what.value as Show, range: null }));
    this.component.addEventListener("change", () => store.set({ component: this.component.value, range: null }));
    this.month.addEventListener("change", () => store.set({ month: Number(this.month.value) }));
    this.percent.addEventListener("change", () => store.set({ percent: this.percent.checked, range: null }));
    const byHand = (): void => {
      const [low, high] = [this.low.valueAsNumber, this.high.valueAsNumber];
      const senseless = !(low < high);
      this.low.setCustomValidity(senseless ? "The first value of the range must be below the second." : "");
      if (!senseless) store.set({ range: [low, high] });
    };
    this.low.addEventListener("change", byHand);
    this.high.addEventListener("change", byHand);
    this.auto.addEventListener("change", () => (this.auto.checked ? store.set({ range: null }) : byHand()));
    store.subscribe(() => this.refresh());
  }

  open(session: Session): void {
    this.session = session;
    this.partners = null;
    this.refresh();
  }

  /** The archive is compared with another. */
  compare(partners: Partners): void {
    this.partners = partners;
    this.refresh();
  }

  /** The range that the legend has now. */
  showRange(range: readonly [number, number]): void {
    if (document.activeElement !== this.low) this.low.value = String(range[0]);
    if (document.activeElement !== this.high) this.high.value = String(range[1]);
  }

  refresh(): void {
    const { session } = this;
    if (!session) return;
    const { state } = this.store;
    const dry = session.weather === null;
    const placed = session.site.place !== null || !dry;
    const mirrors = session.site.materials.some(({ mirror }) => mirror);
    const hint = dry ? " – needs a weather file" : "";
    // Units of people belong to the numbers chosen below.
    const of = (unit: string): string => (session.people ? "" : `, ${unit}`);
    options(this.what, [
      { value: "reference", label: `Clear year, ${KWH_M2}`, disabled: !session.site.hasReference },
      { value: "sky", label: "Sky view, %" },
      { value: "sunlight", label: placed ? "Day, possible sun, h" : "Day, possible sun – needs a place", disabled: !placed },
      ...(mirrors ? [{ value: "glare", label: "Day, sun in mirrors, min", disabled: !placed }] : []),
      { value: "moment", label: `This moment${of(W_M2)}` },
      { value: "day", label: `Day${of(KWH_M2)}${hint}`, disabled: dry },
      { value: "month", label: `Month${of(KWH_M2)}${hint}`, disabled: dry },
      { value: "year", label: `Year${of(KWH_M2)}${hint}`, disabled: dry },
    ]);
    this.what.value = state.show;
    this.offer(session);
    this.month.value = String(state.month);
    byId("row-month", HTMLElement).hidden = state.show !== "month";
    byId("row-component", HTMLElement).hidden = state.show !== "moment" && !isSum(state.show);
    this.auto.checked = state.range === null;
    const felt = comfortOf(state, session.people);
    const notes: Partial<Record<Show, string>> = {
      reference: "A year of cloudless days at this site, computed when the archive was built: for a first look.",
      sky: "How much of an open sky each receiver sees.",
      sunlight: `Hours in which each receiver can see the sun on ${dayName(state.dayOfYear)}, without clouds; the day is chosen below.`,
      glare: `Minutes in which mirrors and glass reflect the sun at each receiver on ${dayName(state.dayOfYear)}, without clouds; the day is chosen below.`,
      day: `The weather file's ${dayName(state.dayOfYear)}; the day is chosen below.`,
    };
    const isChange = this.partners !== null && state.variant === "change";
    byId("row-percent", HTMLElement).hidden = !isChange;
    this.percent.checked = state.percent;
    const note = this.partners && isChange ? compared(this.partners) : dry && state.show === "reference" && this.session ? `${notes.reference} Drop a weather file, such as EPW, to see the sum of its year.` : notes[state.show];
    const told = [note, felt === null || isChange ? undefined : ofPeople(felt)].filter((text) => text !== undefined);
    this.note.textContent = told.join(" ");
    this.note.hidden = told.length === 0;
  }

  /** Offers the numbers of people, if there are people, then light: the total, then its parts. */
  private offer({ site, people }: Session): void {
    const { state } = this.store;
    const choices = choicesOf(state, people);
    const total = site.components.filter((name) => name === "total");
    const parts = site.components.filter((name) => name !== "total");
    const entries = [
      ...choices.map((name) => ({ value: name, label: `${componentLabel(name)}, ${comfortUnit(name)}` })),
      ...[...total, ...parts].map((name) => ({ value: name, label: componentLabel(name) })),
    ];
    if (entries.map(({ value }) => value).join() !== this.offered) options(this.component, entries);
    this.offered = entries.map(({ value }) => value).join();
    this.component.value = comfortOf(state, people) ?? (site.components.includes(state.component) ? state.component : "total");
  }
}

/** Returns the receivers to which the colours of a change apply, in words. */
function compared({ count, moved, ofAfter, ofBefore }: Partners): string {
  const [added, gone] = [ofAfter.length - count, ofBefore.length - count];
  const told = [
    `${number(count)} receivers are in both archives`,
    ...(moved > 0 ? [`${number(moved)} of them at another place, matched by name`] : []),
    ...(added > 0 ? [`${number(added)} only after, grey`] : []),
    ...(gone > 0 ? [`${number(gone)} only before, not shown`] : []),
  ];
  return `${told.join("; ")}.`;
}

/** Returns the assumptions about people in words: the program's default ones. */
function ofPeople(name: string): string {
  const index = name.startsWith("utci_above") ? "Hours in which the Universal Thermal Climate Index is higher. " : name.startsWith("utci") ? "Universal Thermal Climate Index: colours are its categories of stress. " : name.startsWith("pet") ? "Physiological Equivalent Temperature. " : "";
  return `${index}Standing people; ground and walls have their sol-air temperature and store no heat; the wind is the same everywhere.`;
}
