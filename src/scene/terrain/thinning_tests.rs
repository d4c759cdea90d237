//! Tests of thinned surfaces against their rasters.

use std::collections::BTreeMap;
use std::path::Path;

use glam::DVec2;

use super::*;
use crate::terrain::raster::{Grid, Meaning};

/// Returns hills that no plane fits.
fn hills(columns: usize, rows: usize, hole: Option<usize>) -> Raster {
    let height = |i: usize| {
        let (x, y) = ((i % columns) as f32, (i / columns) as f32);
        400.0 * (x * 0.11).sin() * (y * 0.07).cos() + 25.0 * (x * 1.3 + y * 0.9).sin() + (i * 7919 % 13) as f32
    };
    let heights = (0..columns * rows).map(|i| if hole == Some(i) { f32::NAN } else { height(i) }).collect();
    let grid = Grid { columns, rows, first: DVec2::new(1000.0, 5000.0), step: DVec2::new(30.0, 20.0) };
    Raster::new(Path::new("r"), grid, heights, &Meaning::default(), Vec::new()).expect("heights")
}

fn focus(raster: &Raster, column: i64, row: i64) -> Focus {
    let place = raster.plan(column, row);
    Focus::around(place, place)
}

/// Returns twice the area of a triangle in cells.
fn doubled([a, b, c]: &[Sample; 3]) -> i64 {
    ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs()
}

/// On four rasters, of 97 x 60 samples and of sides that are and are not 2^k + 1, triangles cover
/// every cell once and every inner side has two of them (no cracks). Nowhere is the angle to the
/// samples above the limit, which brute force over all samples confirms.
#[test]
fn thinned_terrain_has_no_cracks() {
    for (columns, rows, limit) in [(97, 60, 0.5), (65, 65, 0.2), (2, 9, 0.1), (130, 34, 2.0)] {
        let raster = hills(columns, rows, None);
        let focus = focus(&raster, 40.min(columns as i64 / 2), 3);
        let thinned = thin(&raster, &focus, limit);
        let (wide, high) = (columns as i64 - 1, rows as i64 - 1);
        assert_eq!(thinned.triangles.iter().map(doubled).sum::<i64>(), 2 * wide * high);
        assert!(thinned.triangles.len() <= 2 * (wide * high) as usize && thinned.nodata == 0);
        let mut sides: BTreeMap<[Sample; 2], usize> = BTreeMap::new();
        for [a, b, c] in &thinned.triangles {
            for (p, q) in [(a, b), (b, c), (c, a)] {
                *sides.entry([*p.min(q), *p.max(q)]).or_default() += 1;
            }
        }
        for ([p, q], count) in &sides {
            let edge = (0..2).any(|axis| p[axis] == q[axis] && [0, [wide, high][axis]].contains(&p[axis]));
            assert_eq!(*count, if edge { 1 } else { 2 }, "{p:?} {q:?}");
        }
        let mut worst = 0.0_f64;
        for corners in &thinned.triangles {
            for (sample, off) in inside(&raster, corners) {
                let distance = focus.distance_squared(raster.plan(sample[0], sample[1])).sqrt();
                assert!(off <= 1e-3 + limit.to_radians() * distance, "{sample:?}: {off} m at {distance} m");
                if off > 1e-3 {
                    worst = worst.max((off / distance).to_degrees());
                }
            }
        }
        assert!(
            thinned.largest_deg <= limit && worst <= thinned.largest_deg * 1.001,
            "{worst} {}",
            thinned.largest_deg
        );
    }
}

/// Returns the samples in a triangle by their barycentric coordinates, with their heights off its
/// plane.
fn inside(raster: &Raster, corners: &[Sample; 3]) -> Vec<(Sample, f64)> {
    let z = corners.map(|[c, r]| f64::from(raster.height(c, r)));
    let [a, b, c] = corners;
    let cross =
        |p: &Sample, q: &Sample, s: &Sample| ((q[0] - p[0]) * (s[1] - p[1]) - (q[1] - p[1]) * (s[0] - p[0])) as f64;
    let whole = cross(a, b, c);
    let mut found = Vec::new();
    let range = |axis: usize| {
        let along = corners.map(|corner| corner[axis]);
        along.into_iter().min().unwrap_or(0)..=along.into_iter().max().unwrap_or(0)
    };
    for row in range(1) {
        for column in range(0) {
            let s = [column, row];
            let shares = [cross(b, c, &s), cross(c, a, &s), cross(a, b, &s)].map(|share| share / whole);
            if shares.iter().all(|share| *share >= 0.0) {
                let plane: f64 = shares.iter().zip(z).map(|(share, z)| share * z).sum();
                found.push((s, (f64::from(raster.height(column, row)) - plane).abs()));
            }
        }
    }
    found
}

/// A plain of 513 x 513 samples is 2 triangles, whatever the limit. A step of 100 m in it is kept,
/// and fewer than a tenth of the 524,288 triangles remain.
#[test]
fn a_plain_is_two_triangles() {
    let grid = Grid { columns: 513, rows: 513, first: DVec2::ZERO, step: DVec2::splat(30.0) };
    let raster = |step: f32| {
        let heights = (0..513 * 513).map(|i| if i % 513 > 300 { step } else { 0.0 }).collect();
        Raster::new(Path::new("r"), grid, heights, &Meaning::default(), Vec::new()).expect("heights")
    };
    let flat = raster(0.0);
    assert_eq!(thin(&flat, &focus(&flat, 100, 100), 1e-6).triangles.len(), 2);
    let stepped = raster(100.0);
    let thinned = thin(&stepped, &focus(&stepped, 100, 100), 0.05);
    assert!((1000..52_000).contains(&thinned.triangles.len()), "{}", thinned.triangles.len());
    assert_eq!(thinned.triangles.iter().map(doubled).sum::<i64>(), 2 * 512 * 512);
}

/// A sample without a height removes the triangles that touch it, 4 or 8, and no others.
#[test]
fn nodata_removes_only_triangles_that_touch_it() {
    for (hole, touched) in [(31 * 65 + 31, 8), (32 * 65 + 31, 4)] {
        let raster = hills(65, 65, Some(hole));
        let thinned = thin(&raster, &focus(&raster, 5, 5), 1.0);
        let area: i64 = thinned.triangles.iter().map(doubled).sum();
        assert_eq!((thinned.nodata, area), (touched, 2 * 64 * 64 - touched as i64));
        assert!(thinned.triangles.iter().flatten().all(|&[c, r]| raster.height(c, r).is_finite()));
    }
}
