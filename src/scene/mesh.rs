//! The mesh of a scene. In: positions and triangles in any order. Out: one mesh in canonical form
//! with its vertices on the absolute grid; degenerate and repeated triangles are dropped and
//! counted.

use glam::DVec3;
use heliotile_core::site::grid::{Grid, MAX_M};
use heliotile_core::site::morton::lexicographic;
use rayon::slice::ParallelSliceMut;

use heliotile_core::error::{Error, Result};

/// Largest number of triangles in a scene.
pub const MAX_TRIANGLES: u64 = 1 << 31;

/// Least area of a face as a share of its longest extent squared; smaller faces count as without
/// area.
pub(super) const NO_AREA: f64 = 1e-12;

/// Most rounds of finding the origin. Dropping a sliver may shrink the bounding box and so move the
/// origin. Ordinary scenes settle within this many rounds; others keep the last origin.
const ORIGIN_ROUNDS: usize = 4;

/// Triangles in canonical order: equal scenes are equal meshes, whatever the order of faces and
/// vertices in the file.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Origin, subtracted from every vertex: the multiple of 256 m in input coordinates nearest to
    /// the centre of the bounding box or, beside far terrain, to the centre of everything else.
    pub origin: DVec3,
    /// Step of the grid that vertices lie on, metres: [`Grid::step`].
    pub step_m: f64,
    /// Positions relative to `origin`, metres: on the grid, exact in f32, finite, sorted
    /// lexicographically, all different.
    pub vertices: Vec<DVec3>,
    /// Corners of each triangle in the winding of the file, rotated so that the smallest index is
    /// first; sorted.
    pub triangles: Vec<[u32; 3]>,
    /// Material of each triangle, an index into the scene's materials.
    pub triangle_material: Vec<u16>,
    /// Unit normal of each triangle, kept because it is needed many times.
    normals: Vec<DVec3>,
}

impl Mesh {
    /// Returns the corners of a triangle relative to `origin`, metres. Panics beyond the last
    /// triangle, as a slice does.
    #[allow(clippy::indexing_slicing)] // `canonical` makes only corners that are in range
    pub fn triangle_points(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|corner| self.vertices[corner as usize])
    }

    /// Returns the frame of vertices and ray origins.
    pub fn grid(&self) -> Grid {
        Grid { origin: self.origin, step: self.step_m }
    }

    /// Builds a mesh without materials from the corners of triangles relative to the origin of a
    /// frame, in the order given. Its bounding box includes `around`, two corners of a box.
    pub fn loose(grid: Grid, triangles: &[[DVec3; 3]], around: (DVec3, DVec3)) -> Self {
        let mut vertices: Vec<DVec3> = triangles.iter().flatten().copied().collect();
        vertices.extend([around.0, around.1]);
        Mesh {
            origin: grid.origin,
            step_m: grid.step,
            vertices,
            triangles: (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
            triangle_material: vec![0; triangles.len()],
            normals: triangles.iter().map(|corners| unit_normal(*corners)).collect(),
        }
    }

    /// Returns the least and the greatest corner of the bounding box, relative to `origin`, metres.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        bounds(self.vertices.iter().copied())
    }

    /// Returns the unit normal of a triangle by the right-hand rule, from f64 positions. Panics
    /// beyond the last triangle, as a slice does.
    #[allow(clippy::indexing_slicing)] // one normal for each triangle
    pub fn normal(&self, triangle: usize) -> DVec3 {
        self.normals[triangle]
    }
}

/// A triangle that has not been checked for area.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct RawTriangle {
    pub corners: [u32; 3],
    /// Material number, in any numbering in the order of the material names.
    pub material: u32,
    /// Object number, in any numbering in the order of the object names.
    pub object: u32,
}

/// Counts of triangles that canonicalisation dropped or doubted.
#[derive(Debug, Default)]
pub(super) struct Dropped {
    pub degenerate: usize,
    pub duplicates: usize,
    /// Triangles kept although another material has the same triangle.
    pub contested: usize,
}

/// A canonical mesh. `used[i]` is the caller's number of the mesh's material `i`.
#[derive(Debug)]
pub(super) struct Canonical {
    pub mesh: Mesh,
    pub used: Vec<u32>,
    /// Caller's object number for each triangle of the mesh.
    pub objects: Vec<u32>,
    pub dropped: Dropped,
}

