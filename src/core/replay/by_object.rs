//! Light by the object that takes it from a receiver or reflects it to it. In: a replay, the
//! objects of its scene. Out: for each receiver, light of the free sun and sky, what arrives of it,
//! and what each object takes and gives.
//!
//! Each object that a receiver sees becomes a row of a tile of its own: the sky that it hides is
//! the sky of that row, and the cells that it shows are those that the row sees. The replay of that
//! tile is the light that the object takes and gives. So each formula is that of a replay, and
//! because light is linear in what is seen, taken and received light add up to that under a free
//! sky.
//!
//! - A direction that the sky texture does not show is hidden by the object that the hit texture
//!   shows there, at the middle of the base texel of the sky. If the texel of the hit texture shows
//!   the sky, or the ground below the horizon, the nearest texel counts that shows a surface above
//!   the horizon.
//! - Canopies take what they do not let through, where nothing else hides the sky. If rays of a
//!   receiver cross several, these share what they take together, in proportion to what each alone
//!   would take.
//! - Light that a mirror shows is given by the mirror.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::hemisphere::{Frame, ray_direction, texel_centres, texel_of};
use crate::layers::canopy::{Canopy, SEEN, SKY, SeenLeaf};
use crate::layers::hit::HitTile;
use crate::layers::mirror::ReceiverMirrors;
use crate::layers::response::Response;
use crate::layers::sky_bitmap::SkyBitmap;
use crate::light::mirrors::left;
use crate::light::reflector::Reflector;
use crate::light::response::{Viewer, texel_weights};
use crate::light::tile_view::TileView;
use crate::opened::{CellTriangles, SceneObjects, SeenObject, SurfaceOf};
use crate::replay::components::Component;
use crate::replay::direct::specular::MirrorView;
use crate::replay::receiver_view::ReceiverView;
use crate::replay::run::{Replay, ReplayBuilder};
use crate::replay::tile_layers::{Reads, TileLayers};
use crate::replay::values::TileValues;
use crate::weather::conditions::Condition;

/// Columns of the light that arrives unless something takes it.
pub const DIRECT: [Component; 2] = [Component::SunDirect, Component::SkyDirect];

/// Columns of the light that surfaces give.
pub const GIVEN: [Component; 4] =
    [Component::SunReflected, Component::SkyReflected, Component::SunMirrored, Component::SkyMirrored];

/// Number of values, row by result, that are computed at a time.
const VALUES_AT_ONCE: usize = 1 << 19;

/// Largest number of rows that are computed at a time; each has a response of its own.
const ROWS_AT_ONCE: usize = 1024;

/// Replay of an archive by object.
pub struct ObjectReplay<'a>(Replay<'a>);

impl<'a> ReplayBuilder<'_, 'a> {
    /// Prepares the replay by object, without bands. Responses are derived, not read. Errors as in
    /// [`ReplayBuilder::build`], and for an archive without hits and cells.
    pub fn build_by_object(mut self) -> Result<ObjectReplay<'a>> {
        self.conditions.iter().try_for_each(Condition::check)?;
        self.by_object = true;
        let mut replay = self.build_one()?;
        // What an object takes of a sky with parts below 0 may be below 0.
        replay.forcing.signed();
        Ok(ObjectReplay(replay))
    }
}

/// Light of one receiver, in the unit of the results.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightByObject {
    /// `[column of DIRECT][result]`: light that would arrive if nothing stood before the sky.
    pub free: [Vec<f64>; 2],
    /// `[column of DIRECT][result]`: light that arrives.
    pub received: [Vec<f64>; 2],
    /// Light that each object takes and gives. Taken and received light add up to that under a free
    /// sky.
    pub objects: BTreeMap<SeenObject, ObjectLight>,
}

/// Light that an object takes from a receiver and gives to it.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectLight {
    /// `[column of DIRECT][result]`.
    pub taken: [Vec<f64>; 2],
    /// `[column of GIVEN][result]`.
    pub given: [Vec<f64>; 4],
}

