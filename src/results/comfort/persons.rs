//! Persons: the six receivers of a point. In: receivers, tiles of their light. Out: the numbers of each point in each hour.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use super::climate::HourClimate;
use super::columns::{ComfortColumn, PLANES};
use super::request::SunOnPerson;
use crate::outputs::provenance::Provenance;
use crate::request::LightChoice;
use crate::series::Series;
use crate::stream::TileStream;
use glam::DVec3;
use heliotile_core::archive::format;
use heliotile_core::comfort::clear_sky::ClearSky;
use heliotile_core::comfort::index_curve::IndexCurve;
use heliotile_core::comfort::mean_radiant::{
    DirectSun, RadiantBody, RadiationField, mean_radiant_temperature_c, mean_radiant_temperature_of_cylinder_c,
};
use heliotile_core::comfort::surroundings::{SixPlanes, ViewShares};
use heliotile_core::error::{Error, Result};
use heliotile_core::layers::sky_bitmap::SkyBitmap;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::replay::reflectances::Changes;
use heliotile_core::replay::values::TileValues;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::weather::conditions::Condition;

/// Name of the receiver of a plane; the one that looks up has the name of the point.
pub(super) fn receiver_name(point: &str, plane: usize) -> String {
    match PLANES.get(plane).filter(|_| plane > 0) {
        Some(side) => format!("{point}/{side}"),
        None => point.to_owned(),
    }
}

/// The point of a receiver, and which of its planes it is.
fn point_of(receiver: &str) -> (&str, usize) {
    let named = receiver.rsplit_once('/').and_then(|(point, side)| {
        let plane = PLANES.iter().skip(1).position(|name| *name == side)?;
        Some((point, plane + 1))
    });
    named.unwrap_or((receiver, 0))
}

/// The points of an archive, in the order of the receivers that look up.
pub(super) struct PersonSet {
    names: Vec<String>,
    number_of: HashMap<String, usize>,
    /// `[point]`
    views: Vec<SixPlanes<ViewShares>>,
}

/// The light of a point, `[plane][hour]`.
#[derive(Default)]
pub(super) struct PersonLight {
    /// Place of the point in the set.
    pub number: usize,
    total: [Vec<f32>; 6],
    direct: [Vec<f32>; 6],
}

/// Light that comes tile by tile, until all planes of a point are there.
pub(super) struct PersonCollector<'s> {
    set: &'s PersonSet,
    begun: BTreeMap<usize, (usize, PersonLight)>,
    next: usize,
}

/// How radiation becomes a temperature.
#[derive(Clone, Copy)]
pub(super) struct Absorbing {
    pub body: RadiantBody,
    pub sun: SunOnPerson,
}

impl PersonSet {
    /// The points of the receivers of a stream, each of which must have all six planes; which receivers look up. `place` is that of the archive or
    /// of the atlas.
    pub(super) fn of(stream: &TileStream, place: &Path) -> Result<(Self, Vec<bool>)> {
        let under_leaves = under_leaves(stream)?;
        let mut set = PersonSet { names: Vec::new(), number_of: HashMap::new(), views: Vec::new() };
        let mut found: HashMap<String, [Option<ViewShares>; 6]> = HashMap::new();
        let mut looks_up = Vec::new();
        let mut clear: Option<ClearSky> = None;
        for row in stream.receivers.rows::<SkyBitmap>() {
            let row = row?;
            let clear = match &mut clear {
                Some(clear) if clear.side() == row.layers.side() => clear,
                other => other.insert(ClearSky::of(row.layers.side())),
            };
            let (point, plane) = point_of(&row.receiver.id);
            let [sky, _, obstruction] = row.views.map(f64::from);
            if let Some(of_plane) = found.entry(point.to_owned()).or_default().get_mut(plane) {
                // Leaves before the sky are as warm as the air and black, as far as light does not pass them.
                let through = under_leaves.get(&row.receiver.id).map_or(1.0, |open| (open / sky).min(1.0));
                let missed = through * clear.missed(row.receiver.normal, &row.layers);
                *of_plane = Some(ViewShares { sky, obstruction, missed });
            }
            looks_up.push(plane == 0);
            if plane == 0 {
                set.number_of.insert(point.to_owned(), set.names.len());
                set.names.push(point.to_owned());
            }
        }
        for name in &set.names {
            let planes = found.remove(name).unwrap_or_default();
            let lacks = planes.iter().zip(0..).find(|(view, _)| view.is_none());
            let (Some(views), None) = (all_of(planes), lacks) else {
                let lacking = receiver_name(name, lacks.map_or(0, |(_, plane)| plane));
                return Err(no_persons(
                    place,
                    format!("receiver `{name}` is no point with six planes: `{lacking}` is not there"),
                ));
            };
            set.views.push(views);
        }
        if let Some(point) = found.into_keys().min() {
            return Err(no_persons(place, format!("point `{point}` has no receiver `{point}` that looks up")));
        }
        Ok((set, looks_up))
    }

