//! Sums of light by month and column. In: rows of a file, and its place. Out: the rows without
//! values that the sums disprove, and a sentence for each kind of them.

use std::collections::BTreeMap;
use std::path::Path;

use crate::judging::raw_weather::RawRow;
use heliotile_core::units::kwh_from_w;
use heliotile_core::weather::row::WeatherRow;
use heliotile_core::weather::time::sun::{Location, extraterrestrial_w_m2};

/// Least light of a row that is summed, W/m2. Less light proves nothing.
const MIN_LIGHT_W_M2: f64 = 50.0;

/// Least number of such rows in a month.
const FEWEST_ROWS: usize = 6;

/// Least share of GHI that DNI must explain before a month of zeros is no overcast month.
const MIN_DIRECT_SHARE: f64 = 0.1;

/// Least share of GHI that DHI must explain before zeros are missing values. The clearest skies
/// send 5 %.
const MIN_DIFFUSE_SHARE: f64 = 0.03;

/// Least ratio of GHI to the light outside the atmosphere that a month without any DNI cannot have.
const MIN_CLEARNESS: f64 = 0.45;

/// Largest share of GHI - DHI that direct horizontal light may leave unexplained.
const LARGEST_HORIZONTAL_REST: f64 = 0.02;

/// Largest share of GHI by which a month's DHI + DNI cos z may differ from it.
const LARGEST_MONTH_REST: f64 = 0.2;

/// Number of months that a sentence names.
const NAMED_MONTHS: usize = 3;

/// Year and month.
type Month = (i32, u32);

/// Sums of the rows of a month with light, W/m2 times rows.
#[derive(Default)]
struct MonthSums {
    rows: usize,
    hours: f64,
    ghi: f64,
    dni: f64,
    dhi: f64,
    /// DNI cos z.
    direct: f64,
    /// Light outside the atmosphere on the horizontal.
    outside: f64,
    /// Numbers of rows that state GHI, DNI and DHI.
    stated: [usize; 3],
}

impl MonthSums {
    fn states(&self, column: usize) -> bool {
        self.stated[column] == self.rows
    }

    /// Returns true for GHI, DNI and DHI whose zeros cannot be measured values.
    fn empty(&self) -> [bool; 3] {
        if self.rows < FEWEST_ROWS {
            return [false; 3];
        }
        let [ghi, dni, dhi] = [0, 1, 2].map(|column| self.states(column));
        let no_ghi = ghi && self.ghi == 0.0;
        let clear = self.ghi > MIN_CLEARNESS * self.outside;
        let no_dni = ghi && !no_ghi && dni && self.dni == 0.0;
        let no_dni = no_dni && if dhi { self.ghi - self.dhi > MIN_DIRECT_SHARE * self.ghi } else { clear };
        let no_dhi = ghi && !no_ghi && dhi && self.dhi == 0.0;
        let no_dhi = no_dhi && (!dni || self.ghi - self.direct > MIN_DIFFUSE_SHARE * self.ghi);
        [no_ghi, no_dni, no_dhi]
    }
}

fn months(rows: &[RawRow], site: &Location) -> BTreeMap<Month, MonthSums> {
    let mut all = BTreeMap::<Month, MonthSums>::new();
    for row in rows {
        let [ghi, dni, dhi] = [row.ghi, row.dni, row.dhi].map(Option::unwrap_or_default);
        if ghi.max(dni).max(dhi) <= MIN_LIGHT_W_M2 {
            continue;
        }
        let sine = site.sun(row.interval.date, row.interval.middle_min()).z.max(0.0);
        let sums = all.entry((row.interval.date.year, row.interval.date.month)).or_default();
        sums.rows += 1;
        sums.hours += row.interval.hours();
        for (sum, value) in [
            (&mut sums.ghi, ghi),
            (&mut sums.dni, dni),
            (&mut sums.dhi, dhi),
            (&mut sums.direct, dni * sine),
            (&mut sums.outside, extraterrestrial_w_m2(row.interval.date) * sine),
        ] {
            *sum += value;
        }
        for (count, value) in sums.stated.iter_mut().zip([row.ghi, row.dni, row.dhi]) {
            *count += usize::from(value.is_some());
        }
    }
    all
}

/// Takes columns of zeros for missing values, in months whose other columns show that they cannot
/// be measured: GHI far above DHI without any DNI, or GHI without any DHI. Returns a sentence for
/// each column.
pub fn drop_empty_columns(path: &Path, rows: &mut [RawRow], site: &Location) -> Vec<String> {
    let months = months(rows, site);
    let empty: BTreeMap<Month, [bool; 3]> = months.iter().map(|(month, sums)| (*month, sums.empty())).collect();
    let mut sentences = Vec::new();
    for (column, [name, by]) in [
        ["GHI", "it is not used"],
        ["DNI", "it is taken as missing and computed from GHI"],
        ["DHI", "it is taken as missing and computed from GHI"],
    ]
    .into_iter()
    .enumerate()
    {
        let found: Vec<Month> = empty.iter().filter(|(_, empty)| empty[column]).map(|(month, _)| *month).collect();
        if found.is_empty() {
            continue;
        }
        let of = |sum: fn(&MonthSums) -> f64| found.iter().filter_map(|month| months.get(month)).map(sum).sum::<f64>();
        // Sums are those of means; all rows of a file are equally long.
        let hours = of(|sums| sums.hours) / of(|sums| sums.rows as f64);
        let kwh = |sum: fn(&MonthSums) -> f64| kwh_from_w(of(sum), hours);
        sentences.push(format!(
            "{}: {name} is 0 in all rows of {}, where GHI sums to {:.1}, DNI cos(z) to {:.1} and DHI to {:.1} kWh/m2: {by}",
            path.display(),
            named(&found),
            kwh(|sums| sums.ghi),
            kwh(|sums| sums.direct),
            kwh(|sums| sums.dhi)
        ));
    }
    for row in rows {
        let Some(empty) = empty.get(&(row.interval.date.year, row.interval.date.month)) else { continue };
        for (value, empty) in [&mut row.ghi, &mut row.dni, &mut row.dhi].into_iter().zip(empty) {
            *value = value.filter(|value| !(*empty && *value == 0.0));
        }
    }
    sentences.extend(all_zero(path, &months));
    sentences
}

