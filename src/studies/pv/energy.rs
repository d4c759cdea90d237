//! Energy of an array of modules. In: hours of light on each module, rated powers, air. Out: DC and
//! AC energy by month and string, and what it is worth. [`super::pvwatts`] has the formulas.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use glam::DVec3;

use super::pvwatts::{Inverter, Thermal, cover, dc};
use super::spots::Spot;
use super::worth::{Price, Worth, read_worths};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::named::NamedValues;
use heliotile_core::orientation::fan::Orientation;
use heliotile_core::text::message;
use heliotile_core::units::parse_percent;
use heliotile_core::weather::conditions::Condition;
use heliotile_requests::{DefaultRequest, Request};
use heliotile_results::outputs::pv::energy::{ARRAY, ENERGIES, EnergySums, StringEnergy};
use heliotile_results::outputs::pv::hourly::SideHours;
use heliotile_results::outputs::pv::sums::SideSums;
use heliotile_results::{Every, Resources, Series};
use heliotile_weather::dated::DatedRows;
use heliotile_weather::series::Weather;

/// Request for the energy of an array.
#[derive(Clone, Debug, Request, DefaultRequest)]
pub struct EnergyRequest {
    /// Rated power of the array, kW at standard test conditions, in equal shares of all points or
    /// modules. A column `kwp` of points or a key `kwp` of rows states that of each instead. A
    /// column or key `string` adds sums of each string.
    #[field(metavar = "KW", range = 0.000001..=1_000_000_000.0)]
    pub kwp: Option<f64>,
    /// Temperature coefficient of power, percent per K: -0.35 of today's silicon modules, -0.47 of
    /// those of 2014.
    #[field(metavar = "PERCENT", default = "-0.35", hyphen, range = -2.0..=0.0)]
    pub temperature_coefficient: f64,
    /// Mounting, which decides how much warmer than the air cells are.
    #[field(default = "open")]
    pub mounting: Mounting,
    /// System losses: dirt, mismatch, wiring, age. The 14 % of PVWatts contain 3 % for shade, which
    /// is traced here; without it they are 11.4 %.
    #[field(metavar = "PERCENT", default = "14%", parse = parse_losses)]
    pub losses: f64,
    /// Nominal efficiency of the inverter.
    #[field(default = 0.96, range = 0.5..=1.0)]
    pub inverter_efficiency: f64,
    /// Ratio of the array's rated power to the inverter's.
    #[field(default = 1.1, range = 0.1..=10.0)]
    pub dc_ac_ratio: f64,
    /// Price of a kWh, in any currency, such as 0.30EUR.
    #[field(metavar = "PRICE")]
    pub price: Option<Price>,
    /// Values by the hour, CSV: a row for each row of the weather file, or 12 rows, one a month. A
    /// column `X_per_kwh` (a price, carbon) gives the sum of X, a column `load_kw` the energy that
    /// the load takes at once. A column `time` is compared with the weather file.
    #[field(metavar = "FILE", input = Any)]
    pub value: Option<PathBuf>,
}

/// Mounting of modules.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mounting {
    /// On a rack, with air behind.
    #[default]
    Open,
    /// Close to a roof, with little air behind.
    Roof,
}

impl NamedValues for Mounting {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("open", "On a rack, with air behind", Mounting::Open),
        ("roof", "Close to a roof, with little air behind", Mounting::Roof),
    ];
}

heliotile_core::serde_by_name!(Mounting);

heliotile_core::parse_by_name!(Mounting);

fn parse_losses(text: &str) -> std::result::Result<f64, String> {
    parse_percent(text, 0.0..=99.0).ok_or_else(|| format!("`{text}` is no share of losses: give percent, as in 14%"))
}

/// Wind where the weather file states none, m/s: that of the nominal module temperature of IEC
/// 61215.
const USUAL_WIND_M_S: f64 = 1.0;

