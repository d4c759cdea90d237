//! Connected faces. In: faces of one object. Out: shells of faces connected by edges, and true for
//! sound shells; and the patches of a shell, in which the orientation of each face relative to the
//! first one is known.

use std::collections::{HashSet, VecDeque};

use glam::DVec3;

use super::twins;
use crate::geometry::Geometry;
use crate::mesh::bounds;
use crate::polygon::area_vector_of;

/// Faces of an object that are connected by their edges.
pub(super) struct Shell {
    /// Numbers of faces, ascending.
    pub faces: Vec<usize>,
    /// Corners of the bounding box.
    pub low: DVec3,
    pub high: DVec3,
    /// True if each edge is used as often in one direction as in the other, and the enclosed volume
    /// is positive.
    pub is_balanced: bool,
    /// True if an edge belongs to more than two faces.
    pub is_crowded: bool,
    /// True if the faces certainly look outwards: each edge is used as often in one direction as in
    /// the other, no face occurs twice, and the shell encloses a positive volume.
    pub is_sound: bool,
}

/// Faces of a shell that meet in pairs at their edges.
pub(super) struct Patch {
    /// Number of each face, and true if it is turned against the first one in the file.
    pub faces: Vec<(usize, bool)>,
    /// True if each edge belongs to two faces of the patch.
    pub is_closed: bool,
}

impl Patch {
    /// Returns true if all faces have one orientation in the file.
    pub fn agrees(&self) -> bool {
        self.faces.iter().all(|(_, against)| !against)
    }

    /// Returns the share of the area of faces that are turned against the first one.
    pub fn share_against(&self, geometry: &Geometry) -> f64 {
        let (mut against_m2, mut all_m2) = (0.0, 0.0);
        for (face, against) in &self.faces {
            let area = geometry.polygon(*face).map(|face| area_vector_of(&face, &geometry.vertices).length());
            all_m2 += area.unwrap_or_default();
            against_m2 += if *against { area.unwrap_or_default() } else { 0.0 };
        }
        if all_m2 > 0.0 { against_m2 / all_m2 } else { 0.0 }
    }

    /// Returns the numbers of the faces.
    pub fn numbers(&self) -> impl Iterator<Item = usize> {
        self.faces.iter().map(|(face, _)| *face)
    }

    /// Returns the volume enclosed if all faces are turned as the first one is, m3; negative if the
    /// first one looks inwards.
    pub fn volume(&self, geometry: &Geometry) -> f64 {
        let from = origin(geometry, self.faces.iter().map(|(face, _)| *face));
        let signed = |(face, against): &(usize, bool)| {
            let volume = volume_below(geometry, *face, from);
            if *against { -volume } else { volume }
        };
        self.faces.iter().map(signed).sum()
    }
}

/// An edge of a face, from the lesser rank to the greater.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Edge {
    ends: (u32, u32),
    /// Index in the list of faces.
    face: usize,
    /// True if the face runs from the greater rank to the lesser.
    backwards: bool,
}

/// Returns all edges of some faces, sorted.
fn edges_of(geometry: &Geometry, welded: &[u32], faces: &[usize]) -> Vec<Edge> {
    let rank = |corner: &u32| welded.get(*corner as usize).copied().unwrap_or_default();
    let mut edges = Vec::with_capacity(4 * faces.len());
    for (place, polygon) in faces.iter().enumerate().filter_map(|(i, &face)| Some((i, geometry.polygon(face)?))) {
        for ring in polygon.rings() {
            let after = ring.iter().cycle().skip(1);
            for (a, b) in ring.iter().map(rank).zip(after.map(rank)).filter(|(a, b)| a != b) {
                edges.push(Edge { ends: (a.min(b), a.max(b)), face: place, backwards: a > b });
            }
        }
    }
    edges.sort_unstable();
    edges
}