/// Returns a sentence if a file without GHI holds no other DNI than 0, or no other DHI than 0.
fn all_zero(path: &Path, months: &BTreeMap<Month, MonthSums>) -> Option<String> {
    let of = |sum: fn(&MonthSums) -> f64| months.values().map(sum).sum::<f64>();
    let (dni, dhi) = (of(|sums| sums.dni), of(|sums| sums.dhi));
    let stated = |column: usize| months.values().all(|sums| sums.states(column));
    let no_ghi = months.values().all(|sums| sums.stated[0] == 0);
    if !no_ghi || !stated(1) || !stated(2) || months.values().map(|sums| sums.rows).sum::<usize>() < FEWEST_ROWS {
        return None;
    }
    let name = match (dni == 0.0, dhi == 0.0) {
        (true, false) => "DNI",
        (false, true) => "DHI",
        _ => return None,
    };
    Some(format!(
        "{}: {name} is 0 in all rows, and no GHI shows if it is missing: check this column; it is used unchanged",
        path.display()
    ))
}

/// Takes a column named DNI for direct horizontal irradiance if GHI is its sum with DHI. DNI is
/// then computed from it. Returns a sentence if it is so.
pub fn drop_horizontal_dni(path: &Path, rows: &mut [RawRow], site: &Location) -> Option<String> {
    let (mut count, mut direct, mut as_horizontal, mut as_normal) = (0, 0.0, 0.0, 0.0);
    for row in rows.iter() {
        let (Some(ghi), Some(dni), Some(dhi)) = (row.ghi, row.dni, row.dhi) else { continue };
        if ghi <= MIN_LIGHT_W_M2 || dni <= 0.0 {
            continue;
        }
        let sine = site.sun(row.interval.date, row.interval.middle_min()).z.max(0.0);
        count += 1;
        direct += ghi - dhi;
        as_horizontal += (ghi - dhi - dni).abs();
        as_normal += (ghi - dhi - dni * sine).abs();
    }
    let is_horizontal = count >= FEWEST_ROWS
        && as_horizontal <= LARGEST_HORIZONTAL_REST * direct
        && as_normal > MIN_DIRECT_SHARE * direct;
    if !is_horizontal {
        return None;
    }
    for row in rows {
        if let Some(beam) = row.dni.take() {
            row.ghi = row.ghi.or(row.dhi.map(|dhi| dhi + beam));
            row.dhi = row.dhi.or(row.ghi.map(|ghi| (ghi - beam).max(0.0)));
        }
    }
    Some(format!(
        "{}: the column of DNI holds direct horizontal irradiance: GHI = DHI + column within {:.1} % of the direct \
         light, against {:.1} % for GHI = DHI + column cos(z); it is read so; name it `bhi`",
        path.display(),
        100.0 * as_horizontal / direct,
        100.0 * as_normal / direct
    ))
}

/// Returns a sentence if sums of DHI + DNI cos z of months differ from those of GHI.
pub fn month_warning(path: &Path, raw: &[RawRow], done: &[&WeatherRow]) -> Option<String> {
    let mut months = BTreeMap::<Month, (usize, f64, f64)>::new();
    for (raw, row) in raw.iter().zip(done) {
        let (Some(ghi), Some(_), Some(_)) = (raw.ghi, raw.dni, raw.dhi) else { continue };
        if ghi.max(row.dhi_w_m2) > MIN_LIGHT_W_M2 {
            let sums = months.entry((row.interval.date.year, row.interval.date.month)).or_default();
            sums.0 += 1;
            sums.1 += kwh_from_w(ghi, row.interval.hours());
            sums.2 += kwh_from_w(row.dhi_w_m2 + row.dni_w_m2 * row.sun.z.max(0.0), row.interval.hours());
        }
    }
    let differs = |(rows, ghi, parts): (usize, f64, f64)| {
        rows >= FEWEST_ROWS && (ghi - parts).abs() > LARGEST_MONTH_REST * ghi.max(parts)
    };
    let found: Vec<Month> = months.iter().filter(|(_, sums)| differs(**sums)).map(|(month, _)| *month).collect();
    let (_, ghi, parts) = months.get(found.first()?)?;
    Some(format!(
        "{}: the columns do not agree in {}: GHI of the first sums to {ghi:.1} kWh/m2, DHI + DNI cos(z) to {parts:.1}; \
         check them; DNI and DHI are used unchanged",
        path.display(),
        named(&found)
    ))
}

fn named(months: &[Month]) -> String {
    let names: Vec<String> =
        months.iter().take(NAMED_MONTHS).map(|(year, month)| format!("{year:04}-{month:02}")).collect();
    match months.len().saturating_sub(NAMED_MONTHS) {
        0 => names.join(", "),
        more => format!("{} and {more} more months", names.join(", ")),
    }
}
