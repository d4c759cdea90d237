//! Faces and objects that occur twice. In: faces with the ranks of their corners' positions. Out:
//! the faces that may be left out.

use std::collections::{BTreeMap, HashMap};

use crate::geometry::Geometry;

/// A face with the corners of another face of its object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Twin {
    pub face: usize,
    /// Face that stays.
    pub of: usize,
    /// True if the two faces are turned opposite ways.
    pub reversed: bool,
}

/// Shape of a face, equal for twins: all rings, each beginning at its least corner and taken in its
/// lesser direction.
type Shape = Vec<Vec<u32>>;

/// Returns all faces but one of each set of faces of one object with the same corners. The one that
/// stays has a kind, if one of them has, and the alphabetically first material.
pub(super) fn within(geometry: &Geometry, welded: &[u32], faces: &[usize]) -> Vec<Twin> {
    let mut by_shape: HashMap<Shape, Vec<(usize, bool)>> = HashMap::with_capacity(faces.len());
    for &face in faces {
        if let Some((shape, reversed)) = shape(geometry, welded, face) {
            by_shape.entry(shape).or_default().push((face, reversed));
        }
    }
    let mut found = Vec::new();
    for mut alike in by_shape.into_values().filter(|alike| alike.len() > 1) {
        alike.sort_by_key(|(face, reversed)| (preference(geometry, *face), *reversed, *face));
        let Some(((of, turned), rest)) = alike.split_first() else { continue };
        found.extend(rest.iter().map(|(face, reversed)| Twin { face: *face, of: *of, reversed: reversed != turned }));
    }
    found.sort_unstable_by_key(|twin| twin.face);
    found
}

fn preference(geometry: &Geometry, face: usize) -> (bool, String) {
    let kind = geometry.note_of(face).kind;
    let material = geometry.polygon(face).map(|face| face.material).unwrap_or_default();
    let name = geometry.materials.as_slice().get(material as usize).cloned().unwrap_or_default();
    (kind.is_none(), name)
}

/// Returns the faces of objects all of whose faces also occur in other objects, turned the same
/// way: a building beside the parts that it is made of, or the object whose name comes last.
pub(super) fn whole_objects(geometry: &Geometry, welded: &[u32], dropped: &[bool]) -> Vec<usize> {
    let mut objects: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    let mut holders: HashMap<(Shape, bool), Vec<u32>> = HashMap::new();
    let kept = |face: usize| dropped.get(face) == Some(&false);
    for face in geometry.faces().filter(|face| kept(face.number)) {
        objects.entry(face.object).or_default().push(face.number);
    }
    if objects.len() < 2 {
        return Vec::new();
    }
    for (&object, faces) in &objects {
        for &face in faces {
            if let Some(key) = shape(geometry, welded, face) {
                holders.entry(key).or_default().push(object);
            }
        }
    }
    let others = |object: u32, face: usize| -> Vec<u32> {
        let key = shape(geometry, welded, face);
        let all = key.and_then(|key| holders.get(&key)).map(Vec::as_slice).unwrap_or_default();
        all.iter().copied().filter(|other| *other != object).collect()
    };
    let name = |object: u32| geometry.objects.as_slice().get(object as usize).map(String::as_str).unwrap_or_default();
    let is_part_of = |part: u32, whole: u32| {
        geometry.object_notes.get(&part).is_some_and(|note| note.building == name(whole)) && name(part) != name(whole)
    };
    let mut left_out = Vec::new();
    for (&object, faces) in &objects {
        let in_parts = || faces.iter().all(|&face| others(object, face).iter().any(|other| is_part_of(*other, object)));
        let stands_before = |other: &u32| {
            !is_part_of(object, *other)
                && objects.get(other).is_some_and(|other_faces| other_faces.len() == faces.len())
                && name(*other) < name(object)
                && faces.iter().all(|&face| others(object, face).contains(other))
        };
        let first = faces.first().map(|&face| others(object, face)).unwrap_or_default();
        // A single face, such as a window or a panel, may be meant.
        if !first.is_empty() && faces.len() > 1 && (in_parts() || first.iter().any(stands_before)) {
            left_out.extend(faces);
        }
    }
    left_out
}

/// Returns the shape of a face, and true if its outline had to be reversed; `None` for a face with
/// a ring of fewer than three corners.
fn shape(geometry: &Geometry, welded: &[u32], face: usize) -> Option<(Shape, bool)> {
    let polygon = geometry.polygon(face)?;
    let mut rings = Vec::with_capacity(1);
    let mut turned = false;
    for (i, ring) in polygon.rings().enumerate() {
        let mut ranks: Vec<u32> =
            ring.iter().map(|&corner| welded.get(corner as usize).copied().unwrap_or_default()).collect();
        ranks.dedup();
        while ranks.len() > 1 && ranks.first() == ranks.last() {
            ranks.pop();
        }
        if ranks.len() < 3 {
            return None;
        }
        let forward = from_least(&ranks);
        ranks.reverse();
        let backward = from_least(&ranks);
        if i == 0 {
            turned = backward < forward;
        }
        rings.push(forward.min(backward));
    }
    if let Some(holes) = rings.get_mut(1..) {
        holes.sort_unstable();
    }
    Some((rings, turned))
}

fn from_least(ranks: &[u32]) -> Vec<u32> {
    let least = ranks.iter().enumerate().min_by_key(|(_, rank)| **rank).map_or(0, |(place, _)| place);
    let mut turned = ranks.to_vec();
    turned.rotate_left(least);
    turned
}
