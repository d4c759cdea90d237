//! Geometry of one city object, as its file has it. In: rings, polygons and references, one after
//! the other. Out: the same by index, and the place of each `gml:id`.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;

use glam::DVec3;

/// Mark of the end of a ring among the corners.
const END: u32 = u32::MAX;

/// Surfaces of one city object, its parts and its installations.
#[derive(Default)]
pub(super) struct Store {
    /// Positions, metres.
    pub vertices: Vec<DVec3>,
    /// Vertices by the bits of their three numbers in the file.
    known: HashMap<[u64; 3], u32>,
    /// Rings one after the other, each followed by `END`.
    corners: Vec<u32>,
    pub polygons: Vec<Polygon>,
    /// Members of geometries, in the order of the file: the members of an element stand together.
    pub members: Vec<Member>,
    /// Targets of references, as they are written.
    pub references: Vec<String>,
    /// Members of the element of each `gml:id`.
    pub ids: HashMap<String, Place>,
    /// Names of thematic surfaces.
    pub names: Vec<String>,
    /// Number of things that are left out, by reason.
    pub left_out: BTreeMap<&'static str, usize>,
}

/// A surface with holes.
#[derive(Clone)]
pub(super) struct Polygon {
    /// Range of its rings among the corners.
    rings: Range<u32>,
    /// Index of the name of its thematic surface, if the file has one.
    pub name: Option<u16>,
    /// Line of the file, counted from 1.
    pub line: u32,
}

/// Members of an element.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub members: Range<u32>,
    /// True if the members look the other way than the element's own surfaces, because an element
    /// around it reverses them.
    pub is_reversed: bool,
}

/// A polygon, or a reference to geometry elsewhere.
#[derive(Clone, Copy)]
pub(super) struct Member {
    pub target: Target,
    /// True if it is reversed.
    pub is_reversed: bool,
}

#[derive(Clone, Copy)]
pub(super) enum Target {
    Polygon(u32),
    Reference(u32),
}

impl Store {
    /// Returns the vertex of three numbers of the file, if they came before.
    pub(super) fn known(&self, numbers: [f64; 3]) -> Option<u32> {
        self.known.get(&numbers.map(f64::to_bits)).copied()
    }

    /// Adds the vertex of three numbers of the file. Its index fits in 32 bits, because the limit
    /// on corners of a file bounds the vertices of an object.
    pub(super) fn add_vertex(&mut self, numbers: [f64; 3], position: DVec3) -> u32 {
        let vertex = self.push_vertex(position);
        self.known.insert(numbers.map(f64::to_bits), vertex);
        vertex
    }

    /// Adds a vertex that does not stand for three numbers of the file.
    pub(super) fn push_vertex(&mut self, position: DVec3) -> u32 {
        self.vertices.push(position);
        self.vertices.len() as u32 - 1
    }

    /// Returns the number of corners, ring ends included.
    pub(super) fn corner_count(&self) -> u32 {
        self.corners.len() as u32
    }

    /// Adds a ring to the polygon that is being written.
    pub(super) fn push_ring(&mut self, ring: &[u32]) {
        self.corners.extend_from_slice(ring);
        self.corners.push(END);
    }

    /// Ends a polygon whose rings were added from corner `first` on; returns its index.
    pub(super) fn end_polygon(&mut self, first: u32, name: Option<u16>, line: usize) -> u32 {
        let rings = first..self.corner_count();
        self.polygons.push(Polygon { rings, name, line: u32::try_from(line).unwrap_or(u32::MAX) });
        self.polygons.len() as u32 - 1
    }

    /// Removes the corners from `first` on: the rings of a polygon that is not usable.
    pub(super) fn back_to(&mut self, first: u32) {
        self.corners.truncate(first as usize);
    }

    pub(super) fn polygon(&self, number: u32) -> Option<&Polygon> {
        self.polygons.get(number as usize)
    }

    /// Returns the rings of a polygon, the outline first.
    pub(super) fn rings(&self, polygon: &Polygon) -> impl Iterator<Item = &[u32]> {
        let range = polygon.rings.start as usize..polygon.rings.end as usize;
        let corners = self.corners.get(range).unwrap_or_default();
        corners.split_inclusive(|corner| *corner == END).filter_map(|ring| ring.strip_suffix(&[END]))
    }

