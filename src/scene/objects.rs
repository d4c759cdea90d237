//! Objects that stand in a scene twice. In: triangles and their objects. Out: pairs of objects that
//! fill the same box, most often one building in two files or at two levels of detail.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::load::ObjectTriangles;

/// Size of the cells that corners of boxes are rounded to, metres: boxes with equal cells are one.
const SAME_M: f64 = 0.5;

/// Returns the pairs of objects that fill the same box, by name. Flat objects are left out.
pub fn twins(soup: &ObjectTriangles) -> Vec<(&str, &str)> {
    let mut boxes = vec![(DVec3::INFINITY, DVec3::NEG_INFINITY); soup.object_names.len()];
    for (corners, &object) in soup.triangles.iter().zip(&soup.objects) {
        let Some((low, high)) = boxes.get_mut(object as usize) else { continue };
        for p in corners.iter().filter_map(|&corner| soup.positions.get(corner as usize)) {
            (*low, *high) = (low.min(*p), high.max(*p));
        }
    }
    let mut by_place: BTreeMap<[i64; 6], &str> = BTreeMap::new();
    let mut pairs = Vec::new();
    let mut order: Vec<(&str, (DVec3, DVec3))> =
        soup.object_names.iter().map(String::as_str).zip(boxes.iter().copied()).collect();
    order.sort_by(|a, b| a.0.cmp(b.0));
    for (name, (low, high)) in order {
        if !(high - low).cmpgt(DVec3::splat(2.0 * SAME_M)).all() {
            continue;
        }
        // The cast saturates where a coordinate is large.
        let cell = |metres: f64| (metres / SAME_M).round() as i64;
        let key = [low.x, low.y, low.z, high.x, high.y, high.z].map(cell);
        match by_place.get(&key) {
            Some(first) => pairs.push((*first, name)),
            None => drop(by_place.insert(key, name)),
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The 2 of 4 objects that fill one box are a pair; a flat one and one beside them are not.
    #[test]
    fn two_objects_that_fill_one_box_are_a_pair() {
        let mut soup = ObjectTriangles::default();
        for (name, at, size) in [("a", 0.0, 5.0), ("b", 0.1, 5.0), ("c", 9.0, 5.0), ("flat", 0.0, 0.0)] {
            let first = soup.positions.len() as u32;
            let corner = DVec3::new(at, 0.0, 0.0);
            soup.positions.extend([corner, corner + DVec3::new(5.0, 5.0, size), corner + DVec3::new(5.0, 0.0, 0.0)]);
            soup.triangles.push([first, first + 1, first + 2]);
            soup.objects.push(soup.object_names.len() as u32);
            soup.object_names.push(name.to_owned());
        }
        assert_eq!(twins(&soup), [("a", "b")]);
    }
}