/// Brings triangles over finite positions to the form that [`Mesh`] promises. The mesh may be
/// empty.
///
/// Vertices lie on an absolute grid of 61 um (finer in scenes of less than 4 m), so that a triangle
/// has the same coordinates in all scenes that hold it. Beyond 1024 m from the origin f32 rounds
/// vertices further, to 6e-8 of that distance. Where much of a scene is far terrain, `focus` takes
/// the place of its centre: near it positions keep their millimetres, and far positions keep their
/// direction.
pub(super) fn canonical(
    positions: &[DVec3],
    mut triangles: Vec<RawTriangle>,
    focus: Option<DVec3>,
) -> Result<Canonical> {
    if triangles.len() as u64 > MAX_TRIANGLES {
        return Err(Error::Limit {
            what: "the number of triangles of the scene".into(),
            value: triangles.len() as u64,
            max: MAX_TRIANGLES,
        });
    }
    let given = triangles.len();
    let position = |corner: u32| positions.get(corner as usize).copied().unwrap_or(DVec3::NAN);
    triangles.retain(|triangle| has_area(triangle.corners.map(position)));
    let mut grid = Grid::default();
    for _ in 0..ORIGIN_ROUNDS {
        let before = triangles.len();
        let (least, greatest) = bounds(triangles.iter().flat_map(|triangle| triangle.corners).map(position));
        if triangles.is_empty() {
            break;
        }
        grid = Grid::new(focus.unwrap_or(0.5 * (least + greatest)), (greatest - least).max_element());
        check_reach(grid, least, greatest)?;
        // Areas count on the grid, where rays and normals see the triangles.
        triangles.retain(|triangle| has_area(triangle.corners.map(|corner| grid.relative(position(corner)))));
        if triangles.len() == before {
            break;
        }
    }
    let degenerate = given - triangles.len();

    let vertices = number_vertices(positions, grid, &mut triangles);
    let rotated = triangles.len();
    triangles.par_sort_unstable();
    // Of equal triangles the one of the first object stays.
    triangles.dedup_by_key(|triangle| (triangle.corners, triangle.material));
    let contested = triangles.windows(2).filter(|pair| matches!(pair, [a, b] if a.corners == b.corners)).count();
    let dropped = Dropped { degenerate, duplicates: rotated - triangles.len(), contested };

    let (used, triangle_material) = number_materials(&triangles)?;
    let mut mesh = Mesh {
        origin: if triangles.is_empty() { DVec3::ZERO } else { grid.origin },
        step_m: grid.step,
        vertices,
        triangles: triangles.iter().map(|triangle| triangle.corners).collect(),
        triangle_material,
        normals: Vec::new(),
    };
    mesh.normals = (0..triangles.len()).map(|triangle| unit_normal(mesh.triangle_points(triangle))).collect();
    let objects = triangles.iter().map(|triangle| triangle.object).collect();
    Ok(Canonical { mesh, used, objects, dropped })
}

/// Replaces corners by ranks among the distinct relative positions, least corner first; returns
/// those positions.
#[allow(clippy::indexing_slicing)] // triangles with an area have corners among the positions
fn number_vertices(positions: &[DVec3], grid: Grid, triangles: &mut [RawTriangle]) -> Vec<DVec3> {
    let mut rank_of = vec![u32::MAX; positions.len()];
    let mut sorted: Vec<(DVec3, u32)> = Vec::new();
    for corner in triangles.iter().flat_map(|triangle| triangle.corners) {
        let place = corner as usize;
        if rank_of[place] == u32::MAX {
            rank_of[place] = 0;
            // Corners that coincide on the grid are one vertex, so that all stages see one surface.
            sorted.push((grid.relative(positions[place]), corner));
        }
    }
    sorted.par_sort_unstable_by(|(a, _), (b, _)| lexicographic(*a, *b));

    let mut vertices: Vec<DVec3> = Vec::new();
    for &(relative, corner) in &sorted {
        if vertices.last() != Some(&relative) {
            vertices.push(relative);
        }
        // There is at most one vertex for each u32 corner, so that the count fits.
        rank_of[corner as usize] = (vertices.len() - 1) as u32;
    }
    for triangle in triangles.iter_mut() {
        let [a, b, c] = triangle.corners.map(|corner| rank_of[corner as usize]);
        triangle.corners = if a < b && a < c {
            [a, b, c]
        } else if b < c {
            [b, c, a]
        } else {
            [c, a, b]
        };
    }
    vertices
}

