//! Surfaces that receivers are put on. In: a scene's triangles and the objects that they belong to.
//! Out: surfaces with names. A surface consists of neighbouring triangles of one object and one
//! material in one plane; terrain is one surface. The order of files, objects and faces does not
//! matter, and neither does the way faces are cut into triangles (except for the order of ties).

use crate::materials::select::class_of_name;
use std::collections::{BTreeMap, HashMap};
use std::ops::Range;

use glam::DVec3;

use crate::load::ObjectTriangles;
use heliotile_core::site::material::{Class, Material};
use heliotile_core::site::model_part::ModelPart;
use heliotile_core::site::morton::lexicographic;
use heliotile_core::site::scene_object::ObjectNote;
use heliotile_core::site::semantics::{SourceFace, SurfaceKind};

/// Least cosine between the normals of a triangle and of the first one of its surface (2 degrees).
const SAME_DIRECTION: f64 = 0.999_390_8;
/// Largest distance of a triangle's corners from the plane of its surface, metres.
pub(crate) const SAME_PLANE_M: f64 = 0.1;

/// Width below which a triangle has no direction of its own, metres.
const THIN_M: f64 = 1e-3;
/// Least area of a surface, m2.
const NO_SURFACE_M2: f64 = 1e-6;

/// Returns the kind of a surface: the stated one, or else one by the material's class and the tilt.
/// Up to 60 degrees of tilt is a roof, within 30 degrees of the vertical a wall. Names of materials
/// decide nothing but the class of materials without a stated one.
fn kind_of(stated: Option<SurfaceKind>, material: &Material, up: f64) -> SurfaceKind {
    match stated {
        // City models count the underside of an eave as a part of the roof; it is treated as a
        // floor.
        Some(SurfaceKind::Roof) if up < -0.5 => SurfaceKind::Floor,
        Some(kind) => kind,
        None if material.glass.is_some() => SurfaceKind::Window,
        None if up < -0.5 => SurfaceKind::Floor,
        None if material.class == Class::Ground => SurfaceKind::Ground,
        None if up > 0.5 => SurfaceKind::Roof,
        None => SurfaceKind::Wall,
    }
}

/// A surface: corners in input coordinates, counter-clockwise as seen from the side that gets
/// light.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Name of the object, followed by kind and number if the object has several surfaces:
    /// `house/roof2`.
    pub name: String,
    /// Kind of the surface.
    pub kind: SurfaceKind,
    /// Index into `Surfaces::objects`.
    pub object: usize,
    /// True if the sun may reach the surface, false if not; `None` if the file does not state it.
    pub exposed: Option<bool>,
    /// Material, an index into the scene's materials.
    pub material: u16,
    /// Triangles in input coordinates, wound as in the scene, but upwards on terrain.
    pub triangles: Vec<[DVec3; 3]>,
    /// Face that each triangle is a part of, an index into the soup's faces.
    pub faces: Vec<u32>,
    /// Sum of the areas of the triangles, m2.
    pub area_m2: f64,
    /// Sum of area vectors, scaled to unit length.
    pub normal: DVec3,
}

/// All surfaces of a scene, by object and kind.
#[derive(Clone, Debug, Default)]
pub struct Surfaces {
    /// Surfaces, sorted by object and kind.
    pub list: Vec<Surface>,
    /// Number of closed objects.
    pub closed_objects: usize,
    /// Names of the objects that have opaque triangles, with their notes.
    pub objects: Vec<(String, ObjectNote)>,
    /// Number of edges at which two faces of one object are turned against each other.
    pub contrary_edges: usize,
}

/// A triangle by the ranks of its corners.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Facet {
    group: Group,
    corners: [u32; 3],
    /// Index into the soup's faces.
    face: u32,
}

/// Properties that all triangles of a surface share, besides their plane.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Group {
    material: u16,
    kind: Option<SurfaceKind>,
    exposed: Option<bool>,
}