/// Subject of a row of a tile.
#[derive(Clone, Copy, PartialEq)]
enum RowOf {
    /// Sky without anything before it.
    Free,
    /// Sky that nothing but canopies hides, without these.
    Clear,
    /// Sky that is seen.
    Received,
    /// Sky that is seen where one canopy alone stands before it.
    Behind(u16),
    /// Sky that an object hides, and the cells that it shows.
    Object(SeenObject),
}

/// Row of a tile.
struct Row {
    receiver: usize,
    of: RowOf,
    sky: SkyBitmap,
    canopy: Canopy,
    mirrors: Vec<MirrorView>,
    /// Cells that are seen, and the share of the hemisphere of each.
    cells: Vec<SeenLeaf>,
}

impl ObjectReplay<'_> {
    /// Returns the light of the receivers of a tile for which `wanted` is true, in order.
    pub fn tile(
        &self,
        tile: u32,
        objects: &SceneObjects,
        wanted: impl Fn(usize) -> bool,
    ) -> Result<Vec<LightByObject>> {
        let (site, forcing) = (&self.0.site, &self.0.forcing);
        let view = TileView::read(site, tile)?;
        let positions: Vec<DVec3> = view.receivers.position.iter().map(|&at| DVec3::from(at)).collect();
        let (hits, viewers, mirrors) = (view.hits.clone(), view.viewers.clone(), view.mirrors.clone());
        let canopies = view.canopies.clone();
        let reads = Reads { sky: true, mirrors: self.0.mirrors.as_ref() };
        let (_, layers) = TileLayers::of_view(site, view, reads, Vec::new())?;
        let palette: Vec<CellTriangles> = hits.palette.par_iter().map(|cell| objects.in_cell(*cell)).collect();
        let texels = site.settings().hit * site.settings().hit;
        let centres = texel_centres(site.settings().sky_base);
        let rows = |receiver: usize| -> Vec<Row> {
            let seen = SeenFrom {
                objects,
                palette: &palette,
                hits: &hits,
                texels: &hits.texels[receiver * texels..][..texels],
                viewer: viewers[receiver],
                at: positions[receiver],
                reflectors: self.0.responder.as_ref().map_or(&[], |(tables, _)| &tables.mirrors.reflectors),
            };
            let empty = (Canopy::default(), ReceiverMirrors::default());
            let canopy = canopies.get(receiver).unwrap_or(&empty.0);
            let windows = layers.mirrors.get(receiver).map_or(&[][..], Vec::as_slice);
            let mirrors = mirrors.get(receiver).unwrap_or(&empty.1);
            seen.rows(receiver, &layers.sky[receiver], &centres, canopy, windows, mirrors)
        };
        let mut found = Vec::new();
        let wanted: Vec<usize> = (0..viewers.len()).filter(|receiver| wanted(*receiver)).collect();
        let most = (VALUES_AT_ONCE / forcing.results().max(1)).clamp(1, ROWS_AT_ONCE);
        let mut waiting: Vec<Row> = Vec::new();
        for (place, receiver) in wanted.iter().enumerate() {
            waiting.append(&mut rows(*receiver));
            if waiting.len() >= most || place + 1 == wanted.len() {
                // Rows with cells come first: only they have responses.
                let mut rows = std::mem::take(&mut waiting);
                rows.sort_by_key(|row| row.cells.is_empty());
                let values = self.values(tile, &hits, &viewers, &mut rows)?;
                found.append(&mut gathered(objects, &rows, &values));
            }
        }
        Ok(found)
    }

    /// Returns the values of some rows, those with cells first.
    fn values(&self, tile: u32, hits: &HitTile, viewers: &[Viewer], rows: &mut [Row]) -> Result<TileValues> {
        let normal = |row: &Row| viewers[row.receiver].normal;
        let mut responses: Vec<Vec<Response>> = Vec::new();
        let lit = rows.partition_point(|row| !row.cells.is_empty());
        if let Some((tables, solver)) = self.0.responder.as_ref().filter(|_| lit > 0) {
            // Cells come as those of leaves, which have weights of their own.
            let cells = |row: &mut Row| Canopy::new([&[], &[]], [0, 0], std::mem::take(&mut row.cells));
            let view = TileView {
                number: tile,
                receivers: Default::default(),
                viewers: rows[..lit].iter().map(|row| Viewer { sky_view: 0.0, ..viewers[row.receiver] }).collect(),
                hits: HitTile { palette: hits.palette.clone(), texels: Vec::new() },
                mirrors: Vec::new(),
                canopies: rows[..lit].iter_mut().map(cells).collect(),
            };
            // One tile: a list of responses for each state.
            responses = solver.derive(tables, &[view])?.into_iter().flatten().collect();
        }
        let has_mirrors = rows.iter().any(|row| !row.mirrors.is_empty());
        let of_rows = |row: &mut Row| std::mem::take(&mut row.mirrors);
        Ok(self.0.forcing.replay(&TileLayers {
            normals: rows.iter().map(normal).collect(),
            views: vec![[0.0; 3]; rows.len()],
            canopies: rows.iter().map(|row| row.canopy.clone()).collect(),
            mirrors: if has_mirrors { rows.iter_mut().map(of_rows).collect() } else { Vec::new() },
            sky: rows.iter_mut().map(|row| std::mem::replace(&mut row.sky, SkyBitmap::closed(1, 1))).collect(),
            responses,
        }))
    }
}

