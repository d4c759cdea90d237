//! Cities from rasters. In: a raster of surface heights and optional rasters of the ground, of
//! crowns and of land cover, each in its place. Out: polygons of buildings, ground and crowns. Only
//! [`read`] opens files, and nothing here knows the rest of the scene.
//!
//! # From cells to faces
//!
//! 1. [`layers`] samples all rasters on the grid of the first one.
//! 2. [`standing`] tells buildings from ground, [`roofs`] cuts their roofs into pieces with a plane
//!    each.
//! 3. The plan is then a partition of cells: ground, pieces of roofs, nothing. [`outlines`] follows
//!    the lines between them, and [`straight`] draws these lines straight.
//! 4. [`buildings`] writes a polygon for each piece of a roof and a wall wherever the two sides of
//!    a line differ in height. [`floor`] writes the ground up to the same lines, and [`crowns`] the
//!    canopies.
//!
//! Roofs are planes and not cells with a height each, because annual sums depend on tilt and area:
//! a noise of 0.1 m on cells of 0.5 m tilts them by 11 degrees. Each line is drawn once for both of
//! its sides, and a wall stands on it, so that no gap opens. Where straight lines would cross, they
//! are drawn from corner to corner of cells, and where these cross too, along the sides of cells.
//! Ground that a line passes over is folded: its triangles that turn over are left out, and their
//! neighbours lie on each other or below the roof, by at most the width of a cell and a half.

mod buildings;
mod crowns;
mod finer;
mod floor;
mod landcover;
mod lattice;
pub(crate) mod layers;
mod outlines;
mod plane;
pub(crate) mod read;
mod roofs;
mod simple;
mod standing;
mod straight;
#[cfg(test)]
mod tests;
mod writer;

use std::collections::BTreeSet;
use std::path::Path;

use glam::DVec2;

use buildings::{BuildingNames, Buildings, Foot, roof_of};
use floor::{Floor, Moved, floor};
use lattice::{Lattice, Spot};
use layers::{Companions, Layer, Layers};
use outlines::{Chain, FIRST_ROOF, GROUND, OUTSIDE, chains, rings};
use roofs::{Roofs, roofs};
use standing::{Standing, standing};
use straight::{Drawing, Polyline, straightened};
use writer::Writer;

use crate::geometry::Geometry;
use crate::surface_rasters::{MIN_STEP_M, SurfaceRasters};
use heliotile_core::error::{Error, Result};
use heliotile_core::site::scene_object::ObjectNote;
use heliotile_core::text::{Message, counted};

/// Share of the movement of a line's corners by which corners of ground beside the line move.
const GIVES_WAY: f64 = 0.5;

/// Steps to the eight corners around one.
const AROUND: [Spot; 8] = [[-1, -1], [0, -1], [1, -1], [-1, 0], [1, 0], [-1, 1], [0, 1], [1, 1]];

/// Most rounds in which crossing lines are drawn closer to their cells, before all lines are drawn
/// along cells. Cities need 3.
const ROUNDS: usize = 10;

/// A city, and a note on what it is made of.
pub(crate) struct City {
    pub geometry: Geometry,
    pub note: String,
}