/// Rated power above which modules would give more than the light that they are rated at, kW/m2.
const MAX_KW_M2: f64 = 1.0;

/// Area that a point stands for in that comparison, m2: that of a large roof.
const LARGE_M2: f64 = 1000.0;

/// Largest memory of the hours of all strings, bytes.
const MAX_BYTES: u64 = 2 << 30;

impl EnergyRequest {
    /// Returns the excess of cells for each W/m2, K m2/W, and the temperature of the air, of the
    /// rows of weather that count. Fails if a row with light lacks a temperature; warns if the file
    /// lacks wind.
    fn air(&self, rows: WeatherRows, resources: &Resources) -> Result<Vec<[f64; 2]>> {
        let WeatherRows { file, weather, dated } = rows;
        let thermal = match self.mounting {
            Mounting::Open => Thermal::OPEN,
            Mounting::Roof => Thermal::ROOF,
        };
        let (mut hours, mut windless) = (Vec::new(), 0_u64);
        for (place, (row, _)) in weather.rows.iter().zip(&dated.chosen).enumerate().filter(|(_, (_, is))| **is) {
            let air = weather.air.get(place).copied().unwrap_or_default();
            let has_light = row.dni_w_m2 > 0.0 || row.dhi_w_m2 > 0.0;
            if has_light && air.dry_bulb_c.is_none() {
                let what = format!("{} has light but no air temperature", row.interval.label());
                let hint = "add the temperature to the file: the power of modules depends on it";
                return Err(Error::input(file, row.line, what, hint).because(Problem::Lacks("temperature")));
            }
            windless += u64::from(has_light && air.wind_m_s.is_none());
            let wind_m_s = air.wind_m_s.unwrap_or(USUAL_WIND_M_S);
            hours.push([thermal.excess_k_m2_w(wind_m_s), air.dry_bulb_c.unwrap_or_default()]);
        }
        if windless > 0 {
            let file = file.display();
            resources.observer.warn(format!(
                "{file}: {windless} hours with light have no wind; modules are cooled by {USUAL_WIND_M_S} m/s there"
            ));
        }
        Ok(hours)
    }
}

/// Returns the transmittance of a cover for the sun of an hour, weighted by the light of its
/// positions; `normals` are those of the side at each.
pub fn mean_cover(condition: &Condition, normals: impl Iterator<Item = DVec3>) -> f64 {
    let (mut light, mut passed) = (0.0, 0.0);
    for (instant, normal) in condition.suns.iter().zip(normals) {
        let cos = normal.dot(instant.sun).max(0.0);
        light += instant.weight * cos;
        passed += instant.weight * cos * cover(cos);
    }
    if light > 0.0 { passed / light } else { 1.0 }
}

/// Rows of a weather file that count.
#[derive(Clone, Copy)]
pub struct WeatherRows<'a> {
    pub file: &'a Path,
    pub weather: &'a Weather,
    pub dated: &'a DatedRows,
}

/// Light on a side of a module.
pub struct SideLight<'a> {
    pub hours: &'a SideHours,
    /// Mean transmittance of the cover for the sun of each hour.
    pub cover: Rc<Vec<f64>>,
    /// Share of the light that counts: 1, or the bifaciality.
    pub share: f64,
}

/// String of modules.
struct PlantString {
    name: String,
    /// Rated power, kW.
    kwp: f64,
    /// DC power after losses, `[hour]`, kW.
    dc_kw: Vec<f64>,
}

/// Array of modules: ratings, air and worth of each hour; and the hours of its strings.
pub struct Plant<'a> {
    request: &'a EnergyRequest,
    /// `[spot]`: string and rated power, kW.
    ratings: Vec<(usize, f64)>,
    strings: Vec<PlantString>,
    /// `[hour]`: excess of cells, K m2/W, and temperature of the air.
    air: Vec<[f64; 2]>,
    worths: Vec<Worth>,
    /// Mean transmittance of the cover for the sun of each hour, by the bits of a normal.
    covers: HashMap<[u64; 3], Rc<Vec<f64>>>,
}

