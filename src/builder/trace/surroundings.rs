//! Surroundings of a cell: what it sees besides the sky. In: a cell whose sky bits are traced. Out:
//! the coarse cells that a few rays hit, above and below the horizon apart.
//!
//! No ray is spent on the sky. Above the horizon, rays go again where the sky bits are 0, in
//! proportion to the cosine. The bits tell how much of the hemisphere these rays stand for, so sky
//! and surroundings always add up to the whole.

use glam::{DVec2, DVec3};

use crate::trace::change::ChangeInView;
use crate::trace::kernel::ray::Ray;
use crate::trace::mirror::{MirrorRay, Reflections};
use crate::trace::probe::{Directions, ProbeTrace, pick};
use crate::trace::surface::{CellSurfaces, SurfacePoint, cell_of};
use heliotile_core::hemisphere::{Frame, bit, cosine_direction_of, direction_of, mix, r2, unit};
use heliotile_core::layers::cells::{DOWN, MISS};
use heliotile_core::light::radiosity::SidesOf;
use heliotile_core::site::cells::{CellKey, level_of};

/// Cell that one ray hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenCell {
    /// True if the ray goes above the horizon.
    pub up: bool,
    /// Coarse cell that was hit; `None` if no surface was.
    pub cell: Option<CellKey>,
    /// Ray and its length, metres, if it hit a surface.
    pub path: Option<(Ray, f32)>,
}

impl SeenCell {
    /// Returns the ray as a hit of [`Cells`](heliotile_core::layers::cells::Cells), for uses where
    /// it only matters if anything was hit.
    pub fn as_hit(&self) -> u32 {
        let met = if self.cell.is_some() { 0 } else { MISS };
        if self.up { met } else { met | DOWN }
    }
}

/// Settings of the rays by which cells see their surroundings.
#[derive(Clone, Copy, Debug)]
pub struct SurroundingSettings {
    /// Level of the cells at middle distance, as receivers' cells see them. Nearby cells are finer,
    /// distant cells coarser.
    pub closed_level: i8,
    /// Number of rays of a cell.
    pub rays: usize,
}

/// Surroundings that the rays of a cell hit.
#[derive(Clone, Debug, Default)]
pub struct Surroundings {
    /// Hit of each ray.
    pub seen: Vec<SeenCell>,
    /// Rays that hit a mirror: true if the ray goes above the horizon, and where it hit the mirror.
    pub mirrors: Vec<(bool, MirrorRay)>,
    /// Number of rays cast.
    pub cast: u64,
}

impl Surroundings {
    /// Returns surroundings of `rays` rays that hit nothing, none of them cast.
    pub fn none(rays: usize) -> Self {
        Surroundings { seen: vec![SeenCell { up: true, cell: None, path: None }; rays], ..Surroundings::default() }
    }
}

/// Size of cells on distant surfaces, as a share of their distance: the footprint of a ray.
const FAR_SHARE: f64 = 0.25;

/// Largest size of cells on nearby surfaces, as a share of their distance. In a light well, light
/// falls off over the well's width, and larger cells below an arcade would hold surfaces outside
/// it. With a share of 1, errors are 1.3 times as large in an arcade and 1.2 in a well, for 5 to 10
/// % less time.
const NEAR_SHARE: f64 = 0.5;

/// Levels between a cell and its home, the voxel within which coarse cells of one level see each
/// other, as in a court or a room of white walls. Beyond it they see larger cells; otherwise one
/// street would require the next, and so the whole map.
const HOME: u32 = 3;

/// Levels above those at middle distance from which on cells see each other all over the map: such
/// large cells are few.
const GROWTH: i8 = 6;

/// Share of the hemisphere below which a part gets no ray.
const NEGLIGIBLE: f64 = 1e-3;

