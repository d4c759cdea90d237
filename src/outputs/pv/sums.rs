//! Sums on points: a row a point and side, and a row a month. In: sums by month and component. Out: `points.csv`, `months.csv`.

use std::path::Path;

use glam::DVec3;

use super::write_csv;
use crate::outputs::provenance::Provenance;
use heliotile_core::error::Result;
use heliotile_core::orientation::fan::Turn;
use heliotile_core::replay::components::Component;

/// The components that add up to a total, which is the last.
pub const PARTS: [Component; 6] = {
    let [parts @ .., _] = Component::ALL;
    parts
};

/// Sums by month, kWh/m2: `[month][part]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MonthlySums(pub Vec<[f64; PARTS.len()]>);

impl MonthlySums {
    /// Of all months, by part.
    pub fn parts(&self) -> [f64; PARTS.len()] {
        std::array::from_fn(|part| self.0.iter().map(|month| month[part]).sum())
    }

    /// Of all months and parts.
    pub fn total(&self) -> f64 {
        self.0.iter().map(total).sum()
    }

    /// Adds a share of others, month by month.
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

/// One side of a module, or a point that has only one.
#[derive(Clone, Debug)]
pub struct SideSums {
    pub point: String,
    /// `front` or `rear`; nothing for points.
    pub side: &'static str,
    /// Input coordinates, metres.
    pub position: DVec3,
    /// By true north.
    pub turn: Turn,
    pub months: MonthlySums,
    /// What it would get on an open plain.
    pub open: MonthlySums,
    /// Share of its hemisphere that is sky, by the cosine.
    pub sky_view: f64,
    /// File of its horizon, if there is one.
    pub horizon: String,
    /// On front sides that have a rear: what that adds, percent.
    pub bifacial_gain_percent: Option<f64>,
}

impl SideSums {
    /// What is lost to all that stands around, percent of what an open plain would give; less than nothing where more is reflected.
    pub fn loss_percent(&self) -> Option<f64> {
        let open = self.open.total();
        (open > 0.0).then(|| 100.0 * (1.0 - self.months.total() / open))
    }
}

/// Writes `points.csv`: sums over all that was replayed.
pub fn write_points(path: &Path, sides: &[SideSums], about: &Provenance) -> Result<()> {
    let is_bifacial = sides.iter().any(|side| side.bifacial_gain_percent.is_some());
    let parts = PARTS.map(|part| format!("{}_kwh_m2", part.name()));
    let mut names = vec!["point", "side", "x", "y", "z", "tilt_deg", "azimuth_deg"];
    names.extend(parts.iter().map(String::as_str));
    names.extend(["total_kwh_m2", "open_kwh_m2", "shading_loss_percent", "sky_view", "horizon"]);
    if is_bifacial {
        names.push("bifacial_gain_percent");
    }
    let row = |side: &SideSums| {
        let mut cells = vec![side.point.clone(), side.side.to_owned()];
        cells.extend(side.position.to_array().map(|metres| format!("{metres:.4}")));
        cells.extend([side.turn.tilt_deg, side.turn.azimuth_deg].map(|degrees| format!("{degrees:.2}")));
        cells.extend(side.months.parts().map(kwh));
        cells.extend([side.months.total(), side.open.total()].map(kwh));
        cells.push(side.loss_percent().map_or_else(String::new, |loss| format!("{loss:.3}")));
        cells.push(format!("{:.5}", side.sky_view));
        cells.push(side.horizon.clone());
        if is_bifacial {
            cells.push(side.bifacial_gain_percent.map_or_else(String::new, |gain| format!("{gain:.3}")));
        }
        cells
    };
    write_csv(path, &names, &[], sides.iter().map(row), about)
}

/// Writes `months.csv`: `labels` names the months.
pub fn write_months(path: &Path, sides: &[SideSums], labels: &[String], about: &Provenance) -> Result<()> {
    let parts = PARTS.map(|part| format!("{}_kwh_m2", part.name()));
    let mut names = vec!["point", "side", "month"];
    names.extend(parts.iter().map(String::as_str));
    names.extend(["total_kwh_m2", "open_kwh_m2", "shading_loss_percent"]);
    let rows = sides.iter().flat_map(|side| {
        labels.iter().zip(side.months.0.iter().zip(&side.open.0)).map(move |(label, (month, open))| {
            let mut cells = vec![side.point.clone(), side.side.to_owned(), label.clone()];
            cells.extend(month.map(kwh));
            let (sum, open) = (total(month), total(open));
            cells.extend([kwh(sum), kwh(open)]);
            cells.push(if open > 0.0 { format!("{:.3}", 100.0 * (1.0 - sum / open)) } else { String::new() });
            cells
        })
    });
    write_csv(path, &names, &[], rows, about)
}

fn kwh(sum: f64) -> String {
    format!("{sum:.3}")
}
