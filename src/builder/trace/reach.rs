//! Upper bounds of the light that a change can alter at a place. In: the boxes of added or removed
//! triangles, and the reflectance of the scene's brightest surface. Out: bounds, without casting a
//! ray except in [`Reach::shown`].
//!
//! The light is that of a uniform sky, or the mean over suns everywhere in the sky, as a share of
//! what open ground gets. No direction is then brighter than the sky, whatever reflects. So light
//! from directions that meet a change alters by no more than the view factor of the ball around it,
//! (R/d)^2 at a distance d. The integral equation of radiosity bounds the reflections of altered
//! light: at most (d/D)^2 of a hemisphere at a distance D is nearer than d to the centre of the
//! ball. So the sum over all bounces is at most the solution of
//! `M(D) = (R/D)^2 (1 + rho) + rho int_R^D M(d) 2 d / D^2 dd`, which is
//! `M(D) = (1 + rho) (R/D)^(2 - 2 rho)`.

use std::f64::consts::TAU;

use glam::DVec3;

use super::change::{Change, FLAT};
use super::kernel::rays::Tracer;
use super::viewpoint::Viewpoint;
use crate::trace::kernel::ray::Ray;
use heliotile_core::hemisphere::{Frame, mix, unit};

/// Margin for the rounding of coordinates, metres.
const MARGIN_M: f64 = 0.05;

/// Ball, relative to the origin.
struct Ball {
    middle: DVec3,
    radius: f64,
}

/// Bounds of the light that a change can alter, by place.
pub struct Reach {
    /// Balls around the added or removed triangles.
    balls: Vec<Ball>,
    /// Reflectance of the brightest surface, below 1.
    brightest: f64,
}

/// Surface within `spread_m` of a centre relative to the origin, with its normal if it is plane.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePlace {
    pub middle: DVec3,
    pub spread_m: f64,
    pub normal: Option<DVec3>,
}

impl Reach {
    /// Creates the bounds for a change in a scene whose surfaces all reflect at most `brightest`.
    pub fn new(change: &Change, brightest: f64) -> Self {
        let ball = |[low, high]: &[DVec3; 2]| Ball {
            middle: 0.5 * (*low + *high),
            radius: 0.5 * (*high - *low).length() + MARGIN_M,
        };
        Reach { balls: change.boxes().iter().map(ball).collect(), brightest }
    }

    /// Returns a bound of the share of light anywhere on a surface that comes from directions which
    /// meet the change: at most 1.
    pub fn in_view(&self, surface: SurfacePlace) -> f64 {
        self.sum(|ball| cap(ball, surface))
    }

    /// Does the work of [`Reach::in_view`] for a point, less what other surfaces hide, which rays
    /// towards each ball find out. If k of `RAYS` rays meet the change first, less than (k + 3) /
    /// `RAYS` of the ball is visible by 19 to 1 ("rule of three").
    pub fn shown(&self, at: &Viewpoint, seed: u64, change: &Change, scene: &Tracer) -> f64 {
        let origin = at.origin(scene);
        let middle = DVec3::from(origin.map(f64::from));
        let point = SurfacePlace { middle, spread_m: 0.0, normal: Some(at.normal) };
        let caps: Vec<f64> = self.balls.iter().map(|ball| cap(ball, point)).collect();
        let all: f64 = caps.iter().sum();
        if caps.iter().any(|share| *share > LARGE) {
            return all.min(1.0);
        }
        let shown = |(ball, share): (&Ball, f64)| {
            let way = ball.middle - middle;
            let wide = 1.0 - (1.0 - (ball.radius / way.length()).powi(2)).sqrt();
            let frame = Frame::new(way.normalize());
            let ray = |i: u64| {
                // R2 sequence (Roberts 2018), uniform in the cone.
                let [u, v] = [(12, 0.754_877_666_246_692_8), (13, 0.569_840_290_998_053_3)]
                    .map(|(k, step)| (unit(mix(seed, k)) + i as f64 * step).fract());
                let (z, turn) = (1.0 - u * wide, v * TAU);
                let aside = (1.0 - z * z).sqrt();
                frame.to_world(DVec3::new(aside * turn.cos(), aside * turn.sin(), z))
            };
            let before = (0..RAYS).map(ray).filter(|way| way.dot(at.normal) > 0.0);
            let rays: Vec<Ray> = before.map(|way| Ray { origin, direction: way.as_vec3().to_array() }).collect();
            share * ((change.altered(&rays, scene) as f64 + 3.0) / RAYS as f64).min(1.0)
        };
        self.balls.iter().zip(caps).filter(|(_, share)| *share > 0.0).map(shown).sum::<f64>().min(1.0)
    }

