//! Grouping of receivers into points of six planes. In: receivers with their names. Out: points,
//! each with the indices of its planes.

use std::collections::HashMap;

use glam::DVec3;

use super::columns::PLANES;
use crate::surroundings::SixPlanes;
use heliotile_core::site::receiver::Receiver;

/// Largest distance between the planes of a point, metres: they may stand apart as instruments on a
/// mast do.
const MAX_APART_M: f64 = 1.0;

/// Largest error of the cosines of angles between planes: eight degrees.
const COSINE: f64 = 0.01;

/// Returns the name of the receiver of a plane. The receiver that faces up has the name of the
/// point.
pub fn receiver_name(point: &str, plane: usize) -> String {
    match PLANES.get(plane).filter(|_| plane > 0) {
        Some(side) => format!("{point}/{side}"),
        None => point.to_owned(),
    }
}

/// Returns the point of a receiver, and the number of its plane.
pub fn point_of(receiver: &str) -> (&str, usize) {
    let named = receiver.rsplit_once('/').and_then(|(point, side)| {
        let plane = PLANES.iter().skip(1).position(|name| *name == side)?;
        Some((point, plane + 1))
    });
    named.unwrap_or((receiver, 0))
}

/// Returns six values in the order of [`PLANES`]; `None` if one is missing.
pub fn all_of<T>(planes: [Option<T>; 6]) -> Option<SixPlanes<T>> {
    let [up, down, north, east, south, west] = planes;
    Some(SixPlanes { up: up?, down: down?, sides: [north?, east?, south?, west?] })
}

/// The points of some receivers, in the order of the receivers that face up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PersonPoints {
    names: Vec<String>,
    number_of: HashMap<String, usize>,
    /// `[point][plane]`: the index of its receiver.
    planes: Vec<[usize; 6]>,
}

impl PersonPoints {
    /// Returns the points of these receivers. Each must have all six planes at one place: up, down
    /// and four sides, which may be turned. The error names a plane that is missing or does not
    /// face as its name says.
    pub fn new(receivers: impl IntoIterator<Item = Receiver>) -> Result<Self, String> {
        let mut points = PersonPoints::default();
        let mut found: HashMap<String, [Option<Plane>; 6]> = HashMap::new();
        for (place, Receiver { id, position, normal, .. }) in receivers.into_iter().enumerate() {
            let (point, plane) = point_of(&id);
            if let Some(of_plane) = found.entry(point.to_owned()).or_default().get_mut(plane) {
                *of_plane = Some(Plane { place, position, normal });
            }
            if plane == 0 {
                points.number_of.insert(point.to_owned(), points.names.len());
                points.names.push(point.to_owned());
            }
        }
        for name in &points.names {
            let planes = found.remove(name).unwrap_or_default();
            let lacks = planes.iter().position(Option::is_none);
            let (Some(planes), None) = (all_of(planes), lacks) else {
                let lacking = receiver_name(name, lacks.unwrap_or(0));
                return Err(format!("point `{name}` lacks one of its six planes: there is no receiver `{lacking}`"));
            };
            if !are_planes(&planes) {
                return Err(format!(
                    "the receivers `{name}`, `{name}/down`, `{name}/north` and so on must stand at one place and \
                     face up, down and to the four sides"
                ));
            }
            let SixPlanes { up, down, sides: [north, east, south, west] } = planes;
            points.planes.push([up, down, north, east, south, west].map(|plane| plane.place));
        }
        // Planes that are left belong to no receiver that faces up.
        match found.into_keys().min() {
            Some(point) => Err(format!("point `{point}` has no receiver `{point}` that faces up")),
            None => Ok(points),
        }
    }

    /// Returns the number of points.
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// Returns true if there are no points.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// Returns the name of a point.
    pub fn name(&self, number: usize) -> &str {
        self.names.get(number).map_or("", String::as_str)
    }

    /// Returns the number of a point.
    pub fn number(&self, point: &str) -> Option<usize> {
        self.number_of.get(point).copied()
    }

