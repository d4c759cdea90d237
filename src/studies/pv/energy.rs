//! Energy of an array of modules. In: hours of light on each module, rated powers, air. Out: DC and
//! AC energy by month and string, and what it is worth. [`super::pvwatts`] has the formulas.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use glam::DVec3;

use super::bypass::{LitModule, best_kw};
use super::pvwatts::{Inverter, Thermal, cover, dc_m2_w};
use super::spots::Spot;
use super::worth::{Price, Worth, read_worths};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::named::NamedValues;
use heliotile_core::observer::Observer;
use heliotile_core::orientation::fan::Orientation;
use heliotile_core::text::message;
use heliotile_core::units::parse_percent;
use heliotile_core::weather::conditions::Condition;
use heliotile_requests::{DefaultRequest, Request};
use heliotile_results::outputs::pv::energy::{ARRAY, ENERGIES, EnergySums, EnergyYears, MISMATCH, StringEnergy};
use heliotile_results::outputs::pv::hourly::SideHours;
use heliotile_results::outputs::pv::sums::{PartialShade, SideSums};
use heliotile_results::percentiles::Percentiles;
use heliotile_results::{Every, Resources, Series};
use heliotile_scene::pv::cells::CellGrid;
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
    /// DC power that partial shade of cells takes, `[hour]`, kW.
    mismatch_kw: Vec<f64>,
}

/// Light on a module.
pub struct ModuleLight<'a> {
    /// Its sides: one of a point, front and rear of a module.
    pub sides: Vec<SideLight<'a>>,
    /// Light on each cell of the front, if cells are stated: the direct sun and the rest, `[hour]`,
    /// W/m2.
    pub cells: &'a [Vec<[f32; 2]>],
}

/// Share of the power from which a module counts as shaded in part.
const PARTIAL_SHARE: f64 = 0.01;

/// Modules in series of which some are still to come.
struct Chain {
    /// Number of modules to come.
    left: usize,
    /// `[hour]`: modules, and the power of even light on all cells, kW.
    hours: Vec<(Vec<LitModule>, f64)>,
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
    /// `[spot]`: cells, and chain.
    cells: Vec<Option<(CellGrid, usize)>>,
    chains: HashMap<usize, Chain>,
    /// `[spot]`: partial shade of its cells.
    partial: Vec<PartialShade>,
    interval_hours: f64,
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
            (None, 0) => {
                let hint = "give {kwp}, or a column `kwp` of points, or a key `kwp` of rows";
                let what = "needs the rated power of the array";
                if request.price.is_some() || request.value.is_some() {
                    return Err(Error::argument("price, value", what, hint).because(Problem::needs("kwp")));
                }
                if spots.iter().any(|spot| spot.cells.is_some()) {
                    return Err(
                        Error::input(modules, None, format!("`cells` {what}"), hint).because(Problem::needs("kwp"))
                    );
                }
                return Ok(None);
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
                strings.push(PlantString {
                    name: name.to_owned(),
                    kwp: 0.0,
                    dc_kw: Vec::new(),
                    mismatch_kw: Vec::new(),
                });
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
        let bytes = strings.len() as u64 * air.len() as u64 * 16;
        if bytes > MAX_BYTES {
            let what = message!("the memory of the hours of {} strings, bytes", strings.len());
            return Err(Error::Limit { what, value: bytes, max: MAX_BYTES });
        }
        for string in &mut strings {
            (string.dc_kw, string.mismatch_kw) = (vec![0.0; air.len()], vec![0.0; air.len()]);
        }
        let cells: Vec<Option<(CellGrid, usize)>> = spots.iter().map(|spot| spot.cells).collect();
        let mut chains: HashMap<usize, Chain> = HashMap::new();
        for (_, chain) in cells.iter().flatten() {
            chains.entry(*chain).or_insert_with(|| Chain { left: 0, hours: Vec::new() }).left += 1;
        }
        let (covers, partial) = (HashMap::new(), vec![PartialShade::default(); spots.len()]);
        let interval_hours = rows.weather.interval_hours;
        Ok(Some(Plant { request, ratings, strings, air, worths, covers, cells, chains, partial, interval_hours }))
    }

    /// Adds the light on a module.
    pub fn add(&mut self, spot: usize, light: &ModuleLight) {
        let Some((of_string, kw)) = self.ratings.get(spot).copied() else { return };
        let per_k = self.request.temperature_coefficient / 100.0;
        let kept = 1.0 - self.request.losses / 100.0;
        let Some(string) = self.strings.get_mut(of_string) else { return };
        let (grid, chain) = self.cells.get(spot).copied().flatten().unzip();
        let order = grid.map_or_else(Vec::new, |grid| grid.order());
        let mut chain = chain.and_then(|chain| self.chains.get_mut(&chain));
        if let Some(chain) = &mut chain {
            chain.left -= 1;
            chain.hours.resize(self.air.len(), Default::default());
        }
        for (hour, [excess, air_c]) in self.air.iter().enumerate() {
            // Light on all of the module, what passes its cover, and what does on the rear.
            let (mut all, mut effective, mut behind) = (0.0, 0.0, 0.0);
            let covers = |side: &SideLight| side.cover.get(hour).copied().unwrap_or(1.0);
            for (number, side) in light.sides.iter().enumerate() {
                let [sun, rest] = side.hours.sun_and_rest(hour);
                let passed = side.share * (sun * covers(side) + rest);
                (all, effective) = (all + side.share * (sun + rest), effective + passed);
                behind += if number > 0 { passed } else { 0.0 };
            }
            let kw_m2_w = kw * kept * dc_m2_w(air_c + excess * all, per_k);
            let even_kw = effective * kw_m2_w;
            if let Some(sum) = string.dc_kw.get_mut(hour) {
                *sum += even_kw;
            }
            let (Some(grid), Some(front)) = (grid, light.sides.first()) else { continue };
            if even_kw <= 0.0 {
                continue;
            }
            let of_cell = |cell: &usize| {
                let light = light.cells.get(*cell).and_then(|cell| cell.get(hour)).copied().unwrap_or_default();
                let [sun, rest] = light.map(f64::from);
                (sun * covers(front) + rest + behind) as f32
            };
            let module = LitModule { kw_m2_w, light: order.iter().map(of_cell).collect() };
            if let Some(partial) = self.partial.get_mut(spot) {
                let lost_kw = (even_kw - best_kw(&grid, std::slice::from_ref(&module))).max(0.0);
                partial.even_kwh += even_kw * self.interval_hours;
                partial.lost_kwh += lost_kw * self.interval_hours;
                partial.hours += if lost_kw > PARTIAL_SHARE * even_kw { self.interval_hours } else { 0.0 };
            }
            if let Some((all, sum_kw)) = chain.as_mut().and_then(|chain| chain.hours.get_mut(hour)) {
                all.push(module);
                *sum_kw += even_kw;
            }
        }
        if chain.is_some_and(|chain| chain.left == 0) {
            self.close_chain(spot);
        }
    }

