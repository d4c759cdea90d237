//! Shade of an array over the sky. In: the share of the sun's beam that arrives, by azimuth and
//! altitude, and that of the sky's light. Out: a table, and the layouts of other programs.

use std::path::Path;

use serde_json::json;

use crate::outputs::provenance::Provenance;
use crate::outputs::sink::write_texts;
use crate::outputs::tables::column::{Column, Digits};
use crate::outputs::tables::records::Records;
use crate::outputs::tables::table::Cell;
use heliotile_core::error::Result;

/// Step of azimuths and of altitudes, degrees: four discs of the sun, its way in eight minutes.
const STEP_DEG: usize = 2;

/// Altitudes of the map, degrees: middles of rings from the horizon to the zenith.
pub fn altitudes_deg() -> impl Iterator<Item = f64> {
    (0..90 / STEP_DEG).map(|i| (i as f64 + 0.5) * STEP_DEG as f64)
}

/// Azimuths of the map, degrees clockwise from true north.
pub fn azimuths_deg() -> impl Iterator<Item = f64> {
    (0..360).step_by(STEP_DEG).map(|azimuth| azimuth as f64)
}

/// Files in the folder of shade: the table of the map, and the layouts of other programs.
pub const TABLE: &str = "beam.csv";
pub const LAYOUTS: [&str; 3] = ["sam.json", "userhorizon.txt", "horizon.txt"];

/// Number of heights in the list of a horizon: every 7.5 degrees, as PVGIS's own.
const LISTED: usize = 48;

/// Share of the beam at which the horizon of an array is drawn: half of it is in the sun.
const HALF: f64 = 0.5;

/// Shade of an array.
#[derive(Clone, Debug, PartialEq)]
pub struct ShadeMap {
    /// Share of the beam on the modules that arrives, `[azimuth][altitude]`; `None` where the sun
    /// is behind all of them.
    pub beam: Vec<Vec<Option<f64>>>,
    /// Share of the light of a uniform sky on the modules that arrives.
    pub diffuse: f64,
}

impl ShadeMap {
    /// Writes the files into an existing folder.
    pub fn write(&self, folder: &Path, about: &Provenance) -> Result<()> {
        let angles = ["azimuth_deg", "altitude_deg"].map(|name| Column::number_as(name, Digits::Fewest));
        let columns = angles.into_iter().chain([Column::number("beam", 4).with_unit("1")]).collect();
        let rows = azimuths_deg().zip(&self.beam).flat_map(|(azimuth, column)| {
            let row =
                move |(altitude, share): (f64, &Option<f64>)| vec![azimuth.into(), altitude.into(), (*share).into()];
            altitudes_deg().zip(column).map(row)
        });
        let rows: Vec<Vec<Cell>> = rows.collect();
        Records { columns, rows }.write(&folder.join(TABLE), about)?;
        let [sam, list, pairs] = LAYOUTS;
        write_texts(folder, &[(sam, self.sam()), (list, self.list()), (pairs, self.pairs())])
    }

    /// Returns the group `Shading` of SAM's photovoltaic models, as `Shading.assign` of PySAM takes
    /// it: losses in percent, a first row of azimuths from north and a first column of altitudes
    /// (help of SAM, "Shading and Layout": azimuth by altitude table; `shading_azal` of
    /// nrel-pysam.readthedocs.io/en/main/modules/Pvwattsv8.html).
    fn sam(&self) -> String {
        let percent = |share: Option<f64>| share.map_or(0.0, |share| (1e4 * (1.0 - share)).round() / 100.0);
        // The circle is closed, and the rings reach from the horizon to the zenith.
        let around: Vec<(f64, &Vec<Option<f64>>)> =
            azimuths_deg().chain([360.0]).zip(self.beam.iter().chain(self.beam.first())).collect();
        let mut table =
            vec![std::iter::once(0.0).chain(around.iter().map(|(azimuth, _)| *azimuth)).collect::<Vec<_>>()];
        let count = altitudes_deg().count();
        let rings = (0..count).zip(altitudes_deg());
        for (ring, altitude) in std::iter::once((0, 0.0)).chain(rings).chain([(count - 1, 90.0)]) {
            let losses = around.iter().map(|(_, column)| percent(column.get(ring).copied().flatten()));
            table.push(std::iter::once(altitude).chain(losses).collect());
        }
        let all = json!({
            "shading_en_azal": 1,
            "shading_azal": table,
            "shading_en_diff": 1,
            "shading_diff": percent(Some(self.diffuse)),
        });
        format!("{all}\n")
    }