    /// Returns the indices of the planes of a point among the receivers, in the order of
    /// [`PLANES`].
    pub fn planes(&self, number: usize) -> Option<&[usize; 6]> {
        self.planes.get(number)
    }
}

/// A receiver that may be a plane of a point.
#[derive(Clone, Copy, Debug)]
struct Plane {
    place: usize,
    position: DVec3,
    normal: DVec3,
}

/// Returns true if planes at one place face as their names say: up, down, and to four sides
/// clockwise, at any turn.
fn are_planes(planes: &SixPlanes<Plane>) -> bool {
    let [north, east, south, west] = planes.sides.map(|side| side.normal);
    let sides = [(north, east), (east, south), (south, west), (west, north)];
    let turn_right = sides.iter().all(|(one, next)| next.cross(*one).z > 1.0 - COSINE);
    let all = [planes.up, planes.down].into_iter().chain(planes.sides);
    let is_near = |plane: Plane| plane.position.distance(planes.up.position) <= MAX_APART_M;
    turn_right
        && planes.up.normal.z > 1.0 - COSINE
        && planes.down.normal.z < COSINE - 1.0
        && all.into_iter().all(is_near)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns two people, `a` and `b`, whose sides are turned by 15 degrees.
    fn people() -> Vec<Receiver> {
        let (sin, cos) = 15.0_f64.to_radians().sin_cos();
        let normals = [
            DVec3::Z,
            DVec3::NEG_Z,
            DVec3::new(sin, cos, 0.0),
            DVec3::new(cos, -sin, 0.0),
            DVec3::new(-sin, -cos, 0.0),
            DVec3::new(-cos, sin, 0.0),
        ];
        let receiver = |(name, place): (&str, DVec3), plane: usize| {
            Receiver::new(receiver_name(name, plane), place, normals.get(plane).copied().unwrap_or_default())
        };
        (0..6).flat_map(|plane| [("a", DVec3::ZERO), ("b", DVec3::X)].map(|of| receiver(of, plane))).collect()
    }

    /// Names of planes come back from their points and numbers. A receiver with a slash of its own
    /// is a point.
    #[test]
    fn names_of_planes_come_back() {
        for plane in 0..6 {
            assert_eq!(point_of(&receiver_name("a/b", plane)), ("a/b", plane));
        }
        assert_eq!(point_of("roof/7"), ("roof/7", 0));
    }

    /// Twelve receivers in any order are two points with their six planes. An error names a missing
    /// plane, and planes without a point.
    #[test]
    fn points_need_all_six_planes() {
        let mut people = people();
        people.reverse();
        let points = PersonPoints::new(people.clone()).expect("points");
        assert_eq!((points.len(), points.name(0), points.number("a")), (2, "b", Some(1)));
        assert_eq!(points.planes(0), Some(&[10, 8, 6, 4, 2, 0]));
        let without = |name: &str| PersonPoints::new(people.iter().filter(|of| of.id != name).cloned());
        assert!(without("a/east").is_err_and(|what| what.contains("no receiver `a/east`")));
        assert!(without("a").is_err_and(|what| what.contains("no receiver `a` that faces up")));
    }

    /// Planes that face elsewhere than their names say, or stand elsewhere than their point, are no
    /// person: 4 of 4.
    #[test]
    fn planes_that_face_elsewhere_make_no_person() {
        let refused = |change: fn(&mut [Receiver])| {
            let mut people = people();
            change(&mut people);
            PersonPoints::new(people).is_err_and(|what| what.contains("face up, down and to the four sides"))
        };
        let turned = |people: &mut [Receiver]| people.iter_mut().for_each(|of| of.normal.x *= -1.0);
        assert!(refused(turned), "east and west are changed");
        assert!(refused(|people| people.iter_mut().for_each(|of| of.normal.z *= -1.0)), "up and down are changed");
        assert!(refused(|people| people.iter_mut().for_each(|of| of.normal = DVec3::Z)), "all look up");
        assert!(
            refused(|people| people.iter_mut().take(2).for_each(|of| of.position.y += 3.0)),
            "one plane stands apart"
        );
    }
}