/// Numbers the materials in use without gaps, in their order.
fn number_materials(triangles: &[RawTriangle]) -> Result<(Vec<u32>, Vec<u16>)> {
    let mut used: Vec<u32> = triangles.iter().map(|triangle| triangle.material).collect();
    used.par_sort_unstable();
    used.dedup();
    let too_many = |_| Error::Limit {
        what: "the number of materials in use".into(),
        value: used.len() as u64,
        max: u64::from(u16::MAX),
    };
    // A count of 65,535 leaves the last index free as a mark.
    u16::try_from(used.len()).map_err(too_many)?;
    // The number of a material is the count of smaller ones in use.
    let number = |triangle: &RawTriangle| used.partition_point(|&other| other < triangle.material) as u16;
    let numbers = triangles.iter().map(number).collect();
    Ok((used, numbers))
}

fn unit_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    // Scaled first: the product of two lengths in a tiny scene would underflow.
    let (ab, ac) = (b - a, c - a);
    let scale = ab.abs().max_element().max(ac.abs().max_element());
    (ab / scale).cross(ac / scale).normalize()
}

/// Returns the least and the greatest corner of some points; without points both are infinite, the
/// least above the greatest.
pub fn bounds(points: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(least, greatest), point| {
        (least.min(point), greatest.max(point))
    })
}

/// Checks that a scene is not so wide that keys of cells would repeat in it.
fn check_reach(grid: Grid, least: DVec3, greatest: DVec3) -> Result<()> {
    let reach_m = (least - grid.origin).abs().max((greatest - grid.origin).abs()).max_element();
    if reach_m <= MAX_M {
        return Ok(());
    }
    Err(Error::Limit {
        what:
            "the distance in metres from the middle of the scene to its farthest vertex (look for stray geometry, or \
               state the unit of the file with `scale` in site.toml)"
                .into(),
        // `as` saturates.
        value: reach_m as u64,
        max: MAX_M as u64,
    })
}

fn has_area([a, b, c]: [DVec3; 3]) -> bool {
    let (ab, bc, ca) = (b - a, c - b, a - c);
    let longest_squared = ab.length_squared().max(bc.length_squared()).max(ca.length_squared());
    0.5 * ab.cross(bc).length() > NO_AREA * longest_squared
}

#[cfg(test)]
mod tests {
    use super::*;

    fn build(positions: &[[f64; 3]], triangles: &[([u32; 3], u32)]) -> Canonical {
        let positions: Vec<DVec3> = positions.iter().copied().map(DVec3::from).collect();
        let raw = triangles.iter().map(|&(corners, material)| RawTriangle { corners, material, object: 0 }).collect();
        canonical(&positions, raw, None).expect("within limits")
    }

    /// National grid coordinates with millimetres come back within 0.87 steps of the grid (53 um),
    /// relative to a multiple of 256 m.
    #[test]
    fn national_grid_coordinates_stay_within_53_um() {
        let input = [[78_000.125, 457_000.001, 7.717], [78_010.125, 457_000.002, 7.3], [78_003.5, 457_008.033, -1.0]];
        let Canonical { mesh, .. } = build(&input, &[([0, 1, 2], 0)]);
        assert_eq!(mesh.origin, DVec3::new(78_080.0, 456_960.0, 0.0));
        assert_eq!(mesh.bounds().0.x, -79.875);
        assert_eq!(mesh.bounds().1.x, -69.875);
        for (found, given) in mesh.triangle_points(0).iter().zip(input) {
            let (found, given) = (*found + mesh.origin, DVec3::from(given));
            assert!((found - given).length() < 0.87 * mesh.step_m, "{found} {given}");
        }
    }

    /// Vertices are shared by value, sorted and all used; triangles start at their least corner and
    /// keep their winding.
    #[test]
    fn vertices_are_shared_and_sorted() {
        let positions = [[2., 0., 0.], [0., 2., 0.], [0., 0., 0.], [9., 9., 9.], [2., 0., -0.0], [2., 2., 0.]];
        let Canonical { mesh, used, .. } = build(&positions, &[([0, 5, 1], 7), ([4, 1, 2], 3)]);
        let found: Vec<[f64; 3]> = mesh.vertices.iter().map(DVec3::to_array).collect();
        assert_eq!(found, [[0., 0., 0.], [0., 2., 0.], [2., 0., 0.], [2., 2., 0.]]);
        assert!(mesh.vertices.iter().all(|vertex| vertex.z.is_sign_positive()));
        assert_eq!(mesh.triangles, [[0, 2, 1], [1, 2, 3]]);
        assert_eq!((mesh.triangle_material, used), (vec![0, 1], vec![3, 7]));
    }

    /// The normal has unit length and follows the right-hand rule, also in a scene of a micrometre.
    #[test]
    fn normals_follow_the_right_hand_rule() {
        for size in [1e-6, 1.0, 1e6] {
            let ring = [[0., 0., 0.], [size, 0., size], [0., size, 0.]];
            let normal = build(&ring, &[([0, 1, 2], 0)]).mesh.normal(0);
            assert!((normal - DVec3::new(-1.0, 0.0, 1.0).normalize()).length() < 1e-15, "{normal}");
        }
    }

