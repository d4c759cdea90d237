//! Sums on points: a row a point and side, and a row a month. In: sums by month and component. Out:
//! `points.csv`, `months.csv`.

use std::path::Path;

use glam::DVec3;

use super::hourly::SideHours;
use crate::outputs::provenance::Provenance;
use crate::outputs::tables::column::{Column, Digits};
use crate::outputs::tables::records::Records;
use crate::outputs::tables::table::Cell;
use heliotile_core::error::Result;
use heliotile_core::orientation::fan::Orientation;
use heliotile_core::replay::components::{Component, SUM_SUFFIX};
use heliotile_core::weather::time::bins::Bins;

/// Components that add up to the total, which is the last of all.
pub const PARTS: [Component; 6] = {
    let [parts @ .., _] = Component::ALL;
    parts
};

/// Sums by month, kWh/m2: `[month][part]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MonthlySums(pub Vec<[f64; PARTS.len()]>);

impl MonthlySums {
    /// Returns the sums of hours; `bins` are those of the months.
    pub fn new(hours: &SideHours, bins: &Bins) -> Self {
        let mut months = vec![[0.0; PARTS.len()]; bins.count];
        for (part, of_part) in hours.0.iter().enumerate() {
            for (light, (month, weight)) in of_part.iter().zip(&bins.of_condition) {
                let sum = months.get_mut(*month).and_then(|month| month.get_mut(part));
                sum.into_iter().for_each(|sum| *sum += weight * f64::from(*light));
            }
        }
        MonthlySums(months)
    }

    /// Returns the sums of all months, by part.
    pub fn parts(&self) -> [f64; PARTS.len()] {
        std::array::from_fn(|part| self.0.iter().map(|month| month[part]).sum())
    }

    /// Returns the sums of all parts, month by month.
    pub fn totals(&self) -> impl Iterator<Item = f64> + '_ {
        self.0.iter().map(total)
    }

    /// Returns the sum of all months and parts.
    pub fn total(&self) -> f64 {
        self.totals().sum()
    }

    /// Adds `share` times the sums of `other`, month by month.
    pub fn add(&mut self, other: &MonthlySums, share: f64) {
        self.0.resize(other.0.len().max(self.0.len()), [0.0; PARTS.len()]);
        for (month, more) in self.0.iter_mut().zip(&other.0) {
            month.iter_mut().zip(more).for_each(|(sum, value)| *sum += share * value);
        }
    }
}

fn total(month: &[f64; PARTS.len()]) -> f64 {
    month.iter().sum()
}

/// Side of a module, or a point with one side only, with its sums.
#[derive(Clone, Debug)]
pub struct SideSums {
    pub point: String,
    /// `front` or `rear`; empty for points.
    pub side: &'static str,
    /// Position in input coordinates, metres.
    pub position: DVec3,
    /// Orientation by true north; `None` on trackers.
    pub turn: Option<Orientation>,
    pub months: MonthlySums,
    /// Sums that it would have on an open plain.
    pub open: MonthlySums,
    /// Cosine-weighted share of its hemisphere that is sky.
    pub sky_view: f64,
    /// Name of the file of its horizon; empty if there is none.
    pub horizon: String,
    /// Gain by the rear, percent: the light on the rear times the bifaciality, relative to the
    /// light on the front; only on front sides that have a rear.
    pub bifacial_gain_percent: Option<f64>,
    /// Partial shade of its cells; only of fronts with cells.
    pub partial: Option<PartialShade>,
}

/// Partial shade of the cells of a module that works on its own.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PartialShade {
    /// DC energy of even light on all cells, kWh.
    pub even_kwh: f64,
    /// DC energy that partial shade takes, kWh.
    pub lost_kwh: f64,
    /// Hours in which it takes more than 1 % of the power.
    pub hours: f64,
}

impl SideSums {
    /// Returns the loss to all surroundings, percent of the sum on an open plain; negative if the
    /// surroundings reflect more than they hide.
    pub fn loss_percent(&self) -> Option<f64> {
        loss_percent(self.months.total(), self.open.total())
    }
}

