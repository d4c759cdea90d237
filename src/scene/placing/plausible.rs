//! Checks for geometry and receivers in a wrong unit or place. In: the extents of files, and
//! receivers. Out: a warning for each doubt, with what to do; an error where no intention is
//! possible.
//!
//! Every threshold stands between what is built and what a wrong unit makes of it. Wrong units are
//! factors of 39 (inches) to 1000 (millimetres) or 100,000 (degrees); wrong systems are hundreds of
//! kilometres.

use std::path::Path;

use glam::{DVec2, DVec3};

use crate::ground::endless;
use crate::mesh::bounds;
use crate::placing::extent::Extent;
use crate::{LoadReport, Scene};
use heliotile_core::error::{Error, Result};
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::{Message, message};
use heliotile_place::reference::Reference;

/// Median height of walls, by area, that no city reaches, metres: storeys are 3 m, faces of towers
/// 50 to 200 m (a quarter of Manhattan has 100 m). A house in centimetres has 300 to 1000.
const TALLEST_WALLS_M: f64 = 300.0;

/// Height of walls, metres, and ratio of width to height, beyond which walls are storeys in
/// centimetres (250 to 300): the largest halls are 160 m high and as wide, and towers are narrower
/// than high.
const WIDE_WALLS_M: f64 = 200.0;
const WIDE_WALLS_RATIO: f64 = 1.5;

/// Tallest building, metres: the highest one has 828 m. It counts for a file among several, which
/// may be one building.
const TALLEST_BUILDING_M: f64 = 850.0;

/// Height of walls from which millimetres are assumed, metres: such walls would still be 20 m high
/// in centimetres, and 2 m in millimetres.
const MILLIMETRES_FROM: f64 = 2_000.0;

/// Tallest height, metres, and steepest ratio of height to width: taller geometry is terrain, which
/// is many times wider.
const TALLEST_M: f64 = 3_000.0;
const STEEPEST: f64 = 0.5;

/// Smallest extent of a site, metres.
const SMALLEST_M: f64 = 0.1;

/// Largest width and least height of a region in degrees, and least ratio of its height to its
/// width: a city of 0.1 degrees with houses of 3 m has a ratio of 30.
const DEGREES_WIDE: f64 = 1.0;
const DEGREES_HIGH: f64 = 1.0;
const DEGREES_RATIO: f64 = 20.0;

/// Largest gap between two parts of a site without a warning, metres: beyond it a hill of 300 m is
/// less than a degree high.
const FAR_PART_M: f64 = 20_000.0;

/// Largest gap between two parts of a site, metres; beyond it is an error: the longest sight
/// between mountains is 538 km.
const OUT_OF_SIGHT_M: f64 = 600_000.0;

/// Largest height of a part above the highest point of a raster that it stands on, metres: towers
/// with nothing below them, tethered balloons.
const FLOATING_M: f64 = 300.0;

/// Largest distance of receivers from all geometry, metres: a wall of 100 m is half a degree high
/// there.
const FAR_RECEIVER_M: f64 = 10_000.0;

/// Adds warnings about the files of a scene; fails if a file lies out of sight of the others.
pub(crate) fn doubts(extents: &[Extent], report: &mut LoadReport) -> Result<()> {
    report.warnings.extend(unit(extents));
    far_parts(extents, report)?;
    report.warnings.extend(above_or_below(extents));
    Ok(())
}

/// Returns a warning about geometry whose unit is not the metre.
fn unit(extents: &[Extent]) -> Option<Message> {
    let solid = || extents.iter().filter(|extent| !extent.raster);
    let (low, high) = bounds(solid().flat_map(|extent| extent.bounds));
    let first = solid().next()?;
    let size = high - low;
    let several = solid().nth(1).is_some();
    let told =
        |of: &Extent| if of.scale == 1.0 { String::new() } else { format!(" (read with a scale of {})", of.scale) };
    let file = first.file.display();
    let (wide, high) = (size.x.max(size.y), size.z);
    // Degrees come first, because no scale corrects them.
    if degrees(low, size) {
        return Some(format!(
            "{file}: x and y look like degrees ({:.4} {:.4}, {wide:.4} wide and {high:.1} high), but scenes are in metres: reproject the \
             file, for instance to UTM",
            low.x, low.y
        ).into());
    }
    let most = if several { TALLEST_BUILDING_M } else { TALLEST_WALLS_M };
    let tall = solid().find_map(|extent| Some((extent, extent.walls.median_m().filter(|tall| *tall > most)?)));
    if let Some((extent, tall)) = tall {
        if extent.is_raised {
            return Some(raised_hint(extent, tall));
        }
        let (unit, scale) = if tall > MILLIMETRES_FROM { ("millimetres", 0.001) } else { ("centimetres", 0.01) };
        let give = if several { "scale = " } else { "{scale} " };
        let whose = if several { " in its [[scene]] of a site.toml" } else { "" };
        let (file, told) = (extent.file.display(), told(extent));
        return Some(
            message!(
                "{file}: walls are about {tall:.0} m high{told}, {:.1} m if the file is in {unit}: then give ",
                tall * scale
            )
            .and(give)
            .and(format!("{}{whose} ({} for inches)", scale * extent.scale, 0.0254 * extent.scale)),
        );
    }
    let wide_walls = |extent: &&Extent| {
        let sizes = extent.walls.median_m().zip(extent.walls.median_width_m());
        sizes.is_some_and(|(tall, wide)| tall > WIDE_WALLS_M && wide > WIDE_WALLS_RATIO * tall)
    };
    if let Some(extent) = solid().find(wide_walls) {
        let tall = extent.walls.median_m().unwrap_or_default();
        if extent.is_raised {
            return Some(raised_hint(extent, tall));
        }
        let (file, told) = (extent.file.display(), told(extent));
        return Some(
            message!(
                "{file}: walls are about {tall:.0} m high and even wider{told}: if the file is in centimetres, give "
            )
            .and(if several { "scale = " } else { "{scale} " })
            .and(format!("{}", 0.01 * extent.scale))
            .and(if several { " in its [[scene]] of a site.toml" } else { "" }),
        );
    }
    let told = told(first);
    if high > TALLEST_M && high > STEEPEST * wide {
        return Some(message!(
            "{file}: the geometry is {high:.0} m high and {wide:.0} m wide{told}: if the file is in millimetres give {{scale}} {}",
            0.001 * first.scale
        ));
    }
    (size.max_element() < SMALLEST_M).then(|| {
        message!(
            "{file}: the geometry is {:.4} m wide and {high:.4} m high{told}: if the file is in kilometres give {{scale}} {}, or leave the \
             scale out",
            wide,
            1000.0 * first.scale
        )
    })
}