    /// Four slivers are dropped, two that vanish on the grid and two without area, of which one
    /// repeats a corner; a needle of aspect 1e6 stays.
    #[test]
    fn slivers_are_dropped_and_needles_stay() {
        let positions = [
            [0., 0., 0.],
            [1000., 0., 0.],
            [1000., 1000., 0.],
            [0., 1000., 0.], // a square that sets the grid
            [470., 500., 10.],
            [530., 500., 10.],
            [500., 500.000_06, 10.], // needle, one step wide
            [3., 3., 0.],
            [3.000_000_1, 3., 0.],
            [3., 4., 0.], // two corners coincide on the grid
            [100., 100., 0.],
            [200., 200., 0.],
            [300., 300., 0.], // in line
        ];
        let triangles = [
            ([0, 1, 2], 0),
            ([0, 2, 3], 0),
            ([4, 5, 6], 0),
            ([7, 8, 9], 0),
            ([10, 11, 12], 0),
            ([7, 7, 9], 0),
            ([9, 8, 7], 0),
        ];
        let Canonical { mesh, dropped, .. } = build(&positions, &triangles);
        assert_eq!((dropped.degenerate, mesh.triangles.len(), mesh.vertices.len()), (4, 3, 7));
        assert_eq!(mesh.origin, DVec3::new(512.0, 512.0, 0.0));
    }

    /// A triangle of two scenes whose origins lie 512 m apart has the same corners and the same
    /// normal in both, to the bit, at coordinates that f32 relative to either middle would not
    /// share. A scene 3,000 km wide is refused with its reach.
    #[test]
    fn a_triangle_is_equal_in_two_scenes() {
        let house = [[85_333.333, 446_111.111, 1.7], [85_341.37, 446_118.02, 4.123], [85_336.1, 446_120.9, 9.081]];
        let with = |x: f64| {
            let far = [[x, 446_000., 0.], [x + 3., 446_000., 0.], [x, 446_300., 0.]];
            build(&[house, far].concat(), &[([0, 1, 2], 0), ([3, 4, 5], 0)]).mesh
        };
        let [west, east] = [84_800.0, 85_900.0].map(with);
        assert_eq!(east.origin - west.origin, DVec3::new(512.0, 0.0, 0.0));
        let corners = |mesh: &Mesh, triangle: usize| mesh.triangle_points(triangle).map(|p| p + mesh.origin);
        assert_eq!(corners(&west, 1), corners(&east, 0));
        assert_eq!(west.normal(1).to_array().map(f64::to_bits), east.normal(0).to_array().map(f64::to_bits));

        let far = [[0., 0., 0.], [3e6, 0., 0.], [0., 3e6, 0.]].map(DVec3::from);
        let wide = canonical(&far, vec![RawTriangle { corners: [0, 1, 2], material: 0, object: 0 }], None);
        let message = wide.expect_err("too wide").to_string();
        assert!(message.ends_with("is 1500096, the limit is 1048576"), "{message}");
    }

    /// A repeated triangle of the same material is dropped, whichever corner it starts at; a
    /// flipped one is another triangle.
    #[test]
    fn a_repeated_triangle_is_dropped() {
        let positions = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 0.]];
        let triangles = [([0, 1, 2], 1), ([1, 2, 3], 1), ([2, 3, 1], 1), ([0, 1, 2], 2), ([2, 1, 0], 1)];
        let Canonical { mesh, dropped, .. } = build(&positions, &triangles);
        assert_eq!((dropped.duplicates, dropped.contested, mesh.triangles.len()), (2, 1, 3));
    }

    /// 65,535 materials are accepted; one more is refused with both numbers.
    #[test]
    fn at_most_65535_materials_are_accepted() {
        let fan = |count: u32| {
            let positions: Vec<DVec3> =
                (0..count + 2).map(|i| DVec3::new(f64::from(i), f64::from(i % 2), 0.0)).collect();
            let raw = (0..count).map(|i| RawTriangle { corners: [i, i + 1, i + 2], material: i, object: 0 }).collect();
            canonical(&positions, raw, None)
        };
        assert_eq!(fan(65_535).expect("the limit itself").mesh.triangle_material.last(), Some(&65_534));
        let message = fan(65_536).expect_err("one too many").to_string();
        assert!(message.contains("65536") && message.contains("65535"), "{message}");
    }
}
