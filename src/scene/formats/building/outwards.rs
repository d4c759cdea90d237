//! Faces of rooms that look inwards. In: all outlines that bound one room, including those to its
//! neighbours. Out: the faces whose normal points into the room, if the room is closed or nearly
//! so.
//!
//! A ray from a point of a face of a closed room crosses an odd number of its other faces on the
//! inner side, and an even number on the outer side. This holds for any winding of the faces, and
//! also if their corners do not meet.

use glam::{DVec2, DVec3};

use crate::formats::building::frame::area_vector;

/// Most faces of a room that is examined: the search takes time with the square of the number.
const MAX_FACES: usize = 4_000;
/// Directions of the rays, oblique to the usual directions of buildings.
const LINES: [DVec3; 5] = [
    DVec3::new(0.613, 0.377, 0.694),
    DVec3::new(-0.421, 0.811, 0.406),
    DVec3::new(0.259, -0.552, 0.793),
    DVec3::new(0.883, -0.287, -0.371),
    DVec3::new(-0.337, -0.449, 0.828),
];
/// Fewest rays that must agree that a face looks in or out; where fewer agree, the room is open.
const AGREED: usize = 4;
/// Share of a room's area that must be known to look in or out, for the room to count as closed.
const CLOSED_SHARE: f64 = 0.9;
/// Cosine below which a ray is too flat to a face to decide anything.
const FLAT: f64 = 1e-3;

/// A flat face of a room.
struct Panel {
    /// Unit normal.
    normal: DVec3,
    area_m2: f64,
    origin: DVec3,
    axes: [DVec3; 2],
    /// Outline and holes, along the axes.
    rings: Vec<Vec<DVec2>>,
    /// A point on the face, in space.
    inner: DVec3,
}

#[derive(Clone, Copy, PartialEq)]
enum Facing {
    Out,
    In,
    Unknown,
}

/// Returns the indices of the faces that look into their room; none if the room is not closed. A
/// face is its outline, followed by its holes.
pub(in crate::formats) fn facing_inwards(faces: &[Vec<&[DVec3]>]) -> Vec<usize> {
    if faces.len() > MAX_FACES {
        return Vec::new();
    }
    let panels: Vec<Option<Panel>> = faces.iter().map(|rings| Panel::new(rings)).collect();
    // One ray per face is enough to see that a room is as it should be.
    let first = LINES.get(..1).unwrap_or_default();
    let doubted = (0..panels.len()).any(|i| facing(&panels, i, first, 1) == Facing::In);
    if !doubted {
        return Vec::new();
    }
    let found: Vec<Facing> = (0..panels.len()).map(|i| facing(&panels, i, &LINES, AGREED)).collect();
    let area = |wanted: fn(Facing) -> bool| -> f64 {
        let of = panels.iter().zip(&found).filter(|(_, facing)| wanted(**facing));
        of.filter_map(|(panel, _)| panel.as_ref()).map(|panel| panel.area_m2).sum()
    };
    if area(|facing| facing != Facing::Unknown) < CLOSED_SHARE * area(|_| true) {
        return Vec::new();
    }
    found.iter().enumerate().filter(|(_, facing)| **facing == Facing::In).map(|(i, _)| i).collect()
}

/// Returns where a face looks, if at least `agreed` rays agree and none contradicts.
fn facing(panels: &[Option<Panel>], number: usize, lines: &[DVec3], agreed: usize) -> Facing {
    let Some(Some(panel)) = panels.get(number) else { return Facing::Unknown };
    let (mut out, mut inwards) = (0, 0);
    for line in lines {
        let along = line.dot(panel.normal);
        if along.abs() < FLAT {
            continue;
        }
        let outwards = if along > 0.0 { *line } else { -*line };
        let (mut before, mut behind) = (0_usize, 0_usize);
        for (_, other) in panels.iter().enumerate().filter(|(i, _)| *i != number) {
            match other.as_ref().and_then(|other| other.met(panel.inner, outwards)) {
                Some(distance) if distance > 0.0 => before += 1,
                Some(_) => behind += 1,
                None => {}
            }
        }
        // Equal parities mean a gap in the room: the ray decides nothing.
        match (before % 2, behind % 2) {
            (0, 1) => out += 1,
            (1, 0) => inwards += 1,
            _ => {}
        }
    }
    match (out, inwards) {
        (count, 0) if count >= agreed => Facing::Out,
        (0, count) if count >= agreed => Facing::In,
        _ => Facing::Unknown,
    }
}

impl Panel {
    fn new(rings: &[&[DVec3]]) -> Option<Panel> {
        let outline = *rings.first()?;
        let vector = area_vector(outline);
        let normal = vector.try_normalize()?;
        let origin = outline.iter().sum::<DVec3>() / outline.len() as f64;
        let (right, up) = normal.any_orthonormal_pair();
        let flat = |p: &DVec3| DVec2::new((*p - origin).dot(right), (*p - origin).dot(up));
        let rings: Vec<Vec<DVec2>> = rings.iter().map(|ring| ring.iter().map(flat).collect()).collect();
        let inner = inner_point(&rings)?;
        let inner = origin + inner.x * right + inner.y * up;
        Some(Panel { normal, area_m2: vector.length(), origin, axes: [right, up], rings, inner })
    }

    /// Returns the distance along a line at which it meets the face; negative behind its start.
    fn met(&self, start: DVec3, line: DVec3) -> Option<f64> {
        let along = line.dot(self.normal);
        if along.abs() < 1e-12 {
            return None;
        }
        let distance = (self.origin - start).dot(self.normal) / along;
        let at = start + distance * line - self.origin;
        is_within(&self.rings, DVec2::new(at.dot(self.axes[0]), at.dot(self.axes[1]))).then_some(distance)
    }
}

