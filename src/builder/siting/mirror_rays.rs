//! Rays of one receiver by way of mirrors. In: its position and normal, chains of mirrors,
//! directions. Out: the mirror that is seen in a direction, and whether a chain reflects the sun to
//! it.

use glam::DVec3;

use crate::pipeline::PreparedScene;
use crate::trace::mirror::{Look, Reflections};
use crate::trace::viewpoint::Viewpoint;
use crate::trace::{Ray, Tracer};
use heliotile_core::site::chain::{Chain, MirrorPlane};

/// Mirrors of a scene, ready for rays.
pub struct MirrorRays<'a> {
    reflections: Reflections<'a>,
    tracer: &'a Tracer,
}

/// Receiver in front of mirrors.
pub struct MirrorObserver<'a> {
    rays: &'a MirrorRays<'a>,
    origin: [f32; 3],
    normal: DVec3,
}

impl<'a> MirrorRays<'a> {
    /// Creates the tracer of the mirrors of a prepared scene.
    pub fn new(prepared: &'a PreparedScene<'a>) -> Self {
        let tracer = &prepared.tracer;
        MirrorRays { reflections: Reflections::new(&prepared.scene.mesh, tracer, &prepared.mirrors), tracer }
    }

    /// Maps the numbers of mirrors in an archive of the scene to those of the scene; `None` if the
    /// scene lacks one of them.
    pub fn numbers_of(&self, orientations: &[MirrorPlane]) -> Option<Vec<u16>> {
        let own = self.reflections.orientations();
        let number = |plane: &MirrorPlane| {
            // Normals of opposite signs describe the same mirror.
            let nearness = |one: &MirrorPlane| one.normal.dot(plane.normal).abs();
            let same = own.iter().enumerate().filter(|(_, one)| one.material == plane.material);
            let nearest = same.max_by(|a, b| nearness(a.1).total_cmp(&nearness(b.1)));
            nearest.and_then(|(number, _)| u16::try_from(number).ok())
        };
        orientations.iter().map(number).collect()
    }

    /// Returns a receiver whose rays start where those of a build do. `position` is in input
    /// coordinates.
    pub fn observer(&self, position: DVec3, normal: DVec3) -> MirrorObserver<'_> {
        MirrorObserver { rays: self, origin: Viewpoint { position, normal }.origin(self.tracer), normal }
    }
}

impl MirrorObserver<'_> {
    /// Returns the triangle of the mirror that is hit first in each direction; `None` if another
    /// surface is hit first, or nothing.
    pub fn mirrors(&self, directions: &[DVec3]) -> Vec<Option<usize>> {
        let ray = |direction: &DVec3| Ray { origin: self.origin, direction: direction.as_vec3().to_array() };
        let hits = self.rays.tracer.closest_many(&directions.iter().map(ray).collect::<Vec<_>>());
        let mirror = |hit| self.rays.reflections.orientation(hit).map(|_| hit.triangle as usize);
        hits.into_iter().map(|hit| hit.and_then(mirror)).collect()
    }

    /// Returns for each sun true if a chain, by the scene's numbers, reflects it to the receiver.
    pub fn sees(&self, chain: Chain, suns: &[DVec3]) -> Vec<bool> {
        let look = |sun: &DVec3| Look { chain: 0, sky: *sun, origin: self.origin, normal: self.normal };
        let looks: Vec<Look> = suns.iter().map(look).collect();
        let chains = [(chain, self.rays.reflections.seen_from(&chain))];
        self.rays.reflections.lit(&chains, &looks, &mut 0)
    }
}
