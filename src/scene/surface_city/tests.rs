//! Tests of cities from generated rasters: blocks, gables, noise, crowns, and rasters that are no
//! city at all.

use std::path::Path;

use glam::{DVec2, DVec3};

use super::*;
use crate::terrain::raster::{Grid, Raster};
use heliotile_core::site::semantics::SurfaceKind;

/// Returns a raster of a function of the place, with cells of a width.
fn raster(columns: usize, rows: usize, cell_m: f64, height: impl Fn(DVec2) -> f64) -> Raster {
    let grid = Grid { columns, rows, first: DVec2::new(1000.0, 2000.0), step: DVec2::splat(cell_m) };
    let place = |i: usize| DVec2::new((i % columns) as f64, -((i / columns) as f64)) * cell_m;
    Raster::plain(grid, (0..columns * rows).map(|i| height(place(i)) as f32).collect())
}

fn layer(raster: Raster) -> Layer<'static> {
    Layer { file: Path::new("r.tif"), raster }
}

/// Returns noise of -1 to 1 that depends on the place alone.
fn noise(place: DVec2) -> f64 {
    let x = (place.x * 12.9898 + place.y * 78.233).sin() * 43_758.545_3;
    2.0 * (x - x.floor()) - 1.0
}

/// Returns a place in a frame that is turned about a point of the raster.
fn turned(place: DVec2, degrees: f64) -> DVec2 {
    DVec2::from_angle(-degrees.to_radians()).rotate(place - DVec2::new(14.75, -14.75))
}

/// Areas by kind, m2.
#[derive(Debug, Default)]
pub(super) struct Areas {
    roof: f64,
    wall: f64,
    ground: f64,
    canopy: f64,
    /// Area of roofs in plan.
    roof_plan: f64,
}

pub(super) fn areas(geometry: &Geometry) -> Areas {
    let mut found = Areas::default();
    for number in 0..geometry.face_count() {
        for triangle in crate::polygon::triangles_of(geometry, number) {
            let area = crate::covering::surfaces::area_vector(&triangle);
            match geometry.note_of(number).kind {
                Some(SurfaceKind::Roof) => {
                    found.roof += area.length();
                    found.roof_plan += area.z;
                }
                Some(SurfaceKind::Wall) => found.wall += area.length(),
                Some(SurfaceKind::Ground) => found.ground += area.z,
                _ => found.canopy += area.length(),
            }
        }
    }
    found
}

fn made(dsm: Raster, dem: Option<Raster>) -> City {
    let with = Companions { dem: dem.map(layer), ..Companions::default() };
    city(&layer(dsm), &with, &SurfaceRasters::default()).expect("a city")
}

/// Returns the horizontal length of the sum of all area vectors, m2; 0 if faces close around
/// buildings.
fn open_edges(geometry: &Geometry) -> f64 {
    // Faces that meet along vertical lines have corners of their own, so that edges cannot be
    // compared.
    let mut sum = DVec3::ZERO;
    for number in 0..geometry.face_count() {
        for triangle in crate::polygon::triangles_of(geometry, number) {
            sum += crate::covering::surfaces::area_vector(&triangle);
        }
    }
    sum.truncate().length()
}

/// A block of 10 x 10 x 8 m on flat ground at cells of 0.5 m, along the axes, turned by 30 and by
/// 17 degrees, with a raster of the ground and without, has a roof of 100 m2, walls of 320 m2 and
/// ground of 800 m2, within 0.1 % along the axes and within 3 % turned, and at most 8 walls.
#[test]
fn blocks_have_their_areas() {
    for degrees in [0.0, 30.0, 17.0] {
        let height = |place: DVec2| {
            let p = turned(place, degrees);
            if p.abs().max_element() < 5.0 { 28.0 } else { 20.0 }
        };
        for with_dem in [true, false] {
            let dem = with_dem.then(|| raster(60, 60, 0.5, |_| 20.0));
            let City { geometry, note } = made(raster(60, 60, 0.5, height), dem);
            let found = areas(&geometry);
            let most = if degrees == 0.0 { 0.001 } else { 0.03 };
            for (area, truth) in [(found.roof, 100.0), (found.wall, 320.0), (found.ground, 800.0)] {
                assert!((area / truth - 1.0).abs() < most, "{degrees} {with_dem}: {found:?} {note}");
            }
            assert!(open_edges(&geometry) < 1e-6, "{degrees}: {}", open_edges(&geometry));
            let walls =
                (0..geometry.face_count()).filter(|i| geometry.note_of(*i).kind == Some(SurfaceKind::Wall)).count();
            assert!(walls <= 8, "{walls} walls");
        }
    }
}