/// Returns at most `count` rays from a cell whose sky texture is traced, each with true if it goes
/// above the horizon. All rays above have equal weights, and so have all rays below.
pub fn looks_around(key: CellKey, probe: &ProbeTrace, texture: &Directions, count: usize) -> Vec<(Ray, bool)> {
    let (n, directions) = (texture.n, texture.of(key));
    let seed = key.seed();
    let normals = probe.starts.normals();
    // Blocked texels above the horizon and the running sum of their cosines.
    let blocked = || {
        let texels = texture.texels().filter(|&texel| !normals.is_empty() && !bit(&probe.bits, texel));
        let cosines = texels.map(|t| (t, probe.starts.cosine(usize::from(probe.owner[t]), directions[t])));
        let mut sum = 0.0;
        cosines.filter(|&(_, cos)| cos > 0.0).map(move |(texel, cos)| {
            sum += cos;
            (texel, sum)
        })
    };
    let sum = blocked().last().map_or(0.0, |(_, sum)| sum);
    // A texel has 2 pi / n^2 sr, of the pi of a cosine-weighted hemisphere. Each side of a leaf
    // counts half, as in `SidesOf::cosine`.
    let above = sum * if key.is_leaf() { 1.0 } else { 2.0 } / (n * n) as f64;
    let below = if normals.is_empty() { 0.0 } else { SidesOf(key).below(probe.normal.z).max(0.0) };
    let (up_count, down_count) = split(count, above, below);

    let mut rays: Vec<(Ray, bool)> = Vec::with_capacity(count);
    let mut from = |point: usize, direction: DVec3, up: bool| {
        rays.push((probe.starts.ray(point, direction), up));
    };
    let (start, mut last) = (unit(mix(seed, 11)), 0);
    let mut blocked = blocked().peekable();
    for i in 0..up_count {
        // These values rise from ray to ray.
        let at = (i as f64 + start) / up_count as f64 * sum;
        while let Some(passed) = blocked.next_if(|&(_, sum)| sum <= at) {
            last = passed.0;
        }
        let texel = blocked.peek().map_or(last, |&(texel, _)| texel);
        from(usize::from(probe.owner[texel]), directions[texel], true);
    }
    if down_count > 0 {
        let frames: Vec<Frame> = normals.iter().map(|&normal| Frame::new(normal)).collect();
        let weights: Vec<f64> = probe.points.iter().map(|p| p.1).collect();
        let square = tries_of(key);
        // Only tries that go below the horizon are kept.
        let tries = (0..64 * down_count).map(|j| {
            let point = pick(&weights, unit(mix(seed ^ 0x646f_776e, j as u64)));
            Some((point, downward(key, tried(key, &frames[point], square(j)))?))
        });
        for (point, direction) in tries.flatten().take(down_count) {
            from(point, direction, false);
        }
    }
    rays
}

/// Returns a tried direction if it goes below the horizon. For leaves, which have two sides, other
/// directions are reversed.
fn downward(key: CellKey, direction: DVec3) -> Option<DVec3> {
    match direction.z <= 0.0 {
        true => Some(direction),
        false => key.is_leaf().then_some(-direction),
    }
}

/// Returns a direction that a point of a cell tries: cosine-weighted about its normal, in a volume
/// of leaves any direction alike.
fn tried(key: CellKey, frame: &Frame, square: DVec2) -> DVec3 {
    if key.is_volume() { direction_of(square) } else { frame.to_world(cosine_direction_of(square)) }
}

/// Returns the sequence of points at which a cell tries the cosine-weighted hemisphere.
fn tries_of(key: CellKey) -> impl Fn(usize) -> DVec2 {
    let seed = key.seed();
    let offset = DVec2::new(unit(mix(seed, 12)), unit(mix(seed, 13)));
    move |j| r2(j as f64, offset)
}

/// Returns all rays that a cell may cast towards a change, for its sky and, `count` of them, for
/// its surroundings, whichever of its points are hidden.
pub fn may_cast(key: CellKey, probe: &ProbeTrace, texture: &Directions, count: usize, seen: &ChangeInView) -> Vec<Ray> {
    let directions: Vec<DVec3> = texture.of(key).iter().copied().filter(|way| seen.lies_towards(*way)).collect();
    let mut rays = Vec::new();
    let starts = &probe.starts;
    for point in 0..probe.points.len() {
        let before = directions.iter().filter(|direction| starts.cosine(point, **direction) > 0.0);
        rays.extend(before.map(|direction| starts.ray(point, *direction)));
    }
    let below = |point: &SurfacePoint| SidesOf(key).below(point.normal.z) > NEGLIGIBLE;
    if !seen.lies_below() || !probe.points.iter().any(|(point, _)| below(point)) {
        return rays;
    }
    let frames: Vec<Frame> = probe.points.iter().map(|p| Frame::new(p.0.normal)).collect();
    let square = tries_of(key);
    // A try counts for a point if it goes below the point's horizon. Tries end when `count` of them
    // count for all points.
    let mut below_all = 0;
    for j in 0..64 * count {
        let mut all = true;
        for (point, frame) in frames.iter().enumerate() {
            let direction = downward(key, tried(key, frame, square(j)));
            all &= direction.is_some();
            rays.extend(direction.filter(|way| seen.lies_towards(*way)).map(|way| starts.ray(point, way)));
        }
        below_all += usize::from(all);
        if below_all == count {
            break;
        }
    }
    rays
}