impl Surfaces {
    /// Finds the surfaces of a scene; canopies and the endless ground have none.
    pub fn find(soup: &ObjectTriangles, materials: &[Material]) -> Surfaces {
        let positions = distinct(&soup.positions);
        let rank = |corner: u32| {
            let p = soup.positions.get(corner as usize).copied().unwrap_or_default();
            positions.binary_search_by(|q| lexicographic(*q, p)).unwrap_or_default() as u32
        };
        let mut objects: BTreeMap<&str, (ObjectNote, Vec<Facet>)> = BTreeMap::new();
        // Triangles of no file come last and have no face.
        let faces = soup.faces.iter().copied().chain(std::iter::repeat(u32::MAX));
        let triangles = soup.triangles.iter().zip(&soup.materials).zip(&soup.objects).zip(faces);
        for (((corners, &material), &object), face) in triangles {
            let Some(name) = soup.object_names.get(object as usize) else { continue };
            let opaque = materials.get(usize::from(material)).is_some_and(|m| m.transmittance.is_none());
            if opaque && name != crate::ground::endless::NAME {
                let corners = least_first(corners.map(rank));
                let note = soup.source_faces.get(face as usize).map(|face| face.note).unwrap_or_default();
                let group = Group { material, kind: note.kind, exposed: note.exposed };
                let known = || soup.object_notes.get(object as usize).cloned().unwrap_or_default();
                let entry = objects.entry(name).or_insert_with(|| (known(), Vec::new()));
                entry.1.push(Facet { group, corners, face });
            }
        }
        let mut found = Surfaces::default();
        for (name, (note, mut facets)) in objects {
            facets.sort_unstable();
            facets.dedup_by_key(|facet| (facet.group, facet.corners));
            found.objects.push((name.to_owned(), note));
            found.add_object(name, facets, &positions, materials);
        }
        found
    }

    /// Returns the model part that a receiver on a face of a surface stands for; `faces` are the
    /// soup's.
    pub fn part(&self, surface: &Surface, face: u32, faces: &[SourceFace]) -> ModelPart {
        let none = (String::new(), ObjectNote::default());
        let (name, note) = self.objects.get(surface.object).unwrap_or(&none);
        let or = |text: &String, other: &str| if text.is_empty() { other.to_owned() } else { text.clone() };
        let object = or(&note.object, name);
        ModelPart {
            building: or(&note.building, &object),
            object,
            kind: surface.kind.name().to_owned(),
            object_type: note.object_type.clone(),
            face: faces.get(face as usize).map_or_else(String::new, |face| face.name(name)),
        }
    }