/// Makes a city of a raster of surface heights and its companions.
pub(crate) fn city(dsm: &Layer, with: &Companions, options: &SurfaceRasters) -> Result<City> {
    let mut layers = Layers::new(dsm, with)?;
    let mut standing = standing(&layers, options);
    let step_m = options.step(layers.cell_m());
    let roofs = roofs(&mut layers, &mut standing, step_m);
    let pieces = pieces(&standing, &roofs);
    let floor = floor(&layers, &pieces, &standing.ground);
    if roofs.list.is_empty() && floor.triangles.is_empty() {
        let hint = "nodata lies at every cell: check the band and the nodata value";
        return Err(Error::input(dsm.file, None, "the raster has no cell of ground and no building", hint));
    }
    let chains = chains(&pieces);
    let rings = rings(&chains);
    let drawn = draw(&layers, &chains, &roofs, &simple::Rings::new(&rings, &pieces));
    let mut geometry = Geometry::default();
    geometry.reference = dsm.raster.reference;
    geometry.in_metres = dsm.raster.plane_unit_m.is_some();
    let mut writer = Writer { file: dsm.file, origin: layers.grid.first, geometry };
    landcover::state(&mut writer.geometry);
    let named = |writer: &mut Writer, cells: &Vec<Spot>| {
        let name = format!("building_{}", name_of(&layers, cells));
        let object_type = "Building".to_owned();
        writer.object(&name, &ObjectNote { object: name.clone(), object_type, ..ObjectNote::default() })
    };
    let names = BuildingNames {
        roof: writer.material("RoofSurface"),
        wall: writer.material("WallSurface"),
        objects: standing.cells.iter().map(|cells| named(&mut writer, cells)).collect(),
    };
    let feet = feet(&standing, &chains, &roofs, &floor);
    let buildings = Buildings {
        layers: &layers,
        chains: &chains,
        lines: drawn.lines,
        rings: &rings,
        roofs: &roofs.list,
        feet: &feet,
        ground: &floor.heights,
        moved: &drawn.moved,
    };
    let cut = buildings.write(&mut writer, &names)?;
    floor.write(&mut writer, &layers, &drawn.moved)?;
    let finer = with.canopy.as_ref().filter(|canopy| finer::is_finer(canopy, &layers.grid));
    let finer = match finer {
        Some(canopy) => {
            finer::Site::new(canopy, with.trunk_zone.as_ref(), &layers, &pieces, &floor.heights, &drawn.moved)?
        }
        None => None,
    };
    let mean_m = with.canopy.as_ref().map_or(0.0, |canopy| crowns::mean_height(&canopy.raster));
    let crowns = match &finer {
        Some(own) => {
            writer.origin = own.layers.grid.first;
            crowns::write(&mut writer, &own.layers, &own.pieces, &own.ground, &own.moved, options, mean_m)?
        }
        None => crowns::write(&mut writer, &layers, &pieces, &floor.heights, &drawn.moved, options, mean_m)?,
    };
    let plain = if with.dem.is_some() {
        ""
    } else {
        "; without a raster of the ground, steps in height separate ground and roofs"
    };
    let cut = match cut {
        0 => String::new(),
        1 => "; the border of the raster cuts 1 building, whose wall at the cut gets no receivers".to_owned(),
        many => format!("; the border of the raster cuts {many} buildings, whose walls at the cut get no receivers"),
    };
    let roofs_with = match roofs.list.len() as u64 {
        0 => String::new(),
        count => format!(
            "{} with {} (their heights are {:.2} m off, root mean square), ",
            counted(standing.cells.len() as u64, "building"),
            counted(count, "roof"),
            roofs.off_m()
        ),
    };
    let note = format!(
        "{}: {} x {} cells became {roofs_with}{} of ground and {}{plain}{cut}",
        dsm.file.display(),
        layers.grid.columns,
        layers.grid.rows,
        counted(floor.triangles.len() as u64, "triangle"),
        counted(crowns as u64, "crown"),
    );
    let mut geometry = writer.geometry;
    geometry.warnings.extend(closed_voids(dsm.file, standing.closed).into_iter().map(Message::from));
    if roofs.have_stairs(layers.quantum_m) {
        geometry.warnings.push(format!(
            "{}: heights are whole numbers, in steps of {:.2} m; roofs are planes through the stairs that this makes of slopes, and \
             edges and low roofs may be off by half a step",
            dsm.file.display(),
            layers.quantum_m
        ).into());
    }
    if drawn.kept > 0 {
        geometry.warnings.push(
            format!(
                "{}: {} of {} lines between roofs and ground stay along cells: drawn straight they would cross others",
                dsm.file.display(),
                drawn.kept,
                chains.len()
            )
            .into(),
        );
    }
    Ok(City { geometry, note })
}

/// Returns sentences on cells without a height that got one.
fn closed_voids(file: &Path, [roofs, ground]: [usize; 2]) -> Vec<String> {
    let say = |count: usize, what: &str| {
        let cells = counted(count as u64, "cell");
        (count > 0).then(|| format!("{}: {cells} without a height {what}", file.display()))
    };
    let found = [
        say(roofs, "lie within buildings; they are closed with the planes of the roofs around them"),
        say(ground, "lie beside buildings or within the ground; they are closed with the nearest ground"),
    ];
    found.into_iter().flatten().collect()
}

/// Returns the place of an object as a name: its most north-western cell in whole metres, so that
/// tiles of a region agree on it.
fn name_of(layers: &Layers, cells: &[Spot]) -> String {
    let first = cells.iter().min_by_key(|cell| (cell[1], cell[0])).copied().unwrap_or_default();
    let place = (layers.grid.first + layers.middle(first)).floor();
    format!("{:.0}_{:.0}", place.x, place.y)
}

/// Returns the number of each cell's piece: nothing, ground or a roof.
fn pieces(standing: &Standing, roofs: &Roofs) -> Lattice<u32> {
    let mut pieces = roofs.piece.like(OUTSIDE);
    for cell in pieces.spots() {
        let roof = roofs.piece.at(cell);
        let piece = match roof {
            u32::MAX if standing.ground.at(cell).is_nan() => OUTSIDE,
            u32::MAX => GROUND,
            roof => roof + FIRST_ROOF,
        };
        pieces.set(cell, piece);
    }
    pieces
}

/// Lines of a city as they are drawn.
struct Drawn {
    lines: Vec<Polyline>,
    moved: Moved,
    /// Number of lines that stay along cells.
    kept: usize,
}