    /// Returns the altitude in a direction up to which less than half of the beam arrives, degrees.
    /// Surfaces that hang above free sky do not count.
    fn horizon_deg(&self, azimuth_deg: f64) -> f64 {
        let place = azimuth_deg.rem_euclid(360.0) / STEP_DEG as f64;
        let of = |column: usize| self.crossing_deg(column % self.beam.len().max(1));
        let (below, part) = (place.floor() as usize, place.fract());
        of(below) * (1.0 - part) + of(below + 1) * part
    }

    fn crossing_deg(&self, column: usize) -> f64 {
        let (mut last, mut is_edge): (Option<(f64, f64)>, bool) = (None, false);
        for (altitude, share) in altitudes_deg().zip(self.beam.get(column).into_iter().flatten()) {
            // Where the sun is behind the modules, nothing is known and nothing matters.
            let Some(share) = *share else {
                is_edge = true;
                continue;
            };
            // Next to it, modules that differ a little hide the sun from each other's plane.
            if std::mem::take(&mut is_edge) && share < HALF {
                continue;
            }
            if share >= HALF {
                return match last {
                    Some((below, less)) => below + (altitude - below) * (HALF - less) / (share - less),
                    None => 0.0,
                };
            }
            last = Some((altitude, share));
        }
        last.map_or(0.0, |_| 90.0)
    }

    /// Returns heights of the horizon at equal distances, clockwise from north, with commas between
    /// them: `userhorizon` of PVGIS ("starting at north and moving clockwise", PVGIS user manual,
    /// API, joint-research-centre.ec.europa.eu), which Forecast.Solar takes as `horizon`
    /// (doc.forecast.solar/horizon).
    fn list(&self) -> String {
        let step = 360.0 / LISTED as f64;
        let heights: Vec<String> = (0..LISTED).map(|i| format!("{:.1}", self.horizon_deg(step * i as f64))).collect();
        heights.join(",") + "\n"
    }

    /// Returns azimuths from 0, north, to 360 and heights, separated by tabs: `horizon.txt` of Home
    /// Assistant's Open-Meteo Solar Forecast (README of rany2/ha-open-meteo-solar-forecast).
    fn pairs(&self) -> String {
        let azimuths = azimuths_deg().chain([360.0]);
        azimuths.map(|azimuth| format!("{azimuth}\t{:.2}\n", self.horizon_deg(azimuth))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Below 30 degrees in the east all is shaded, above nothing. The sun is behind the modules in
    /// the north, and up to 20 degrees in the north-west, where it grazes them next. The horizon is
    /// 30 degrees at 90, and 0 elsewhere, in all layouts.
    #[test]
    fn layouts_show_the_same_wall() {
        let share = |azimuth: f64, altitude: f64| match azimuth {
            0.0..10.0 => None,
            80.0..=100.0 if altitude < 30.0 => Some(0.0),
            340.0.. if altitude < 20.0 => None,
            340.0.. if altitude < 22.0 => Some(0.3),
            _ => Some(1.0),
        };
        let column = |azimuth| altitudes_deg().map(|altitude| share(azimuth, altitude)).collect();
        let map = ShadeMap { beam: azimuths_deg().map(column).collect(), diffuse: 0.9 };
        let list: Vec<f64> = map.list().trim().split(',').map(|height| height.parse().expect("a height")).collect();
        assert_eq!((list.len(), list[0], list[12], list[24], list[36]), (48, 0.0, 30.0, 0.0, 0.0));
        let pairs = map.pairs();
        assert_eq!((pairs.lines().count(), pairs.lines().nth(45)), (181, Some("90\t30.00")));
        assert!(pairs.starts_with("0\t0.00\n") && pairs.ends_with("360\t0.00\n"), "{pairs}");
        let sam: serde_json::Value = serde_json::from_str(&map.sam()).expect("JSON");
        let table = sam["shading_azal"].as_array().expect("a table");
        assert_eq!((table.len(), table[0][46].as_f64(), table[16][0].as_f64()), (48, Some(90.0), Some(29.0)));
        assert_eq!((table[16][46].as_f64(), table[17][46].as_f64()), (Some(100.0), Some(0.0)));
        assert_eq!(sam["shading_diff"].as_f64(), Some(10.0));
    }
}
