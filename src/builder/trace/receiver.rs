//! What one receiver sees: sky bits wherever they are asked for, and the cell that each texel of its own hemisphere meets.

use glam::{DVec2, DVec3};

use crate::trace::kernel::rays::{Ray, Tracer};
use crate::trace::mirror::{MirrorRay, Reflections};
use crate::trace::probe::lifted;
use crate::trace::surroundings::cell_of;
use heliotile_core::hemisphere::{Centres, Frame, jitter, texel_direction, texels_in_blocks};
use heliotile_core::site::cells::{CellKey, level_of, receiver_seed};
use heliotile_scene::mesh::Mesh;

/// How hits are gathered into cells.
#[derive(Clone, Copy, Debug)]
pub struct CellSettings {
    /// Edge of a cell in units of the hit texel's footprint; 0 gives every hit a cell of its own (about 1 mm).
    pub factor: f64,
    /// Smallest edge of a cell.
    pub floor_m: f64,
}

impl CellSettings {
    /// Level of the cell of a hit at this distance, texels of the hit texture being so wide.
    pub fn level(&self, distance_m: f64, texel_angle: f64) -> i8 {
        let size = (self.factor * distance_m * texel_angle).max(self.floor_m);
        if self.factor > 0.0 { level_of(size) } else { PRIVATE_LEVEL }
    }
}

/// Level of a cell that holds nothing but its own hit: 2^-10 m.
const PRIVATE_LEVEL: i8 = -10;

/// The hits of one receiver.
#[derive(Clone, Debug)]
pub struct HitTrace {
    /// n x n, row-major, surface frame; `None` where the ray met nothing.
    pub cells: Vec<Option<CellKey>>,
    /// Distance of the nearest surface met, metres.
    pub nearest_m: f64,
    /// Texels whose ray meets a mirror.
    pub mirrors: Vec<(usize, MirrorRay)>,
    /// `[texel]`: distance of what is met, metres; infinite where nothing is.
    pub distances_m: Vec<f32>,
}

/// Where a texel at the rim of a texture that will be refined is looked at: near the horizon, as whatever stands there stands on it. With
/// its centre, 0.9 degrees up in a texture of 64 a side, lower hills and houses would never be seen.
fn low(column: u32, row: u32, n: usize) -> Option<DVec3> {
    let last = n as u32 - 1;
    let at = |i: u32| match i {
        0 => RIM,
        i if i == last => 1.0 - RIM,
        _ => 0.5,
    };
    let rim = [column, row].iter().any(|&i| i == 0 || i == last);
    rim.then(|| texel_direction(column as usize, row as usize, n, DVec2::new(at(column), at(row))))
}

/// Texels off the rim: 0.1 degrees of the coarsest ones.
const RIM: f64 = 0.06;

/// A receiver's place (input coordinates, metres) and normal.
#[derive(Clone, Copy, Debug)]
pub struct Viewpoint {
    /// Relative to the scene origin, metres.
    pub position: DVec3,
    /// Unit.
    pub normal: DVec3,
}

impl Viewpoint {
    pub(super) fn origin(&self, tracer: &Tracer) -> [f32; 3] {
        lifted(self.position, self.normal, tracer)
    }

    /// Seed of the jitter of this viewpoint's hit rays.
    pub fn seed(&self) -> u64 {
        receiver_seed(self.position, self.normal)
    }

    /// Sky bits of the given texels (column, row) of an n x n world-frame texture. Texels whose centre lies behind the
    /// surface are asked along the surface.
    pub fn sky(&self, n: usize, texels: &[(u32, u32)], centres: &Centres, tracer: &Tracer) -> Vec<bool> {
        let (origin, centre, refined) = (self.origin(tracer), centres.of(n), n < centres.finest());
        let rays: Vec<Ray> = texels
            .iter()
            .map(|&(column, row)| {
                let d = if refined { low(column, row, n) } else { None }.unwrap_or_else(|| centre(column, row));
                let behind = self.normal.dot(d);
                let d = if behind > 0.0 { d } else { d - self.normal * (behind - 1e-4) };
                Ray { origin, direction: d.as_vec3().to_array() }
            })
            .collect();
        tracer.occluded_many(&rays).into_iter().map(|met| !met).collect()
    }

    /// Closest hits over the n x n texture of the surface's own hemisphere, one jittered ray a texel.
    pub fn hits(
        &self,
        n: usize,
        cells: CellSettings,
        mesh: &Mesh,
        tracer: &Tracer,
        reflections: Option<&Reflections>,
    ) -> HitTrace {
        let origin = self.origin(tracer);
        let lifted_position = DVec3::from(origin.map(f64::from));
        let texel_angle = (heliotile_core::hemisphere::HEMISPHERE_SR / (n * n) as f64).sqrt();
        let direction = self.hit_directions(n);
        let texels: Vec<usize> = texels_in_blocks(n).map(|(column, row)| row * n + column).collect();
        let directions: Vec<DVec3> = texels.iter().map(|&texel| direction(texel)).collect();
        let rays: Vec<Ray> = directions.iter().map(|d| Ray { origin, direction: d.as_vec3().to_array() }).collect();
        let mut nearest_m = f64::INFINITY;
        let mut keys = vec![None; n * n];
        let mut mirrors = Vec::new();
        let mut distances_m = vec![f32::INFINITY; n * n];
        for ((texel, direction), hit) in texels.into_iter().zip(directions).zip(tracer.closest_many(&rays)) {
            let Some(hit) = hit else { continue };
            nearest_m = nearest_m.min(f64::from(hit.t));
            distances_m[texel] = hit.t;
            let level = cells.level(f64::from(hit.t), texel_angle);
            keys[texel] = Some(cell_of(hit, direction, level, mesh, lifted_position));
            if reflections.is_some_and(|r| r.orientation(hit).is_some()) {
                mirrors.push((texel, MirrorRay { from: lifted_position, direction, hit }));
            }
        }
        HitTrace { cells: keys, nearest_m, mirrors, distances_m }
    }

    /// Directions of the hit rays by texel: jittered, world frame.
    pub(super) fn hit_directions(&self, n: usize) -> impl Fn(usize) -> DVec3 + use<> {
        let (frame, seed) = (Frame::of(self.normal), self.seed());
        move |texel| frame.to_world(texel_direction(texel % n, texel / n, n, jitter(seed, texel as u64)))
    }

    /// Whether this lies below terrain or inside a solid: rays that go up from there cross surfaces an odd number of times, at least
    /// two of three steep ones.
    pub fn enclosed(&self, tracer: &Tracer) -> bool {
        let origin = self.origin(tracer);
        let ups = [[0.031, 0.017, 1.0], [-0.023, 0.041, 1.0], [0.011, -0.037, 1.0]];
        ups.into_iter().filter(|&direction| tracer.crossings(Ray { origin, direction }) % 2 == 1).count() >= 2
    }
}