/// Returns the shells of an object.
pub(super) fn shells(geometry: &Geometry, welded: &[u32], faces: &[usize]) -> Vec<Shell> {
    let edges = edges_of(geometry, welded, faces);
    let mut roots: Vec<usize> = (0..faces.len()).collect();
    let (mut is_balanced, mut is_crowded) = (vec![true; faces.len()], vec![false; faces.len()]);
    for at_edge in edges.chunk_by(|a, b| a.ends == b.ends) {
        let balanced = 2 * at_edge.iter().filter(|edge| edge.backwards).count() == at_edge.len();
        let Some(first) = at_edge.first() else { continue };
        for edge in at_edge {
            join(&mut roots, first.face, edge.face);
            if let (Some(balance), Some(crowd)) = (is_balanced.get_mut(edge.face), is_crowded.get_mut(edge.face)) {
                *balance &= balanced;
                *crowd |= at_edge.len() > 2;
            }
        }
    }
    let mut by_root: Vec<(usize, usize)> = (0..faces.len()).map(|place| (root(&mut roots, place), place)).collect();
    by_root.sort_unstable();
    let shell = |members: &[(usize, usize)]| {
        let places = || members.iter().map(|(_, place)| *place);
        let is = |flags: &[bool], place: usize| flags.get(place) == Some(&true);
        let faces: Vec<usize> = places().filter_map(|place| faces.get(place).copied()).collect();
        let polygons = faces.iter().filter_map(|&face| geometry.polygon(face));
        let corners = polygons.flat_map(|polygon| polygon.corners());
        let (low, high) = bounds(corners.filter_map(|&corner| geometry.vertices.get(corner as usize)).copied());
        let is_balanced =
            faces.len() > 3 && places().all(|place| is(&is_balanced, place)) && encloses(geometry, &faces);
        let is_crowded = places().any(|place| is(&is_crowded, place));
        // Faces that occur twice make edges of more than two faces: only there are repeats
        // searched.
        let is_sound = is_balanced && !(is_crowded && has_repeats(geometry, welded, &faces));
        Shell { faces, low, high, is_balanced, is_crowded, is_sound }
    };
    by_root.chunk_by(|a, b| a.0 == b.0).map(shell).collect()
}

/// Returns the places in a list of the pairs of faces that alone meet at an edge, in opposite
/// directions.
pub(super) fn pairs_of_one_edge(geometry: &Geometry, welded: &[u32], faces: &[usize]) -> Vec<(usize, usize)> {
    let edges = edges_of(geometry, welded, faces);
    let pair = |at_edge: &[Edge]| match at_edge {
        [a, b] if a.face != b.face && a.backwards != b.backwards => Some((a.face, b.face)),
        _ => None,
    };
    edges.chunk_by(|a, b| a.ends == b.ends).filter_map(pair).collect()
}

/// Share of the volumes below all faces; less is a rounding error of a volume of zero.
const NO_VOLUME: f64 = 1e-9;

/// Returns true if the volume that faces enclose is positive.
fn encloses(geometry: &Geometry, faces: &[usize]) -> bool {
    let from = origin(geometry, faces.iter().copied());
    let (mut volume, mut all) = (0.0, 0.0);
    for below in faces.iter().map(|&face| volume_below(geometry, face, from)) {
        volume += below;
        all += below.abs();
    }
    volume > NO_VOLUME * all
}

/// Returns true if a face occurs twice in one orientation, as two of three equal faces must.
fn has_repeats(geometry: &Geometry, welded: &[u32], faces: &[usize]) -> bool {
    let twins = twins::within(geometry, welded, faces);
    let stand_for: HashSet<usize> = twins.iter().map(|twin| twin.of).collect();
    stand_for.len() < twins.len() || twins.iter().any(|twin| !twin.reversed)
}

/// Returns the first of the faces connected to a face, and shortens the path to it.
fn root(roots: &mut [usize], mut place: usize) -> usize {
    while let Some(&above) = roots.get(place).filter(|above| **above != place) {
        let next = roots.get(above).copied().unwrap_or(above);
        if let Some(slot) = roots.get_mut(place) {
            *slot = next;
        }
        place = above;
    }
    place
}

