//! Sums on the ground among rows of modules: a row a receiver, and a row a month. In: sums by month
//! of all light and of photosynthetically active radiation (PAR), and the PAR of an open plain.
//! Out: `ground.csv`, `ground_months.csv`.

use std::path::Path;

use glam::DVec3;

use super::sums::{DECIMALS, MonthlySums, columns_of_parts};
use crate::outputs::provenance::Provenance;
use crate::outputs::tables::column::Column;
use crate::outputs::tables::records::Records;
use crate::outputs::tables::table::Cell;
use heliotile_core::error::Result;
use heliotile_core::replay::components::Component;

/// Components of photosynthetically active radiation: energy, photons.
pub const PAR: [Component; 2] = [Component::TotalPar, Component::Ppfd];

/// Sums of [`PAR`], kWh/m2 and mol/m2: `[month][column]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlantLight(pub Vec<[f64; PAR.len()]>);

impl PlantLight {
    /// Returns the sums of all months.
    fn all(&self) -> [f64; PAR.len()] {
        std::array::from_fn(|column| self.0.iter().filter_map(|month| month.get(column)).sum())
    }
}

/// Numbers of days that have rows of weather.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DayCounts {
    /// Number of days of all months.
    pub all: usize,
    /// `[month]`: number of days.
    pub of_month: Vec<usize>,
}

/// Position on the ground, with its sums.
#[derive(Clone, Debug)]
pub struct GroundSums {
    pub receiver: String,
    /// Name of the rows of modules around it.
    pub rows: String,
    /// Position in input coordinates, metres.
    pub position: DVec3,
    /// Distance behind the lower edge of a row, in plan, from 0 to the pitch, metres.
    pub behind_m: f64,
    pub months: MonthlySums,
    pub par: PlantLight,
    /// Sums that it would have on an open plain.
    pub open: PlantLight,
    /// Cosine-weighted share of its hemisphere that is sky.
    pub sky_view: f64,
}

/// All positions on the ground, with their sums.
#[derive(Clone, Debug, Default)]
pub struct SumsOnGround {
    /// Positions in the order of rows of the tables.
    pub places: Vec<GroundSums>,
    pub days: DayCounts,
}

impl GroundSums {
    /// Returns the PAR in percent of that of an open plain; `None` if that has no light.
    pub fn par_of_open_percent(&self) -> Option<f64> {
        percent(self.par.all(), self.open.all())
    }

    /// Returns the photons a day, mol/m2, as a mean over days.
    pub fn daily_photons(&self, days: &DayCounts) -> Option<f64> {
        daily(self.par.all(), days.all)
    }
}

/// Writes `ground.csv`: sums over the whole replay.
pub fn write_ground(path: &Path, ground: &SumsOnGround, about: &Provenance) -> Result<()> {
    let mut columns = vec![Column::text("receiver")];
    columns.extend(["x", "y", "z", "behind_m"].map(|name| Column::number(name, 4)));
    columns.extend(columns_of_parts().chain(["total_kwh_m2".to_owned()]).map(|name| Column::number(name, DECIMALS)));
    columns.extend(columns_of_par());
    columns.extend([Column::number("open_par_kwh_m2", DECIMALS), Column::number("par_of_open_percent", DECIMALS)]);
    columns.push(Column::number("sky_view", 5));
    let row = |place: &GroundSums| {
        let mut cells = vec![Cell::from(&place.receiver)];
        cells.extend(place.position.to_array().map(Cell::from));
        cells.push(place.behind_m.into());
        cells.extend(place.months.parts().map(Cell::from));
        cells.push(place.months.total().into());
        cells.extend(place.par.all().map(Cell::from));
        cells.push(place.daily_photons(&ground.days).into());
        let [open, _] = place.open.all();
        cells.extend([Cell::from(open), place.par_of_open_percent().into(), place.sky_view.into()]);
        cells
    };
    let rows = ground.places.iter().map(row).collect();
    Records { columns, rows }.write(path, about).map(drop)
}

/// Writes `ground_months.csv`; `labels` are the names of the months.
pub fn write_ground_months(path: &Path, ground: &SumsOnGround, labels: &[String], about: &Provenance) -> Result<()> {
    let mut columns = vec![Column::text("receiver"), Column::text("month"), Column::number("total_kwh_m2", DECIMALS)];
    columns.extend(columns_of_par());
    columns.push(Column::number("par_of_open_percent", DECIMALS));
    let rows = ground.places.iter().flat_map(|place| {
        let light = place.par.0.iter().zip(&place.open.0).zip(&ground.days.of_month);
        let months = labels.iter().zip(place.months.totals()).zip(light);
        months.map(move |((label, total), ((par, open), days))| {
            let mut cells = vec![Cell::from(&place.receiver), label.into(), total.into()];
            cells.extend(par.map(Cell::from));
            cells.extend([daily(*par, *days).into(), percent(*par, *open).into()]);
            cells
        })
    });
    let rows = rows.collect();
    Records { columns, rows }.write(path, about).map(drop)
}

/// Returns the columns of energy, photons, and photons a day: the daily light integral.
fn columns_of_par() -> impl Iterator<Item = Column> {
    let names = PAR.map(|column| format!("{}{}", column.name(), column.measure().sum_suffix()));
    names.into_iter().chain(["dli_mol_m2_d".to_owned()]).map(|name| Column::number(name, DECIMALS))
}

fn percent([par, _]: [f64; PAR.len()], [open, _]: [f64; PAR.len()]) -> Option<f64> {
    (open > 0.0).then(|| 100.0 * par / open)
}

fn daily([_, photons]: [f64; PAR.len()], days: usize) -> Option<f64> {
    (days > 0).then(|| photons / days as f64)
}
