//! Worth of energy. In: a price, a table of values by the hour. Out: what each hour's energy adds
//! to a column of sums.

use std::path::Path;

use super::energy::WeatherRows;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::replay::schedule_csv::{Column, Rows, column_names, column_texts, parse_schedule};
use heliotile_core::weather::time::calendar::Date;
use heliotile_results::Resources;

/// Price of a kWh: a number and, perhaps, a currency.
#[derive(Clone, Debug, PartialEq)]
pub struct Price {
    pub per_kwh: f64,
    /// Currency in small letters; empty if none is given.
    pub currency: String,
}

impl std::str::FromStr for Price {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let refused = || format!("`{text}` is no price of a kWh: give a number and a currency, as in 0.30EUR");
        let text = text.trim();
        let end = text.find(|c: char| !c.is_ascii_digit() && !"+-.".contains(c)).unwrap_or(text.len());
        let (number, currency) = text.split_at_checked(end).ok_or_else(refused)?;
        let currency = currency.trim();
        let per_kwh = number.parse().ok().filter(|price: &f64| price.abs() <= MOST).ok_or_else(refused)?;
        let is_word = currency.len() <= 20 && currency.chars().all(char::is_alphabetic);
        is_word.then(|| Price { per_kwh, currency: currency.to_lowercase() }).ok_or_else(refused)
    }
}

heliotile_requests::parse_by_text!(Price: heliotile_requests::Form::TEXT);

/// Ending of columns of values of a kWh.
const PER_KWH: &str = "_per_kwh";
/// Column of loads, kW.
const LOAD: &str = "load_kw";
/// Column of times, which is only compared.
const TIME: &str = "time";
/// Largest value of a kWh, and largest load, kW: more is a mix-up of columns.
const MOST: f64 = 1e9;

/// Column of sums.
pub struct Worth {
    /// Name: `value_eur`, `value`, `used_kwh`.
    pub column: String,
    measure: Measure,
}

/// Rule by which an hour's energy adds to a column.
enum Measure {
    /// The energy times a value of each hour, or of all.
    Value(Vec<f64>),
    Price(f64),
    /// The part of the energy that a load takes in the same hour, kW.
    Load(Vec<f64>),
}

impl Worth {
    /// Returns what power of an hour, kW, adds in each hour of its length.
    pub fn of(&self, hour: usize, ac_kw: f64) -> f64 {
        let at = |values: &[f64]| values.get(hour).copied().unwrap_or_default();
        match &self.measure {
            Measure::Price(price) => price * ac_kw,
            Measure::Value(values) => at(values) * ac_kw,
            Measure::Load(loads) => at(loads).min(ac_kw),
        }
    }
}

/// Returns the worths of a price and of the columns of a table, which follows the rows of weather
/// that count.
pub fn read_worths(
    price: Option<&Price>,
    file: Option<&Path>,
    rows: WeatherRows,
    resources: &Resources,
) -> Result<Vec<Worth>> {
    let named = |unit: &str| if unit.is_empty() { "value".to_owned() } else { format!("value_{unit}") };
    let of_price = |price: &Price| Worth { column: named(&price.currency), measure: Measure::Price(price.per_kwh) };
    let mut all: Vec<Worth> = price.map(of_price).into_iter().collect();
    let Some(file) = file else { return Ok(all) };
    let bytes = (resources.files)(file)?;
    let header = check_times(file, &bytes, rows)?;
    let dated = rows.dated;
    let dates: Vec<Date> =
        dated.dates.iter().zip(&dated.chosen).filter_map(|(date, chosen)| chosen.then_some(*date)).collect();
    for name in &header {
        let (column, low) = match name.strip_suffix(PER_KWH) {
            Some(unit) => (named(unit), -MOST),
            None if name == LOAD => ("used_kwh".to_owned(), 0.0),
            None => continue,
        };
        if all.iter().any(|worth| worth.column == column) {
            let what = format!("column `{name}` gives `{column}`, which another column or the price gives, too");
            let hint = "leave one of them out, or name the column for another unit";
            return Err(Error::input(file, 1, what, hint).because(Problem::duplicate(name)));
        }
        let values = parse_schedule(file, &bytes, Column { name, low, high: MOST }, Rows::Dated(&dates))?;
        let measure = if name == LOAD { Measure::Load(values) } else { Measure::Value(values) };
        all.push(Worth { column, measure });
    }
    if all.len() == usize::from(price.is_some()) {
        let what = format!("no column of the header is `{LOAD}`, or ends with `{PER_KWH}`");
        let hint = "name the column of prices eur_per_kwh, that of carbon kgco2_per_kwh, that of a load load_kw";
        return Err(Error::input(file, 1, what, hint).because(Problem::no_column(PER_KWH)));
    }
    Ok(all)
}

/// Returns the header. Refuses a column `time` whose months, days and hours are not those of the
/// rows of weather: clocks of prices often have summer time, those of weather files have not.
fn check_times(file: &Path, bytes: &[u8], rows: WeatherRows) -> Result<Vec<String>> {
    let header = column_names(file, bytes)?;
    if !header.iter().any(|name| name == TIME) {
        return Ok(header);
    }
    let texts = column_texts(file, bytes, TIME)?;
    let hour_of = |text: &str| text.get(5..13).map(|text| text.replace(' ', "T"));
    let chosen = rows.weather.rows.iter().zip(&rows.dated.chosen).filter_map(|(row, chosen)| chosen.then_some(row));
    // Twelve rows are months.
    for ((line, text), row) in texts.iter().zip(chosen).filter(|_| texts.len() != 12) {
        let label = row.interval.label();
        if hour_of(text) != hour_of(&label) {
            let what = format!("column `time` holds `{text}`, and the weather file has {label} in this row");
            let hint = "give the rows in the order of the weather file, at the start of each hour in its standard time, without summer \
                        time; or leave the column out";
            return Err(Error::input(file, *line, what, hint).because(Problem::value(TIME, text)));
        }
    }
    Ok(header)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Prices are numbers with a currency or without one; 7 other texts are refused.
    #[test]
    fn prices_have_any_currency() {
        let price = |text: &str| text.parse::<Price>().map(|price| (price.per_kwh, price.currency));
        assert_eq!(price("0.30EUR"), Ok((0.3, "eur".into())));
        assert_eq!(price("25 ct"), Ok((25.0, "ct".into())));
        assert_eq!(price("0.3"), Ok((0.3, String::new())));
        for text in ["", "EUR", "0,3EUR", "1e99", "1e9EUR0", "9999999999EUR", "0.3 EUR/kWh"] {
            assert!(price(text).is_err(), "{text}");
        }
    }

    /// An hour of 2 kW at 0.3 is worth 0.6; a load of 0.5 kW takes 0.5 of it, one of 3 kW all.
    #[test]
    fn worth_is_price_times_energy_or_what_a_load_takes() {
        let worth = |measure| Worth { column: String::new(), measure };
        assert_eq!(worth(Measure::Price(0.3)).of(0, 2.0), 0.6);
        assert_eq!(worth(Measure::Value(vec![0.1, -0.2])).of(1, 2.0), -0.4);
        let load = worth(Measure::Load(vec![0.5, 3.0]));
        assert_eq!((load.of(0, 2.0), load.of(1, 2.0)), (0.5, 2.0));
    }
}