/// A receiver and the surfaces that its rays met.
struct SeenFrom<'t> {
    objects: &'t SceneObjects,
    /// Triangles of each cell of the palette of `hits`.
    palette: &'t [CellTriangles<'t>],
    hits: &'t HitTile,
    /// `[texel]` of the receiver's hits.
    texels: &'t [u32],
    viewer: Viewer,
    at: DVec3,
    /// `[material]`; empty if no surface reflects diffusely.
    reflectors: &'t [Reflector],
}

impl SeenFrom<'_> {
    /// Returns the rows of the receiver.
    fn rows(
        &self,
        receiver: usize,
        sky: &SkyBitmap,
        centres: &[DVec3],
        canopy: &Canopy,
        windows: &[MirrorView],
        mirrors: &ReceiverMirrors,
    ) -> Vec<Row> {
        let shown = self.shown();
        let disc = ObjectDisc::new(&shown, self.viewer.normal);
        let toward = |direction: DVec3| disc.seen(direction);
        let closed = || SkyBitmap::closed(sky.side(), sky.block());
        let row =
            |of, sky| Row { receiver, of, sky, canopy: Canopy::default(), mirrors: Vec::new(), cells: Vec::new() };
        let mut found: BTreeMap<SeenObject, Row> = BTreeMap::new();
        for (object, hidden) in sky.inverse().split(|texel| toward(centres[texel])) {
            found.insert(object, row(RowOf::Object(object), hidden));
        }
        let new = |object| row(RowOf::Object(object), closed());
        for (object, part) in windows.iter().flat_map(|window| window.split(toward)) {
            found.entry(object).or_insert_with(|| new(object)).mirrors.push(part);
        }
        for (object, cell) in
            self.cells(&shown, &disc, canopy, mirrors).into_iter().filter(|(_, cell)| cell.share > 0.0)
        {
            found.entry(object).or_insert_with(|| new(object)).cells.push(cell);
        }
        let mut rows: Vec<Row> = found.into_values().collect();
        rows.push(row(RowOf::Free, closed().inverse()));
        rows.push(row(RowOf::Clear, sky.clone()));
        let crossed: Vec<u16> = canopy.crossed(SKY).collect();
        if !crossed.is_empty() {
            rows.push(Row { canopy: canopy.clone(), ..row(RowOf::Received, sky.clone()) });
            let behind =
                |&material: &u16| Row { canopy: canopy.only(material), ..row(RowOf::Behind(material), sky.clone()) };
            rows.extend(crossed.iter().map(behind));
        }
        rows
    }

    /// Returns the cells that are seen, each with its share of the hemisphere and the object that
    /// shows it.
    fn cells(
        &self,
        shown: &[Option<(SeenObject, bool)>],
        disc: &ObjectDisc,
        canopy: &Canopy,
        mirrors: &ReceiverMirrors,
    ) -> Vec<(SeenObject, SeenLeaf)> {
        let weights = texel_weights(self.texels, &self.viewer);
        let mut before = canopy.crossings(SEEN);
        let mut cells = Vec::new();
        for (texel, seen) in shown.iter().enumerate() {
            if let (Some((object, _)), Some(cell)) = (seen, self.hits.palette.get(self.cell(texel))) {
                let before = before.remove(&texel).unwrap_or_default();
                cells.push((*object, SeenLeaf { cell: *cell, before, share: weights[texel] as f32 }));
            }
        }
        for path in mirrors.paths.iter().filter(|_| !self.reflectors.is_empty()) {
            let share = weights[path.texel as usize] * left(&path.steps, self.reflectors);
            let cell = SeenLeaf { cell: path.cell, before: Vec::new(), share: share as f32 };
            cells.push((disc.nearest[path.texel as usize], cell));
        }
        let of_leaf = |leaf: &SeenLeaf| (self.objects.in_cell(leaf.cell).seen_from(self.at), leaf.clone());
        cells.extend(canopy.seen_leaves().iter().map(of_leaf));
        cells
    }

    /// Returns the index in the palette of the cell that a texel shows; a large one for none.
    fn cell(&self, texel: usize) -> usize {
        (self.texels[texel] as usize).wrapping_sub(1)
    }

    /// Returns the object that each texel shows, and whether its ray goes above the horizon.
    fn shown(&self) -> Vec<Option<(SeenObject, bool)>> {
        let (side, frame) = (self.texels.len().isqrt(), Frame::new(self.viewer.normal));
        let of = |texel: usize| {
            let cell = self.palette.get(self.cell(texel))?;
            let toward = frame.to_world(ray_direction(texel, side, self.viewer.seed));
            Some((cell.seen(self.at, toward), toward.z > 0.0))
        };
        (0..self.texels.len()).map(of).collect()
    }
}

