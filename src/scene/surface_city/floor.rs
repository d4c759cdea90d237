//! Ground between buildings. In: heights of cells of ground, and the places of corners of cells.
//! Out: a surface without cracks that ends where buildings begin, thinned where that moves it
//! little.

use std::collections::{BTreeMap, HashMap, VecDeque};

use glam::DVec2;

use crate::surface_city::landcover;
use crate::surface_city::lattice::{Lattice, STEPS, Spot, beside};
use crate::surface_city::layers::{Layers, NO_CLASS};
use crate::surface_city::outlines::{FIRST_ROOF, GROUND};
use crate::surface_city::writer::{FaceOf, Writer};
use crate::terrain::raster::{Grid, Raster};
use crate::terrain::thinning::thin_within;
use heliotile_core::error::Result;
use heliotile_core::site::scene_object::ObjectNote;

use crate::terrain::surface::NAME;
use heliotile_core::site::semantics::SurfaceKind;

/// Largest error of thinned ground, metres, and its growth a metre away from buildings (0.2
/// degrees, as for far terrain).
const OFF_M: f32 = 0.1;
const OFF_A_METRE: f32 = 0.0035;

/// Least area of a triangle, in cells; smaller ones are rounding errors.
const NO_AREA: f64 = 1e-9;
/// Places in plan of corners of cells that are not on the grid.
pub(super) type Moved = HashMap<Spot, DVec2>;

/// Ground by the corners of its cells.
pub(super) struct Floor {
    /// Mean height of the cells of ground around a corner, `[corner]`; NaN without such cells.
    pub heights: Lattice<f32>,
    /// Triangles between corners, counter-clockwise as seen from above.
    pub triangles: Vec<[Spot; 3]>,
}

/// Returns the cells around a corner.
pub(super) fn around([column, row]: Spot) -> [Spot; 4] {
    [[column - 1, row - 1], [column, row - 1], [column - 1, row], [column, row]]
}

/// Returns the cell that holds the middle of a triangle between corners.
pub(super) fn cell_of(triangle: &[Spot; 3]) -> Spot {
    [0, 1].map(|axis| triangle.iter().filter_map(|corner| corner.get(axis)).sum::<i64>().div_euclid(3))
}

/// Returns the surface of the ground; `pieces` holds the number of each cell's piece.
pub(super) fn floor(layers: &Layers, pieces: &Lattice<u32>, ground: &Lattice<f32>) -> Floor {
    let (columns, rows) = (pieces.columns + 1, pieces.rows + 1);
    let mut heights = Lattice::filled(columns, rows, f32::NAN);
    let mut allowed = Lattice::filled(columns, rows, OFF_M);
    let far = distances(layers, pieces);
    let class = |cell: Spot| layers.class.as_ref().map_or(NO_CLASS, |class| landcover::joined(class.at(cell)));
    for corner in heights.spots() {
        let cells = around(corner);
        let (mut sum, mut count, mut kinds) = (0.0_f64, 0_u32, [NO_CLASS; 4]);
        let mut others = 0;
        for (cell, kind) in cells.into_iter().zip(&mut kinds) {
            let is_on = cell[0] >= 0 && cell[1] >= 0 && cell[0] < pieces.columns as i64 && cell[1] < pieces.rows as i64;
            if pieces.at(cell) == GROUND {
                sum += f64::from(ground.at(cell));
                count += 1;
                *kind = class(cell);
            } else if is_on {
                others += 1;
            }
        }
        if count == 0 {
            continue;
        }
        heights.set(corner, (sum / f64::from(count)) as f32);
        let first = cells.iter().zip(kinds).find(|(cell, _)| pieces.at(**cell) == GROUND).map(|(_, kind)| kind);
        let is_edge = cells.iter().zip(kinds).any(|(cell, kind)| pieces.at(*cell) == GROUND && Some(kind) != first);
        let near = cells.iter().map(|cell| far.at(*cell)).fold(f32::INFINITY, f32::min);
        let off = OFF_M + OFF_A_METRE * if near.is_finite() { near } else { 0.0 };
        // A corner with a limit below 0 stays.
        allowed.set(corner, if others > 0 || is_edge { -1.0 } else { off });
    }
    let triangles = surface_of(layers, &heights, allowed).into_iter();
    let triangles = triangles.filter(|triangle| pieces.at(cell_of(triangle)) == GROUND).collect();
    Floor { heights, triangles }
}