/// A gabled house of 12 x 8 m with a pitch of 40 degrees, turned by 20, with noise of 0.1 m, has 2
/// roofs with 125.3 m2 within 3 % that lean by 40 degrees within 1.
#[test]
fn gables_keep_their_pitch() {
    let height = |place: DVec2| {
        let p = turned(place, 20.0);
        let is_in = p.x.abs() < 6.0 && p.y.abs() < 4.0;
        10.0 + if is_in { 5.0 + (4.0 - p.y.abs()) * 40.0_f64.to_radians().tan() } else { 0.0 } + 0.1 * noise(place)
    };
    let City { geometry, note } = made(raster(60, 60, 0.5, height), Some(raster(60, 60, 0.5, |_| 10.0)));
    let found = areas(&geometry);
    let truth = 96.0 / 40.0_f64.to_radians().cos();
    assert!((found.roof / truth - 1.0).abs() < 0.03, "{found:?} {truth} {note}");
    let pitch = (found.roof_plan / found.roof).acos().to_degrees();
    assert!((pitch - 40.0).abs() < 1.0, "{pitch} {note}");
    let roofs = (0..geometry.face_count()).filter(|i| geometry.note_of(*i).kind == Some(SurfaceKind::Roof)).count();
    assert_eq!(roofs, 2, "{note}");
}

/// A block of 30 x 20 x 12 m with a void of 20 x 12 m or 5 voids of a cell in its roof, and with
/// a ring of 1.5 m without heights around it, has a roof of 600 m2, walls of 1200 m2 and ground of
/// 1000 m2, with a raster of the ground and without; so has the gabled block with a void across
/// its ridge, 670.8 m2 of roof. What was closed is said in 1 sentence. Open nodata at the border
/// stays.
#[test]
fn voids_are_closed() {
    let flat = |_: DVec2| 12.0;
    let gable = |p: DVec2| 6.0 + 0.5 * (10.0 - p.y.abs());
    let [large, few] = [
        |p: DVec2| p.x.abs() < 10.0 && p.y.abs() < 6.0,
        |p: DVec2| {
            [-9.25, -4.25, 0.25, 5.25, 9.25].iter().any(|x| (p - DVec2::new(*x, 0.6 * x)).abs().max_element() < 0.26)
        },
    ];
    fn is_in(p: DVec2, by: f64) -> bool {
        p.x.abs() < 15.0 + by && p.y.abs() < 10.0 + by
    }
    let ring = |p: DVec2| is_in(p, 1.5) && !is_in(p, 0.0);
    type Height = fn(DVec2) -> f64;
    type Void = fn(DVec2) -> bool;
    let cases: [(Height, Void, f64, &str); 4] = [
        (flat, large, 600.0, "within buildings"),
        (flat, few, 600.0, "within buildings"),
        (flat, ring, 600.0, "nearest ground"),
        (gable, large, 670.8, "within buildings"),
    ];
    for (case, (roof, void, area, said)) in cases.into_iter().enumerate() {
        let height = |place: DVec2| {
            let p = place - DVec2::new(19.75, -19.75);
            match p {
                p if void(p) => f64::NAN,
                p if is_in(p, 0.0) => roof(p),
                _ => 0.0,
            }
        };
        for with_dem in [false, true] {
            let dem = with_dem.then(|| raster(80, 80, 0.5, |_| 0.0));
            let City { geometry, note } = made(raster(80, 80, 0.5, height), dem);
            let found = areas(&geometry);
            let walls = if case == 3 { 700.0 } else { 1200.0 };
            for (area, truth) in [(found.roof, area), (found.wall, walls), (found.ground, 1000.0)] {
                assert!((area / truth - 1.0).abs() < 0.002, "{case} {with_dem}: {found:?} {note}");
            }
            let closed = geometry.warnings.iter().filter(|text| text.contains("without a height")).count();
            // With a raster of the ground nothing is open beside the block.
            let is_said = !(with_dem && said.contains("ground"));
            assert_eq!(closed, usize::from(is_said), "{:?}", geometry.warnings);
            assert!(!is_said || geometry.warnings[0].contains(said), "{:?}", geometry.warnings);
        }
    }
    let border = |place: DVec2| if place.x < 5.0 { f64::NAN } else { 3.0 };
    let found = areas(&made(raster(40, 40, 1.0, border), None).geometry);
    assert!((found.ground - 35.0 * 40.0).abs() < 1.0, "{found:?}");
}

