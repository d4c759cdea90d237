//! From tiles of light to files. In: a request, a stream of the receivers of points. Out: tables,
//! maps and pictures, and the counts of points and hours.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::beyond::HoursBeyond;
use super::climate::climates;
use super::columns::ComfortColumns;
use super::persons::{PersonCollector, PersonSet, PointLight};
use super::request::{ComfortRequest, WindChoice};
use crate::archives::Archives;
use crate::files::{OutputRequest, RowFiles, RowsAbout, name_of};
use crate::outputs::periods::Every;
use crate::outputs::provenance::Provenance;
use crate::outputs::quantities::PlaceValues;
use crate::outputs::row_maker::RowMaker;
use crate::outputs::tables::layout::{BinKind, By, Layout};
use crate::series::Series;
use crate::stream::TileStream;
use heliotile_comfort::index_curve::IndexCurve;
use heliotile_comfort::people::climate::HourClimate;
use heliotile_comfort::people::columns::ComfortColumn;
use heliotile_comfort::people::light::PersonNumbers;
use heliotile_comfort::people::model::ComfortModel;
use heliotile_core::error::{Error, Result};
use heliotile_core::named;
use heliotile_core::opened::OpenSite;
use heliotile_core::site::material::{Class, Material};
use heliotile_core::text::counted;

/// Number of points that are computed together.
const POINTS_AT_ONCE: usize = 64;

/// Counts of points and hours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ComfortDone {
    /// Number of points.
    pub points: u64,
    /// Number of hours of the weather that count.
    pub hours: u64,
}

/// Data that all points share.
struct PointPass<'a> {
    set: &'a PersonSet,
    climates: &'a [HourClimate],
    columns: &'a ComfortColumns,
    asked: &'a [ComfortColumn],
    model: &'a ComfortModel,
    rows: &'a Series,
    is_hourly: bool,
    place: &'a Path,
}

impl ComfortRequest {
    /// Writes the files; `place` is the path of the archive or of the atlas.
    pub fn write(
        &self,
        files: &OutputRequest,
        stream: &TileStream,
        archives: Archives,
        place: &Path,
    ) -> Result<ComfortDone> {
        let every = self.replay.every;
        if files.by != By::Receiver {
            let hint = "leave it out: a point belongs to no surface";
            return Err(Error::argument("by", "comfort is calculated at points", hint));
        }
        let resources = &stream.resources;
        let (set, looks_up) = PersonSet::new(stream, &self.choice, place)?;
        let receivers = stream.receivers.some(&looks_up);
        let columns = ComfortColumns::new(&self.choice.columns, every, &self.choice.above_c);
        let asked: Vec<ComfortColumn> = columns.asked().collect();
        let site = OpenSite::open(archives.first())?;
        let conditions = &stream.series.conditions;
        let model = self.model(site.materials());
        let climates = climates(self, conditions, &model, &asked, resources)?;
        self.tell_gaps(&climates, stream);
        let series = stream.series.by(every);
        let labels = if every == Every::Hour { BinKind::Times } else { BinKind::Dates };
        let layout = Layout::of_quantities(labels, By::Receiver, columns.quantities());
        let rows = RowMaker::new(layout, series.labels.clone(), Some(every));
        let about = stream.with_series(&series).about(archives, place);
        let about = self.about(about, &model, site.materials());
        let called = format!("{} under {}", name_of(place), series.called);
        let told = RowsAbout { called, about, place, scene: None };
        let maps = files.maps(files.plots.iter().map(PathBuf::as_path))?;
        let mut to = RowFiles::new(&rows, None);
        if files.wants_table()? {
            to = to.with_table(&files.output, &receivers, &told.about);
        }
        let mut to = to.with_maps(&maps, &receivers, &told, resources)?;
        to.start()?;
        let (climates, asked) = (climates.as_slice(), asked.as_slice());
        let is_hourly = every == Every::Hour;
        let pass =
            PointPass { set: &set, climates, columns: &columns, asked, model: &model, rows: &series, is_hourly, place };
        let mut beyond = HoursBeyond::default();
        let mut collector = PersonCollector::new(&set);
        let mut waiting: Vec<PointLight> = Vec::new();
        // The planes of a point may lie in several tiles, so points wait until all six are there.
        stream.each(self.components(), |tile| {
            collector.add(tile.ids, tile.values);
            waiting.extend(collector.complete());
            if waiting.len() >= POINTS_AT_ONCE {
                pass.write(&std::mem::take(&mut waiting), &mut to, &mut beyond)?;
            }
            Ok(!to.is_closed())
        })?;
        pass.write(&waiting, &mut to, &mut beyond)?;
        to.finish(resources.observer)?;
        let told = beyond.warnings(&self.choice.above_c, is_hourly);
        told.iter().for_each(|text| resources.observer.warn(text));
        Ok(ComfortDone { points: set.len() as u64, hours: climates.len() as u64 })
    }

