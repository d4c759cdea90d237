//! Which side of a face is outside, by rays. In: the faces of one object. Out: for a patch of them a verdict.
//!
//! A ray that starts outside of a solid meets its faces an even number of times, one that starts inside an odd number, however the faces are turned.
//! Most rays are nearly level: many houses have no floor, few have no walls. Some rise steeply: a street has walls on both sides as a house has, but
//! no roof. Most of them have to agree, so that gaps do not matter (after Takayama, Jacobson, Kavan, Sorkine-Hornung, "A simple method for
//! correcting facet orientations in polygon meshes based on ray casting", JCGT 3(4), 2014, which counts the free paths of such rays).

use glam::DVec3;

use crate::geometry::Geometry;
use crate::polygon::triangles_of;

/// What rays say of a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// The side from which its first face turns counter-clockwise is outside.
    Outward,
    /// That side is inside.
    Inward,
    /// Both sides are outside.
    Sheet,
    /// Both sides are inside.
    Inner,
    /// Rays disagree.
    Unclear,
}

/// Rays of a face that are nearly level, and steep ones.
const LEVEL_RAYS: usize = 24;
const STEEP_RAYS: usize = 8;
/// Level rays rise or fall by at most this much in a metre.
const SLOPE: f64 = 0.2;
/// Steep rays go aside by this much in a metre.
const ASIDE: f64 = 0.05;
/// Largest faces of a patch that are asked.
const ASKED: usize = 9;
/// How many rays of one side have to agree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// Six of ten: where faces disagree, one of two answers is right.
    Most,
    /// Nine of ten: where nothing but rays speaks against what the file says.
    All,
}

impl Rule {
    fn share(self) -> f64 {
        if self == Rule::Most { 0.6 } else { 0.9 }
    }

    /// Share of the area that rays have to tell.
    fn told(self) -> f64 {
        if self == Rule::Most { 0.3 } else { 0.6 }
    }
}

/// Share of a patch's area that has to agree, of what rays tell.
const AGREED_AREA: f64 = 0.8;
/// Rays start so far off their face, metres: other faces may lie in its plane.
const OFF_M: f64 = 1e-3;
/// Tests of a ray and a triangle beyond which a patch is not asked about: some seconds.
const MOST_TESTS: usize = 300_000_000;

/// A face as rays meet it.
struct Faced {
    number: usize,
    triangles: Vec<[DVec3; 3]>,
    low: DVec3,
    high: DVec3,
    /// Along its normal, as long as its area.
    area: DVec3,
}

/// Faces of an object, ready for rays.
pub(super) struct Sides {
    faces: Vec<Faced>,
    /// `[face of the object]`, sorted by number: place in `faces`.
    places: Vec<(usize, usize)>,
    /// Subtracted from all corners.
    triangles: usize,
}

impl Sides {
    pub fn new(geometry: &Geometry, faces: &[usize]) -> Sides {
        let mut list = Vec::with_capacity(faces.len());
        for &number in faces {
            let triangles = triangles_of(geometry, number);
            let corners = || triangles.iter().flatten().copied();
            let (low, high) = crate::mesh::bounds(corners());
            let area = triangles.iter().map(|[a, b, c]| 0.5 * (*b - *a).cross(*c - *a)).sum();
            list.push(Faced { number, triangles, low, high, area });
        }
        let mut places: Vec<(usize, usize)> =
            list.iter().enumerate().map(|(place, face)| (face.number, place)).collect();
        places.sort_unstable();
        let triangles = list.iter().map(|face| face.triangles.len()).sum();
        Sides { faces: list, places, triangles }
    }

    /// What the largest faces of a patch say; each face with whether it turns against the first one.
    pub fn verdict(&self, patch: &[(usize, bool)], rule: Rule) -> Verdict {
        let place = |face: usize| self.places.binary_search_by_key(&face, |(number, _)| *number).ok();
        let found = patch.iter().filter_map(|(face, against)| {
            let (_, place) = self.places.get(place(*face)?)?;
            Some((self.faces.get(*place)?, *against))
        });
        let mut asked: Vec<(&Faced, bool)> = found.filter(|(face, _)| face.area.length_squared() > 0.0).collect();
        // By size and then by place, so that the order in the file does not matter.
        asked.sort_by(|(a, _), (b, _)| {
            let size = b.area.length().total_cmp(&a.area.length());
            size.then(heliotile_core::site::morton::lexicographic(a.low + a.high, b.low + b.high))
        });
        asked.truncate(ASKED);
        if self.triangles * (LEVEL_RAYS + STEEP_RAYS) * asked.len() > MOST_TESTS {
            return Verdict::Sheet;
        }
        let (mut weights, mut total) = ([0.0; 4], 0.0);
        for (face, against) in asked {
            let area = face.area.length();
            total += area;
            let slot = match (self.of_face(face, rule), against) {
                (Verdict::Outward, false) | (Verdict::Inward, true) => 0,
                (Verdict::Inward, false) | (Verdict::Outward, true) => 1,
                (Verdict::Sheet, _) => 2,
                (Verdict::Inner, _) => 3,
                (Verdict::Unclear, _) => continue,
            };
            if let Some(weight) = weights.get_mut(slot) {
                *weight += area;
            }
        }
        let [outward, inward, sheet, inner] = weights;
        let told = outward + inward;
        match total {
            0.0 => Verdict::Sheet,
            // A few that rays do not tell, such as the eaves of a house, go with the others.
            _ if outward >= AGREED_AREA * told && outward > rule.told() * total => Verdict::Outward,
            _ if inward >= AGREED_AREA * told && inward > rule.told() * total => Verdict::Inward,
            _ if sheet >= AGREED_AREA * total => Verdict::Sheet,
            _ if inner >= AGREED_AREA * total => Verdict::Inner,
            _ => Verdict::Unclear,
        }
    }