    /// Returns a bound of the share of light anywhere on a surface that the change alters, directly
    /// and by all reflections: at most 1.
    pub fn by_all_ways(&self, surface: SurfacePlace) -> f64 {
        let (rho, power) = (self.brightest, 2.0 - 2.0 * self.brightest);
        self.sum(|ball| {
            let near = ball.radius / (ball.middle.distance(surface.middle) - surface.spread_m).max(ball.radius);
            (1.0 + rho) * near.powf(power)
        })
    }

    fn sum(&self, each: impl Fn(&Ball) -> f64) -> f64 {
        self.balls.iter().map(each).sum::<f64>().min(1.0)
    }
}

/// Number of rays towards a ball.
const RAYS: u64 = 64;

/// Share of the light of a ball above which its visibility is not traced.
const LARGE: f64 = 0.1;

/// Returns an upper bound of the light from a ball anywhere on a surface.
fn cap(ball: &Ball, surface: SurfacePlace) -> f64 {
    let SurfacePlace { middle, spread_m, normal } = surface;
    let (way, radius) = (ball.middle - middle, ball.radius);
    let distance = way.length();
    if distance <= radius + spread_m {
        return 1.0;
    }
    // Solid angle of the ball over pi, the cosine-weighted hemisphere, and the steepest direction
    // into it from anywhere on the surface.
    let sine = (radius / (distance - spread_m)).min(1.0);
    let share = 2.0 * (1.0 - (1.0 - sine * sine).sqrt());
    let steepest = normal.map_or(1.0, |normal| {
        let aside = (way.dot(normal) / distance).clamp(-1.0, 1.0).acos();
        (aside - ((radius + spread_m) / distance).asin() - FLAT).max(0.0).cos().max(0.0)
    });
    share * steepest
}

#[cfg(test)]
mod tests {
    use super::*;
    use heliotile_core::site::material::{Class, Material};
    use heliotile_scene::Scene;
    use heliotile_scene::change::SceneChange;

    /// A triangle 2 m long is seen from surfaces at 3 to 300 m. The share in view of a surface that
    /// faces it is (R/d)^2 within 12 %, 1 at the triangle, 0 if the triangle lies behind, and less
    /// than 1.5 (R/d)^3 at the horizon of a surface. With all reflections at a reflectance of 0.5,
    /// the bound is the numerical solution of the integral equation within 1 %, and never less than
    /// the share in view.
    #[test]
    fn bounds_fall_with_distance() {
        let corners = [DVec3::ZERO, DVec3::X * 2.0, DVec3::new(1.0, 1.0, 0.0)];
        let scene = Scene::from_triangles(&[(corners, 0)], vec![Material::matt("a", 0.5, Class::Ground)]).expect("one");
        let change = Change::new(&SceneChange { added: vec![0], ..SceneChange::default() }, &scene);
        let reach = Reach::new(&change, 0.5);
        let middle = DVec3::new(1.0, 0.5, 0.0) - scene.mesh.origin;
        let radius = 0.5 * 5_f64.sqrt() + MARGIN_M;
        let surface =
            |x: f64, normal| SurfacePlace { middle: middle + DVec3::X * x, spread_m: 0.5, normal: Some(normal) };
        let here = surface(0.0, DVec3::X);
        assert_eq!((reach.in_view(here), reach.by_all_ways(here)), (1.0, 1.0));
        for x in [3.0, 10.0, 30.0, 100.0, 300.0] {
            let near = radius / (x - 0.5);
            let [towards, along, away] =
                [-DVec3::X, DVec3::Z, DVec3::X].map(|normal| reach.in_view(surface(x, normal)));
            assert!((1.0..1.12).contains(&(towards / near.powi(2))), "{x}: {towards}");
            assert!(
                away == 0.0 && along > 0.0 && along < 1.5 * near.powi(3) + FLAT * near.powi(2),
                "{x}: {along} {away}"
            );
            // N = M D^2 in steps: N' = 2 rho M D.
            let (steps, mut n, distance) = (20_000, 1.5 * radius * radius, x - 0.5);
            for i in 0..steps {
                let step = (distance - radius) / f64::from(steps);
                n += step * n / (radius + (f64::from(i) + 0.5) * step);
            }
            let (all, whole) = (reach.by_all_ways(surface(x, DVec3::Z)), (n / (distance * distance)).min(1.0));
            assert!((all / whole - 1.0).abs() < 0.01 && all >= towards, "{x}: {all} {whole}");
        }
    }
}