impl<'a> Plant<'a> {
    /// Prepares the array of modules; `None` if nothing states a rated power. `modules` is their
    /// file, for messages.
    pub fn new(
        request: &'a EnergyRequest,
        modules: &Path,
        spots: &[Spot],
        rows: WeatherRows,
        resources: &Resources,
    ) -> Result<Option<Self>> {
        let rated = spots.iter().filter(|spot| spot.rating.kwp.is_some()).count();
        let each_kw = match (request.kwp, rated) {
            (Some(_), 1..) => {
                let hint = "leave out {kwp}, or the column or key `kwp`";
                return Err(Error::argument("kwp", "is given, and modules state their own", hint)
                    .because(Problem::excludes("points, rows")));
            }
            (Some(kwp), 0) => Some(kwp / spots.len().max(1) as f64),
            (None, 1..) => None,
            (None, 0) if request.price.is_none() && request.value.is_none() => return Ok(None),
            (None, 0) => {
                let hint = "give {kwp}, or a column `kwp` of points, or a key `kwp` of rows";
                return Err(Error::argument("price, value", "need the rated power of the array", hint)
                    .because(Problem::needs("kwp")));
            }
        };
        if let Some(spot) = spots.iter().find(|spot| each_kw.is_none() && spot.rating.kwp.is_none()) {
            let what = format!("`{}` has no rated power, and {rated} others have one", spot.name);
            let hint = "state `kwp` of each, 0 for one that is not built";
            return Err(Error::input(modules, None, what, hint).because(Problem::Lacks("kwp")));
        }
        let air = request.air(rows, resources)?;
        let worths = read_worths(request.price.as_ref(), request.value.as_deref(), rows, resources)?;
        let mut strings: Vec<PlantString> = Vec::new();
        let mut of_name: HashMap<&str, usize> = HashMap::new();
        let (mut ratings, mut strongest) = (Vec::new(), 0.0_f64);
        for spot in spots {
            let name = spot.rating.string.as_str();
            if name == ARRAY {
                let hint = "give the string another name: this one is that of the sum of all";
                return Err(Error::input(modules, None, format!("a string is named `{ARRAY}`"), hint)
                    .because(Problem::duplicate(ARRAY)));
            }
            let string = *of_name.entry(name).or_insert_with(|| {
                strings.push(PlantString { name: name.to_owned(), kwp: 0.0, dc_kw: Vec::new() });
                strings.len() - 1
            });
            let kw = each_kw.or(spot.rating.kwp).unwrap_or_default();
            strongest = strongest.max(kw / spot.front_m2().unwrap_or(LARGE_M2));
            strings.get_mut(string).into_iter().for_each(|string| string.kwp += kw);
            ratings.push((string, kw));
        }
        if strings.iter().all(|string| string.kwp == 0.0) {
            let hint = "state the rated power of a module, kW";
            return Err(Error::input(modules, None, "all modules have a rated power of 0", hint)
                .because(Problem::value("kwp", "0")));
        }
        if strongest > MAX_KW_M2 {
            resources.observer.warn(format!(
                "{}: a module has {:.1} kW a square metre, more than the light on it: is its rated power in watts?",
                modules.display(),
                strongest
            ));
        }
        let bytes = strings.len() as u64 * air.len() as u64 * 8;
        if bytes > MAX_BYTES {
            let what = message!("the memory of the hours of {} strings, bytes", strings.len());
            return Err(Error::Limit { what, value: bytes, max: MAX_BYTES });
        }
        strings.iter_mut().for_each(|string| string.dc_kw = vec![0.0; air.len()]);
        Ok(Some(Plant { request, ratings, strings, air, worths, covers: HashMap::new() }))
    }

