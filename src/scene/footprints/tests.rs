//! Tests of buildings from footprints: areas against sums by hand, neighbours, parts, terrain.

use std::f64::consts::FRAC_PI_6;
use std::path::Path;

use glam::{DVec2, DVec3};

use crate::footprint::{Footprint, PlanRing, StatedHeights};
use crate::footprints::ground_below::GroundBelow;
use crate::footprints::raised::{FootprintFile, raise};
use crate::geometry::Geometry;
use crate::polygon::area_vector_of;
use heliotile_core::site::semantics::SurfaceKind;

/// Returns a house on a rectangle, turned by 30 degrees about a corner of a national grid.
fn house(name: &str, west: f64, south: f64, east: f64, north: f64, roof_m: f64) -> Footprint {
    let turned =
        |x: f64, y: f64| DVec2::from_angle(FRAC_PI_6).rotate(DVec2::new(x, y)) + DVec2::new(690_000.0, 5_330_000.0);
    let ring: PlanRing =
        [(west, south), (east, south), (east, north), (west, north)].map(|(x, y)| turned(x, y)).to_vec();
    Footprint {
        name: name.to_owned(),
        building: String::new(),
        is_part: false,
        number: 1,
        polygons: vec![vec![ring]],
        heights: StatedHeights { roof_m, is_roof_absolute: false, foot_m: 0.0, base_m: None, has_walls: true },
        attributes: String::new(),
    }
}

/// Areas of roofs, walls and undersides, lowest and highest corner, and number of walls.
struct Found {
    roof_m2: f64,
    wall_m2: f64,
    underside_m2: f64,
    heights: [f64; 2],
    walls: usize,
}

fn found(footprints: Vec<Footprint>, ground: Vec<[DVec3; 3]>) -> (Found, Geometry) {
    let mut geometry = Geometry::default();
    let file = FootprintFile { file: Path::new("f.geojson"), elevation_m: 0.0, footprints, geometry: &mut geometry };
    raise(&mut [file], &GroundBelow::new(Vec::new(), ground)).expect("faces");
    let mut found =
        Found { roof_m2: 0.0, wall_m2: 0.0, underside_m2: 0.0, heights: [f64::INFINITY, f64::NEG_INFINITY], walls: 0 };
    for face in geometry.faces() {
        let across = area_vector_of(&face, &geometry.vertices);
        let area = across.length();
        match geometry.note_of(face.number).kind {
            Some(SurfaceKind::Roof) if across.z > 0.99 * area => found.roof_m2 += area,
            Some(SurfaceKind::Wall) if across.z.abs() < 1e-6 * area => {
                found.wall_m2 += area;
                found.walls += 1;
            }
            Some(SurfaceKind::Floor) if across.z < -0.99 * area => found.underside_m2 += area,
            other => panic!("{other:?} {across}"),
        }
        for corner in face.corners() {
            let z = geometry.vertices[*corner as usize].z;
            found.heights = [found.heights[0].min(z), found.heights[1].max(z)];
        }
    }
    (found, geometry)
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-3 * b.abs().max(1.0)
}

/// A row of 40 houses of 6 m by 10 m, alternately 8 and 9 m high, turned by 30 degrees, has 2,400
/// m2 of roof. Its walls are the two gables, the fronts and the steps of 1 m between neighbours:
/// 4,640 m2 in 121 pieces.
#[test]
fn a_row_of_houses_has_no_walls_between() {
    let row: Vec<Footprint> = (0..40)
        .map(|i| house(&format!("h{i}"), 6.0 * f64::from(i), 0.0, 6.0 * f64::from(i + 1), 10.0, 8.0 + f64::from(i % 2)))
        .collect();
    let (found, geometry) = found(row, Vec::new());
    let fronts = 2.0 * 6.0 * 20.0 * (8.0 + 9.0);
    let expected = fronts + 10.0 * (8.0 + 9.0) + 39.0 * 10.0;
    assert!(near(found.roof_m2, 2400.0) && near(found.wall_m2, expected), "{} {expected}", found.wall_m2);
    assert_eq!((found.walls, expected), (80 + 2 + 39, 2.0 * 6.0 * 340.0 + 170.0 + 390.0));
    assert_eq!(geometry.objects.as_slice().len(), 40);
}

/// A block of 20 m with a court of 10 m, a house that fills half of the court, and a part from 6 to
/// 12 m above a corner have the areas of a sum by hand; the order of features changes nothing.
#[test]
fn courts_and_parts_have_their_areas() {
    let mut block = house("block", 0.0, 0.0, 20.0, 20.0, 6.0);
    let mut court = house("", 5.0, 5.0, 15.0, 15.0, 1.0).polygons.remove(0).remove(0);
    court.reverse();
    block.polygons[0].push(court);
    let filling = house("filling", 5.0, 5.0, 15.0, 10.0, 4.0);
    let mut part = house("part", 0.0, 0.0, 5.0, 5.0, 12.0);
    part.heights.foot_m = 6.0;
    let (one, first) = found(vec![block.clone(), filling.clone(), part.clone()], Vec::new());
    // Roofs: 300 m2 less 25 below the part, 50, 25. Walls: 80 m of 6 m outside, 40 m of 6 m to the
    // court less 20 m of 4 m beside the filling, 10 m of 4 m of the filling towards the court, 20 m
    // of 6 m of the part.
    assert!(near(one.roof_m2, 275.0 + 50.0 + 25.0), "{}", one.roof_m2);
    let walls = 480.0 + 240.0 - 80.0 + 40.0 + 120.0;
    assert!(near(one.wall_m2, walls) && near(one.underside_m2, 0.0), "{} {walls}", one.wall_m2);
    let (other, second) = found(vec![part, filling, block], Vec::new());
    assert!(near(other.wall_m2, one.wall_m2) && first.face_count() == second.face_count());
}

/// An overhang from 3 to 6 m has an underside of 50 m2 and 4 walls of 3 m; below it nothing stands.
#[test]
fn overhangs_have_undersides() {
    let mut part = house("part", 0.0, 0.0, 5.0, 10.0, 6.0);
    part.heights.foot_m = 3.0;
    let (found, _) = found(vec![part], Vec::new());
    assert!(near(found.underside_m2, 50.0) && near(found.wall_m2, 90.0) && near(found.roof_m2, 50.0));
    assert!((found.heights[0] - 3.0).abs() < 1e-9);
}

/// On a slope each of two neighbours stands on the lowest ground below it, 10 m below its roof; of
/// the wall between them only the step is left.
#[test]
fn neighbours_stand_on_the_ground_below_them() {
    let at = |x: f64, y: f64| {
        let place = DVec2::new(690_000.0 + x, 5_330_000.0 + y);
        place.extend(0.1 * DVec2::from_angle(-FRAC_PI_6).rotate(DVec2::new(x, y)).x)
    };
    let [a, b, c, d] = [at(-100., -100.), at(100., -100.), at(100., 100.), at(-100., 100.)];
    let houses = vec![house("a", 0.0, 0.0, 10.0, 10.0, 10.0), house("b", 10.0, 0.0, 20.0, 10.0, 10.0)];
    let (found, _) = found(houses, vec![[a, b, c], [a, c, d]]);
    // Bases at 0 and 1 m; outer walls 30 m of 10 m each, the step of 1 m.
    assert!(near(found.wall_m2, 600.0 + 10.0) && near(found.roof_m2, 200.0), "{}", found.wall_m2);
    assert!((found.heights[0]).abs() < 1e-3 && (found.heights[1] - 11.0).abs() < 1e-3, "{:?}", found.heights);
}