/// Casts the rays of [`looks_around`] from cells whose sky textures are traced, and returns the
/// surroundings of each. Rays of all cells go together, since one cell has too few to fill packets.
pub fn surroundings<'p>(
    cells: impl Iterator<Item = (CellKey, &'p ProbeTrace)>,
    texture: &Directions,
    settings: SurroundingSettings,
    surfaces: CellSurfaces,
    reflections: Option<&Reflections>,
) -> Vec<Surroundings> {
    let CellSurfaces { mesh, tracer, .. } = surfaces;
    let SurroundingSettings { closed_level, rays: count } = settings;
    let looks = |(key, probe)| (key, looks_around(key, probe, texture, count));
    let cells: Vec<(CellKey, Vec<(Ray, bool)>)> = cells.map(looks).collect();
    let cast: Vec<Ray> = cells.iter().flat_map(|(_, rays)| rays.iter().map(|ray| ray.0)).collect();
    let mut hits = tracer.closest_many(&cast).into_iter();
    let met_by = |(key, rays): (CellKey, Vec<(Ray, bool)>)| {
        let mut met = Surroundings { cast: rays.len() as u64, ..Surroundings::default() };
        for ((ray, up), hit) in rays.into_iter().zip(hits.by_ref()) {
            let [from, direction] = [ray.origin, ray.direction].map(|v| DVec3::from(v.map(f64::from)));
            let cell = hit.map(|hit| {
                seen_from(key, f64::from(hit.t), closed_level, |level| cell_of(hit, direction, level, mesh, from))
            });
            met.seen.push(SeenCell { up, cell, path: hit.map(|hit| (ray, hit.t)) });
            if let Some(hit) = hit.filter(|&hit| reflections.is_some_and(|r| r.orientation(hit).is_some())) {
                met.mirrors.push((up, MirrorRay { from, direction, hit }));
            }
        }
        met.seen.resize(count, SeenCell { up: true, cell: None, path: None });
        met
    };
    cells.into_iter().map(met_by).collect()
}

/// Returns the coarse cell that a cell sees at a distance. `met` gives the cell that was hit, for a
/// level.
pub fn seen_from(own: CellKey, distance_m: f64, closed: i8, met: impl Fn(i8) -> CellKey) -> CellKey {
    let near = level_of(distance_m * NEAR_SHARE).min(closed);
    let far = level_of(distance_m * FAR_SHARE);
    // Fine cells see only coarser ones, or one well of them would require a city of them.
    let level = near.max(far).max((own.level + 1).min(closed)).max(own.level);
    let seen = met(level).coarse(level);
    let home = |key: CellKey| key.voxel.map(|v| v >> HOME);
    let stays = level > own.level || level >= closed + GROWTH || home(own) == home(seen);
    if stays { seen } else { seen.coarse(level + 1) }
}

/// Returns true if a cell with this mean normal can see a change at all: by its texels of the sky,
/// or below the horizon.
pub fn may_see(key: CellKey, normal: DVec3, texture: &Directions, seen: &ChangeInView) -> bool {
    // The normal that a cell holds is rounded to f32.
    (seen.lies_below() && SidesOf(key).below(normal.z) > 0.5 * NEGLIGIBLE)
        || texture.of(key).iter().any(|direction| seen.lies_towards(*direction))
}

/// Splits `count` rays above and below the horizon in proportion to their shares, with at least one
/// for each share that matters. `count` is 0 where further reflections are left out, else at least
/// 2.
fn split(count: usize, above: f64, below: f64) -> (usize, usize) {
    match (above > NEGLIGIBLE, below > NEGLIGIBLE) {
        _ if count == 0 => (0, 0),
        (false, false) => (0, 0),
        (true, false) => (count, 0),
        (false, true) => (0, count),
        (true, true) => {
            let up = (count as f64 * above / (above + below)).round() as usize;
            let up = up.clamp(1, count - 1);
            (up, count - up)
        }
    }
}
