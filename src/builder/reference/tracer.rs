//! Scene as light paths meet it. In: rays, hits. Out: open rays, the shares that canopies let
//! through, the places and mirrors that are hit.

use glam::DVec3;

use super::estimate::{BATCHES, Batch};
use crate::pipeline::PreparedScene;
use crate::settings::{Effect, Effects};
use crate::trace::canopy::{Canopies, Passage, Path};
use crate::trace::kernel::ray::Hit;
use crate::trace::{Ray, Tracer};
use heliotile_core::light::reflector::Reflector;
use heliotile_core::site::chain::MirrorPlane;
use heliotile_core::site::material::Material;
use heliotile_scene::mesh::Mesh;
use heliotile_scene::mirrors::Mirrors;

/// Reference path tracer of a scene.
pub struct PathTracer<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) tracer: &'a Tracer,
    pub(super) canopies: Option<&'a Canopies<'a>>,
    /// Mirrors; `None` if there are none.
    pub(super) mirrors: Option<&'a Mirrors>,
    pub(super) reflectors: Vec<Reflector>,
    /// True if light is reflected by at most one matt surface.
    pub(super) once: bool,
    /// True if leaves scatter light.
    pub(super) leaves: bool,
}

/// Vertex of a light path: a place on a surface, where rays start.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathVertex {
    /// Position relative to the scene origin, off the surface.
    pub from: DVec3,
    /// Normal on the side that is lit.
    pub normal: DVec3,
}

/// Sums by sky and batch, W/m2.
pub(super) type Sums = Vec<[Batch; BATCHES]>;

impl<'a> PathTracer<'a> {
    /// Creates the path tracer of a scene. Effects in `left_out` are left out as a build leaves
    /// them out.
    pub fn new(prepared: &'a PreparedScene<'a>, left_out: Effects) -> Self {
        let reflector = |material: &Material| match left_out.contains(Effect::Diffuse) {
            true => Reflector { diffuse: 0.0, ..Reflector::new(material) },
            false => Reflector::new(material),
        };
        PathTracer {
            mesh: &prepared.scene.mesh,
            tracer: &prepared.tracer,
            canopies: prepared.canopies.as_ref().filter(|_| !left_out.contains(Effect::Canopies)),
            mirrors: Some(&prepared.mirrors).filter(|all| !all.is_empty() && !left_out.contains(Effect::Mirrors)),
            reflectors: prepared.scene.materials.iter().map(reflector).collect(),
            once: left_out.contains(Effect::Bounces),
            leaves: ![Effect::Leaves, Effect::Diffuse].iter().any(|effect| left_out.contains(*effect)),
        }
    }

    /// Returns the rays that hit nothing, with the share that canopies let through.
    pub(super) fn open(&self, rays: &[Ray]) -> Vec<(usize, f64)> {
        let met = self.tracer.occluded_many(rays);
        let open: Vec<usize> = met.into_iter().enumerate().filter(|(_, met)| !met).map(|(place, _)| place).collect();
        let through = self.through(open.iter().map(|&place| (rays[place], f32::INFINITY)));
        open.into_iter().zip(through).collect()
    }

    /// Returns the vertex where a ray hits a surface, and the orientation of the mirror if it is
    /// one.
    pub(super) fn vertex(&self, from: DVec3, direction: DVec3, hit: Hit) -> (PathVertex, Option<MirrorPlane>) {
        let triangle = hit.triangle as usize;
        let outward = self.mesh.normal(triangle);
        let normal = if outward.dot(direction) > 0.0 { -outward } else { outward };
        // Distances have single precision, so the place is moved onto the plane of the surface.
        let way = direction * f64::from(hit.t);
        let [corner, ..] = self.mesh.triangle_points(triangle);
        let way = way - outward * (way - (corner - from)).dot(outward);
        let grid = self.mesh.grid();
        let from = vector(grid.lifted(grid.absolute(from) + way, normal));
        (PathVertex { from, normal }, self.orientation(hit).map(|(_, orientation)| orientation))
    }

    /// Returns the number and orientation of the mirror that was hit; `None` if it is no mirror.
    pub(super) fn orientation(&self, hit: Hit) -> Option<(u16, MirrorPlane)> {
        let mirrors = self.mirrors?;
        let number = mirrors.of_triangle(hit.triangle)?;
        Some((number, mirrors.orientations[usize::from(number)]))
    }

    /// Returns the shares that canopies let through of rays with their lengths, metres.
    pub(super) fn through(&self, rays: impl ExactSizeIterator<Item = (Ray, f32)>) -> Vec<f64> {
        let count = rays.len();
        match self.canopies {
            None => vec![1.0; count],
            Some(canopies) => self.left_behind(&canopies.passages(&numbered(rays)), count),
        }
    }

    /// Returns the remaining share of `rays` rays, some of which cross canopies.
    pub(super) fn left_behind(&self, passages: &[Passage], rays: usize) -> Vec<f64> {
        let mut through = vec![1.0; rays];
        for (canopies, passage) in self.canopies.iter().flat_map(|all| passages.iter().map(move |one| (all, one))) {
            for (material, amount) in canopies.crossed_before(passage, f64::INFINITY) {
                through[passage.place as usize] *= self.left(material, amount);
            }
        }
        through
    }

    /// Returns the share that a number of crossings of a canopy leaves, or a length in metres in a
    /// volume.
    pub(super) fn left(&self, material: u16, amount: f64) -> f64 {
        self.reflectors[usize::from(material)].transmittance.unwrap_or(1.0).powf(amount)
    }
}

/// Numbers rays and their lengths, metres.
pub(super) fn numbered(rays: impl Iterator<Item = (Ray, f32)>) -> Vec<Path> {
    (0..).zip(rays).map(|(place, (ray, reach_m))| Path { place, ray, reach_m }).collect()
}

pub(super) fn ray(from: DVec3, direction: DVec3) -> Ray {
    Ray { origin: from.as_vec3().to_array(), direction: direction.as_vec3().to_array() }
}

pub(super) fn vector(point: [f32; 3]) -> DVec3 {
    DVec3::from(point.map(f64::from))
}
