//! Energy of an array: a row for the array and each of its strings, and a row a month. In: sums by
//! month. Out: `energy.csv`, `energy_months.csv`, a sentence.

use std::path::Path;

use super::sums::{DECIMALS, SideSums, loss_percent};
use crate::outputs::provenance::Provenance;
use crate::outputs::tables::column::Column;
use crate::outputs::tables::records::Records;
use crate::outputs::tables::table::Cell;
use heliotile_core::error::Result;

/// Name of the sum of all modules in the column of strings.
pub const ARRAY: &str = "array";

/// Columns of energy: DC before the inverter, AC, and what the inverter clips at its rating.
pub const ENERGIES: [&str; 3] = ["dc_kwh", "ac_kwh", "clipped_kwh"];

/// Column of the DC energy that partial shade of cells takes; the first of those after
/// [`ENERGIES`], where cells are stated.
pub const MISMATCH: &str = "mismatch_kwh";

/// Hours of a common year.
const YEAR_H: f64 = 8760.0;

/// Returns the number of years in some hours; `None` if they are no whole years. Years of a file of
/// several count alike; 29 February makes no other year.
pub fn years_in(hours: f64) -> Option<f64> {
    let years = (hours / YEAR_H).round();
    (years >= 1.0 && (hours / YEAR_H / years - 1.0).abs() < 0.01).then_some(years)
}

/// Energy of a string, or of the array.
#[derive(Clone, Debug, PartialEq)]
pub struct StringEnergy {
    pub name: String,
    /// Rated power, kW.
    pub kwp: f64,
    /// Sums, `[month][column]`: [`ENERGIES`], kWh, then the other columns.
    pub months: Vec<Vec<f64>>,
    /// Light on the fronts and what they would have on an open plain, `[month]`, each weighted by
    /// the rated power, kWh/m2 kW.
    pub fronts: Vec<[f64; 2]>,
}

impl StringEnergy {
    /// Returns the sums of all months.
    fn all(&self) -> Vec<f64> {
        let width = self.months.first().map_or(0, Vec::len);
        (0..width).map(|column| self.months.iter().filter_map(|month| month.get(column)).sum()).collect()
    }

    /// Adds the light on a front of a rated power, kW, month by month.
    pub fn add_front(&mut self, kw: f64, front: &SideSums) {
        let months = self.fronts.iter_mut().zip(front.months.totals().zip(front.open.totals()));
        months.for_each(|(sums, (light, open))| *sums = [sums[0] + kw * light, sums[1] + kw * open]);
    }

    /// Returns the sums of each of some years, `[year][column]`; `of_month` is the index of the
    /// year of each month.
    pub fn by_year(&self, of_month: &[usize], years: usize) -> Vec<Vec<f64>> {
        let width = self.months.first().map_or(0, Vec::len);
        let mut sums = vec![vec![0.0; width]; years];
        for (month, year) in self.months.iter().zip(of_month) {
            let sum = sums.get_mut(*year).into_iter().flatten();
            sum.zip(month).for_each(|(sum, value)| *sum += value);
        }
        sums
    }

    /// Returns the loss of light on the fronts over all months, percent.
    fn loss_percent(&self) -> Option<f64> {
        let [light, open] = self.fronts.iter().fold([0.0; 2], |sum, month| [sum[0] + month[0], sum[1] + month[1]]);
        loss_percent(light, open)
    }
}

/// Sums of the years of a weather file of several.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EnergyYears {
    /// Labels of the years, then of percentiles, if there are enough years.
    pub labels: Vec<String>,
    /// Sums, `[string][label][column]`.
    pub sums: Vec<Vec<Vec<f64>>>,
    /// Number of complete years, which percentiles are of.
    pub complete: usize,
}

/// Energy of an array and of its strings.
#[derive(Clone, Debug, PartialEq)]
pub struct EnergySums {
    /// Names of the other columns: [`MISMATCH`] of cells, and those of worth.
    pub columns: Vec<String>,
    /// The array, then its strings.
    pub strings: Vec<StringEnergy>,
    /// Labels of the months.
    pub months: Vec<String>,
    /// Years of the months; `None` of a single year.
    pub years: Option<EnergyYears>,
    /// Number of hours of the sums.
    pub hours: f64,
    /// Bifaciality of modules with rears; `None` if only fronts count.
    pub bifaciality: Option<f64>,
}

/// Column of the loss of light on the fronts to surroundings and other modules.
const LOSS: &str = "shading_loss_percent";

