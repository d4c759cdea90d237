//! Solar cadastre of buildings and roof faces. In: a stream of a year's sums. Out: tables of
//! buildings and of roof faces.

use std::path::{Path, PathBuf};

use super::archives::Archives;
use super::stream::TileStream;
use crate::outputs::buildings::{Cadastre, Usable, building_rows, face_rows};
use crate::outputs::tables::format::table_help;
use crate::outputs::tables::format::{Format, files_of};
use heliotile_archives::transfer::Shown;
use heliotile_core::error::{Error, Result, check_ranges};
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::text::{Message, counted, message};
use heliotile_core::units::parse_amount;
use heliotile_files::writing::claim::same_place;
use heliotile_files::writing::guards::guard_output;
use heliotile_remote::naming::shown;
use heliotile_requests::{DefaultRequest, Request};

/// Hours that are more than a year's. The reader of the weather warns of fewer hours than a year
/// has.
const MORE_THAN_A_YEAR_H: f64 = 8800.0;

/// Request for a solar cadastre.
#[derive(Clone, Debug, Request, DefaultRequest)]
pub struct BuildingsRequest {
    /// Table of buildings; `-`: standard output.
    #[field(short = 'o', default = "-", help = output_help, output = Table)]
    pub output: PathBuf,
    /// Also write a table of roof faces; its ending chooses the format, as for --output.
    #[field(metavar = "FILE", output = Table)]
    pub faces: Option<PathBuf>,
    /// Least irradiation of a usable place on a roof, kWh/m2 over the weather file.
    #[field(name = "threshold", metavar = "KWH_M2", default = 900.0, hyphen, parse = parse_amount)]
    pub threshold_kwh_m2: f64,
    /// Least area of a usable region, m2: usable places that touch one another.
    #[field(name = "min_area", metavar = "M2", default = 10.0, hyphen, parse = parse_amount)]
    pub least_m2: f64,
}

/// Counts of what a cadastre holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildingsSummary {
    /// Number of buildings.
    pub buildings: u64,
    /// Number of roof faces.
    pub faces: u64,
}

impl BuildingsRequest {
    /// Refuses tables of unknown endings, and tables that would replace an input or each other.
    pub fn check(&self, inputs: &[&Path]) -> Result<()> {
        check_ranges(self)?;
        let outputs = || [Some(self.output.as_path()), self.faces.as_deref()].into_iter().flatten();
        for output in outputs() {
            check_table(output, inputs)?;
        }
        if self.faces.as_deref().is_some_and(|faces| same_place(faces, &self.output)) {
            let what = "is the table of faces and the table of buildings";
            return Err(Error::input(&self.output, None, what, "give the table of faces a name of its own"));
        }
        Ok(())
    }

    /// Writes the tables from the sums of a year; `place` is the path of the archive or of the
    /// atlas.
    pub fn write(&self, stream: &TileStream, archives: Archives, place: &Path) -> Result<BuildingsSummary> {
        let (series, observer) = (stream.series, stream.resources.observer);
        let hours: f64 =
            series.conditions.iter().filter_map(|condition| condition.stamp).map(|stamp| stamp.hours).sum();
        if hours > MORE_THAN_A_YEAR_H {
            observer.warn(message!(
                "{}: sums are over all {hours} hours, more than a year, and {{threshold}} {} is compared with them",
                series.source.display(),
                self.threshold_kwh_m2
            ));
        }
        let set = stream.receivers;
        let usable = Usable { threshold_kwh_m2: self.threshold_kwh_m2, least_m2: self.least_m2 };
        let mut cadastre = Cadastre::new(set.receivers(), usable, set.north(), place)?;
        let mut receivers = set.rows::<Shown>();
        stream.each(ComponentSet::new(&[Component::Total]), |tile| {
            for (row, shown) in receivers.by_ref().take(tile.ids.len()).enumerate() {
                let shown = shown?;
                let sum = tile.values.row(Component::Total, row).first().copied().unwrap_or_default();
                cadastre.add(&shown.receiver, shown.layers.patch, shown.views[0].into(), sum.into());
            }
            Ok(true)
        })?;
        if cadastre.vague() > 0 {
            observer.warn(format!(
                "{} of {}: the receivers have no patches, so each face counts as one region (receivers that cover a scene have patches)",
                counted(cadastre.vague() as u64, "roof face"),
                shown(place).display()
            ));
        }
        let about = stream.about(archives, place);
        if let Some(faces) = &self.faces {
            face_rows(&cadastre).write(faces, &about)?;
        }
        building_rows(&cadastre).write(&self.output, &about)?;
        Ok(BuildingsSummary { buildings: cadastre.names.len() as u64, faces: cadastre.faces.len() as u64 })
    }
}

/// Refuses a table of an unknown ending, and one that would replace an input.
pub fn check_table(output: &Path, inputs: &[&Path]) -> Result<()> {
    if output != Path::new("-") {
        files_of(output).iter().try_for_each(|file| guard_output(file, inputs))?;
    }
    Format::by_ending(output).map(drop)
}

/// Returns the help of the output.
fn output_help() -> Message {
    table_help("Table of buildings to write")
}
