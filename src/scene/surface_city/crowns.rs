//! Crowns of trees. In: heights of crowns and of their undersides above the ground. Out: closed
//! hulls of leaves, with open trunk space below.

use std::collections::HashMap;

use crate::surface_city::floor::{Moved, around, cell_of, surface_of};
use crate::surface_city::lattice::{Lattice, STEPS, Spot, beside};
use crate::surface_city::layers::Layers;
use crate::surface_city::outlines::GROUND;
use crate::surface_city::standing::MIN_CROWN_M;
use crate::surface_city::writer::{Corner, FaceOf, Writer};
use crate::surface_rasters::SurfaceRasters;
use crate::terrain::raster::Raster;
use crate::trees::TREES;
use heliotile_core::error::Result;
use heliotile_core::site::material::{BROADLEAF_DIFFUSE, Material};
use heliotile_core::site::scene_object::ObjectNote;
use heliotile_core::text::counted;

/// Name of the material of crowns.
const NAME: &str = "canopy";

/// Largest error of the top of a thinned crown, metres.
const OFF_M: f32 = 0.25;

/// Crowns by the corners of their cells.
struct Crowns {
    /// Number of each cell's piece, `[cell]`; `u32::MAX` for none.
    piece: Lattice<u32>,
    /// Cells of each piece.
    list: Vec<Vec<Spot>>,
    /// Mean height above the ground of the crowns around a corner, `[corner]`.
    heights: Lattice<f32>,
    /// Mean height above the ground of their undersides, `[corner]`.
    bases: Lattice<f32>,
}

/// Writes crowns and returns the number of pieces. `pieces` holds the number of each cell's piece,
/// `ground` the height of each corner; `mean_m` is the mean height of all crowns of the raster,
/// metres.
pub(super) fn write(
    writer: &mut Writer,
    layers: &Layers,
    pieces: &Lattice<u32>,
    ground: &Lattice<f32>,
    moved: &Moved,
    options: &SurfaceRasters,
    mean_m: f64,
) -> Result<usize> {
    let Some(crown) = &layers.crown else { return Ok(0) };
    let belongs = |cell: Spot| crown.at(cell) >= MIN_CROWN_M && pieces.at(cell) == GROUND;
    let (piece, list) = pieces.pieces(belongs, |_, _| true);
    if list.is_empty() {
        return Ok(0);
    }
    let (trunk, highest) = (options.trunk() as f32, SurfaceRasters::HIGHEST_TRUNK_SHARE as f32);
    let stated = |cell: Spot| layers.base.as_ref().map_or(f32::NAN, |base| base.at(cell));
    let base = |cell: Spot| match stated(cell) {
        none if none.is_nan() => trunk * crown.at(cell),
        base => base.clamp(0.0, highest * crown.at(cell)),
    };
    let (heights, bases) = (by_corner(&piece, |cell| crown.at(cell)), by_corner(&piece, base));
    let crowns = Crowns { heights, bases, piece, list };
    let too_high = crowns.list.iter().flatten().filter(|cell| stated(**cell) >= crown.at(**cell)).count() as u64;
    if too_high > 0 {
        let cells = counted(too_high, "cell");
        let text = format!(
            "the underside is not below the top of the crown in {cells}; a twentieth of the height is crown there (trunk_zone)"
        );
        writer.geometry.warnings.push(text.into());
    }
    let material = writer.material(NAME);
    let canopy = Material::of_leaves(NAME, options.density(mean_m), BROADLEAF_DIFFUSE);
    let canopy = Material { group: Some(TREES.to_owned()), ..canopy };
    writer.geometry.stated.insert(NAME.to_owned(), canopy);
    if options.leaf_area_density.is_none() {
        writer.geometry.assumed.insert(NAME.to_owned());
    }
    let note = |name: &str| ObjectNote {
        object: name.to_owned(),
        object_type: "PlantCover".to_owned(),
        beside: true,
        ..ObjectNote::default()
    };
    let mut objects = Vec::new();
    for cells in &crowns.list {
        let name = format!("trees_{}", super::name_of(layers, cells));
        objects.push(writer.object(&name, &note(&name)));
    }
    let place = |corner: Spot| moved.get(&corner).copied().unwrap_or_else(|| layers.corner(corner));
    let foot = |corner: Spot| f64::from(ground.at(corner));
    let at = |corner: Spot, above: &Lattice<f32>| Corner {
        place: place(corner),
        height: foot(corner) + f64::from(above.at(corner)),
    };
    let of = |cell: Spot| FaceOf {
        material,
        object: objects.get(crowns.piece.at(cell) as usize).copied().unwrap_or_default(),
        kind: None,
        exposed: None,
    };
    let mut numbers: HashMap<(Spot, bool), u32> = HashMap::new();
    let mut number = |writer: &mut Writer, corner: Spot, is_top: bool| match numbers.get(&(corner, is_top)) {
        Some(known) => Ok(*known),
        None => {
            let Corner { place, height } = at(corner, if is_top { &crowns.heights } else { &crowns.bases });
            let new = writer.vertex(place, height)?;
            numbers.insert((corner, is_top), new);
            Ok(new)
        }
    };
    let mut faces: Vec<(Spot, Vec<(Spot, bool)>)> = Vec::new();
    for triangle in crowns.surface(layers, ground) {
        let cell = cell_of(&triangle);
        if belongs(cell) {
            let [a, b, c] = triangle;
            faces.push((cell, vec![(a, true), (b, true), (c, true)]));
            faces.push((cell, vec![(c, false), (b, false), (a, false)]));
        }
    }
    for cell in crowns.list.iter().flatten() {
        let [column, row] = *cell;
        // Corners of the side in each direction of STEPS, with the crown to the left.
        let sides = [
            [[column + 1, row + 1], [column + 1, row]],
            [[column, row + 1], [column + 1, row + 1]],
            [[column, row], [column, row + 1]],
            [[column + 1, row], [column, row]],
        ];
        for (step, [from, to]) in STEPS.into_iter().zip(sides) {
            if !belongs(beside(*cell, step)) {
                faces.push((*cell, vec![(from, false), (to, false), (to, true), (from, true)]));
            }
        }
    }
    for (cell, corners) in faces {
        let mut ring = Vec::with_capacity(corners.len());
        for (corner, is_top) in corners {
            ring.push(number(writer, corner, is_top)?);
        }
        // Sides need not be flat, so that each becomes two triangles.
        match ring.as_slice() {
            [a, b, c, d] => {
                writer.face([&[*a, *b, *c][..]], &of(cell));
                writer.face([&[*a, *c, *d][..]], &of(cell));
            }
            ring => writer.face([ring], &of(cell)),
        }
    }
    Ok(crowns.list.len())
}

