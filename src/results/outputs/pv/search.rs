//! Results of a search of orientations. In: orientations of points and their sums. Out:
//! `search.csv` with all of them, and `best.csv`, a row a point.

use std::path::Path;

use crate::outputs::provenance::Provenance;
use crate::outputs::tables::column::Column;
use crate::outputs::tables::records::Records;
use crate::outputs::tables::table::Cell;
use heliotile_core::error::Result;
use heliotile_core::orientation::best::OrientationValue;
use heliotile_core::orientation::fan::Ring;

/// Results of a search for a point, kWh/m2.
#[derive(Clone, Debug)]
pub struct PointSearch {
    pub point: String,
    /// Rings of the first fan, each with the sum of each orientation.
    pub rings: Vec<(Ring, Vec<f64>)>,
    /// Allowed orientations of the second fan.
    pub fine: Vec<OrientationValue>,
    pub best: OrientationValue,
    /// Standard deviation of single orientations from the fit whose peak is the best one, percent.
    pub scatter_percent: f64,
    /// Sum of a horizontal surface that faces up.
    pub flat: OrientationValue,
    /// Sum of the orientation in the table of points, if it has one.
    pub given: Option<OrientationValue>,
    /// Best orientation of the point on an open plain, with its sum.
    pub open_best: OrientationValue,
}

impl PointSearch {
    /// Returns the loss of a sum against the best one, percent; 0 if no orientation gets any light.
    pub fn loss_percent(&self, value: f64) -> f64 {
        if self.best.value > 0.0 { 100.0 * (1.0 - value / self.best.value) } else { 0.0 }
    }

    /// Returns all orientations that were tried, each with its kind.
    fn rows(&self) -> impl Iterator<Item = (&'static str, OrientationValue)> + '_ {
        let coarse = self.rings.iter().flat_map(|(ring, values)| {
            ring.turns().zip(values).map(|(turn, value)| ("coarse", OrientationValue { turn, value: *value }))
        });
        let fine = self.fine.iter().map(|found| ("fine", *found));
        let named = [("flat", Some(self.flat)), ("given", self.given), ("best", Some(self.best))];
        coarse.chain(fine).chain(named.into_iter().filter_map(|(kind, found)| Some((kind, found?))))
    }
}

/// Decimals of sums, losses and orientations that were tried; `TURN_DECIMALS` are those of the best
/// orientations.
const DECIMALS: usize = 3;
const TURN_DECIMALS: usize = 2;

/// Writes every orientation that was tried.
pub fn write_all(path: &Path, points: &[PointSearch], about: &Provenance) -> Result<()> {
    let numbers =
        ["tilt_deg", "azimuth_deg", "total_kwh_m2", "loss_percent"].map(|name| Column::number(name, DECIMALS));
    let columns = ["point", "kind"].map(Column::text).into_iter().chain(numbers).collect();
    let rows = points.iter().flat_map(|search| {
        search.rows().map(move |(kind, found)| {
            let numbers = [found.turn.tilt_deg, found.turn.azimuth_deg, found.value, search.loss_percent(found.value)];
            [Cell::from(&search.point), kind.into()].into_iter().chain(numbers.map(Cell::from)).collect()
        })
    });
    let rows = rows.collect();
    Records { columns, rows }.write(path, about).map(drop)
}

/// Writes the best orientation of each point, losses of other orientations, and the best
/// orientation on an open plain.
pub fn write_best(path: &Path, points: &[PointSearch], about: &Provenance) -> Result<()> {
    let turn = |name: &str| Column::number(name, TURN_DECIMALS);
    let sum = |name: &str| Column::number(name, DECIMALS);
    let columns = vec![
        Column::text("point"),
        turn("tilt_deg"),
        turn("azimuth_deg"),
        sum("total_kwh_m2"),
        sum("scatter_percent"),
        sum("flat_kwh_m2"),
        sum("flat_loss_percent"),
        turn("given_tilt_deg"),
        turn("given_azimuth_deg"),
        sum("given_kwh_m2"),
        sum("given_loss_percent"),
        turn("open_tilt_deg"),
        turn("open_azimuth_deg"),
        sum("open_kwh_m2"),
    ];
    let rows = points.iter().map(best_row).collect();
    Records { columns, rows }.write(path, about).map(drop)
}

/// Returns the row of a point.
fn best_row(search: &PointSearch) -> Vec<Cell> {
    let (best, flat, open, given) = (&search.best, &search.flat, &search.open_best, search.given.as_ref());
    vec![
        Cell::from(&search.point),
        best.turn.tilt_deg.into(),
        best.turn.azimuth_deg.into(),
        best.value.into(),
        search.scatter_percent.into(),
        flat.value.into(),
        search.loss_percent(flat.value).into(),
        given.map(|given| given.turn.tilt_deg).into(),
        given.map(|given| given.turn.azimuth_deg).into(),
        given.map(|given| given.value).into(),
        given.map(|given| search.loss_percent(given.value)).into(),
        open.turn.tilt_deg.into(),
        open.turn.azimuth_deg.into(),
        open.value.into(),
    ]
}
