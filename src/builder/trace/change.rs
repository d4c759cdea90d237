//! Change of a scene, for finding what it can alter. In: the triangles that were added or removed.
//! Out: the rays that meet one of them. All other rays hit what they hit before, or still nothing.

use glam::DVec3;

use crate::trace::kernel::fan::Cone;
use crate::trace::kernel::ray::{Hit, Ray};
use crate::trace::kernel::rays::Tracer;
use heliotile_core::layers::texel_block::Answers;
use heliotile_core::site::cells::{CellKey, GRID_SHIFT_M, size_of};
use heliotile_core::site::grid::Grid;
use heliotile_scene::Scene;
use heliotile_scene::change::SceneChange;
use heliotile_scene::mesh::Mesh;

/// Triangles that were added or removed.
pub struct Change {
    /// Tracer of the triangles; `None` without triangles.
    tracer: Option<Tracer>,
    /// Boxes around all triangles, relative to the origin.
    boxes: Vec<[DVec3; 2]>,
    grid: Grid,
}

/// Size below which boxes are not cut further, metres, so that the balls around them are not much
/// larger than their contents.
const SMALL_M: f64 = 16.0;

/// Largest number of successive cuts: 64 boxes.
const CUTS: u32 = 6;

/// Margin that covers the rounding of coordinates, distances and directions: metres, and metres per
/// metre of distance.
const MARGIN: (f64, f64) = (0.05, 1e-4);

impl Change {
    /// Creates the change of a scene that is `scene` now.
    pub fn new(change: &SceneChange, scene: &Scene) -> Self {
        Change::with(change, &[], scene)
    }

    /// Creates the change, and counts some triangles of the scene as changed, too.
    pub fn with(change: &SceneChange, more: &[u32], scene: &Scene) -> Self {
        let points = |&triangle: &u32| scene.mesh.triangle_points(triangle as usize);
        let now = change.added.iter().chain(more).map(points);
        let triangles: Vec<[DVec3; 3]> = change.removed.iter().copied().chain(now).collect();
        let mesh = Mesh::loose(scene.mesh.grid(), &triangles, scene.mesh.bounds());
        let all: Vec<u32> = (0..triangles.len() as u32).collect();
        let mut corners = triangles;
        let mut boxes = Vec::new();
        cut(&mut corners, CUTS, &mut boxes);
        Change { tracer: (!all.is_empty()).then(|| Tracer::of_triangles(&mesh, &all)), boxes, grid: mesh.grid() }
    }

    /// Adds boxes of unchanged triangles to the places that cells look towards. Rays do not meet
    /// these triangles.
    pub fn near_to(mut self, triangles: impl Iterator<Item = [DVec3; 3]>) -> Self {
        cut(&mut triangles.collect::<Vec<_>>(), CUTS, &mut self.boxes);
        self
    }

    /// Returns true if nothing was added or removed.
    pub fn is_nothing(&self) -> bool {
        self.tracer.is_none()
    }

    /// Returns for each ray true if it meets one of the triangles.
    pub fn met(&self, rays: &[Ray]) -> Vec<bool> {
        self.tracer.as_ref().map_or_else(|| vec![false; rays.len()], |tracer| tracer.occluded_many(rays))
    }

    /// Returns the number of rays that hit something else than before the change: one of the
    /// triangles, with nothing nearer. `hits` are the hits in the scene as it is now.
    pub fn altered_of(&self, rays: &[Ray], hits: &[Option<Hit>]) -> usize {
        let Some(changed) = &self.tracer else { return 0 };
        let met = rays.iter().zip(hits).zip(self.met(rays)).filter(|ray| ray.1).map(|ray| ray.0);
        let (rays, hits): (Vec<Ray>, Vec<Option<Hit>>) = met.map(|(ray, hit)| (*ray, *hit)).unzip();
        let is_first = |(near, first): &(Option<Hit>, &Option<Hit>)| {
            near.as_ref().zip(first.as_ref()).is_none_or(|(near, first)| first.t >= near.t)
        };
        changed.closest_many(&rays).into_iter().zip(&hits).filter(is_first).count()
    }