/// Objects around a receiver, by direction.
pub struct ObjectDisc {
    frame: Frame,
    side: usize,
    /// `[texel]` of the hit texture.
    nearest: Vec<SeenObject>,
}

impl ObjectDisc {
    /// Returns the objects around a receiver.
    pub fn of_view(view: &ReceiverView, objects: &SceneObjects) -> Self {
        let palette: Vec<CellTriangles> = view.palette.iter().map(|cell| objects.in_cell(*cell)).collect();
        let hits = HitTile { palette: Vec::new(), texels: Vec::new() };
        let seen = SeenFrom {
            objects,
            palette: &palette,
            hits: &hits,
            texels: &view.texels,
            viewer: view.viewer,
            at: view.receiver.position,
            reflectors: &[],
        };
        ObjectDisc::new(&seen.shown(), view.viewer.normal)
    }

    fn new(shown: &[Option<(SeenObject, bool)>], normal: DVec3) -> Self {
        let side = shown.len().isqrt();
        ObjectDisc { frame: Frame::new(normal), side, nearest: nearest(shown, side) }
    }

    /// Returns the objects, each once.
    pub fn all(&self) -> impl Iterator<Item = SeenObject> {
        let all: BTreeSet<SeenObject> = self.nearest.iter().copied().collect();
        all.into_iter()
    }

