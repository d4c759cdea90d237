//! What a search of turns found. In: turns of points and what they get. Out: `search.csv`, all of them, and `best.csv`, a row a point.

use std::path::Path;

use super::write_csv;
use crate::outputs::provenance::Provenance;
use heliotile_core::error::Result;
use heliotile_core::orientation::best::TurnValue;
use heliotile_core::orientation::fan::Ring;

/// All that was found for a point, kWh/m2.
#[derive(Clone, Debug)]
pub struct PointSearch {
    pub point: String,
    /// Of the first fan, ring by ring, each turn with its sum.
    pub rings: Vec<(Ring, Vec<f64>)>,
    /// Of the second fan, those that are allowed.
    pub fine: Vec<TurnValue>,
    pub best: TurnValue,
    /// Standard deviation of single turns off the fit that the best one is the peak of, percent.
    pub scatter_percent: f64,
    /// What looks straight up gets.
    pub flat: TurnValue,
    /// What the turn of the table of points gets, if it has one.
    pub given: Option<TurnValue>,
    /// What the point gets at best on an open plain.
    pub open_best: TurnValue,
}

impl PointSearch {
    /// What another turn loses beside the best, percent.
    pub fn loss_percent(&self, other: &TurnValue) -> f64 {
        100.0 * (1.0 - other.value / self.best.value)
    }

    /// All that was tried, each with its kind.
    fn rows(&self) -> impl Iterator<Item = (&'static str, TurnValue)> + '_ {
        let coarse = self.rings.iter().flat_map(|(ring, values)| {
            ring.turns().zip(values).map(|(turn, value)| ("coarse", TurnValue { turn, value: *value }))
        });
        let fine = self.fine.iter().map(|found| ("fine", *found));
        let named = [("flat", Some(self.flat)), ("given", self.given), ("best", Some(self.best))];
        coarse.chain(fine).chain(named.into_iter().filter_map(|(kind, found)| Some((kind, found?))))
    }
}

/// Writes every turn that was tried.
pub fn write_all(path: &Path, points: &[PointSearch], about: &Provenance) -> Result<()> {
    let names = ["point", "kind", "tilt_deg", "azimuth_deg", "total_kwh_m2", "loss_percent"];
    let rows = points.iter().flat_map(|search| {
        search.rows().map(move |(kind, found)| {
            let mut cells = vec![search.point.clone(), kind.to_owned()];
            cells.extend([found.turn.tilt_deg, found.turn.azimuth_deg].map(|degrees| format!("{degrees:.3}")));
            cells.extend([found.value, search.loss_percent(&found)].map(|value| format!("{value:.3}")));
            cells
        })
    });
    write_csv(path, &names, &[], rows, about)
}

/// Writes the best turn of each point, what others lose, and what is best on an open plain.
pub fn write_best(path: &Path, points: &[PointSearch], about: &Provenance) -> Result<()> {
    let names = [
        "point",
        "tilt_deg",
        "azimuth_deg",
        "total_kwh_m2",
        "scatter_percent",
        "flat_kwh_m2",
        "flat_loss_percent",
        "given_tilt_deg",
        "given_azimuth_deg",
        "given_kwh_m2",
        "given_loss_percent",
        "open_tilt_deg",
        "open_azimuth_deg",
        "open_kwh_m2",
    ];
    let row = |search: &PointSearch| {
        let turn =
            |found: &TurnValue| [found.turn.tilt_deg, found.turn.azimuth_deg].map(|degrees| format!("{degrees:.2}"));
        let sum = |found: &TurnValue| format!("{:.3}", found.value);
        let loss = |found: &TurnValue| format!("{:.3}", search.loss_percent(found));
        let mut cells = vec![search.point.clone()];
        cells.extend(turn(&search.best));
        cells.extend([
            sum(&search.best),
            format!("{:.3}", search.scatter_percent),
            sum(&search.flat),
            loss(&search.flat),
        ]);
        match &search.given {
            Some(given) => {
                cells.extend(turn(given));
                cells.extend([sum(given), loss(given)]);
            }
            None => cells.extend([const { String::new() }; 4]),
        }
        cells.extend(turn(&search.open_best));
        cells.push(sum(&search.open_best));
        cells
    };
    write_csv(path, &names, &[], points.iter().map(row), about)
}