    /// Returns the number of corners of a polygon, ring ends included.
    pub(super) fn corners_of(&self, polygon: u32) -> u64 {
        self.polygon(polygon).map_or(0, |polygon| polygon.rings.len() as u64)
    }

    pub(super) fn position(&self, vertex: u32) -> DVec3 {
        self.vertices.get(vertex as usize).copied().unwrap_or_default()
    }

    /// Returns the index of a surface name; `None` beyond 65,536 names.
    pub(super) fn name(&mut self, name: &str) -> Option<u16> {
        let at = self.names.iter().position(|known| known == name).unwrap_or_else(|| {
            self.names.push(name.to_owned());
            self.names.len() - 1
        });
        u16::try_from(at).ok()
    }

    pub(super) fn member_count(&self) -> u32 {
        self.members.len() as u32
    }

    /// Records the members of an element with an id: all from member `start` on.
    pub(super) fn set_place(&mut self, id: &str, start: u32, is_reversed: bool) {
        let members = start..self.member_count();
        self.ids.insert(id.to_owned(), Place { members, is_reversed });
    }

    pub(super) fn push_polygon(&mut self, polygon: u32, is_reversed: bool) {
        self.members.push(Member { target: Target::Polygon(polygon), is_reversed });
    }

    /// Adds a reference.
    pub(super) fn refer(&mut self, href: &str, is_reversed: bool) {
        self.references.push(href.to_owned());
        let target = Target::Reference(self.references.len() as u32 - 1);
        self.members.push(Member { target, is_reversed });
    }

    pub(super) fn leave_out(&mut self, reason: &'static str) {
        *self.left_out.entry(reason).or_default() += 1;
    }

    /// Returns a copy of polygons with their own vertices, independent of the store.
    pub(super) fn lift(&self, sides: &[Side]) -> Lifted {
        let (mut lifted, mut vertices) = (Lifted::default(), HashMap::new());
        for side in sides {
            let Some(polygon) = self.polygon(side.polygon) else { continue };
            let mut rings = Vec::new();
            for ring in self.rings(polygon) {
                let number = |corner: &u32| {
                    *vertices.entry(*corner).or_insert_with(|| {
                        lifted.vertices.push(self.position(*corner));
                        lifted.vertices.len() as u32 - 1
                    })
                };
                rings.push(ring.iter().map(number).collect());
            }
            lifted.polygons.push(LiftedPolygon { rings, is_reversed: side.is_reversed, line: polygon.line });
        }
        lifted
    }

    /// Adds polygons with their vertices moved by `place`; returns their members.
    pub(super) fn put(&mut self, lifted: &Lifted, place: impl Fn(DVec3) -> DVec3) -> Range<u32> {
        let (start, first_vertex) = (self.member_count(), self.vertices.len() as u32);
        self.vertices.extend(lifted.vertices.iter().map(|vertex| place(*vertex)));
        for polygon in &lifted.polygons {
            let first = self.corner_count();
            for ring in &polygon.rings {
                self.corners.extend(ring.iter().map(|corner| first_vertex + corner));
                self.corners.push(END);
            }
            let number = self.end_polygon(first, None, polygon.line as usize);
            self.push_polygon(number, polygon.is_reversed);
        }
        start..self.member_count()
    }
}

/// Polygons that belong to no object: a template, or geometry that objects refer to.
#[derive(Clone, Default)]
pub(super) struct Lifted {
    pub vertices: Vec<DVec3>,
    polygons: Vec<LiftedPolygon>,
}

#[derive(Clone)]
struct LiftedPolygon {
    rings: Vec<Vec<u32>>,
    is_reversed: bool,
    line: u32,
}

impl Lifted {
    /// Returns the number of corners of all rings.
    pub(super) fn corners(&self) -> u64 {
        self.polygons.iter().flat_map(|polygon| &polygon.rings).map(|ring| ring.len() as u64).sum()
    }
}

/// A polygon of a geometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Side {
    pub polygon: u32,
    /// True if the geometry uses the polygon reversed.
    pub is_reversed: bool,
}