    /// Number of points.
    pub(super) fn len(&self) -> usize {
        self.names.len()
    }

    /// Name of a point.
    pub(super) fn name(&self, number: usize) -> &str {
        self.names.get(number).map_or("", String::as_str)
    }
}

/// Shares of hemispheres, weighted by the cosine, that are sky behind leaves and screens, as light passes these; empty where there are none.
fn under_leaves(stream: &TileStream) -> Result<HashMap<String, f64>> {
    const OPEN_W_M2: f64 = 100.0;
    let mut found = HashMap::new();
    if stream.receivers.parts().iter().all(|part| part.archive.entries_of(format::CANOPY).is_empty()) {
        return Ok(found);
    }
    let sky = Condition::new("uniform".into(), &[], DVec3::Z, 0.0, OPEN_W_M2);
    let series = Series::of_conditions(vec![sky], Changes::default(), Provenance::default());
    let light = LightChoice { sky: SkyModel::Uniform, ..LightChoice::default() };
    let stream = TileStream { series: &series, light: &light, ..*stream };
    stream.each(ComponentSet::of(&[Component::SkyDirect]), |tile| {
        found.extend(tile.ids.iter().enumerate().map(|(row, id)| {
            let light: f64 = tile.values.row(Component::SkyDirect, row).iter().copied().map(f64::from).sum();
            (id.clone(), light / OPEN_W_M2)
        }));
        Ok(true)
    })?;
    Ok(found)
}

fn no_persons(place: &Path, what: String) -> Error {
    let hint = "name the scene in place of the archive, or give receivers of the planes up, down, north, east, south and west: \
                P, P/down, P/north and so on";
    Error::input(place, None, what, hint)
}

/// All six values, in the order of [`PLANES`].
fn all_of(planes: [Option<ViewShares>; 6]) -> Option<SixPlanes<ViewShares>> {
    let [up, down, north, east, south, west] = planes;
    Some(SixPlanes { up: up?, down: down?, sides: [north?, east?, south?, west?] })
}

impl<'s> PersonCollector<'s> {
    pub(super) fn new(set: &'s PersonSet) -> Self {
        PersonCollector { set, begun: BTreeMap::new(), next: 0 }
    }

    /// Takes the receivers of a tile.
    pub(super) fn add(&mut self, ids: &[String], values: &TileValues) {
        for (row, id) in ids.iter().enumerate() {
            let (point, plane) = point_of(id);
            let Some(number) = self.set.number_of.get(point).copied() else { continue };
            let (planes, light) = self.begun.entry(number).or_default();
            *planes += 1;
            light.number = number;
            let kinds = [(&mut light.total, Component::Total), (&mut light.direct, Component::SunDirect)];
            for (to, component) in kinds {
                if let Some(to) = to.get_mut(plane) {
                    *to = values.row(component, row).to_vec();
                }
            }
        }
    }

    /// Points whose planes are all there, in their order, until one is not.
    pub(super) fn complete(&mut self) -> Vec<PersonLight> {
        let mut ready = Vec::new();
        while self
            .begun
            .first_key_value()
            .is_some_and(|(number, (planes, _))| *number == self.next && *planes == PLANES.len())
        {
            ready.extend(self.begun.pop_first().map(|(_, (_, light))| light));
            self.next += 1;
        }
        ready
    }
}