/// Writes `points.csv`: sums over the whole replay.
pub fn write_points(path: &Path, sides: &[SideSums], about: &Provenance) -> Result<()> {
    let is_bifacial = sides.iter().any(|side| side.bifacial_gain_percent.is_some());
    let mut columns = vec![Column::text("point"), Column::text("side")];
    // Points keep all digits, so that the table can be given as points again.
    let of_points = sides.iter().all(|side| side.side.is_empty());
    let number = |name, decimals| match of_points {
        true => Column::number_as(name, Digits::Fewest),
        false => Column::number(name, decimals),
    };
    columns.extend(["x", "y", "z"].map(|name| number(name, 4)));
    columns.extend(["tilt_deg", "azimuth_deg"].map(|name| number(name, 2)));
    columns.extend(columns_of_sums());
    columns.extend([Column::number("sky_view", 5), Column::text("horizon")]);
    columns.extend(is_bifacial.then(|| Column::number("bifacial_gain_percent", DECIMALS)));
    let has_cells = sides.iter().any(|side| side.partial.is_some());
    let of_cells = ["mismatch_loss_percent", "partial_shade_h"].map(|name| Column::number(name, DECIMALS));
    columns.extend(of_cells.into_iter().filter(|_| has_cells));
    let rows = sides.iter().map(|side| {
        let mut cells = vec![Cell::from(&side.point), side.side.into()];
        cells.extend(side.position.to_array().map(Cell::from));
        cells.extend([side.turn.map(|turn| turn.tilt_deg), side.turn.map(|turn| turn.azimuth_deg)].map(Cell::from));
        cells.extend(side.months.parts().map(Cell::from));
        cells.extend([side.months.total(), side.open.total()].map(Cell::from));
        cells.extend([side.loss_percent().into(), side.sky_view.into(), Cell::from(&side.horizon)]);
        cells.extend(is_bifacial.then(|| side.bifacial_gain_percent.into()));
        let lost = side.partial.filter(|partial| partial.even_kwh > 0.0);
        let of_cells = [lost.map(|of| 100.0 * of.lost_kwh / of.even_kwh), side.partial.map(|of| of.hours)];
        cells.extend(of_cells.map(Cell::from).into_iter().filter(|_| has_cells));
        cells
    });
    let rows = rows.collect();
    Records { columns, rows }.write(path, about).map(drop)
}

/// Writes `months.csv`; `labels` are the names of the months.
pub fn write_months(path: &Path, sides: &[SideSums], labels: &[String], about: &Provenance) -> Result<()> {
    let mut columns = vec![Column::text("point"), Column::text("side"), Column::text("month")];
    columns.extend(columns_of_sums());
    let rows = sides.iter().flat_map(|side| {
        labels.iter().zip(side.months.0.iter().zip(&side.open.0)).map(move |(label, (month, open))| {
            let mut cells = vec![Cell::from(&side.point), side.side.into(), label.into()];
            cells.extend(month.map(Cell::from));
            let (sum, open) = (total(month), total(open));
            cells.extend([Cell::from(sum), open.into(), loss_percent(sum, open).into()]);
            cells
        })
    });
    let rows = rows.collect();
    Records { columns, rows }.write(path, about).map(drop)
}

/// Decimals of sums and percentages in CSV.
pub const DECIMALS: usize = 3;

/// Returns the names of sums by part.
pub fn columns_of_parts() -> impl Iterator<Item = String> {
    PARTS.map(|part| format!("{}{SUM_SUFFIX}", part.name())).into_iter()
}

/// Returns the columns of sums by part, their total, the total on an open plain, and the loss
/// against it.
fn columns_of_sums() -> impl Iterator<Item = Column> {
    let others = ["total_kwh_m2", "open_kwh_m2", "shading_loss_percent"].map(str::to_owned);
    columns_of_parts().chain(others).map(|name| Column::number(name, DECIMALS))
}

/// Returns the loss against the sum on an open plain, percent.
pub fn loss_percent(sum: f64, open: f64) -> Option<f64> {
    (open > 0.0).then(|| 100.0 * (1.0 - sum / open))
}