    /// Takes off what partial shade costs the chain of a module, all of which are known.
    fn close_chain(&mut self, spot: usize) {
        let Some((grid, chain)) = self.cells.get(spot).copied().flatten() else { return };
        let string = self.ratings.get(spot).and_then(|(string, _)| self.strings.get_mut(*string));
        let (Some(chain), Some(string)) = (self.chains.remove(&chain), string) else { return };
        let sums = string.dc_kw.iter_mut().zip(&mut string.mismatch_kw);
        for ((modules, even_kw), (dc_kw, mismatch_kw)) in chain.hours.iter().zip(sums) {
            let lost_kw = (even_kw - best_kw(&grid, modules)).max(0.0);
            *dc_kw -= lost_kw;
            *mismatch_kw += lost_kw;
        }
    }

    /// Returns the partial shade of the cells of each spot, if any are stated.
    pub fn partial_shade(&self) -> Option<&[PartialShade]> {
        self.cells.iter().any(Option::is_some).then_some(&self.partial)
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
    pub fn sums(&self, series: &Series, fronts: &[&SideSums], observer: &dyn Observer) -> EnergySums {
        let (months, years, interval_hours) = (series.by(Every::Month), series.by(Every::Year), self.interval_hours);
        let has_cells = self.partial_shade().is_some();
        let width = ENERGIES.len() + usize::from(has_cells) + self.worths.len();
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
            let mismatch = |string: &PlantString| string.mismatch_kw.get(hour).copied().unwrap_or_default();
            let mismatches =
                [self.strings.iter().map(mismatch).sum()].into_iter().chain(self.strings.iter().map(mismatch));
            for (sums, kw) in std::iter::once(&mut all).chain(&mut each).zip(mismatches).filter(|_| has_cells) {
                let sum = sums.months.get_mut(*month).and_then(|sums| sums.get_mut(ENERGIES.len()));
                sum.into_iter().for_each(|sum| *sum += kw * interval_hours);
            }
            if dc_kw <= 0.0 {
                continue;
            }
            let [ac_kw, clipped_kw] = inverter.ac_kw(dc_kw);
            let mut cells = vec![dc_kw, ac_kw, clipped_kw];
            cells.extend(has_cells.then_some(0.0));
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
        let worths = self.worths.iter().map(|worth| worth.column.clone());
        let columns = has_cells.then(|| MISMATCH.to_owned()).into_iter().chain(worths).collect();
        let hours = interval_hours * months.bins.of_condition.len() as f64;
        let strings: Vec<StringEnergy> = std::iter::once(all).chain(each).collect();
        let mut of_month = vec![0; months.labels.len()];
        for ((month, _), (year, _)) in months.bins.of_condition.iter().zip(&years.bins.of_condition) {
            of_month.get_mut(*month).into_iter().for_each(|of_month| *of_month = *year);
        }
        let years = (years.labels.len() > 1).then(|| years_of(&strings, &years, &of_month, observer));
        EnergySums { columns, strings, months: months.labels.text, years, hours, bifaciality: None }
    }
}

/// Returns the sums of strings by year, and their percentiles, each column by itself.
fn years_of(strings: &[StringEnergy], years: &Series, of_month: &[usize], observer: &dyn Observer) -> EnergyYears {
    // Fewer than three complete years have no percentiles.
    let percentiles = Percentiles::of_complete(years, observer).ok();
    let of_string = |string: &StringEnergy| {
        let mut sums = string.by_year(of_month, years.labels.len());
        let Some(percentiles) = &percentiles else { return sums };
        let column = |at: usize| sums.iter().filter_map(|year| year.get(at)).copied().collect::<Vec<f64>>();
        let width = sums.first().map_or(0, Vec::len);
        let columns: Vec<_> = (0..width).map(|at| percentiles.of_years(&column(at))).collect();
        let of = |row: usize| columns.iter().filter_map(|column| column.get(row)).copied().collect::<Vec<f64>>();
        let rows: Vec<Vec<f64>> = (0..Percentiles::labels().len()).map(of).collect();
        sums.extend(rows);
        sums
    };
    let mut labels = years.labels.text.clone();
    labels.extend(percentiles.iter().flat_map(|_| Percentiles::labels().text));
    let complete = percentiles.as_ref().map_or(0, Percentiles::years);
    EnergyYears { labels, sums: strings.iter().map(of_string).collect(), complete }
}