    /// Does the work of [`Change::altered_of`] if the hits of the rays are not known.
    pub fn altered(&self, rays: &[Ray], scene: &Tracer) -> usize {
        let met: Vec<Ray> = rays.iter().zip(self.met(rays)).filter(|ray| ray.1).map(|ray| *ray.0).collect();
        self.altered_of(&met, &scene.closest_many(&met))
    }

    /// Returns true if some of the rays hit something else than before the change.
    pub fn alters(&self, rays: &[Ray], scene: &Tracer) -> bool {
        self.altered(rays, scene) > 0
    }

    /// Returns the directions of the boxes as seen from within `spread_m` of a point relative to
    /// the origin.
    pub fn seen_from(&self, point: DVec3, spread_m: f64) -> ChangeInView {
        let ball = |[low, high]: &[DVec3; 2]| {
            let way = 0.5 * (*low + *high) - point;
            let radius = 0.5 * (*high - *low).length() + spread_m + MARGIN.0 + MARGIN.1 * way.length();
            let beyond = way.length_squared() - radius * radius;
            Ball { way, radius, least: if beyond > 0.0 { beyond.sqrt() } else { f64::NEG_INFINITY } }
        };
        ChangeInView { balls: self.boxes.iter().map(ball).collect() }
    }

    /// Returns true if a box touches the voxel of a cell, or comes nearer to it than `nearby` times
    /// its edge.
    pub fn touches(&self, key: CellKey, nearby: f64) -> bool {
        let (corner, size) = (key.corner(self.grid.origin), size_of(key.level));
        // 1 / 4096 is more than the 1 / 8192 by which `surface::sample` widens a voxel.
        let slack = size * (nearby + 1.0 / 4096.0) + self.grid.slack_m(corner, size) + MARGIN.0;
        let low = corner - self.grid.origin - GRID_SHIFT_M - slack;
        let high = low + (size + 2.0 * slack);
        self.boxes.iter().any(|of| of[0].cmple(high).all() && of[1].cmpge(low).all())
    }

    /// Returns the centre of a cell's voxel relative to the origin, and the distance of its corners
    /// from there.
    pub fn middle(&self, key: CellKey) -> (DVec3, f64) {
        let (corner, size) = (key.corner(self.grid.origin), size_of(key.level));
        (corner - self.grid.origin - GRID_SHIFT_M + 0.5 * size, size * 3_f64.sqrt() * 0.5)
    }
}

/// Cuts triangles into boxes, each in the middle of its longest side.
fn cut(triangles: &mut [[DVec3; 3]], cuts: u32, boxes: &mut Vec<[DVec3; 2]>) {
    let corners = || triangles.iter().flatten();
    let low = corners().fold(DVec3::INFINITY, |low, p| low.min(*p));
    let high = corners().fold(DVec3::NEG_INFINITY, |high, p| high.max(*p));
    let size = high - low;
    if triangles.is_empty() {
        return;
    }
    if cuts > 0 && size.max_element() > SMALL_M && triangles.len() > 1 {
        let axis = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(0);
        let middle = |triangle: &[DVec3; 3]| triangle[0][axis] + triangle[1][axis] + triangle[2][axis];
        triangles.sort_by(|a, b| middle(a).total_cmp(&middle(b)));
        // `middle` is a sum of three corners, so it is compared with three times the middle of the
        // box.
        let half = 1.5 * (low[axis] + high[axis]);
        let at = triangles.partition_point(|triangle| middle(triangle) < half);
        // If all centres lie on one side of the middle, cut the list in half.
        let at = if (1..triangles.len()).contains(&at) { at } else { triangles.len() / 2 };
        let (left, right) = triangles.split_at_mut(at);
        cut(left, cuts - 1, boxes);
        cut(right, cuts - 1, boxes);
    } else {
        boxes.push([low, high]);
    }
}

/// Ball around some of the changed triangles, as seen from a place.
struct Ball {
    /// Vector from the place to the centre, metres.
    way: DVec3,
    radius: f64,
    /// Least dot product of `way` with a unit direction that touches the ball; -infinity if the
    /// place is inside the ball.
    least: f64,
}

/// Directions of the changed triangles as seen from a place.
pub struct ChangeInView {
    balls: Vec<Ball>,
}

/// Bound of the deviation of a plane cell's normals from their mean. The length of the mean is
/// known to 1e-6, which leaves 0.003.
pub const FLAT: f64 = 4e-3;

