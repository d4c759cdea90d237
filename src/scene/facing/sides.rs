//! Rays that find the outside of faces. In: the faces of one object. Out: a verdict for a patch of
//! them.
//!
//! A ray that starts outside of a solid meets its faces an even number of times, one that starts
//! inside an odd number, however the faces are turned. Most rays are nearly level, because many
//! houses have no floor and few have no walls. Some rays rise steeply: a street has walls on both
//! sides as a house has, but no roof. Most rays have to agree, so that gaps do not matter (after
//! Takayama, Jacobson, Kavan, Sorkine-Hornung, "A simple method for correcting facet orientations
//! in polygon meshes based on ray casting", JCGT 3(4), 2014, which counts the free paths of such
//! rays).

use glam::DVec3;

use crate::geometry::Geometry;
use crate::polygon::triangles_of;

/// Verdict of the rays on a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// The front of the first face is outside: the side from which it turns counter-clockwise.
    Outward,
    /// The front of the first face is inside.
    Inward,
    /// Front and back are outside.
    Sheet,
    /// Front and back are inside.
    Inner,
    /// The rays disagree.
    Unclear,
}

/// Numbers of nearly level rays and of steep rays of a face.
const LEVEL_RAYS: usize = 24;
const STEEP_RAYS: usize = 8;
/// Largest slope of level rays, metres up or down a metre.
const SLOPE: f64 = 0.2;
/// Largest offset of steep rays to the side, metres a metre.
const ASIDE: f64 = 0.05;
/// Number of the largest faces of a patch from which rays start.
const ASKED: usize = 9;
/// Share of the rays of one side that have to agree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// Six of ten: where faces disagree, one of two answers is right.
    Most,
    /// Nine of ten: where only rays contradict the file.
    All,
}

impl Rule {
    fn share(self) -> f64 {
        if self == Rule::Most { 0.6 } else { 0.9 }
    }

    /// Returns the least share of the area for which rays have to give a result.
    fn told(self) -> f64 {
        if self == Rule::Most { 0.3 } else { 0.6 }
    }
}

/// Least share of the area with a result that has to agree.
const AGREED_AREA: f64 = 0.8;
/// Distance of the start of a ray from its face, metres: other faces may lie in the plane of the
/// face.
const OFF_M: f64 = 1e-3;
/// Most tests of a ray and a triangle for one patch, some seconds; larger patches count as sheets.
const MAX_TESTS: usize = 300_000_000;

/// A face as rays meet it.
struct Faced {
    number: usize,
    triangles: Vec<[DVec3; 3]>,
    low: DVec3,
    high: DVec3,
    /// Area vector: along the normal, as long as the area.
    area: DVec3,
}

/// Faces of an object, ready for rays.
pub(super) struct Sides {
    faces: Vec<Faced>,
    /// Face numbers with their places in `faces`, sorted by number.
    places: Vec<(usize, usize)>,
    /// Number of triangles of all faces.
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

    /// Returns the verdict of the largest faces of a patch. Each face comes with true if it is
    /// turned against the first one.
    pub fn verdict(&self, patch: &[(usize, bool)], rule: Rule) -> Verdict {
        let place = |face: usize| self.places.binary_search_by_key(&face, |(number, _)| *number).ok();
        let found = patch.iter().filter_map(|(face, against)| {
            let (_, place) = self.places.get(place(*face)?)?;
            Some((self.faces.get(*place)?, *against))
        });
        let mut asked: Vec<(&Faced, bool)> = found.filter(|(face, _)| face.area.length_squared() > 0.0).collect();
        // Sorted by size and then by position, so that the order in the file does not matter.
        asked.sort_by(|(a, _), (b, _)| {
            let size = b.area.length().total_cmp(&a.area.length());
            size.then(heliotile_core::site::morton::lexicographic(a.low + a.high, b.low + b.high))
        });
        asked.truncate(ASKED);
        if self.triangles * (LEVEL_RAYS + STEEP_RAYS) * asked.len() > MAX_TESTS {
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
            // Faces without a result, such as the eaves of a house, follow the others.
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

    /// Returns true if a ray from a face meets the other faces an odd number of times.
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

/// Returns the start of a ray, off its face on the side that the ray goes to.
fn off(from: DVec3, normal: DVec3, direction: DVec3) -> DVec3 {
    from + OFF_M * direction.dot(normal).signum() * normal
}

/// Count of rays, and of rays that meet faces an odd number of times.
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

/// Results of the rays of one side of a face.
#[derive(Clone, Copy, Default)]
struct SideRays {
    level: Rays,
    steep: Rays,
}

impl SideRays {
    /// Returns true if the side is inside, false if outside, and `None` if the rays disagree. Steep
    /// rays from outside may meet eaves, so that they only confirm an inside.
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

/// Returns the direction of a nearly level ray; rays are spread over all azimuths, rising and
/// falling in turn.
fn level(ray: usize) -> DVec3 {
    let (around, along) = spread(ray);
    let (sin, cos) = around.sin_cos();
    DVec3::new(cos, sin, SLOPE * (2.0 * along - 1.0))
}

/// Returns the direction of a steep ray; rays lean to all sides in turn.
fn steep(ray: usize) -> DVec3 {
    let (around, along) = spread(ray);
    let (sin, cos) = around.sin_cos();
    let aside = ASIDE * (0.5 + 0.5 * along);
    DVec3::new(aside * cos, aside * sin, 1.0)
}

/// Returns an angle around and a share of 1, evenly spread together (the R2 sequence of Roberts,
/// 2018).
fn spread(ray: usize) -> (f64, f64) {
    // Steps of 1 / p and 1 / p^2, where p^3 = p + 1.
    let even = |step: f64| ((ray as f64 + 0.5) * step).fract();
    (std::f64::consts::TAU * even(0.754_877_666_246_693), even(0.569_840_290_998_053))
}

fn meets_box(from: DVec3, direction: DVec3, low: DVec3, high: DVec3) -> bool {
    let inverse = direction.recip();
    let (t0, t1) = ((low - from) * inverse, (high - from) * inverse);
    // A face in a plane of the axes has a box without depth.
    let (enter, leave) = (t0.min(t1).max_element(), t0.max(t1).min_element());
    leave >= 0.0 && enter <= leave + 1e-6
}

/// Returns true if a ray meets a triangle (Möller and Trumbore, "Fast, minimum storage ray-triangle
/// intersection", 1997).
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