/// A block of 8 m height that the border of the raster cuts to 6 x 10 m has walls of 176 m2 that
/// get receivers and one of 80 m2 at the cut that gets none, also if nodata
/// lies beyond the cut.
#[test]
fn cuts_are_no_facades() {
    for nodata in [0.0, 3.0] {
        let height = |place: DVec2| match place {
            p if p.x < nodata => f64::NAN,
            p if p.x < 6.0 + nodata && (p.y + 14.75).abs() < 5.0 => 28.0,
            _ => 20.0,
        };
        let City { geometry, note } = made(raster(60, 60, 0.5, height), None);
        let mut walls = [0.0; 2];
        for number in 0..geometry.face_count() {
            let of = geometry.note_of(number);
            if of.kind == Some(SurfaceKind::Wall) {
                let triangles = crate::polygon::triangles_of(&geometry, number);
                let area = triangles.iter().map(|t| crate::covering::surfaces::area_vector(t).length()).sum::<f64>();
                walls[usize::from(of.exposed == Some(false))] += area;
            }
        }
        assert!((walls[0] - 176.0).abs() < 0.5 && (walls[1] - 80.0).abs() < 0.5, "{nodata}: {walls:?} {note}");
        assert!(note.ends_with("the border of the raster cuts 1 building, whose wall at the cut gets no receivers"));
    }
}

/// Gables in whole metres have 2 roofs with their areas within 3 % and their pitch within 2
/// degrees: 30 x 20 m with a pitch of 26.6 degrees along the axes (670.8 m2) at cells of 1 m, and
/// turned ones of 20 x 14 m with pitches of 20, 30 and 45 degrees at cells of 1 and 0.5 m. Stairs
/// are said once. Level roofs a metre apart stay two, with walls between them, and nothing is said.
#[test]
fn whole_metres_make_no_stairs() {
    let whole = |cells: usize, cell_m: f64, height: &dyn Fn(DVec2) -> f64| {
        let mut dsm = raster(cells, cells, cell_m, |place| height(place).round());
        dsm.quantum_m = 1.0;
        made(dsm, None)
    };
    let cases = [
        (26.565, 0.0, 1.0, [15.0, 10.0]),
        (20.0, 17.0, 1.0, [10.0, 7.0]),
        (30.0, 17.0, 1.0, [10.0, 7.0]),
        (45.0, 30.0, 0.5, [10.0, 7.0]),
    ];
    for (pitch, turn, cell_m, [along, across]) in cases {
        let rise = f64::to_radians(pitch).tan();
        let height = |place: DVec2| {
            let p = DVec2::from_angle(f64::to_radians(-turn)).rotate(place - DVec2::new(19.75, -19.75));
            if p.x.abs() < along && p.y.abs() < across { 106.0 + rise * (across - p.y.abs()) } else { 100.0 }
        };
        let City { geometry, note } = whole((40.0 / cell_m) as usize, cell_m, &height);
        let found = areas(&geometry);
        let truth = 4.0 * along * across / f64::to_radians(pitch).cos();
        assert!((found.roof / truth - 1.0).abs() < 0.03, "{pitch} {turn}: {found:?} {truth} {note}");
        let leans = (found.roof_plan / found.roof).acos().to_degrees();
        assert!((leans - pitch).abs() < 2.0, "{leans} {pitch} {turn} {note}");
        assert!(note.contains("1 building with 2 roofs"), "{note}");
        assert_eq!(geometry.warnings.iter().filter(|text| text.contains("in steps of 1.00 m")).count(), 1);
    }
    let level = |p: DVec2| match p {
        p if p.x.abs() >= 35.0 || p.x < 5.0 || p.y.abs() >= 30.0 || p.y > -10.0 => 0.0,
        p if p.x < 20.0 => 8.0,
        _ => 9.0,
    };
    let City { geometry, note } = whole(40, 1.0, &level);
    let found = areas(&geometry);
    assert!(note.contains("1 building with 2 roofs") && geometry.warnings.is_empty(), "{note} {:?}", geometry.warnings);
    assert!((found.roof - 600.0).abs() < 0.5 && (found.wall - 870.0).abs() < 0.5, "{found:?}");
}