/// Draws lines straight as far as outlines of roofs do not cross themselves.
fn draw(layers: &Layers, chains: &[Chain], roofs: &Roofs, simple: &simple::Rings) -> Drawn {
    let mut drawings = vec![Drawing::Fitted; chains.len()];
    let planes = |chain: &Chain| {
        let of = |piece: u32| roof_of(&roofs.list, piece).map(|roof| roof.plane);
        Some([of(chain.left)?, of(chain.right)?])
    };
    for round in 0..=ROUNDS {
        let lines = straightened(chains, layers, planes, &drawings);
        let mut bad: BTreeSet<usize> = simple.crossed(layers, &lines);
        bad.retain(|number| drawings.get(*number) < Some(&Drawing::Cells));
        if bad.is_empty() {
            let kept = drawings.iter().filter(|drawing| **drawing == Drawing::Cells).count();
            return Drawn { moved: moved(layers, chains, &lines), lines, kept };
        }
        for (number, drawing) in drawings.iter_mut().enumerate() {
            if round + 1 >= ROUNDS {
                *drawing = Drawing::Cells;
            } else if bad.contains(&number) {
                *drawing = drawing.closer();
            }
        }
    }
    let lines = straightened(chains, layers, planes, &vec![Drawing::Cells; chains.len()]);
    Drawn { moved: Moved::new(), lines, kept: chains.len() }
}

/// Returns the places of corners along lines; corners of ground beside them move by half as much.
fn moved(layers: &Layers, chains: &[Chain], lines: &[Polyline]) -> Moved {
    let mut moved = Moved::new();
    for (chain, line) in chains.iter().zip(lines) {
        if chain.left.min(chain.right) > GROUND {
            continue;
        }
        for ([from, to], [a, b]) in line.corners.array_windows().zip(line.points.array_windows()) {
            let corners = chain.corners.get(*from..=*to).unwrap_or_default();
            let count = corners.len().saturating_sub(1).max(1) as f64;
            let along = *b - *a;
            let mut shares: Vec<f64> = Vec::with_capacity(corners.len());
            for (i, corner) in corners.iter().enumerate() {
                // The share follows the direct line for the most part, and grows with every corner.
                let ahead = (layers.corner(*corner) - *a).dot(along) / along.length_squared().max(1e-12);
                shares.push((0.75 * ahead + 0.25 * i as f64 / count).clamp(0.0, 1.0));
            }
            let goes_on = shares.get(1..shares.len().saturating_sub(1)).unwrap_or_default();
            let is_strict =
                [0.0].iter().chain(goes_on).chain(&[1.0]).collect::<Vec<_>>().array_windows().all(|[a, b]| a < b);
            for (i, (corner, share)) in corners.iter().zip(&shares).enumerate() {
                let place = match i {
                    0 => *a,
                    _ if i + 1 == corners.len() => *b,
                    _ if is_strict => a.lerp(*b, *share),
                    _ => a.lerp(*b, i as f64 / count),
                };
                moved.insert(*corner, place);
            }
        }
    }
    let mut given: Moved = Moved::new();
    for corner in moved.keys().flat_map(|corner| AROUND.map(|step| lattice::beside(*corner, step))) {
        if moved.contains_key(&corner) || given.contains_key(&corner) {
            continue;
        }
        let near = AROUND.map(|step| lattice::beside(corner, step)).into_iter();
        let by: Vec<DVec2> = near.filter_map(|near| Some(*moved.get(&near)? - layers.corner(near))).collect();
        let mean = by.iter().sum::<DVec2>() / by.len().max(1) as f64;
        given.insert(corner, layers.corner(corner) + GIVES_WAY * mean);
    }
    moved.extend(given);
    moved
}

/// Returns the foot of each building: the lowest ground beside it, or else that below it.
fn feet(standing: &Standing, chains: &[Chain], roofs: &Roofs, floor: &Floor) -> Vec<Foot> {
    let mut feet = vec![Foot { height: f64::INFINITY, meets_ground: false }; standing.cells.len()];
    for chain in chains.iter().filter(|chain| chain.left.min(chain.right) == GROUND) {
        let Some(roof) = roof_of(&roofs.list, chain.left.max(chain.right)) else { continue };
        let lowest =
            chain.corners.iter().map(|corner| f64::from(floor.heights.at(*corner))).fold(f64::INFINITY, f64::min);
        if let Some(foot) = feet.get_mut(roof.building as usize) {
            *foot = Foot { height: foot.height.min(lowest), meets_ground: true };
        }
    }
    let all = floor.heights.clone().into_values().into_iter().fold(f32::INFINITY, f32::min);
    for (foot, cells) in feet.iter_mut().zip(&standing.cells) {
        if foot.height.is_infinite() {
            let below = standing
                .below
                .as_ref()
                .map(|below| cells.iter().map(|cell| below.at(*cell)).fold(f32::INFINITY, f32::min));
            let found = below.unwrap_or(all);
            let lowest = roofs.list.iter().map(|roof| roof.plane.height).fold(f64::INFINITY, f64::min);
            foot.height = if found.is_finite() { f64::from(found) } else { lowest - MIN_STEP_M };
        }
    }
    feet
}