    /// Returns the object that is seen in a direction which the sky texture does not show.
    pub fn seen(&self, direction: DVec3) -> SeenObject {
        let (column, row) = texel_of(self.frame.to_local(direction), self.side);
        self.nearest[row * self.side + column]
    }
}

/// Returns for each texel the object of the nearest texel whose ray met a surface above the
/// horizon; of all texels if none did.
fn nearest(shown: &[Option<(SeenObject, bool)>], side: usize) -> Vec<SeenObject> {
    let has_upper = shown.iter().flatten().any(|(_, up)| *up);
    let mut found: Vec<Option<SeenObject>> =
        shown.iter().map(|seen| seen.filter(|(_, up)| *up || !has_upper).map(|(object, _)| object)).collect();
    let mut reached: VecDeque<usize> = (0..found.len()).filter(|texel| found[*texel].is_some()).collect();
    while let Some(texel) = reached.pop_front() {
        let (column, row) = (texel % side, texel / side);
        let near = |at: usize| at.saturating_sub(1)..(at + 2).min(side);
        for next in near(row).flat_map(|row| near(column).map(move |column| row * side + column)) {
            if found[next].is_none() {
                found[next] = found[texel];
                reached.push_back(next);
            }
        }
    }
    let unknown = SeenObject { of: SurfaceOf::Unknown, is_ground: false };
    found.into_iter().map(|object| object.unwrap_or(unknown)).collect()
}

/// Gathers the values of rows by receiver, ascending.
fn gathered(objects: &SceneObjects, rows: &[Row], values: &TileValues) -> Vec<LightByObject> {
    let mut of_receivers: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    rows.iter().enumerate().for_each(|(place, row)| of_receivers.entry(row.receiver).or_default().push(place));
    let row = |component, place| -> Vec<f64> { values.row(component, place).iter().copied().map(f64::from).collect() };
    let direct = |place| DIRECT.map(|component| row(component, place));
    let of_receiver = |places: Vec<usize>| {
        let mut light = LightByObject::default();
        let mut behind = Vec::new();
        let mut clear = <[Vec<f64>; 2]>::default();
        let mut is_behind_canopies = false;
        for place in places {
            match rows[place].of {
                RowOf::Free => light.free = direct(place),
                RowOf::Clear => clear = direct(place),
                RowOf::Received => (light.received, is_behind_canopies) = (direct(place), true),
                RowOf::Behind(material) => behind.push((material, direct(place))),
                RowOf::Object(object) => {
                    let given = GIVEN.map(|component| row(component, place));
                    light.objects.insert(object, ObjectLight { taken: direct(place), given });
                }
            }
        }
        if is_behind_canopies {
            add_canopies(objects, &mut light, &clear, &behind);
        } else {
            light.received = clear;
        }
        light
    };
    of_receivers.into_values().map(of_receiver).collect()
}

/// Adds what canopies take: `clear` is the light without them, `behind` that behind each alone.
fn add_canopies(
    objects: &SceneObjects,
    light: &mut LightByObject,
    clear: &[Vec<f64>; 2],
    behind: &[(u16, [Vec<f64>; 2])],
) {
    let results = clear[0].len();
    for (column, clear) in clear.iter().enumerate() {
        for (result, clear) in clear.iter().enumerate() {
            let alone: Vec<f64> = behind.iter().map(|(_, left)| (clear - left[column][result]).max(0.0)).collect();
            let (together, sum) = (clear - light.received[column][result], alone.iter().sum::<f64>());
            for ((material, _), alone) in behind.iter().zip(alone).filter(|_| sum > 0.0) {
                let none = || ObjectLight {
                    taken: std::array::from_fn(|_| vec![0.0; results]),
                    given: std::array::from_fn(|_| vec![0.0; results]),
                };
                let object = light.objects.entry(objects.of_material(*material)).or_insert_with(none);
                object.taken[column][result] += together * alone / sum;
            }
        }
    }
}