/// Noise of 0.3 m on a slope, and a car of 1.6 m, make no wall and no roof: there are 900 m2 of
/// ground alone, within 1 m2.
#[test]
fn noise_makes_no_wall() {
    let height = |place: DVec2| {
        let car = (place.x - 10.0).abs() < 2.0 && (place.y + 10.0).abs() < 1.0;
        50.0 + 0.1 * place.x + 0.3 * noise(place) + if car { 1.6 } else { 0.0 }
    };
    for dem in [None, Some(raster(60, 60, 0.5, |place| 50.0 + 0.1 * place.x))] {
        let found = areas(&made(raster(60, 60, 0.5, height), dem).geometry);
        assert_eq!((found.roof, found.wall), (0.0, 0.0), "{found:?}");
        assert!((found.ground - 900.0).abs() < 1.0, "{found:?}");
    }
}

/// A lawn has a crown of 6 x 6 m and 8 m height. The hull of the crown has a top at 8 m and an
/// underside at 2 m above the ground, 36 m2 each and 144 m2 at the sides; it is a volume of 1
/// m2/m3, and the hull is an object beside the buildings. The lawn keeps its 900 m2 and its
/// reflectance of 0.16.
#[test]
fn a_crown_over_a_lawn_is_a_hull() {
    let crown = |place: DVec2| if (place - DVec2::new(14.75, -14.75)).abs().max_element() < 3.0 { 8.0 } else { 0.0 };
    let with = Companions {
        dem: Some(layer(raster(60, 60, 0.5, |_| 5.0))),
        canopy: Some(layer(raster(60, 60, 0.5, crown))),
        landcover: Some(layer(raster(60, 60, 0.5, |_| 5.0))),
        trunk_zone: None,
    };
    // The crown stands in the surface, too, as in many rasters.
    let dsm = raster(60, 60, 0.5, |place| 5.0 + crown(place));
    let geometry = city(&layer(dsm), &with, &SurfaceRasters::default()).expect("a city").geometry;
    let found = areas(&geometry);
    assert!((found.canopy - 216.0).abs() < 1e-6 && (found.ground - 900.0).abs() < 1e-6, "{found:?}");
    let canopy = &geometry.stated["canopy"];
    assert!((canopy.leaf_area_density().expect("a volume") - 1.0).abs() < 1e-12 && canopy.scatters());
    assert_eq!((canopy.group.as_deref(), geometry.stated["grass"].diffuse), (Some("trees"), 0.16));
    let trees: Vec<_> = geometry.object_notes.values().filter(|note| note.beside).collect();
    assert_eq!((trees.len(), trees[0].object.as_str()), (1, "trees_1012_1988"));
}

/// The underside of a crown of 6 x 6 x 8 m is stated in cells of 1 m. At 3 m its sides have 120 m2;
/// at 0 m it stands on the ground; where nothing is stated the underside lies at 2 m. At 9 m, above
/// the top, a warning counts the 144 cells and sides have 9.6 m2.
#[test]
fn undersides_of_crowns_are_read() {
    let crown = |place: DVec2| if (place - DVec2::new(14.75, -14.75)).abs().max_element() < 3.0 { 8.0 } else { 0.0 };
    for (base, sides) in [(3.0, 120.0), (0.0, 192.0), (f64::NAN, 144.0), (9.0, 9.6)] {
        let with = Companions {
            dem: Some(layer(raster(60, 60, 0.5, |_| 5.0))),
            canopy: Some(layer(raster(60, 60, 0.5, crown))),
            trunk_zone: Some(layer(raster(30, 30, 1.0, |_| base))),
            ..Companions::default()
        };
        let dsm = raster(60, 60, 0.5, |_| 5.0);
        let geometry = city(&layer(dsm), &with, &SurfaceRasters::default()).expect("a city").geometry;
        assert!((areas(&geometry).canopy - 72.0 - sides).abs() < 1e-4, "{base}: {:?}", areas(&geometry));
        let warned = geometry.warnings.iter().any(|text| format!("{text:?}").contains("in 144 cells"));
        assert_eq!(warned, base > 8.0, "{:?}", geometry.warnings);
    }
}

