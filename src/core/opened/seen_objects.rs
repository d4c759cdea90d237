//! Objects of the surfaces that stored rays met. In: triangles and objects of an archive. Out: for
//! a cell and the line along which it is seen, an object. Never: a ray through the scene. A line is
//! compared with the triangles of the one cell that the archive names.

use glam::{DVec3, Vec3};

use crate::archive::format::{OBJECTS, SCENE, TileNumber};
use crate::archive::tables::{GeometryTable, ObjectsTable};
use crate::error::Result;
use crate::opened::open_site::OpenSite;
use crate::site::cells::{CellKey, FaceTag, GRID_SHIFT_M, size_of};
use crate::site::material::Class;
use crate::site::scene_object::SceneObject;

/// Largest number of triangles in a leaf of the tree.
const LEAF: usize = 8;

/// Width that is added around a cell, metres: stored vertices are rounded to f32.
const MARGIN_M: f64 = 2e-3;

/// Owner of a surface, as finely as the archive names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SurfaceOf {
    /// An object: index into [`SceneObjects::objects`].
    Object(u32),
    /// A material: its number. The archive names no object, or not which one.
    Material(u16),
    /// Nothing that a stored ray met.
    Unknown,
}

/// Object, or else material, that takes light or gives it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SeenObject {
    /// Object or material.
    pub of: SurfaceOf,
    /// True if its surface is of class ground.
    pub is_ground: bool,
}

/// Triangle of the scene and its object.
struct Triangle {
    /// Relative to the scene's origin, metres.
    corners: [Vec3; 3],
    tag: FaceTag,
    object: Option<u32>,
}

/// Box around some of the triangles.
struct Node {
    low: Vec3,
    high: Vec3,
    /// Triangles of a leaf; empty for other nodes.
    triangles: std::ops::Range<usize>,
    /// Node to go on with where the box is not met.
    next: usize,
}

/// Triangles of an archive, by place, with the objects that they are parts of. Takes some 60 bytes
/// a triangle.
pub struct SceneObjects {
    origin: DVec3,
    objects: Vec<SceneObject>,
    triangles: Vec<Triangle>,
    nodes: Vec<Node>,
    classes: Vec<Class>,
    /// `[material]`: the only object that has it.
    only: Vec<Option<u32>>,
}

impl SceneObjects {
    /// Reads the triangles and objects of a site; `origin` is that of its scene. An archive without
    /// them, or with a single object, has no objects: surfaces are told apart by material.
    pub fn new(site: &OpenSite, origin: DVec3) -> Result<Self> {
        let mut all = SceneObjects {
            origin,
            objects: Vec::new(),
            triangles: Vec::new(),
            nodes: Vec::new(),
            classes: site.materials().iter().map(|material| material.class).collect(),
            only: Vec::new(),
        };
        let mut numbers = std::collections::HashMap::new();
        for chunk in (0..).map(TileNumber).take_while(|chunk| site.has(SCENE, *chunk)) {
            let block = site.block(SCENE, chunk)?;
            let table = GeometryTable::from_block(&block)?;
            site.check_materials(&block, table.material.iter().copied())?;
            let mut of_triangle = vec![None; table.rows()];
            if site.has(OBJECTS, chunk) {
                let block = site.block(OBJECTS, chunk)?;
                let mut objects = ObjectsTable::from_block(&block)?;
                if objects.rows() != table.rows() {
                    let (found, right) = (objects.rows(), table.rows());
                    return Err(block.corrupt(format!("objects of {found} triangles"), format!("of {right}")));
                }
                let rows = std::mem::take(&mut objects.row);
                let mut number = |object: SceneObject| {
                    let next = numbers.len() as u32;
                    // Objects without a name are no objects.
                    (!object.name.is_empty() || !object.note.object.is_empty()).then(|| {
                        *numbers.entry(object.name.clone()).or_insert_with(|| {
                            all.objects.push(object);
                            next
                        })
                    })
                };
                let of_row: Vec<Option<u32>> = objects.objects().into_iter().map(&mut number).collect();
                of_triangle = rows.iter().map(|row| of_row[usize::from(*row)]).collect();
            }
            let vertices: Vec<Vec3> = table.vertex.iter().map(|&vertex| Vec3::from(vertex)).collect();
            for ((corners, &material), object) in table.corner.iter().zip(&table.material).zip(of_triangle) {
                let corners = corners.map(|corner| vertices[corner as usize]);
                let [a, b, c] = corners.map(|corner| corner.as_dvec3());
                let normal = (b - a).cross(c - a).normalize_or_zero();
                all.triangles.push(Triangle { corners, tag: FaceTag::new(normal, material), object });
            }
        }
        // One object that holds all, such as a whole file, tells nothing apart.
        if all.objects.len() == 1 && all.triangles.iter().all(|triangle| triangle.object.is_some()) {
            all.objects.clear();
            all.triangles.iter_mut().for_each(|triangle| triangle.object = None);
        }
        all.only = all.only_objects();
        add_nodes(&mut all.triangles, 0, &mut all.nodes);
        Ok(all)
    }

    /// Returns for each material the object that has it alone.
    fn only_objects(&self) -> Vec<Option<u32>> {
        let mut found: Vec<Option<Option<u32>>> = vec![None; self.classes.len()];
        for triangle in &self.triangles {
            if let Some(place) = found.get_mut(usize::from(triangle.tag.material())) {
                let only = place.get_or_insert(triangle.object);
                *only = only.filter(|_| *only == triangle.object);
            }
        }
        found.into_iter().map(Option::flatten).collect()
    }