    /// Adds the light on the sides of a module.
    pub fn add(&mut self, spot: usize, sides: &[SideLight]) {
        let Some((string, kw)) = self.ratings.get(spot).copied() else { return };
        let per_k = self.request.temperature_coefficient / 100.0;
        let kept = 1.0 - self.request.losses / 100.0;
        let Some(string) = self.strings.get_mut(string) else { return };
        for (hour, (sum, [excess, air_c])) in string.dc_kw.iter_mut().zip(&self.air).enumerate() {
            let (mut all, mut effective) = (0.0, 0.0);
            for side in sides {
                let [sun, rest] = side.hours.sun_and_rest(hour);
                all += side.share * (sun + rest);
                effective += side.share * (sun * side.cover.get(hour).copied().unwrap_or(1.0) + rest);
            }
            *sum += kw * kept * dc(effective, air_c + excess * all, per_k);
        }
    }

    /// Returns the transmittance of the cover of a fixed side for the sun of each hour.
    pub fn cover_of(&mut self, turn: Orientation, series: &Series) -> Rc<Vec<f64>> {
        let normal = turn.normal();
        let mean = |condition: &Condition| mean_cover(condition, std::iter::repeat(normal));
        let key = normal.to_array().map(f64::to_bits);
        let of = || Rc::new(series.conditions.iter().map(mean).collect());
        Rc::clone(self.covers.entry(key).or_insert_with(of))
    }

    /// Returns the sums by month of the array and, if there are strings, of each; `fronts` are
    /// those of all modules in their order.
    pub fn sums(&self, series: &Series, interval_hours: f64, fronts: &[&SideSums]) -> EnergySums {
        let months = series.by(Every::Month);
        let width = ENERGIES.len() + self.worths.len();
        let of = |name: &str, kwp: f64| StringEnergy {
            name: name.to_owned(),
            kwp,
            months: vec![vec![0.0; width]; months.labels.len()],
            fronts: vec![[0.0; 2]; months.labels.len()],
        };
        let kwp: f64 = self.strings.iter().map(|string| string.kwp).sum();
        let mut all = of(ARRAY, kwp);
        let mut each: Vec<StringEnergy> = self.strings.iter().map(|string| of(&string.name, string.kwp)).collect();
        let request = self.request;
        let inverter = Inverter { rated_kw: kwp / request.dc_ac_ratio, efficiency: request.inverter_efficiency };
        for (hour, (month, _)) in months.bins.of_condition.iter().enumerate() {
            let dc_kw: f64 = self.strings.iter().filter_map(|string| string.dc_kw.get(hour)).sum();
            if dc_kw <= 0.0 {
                continue;
            }
            let [ac_kw, clipped_kw] = inverter.ac_kw(dc_kw);
            let mut cells = vec![dc_kw, ac_kw, clipped_kw];
            cells.extend(self.worths.iter().map(|worth| worth.of(hour, ac_kw)));
            // The strings share one inverter: each gets its part by its DC power.
            let of_strings = each.iter_mut().zip(&self.strings);
            let parts = of_strings.map(|(sums, string)| (sums, string.dc_kw.get(hour).map_or(0.0, |kw| kw / dc_kw)));
            for (sums, share) in std::iter::once((&mut all, 1.0)).chain(parts) {
                let Some(sums) = sums.months.get_mut(*month) else { continue };
                sums.iter_mut().zip(&cells).for_each(|(sum, cell)| *sum += share * cell * interval_hours);
            }
        }
        for ((string, kw), front) in self.ratings.iter().zip(fronts) {
            all.add_front(*kw, front);
            each.get_mut(*string).into_iter().for_each(|string| string.add_front(*kw, front));
        }
        // Modules without a string are a part of the array only.
        each.retain(|string| !string.name.is_empty());
        let columns = self.worths.iter().map(|worth| worth.column.clone()).collect();
        let hours = interval_hours * months.bins.of_condition.len() as f64;
        let strings = std::iter::once(all).chain(each).collect();
        EnergySums { columns, strings, months: months.labels.text, hours, bifaciality: None }
    }
}