/// Returns the warning about walls that no building of a column of heights has. A scale would
/// shrink the plan, too.
fn raised_hint(extent: &Extent, tall_m: f64) -> Message {
    message!(
        "{}: walls are about {tall_m:.0} m high: if the column holds heights of roofs above the sea, give {{height_above}} sea, and the \
         ground as terrain or as {{base}} COLUMN; if it holds centimetres, give {{height}} COLUMN[cm]",
        extent.file.display()
    )
}

/// Returns true if plane coordinates look like degrees: within their range, far from 0 for their
/// size, and much too high for it.
fn degrees(low: DVec3, size: DVec3) -> bool {
    let (wide, middle) = (size.x.max(size.y), low + 0.5 * size);
    let range = |x: f64, y: f64| x.abs() <= 180.0 && y.abs() <= 90.0;
    let in_range = range(middle.x, middle.y) || range(middle.y, middle.x);
    wide < DEGREES_WIDE
        && size.z > DEGREES_HIGH
        && size.z > DEGREES_RATIO * wide
        && in_range
        && middle.truncate().length() > 1.0_f64.max(10.0 * wide)
}

/// Returns the gap between two boxes in plan, metres.
fn gap(a: [DVec3; 2], b: [DVec3; 2]) -> f64 {
    let [a, b] = [a, b].map(|of| of.map(DVec3::truncate));
    (a[0] - b[1]).max(b[0] - a[1]).max(DVec2::ZERO).length()
}

/// Warns of groups of files that lie far from the first file, and refuses groups out of its sight.
fn far_parts(extents: &[Extent], report: &mut LoadReport) -> Result<()> {
    let mut left: Vec<&Extent> = extents.iter().collect();
    let mut groups: Vec<Vec<&Extent>> = Vec::new();
    while let Some(seed) = left.first().copied() {
        let mut group = vec![seed];
        left.remove(0);
        let mut next = 0;
        while let Some(from) = group.get(next).copied() {
            next += 1;
            left.retain(|other| {
                let near = gap(from.bounds, other.bounds) <= FAR_PART_M;
                if near {
                    group.push(other);
                }
                !near
            });
        }
        groups.push(group);
    }
    let Some((home, others)) = groups.split_first() else { return Ok(()) };
    for other in others {
        let pairs = home.iter().flat_map(|a| other.iter().map(move |b| (*a, *b)));
        let nearest = pairs.min_by(|(a, b), (c, d)| gap(a.bounds, b.bounds).total_cmp(&gap(c.bounds, d.bounds)));
        let Some((a, b)) = nearest else { continue };
        let apart_m = gap(a.bounds, b.bounds);
        let what = format!("lies {:.0} km from {}", apart_m / 1000.0, a.file.display());
        let hint = hint_of(a, b);
        if apart_m > OUT_OF_SIGHT_M {
            return Err(Error::input(&b.file, None, format!("{what}, out of sight of it"), hint));
        }
        report.warnings.push(format!("{} {what}, with nothing between them: {hint}", b.file.display()).into());
    }
    Ok(())
}

