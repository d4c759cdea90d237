//! The best places of modules on roofs and facades. In: a stream of a year's sums. Out: a table of
//! points that a study of modules reads.

use std::path::{Path, PathBuf};

use super::archives::Archives;
use super::buildings::check_table;
use super::stream::TileStream;
use crate::outputs::buildings::{Envelope, building_of, face_of};
use crate::outputs::pv::places::{ModulePlace, PlaceCandidate, best_places};
use crate::outputs::tables::column::Column;
use crate::outputs::tables::format::table_help;
use crate::outputs::tables::records::Records;
use crate::outputs::tables::table::Cell;
use heliotile_archives::transfer::Shown;
use heliotile_core::error::{Error, Result, check_ranges};
use heliotile_core::named::NamedValues;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::site::north::North;
use heliotile_core::text::{Message, counted, message};
use heliotile_core::units::parse_amount;
use heliotile_core::units::tilt_and_azimuth;
use heliotile_requests::{DefaultRequest, Request};

/// Returns the columns of the table.
fn columns() -> Vec<Column> {
    let numbers = ["x", "y", "z", "tilt_deg", "azimuth_deg", "total_kwh_m2", "light_kwh", "sky_view"];
    let numbers = numbers.map(|name| Column::number(name, 3));
    let names = ["receiver", "surface", "building"].map(Column::text);
    std::iter::once(Column::text("point")).chain(numbers).chain(names).collect()
}

/// Surfaces that modules go on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlaceOn {
    /// Surfaces that face up.
    #[default]
    Roofs,
    /// Surfaces that face sideways.
    Facades,
    /// Roofs and facades.
    Both,
}

/// Request for the best places of modules.
#[derive(Clone, Debug, Request, DefaultRequest)]
pub struct PlacesRequest {
    /// Table of places; `-`: standard output.
    #[field(short = 'o', default = "-", help = output_help, output = Table)]
    pub output: PathBuf,
    /// Number of places, the best first.
    #[field(metavar = "N", default = 10, range = 1..=1_000_000)]
    pub best: usize,
    /// Width x height of a module, metres: the width is horizontal, the height goes up the surface.
    #[field(metavar = "WxH", default = "1.1x1.8", parse = parse_module)]
    pub module_m: [f64; 2],
    /// Surfaces to search for places.
    #[field(default = "roofs")]
    pub on: PlaceOn,
    /// Height of modules above their surface, metres.
    #[field(metavar = "M", default = 0.1, hyphen, parse = parse_amount)]
    pub clearance_m: f64,
}

/// Counts of what a search found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlacesSummary {
    /// Number of places in the table.
    pub places: u64,
    /// Number of receivers that the places were chosen from.
    pub receivers: u64,
}

impl PlacesRequest {
    /// Refuses a table of an unknown ending, and one that would replace an input.
    pub fn check(&self, inputs: &[&Path]) -> Result<()> {
        check_ranges(self)?;
        check_table(&self.output, inputs)
    }

    /// Writes the table from the sums of a year; `place` is the path of the archive or of the
    /// atlas.
    pub fn write(&self, stream: &TileStream, archives: Archives, place: &Path) -> Result<PlacesSummary> {
        let candidates = self.candidates(stream)?;
        if candidates.is_empty() {
            let what = "has no receiver with a patch on the chosen surfaces";
            let hint = "build it with receivers that cover a scene, or choose other surfaces with {on}";
            return Err(Error::input(place, None, what, hint));
        }
        let best = best_places(&candidates, self.module_m, self.best)?;
        if best.len() < self.best {
            stream.resources.observer.warn(message!(
                "{} of {} x {} m found instead of {}: no more fit",
                counted(best.len() as u64, "place"),
                self.module_m[0],
                self.module_m[1],
                self.best
            ));
        }
        let north = stream.receivers.north();
        let row = |(number, place): (u64, &ModulePlace)| self.row(number, place, &candidates[place.candidate], north);
        let rows = (1..).zip(&best).map(row).collect();
        let about = stream.about(archives, place);
        Records { columns: columns(), rows }.write(&self.output, &about)?;
        Ok(PlacesSummary { places: best.len() as u64, receivers: candidates.len() as u64 })
    }

    /// Returns the receivers with patches on the requested surfaces, and their sums.
    fn candidates(&self, stream: &TileStream) -> Result<Vec<PlaceCandidate>> {
        let mut receivers = stream.receivers.rows::<Shown>();
        let mut candidates = Vec::new();
        stream.each(ComponentSet::new(&[Component::Total]), |tile| {
            for (row, shown) in receivers.by_ref().take(tile.ids.len()).enumerate() {
                let shown = shown?;
                let receiver = &shown.receiver;
                let is_asked = match Envelope::new(receiver) {
                    Envelope::Roof => self.on != PlaceOn::Facades,
                    Envelope::Facade => self.on != PlaceOn::Roofs,
                    Envelope::Neither => false,
                };
                if is_asked && !shown.layers.patch.is_empty() {
                    let sum = tile.values.row(Component::Total, row).first().copied().unwrap_or_default();
                    candidates.push(PlaceCandidate {
                        position: receiver.position,
                        normal: receiver.normal,
                        kwh_m2: sum.into(),
                        sky_view: shown.views[0].into(),
                        receiver: receiver.id.clone(),
                        face: face_of(receiver).to_owned(),
                        building: building_of(receiver).unwrap_or_default().to_owned(),
                        patch: shown.layers.patch,
                    });
                }
            }
            Ok(true)
        })?;
        Ok(candidates)
    }

    /// Returns the row of a place, whose middle lies above a receiver.
    fn row(&self, number: u64, place: &ModulePlace, receiver: &PlaceCandidate, north: North) -> Vec<Cell> {
        let [width, height] = self.module_m;
        let at = place.middle + place.normal * self.clearance_m;
        let (tilt, azimuth) = tilt_and_azimuth(north.to_true(place.normal));
        let sums = [place.kwh_m2, place.kwh_m2 * width * height, place.sky_view];
        let numbers = [at.x, at.y, at.z, tilt, azimuth].into_iter().chain(sums);
        let texts = [&receiver.receiver, &receiver.face, &receiver.building];
        [Cell::Text(format!("best{number}"))]
            .into_iter()
            .chain(numbers.map(Cell::from))
            .chain(texts.map(Cell::from))
            .collect()
    }
}

impl NamedValues for PlaceOn {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("roofs", "Surfaces that face up", PlaceOn::Roofs),
        ("facades", "Surfaces that face to the side", PlaceOn::Facades),
        ("both", "Roofs and facades", PlaceOn::Both),
    ];
}

heliotile_core::serde_by_name!(PlaceOn);

heliotile_core::parse_by_name!(PlaceOn);

/// Returns the help of the output.
fn output_help() -> Message {
    table_help("Table of places to write; as CSV, {points} of `pv` reads it")
}

/// Reads the width and height of a module in metres, `1.1x1.8`.
fn parse_module(text: &str) -> std::result::Result<[f64; 2], String> {
    let metres = |side: &str| side.trim().parse().ok().filter(|metres| (0.01..=100.0).contains(metres));
    let sides = text.split_once(['x', 'X']).and_then(|(width, height)| Some([metres(width)?, metres(height)?]));
    sides.ok_or_else(|| "give width and height in metres, 0.01 to 100, as in 1.1x1.8".into())
}