impl EnergySums {
    /// Returns the columns of sums.
    fn columns(&self) -> impl Iterator<Item = Column> + '_ {
        let names = ENERGIES.into_iter().chain(self.columns.iter().map(String::as_str));
        names.map(|name| Column::number(name, DECIMALS))
    }

    /// Writes a row for the array and for each string.
    pub fn write(&self, path: &Path, about: &Provenance) -> Result<()> {
        let mut columns = vec![Column::text("string"), Column::number("kwp", DECIMALS).with_unit("kW")];
        columns.extend(self.columns());
        columns.push(Column::number("ac_kwh_kwp", DECIMALS).with_unit("kWh/kW"));
        columns.push(Column::number(LOSS, DECIMALS));
        let rows = self.strings.iter().map(|string| {
            let sums = string.all();
            let per_kwp = sums.get(1).filter(|_| string.kwp > 0.0).map(|ac_kwh| ac_kwh / string.kwp);
            let texts = [Cell::from(&string.name), string.kwp.into()];
            let shares = [per_kwp, string.loss_percent()].map(Cell::from);
            texts.into_iter().chain(sums.into_iter().map(Cell::from)).chain(shares).collect()
        });
        let rows = rows.collect();
        Records { columns, rows }.write(path, about).map(drop)
    }

    /// Writes a row for each month of the array and of each string.
    pub fn write_months(&self, path: &Path, about: &Provenance) -> Result<()> {
        let columns = ["string", "month"].map(Column::text).into_iter().chain(self.columns());
        let columns = columns.chain([Column::number(LOSS, DECIMALS)]).collect();
        let rows = self.strings.iter().flat_map(|string| {
            let months = self.months.iter().zip(string.months.iter().zip(&string.fronts));
            months.map(|(label, (sums, [light, open]))| {
                let texts = [Cell::from(&string.name), label.into()];
                let sums = sums.iter().copied().map(Cell::from);
                texts.into_iter().chain(sums).chain([loss_percent(*light, *open).into()]).collect()
            })
        });
        let rows = rows.collect();
        Records { columns, rows }.write(path, about).map(drop)
    }

    /// Writes a row for each year of the array and of each string, then their percentiles, each
    /// column by itself.
    pub fn write_years(&self, years: &EnergyYears, path: &Path, about: &Provenance) -> Result<()> {
        let columns = ["string", "year"].map(Column::text).into_iter().chain(self.columns());
        let rows = self.strings.iter().zip(&years.sums).flat_map(|(string, of_string)| {
            years.labels.iter().zip(of_string).map(|(label, sums)| {
                let texts = [Cell::from(&string.name), label.into()];
                texts.into_iter().chain(sums.iter().copied().map(Cell::from)).collect()
            })
        });
        Records { columns: columns.collect(), rows: rows.collect() }.write(path, about).map(drop)
    }

    /// Returns the energy of the array and its worth in a sentence.
    pub fn sentence(&self) -> String {
        let Some(array) = self.strings.first() else { return String::new() };
        let sums = array.all();
        let at = |column: usize| sums.get(column).copied().unwrap_or_default();
        let (period, count) = match years_in(self.hours) {
            Some(years) => ("a year".to_owned(), years),
            None => (format!("in {:.0} hours", self.hours), 1.0),
        };
        let energy = at(1) / count;
        let mut text = format!(
            "the array of {:.2} kWp gives {energy:.0} kWh {period} ({:.0} kWh per kWp)",
            array.kwp,
            energy / array.kwp
        );
        if let Some(years) = &self.years {
            let p90 = years.labels.iter().position(|label| label == "P90");
            let of_array = p90.and_then(|row| years.sums.first()?.get(row)?.get(1));
            text += &of_array.map_or(String::new(), |kwh| {
                format!(", in 9 of 10 years at least {kwh:.0} (P90 of {} years)", years.complete)
            });
        }
        if let Some(bifaciality) = self.bifaciality {
            text += &format!(", with {:.0} % of the light on rears", 100.0 * bifaciality);
        }
        if let Some(loss) = array.loss_percent() {
            let words = if loss < 0.0 { "adds" } else { "takes" };
            text += &format!("; what stands around {words} {:.1} % of the light on fronts", loss.abs());
        }
        for (column, name) in (ENERGIES.len()..).zip(&self.columns) {
            let unit = name.trim_start_matches("value").trim_start_matches('_');
            text += &match name.as_str() {
                MISMATCH => {
                    let share = 100.0 * at(column) / (at(0) + at(column)).max(f64::MIN_POSITIVE);
                    format!("; partial shade of cells takes {share:.1} % of the DC energy")
                }
                "used_kwh" => format!("; {:.0} kWh {period} go to the load at once", at(column) / count),
                _ => format!("; {:.2} {} {period}", at(column) / count, unit.to_uppercase()).replace("  ", " "),
            };
        }
        text + "\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two years of 4 kW and 8000 kWh AC at 2400 euros are 4000 kWh, 1000 kWh per kWp and 1200 EUR
    /// a year; 72 hours are no year.
    #[test]
    fn the_sentence_is_of_a_year() {
        let months = vec![vec![4200.0, 4000.0, 1.0, 1200.0]; 2];
        let array = StringEnergy { name: ARRAY.into(), kwp: 4.0, months, fronts: vec![[3600.0, 4000.0]; 2] };
        let sums = EnergySums {
            columns: vec!["value_eur".into()],
            strings: vec![array],
            months: vec!["01".into(), "02".into()],
            years: None,
            hours: 17544.0,
            bifaciality: Some(0.8),
        };
        let text = sums.sentence();
        let expected = "the array of 4.00 kWp gives 4000 kWh a year (1000 kWh per kWp), with 80 % of the light on rears; what \
                        stands around takes 10.0 % of the light on fronts; 1200.00 EUR a year\n";
        assert_eq!(text, expected);
        assert!(EnergySums { hours: 72.0, ..sums }.sentence().contains("gives 8000 kWh in 72 hours"));
    }
}