impl ChangeInView {
    /// Drops the balls that lie wholly behind a surface at that place.
    pub fn before(mut self, normal: DVec3) -> Self {
        self.balls.retain(|ball| ball.way.dot(normal) + ball.radius + FLAT * ball.way.length() > 0.0);
        self
    }

    /// Returns true if nothing of the change can be seen.
    pub fn is_nothing(&self) -> bool {
        self.balls.is_empty()
    }

    /// Returns true if a ray in a direction can meet the change.
    pub fn lies_towards(&self, direction: DVec3) -> bool {
        // The squared distance of the centre from the ray is way^2 - along^2.
        self.balls.iter().any(|ball| ball.way.dot(direction) >= ball.least)
    }

    /// Returns true if a ray that does not go up can meet the change.
    pub fn lies_below(&self) -> bool {
        self.balls.iter().any(|ball| ball.way.z <= ball.radius)
    }

    /// Returns true if a ray of a cone can meet the change.
    pub(crate) fn lies_in(&self, cone: &Cone) -> bool {
        self.balls.iter().any(|Ball { way, radius, .. }| {
            let distance = way.length();
            if distance <= *radius {
                return true;
            }
            let sine = radius / distance;
            // Directions of the cone have about unit length.
            f64::from(cone.dot((*way / distance).as_vec3().to_array())[1]) >= (1.0 - sine * sine).sqrt() - 1e-4
        })
    }
}

/// Answers for a receiver's sky from before a change.
pub struct KnownSky<'a> {
    /// Answers of each level of the texture, the base first.
    pub answers: &'a [Answers],
    pub change: &'a Change,
    /// `[part of the sky]`: true if the change may be seen there.
    pub touched: &'a [bool],
}

#[cfg(test)]
mod tests {
    use super::*;
    use heliotile_core::hemisphere::{mix, unit};

    /// 20,000 random rays go towards 40 triangles. Every ray that meets one is predicted to by the
    /// balls of its place, by the balls for places within 5 m and by the cone around its direction.
    /// Over 150 rays meet one, and fewer than 16 times as many are predicted to.
    #[test]
    fn every_ray_that_meets_a_change_is_predicted() {
        let random = |i: u64, k: u64| unit(mix(i, k)) - 0.5;
        let point = |i: u64, size: f64| DVec3::new(random(i, 1), random(i, 2), random(i, 3)) * size;
        let triangle = |i: u64| {
            let at = point(i, 200.0);
            ([at, at + point(i + 100, 30.0), at + point(i + 200, 30.0)], 0)
        };
        let all = heliotile_core::site::material::Material::matt;
        let wall = all("wall", 0.3, heliotile_core::site::material::Class::Obstruction);
        let scene = Scene::from_triangles(&(0..40).map(triangle).collect::<Vec<_>>(), vec![wall]).expect("a scene");
        let added = (0..scene.mesh.triangles.len() as u32).collect();
        let change = Change::new(&SceneChange { added, ..SceneChange::default() }, &scene);
        assert!((5..=64).contains(&change.boxes.len()), "{}", change.boxes.len());
        let (mut met, mut expected) = (0, 0);
        for i in 1000..21_000 {
            let (from, towards) = (point(i, 300.0), point(i + 50_000, 2.0).normalize());
            let ray = Ray { origin: from.as_vec3().to_array(), direction: towards.as_vec3().to_array() };
            let [low, high] = [-0.02, 0.02].map(|wide| (towards + wide).to_array());
            let crosses = [0, 1, 2].map(|i| low[i] < 0.0 && high[i] > 0.0);
            let seen = [change.seen_from(from, 0.0), change.seen_from(from + point(i, 5.0), 5.0)];
            let is_met = change.met(&[ray])[0];
            let found = [seen[0].lies_towards(towards), seen[1].lies_towards(towards)];
            assert!(!is_met || found == [true; 2], "{from} {towards}");
            if crosses == [false; 3] {
                assert!(!is_met || seen[0].lies_in(&Cone::between(low, high)));
            }
            met += u32::from(is_met);
            expected += u32::from(found[0]);
        }
        assert!(met > 150 && (met..16 * met).contains(&expected), "{met} {expected}");
    }
}