    fn add_object(&mut self, name: &str, facets: Vec<Facet>, positions: &[DVec3], materials: &[Material]) {
        let point = |corner: u32| positions.get(corner as usize).copied().unwrap_or_default();
        let (closed, contrary) = shell(&facets);
        self.contrary_edges += contrary;
        self.closed_objects += usize::from(closed);
        let object = self.objects.len().saturating_sub(1);
        let mut surfaces: Vec<Surface> = Vec::new();
        for group in facets.chunk_by(|a, b| a.group == b.group) {
            let Some(first) = group.first() else { continue };
            let Group { material: number, kind: stated, exposed } = first.group;
            let Some(material) = materials.get(usize::from(number)) else { continue };
            let triangles: Vec<[DVec3; 3]> = group.iter().map(|facet| facet.corners.map(point)).collect();
            // Terrain looks up, however it is wound; the slab of a building does not.
            let sheet = !closed && is_terrain(material);
            let groups = if sheet { vec![(0..triangles.len()).collect()] } else { planes(group, &triangles) };
            for members in groups {
                let mut own: Vec<[DVec3; 3]> = members.iter().filter_map(|&i| triangles.get(i).copied()).collect();
                if sheet {
                    own.iter_mut().filter(|t| area_vector(t).z < 0.0).for_each(|t| t.swap(1, 2));
                }
                let sum: DVec3 = own.iter().map(area_vector).sum();
                let area_m2: f64 = own.iter().map(|t| area_vector(t).length()).sum();
                let normal = sum.normalize_or_zero();
                if normal != DVec3::ZERO && area_m2 > NO_SURFACE_M2 {
                    let faces = members.iter().filter_map(|&i| group.get(i)).map(|facet| facet.face).collect();
                    surfaces.push(Surface {
                        name: String::new(),
                        kind: kind_of(stated, material, normal.z),
                        object,
                        exposed,
                        material: number,
                        triangles: own,
                        faces,
                        area_m2,
                        normal,
                    });
                }
            }
        }
        surfaces
            .sort_by(|a, b| (a.kind, a.material).cmp(&(b.kind, b.material)).then(lexicographic(centre(a), centre(b))));
        let single = surfaces.len() == 1;
        let mut numbers: BTreeMap<SurfaceKind, usize> = BTreeMap::new();
        for surface in &mut surfaces {
            let number = numbers.entry(surface.kind).or_default();
            *number += 1;
            surface.name = if single { name.to_owned() } else { format!("{name}/{}{number}", surface.kind.name()) };
        }
        self.list.extend(surfaces);
    }
}

/// Returns true for materials of ground that are not the underside of a building.
fn is_terrain(material: &Material) -> bool {
    let underside = material.name.to_lowercase().contains("groundsurface");
    material.class == Class::Ground && class_of_name(&material.name) == Class::Ground && !underside
}

/// Returns half the cross product of two edges: a vector along the normal, as long as the area.
pub(crate) fn area_vector([a, b, c]: &[DVec3; 3]) -> DVec3 {
    0.5 * (*b - *a).cross(*c - *a)
}

fn is_thin(t: &[DVec3; 3]) -> bool {
    let [a, b, c] = t;
    let longest = a.distance(*b).max(b.distance(*c)).max(c.distance(*a));
    2.0 * area_vector(t).length() < THIN_M * longest
}

fn centre(surface: &Surface) -> DVec3 {
    let sum: DVec3 = surface.triangles.iter().map(|t| area_vector(t).length() * (t[0] + t[1] + t[2]) / 3.0).sum();
    sum / surface.area_m2
}

/// Returns the distinct positions in order.
fn distinct(positions: &[DVec3]) -> Vec<DVec3> {
    let mut sorted = positions.to_vec();
    sorted.sort_unstable_by(|a, b| lexicographic(*a, *b));
    sorted.dedup();
    sorted
}