    /// Adds every assumption to the provenance that the files state.
    fn about(&self, about: Provenance, model: &ComfortModel, materials: &[Material]) -> Provenance {
        let choice = &self.choice;
        let emissivity = |class| choice.said_of(class, materials, |mean| mean.emissivity);
        let absorptances = [
            ("absorptance_ground", Class::Ground, &model.ground),
            ("absorptance_obstruction", Class::Obstruction, &model.obstruction),
        ];
        let about = about
            .with("posture", named::name_of(&choice.posture))
            .with("sun_on_person", named::name_of(&choice.sun_on))
            .with("surface_temperatures", named::name_of(&choice.surfaces))
            .with("film_w_m2_k", model.film_w_m2_k)
            .with("emissivity_ground", emissivity(Class::Ground))
            .with("emissivity_obstruction", emissivity(Class::Obstruction))
            .with("person_absorptivity_shortwave", model.body.shortwave_absorptivity)
            .with("person_emissivity", model.body.longwave_emissivity)
            .with("pet_clothing_clo", model.person.clothing_clo)
            .with("pet_activity_met", format!("{:.2}", model.person.activity_met));
        // Surfaces of given temperatures have no absorptance.
        let absorbing = absorptances.into_iter().filter(|(_, _, surfaces)| surfaces.sol_air.is_some());
        let about = absorbing.fold(about, |about, (name, class, _)| {
            about.with(name, choice.said_of(class, materials, |mean| mean.absorptance))
        });
        match &choice.wind {
            WindChoice::Factor(factor) => about.with("wind_factor", factor),
            WindChoice::File(file) => about.with("wind", name_of(file)),
        }
    }

    /// Notes how many hours have no value of an index even if the mean radiant temperature equals
    /// that of the air.
    fn tell_gaps(&self, climates: &[HourClimate], stream: &TileStream) {
        type OfHour = fn(&HourClimate) -> Option<&IndexCurve>;
        let indices: [(&str, OfHour); 2] = [("UTCI", |hour| hour.utci.as_ref()), ("PET", |hour| hour.pet.as_ref())];
        for (index, of_hour) in indices {
            let is_gap = |hour: &&HourClimate| of_hour(hour).is_some_and(|curve| curve.at(hour.air_c).is_none());
            let without = climates.iter().filter(is_gap).count() as u64;
            if without > 0 {
                stream.resources.observer.note(format!(
                    "the {index} has no value in {} of {}: air, wind or humidity are outside of its range",
                    counted(without, "hour"),
                    climates.len()
                ));
            }
        }
    }
}

impl PointPass<'_> {
    /// Writes the rows of some points, and counts their hours that are too hot for an index.
    fn write(&self, lights: &[PointLight], to: &mut RowFiles, beyond: &mut HoursBeyond) -> Result<()> {
        if lights.is_empty() {
            return Ok(());
        }
        let hours: Vec<f64> = self.climates.iter().map(|climate| climate.hours).collect();
        let of_point = |point: &PointLight| {
            let views = self.set.views(point.number).ok_or_else(|| {
                let what = format!("the view shares of point `{}` are missing", self.set.name(point.number));
                Error::defect(self.place, "receivers", "views", what)
            })?;
            let mut numbers = point.light.numbers(&views, self.climates, self.asked, self.model);
            if !self.is_hourly {
                numbers.bound();
            }
            let rows = self.columns.rows(&numbers.values, &self.rows.bins, &hours);
            numbers.values.clear();
            Ok((rows, numbers))
        };
        let found: Vec<(Vec<Vec<f32>>, PersonNumbers)> = lights.par_iter().map(of_point).collect::<Result<_>>()?;
        lights.iter().zip(&found).for_each(|(light, (_, numbers))| beyond.add(light.number, numbers, &hours));
        let rows: Vec<Vec<Vec<f32>>> = found.into_iter().map(|(rows, _)| rows).collect();
        let array = |number: usize| rows.iter().filter_map(|row| row.get(number)).flatten().copied().collect();
        let arrays: Vec<Vec<f32>> = (0..self.columns.count()).map(array).collect();
        let names: Vec<String> = lights.iter().map(|light| self.set.name(light.number).to_owned()).collect();
        to.write(&names, &PlaceValues::of_arrays(names.len(), self.rows.labels.len(), &arrays), &[])
    }
}