impl PersonLight {
    /// The numbers of all hours, `[number][hour]`, in the order of `asked`.
    pub(super) fn numbers(
        &self,
        set: &PersonSet,
        climates: &[HourClimate],
        asked: &[ComfortColumn],
        absorbing: Absorbing,
    ) -> Vec<Vec<f32>> {
        let Some(views) = set.views.get(self.number) else { return Vec::new() };
        let count = asked.iter().map(|column| width(*column)).sum();
        let mut numbers = vec![Vec::with_capacity(climates.len()); count];
        for (hour, climate) in climates.iter().enumerate() {
            let shortwave = at_hour(&self.total, hour);
            let longwave = climate.surroundings.longwave(views, &shortwave);
            let field = RadiationField { shortwave: shortwave.into(), longwave: longwave.into() };
            let mean_radiant_c = match absorbing.sun {
                SunOnPerson::Box => mean_radiant_temperature_c(&field, &absorbing.body),
                SunOnPerson::Cylinder => {
                    let direct = at_hour(&self.direct, hour);
                    let diffuse = shortwave.less(&direct).into();
                    let field = RadiationField { shortwave: diffuse, ..field };
                    mean_radiant_temperature_of_cylinder_c(&field, &sun_of(&direct), &absorbing.body)
                }
            };
            let index = |curve: &Option<IndexCurve>| curve.as_ref()?.at(mean_radiant_c?);
            let mut to = numbers.iter_mut();
            let mut push = |value: Option<f64>| {
                if let Some(to) = to.next() {
                    to.push(value.map_or(f32::NAN, |value| value as f32));
                }
            };
            for column in asked {
                match column {
                    ComfortColumn::Air => push(Some(climate.air_c)),
                    ComfortColumn::Wind => push(Some(climate.wind_m_s)),
                    ComfortColumn::MeanRadiant => push(mean_radiant_c),
                    ComfortColumn::Utci => push(index(&climate.utci)),
                    ComfortColumn::Pet => push(index(&climate.pet)),
                    ComfortColumn::Shortwave => shortwave.each(|value| push(Some(value))),
                    ComfortColumn::Longwave => longwave.each(|value| push(Some(value))),
                }
            }
        }
        numbers
    }
}

/// How many numbers a column is.
fn width(column: ComfortColumn) -> usize {
    match column {
        ComfortColumn::Shortwave | ComfortColumn::Longwave => PLANES.len(),
        _ => 1,
    }
}

fn at_hour(planes: &[Vec<f32>; 6], hour: usize) -> SixPlanes<f64> {
    let [up, down, north, east, south, west] =
        planes.each_ref().map(|plane| plane.get(hour).copied().map_or(0.0, f64::from));
    SixPlanes { up, down, sides: [north, east, south, west] }
}

/// The sun whose direct light these planes get: opposite planes see it from one side each, so that their differences are its vector.
fn sun_of(direct: &SixPlanes<f64>) -> DirectSun {
    let [north, east, south, west] = direct.sides;
    let (up, horizontal) = (direct.up - direct.down, (north - south).hypot(east - west));
    DirectSun { beam_normal_w_m2: up.hypot(horizontal), altitude_deg: up.atan2(horizontal).to_degrees() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names of planes go there and back; a receiver with a slash of its own is a point.
    #[test]
    fn names() {
        for plane in 0..6 {
            assert_eq!(point_of(&receiver_name("a/b", plane)), ("a/b", plane));
        }
        assert_eq!(point_of("roof/7"), ("roof/7", 0));
    }

    /// A beam of 800 W/m2 from azimuth 120 at 35 degrees is found from what it gives on the six planes.
    #[test]
    fn suns() {
        let (azimuth, altitude) = (120.0_f64.to_radians(), 35.0_f64.to_radians());
        let (east, north) = (azimuth.sin() * altitude.cos(), azimuth.cos() * altitude.cos());
        let on = |cos: f64| 800.0 * cos.max(0.0);
        let sides = [on(north), on(east), on(-north), on(-east)];
        let sun = sun_of(&SixPlanes { up: on(altitude.sin()), down: 0.0, sides });
        assert!((sun.beam_normal_w_m2 - 800.0).abs() < 1e-9 && (sun.altitude_deg - 35.0).abs() < 1e-9, "{sun:?}");
    }
}
