// The present quantity as numbers and words: title, unit, a value for each receiver, all components
// of one.

import type { Asker } from "./asker";
import type { Stress } from "./engine/client";
import { comfortOf, namesOf } from "./people";
import type { Session } from "./session";
import { isOfSun, isSum, type State } from "./state";
import { CELSIUS, comfortUnit, componentLabel, dayName, KWH_M2, MONTHS, number, W_M2 } from "./words";

export interface Quantity {
  /** "Year", "This moment" ... */
  title: string;
  /** Title with the component. */
  shownTitle: string;
  unit: string;
  /** Unit of value x area; null if a sum over areas means nothing. */
  wholeUnit: string | null;
  /** Suffix of names in tables: the unit, if the names do not have it. */
  suffix: string;
  components: readonly string[];
  /** The component that colours show. */
  shown: string;
  /** Values by receiver; NaN where there is none yet. */
  column: Float32Array | null;
  of(index: number): readonly number[] | null;
  label(value: number): string;
  /** For people: returns true if a receiver stands for its point. */
  isRow?: (index: number) => boolean;
  /** Classes of a UTCI. */
  stress?: readonly Stress[];
}

/** Returns the present quantity. Quantities that need weather have no values without it. */
export function quantityOf(state: State, session: Session, asker: Asker): Quantity {
  const { show } = state;
  if (show === "sky") {
    const percent = session.skyView.map((share) => 100 * share);
    return single("Sky view", "%", "%·m²", "sky_view_percent", percent);
  }
  if (show === "reference") return single("Clear year", KWH_M2, "kWh", "reference_kwh_m2", session.reference);
  if (isOfSun(show)) return ofSun(state, asker);
  const titles: Record<string, string> = { year: "Year", month: MONTHS[state.month - 1] ?? "Month", day: dayName(state.dayOfYear), moment: "This moment" };
  const title = titles[show]!;
  const felt = comfortOf(state, session.people);
  if (felt !== null) return ofPeople(title, felt, state, session, asker);
  const sums = isSum(show);
  const unit = sums ? KWH_M2 : W_M2;
  const { values } = asker;
  const component = values.components.includes(state.component) ? state.component : "total";
  return {
    title,
    shownTitle: `${title}, ${componentLabel(component).toLowerCase()}`,
    unit,
    wholeUnit: sums ? "kWh" : "W",
    suffix: sums ? "_kwh_m2" : "",
    components: values.components,
    shown: component,
    column: values.column(component),
    of: (index) => values.of(index),
    label: (value) => `${number(value)} ${unit}`,
  };
}

/** Returns the hours of sun on the day, or the minutes of sun in mirrors. */
function ofSun({ show, dayOfYear }: State, { minutes }: Asker): Quantity {
  const column = minutes.column("minutes")!;
  const title = show === "glare" ? `Sun in mirrors, ${dayName(dayOfYear)}` : `Possible sun, ${dayName(dayOfYear)}`;
  if (show === "glare") return single(title, "min", "min·m²", "glare_minutes", column);
  return single(title, "h", "h·m²", "sun_hours", column.map((value) => value / 60));
}

/** Returns a quantity of comfort. */
function ofPeople(title: string, shown: string, state: State, { people }: Session, asker: Asker): Quantity {
  const components = namesOf(state, people);
  const values = asker.felt(components);
  const unit = comfortUnit(shown);
  return {
    title: `${title}, people`,
    shownTitle: `${title}, ${componentLabel(shown)}`,
    unit,
    wholeUnit: null,
    suffix: "",
    components,
    shown,
    column: values.column(shown),
    of: (index) => values.of(index),
    label: (value) => `${number(value)} ${unit}`,
    isRow: (index) => people?.up[index] === 1,
    ...(people && shown.startsWith("utci") && unit === CELSIUS ? { stress: people.stress } : {}),
  };
}

function single(title: string, unit: string, wholeUnit: string, name: string, column: Float32Array): Quantity {
  return {
    title, shownTitle: title, unit, wholeUnit, suffix: "", components: [name], shown: name, column,
    of: (index) => (Number.isFinite(column[index]) ? [column[index]!] : null),
    label: (value) => `${number(value)} ${unit}`,
  };
}
