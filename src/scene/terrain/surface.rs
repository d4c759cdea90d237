//! The surface of a raster. In: heights at the middles of cells. Out: triangles between them; cells
//! that touch nodata have none.
//!
//! A cell between four samples is cut along the diagonal through the sample whose column and row
//! are odd. Diagonals alternate, so that no direction is favoured, and a thinned surface (see
//! [`crate::terrain::thinning`]) is the same where nothing was left out. The surface ends at the
//! outermost samples, half a cell within the raster's edges.

use std::path::Path;

use crate::geometry::Geometry;
use crate::terrain::focus::{Focus, curvature_drop, curvature_words};
use crate::terrain::raster::Raster;
use crate::terrain::thinning::{Sample, thin};
use heliotile_core::error::{Error, Result};

/// Name of the material of terrain, and of its object if there is one raster.
pub(crate) const NAME: &str = "terrain";

/// Default limit of the horizon's error, degrees; the mean error is a quarter of it, less than a
/// minute of a sunrise. Finer limits cost more than they gain: for a house in mountains 0.05
/// degrees changed a year's sums by 0.02 % and took three times as long.
const HORIZON_DEG: f64 = 0.2;

/// Distance beyond the focus from which the Earth's curvature counts, metres: there it lowers 6.8
/// m, 0.04 degrees.
const CURVED_BEYOND_M: f64 = 10_000.0;

/// Options for the surface of a raster.
pub(crate) struct RasterOptions<'a> {
    pub file: &'a Path,
    pub object: &'a str,
    /// Box from which the raster is a horizon; `None` if the raster is the whole scene.
    pub focus: Option<Focus>,
    /// Largest error of the horizon, degrees; `None` for the default.
    pub horizon_deg: Option<f64>,
}

/// Returns the surface of a raster, and a note on its thinning.
pub(crate) fn surface(mut raster: Raster, wanted: &RasterOptions) -> Result<(Geometry, Option<String>)> {
    let mut geometry = Geometry::default();
    geometry.warnings.append(&mut raster.warnings);
    geometry.reference = raster.reference;
    geometry.in_metres = raster.plane_unit_m.is_some();
    if let Some(angle) = wanted.horizon_deg
        && !(0.0..=10.0).contains(&angle)
    {
        let what = format!("the horizon error is {angle} degrees");
        let hint = "give 0 (full resolution) to 10 degrees; 0.2 is usual";
        return Err(Error::input(wanted.file, None, what, hint));
    }
    let (low, high) = raster.bounds();
    let middle = 0.5 * (low + high);
    let alone = wanted.focus.is_none();
    let focus = wanted.focus.unwrap_or_else(|| Focus::around(middle, middle));
    let limit_deg = match (wanted.horizon_deg, alone) {
        (Some(angle), _) => angle,
        (None, true) => 0.0,
        (None, false) => HORIZON_DEG,
    };
    let reach = focus.reach(low, high);
    let curved = !alone && reach > CURVED_BEYOND_M;
    // Heights are lowered before thinning, whose limit holds for the ground as it is seen.
    if curved {
        raster.lower(|place| curvature_drop(focus.distance_squared(place)));
    }
    let whole = all(&raster).count();
    let (found, left_out, largest_deg) = if limit_deg > 0.0 {
        let thinned = thin(&raster, &focus, limit_deg);
        (fill(&mut geometry, &raster, thinned.triangles.into_iter(), wanted)?, thinned.nodata, thinned.largest_deg)
    } else {
        let cells = (raster.grid.columns - 1) * (raster.grid.rows - 1);
        (fill(&mut geometry, &raster, all(&raster), wanted)?, 2 * cells - whole, 0.0)
    };
    if found == 0 {
        let hint = "nodata lies at a corner of every cell: fill the gaps, or check the nodata value";
        return Err(Error::input(wanted.file, None, "the raster has no cell with heights at its corners", hint));
    }
    if left_out > 0 {
        let reason = if raster.is_joined { "at nodata or beyond its tiles" } else { "at nodata" };
        geometry.left_out.insert(format!("{reason} (triangles of the terrain)"), left_out);
    }
    let note = (!alone || limit_deg > 0.0).then(|| {
        let (file, km) = (wanted.file.display(), reach / 1000.0);
        let seen_from = if alone { "the raster's centre" } else { "the other geometry" };
        let level = if curved { curvature_words() } else { "not lowered by the Earth's curvature".into() };
        let error = match limit_deg > 0.0 {
            true => {
                format!(
                    "the horizon seen from {seen_from} is off by at most {largest_deg:.3} degrees (limit {limit_deg})"
                )
            }
            false => format!("the horizon seen from {seen_from} is exact"),
        };
        format!("{file}: far terrain thinned to {found} triangles of {whole}; {error}; it reaches {km:.1} km, {level}")
    });
    Ok((geometry, note))
}

/// Returns both triangles of each cell, row by row.
fn all(raster: &Raster) -> impl Iterator<Item = [Sample; 3]> + '_ {
    let (columns, rows) = (raster.grid.columns as i64 - 1, raster.grid.rows as i64 - 1);
    (0..rows).flat_map(move |row| (0..columns).map(move |column| [column, row])).flat_map(move |[column, row]| {
        let (odd_column, odd_row) = (column | 1, row | 1);
        let (even_column, even_row) = (2 * column + 1 - odd_column, 2 * row + 1 - odd_row);
        let (a, b) = ([even_column, even_row], [odd_column, odd_row]);
        let halves = [[a, b, [odd_column, even_row]], [a, b, [even_column, odd_row]]];
        let is_missing = |&[column, row]: &Sample| raster.height(column, row).is_nan();
        halves.into_iter().filter(move |corners| !corners.iter().any(is_missing))
    })
}

/// Adds triangles to the geometry, facing up; returns their number.
fn fill(
    geometry: &mut Geometry,
    raster: &Raster,
    triangles: impl Iterator<Item = [Sample; 3]>,
    wanted: &RasterOptions,
) -> Result<usize> {
    let (material, object) = (geometry.materials.id(NAME), geometry.objects.id(wanted.object));
    let mut numbers = vec![u32::MAX; raster.samples()];
    let mut found = 0;
    for mut corners in triangles {
        let [[ax, ay], [bx, by], [cx, cy]] = corners;
        // Rows go southwards, so that a clockwise turn in columns and rows is counter-clockwise on
        // the ground.
        if (bx - ax) * (cy - ay) > (by - ay) * (cx - ax) {
            corners.swap(0, 1);
        }
        for [column, row] in corners {
            let place = row as usize * raster.grid.columns + column as usize;
            let known = numbers.get(place).copied().unwrap_or(u32::MAX);
            let number = match known {
                u32::MAX => {
                    let position = raster.plan(column, row).extend(f64::from(raster.height(column, row)));
                    let number = geometry.push_vertex(wanted.file, position)?;
                    if let Some(slot) = numbers.get_mut(place) {
                        *slot = number;
                    }
                    number
                }
                number => number,
            };
            geometry.push_corner(number);
        }
        geometry.end_face(material, object, 0);
        found += 1;
    }
    Ok(found)
}