    fn of_face(&self, face: &Faced, rule: Rule) -> Verdict {
        let size = |[a, b, c]: &&[DVec3; 3]| (*b - *a).cross(*c - *a).length_squared();
        let Some([a, b, c]) = face.triangles.iter().max_by(|t, u| size(t).total_cmp(&size(u))) else {
            return Verdict::Unclear;
        };
        let (from, normal) = ((*a + *b + *c) / 3.0, face.area.normalize_or_zero());
        let (mut front, mut back) = (SideRays::default(), SideRays::default());
        for direction in (0..LEVEL_RAYS).map(level) {
            let side = if direction.dot(normal) > 0.0 { &mut front } else { &mut back };
            side.level.add(self.meets_odd(face.number, off(from, normal, direction), direction));
        }
        for direction in (0..STEEP_RAYS).map(steep) {
            let side = if direction.dot(normal) > 0.0 { &mut front } else { &mut back };
            side.steep.add(self.meets_odd(face.number, off(from, normal, direction), direction));
        }
        match (front.is_inside(rule), back.is_inside(rule)) {
            (Some(false), Some(true)) => Verdict::Outward,
            (Some(true), Some(false)) => Verdict::Inward,
            (Some(false), Some(false)) => Verdict::Sheet,
            (Some(true), Some(true)) => Verdict::Inner,
            _ => Verdict::Unclear,
        }
    }

    /// Whether a ray from a face meets the others an odd number of times.
    fn meets_odd(&self, own: usize, from: DVec3, direction: DVec3) -> bool {
        let met = |face: &Faced| -> usize {
            if !meets_box(from, direction, face.low, face.high) {
                return 0;
            }
            face.triangles.iter().filter(|triangle| meets(from, direction, triangle)).count()
        };
        self.faces.iter().filter(|face| face.number != own).map(met).sum::<usize>() % 2 == 1
    }
}

/// The start of a ray, off its face on the side that it goes to.
fn off(from: DVec3, normal: DVec3, direction: DVec3) -> DVec3 {
    from + OFF_M * direction.dot(normal).signum() * normal
}

/// Rays, and those of them that meet faces an odd number of times.
#[derive(Clone, Copy, Default)]
struct Rays {
    all: f64,
    odd: f64,
}

impl Rays {
    fn add(&mut self, is_odd: bool) {
        self.all += 1.0;
        self.odd += f64::from(u8::from(is_odd));
    }
}

/// What rays say of one side of a face.
#[derive(Clone, Copy, Default)]
struct SideRays {
    level: Rays,
    steep: Rays,
}

impl SideRays {
    /// Whether it is inside, if rays agree. Steep rays from outside may meet eaves, so that they only tell what is inside.
    fn is_inside(&self, rule: Rule) -> Option<bool> {
        let SideRays { level, steep } = self;
        if level.all == 0.0 {
            None
        } else if level.odd >= rule.share() * level.all && steep.odd >= rule.share() * steep.all {
            Some(true)
        } else {
            (level.odd <= (1.0 - rule.share()) * level.all).then_some(false)
        }
    }
}

/// Spread over all azimuths, rising and falling by turns.
fn level(ray: usize) -> DVec3 {
    let (around, along) = spread(ray);
    let (sin, cos) = around.sin_cos();
    DVec3::new(cos, sin, SLOPE * (2.0 * along - 1.0))
}

/// Upwards, to all sides by turns.
fn steep(ray: usize) -> DVec3 {
    let (around, along) = spread(ray);
    let (sin, cos) = around.sin_cos();
    let aside = ASIDE * (0.5 + 0.5 * along);
    DVec3::new(aside * cos, aside * sin, 1.0)
}

/// An angle around and a share of 1, evenly spread together (the R2 sequence of Roberts, 2018).
fn spread(ray: usize) -> (f64, f64) {
    let even = |step: f64| ((ray as f64 + 0.5) * step).fract();
    (std::f64::consts::TAU * even(0.754_877_666_246_693), even(0.569_840_290_998_053))
}

fn meets_box(from: DVec3, direction: DVec3, low: DVec3, high: DVec3) -> bool {
    let inverse = direction.recip();
    let (t0, t1) = ((low - from) * inverse, (high - from) * inverse);
    // A face that lies in a plane of the axes has a box without depth.
    let (enter, leave) = (t0.min(t1).max_element(), t0.max(t1).min_element());
    leave >= 0.0 && enter <= leave + 1e-6
}

/// Möller and Trumbore, "Fast, minimum storage ray-triangle intersection", 1997.
fn meets(from: DVec3, direction: DVec3, [a, b, c]: &[DVec3; 3]) -> bool {
    let (ab, ac) = (*b - *a, *c - *a);
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    if determinant == 0.0 {
        return false;
    }
    let s = (from - *a) / determinant;
    let u = s.dot(p);
    let q = s.cross(ab);
    let v = direction.dot(q);
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && ac.dot(q) > 0.0
}
