//! Persons: the six receivers of a point. In: receivers, tiles of their light. Out: points, the
//! view shares of their planes, and the light of each.

use crate::own_skies::SkyChoice;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use super::request::ComfortChoice;
use crate::outputs::provenance::Provenance;
use crate::request::LightRequest;
use crate::series::Series;
use crate::stream::TileStream;
use heliotile_archives::transfer::Layers;
use heliotile_comfort::people::columns::PLANES;
use heliotile_comfort::people::light::PersonLight;
use heliotile_comfort::people::points::{PersonPoints, all_of, point_of};
use heliotile_comfort::people::surfaces::seen_surfaces;
use heliotile_comfort::people::views::{PlaneViews, SeenByPlane, open_share, uniform_sky};
use heliotile_comfort::surroundings::{SeenSurfaces, SixPlanes, ViewShares};
use heliotile_core::archive::format;
use heliotile_core::archive::format::BlockKind;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::layers::sky_bitmap::SkyBitmap;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::replay::reflectances::Changes;
use heliotile_core::replay::values::TileValues;
use heliotile_core::sky::model::SkyModel;

/// Points of an archive, in the order of their receivers that face up.
pub(super) struct PersonSet {
    points: PersonPoints,
    /// `[receiver]`: view shares of the plane.
    views: Vec<ViewShares>,
}

/// Surfaces that a plane sees, by material.
struct OfPlane(SeenSurfaces);

impl Layers for OfPlane {
    /// Returns no blocks to read ahead: hits are read only if materials differ.
    fn kinds() -> Vec<BlockKind> {
        Vec::new()
    }

    fn of_tile(site: &OpenSite, tile: u32, receivers: usize) -> Result<Vec<Self>> {
        Ok(seen_surfaces(site, tile, receivers)?.into_iter().map(OfPlane).collect())
    }
}

/// Light on the six planes of a point.
#[derive(Default)]
pub(super) struct PointLight {
    /// Index of the point in the set.
    pub number: usize,
    pub light: PersonLight,
}

/// Collects light tile by tile, until all planes of a point are there.
pub(super) struct PersonCollector<'s> {
    set: &'s PersonSet,
    begun: BTreeMap<usize, (usize, PointLight)>,
    next: usize,
}

impl PersonSet {
    /// Returns the points of a stream's receivers, and which receivers face up. Each point must
    /// have all six planes. `choice` may state properties of surfaces; `place` is the path of the
    /// archive or of the atlas.
    pub(super) fn new(stream: &TileStream, choice: &ComfortChoice, place: &Path) -> Result<(Self, Vec<bool>)> {
        let under_leaves = under_leaves(stream)?;
        let (mut views, mut looks_up, mut failed) = (Vec::new(), Vec::new(), None);
        let mut found = PlaneViews::default();
        let rows = stream.receivers.rows::<(SkyBitmap, OfPlane)>().map_while(|row| {
            let row = row.map_err(|error| failed = Some(error)).ok()?;
            let (receiver, (sky, OfPlane(surfaces))) = (row.receiver, row.layers);
            let open = under_leaves.get(&receiver.id).copied();
            let surfaces = choice.over(surfaces);
            views.push(found.of(receiver.normal, &SeenByPlane { shares: row.views, sky: &sky, open, surfaces }));
            let (_, plane) = point_of(&receiver.id);
            looks_up.push(plane == 0);
            Some(receiver)
        });
        let points = PersonPoints::new(rows);
        if let Some(error) = failed {
            return Err(error);
        }
        let points = points.map_err(|what| no_persons(place, what))?;
        Ok((PersonSet { points, views }, looks_up))
    }

    /// Returns the number of points.
    pub(super) fn len(&self) -> usize {
        self.points.len()
    }

    /// Returns the name of a point.
    pub(super) fn name(&self, number: usize) -> &str {
        self.points.name(number)
    }

    /// Returns the view shares of the planes of a point.
    pub(super) fn views(&self, number: usize) -> Option<SixPlanes<ViewShares>> {
        let planes = self.points.planes(number)?;
        all_of(planes.map(|receiver| self.views.get(receiver).copied()))
    }
}

/// Returns the cosine-weighted share of sky that each receiver sees through leaves and screens, by
/// receiver; empty if the scene has none. Light that these let through counts.
fn under_leaves(stream: &TileStream) -> Result<HashMap<String, f64>> {
    let mut found = HashMap::new();
    if stream.receivers.parts().iter().all(|part| part.archive.entries_of(format::CANOPY).is_empty()) {
        return Ok(found);
    }
    let series = Series::of_conditions(vec![uniform_sky()], Changes::default(), Provenance::default());
    let light = LightRequest { sky: SkyChoice::Model(SkyModel::Uniform), ..LightRequest::default() };
    let stream = TileStream { series: &series, light: &light, ..*stream };
    stream.each(ComponentSet::new(&[Component::SkyDirect]), |tile| {
        let share = |row: usize| open_share(tile.values.row(Component::SkyDirect, row));
        found.extend(tile.ids.iter().enumerate().map(|(row, id)| (id.clone(), share(row))));
        Ok(true)
    })?;
    Ok(found)
}

fn no_persons(place: &Path, what: String) -> Error {
    let hint = "give the scene instead of the archive, or receivers for the planes up, down, north, east, south and west of each point \
                P: P, P/down, P/north and so on";
    Error::input(place, None, what, hint).because(Problem::Lacks("receivers"))
}

impl<'s> PersonCollector<'s> {
    pub(super) fn new(set: &'s PersonSet) -> Self {
        PersonCollector { set, begun: BTreeMap::new(), next: 0 }
    }

    /// Takes the receivers of a tile.
    pub(super) fn add(&mut self, ids: &[String], values: &TileValues) {
        for (row, id) in ids.iter().enumerate() {
            let (point, plane) = point_of(id);
            let Some(number) = self.set.points.number(point) else { continue };
            let (planes, found) = self.begun.entry(number).or_default();
            *planes += 1;
            found.number = number;
            found.light.put(plane, values.row(Component::Total, row), values.row(Component::SunDirect, row));
        }
    }

    /// Returns the complete points, in their order, up to the first incomplete one.
    pub(super) fn complete(&mut self) -> Vec<PointLight> {
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