/// Returns twice the area of a triangle in plan with its corners moved, m2; negative if the
/// triangle is turned over.
fn doubled(layers: &Layers, moved: &Moved, triangle: &[Spot; 3]) -> f64 {
    let [a, b, c] = triangle.map(|corner| moved.get(&corner).copied().unwrap_or_else(|| layers.corner(corner)));
    (b - a).perp_dot(c - a)
}

/// Returns the triangles between corners with a height, thinned within the limits in `allowed`.
pub(super) fn surface_of(layers: &Layers, heights: &Lattice<f32>, allowed: Lattice<f32>) -> Vec<[Spot; 3]> {
    let grid =
        Grid { columns: heights.columns, rows: heights.rows, first: layers.corner([0, 0]), step: layers.grid.step };
    let raster = Raster::plain(grid, heights.clone().into_values());
    let mut found = thin_within(&raster, &allowed.into_values());
    for triangle in &mut found {
        let [[ax, ay], [bx, by], [cx, cy]] = *triangle;
        // Rows go southwards.
        if (bx - ax) * (cy - ay) > (by - ay) * (cx - ax) {
            triangle.swap(0, 1);
        }
    }
    found
}

/// Returns the distance of each cell from the next roof along rows and columns, metres.
fn distances(layers: &Layers, pieces: &Lattice<u32>) -> Lattice<f32> {
    let mut far = pieces.like(f32::INFINITY);
    let mut next: VecDeque<Spot> = pieces.spots().filter(|cell| pieces.at(*cell) >= FIRST_ROOF).collect();
    next.iter().for_each(|cell| far.set(*cell, 0.0));
    let step = layers.cell_m() as f32;
    while let Some(cell) = next.pop_front() {
        for other in STEPS.map(|step| beside(cell, step)) {
            let is_on =
                other[0] >= 0 && other[1] >= 0 && other[0] < pieces.columns as i64 && other[1] < pieces.rows as i64;
            if is_on && far.at(other).is_infinite() {
                far.set(other, far.at(cell) + step);
                next.push_back(other);
            }
        }
    }
    far
}

impl Floor {
    /// Writes the ground.
    pub(super) fn write(&self, writer: &mut Writer, layers: &Layers, moved: &Moved) -> Result<()> {
        let object = writer.object(NAME, &ObjectNote::default());
        let mut numbers: HashMap<Spot, u32> = HashMap::new();
        let mut materials: BTreeMap<u16, u32> = BTreeMap::new();
        // Corners that a line passes one after the other have no ground between them.
        let least = NO_AREA * layers.cell_m2();
        for triangle in self.triangles.iter().filter(|triangle| doubled(layers, moved, triangle) > least) {
            let code = layers.class.as_ref().map_or(NO_CLASS, |class| class.at(cell_of(triangle)));
            let material = *materials.entry(code).or_insert_with(|| writer.material(&landcover::material_of(code)));
            let mut corners = [0; 3];
            for (number, corner) in corners.iter_mut().zip(triangle) {
                *number = match numbers.get(corner) {
                    Some(known) => *known,
                    None => {
                        let place = moved.get(corner).copied().unwrap_or_else(|| layers.corner(*corner));
                        let new = writer.vertex(place, f64::from(self.heights.at(*corner)))?;
                        numbers.insert(*corner, new);
                        new
                    }
                };
            }
            writer.face([&corners[..]], &FaceOf { material, object, kind: Some(SurfaceKind::Ground), exposed: None });
        }
        Ok(())
    }
}
