//! Check that surfaces close a volume. In: polygons of a store. Out: true if every edge is matched
//! by its opposite.

use std::collections::HashMap;

use glam::DVec3;

use crate::formats::citygml::store::{Side, Store};

/// Distance below which corners are one, metres.
const WELD_M: f64 = 1e-3;

/// Height above the lowest corner up to which edges may be open, metres: a building on open ground
/// often has no ground surface.
const GROUND_M: f64 = 1.0;

/// Largest upward component of the unit normal of a wall, up or down (sine of the angle; 17
/// degrees).
const UPRIGHT: f64 = 0.3;

/// Returns true if polygons close a volume, apart from the ground: a model without ground surfaces
/// is complete for all that light meets. A roof without walls is open, however low its eaves are.
pub(super) fn is_closed(store: &Store, sides: &[Side]) -> bool {
    // The welding grid separates corners on two sides of one of its lines; the grid shifted by half
    // a cell then joins them.
    !sides.is_empty()
        && [0.0, 0.5].into_iter().any(|shift| open_edges(store, sides, shift).is_none_or(|is_ground| is_ground))
}

/// Returns `None` if no edge is open, otherwise true if all open edges lie near the ground and most
/// of their length belongs to walls.
fn open_edges(store: &Store, sides: &[Side], shift: f64) -> Option<bool> {
    let cell = |p: DVec3| (p / WELD_M + shift).floor().to_array().map(|steps| steps as i64);
    let mut edges: HashMap<([i64; 3], [i64; 3]), Uses> = HashMap::new();
    let mut lowest = f64::INFINITY;
    for side in sides {
        let Some(polygon) = store.polygon(side.polygon) else { continue };
        let is_wall = is_upright(store, side.polygon);
        for ring in store.rings(polygon) {
            let corners: Vec<DVec3> = ring.iter().map(|corner| store.position(*corner)).collect();
            for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
                lowest = lowest.min(a.z);
                let length_m = a.distance(*b);
                let (a, b) = if side.is_reversed { (cell(*b), cell(*a)) } else { (cell(*a), cell(*b)) };
                // An edge has one key for its two directions, which count +1 and -1: opposite edges
                // cancel.
                let (ends, step) = if a < b { ((a, b), 1) } else { ((b, a), -1) };
                if a != b {
                    let uses = edges.entry(ends).or_default();
                    uses.balance += step;
                    uses.length_m = length_m;
                    uses.is_of_wall |= is_wall;
                }
            }
        }
    }
    let highest_m = ((lowest + GROUND_M) / WELD_M) as i64;
    let open: Vec<_> = edges.iter().filter(|(_, uses)| uses.balance != 0).collect();
    if open.is_empty() {
        return None;
    }
    let is_low = open.iter().all(|(([_, _, a], [_, _, b]), _)| *a <= highest_m && *b <= highest_m);
    let all_m: f64 = open.iter().map(|(_, uses)| uses.length_m).sum();
    let of_walls_m: f64 = open.iter().filter(|(_, uses)| uses.is_of_wall).map(|(_, uses)| uses.length_m).sum();
    Some(is_low && 2.0 * of_walls_m >= all_m)
}

/// Faces along an edge.
#[derive(Default)]
struct Uses {
    /// Uses in one direction less those in the other.
    balance: i32,
    length_m: f64,
    /// True if one of the faces is a wall.
    is_of_wall: bool,
}

/// Returns true if the outline of a polygon is upright.
fn is_upright(store: &Store, polygon: u32) -> bool {
    let outline = store.polygon(polygon).and_then(|polygon| store.rings(polygon).next()).unwrap_or_default();
    let at = |corner: &u32| store.position(*corner);
    let from = outline.first().map(at).unwrap_or_default();
    let normal: DVec3 = outline.array_windows::<2>().map(|[a, b]| (at(a) - from).cross(at(b) - from)).sum();
    normal.z.abs() < UPRIGHT * normal.length()
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: [[usize; 4]; 6] = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

    /// Returns a box of 10 m with some of its faces. Each face has its own corners, which lie up to
    /// 0.5 mm off.
    fn part_of_box(faces: &[usize]) -> (Store, Vec<Side>) {
        let (mut store, mut sides) = (Store::default(), Vec::new());
        for (i, face) in faces.iter().enumerate() {
            let first = store.corner_count();
            let corners = BOX[*face].map(|corner| {
                let at = [corner == 1 || corner == 2 || corner == 5 || corner == 6, corner % 4 > 1, corner > 3];
                store.push_vertex(DVec3::from(at.map(|far| if far { 10.0 } else { 0.0 })) + 1e-4 * i as f64)
            });
            store.push_ring(&corners);
            sides.push(Side { polygon: store.end_polygon(first, None, 1), is_reversed: false });
        }
        (store, sides)
    }

    /// A box is closed, also without its floor. It is not closed without its roof or a wall, with
    /// its roof alone, or with one of its 6 faces turned.
    #[test]
    fn boxes_are_closed_but_for_their_ground() {
        for (faces, expected) in [
            (&[0, 1, 2, 3, 4, 5][..], true),
            (&[1, 2, 3, 4, 5], true),
            (&[0, 2, 3, 4, 5], false),
            (&[0, 1, 2, 3, 4], false),
            (&[1], false),
            (&[], false),
        ] {
            let (store, sides) = part_of_box(faces);
            assert_eq!(is_closed(&store, &sides), expected, "{faces:?}");
        }
        let (store, mut sides) = part_of_box(&[0, 1, 2, 3, 4, 5]);
        sides[1].is_reversed = true;
        assert!(!is_closed(&store, &sides));
    }
}