fn least_first([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

fn edges_of(corners: [u32; 3]) -> [(u32, u32); 3] {
    let [a, b, c] = corners;
    [(a, b), (b, c), (c, a)]
}

/// Returns true if every edge of an object is used as often in one direction as in the other, and
/// the number of edges at which two faces are turned against each other.
fn shell(facets: &[Facet]) -> (bool, usize) {
    // Balance and count of each edge, taken from its lower corner to its higher one.
    let mut edges: HashMap<(u32, u32), (i32, u32)> = HashMap::new();
    for (a, b) in facets.iter().flat_map(|facet| edges_of(facet.corners)) {
        let entry = edges.entry((a.min(b), a.max(b))).or_default();
        entry.0 += if a < b { 1 } else { -1 };
        entry.1 += 1;
    }
    let closed = !edges.is_empty() && edges.values().all(|(balance, _)| *balance == 0);
    let contrary = edges.values().filter(|(balance, count)| *count == 2 && *balance != 0).count();
    (closed, contrary)
}

/// Groups neighbouring triangles in one plane. Groups grow from the largest triangle first, then
/// from the largest of the rest.
fn planes(facets: &[Facet], triangles: &[[DVec3; 3]]) -> Vec<Vec<usize>> {
    let mut at_edge: Vec<((u32, u32), usize)> = Vec::with_capacity(3 * facets.len());
    for (i, facet) in facets.iter().enumerate() {
        at_edge.extend(edges_of(facet.corners).map(|(a, b)| ((a.min(b), a.max(b)), i)));
    }
    at_edge.sort_unstable();
    let neighbours = |edge: (u32, u32)| -> Range<usize> {
        at_edge.partition_point(|entry| entry.0 < edge)..at_edge.partition_point(|entry| entry.0 <= edge)
    };
    let area: Vec<DVec3> = triangles.iter().map(area_vector).collect();
    let size = |i: usize| area.get(i).map_or(0.0, |a| a.length());
    let mut order: Vec<usize> = (0..triangles.len()).collect();
    // The sort is stable: ties stay in the order of positions.
    order.sort_by(|&a, &b| size(b).total_cmp(&size(a)));
    let mut taken = vec![false; triangles.len()];
    let mut groups = Vec::new();
    for seed in order {
        let Some(&[origin, ..]) = triangles.get(seed) else { continue };
        if taken.get(seed) != Some(&false) {
            continue;
        }
        let normal = area.get(seed).copied().unwrap_or_default().normalize_or_zero();
        let flat = |i: usize| {
            let direction = area.get(i).copied().unwrap_or_default().normalize_or_zero();
            let near = |p: &DVec3| (*p - origin).dot(normal).abs() < SAME_PLANE_M;
            triangles
                .get(i)
                .is_some_and(|t| (direction.dot(normal) > SAME_DIRECTION || is_thin(t)) && t.iter().all(near))
        };
        let (mut members, mut next) = (Vec::new(), vec![seed]);
        if let Some(mark) = taken.get_mut(seed) {
            *mark = true;
        }
        while let Some(i) = next.pop() {
            members.push(i);
            let Some(facet) = facets.get(i) else { continue };
            for edge in edges_of(facet.corners) {
                let (a, b) = edge;
                for (_, other) in at_edge.get(neighbours((a.min(b), a.max(b)))).unwrap_or_default() {
                    if taken.get(*other) == Some(&false) && flat(*other) {
                        if let Some(mark) = taken.get_mut(*other) {
                            *mark = true;
                        }
                        next.push(*other);
                    }
                }
            }
        }
        members.sort_unstable();
        groups.push(members);
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_files::load_text;
    use heliotile_core::site::material::Glass;

    fn find(obj: &str) -> Surfaces {
        let (scene, soup) = load_text("town.obj", obj).expect("a scene");
        Surfaces::find(&soup, &scene.materials)
    }

    const CORNERS: &str =
        "v 0 0 0\nv 4 0 0\nv 4 6 0\nv 0 6 0\nv 0 0 3\nv 4 0 3\nv 4 6 3\nv 0 6 3\nv 2 3 3\no house\nusemtl brick\n";
    const WALLS: [&str; 5] = ["f 1 2 6 5", "f 2 3 7 6", "f 3 4 8 7", "f 4 1 5 8", "f 4 3 2 1"];
    const ROOF: [&str; 4] = ["f 5 6 9", "f 6 7 9", "f 7 8 9", "f 8 5 9"];

    fn house(faces: impl Iterator<Item = &'static str>) -> String {
        faces.fold(CORNERS.to_owned(), |text, face| text + face + "\n")
    }

    /// A box of 9 faces has 6 surfaces: a roof of 24 m2, 4 walls of 60 m2 together and a floor of
    /// 24 m2, however its faces are ordered.
    #[test]
    fn a_box_of_9_faces_has_6_surfaces() {
        let one = find(&house(WALLS.into_iter().chain(ROOF)));
        let other = find(&house(ROOF.into_iter().rev().chain(WALLS.into_iter().rev())));
        let told = |surfaces: &Surfaces| -> Vec<(String, f64, [f64; 3])> {
            surfaces.list.iter().map(|s| (s.name.clone(), s.area_m2, s.normal.to_array())).collect()
        };
        assert_eq!(told(&one), told(&other));
        let names: Vec<&str> = one.list.iter().map(|surface| surface.name.as_str()).collect();
        let expected = ["house/roof1", "house/wall1", "house/wall2", "house/wall3", "house/wall4", "house/floor1"];
        assert_eq!(names, expected);
        let area = |kind: SurfaceKind| -> f64 { one.list.iter().filter(|s| s.kind == kind).map(|s| s.area_m2).sum() };
        assert_eq!((area(SurfaceKind::Roof), area(SurfaceKind::Wall), area(SurfaceKind::Floor)), (24.0, 60.0, 24.0));
        assert_eq!((one.closed_objects, one.contrary_edges), (1, 0));
    }

    /// A box inside out, or with one face turned alone, has the 6 surfaces of the sound box and no
    /// contrary edge.
    #[test]
    fn a_box_with_turned_faces_is_the_same_box() {
        let backwards = |face: &str| {
            let mut corners: Vec<&str> = face.split(' ').skip(1).collect();
            corners.reverse();
            format!("f {}\n", corners.join(" "))
        };
        let right = find(&house(WALLS.into_iter().chain(ROOF)));
        let inside_out = WALLS.into_iter().chain(ROOF).fold(CORNERS.to_owned(), |text, face| text + &backwards(face));
        let one_face = house(WALLS.into_iter().skip(1).chain(ROOF)) + &backwards(WALLS[0]);
        for text in [inside_out, one_face] {
            let turned = find(&text);
            let told = |surfaces: &Surfaces| -> Vec<(String, DVec3)> {
                surfaces.list.iter().map(|s| (s.name.clone(), s.normal)).collect()
            };
            assert_eq!(told(&turned), told(&right));
            assert_eq!((turned.closed_objects, turned.contrary_edges), (1, 0));
        }
    }

    /// A wall with a sliver of 1e-7 m between its triangles that faces askew is 1 surface, named
    /// after its object.
    #[test]
    fn a_wall_with_a_sliver_is_one_surface() {
        let wall = find(
            "v 0 0 0\nv 10 0 0\nv 10 0 3\nv 0 0 3\nv 5 0.0000001 0.0000001\no wall\nf 1 5 4\nf 5 2 4\nf 2 3 4\nf 1 2 5\n",
        );
        assert_eq!((wall.list.len(), wall.list[0].name.as_str()), (1, "wall"));
        assert!((wall.list[0].area_m2 - 30.0).abs() < 1e-5, "{}", wall.list[0].area_m2);
    }

    /// The kind that the file states decides, then glass, class and tilt, and never a name: 9 of 9.
    #[test]
    fn the_stated_kind_decides_and_never_a_name() {
        let glass = Material { glass: Some(Glass::Double), ..Material::matt("front", 0.0, Class::Obstruction) };
        let called = |name: &str| crate::materials::assumed::assumed(name);
        let (roof, wall) = (Some(SurfaceKind::Roof), Some(SurfaceKind::Wall));
        for (stated, material, up, kind) in [
            (roof, called("W1"), 0.1, SurfaceKind::Roof),
            (wall, called("RoofSurface"), 0.9, SurfaceKind::Wall),
            (roof, called("RoofSurface"), -0.9, SurfaceKind::Floor),
            (None, called("terrain"), 1.0, SurfaceKind::Ground),
            (None, glass, 0.0, SurfaceKind::Window),
            (None, called("window"), 0.0, SurfaceKind::Wall),
            (None, called("wall"), 1.0, SurfaceKind::Roof),
            (None, called("roof"), 0.4, SurfaceKind::Wall),
            (None, called("brick"), -0.6, SurfaceKind::Floor),
        ] {
            assert_eq!(kind_of(stated, &material, up), kind, "{} {up}", material.name);
        }
    }
}