    /// Returns the objects, in the order of [`SurfaceOf::Object`].
    pub fn objects(&self) -> &[SceneObject] {
        &self.objects
    }

    /// Returns the object that alone has a material, or the material.
    pub fn of_material(&self, material: u16) -> SeenObject {
        self.seen(material, self.only.get(usize::from(material)).copied().flatten())
    }

    fn seen(&self, material: u16, object: Option<u32>) -> SeenObject {
        let of = object.map_or(SurfaceOf::Material(material), SurfaceOf::Object);
        let is_ground = self.classes.get(usize::from(material)) == Some(&Class::Ground);
        SeenObject { of, is_ground }
    }

    /// Returns the triangles that a cell may hold parts of.
    pub fn in_cell(&self, cell: CellKey) -> CellTriangles<'_> {
        let low = cell.corner(self.origin) - GRID_SHIFT_M - self.origin - MARGIN_M;
        let high = low + size_of(cell.level) + 2.0 * MARGIN_M;
        let mut triangles = Vec::new();
        let (mut at, meets) =
            (0, |node: &Node| node.low.as_dvec3().cmple(high).all() && node.high.as_dvec3().cmpge(low).all());
        while let Some(node) = self.nodes.get(at) {
            let is_met = meets(node);
            if is_met {
                let some = self.triangles[node.triangles.clone()].iter();
                triangles.extend(some.filter(|triangle| {
                    let (least, most) = bounds(&triangle.corners);
                    cell.holds(triangle.tag) && least.as_dvec3().cmple(high).all() && most.as_dvec3().cmpge(low).all()
                }));
            }
            at = if is_met { at + 1 } else { node.next };
        }
        CellTriangles { objects: self, cell, low, high, triangles }
    }
}

/// Triangles that a cell may hold parts of.
pub struct CellTriangles<'o> {
    objects: &'o SceneObjects,
    cell: CellKey,
    low: DVec3,
    high: DVec3,
    triangles: Vec<&'o Triangle>,
}

impl CellTriangles<'_> {
    /// Returns the object of the cell that is seen from a place in a direction, in input
    /// coordinates. Of several it is that of the triangle nearest to where the line meets the cell.
    pub fn seen(&self, from: DVec3, toward: DVec3) -> SeenObject {
        let first = self.triangles.first().map(|triangle| triangle.object);
        let object = match first {
            None => return self.objects.of_material(self.cell.material),
            Some(first) if self.triangles.iter().all(|triangle| triangle.object == first) => first,
            Some(_) => {
                let from = from - self.objects.origin;
                let far = |triangle: &&&Triangle| triangle.distance(from, toward, self.low, self.high);
                let nearest = self.triangles.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
                nearest.and_then(|triangle| triangle.object)
            }
        };
        self.objects.seen(self.cell.material, object)
    }

    /// Returns the object of the cell that is seen from a place, towards the cell's middle.
    pub fn seen_from(&self, from: DVec3) -> SeenObject {
        let middle = (self.low + self.high) / 2.0 + self.objects.origin;
        self.seen(from, (middle - from).normalize_or(DVec3::Z))
    }
}

impl Triangle {
    /// Returns how far the point in which a line meets the triangle's plane lies outside the
    /// triangle and outside a box, metres; a large number if the line does not meet it.
    fn distance(&self, from: DVec3, toward: DVec3, low: DVec3, high: DVec3) -> f64 {
        let [a, b, c] = self.corners.map(|corner| corner.as_dvec3());
        let normal = (b - a).cross(c - a);
        let along = normal.dot(a - from) / normal.dot(toward);
        if !(along.is_finite() && along > 0.0) {
            return f64::MAX;
        }
        let at = from + toward * along;
        // Areas of the parts, as shares of the whole: all are above 0 inside.
        let share = |p: DVec3, q: DVec3| (q - p).cross(at - p).dot(normal) / normal.length_squared();
        let outside = share(a, b).min(share(b, c)).min(share(c, a)).min(0.0).abs();
        let size = (b - a).length().max((c - a).length());
        outside * size + (at - at.clamp(low, high)).length()
    }
}

fn bounds<'t>(corners: impl IntoIterator<Item = &'t Vec3>) -> (Vec3, Vec3) {
    let all = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    corners.into_iter().fold(all, |(low, high), corner| (low.min(*corner), high.max(*corner)))
}

/// Sorts triangles into halves by place, and appends the boxes around them; `first` is the number
/// of the first triangle.
fn add_nodes(triangles: &mut [Triangle], first: usize, nodes: &mut Vec<Node>) {
    let (low, high) = bounds(triangles.iter().flat_map(|triangle| &triangle.corners));
    let (own, count) = (nodes.len(), triangles.len());
    let is_leaf = count <= LEAF;
    nodes.push(Node { low, high, triangles: first..if is_leaf { first + count } else { first }, next: 0 });
    if !is_leaf {
        let size = high - low;
        let axis = if size.x >= size.y && size.x >= size.z { 0 } else { 1 + usize::from(size.z > size.y) };
        let middle = |triangle: &Triangle| triangle.corners.iter().map(|corner| corner[axis]).sum::<f32>();
        triangles.select_nth_unstable_by(count / 2, |a, b| middle(a).total_cmp(&middle(b)));
        let (left, right) = triangles.split_at_mut(count / 2);
        add_nodes(left, first, nodes);
        add_nodes(right, first + count / 2, nodes);
    }
    nodes[own].next = nodes.len();
}
