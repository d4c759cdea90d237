// Words, units and numbers as they are shown.

export const COMPONENT_LABELS: Record<string, string> = {
  total: "Total",
  sun_direct: "Sun, direct",
  sky_direct: "Sky, direct",
  sun_reflected: "Sun, reflected",
  sky_reflected: "Sky, reflected",
  sun_mirrored: "Sun, mirrored",
  sky_mirrored: "Sky, mirrored",
  sky_view_percent: "Sky view",
  reference_kwh_m2: "Clear year",
  sun_hours: "Possible sun",
  glare_minutes: "Sun in mirrors",
  utci_c: "UTCI",
  mrt_c: "Mean radiant temperature",
  pet_c: "PET",
  utci_mean_c: "UTCI, mean",
  utci_max_c: "UTCI, highest",
  mrt_mean_c: "Mean radiant temperature, mean",
};

// Okabe and Ito's colours, told apart by the colour-blind.
export const COMPONENT_COLOURS: Record<string, string> = {
  sun_direct: "#e69f00",
  sky_direct: "#56b4e9",
  sun_reflected: "#d55e00",
  sky_reflected: "#0072b2",
  sun_mirrored: "#cc79a7",
  sky_mirrored: "#009e73",
};

export const MONTHS = [
  "January", "February", "March", "April", "May", "June",
  "July", "August", "September", "October", "November", "December",
];
const MONTH_DAYS = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];

export const W_M2 = "W/m²";
export const KWH_M2 = "kWh/m²";
export const CELSIUS = "°C";

export function componentLabel(name: string): string {
  const above = /^utci_above_(.+)_h$/.exec(name);
  if (above) return `UTCI above ${above[1]} ${CELSIUS}`;
  const plane = /^(shortwave|longwave)_(.+)$/.exec(name);
  if (plane) return `${plane[1] === "shortwave" ? "Shortwave" : "Longwave"}, ${plane[2]}`;
  return COMPONENT_LABELS[name] ?? name;
}

/** Returns the unit of a number of people. */
export function comfortUnit(name: string): string {
  return name.endsWith("_c") ? CELSIUS : name.endsWith("_h") ? "h" : W_M2;
}

/** Returns a value for display: about four figures, never more than three decimals. */
export function number(value: number): string {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  const decimals = size >= 1000 ? 0 : size >= 100 ? 1 : size >= 10 ? 2 : 3;
  return value.toLocaleString("en-US", { minimumFractionDigits: 0, maximumFractionDigits: decimals }).replaceAll(",", "\u202f").replace("-", "−");
}

/** Returns a value with its sign, also if it is positive. */
export function signed(value: number): string {
  return value > 0 ? `+${number(value)}` : number(value);
}

/** Returns a day of a year without 29 February, 1..365, as `21 June`. */
export function dayName(dayOfYear: number): string {
  let day = dayOfYear;
  for (const [month, days] of MONTH_DAYS.entries()) {
    if (day <= days) return `${day} ${MONTHS[month]}`;
    day -= days;
  }
  return "31 December";
}

export function clock(minutes: number): string {
  const whole = Math.round(minutes) % 1440;
  return `${String(Math.floor(whole / 60)).padStart(2, "0")}:${String(whole % 60).padStart(2, "0")}`;
}

/** Returns the name of an azimuth in degrees: north, north-east ... */
export function bearing(azimuth: number): string {
  const names = ["north", "north-east", "east", "south-east", "south", "south-west", "west", "north-west"];
  return names[Math.round(azimuth / 45) % 8] ?? "north";
}

export function bytes(count: number): string {
  if (count < 1e6) return `${number(count / 1e3)} kB`;
  return count < 1e9 ? `${number(count / 1e6)} MB` : `${number(count / 1e9)} GB`;
}

/** Returns the label of a sky by its name in `--sky`. */
export function skyLabel(name: string): string {
  const known: Record<string, string> = {
    perez: "Perez 1993",
    perez1990: "Perez 1990",
    uniform: "Uniform",
    "cie:1": "CIE 1, overcast",
    "cie:5": "CIE 5, uniform",
    "cie:12": "CIE 12, clear",
    "cie:16": "CIE traditional overcast",
  };
  return known[name] ?? name.replace(/^cie:/, "CIE ");
}
