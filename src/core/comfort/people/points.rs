//! Which receivers are the six planes of a point. In: names of receivers. Out: points, each with the places of its planes.

use std::collections::HashMap;

use super::columns::PLANES;
use crate::comfort::surroundings::SixPlanes;

/// Name of the receiver of a plane; the one that looks up has the name of the point.
pub fn receiver_name(point: &str, plane: usize) -> String {
    match PLANES.get(plane).filter(|_| plane > 0) {
        Some(side) => format!("{point}/{side}"),
        None => point.to_owned(),
    }
}

/// The point of a receiver, and which of its planes it is.
pub fn point_of(receiver: &str) -> (&str, usize) {
    let named = receiver.rsplit_once('/').and_then(|(point, side)| {
        let plane = PLANES.iter().skip(1).position(|name| *name == side)?;
        Some((point, plane + 1))
    });
    named.unwrap_or((receiver, 0))
}

/// Six values in the order of [`PLANES`]; `None` if one is missing.
pub fn all_of<T>(planes: [Option<T>; 6]) -> Option<SixPlanes<T>> {
    let [up, down, north, east, south, west] = planes;
    Some(SixPlanes { up: up?, down: down?, sides: [north?, east?, south?, west?] })
}

/// The points of some receivers, in the order of those that look up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PersonPoints {
    names: Vec<String>,
    number_of: HashMap<String, usize>,
    /// `[point][plane]`: the place of its receiver.
    planes: Vec<[usize; 6]>,
}

impl PersonPoints {
    /// The points of receivers with these names, each of which must have all six planes. An error: what is missing.
    pub fn of(receivers: impl IntoIterator<Item = impl AsRef<str>>) -> Result<Self, String> {
        let mut points = PersonPoints::default();
        let mut found: HashMap<String, [Option<usize>; 6]> = HashMap::new();
        for (place, receiver) in receivers.into_iter().enumerate() {
            let (point, plane) = point_of(receiver.as_ref());
            if let Some(of_plane) = found.entry(point.to_owned()).or_default().get_mut(plane) {
                *of_plane = Some(place);
            }
            if plane == 0 {
                points.number_of.insert(point.to_owned(), points.names.len());
                points.names.push(point.to_owned());
            }
        }
        for name in &points.names {
            let planes = found.remove(name).unwrap_or_default();
            let mut whole = [0; 6];
            for (plane, (to, place)) in whole.iter_mut().zip(planes).enumerate() {
                let missing = || {
                    let lacking = receiver_name(name, plane);
                    format!("receiver `{name}` is no point with six planes: `{lacking}` is not there")
                };
                *to = place.ok_or_else(missing)?;
            }
            points.planes.push(whole);
        }
        match found.into_keys().min() {
            Some(point) => Err(format!("point `{point}` has no receiver `{point}` that looks up")),
            None => Ok(points),
        }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// Name of a point.
    pub fn name(&self, number: usize) -> &str {
        self.names.get(number).map_or("", String::as_str)
    }

    /// The number of a point.
    pub fn number(&self, point: &str) -> Option<usize> {
        self.number_of.get(point).copied()
    }

    /// Places of the planes of a point among the receivers, in the order of [`PLANES`].
    pub fn planes(&self, number: usize) -> Option<&[usize; 6]> {
        self.planes.get(number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names of planes go there and back; a receiver with a slash of its own is a point.
    #[test]
    fn names() {
        for plane in 0..6 {
            assert_eq!(point_of(&receiver_name("a/b", plane)), ("a/b", plane));
        }
        assert_eq!(point_of("roof/7"), ("roof/7", 0));
    }

    /// Twelve receivers in any order are two points with their six planes; one without a plane, and planes without a point, are told of by name.
    #[test]
    fn whole_points() {
        let mut names: Vec<String> =
            (0..6).flat_map(|plane| ["a", "b"].map(|name| receiver_name(name, plane))).collect();
        names.reverse();
        let points = PersonPoints::of(&names).expect("points");
        assert_eq!((points.len(), points.name(0), points.number("a")), (2, "b", Some(1)));
        assert_eq!(points.planes(0), Some(&[10, 8, 6, 4, 2, 0]));
        let lacks = PersonPoints::of(names.iter().filter(|name| *name != "a/east"));
        assert!(lacks.is_err_and(|what| what.contains("`a/east` is not there")));
        let lost = PersonPoints::of(names.iter().filter(|name| *name != "a"));
        assert!(lost.is_err_and(|what| what.contains("no receiver `a` that looks up")));
    }
}
