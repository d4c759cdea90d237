//! The people of an archive: points with six planes each. In: names of its receivers, their skies.
//! Out: the point and plane of each receiver, and what the planes see of the heat around them.
//! Their comfort stands in [`crate::comfort`].

use std::collections::HashMap;

use heliotile_comfort::people::columns::ComfortColumn;
use heliotile_comfort::people::points::{PersonPoints, all_of, point_of};
use heliotile_comfort::people::surfaces::seen_surfaces;
use heliotile_comfort::people::views::{PlaneViews, SeenByPlane, open_share, uniform_sky};
use heliotile_comfort::surroundings::{SixPlanes, ViewShares};
use heliotile_comfort::utci::StressCategory;
use heliotile_core::archive::format::{CANOPY, RECEIVERS};
use heliotile_core::error::Result;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::site::receiver::Receiver;
use heliotile_core::sky::model::SkyModel;
use serde_json::json;

use crate::answer::{Answer, Numbers};
use crate::comfort::{MOMENT, sum_names};
use crate::failure::{Failure, Kind};
use crate::open::Opened;

/// Tile and row of a plane of a point.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    pub tile: u32,
    pub row: usize,
}

/// Points of the archive, and the views of their planes as far as they were found.
pub struct People {
    points: PersonPoints,
    /// `[receiver]`: number of its point, and number of the plane in the point.
    of_receiver: Vec<(usize, usize)>,
    /// `[tile][row]`: views of the planes, of tiles that were asked for.
    views: HashMap<u32, Vec<ViewShares>>,
    found: PlaneViews,
    /// Replay of a uniform sky; `None` if no leaves stand before the sky.
    through_leaves: Option<Replay<'static>>,
}

impl People {
    /// Returns true if names of the first tile are names of planes. It reads no other tile to find
    /// out.
    pub fn are_likely(opened: &Opened) -> Result<bool> {
        if opened.site.tiles() == 0 {
            return Ok(false);
        }
        let receivers = opened.site.tile_receivers(0)?.receivers();
        Ok(receivers.iter().any(|receiver| point_of(&receiver.id).1 > 0))
    }

    /// Returns the people of an archive, or `None` if its receivers are not all planes of points.
    pub fn new(opened: &Opened) -> Result<Option<Self>> {
        if !People::are_likely(opened)? {
            return Ok(None);
        }
        opened.site.expect(&[RECEIVERS], 0..opened.site.tiles());
        let mut receivers = Vec::new();
        for tile in 0..opened.site.tiles() {
            receivers.extend(opened.site.tile_receivers(tile)?.receivers());
        }
        let names: Vec<String> = receivers.iter().map(|receiver| receiver.id.clone()).collect();
        let Ok(points) = PersonPoints::new(receivers) else { return Ok(None) };
        let of_receiver = names.iter().filter_map(|name| {
            let (point, plane) = point_of(name);
            Some((points.number(point)?, plane))
        });
        let of_receiver = of_receiver.collect();
        let through_leaves = match opened.archive.entries_of(CANOPY).is_empty() {
            true => None,
            false => Some(below_uniform_sky(opened)?),
        };
        let (views, found) = (HashMap::new(), PlaneViews::default());
        Ok(Some(People { points, of_receiver, views, found, through_leaves }))
    }

    /// Answers the number of people, the names of the numbers that can be asked for, the classes of
    /// the UTCI, and the receivers that look up.
    pub fn answer(people: Option<&People>) -> Answer {
        let names = |asked: &[ComfortColumn]| asked.iter().flat_map(|column| column.names()).collect::<Vec<_>>();
        let stress = StressCategory::ALL.map(|StressCategory { name, upper_limit_c }| {
            let to = Some(upper_limit_c).filter(|limit| limit.is_finite());
            json!({ "name": name, "to": to })
        });
        let up = people.map_or_else(Vec::new, |people| {
            people.of_receiver.iter().map(|(_, plane)| u8::from(*plane == 0)).collect::<Vec<_>>()
        });
        let count = people.map_or(0, |people| people.points.len());
        let value = json!({ "count": count, "moment": names(&MOMENT), "sums": sum_names(), "stress": stress });
        Answer::of(value).with("up", Numbers::U8(&up))
    }

    /// Returns the points that have a plane among the receivers of a tile, `[row]`.
    pub fn in_tile(&self, opened: &Opened, tile: u32) -> std::result::Result<Vec<usize>, Failure> {
        let first = opened.first(opened.tile(tile)?) as usize;
        let rows = self.of_receiver.get(first..first + opened.site.tile_rows(tile)).ok_or_else(lost)?;
        Ok(rows.iter().map(|(point, _)| *point).collect())
    }

    /// Returns the tile and row of each plane of a point.
    pub fn planes(&self, opened: &Opened, point: usize) -> std::result::Result<[Plane; 6], Failure> {
        let receivers = self.points.planes(point).ok_or_else(lost)?;
        Ok(receivers.map(|receiver| {
            let tile = opened.firsts.partition_point(|first| *first <= receiver as u64).saturating_sub(1) as u32;
            Plane { tile, row: receiver - opened.first(tile) as usize }
        }))
    }

    /// Returns the shares of the surroundings that the planes of a point see.
    pub fn views(&mut self, opened: &Opened, point: usize) -> std::result::Result<SixPlanes<ViewShares>, Failure> {
        let planes = self.planes(opened, point)?;
        for Plane { tile, .. } in planes {
            if !self.views.contains_key(&tile) {
                let made = self.views_of(&opened.site, tile)?;
                self.views.insert(tile, made);
            }
        }
        let view = |Plane { tile, row }: Plane| self.views.get(&tile)?.get(row).copied();
        all_of(planes.map(view)).ok_or_else(lost)
    }

    fn views_of(&mut self, site: &OpenSite, tile: u32) -> Result<Vec<ViewShares>> {
        let table = site.tile_receivers(tile)?;
        let receivers = table.receivers();
        let skies = site.tile_sky(tile, receivers.len())?;
        let lit = match &self.through_leaves {
            Some(replay) => replay.run([tile])?.pop().map(|(_, values)| values),
            None => None,
        };
        let open = |row: usize| Some(open_share(lit.as_ref()?.row(Component::SkyDirect, row)));
        let surfaces = seen_surfaces(site, tile, receivers.len())?;
        let rows = receivers.iter().zip(table.views()).zip(skies.iter().zip(surfaces)).enumerate();
        let view = |(row, ((receiver, shares), (sky, surfaces)))| {
            let receiver: &Receiver = receiver;
            self.found.of(receiver.normal, &SeenByPlane { shares, sky, open: open(row), surfaces })
        };
        Ok(rows.map(view).collect())
    }
}

/// Makes a replay of a sky of equal radiance, which gives the share of the sky that leaves let
/// through.
fn below_uniform_sky(opened: &Opened) -> Result<Replay<'static>> {
    let settings = ReplaySettings {
        sky: SkyModel::Uniform,
        patches: opened.archive.manifest().settings.patches(),
        components: ComponentSet::new(&[Component::SkyDirect]),
        ..ReplaySettings::default()
    };
    Replay::builder(&opened.site, &[uniform_sky()], settings).build()
}

fn lost() -> Failure {
    Failure::new(Kind::Other, "there is no such point", "")
}