/// Returns the hint for two files that lie far apart.
fn hint_of(a: &Extent, b: &Extent) -> String {
    let name = |of: &Extent| of.file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let said = |of: &Extent| match of.reference() {
        Some(Reference::Epsg(epsg)) => format!("{} is in EPSG:{epsg}", name(of)),
        Some(place) => format!("{} lies at {place} in coordinates of its own", name(of)),
        None => format!("{} names no coordinate system", name(of)),
    };
    let systems = match (a.reference(), b.reference()) {
        (Some(one), Some(other)) if one.is_same(&other) => format!("both are in {one}"),
        (None, None) => "neither names its coordinate system".to_owned(),
        _ => format!("{}, {}", said(a), said(b)),
    };
    format!(
        "{systems}; reproject one of them to the system of the other, or move one with `offset = [x, y, z]` in a site.toml (`heliotile \
         info` of each shows where it lies)"
    )
}

/// Returns a warning about geometry that lies wholly below or far above the raster that it stands
/// on.
fn above_or_below(extents: &[Extent]) -> Option<Message> {
    extents.iter().filter(|raster| raster.raster).find_map(|raster| {
        let [lowest, highest] = raster.bounds;
        let inside = |extent: &&Extent| {
            let [low, high] = extent.bounds;
            let middle = 0.5 * (low + high);
            !extent.raster && middle.truncate().cmpge(lowest.truncate()).all() && middle.truncate().cmple(highest.truncate()).all()
        };
        extents.iter().filter(inside).find_map(|extent| {
            let [low, high] = extent.bounds;
            let (lifts, words) = match extent {
                _ if high.z < lowest.z => (lowest.z, "below the lowest"),
                _ if low.z > highest.z + FLOATING_M => (highest.z, "above the highest"),
                _ => return None,
            };
            Some(message!(
                "{} ({:.0} to {:.0} m high) lies wholly {words} point of {} ({lifts:.0} m): if its heights are not above sea level, give \
                 the height of its z = 0 with {{elevation}}, or elevation_m in site.toml",
                extent.file.display(),
                low.z,
                high.z,
                raster.file.display()
            ))
        })
    })
}

/// Returns the lowest and the highest corner of a scene without its endless ground; `None` if there
/// is nothing else.
fn near_bounds(scene: &Scene) -> Option<[DVec3; 2]> {
    let endless = scene.materials.iter().position(|material| material.name == endless::NAME);
    let mesh = &scene.mesh;
    let of_scene =
        mesh.triangle_material.iter().enumerate().filter(|(_, material)| Some(usize::from(**material)) != endless);
    let (low, high) = bounds(of_scene.flat_map(|(triangle, _)| mesh.triangle_points(triangle)));
    low.is_finite().then(|| [low + mesh.origin, high + mesh.origin])
}

/// Returns a warning about objects of a file that lie far from a scene to which they are added;
/// both are given by their least and greatest corners.
pub fn far_objects(file: &Path, objects: [DVec3; 2], scene: [DVec3; 2]) -> Option<Message> {
    let apart_m = gap(objects, scene);
    (apart_m > FAR_PART_M).then(|| {
        message!(
            "{} lies {:.0} km from the scene, with nothing between them: give it coordinates of the scene, or {{up}} y \
             if y points up in it",
            file.display(),
            apart_m / 1000.0
        )
    })
}

/// Receivers that lie far from all geometry.
#[derive(Clone, Debug, PartialEq)]
pub struct FarReceivers {
    /// Who lies where, and a reason.
    pub what: String,
    /// True if all would lie at the scene with x and y swapped, or in another unit.
    pub is_mistake: bool,
}

/// Returns the receivers that lie far from all geometry: `low` and `high` bound all `count` of
/// them, and one is the farthest.
pub fn far_receivers(
    scene: &Scene,
    [low, high]: [DVec3; 2],
    farthest: &Receiver,
    count: usize,
) -> Option<FarReceivers> {
    let box_of = near_bounds(scene)?;
    let at = farthest.position;
    let apart_m = gap(box_of, [at; 2]);
    if apart_m <= FAR_RECEIVER_M {
        return None;
    }
    let all = gap(box_of, [low, high]) > FAR_RECEIVER_M;
    let who = if all { format!("all {count} receivers lie far from the scene: ") } else { String::new() };
    let near = |position: DVec3| gap(box_of, [position; 2]) < 1_000.0;
    let local = at.truncate().abs().max_element() < FAR_RECEIVER_M;
    let mistake = match at {
        p if near(DVec3::new(p.y, p.x, p.z)) => Some("x and y look swapped"),
        p if near(0.001 * p) => Some("they look like millimetres, but are read as metres"),
        p if near(p / 0.3048) || near(0.3048 * p) => {
            Some("the receivers or the scene look like feet, but are read as metres")
        }
        _ => None,
    };
    let why = mistake.unwrap_or(match local {
        true => "they look local: add the origin of the scene's coordinates to them",
        false => "are they in another coordinate system?",
    });
    let [from, to] = box_of;
    let what = format!(
        "{who}receiver {} at {:.1} {:.1} is {:.0} km from the scene, which reaches from {:.1} {:.1} to {:.1} {:.1}: {why}",
        farthest.id,
        at.x,
        at.y,
        apart_m / 1000.0,
        from.x,
        from.y,
        to.x,
        to.y
    );
    Some(FarReceivers { what, is_mistake: all && mistake.is_some() })
}