/// Returns the mean height of all crowns of a raster, metres; 0 if there are none. Parts of a
/// region are cut from one raster, so that their crowns are equally dense.
pub(super) fn mean_height(raster: &Raster) -> f64 {
    let crowns = raster.heights.iter().filter(|height| **height >= MIN_CROWN_M);
    let (sum, count) = crowns.fold((0.0, 0.0), |(sum, count), height| (sum + f64::from(*height), count + 1.0));
    sum / f64::max(count, 1.0)
}

/// Returns the mean of a value of the cells with crowns around each corner.
fn by_corner(piece: &Lattice<u32>, value: impl Fn(Spot) -> f32) -> Lattice<f32> {
    let mut means = Lattice::filled(piece.columns + 1, piece.rows + 1, f32::NAN);
    for corner in means.spots() {
        let known = around(corner).into_iter().filter(|cell| piece.at(*cell) != u32::MAX);
        let (sum, count) = known.fold((0.0, 0.0), |(sum, count), cell| (sum + value(cell), count + 1.0));
        means.set(corner, sum / count);
    }
    means
}

impl Crowns {
    /// Returns the triangles of the tops.
    fn surface(&self, layers: &Layers, ground: &Lattice<f32>) -> Vec<[Spot; 3]> {
        let mut allowed = self.heights.like(-1.0_f32);
        let mut tops = self.heights.clone();
        for corner in self.heights.spots() {
            tops.set(corner, self.heights.at(corner) + ground.at(corner));
            if around(corner).into_iter().all(|cell| self.piece.at(cell) != u32::MAX) {
                allowed.set(corner, OFF_M);
            }
        }
        surface_of(layers, &tops, allowed)
    }
}
