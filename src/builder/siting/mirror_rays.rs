//! Rays of one receiver by way of mirrors. In: its place and normal, chains of mirrors, directions. Out: which mirror is seen in a direction, and
//! whether a chain throws the sun at it.

use glam::DVec3;

use crate::pipeline::PreparedScene;
use crate::trace::mirror::{Look, Reflections};
use crate::trace::receiver::Viewpoint;
use crate::trace::{Ray, Tracer};
use heliotile_core::site::chain::{Chain, MirrorPlane};

/// The mirrors of a scene, ready for rays.
pub struct MirrorRays<'a> {
    reflections: Reflections<'a>,
    tracer: &'a Tracer,
}

/// A receiver before them.
pub struct MirrorObserver<'a> {
    rays: &'a MirrorRays<'a>,
    origin: [f32; 3],
    normal: DVec3,
}

impl<'a> MirrorRays<'a> {
    /// Of a prepared scene.
    pub fn new(prepared: &'a PreparedScene<'a>) -> Self {
        let tracer = &prepared.tracer;
        MirrorRays { reflections: Reflections::new(&prepared.scene.mesh, tracer, &prepared.mirrors), tracer }
    }

    /// The scene's numbers of mirrors by those of an archive of it; `None` if it has no such mirror.
    pub fn numbers_of(&self, orientations: &[MirrorPlane]) -> Option<Vec<u16>> {
        let own = self.reflections.orientations();
        let number = |plane: &MirrorPlane| {
            // Signs of normals mean nothing.
            let nearness = |one: &MirrorPlane| one.normal.dot(plane.normal).abs();
            let same = own.iter().enumerate().filter(|(_, one)| one.material == plane.material);
            let nearest = same.max_by(|a, b| nearness(a.1).total_cmp(&nearness(b.1)));
            nearest.and_then(|(number, _)| u16::try_from(number).ok())
        };
        orientations.iter().map(number).collect()
    }

    /// A receiver whose rays start where those of a build do; `position` in input coordinates.
    pub fn observer(&self, position: DVec3, normal: DVec3) -> MirrorObserver<'_> {
        MirrorObserver { rays: self, origin: Viewpoint { position, normal }.origin(self.tracer), normal }
    }
}

impl MirrorObserver<'_> {
    /// Triangles of the mirrors that are seen first in some directions; none where something else is, or nothing.
    pub fn mirrors(&self, directions: &[DVec3]) -> Vec<Option<usize>> {
        let ray = |direction: &DVec3| Ray { origin: self.origin, direction: direction.as_vec3().to_array() };
        let hits = self.rays.tracer.closest_many(&directions.iter().map(ray).collect::<Vec<_>>());
        let mirror = |hit| self.rays.reflections.orientation(hit).map(|_| hit.triangle as usize);
        hits.into_iter().map(|hit| hit.and_then(mirror)).collect()
    }

    /// Whether a chain, by the scene's numbers, throws each of some suns at the receiver.
    pub fn sees(&self, chain: Chain, suns: &[DVec3]) -> Vec<bool> {
        let look = |sun: &DVec3| Look { chain: 0, sky: *sun, origin: self.origin, normal: self.normal };
        let looks: Vec<Look> = suns.iter().map(look).collect();
        let chains = [(chain, self.rays.reflections.seen_from(&chain))];
        self.rays.reflections.lit(&chains, &looks, &mut 0)
    }
}
