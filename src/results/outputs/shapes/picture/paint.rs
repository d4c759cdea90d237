//! Painting of a panel. In: the scene around, rows with their colours. Out: surfaces of a raster.

use glam::{DVec2, DVec3};

use super::palette::Ink;
use super::raster::Raster;
use super::view::View;
use crate::outputs::pictures::drawing::Rgb;
use crate::outputs::shapes::glb::Surroundings;
use crate::outputs::shapes::row::{MapPolygon, MapRow};
use heliotile_core::archive::format;
use heliotile_core::archive::format::TileNumber;
use heliotile_core::archive::tables::GeometryTable;
use heliotile_core::error::Result;
use heliotile_core::site::material::Class;

/// Colour of patches that are seen from behind.
const BEHIND: Rgb = [150, 152, 156];
/// Distance by which patches are brought in front of the scene's surfaces, metres.
const NEARER_M: f64 = 0.05;
/// Cosine below which a surface is seen edge-on.
const EDGE_ON: f64 = 0.02;

/// Passes the corners of each triangle of the archive and its class to `take`.
fn each_triangle(around: &Surroundings, mut take: impl FnMut([DVec3; 3], Class)) -> Result<()> {
    for chunk in 0..around.chunks {
        let table = GeometryTable::from_block(&around.site.block(format::SCENE, TileNumber(chunk))?)?;
        let corner = |number: u32| {
            let vertex = table.vertex.get(number as usize).copied().unwrap_or_default();
            DVec3::from_array(vertex.map(f64::from)) + around.origin
        };
        for (triangle, material) in table.corner.iter().zip(&table.material) {
            let material = around.site.materials().get(usize::from(*material));
            take(triangle.map(corner), material.map_or(Class::Obstruction, |material| material.class));
        }
    }
    Ok(())
}

/// Extends corners in each view, metres to the right and up, by what stands on the ground.
pub fn extend(corners: &mut [[DVec2; 2]], views: &[View], around: &Surroundings) -> Result<()> {
    each_triangle(around, |triangle, class| {
        for corner in triangle.iter().filter(|_| class != Class::Ground) {
            views.iter().zip(&mut *corners).for_each(|(view, corners)| include(corners, view, *corner));
        }
    })
}

/// Extends corners by a row.
pub fn extend_by_row(corners: &mut [[DVec2; 2]], views: &[View], row: &MapRow) {
    for corner in row.polygons.iter().flat_map(MapPolygon::corners) {
        views.iter().zip(&mut *corners).for_each(|(view, corners)| include(corners, view, *corner));
    }
}

fn include([low, high]: &mut [DVec2; 2], view: &View, point: DVec3) {
    let at = view.of(point).truncate();
    (*low, *high) = (low.min(at), high.max(at));
}

/// Draws the triangles of the archive in grey, brighter if they face up and to the west; `darker`
/// is taken from their brightness of 255.
pub fn draw_scene(raster: &mut Raster, around: &Surroundings, darker: f64) -> Result<()> {
    let view = raster.view();
    let light = view.of(DVec3::new(-0.5, -0.3, 0.8)).normalize();
    each_triangle(around, |corners, _| {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        // Triangles have no front side: the normal is turned towards the viewer.
        let normal = if normal.dot(view.towards) < 0.0 { -normal } else { normal };
        let grey = (212.0 - darker + 26.0 * view.of(normal).dot(light)) as u8;
        raster.triangle(corners, 0.0, Ink::plain([grey; 3]));
    })
}

/// Draws a row.
pub fn draw_row(raster: &mut Raster, row: &MapRow, ink: Ink) {
    let view = raster.view();
    for polygon in &row.polygons {
        let corners: Vec<DVec3> = polygon.corners().copied().collect();
        if let [only] = corners.as_slice() {
            raster.mark(*only, ink);
            continue;
        }
        let cos = polygon.normal().dot(view.towards);
        if cos.abs() < EDGE_ON {
            for ring in &polygon.rings {
                ring.iter().zip(ring.iter().cycle().skip(1)).for_each(|(from, to)| raster.edge(*from, *to, ink));
            }
            continue;
        }
        let at = |number: u32| corners.get(number as usize).copied().unwrap_or_default();
        let ink = if cos > 0.0 { ink } else { Ink::plain(BEHIND) };
        polygon.triangles().iter().for_each(|three| raster.triangle(three.map(at), NEARER_M, ink));
    }
}