fn edges(rings: &[Vec<DVec2>]) -> impl Iterator<Item = (DVec2, DVec2)> + '_ {
    rings.iter().flat_map(|ring| ring.iter().copied().zip(ring.iter().copied().cycle().skip(1)))
}

/// Returns true if `p` lies inside the outline and outside the holes.
fn is_within(rings: &[Vec<DVec2>], p: DVec2) -> bool {
    crossings(rings, p.y).filter(|x| *x > p.x).count() % 2 == 1
}

/// Returns the x at which edges cross a height.
fn crossings(rings: &[Vec<DVec2>], y: f64) -> impl Iterator<Item = f64> + '_ {
    let crossed = edges(rings).filter(move |(a, b)| (a.y > y) != (b.y > y));
    crossed.map(move |(a, b)| (b.x - a.x) * (y - a.y) / (b.y - a.y) + a.x)
}

/// Returns a point well inside: halfway up the highest gap between corners, in the middle of the
/// widest stretch there.
fn inner_point(rings: &[Vec<DVec2>]) -> Option<DVec2> {
    let mut heights: Vec<f64> = rings.iter().flatten().map(|p| p.y).collect();
    heights.sort_by(f64::total_cmp);
    let gaps = heights.iter().zip(heights.iter().skip(1));
    let (low, high) = gaps.max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)))?;
    let y = 0.5 * (low + high);
    let mut places: Vec<f64> = crossings(rings, y).collect();
    places.sort_by(f64::total_cmp);
    let stretches = places.chunks_exact(2).filter_map(|two| Some((*two.first()?, *two.last()?)));
    let (from, to) = stretches.max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)))?;
    Some(DVec2::new(0.5 * (from + to), y))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of 4 x 3 x 2 m, faces outwards. Its floor is cut in two, with corners that do not meet
    /// those of the walls.
    fn room() -> Vec<Vec<DVec3>> {
        let corners = |list: [[f64; 3]; 4]| list.map(DVec3::from_array).to_vec();
        vec![
            corners([[0., 0., 0.], [4., 0., 0.], [4., 0., 2.], [0., 0., 2.]]),
            corners([[4., 0., 0.], [4., 3., 0.], [4., 3., 2.], [4., 0., 2.]]),
            corners([[4., 3., 0.], [0., 3., 0.], [0., 3., 2.], [4., 3., 2.]]),
            corners([[0., 3., 0.], [0., 0., 0.], [0., 0., 2.], [0., 3., 2.]]),
            corners([[0., 0., 2.], [4., 0., 2.], [4., 3., 2.], [0., 3., 2.]]),
            corners([[0., 0., 0.], [0., 3., 0.], [1.5, 3., 0.], [1.5, 0., 0.]]),
            corners([[1.5, 0., 0.], [1.5, 3., 0.], [4., 3., 0.], [4., 0., 0.]]),
        ]
    }

    fn inwards(room: &[Vec<DVec3>]) -> Vec<usize> {
        facing_inwards(&room.iter().map(|face| vec![face.as_slice()]).collect::<Vec<_>>())
    }

    /// In a room of 7 faces, exactly the faces that look inwards are found: none, one, two and
    /// all 7. Without its ceiling, none of the other 6 is found.
    #[test]
    fn inward_faces_of_a_closed_room_are_found() {
        for turned in [vec![], vec![1], vec![0, 6], (0..7).collect()] {
            let mut room = room();
            turned.iter().for_each(|i: &usize| room[*i].reverse());
            assert_eq!(inwards(&room), turned);
            room.remove(4);
            assert_eq!(inwards(&room), Vec::<usize>::new());
        }
    }

    /// The 4 walls of a court of 1 m2 look into the court, which is outdoors; floor and ceiling are
    /// rings. With all 10 faces turned, all 10 are found.
    #[test]
    fn a_court_is_outdoors() {
        let square = |low: f64, high: f64, z: f64| {
            [[low, low], [high, low], [high, high], [low, high]].map(|[x, y]| DVec3::new(x, y, z)).to_vec()
        };
        let (outer, inner) =
            ([square(0.0, 3.0, 0.0), square(0.0, 3.0, 2.0)], [square(1.0, 2.0, 0.0), square(1.0, 2.0, 2.0)]);
        let mut walls = Vec::new();
        for i in 0..4 {
            let next = (i + 1) % 4;
            walls.push(vec![outer[0][i], outer[0][next], outer[1][next], outer[1][i]]);
            walls.push(vec![inner[0][next], inner[0][i], inner[1][i], inner[1][next]]);
        }
        let floor: Vec<DVec3> = outer[0].iter().rev().copied().collect();
        let all = |walls: &[Vec<DVec3>], floor: &[DVec3], ceiling: &[DVec3]| {
            let mut faces: Vec<Vec<&[DVec3]>> = walls.iter().map(|wall| vec![wall.as_slice()]).collect();
            faces.push(vec![floor, &inner[0]]);
            faces.push(vec![ceiling, &inner[1]]);
            facing_inwards(&faces)
        };
        assert_eq!(all(&walls, &floor, &outer[1]), Vec::<usize>::new());
        walls.iter_mut().for_each(|wall| wall.reverse());
        let ceiling: Vec<DVec3> = outer[1].iter().rev().copied().collect();
        assert_eq!(all(&walls, &outer[0], &ceiling), (0..10).collect::<Vec<_>>());
    }
}