fn join(roots: &mut [usize], a: usize, b: usize) {
    let (a, b) = (root(roots, a), root(roots, b));
    if let Some(slot) = roots.get_mut(a.max(b)) {
        *slot = a.min(b);
    }
}

/// Returns the patches of faces. A patch ends at edges where more than two faces meet; a patch that
/// contradicts itself is cut into single faces.
pub(super) fn patches(geometry: &Geometry, welded: &[u32], faces: &[usize]) -> Vec<Patch> {
    let edges = edges_of(geometry, welded, faces);
    let count = faces.len();
    // Neighbours of each face, and true for those that are turned against it.
    let mut beside: Vec<Vec<(usize, bool)>> = vec![Vec::new(); count];
    let mut is_open = vec![false; count];
    for at_edge in edges.chunk_by(|a, b| a.ends == b.ends) {
        match at_edge {
            [a, b] if a.face != b.face => {
                let against = a.backwards == b.backwards;
                for (from, to) in [(a.face, b.face), (b.face, a.face)] {
                    if let Some(list) = beside.get_mut(from) {
                        list.push((to, against));
                    }
                }
            }
            // Both sides of a slit that leads to a hole.
            [a, b] if a.backwards != b.backwards => {}
            _ => at_edge.iter().for_each(|edge| {
                if let Some(slot) = is_open.get_mut(edge.face) {
                    *slot = true;
                }
            }),
        }
    }
    let number = |place: usize| faces.get(place).copied().unwrap_or_default();
    let mut turns: Vec<Option<bool>> = vec![None; count];
    let mut list = Vec::new();
    for first in 0..count {
        if turns.get(first) != Some(&None) {
            continue;
        }
        let (mut members, mut next, mut contradicts) = (Vec::new(), VecDeque::from([(first, false)]), false);
        while let Some((face, against)) = next.pop_front() {
            match turns.get_mut(face) {
                Some(slot @ None) => *slot = Some(against),
                Some(Some(known)) => {
                    contradicts |= *known != against;
                    continue;
                }
                None => continue,
            }
            members.push((face, against));
            let neighbours = beside.get(face).map(Vec::as_slice).unwrap_or_default();
            next.extend(neighbours.iter().map(|(other, turned)| (*other, *turned != against)));
        }
        let is_closed = !members.iter().any(|(face, _)| is_open.get(*face) == Some(&true));
        let members = members.into_iter().map(|(place, against)| (number(place), against));
        if contradicts {
            list.extend(members.map(|(face, _)| Patch { faces: vec![(face, false)], is_closed: false }));
        } else {
            list.push(Patch { faces: members.collect(), is_closed });
        }
    }
    list
}

/// Returns a corner near all faces: sums of products of far coordinates would lose digits.
fn origin(geometry: &Geometry, faces: impl Iterator<Item = usize>) -> DVec3 {
    let corner = faces.filter_map(|face| geometry.polygon(face)).find_map(|polygon| polygon.corners().first().copied());
    corner.and_then(|corner| geometry.vertices.get(corner as usize).copied()).unwrap_or_default()
}

/// Returns the volume of the cone from a point to a face, m3; positive if the face looks away from
/// the point.
fn volume_below(geometry: &Geometry, face: usize, from: DVec3) -> f64 {
    let Some(polygon) = geometry.polygon(face) else { return 0.0 };
    let corner = |corner: &u32| geometry.vertices.get(*corner as usize).copied().unwrap_or_default() - from;
    let outline = polygon.rings().next().unwrap_or_default();
    let middle = outline.iter().map(corner).sum::<DVec3>() / outline.len().max(1) as f64;
    middle.dot(area_vector_of(&polygon, &geometry.vertices)) / 3.0
}