/// Crowns in cells of 0.25 m stand in a city in cells of 2 m: the hull of a crown of 2.5 x 2.5 x 8
/// m has its 72.5 m2, and that of a crown of 6 x 6 x 6 m at a wall ends with the last cell whose
/// middle is not inside, 4.75 m wide.
#[test]
fn crowns_keep_a_finer_grid_than_the_city() {
    let within = |place: DVec2, x: f64, y: f64, half: f64| (place - DVec2::new(x, y)).abs().max_element() < half;
    let crown = |place: DVec2| match place {
        place if within(place, 22.125, -14.125, 1.25) => 8.0,
        place if within(place, 12.625, -30.125, 3.0) => 6.0,
        _ => 0.0,
    };
    let with = Companions {
        dem: Some(layer(raster(30, 30, 2.0, |_| 5.0))),
        canopy: Some(layer(raster(230, 230, 0.25, crown))),
        ..Companions::default()
    };
    let dsm = raster(30, 30, 2.0, |place| if place.x < 11.0 { 13.0 } else { 5.0 });
    let found = areas(&city(&layer(dsm), &with, &SurfaceRasters::default()).expect("a city").geometry);
    let hulls = 2.0 * 2.5 * 2.5 + 4.0 * 2.5 * 6.0 + 2.0 * 4.75 * 6.0 + 2.0 * (4.75 + 6.0) * 4.5;
    assert!((found.canopy - hulls).abs() < 1e-6, "{found:?} {hulls}");
}

/// Ground in cells of 5 m that rises by 0.2 m a metre, with crowns in cells of 0.5 m and no
/// surface, is a forest: 1600 m2 of ground, no roof, and the hull of a crown of 6 x 6 m whose top
/// stands 8 m above the ground.
#[test]
fn ground_and_crowns_are_a_forest() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, cells: usize, cell_m: f64, height: &dyn Fn(f64, f64) -> f64| {
        let middle = |i: usize| (i as f64 + 0.5) * cell_m;
        let line = |row: usize| (0..cells).map(|i| format!("{} ", height(middle(i), middle(row)))).collect::<String>();
        let lines: Vec<String> = (0..cells).map(line).collect();
        let text = format!(
            "ncols {cells}\nnrows {cells}\nxllcorner 0\nyllcorner 0\ncellsize {cell_m}\n{}\n",
            lines.join("\n")
        );
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("a raster");
        path
    };
    let dem = write("dem.asc", 8, 5.0, &|x, _| 100.0 + 0.2 * x);
    let is_crown = |x: f64, y: f64| (x - 15.0).abs() < 3.0 && (y - 15.0).abs() < 3.0;
    let canopy = write("chm.asc", 60, 0.5, &|x, y| if is_crown(x, y) { 8.0 } else { 0.0 });
    let options = SurfaceRasters::of_files(None, Some(dem.clone()), Some(canopy), None).expect("a request");
    let part = crate::site::Part::surface(&options, None);
    let read = crate::formats::read(&dem, &crate::formats::ReadOptions::default()).expect("a raster");
    let crate::formats::Content::Terrain(raster) = read else { panic!("no raster") };
    let found = read::windows_of(&part, raster, &options, &Default::default(), 512).expect("a forest");
    let [found] = found.as_slice() else { panic!("{} windows", found.len()) };
    let found = areas(found);
    assert_eq!((found.roof, found.wall), (0.0, 0.0));
    assert!((found.ground - 1600.0).abs() < 1e-6, "{found:?}");
    // Top and underside lean by 0.2, the sides are 6 m high.
    let hull = 2.0 * 36.0 * 1.04_f64.sqrt() + 4.0 * 36.0;
    assert!((found.canopy - hull).abs() < 1.0, "{found:?} {hull}");
}

/// A tower of 6 x 6 x 12 m on a podium of 14 x 14 x 5 m without a raster of the ground is one
/// building with roofs of 196 m2 and walls of 280 and 288 m2.
#[test]
fn towers_stand_on_podiums() {
    let height = |place: DVec2| match turned(place, 0.0).abs().max_element() {
        off if off < 3.0 => 17.0,
        off if off < 7.0 => 5.0,
        _ => 0.0,
    };
    let geometry = made(raster(60, 60, 0.5, height), None).geometry;
    let found = areas(&geometry);
    assert!((found.roof - 196.0).abs() < 0.5 && (found.wall - 568.0).abs() < 1.0, "{found:?}");
    assert_eq!(geometry.object_notes.len(), 1);
}

/// A surface that is all nodata is refused. A surface with NaN in it, one of 2 x 30 cells, one
/// below its ground, and one with a canopy of -5 m and land cover of another size become cities; a
/// raster that does not cover the surface is refused.
#[test]
fn rasters_without_heights_are_refused() {
    let flat = || raster(20, 20, 1.0, |_| 3.0);
    let of = |dsm: Raster, with: Companions| city(&layer(dsm), &with, &SurfaceRasters::default());
    let all_nodata = of(raster(20, 20, 1.0, |_| f64::NAN), Companions::default());
    assert!(all_nodata.is_err_and(|error| error.to_string().contains("no cell")));
    let holes = raster(20, 20, 1.0, |place| if noise(place) > 0.0 { f64::NAN } else { 20.0 * noise(place) });
    let found = areas(&of(holes, Companions::default()).expect("a city").geometry);
    assert!(found.ground >= 0.0);
    let strip = raster(2, 30, 1.0, |place| if place.y < -15.0 { 9.0 } else { 0.0 });
    assert!(of(strip, Companions::default()).is_ok());
    let above = Companions { dem: Some(layer(raster(20, 20, 1.0, |_| 30.0))), ..Companions::default() };
    assert!((areas(&of(flat(), above).expect("ground").geometry).ground - 400.0).abs() < 1e-6);
    let below = Companions {
        canopy: Some(layer(raster(20, 20, 1.0, |_| -5.0))),
        landcover: Some(layer(raster(3, 3, 7.0, |_| 12.0))),
        ..Companions::default()
    };
    let found = of(flat(), below).expect("a city").geometry;
    assert_eq!(areas(&found).canopy, 0.0);
    assert!(found.materials.as_slice().contains(&"landcover_12".to_owned()), "{:?}", found.materials);
    let mut far = raster(20, 20, 1.0, |_| 0.0);
    far.grid.first += DVec2::splat(500.0);
    let apart = layers::check_place(&layer(flat()), &layer(far));
    assert!(apart.is_err_and(|error| error.to_string().contains("has no value on")));
}

/// The street of `tests/data/rasters` has 4 buildings with 7 roofs of 627 m2 within 3 %, 3 trees in
/// 2 crowns, whose leaves are assumed, and materials by its land cover. A survey finds the
/// same 7 objects, ground among them, 4 of which get receivers.
#[test]
fn a_street_is_read() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/rasters");
    let at = |name: &str| Some(folder.join(format!("street_{name}.tif")));
    let rasters = SurfaceRasters {
        dem: at("dem"),
        canopy: at("canopy"),
        landcover: at("landcover"),
        ..SurfaceRasters::new(at("dsm").expect("a path"))
    };
    let request = crate::request::SceneRequest { surface: rasters, ..Default::default() };
    let site = request.site().expect("a site");
    let (scene, soup) = crate::Scene::load_with_objects(&site).expect("a scene");
    let names: Vec<&str> = scene.materials.iter().map(|material| material.name.as_str()).collect();
    assert_eq!(names, ["RoofSurface", "WallSurface", "canopy", "grass", "paved"]);
    let of = |kind: &str| soup.object_names.iter().filter(|name| name.starts_with(kind)).count();
    assert!(scene.report.assumed.contains(&"canopy".to_owned()), "{:?}", scene.report.assumed);
    assert_eq!([of("building_"), of("trees_")], [4, 2], "{:?} {:?}", soup.object_names, scene.report.notes);
    let surfaces = crate::covering::surfaces::Surfaces::find(&soup, &scene.materials);
    let roofs: Vec<f64> = surfaces.list.iter().filter(|s| s.kind == SurfaceKind::Roof).map(|s| s.area_m2).collect();
    let area: f64 = roofs.iter().sum();
    assert_eq!(roofs.len(), 7, "{roofs:?} {:?}", scene.report.notes);
    assert!((area / 627.0 - 1.0).abs() < 0.03, "{area}");
    let found = site.survey().expect("a survey");
    assert_eq!(found[0].objects.iter().filter(|object| object.is_usual).count(), 4);
    assert_eq!(found[0].objects.len(), 7);
    assert_eq!(site.files().count(), 4);
}
