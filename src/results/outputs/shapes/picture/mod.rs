//! Maps as pictures. In: rows, the scene around. Out: PNG with two views in one scale: from above,
//! true north up and true to scale, and from the south-west. It has the page's colours, a legend
//! and a scale bar. Memory depends on the number of pixels, not on the size of the site.

mod raster;
pub mod thumbnail;
mod view;

use std::io::Write;

use glam::{DVec2, DVec3};

use super::columns::MapColumns;
use super::glb::Surroundings;
use super::row::{MapPolygon, MapRow};
use super::rows::MapRows;
use crate::outputs::pictures::canvas::{Canvas, Rgb, Side};
use crate::outputs::pictures::colours::{ColourScale, STEPS};
use crate::outputs::pictures::scale::round_steps;
use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use heliotile_core::archive::format;
use heliotile_core::archive::format::TileNumber;
use heliotile_core::archive::tables::GeometryTable;
use heliotile_core::error::{Error, Result};
use heliotile_core::site::north::North;
use raster::Raster;
use view::{ALTITUDE_DEG, Panel, View};

const PAPER: Rgb = [255, 255, 255];
const INK: Rgb = [30, 30, 40];
/// Colour of patches that are seen from behind.
const BEHIND: Rgb = [150, 152, 156];

/// Largest width and height of both views together, points. The constants below are the space
/// around them.
const MAX: DVec2 = DVec2::new(1340.0, 940.0);
const MARGIN: f64 = 24.0;
const HEAD: f64 = 64.0;
const FOOT: f64 = 92.0;
/// Least width of a page, points: narrower ones have no room for words.
const NARROWEST: f64 = 560.0;

/// Distance by which patches are brought in front of the scene's surfaces, metres.
const NEARER_M: f64 = 0.05;
/// Cosine below which a surface is seen edge-on.
const EDGE_ON: f64 = 0.02;
/// Least size that is drawn, metres.
const MIN_M: f64 = 1.0;

/// Contents of a picture besides rows.
pub struct Drawn<'a> {
    pub around: Option<&'a Surroundings<'a>>,
    pub north: North,
    /// Description of the values in words.
    pub called: &'a str,
    /// Unit of the values.
    pub unit: &'a str,
}

/// Writes the picture and returns the number of bytes.
pub fn write(
    mut sink: Sink,
    rows: &mut MapRows,
    columns: &MapColumns,
    drawn: &Drawn,
    about: &Provenance,
) -> Result<u64> {
    let ticks = columns.scale.ticks(rows.facts.largest.into());
    let top = ticks.last().copied().unwrap_or(1.0);
    let views = [View::above(drawn.north), View::south_west(drawn.north)];
    let (panels, width, height) = arranged(views, extents(rows, views)?);
    let mut canvas = Canvas::painted(width as usize, height as usize, |_, _| PAPER);
    for (panel, is_above) in panels.into_iter().zip([true, false]) {
        let mut raster = Raster::new(&mut canvas, panel);
        if let Some(around) = drawn.around {
            draw_scene(&mut raster, panel, around)?;
        }
        // The view from above also shows places below roofs and trees.
        if is_above {
            raster.forget_depth();
        }
        rows.each(|row| {
            draw_row(&mut raster, panel, row, paint(row, columns.colour, columns.scale, top));
            Ok(())
        })?;
    }
    let title = format!("{}, {}", columns.main_words(), drawn.unit);
    draw_words(&mut canvas, panels, DVec2::new(width, height), &title, drawn.called, drawn.around.is_some());
    draw_legend(&mut canvas, columns.scale, &ticks, DVec2::new(width, height));
    let [low, high] = [columns.scale.least(top), top].map(|end| end.to_string());
    let about =
        about.clone().with("colours", columns.scale.name_on_paper()).with("colours_from", low).with("colours_to", high);
    let path = sink.path().to_owned();
    sink.write_all(&canvas.png(about.ascii())?).map_err(Error::io(&path, "write to"))?;
    sink.finish()
}

/// Returns the lowest and highest metres to the right and up, by view.
fn extents(rows: &mut MapRows, views: [View; 2]) -> Result<[[DVec2; 2]; 2]> {
    let mut found = [[DVec2::INFINITY, DVec2::NEG_INFINITY]; 2];
    rows.each(|row| {
        for corner in row.polygons.iter().flat_map(MapPolygon::corners) {
            for (view, [low, high]) in views.iter().zip(&mut found) {
                let at = view.of(*corner).truncate();
                (*low, *high) = (low.min(at), high.max(at));
            }
        }
        Ok(())
    })?;
    Ok(found.map(padded))
}

/// Returns corners with a margin, such that a page has some size whatever it shows.
fn padded([low, high]: [DVec2; 2]) -> [DVec2; 2] {
    let (low, high) = if low.is_finite() && high.is_finite() { (low, high) } else { (DVec2::ZERO, DVec2::ZERO) };
    let more = (0.03 * (high - low).max_element()).max(MIN_M);
    [low - more, high + more]
}

/// Arranges both panels side by side or one above the other, whichever is larger. Returns them with
/// the page's width and height.
fn arranged(views: [View; 2], extents: [[DVec2; 2]; 2]) -> ([Panel; 2], f64, f64) {
    let [first, second] = extents.map(|[low, high]| high - low);
    let beside = (MAX.x / (first.x + second.x)).min(MAX.y / first.y.max(second.y));
    let above = (MAX.x / first.x.max(second.x)).min(MAX.y / (first.y + second.y));
    let scale = beside.max(above);
    let panel = |i: usize, corner: DVec2| Panel {
        view: views[i],
        low: extents[i][0],
        size_m: extents[i][1] - extents[i][0],
        scale,
        // Corners lie on whole pixels.
        corner: corner.round(),
    };
    let corner = DVec2::new(MARGIN, HEAD);
    let (next, size) = if beside >= above {
        let next = corner + DVec2::new(first.x * scale + MARGIN, 0.0);
        (next, DVec2::new((first.x + second.x) * scale + MARGIN, first.y.max(second.y) * scale))
    } else {
        let next = corner + DVec2::new(0.0, first.y * scale + MARGIN);
        (next, DVec2::new(first.x.max(second.x) * scale, (first.y + second.y) * scale + MARGIN))
    };
    let (width, height) = ((size.x + 2.0 * MARGIN).max(NARROWEST).ceil(), (size.y + HEAD + FOOT).ceil());
    ([panel(0, corner), panel(1, next)], width, height)
}

/// Draws the triangles of the archive in grey, brighter if they face up and to the west.
fn draw_scene(raster: &mut Raster, panel: Panel, around: &Surroundings) -> Result<()> {
    let light = (panel.view.of(DVec3::new(-0.5, -0.3, 0.8))).normalize();
    for chunk in 0..around.chunks {
        let table = GeometryTable::from_block(&around.site.block(format::SCENE, TileNumber(chunk))?)?;
        let corner = |number: u32| {
            let vertex = table.vertex.get(number as usize).copied().unwrap_or_default();
            DVec3::from_array(vertex.map(f64::from)) + around.origin
        };
        for triangle in &table.corner {
            let corners = triangle.map(corner);
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
            // Triangles have no front side: the normal is turned towards the viewer.
            let normal = if normal.dot(panel.view.towards) < 0.0 { -normal } else { normal };
            let grey = (212.0 + 26.0 * panel.view.of(normal).dot(light)) as u8;
            raster.triangle(corners, 0.0, [grey; 3]);
        }
    }
    Ok(())
}

/// Returns the colour of a row, by one of its numbers and the top of the scale.
fn paint(row: &MapRow, colour: usize, scale: ColourScale, top: f64) -> Rgb {
    let value = row.numbers.get(colour).copied().unwrap_or(f32::NAN);
    scale.on_paper((f64::from(value) / top) as f32)
}

fn draw_row(raster: &mut Raster, panel: Panel, row: &MapRow, paint: Rgb) {
    for polygon in &row.polygons {
        let corners: Vec<DVec3> = polygon.corners().copied().collect();
        if let [only] = corners.as_slice() {
            raster.mark(*only, paint);
            continue;
        }
        let cos = polygon.normal().dot(panel.view.towards);
        if cos.abs() < EDGE_ON {
            for ring in &polygon.rings {
                ring.iter().zip(ring.iter().cycle().skip(1)).for_each(|(from, to)| raster.edge(*from, *to, paint));
            }
            continue;
        }
        let at = |number: u32| corners.get(number as usize).copied().unwrap_or_default();
        let paint = if cos > 0.0 { paint } else { BEHIND };
        polygon.triangles().iter().for_each(|three| raster.triangle(three.map(at), NEARER_M, paint));
    }
}

fn draw_words(
    canvas: &mut Canvas,
    [above, oblique]: [Panel; 2],
    size: DVec2,
    title: &str,
    called: &str,
    has_scene: bool,
) {
    canvas.headline(title, (MARGIN, 18.0), Side::Left, INK);
    canvas.word(called, (MARGIN, 36.0), Side::Left, INK);
    let under_title = HEAD - 11.0;
    canvas.word("from above", (above.corner.x, under_title), Side::Left, INK);
    let beside = oblique.corner.x > above.corner.x;
    let caption = if beside { under_title } else { oblique.corner.y - 10.0 };
    let words = format!("from the south-west, {ALTITUDE_DEG}\u{b0} high");
    canvas.word(&words, (oblique.corner.x, caption), Side::Left, INK);
    // North arrow and scale bar belong to the view from above.
    let foot = size.y - FOOT;
    let steps = round_steps(0.25 * above.size_m.x.max(60.0 / above.scale), 1);
    let metres = steps.last().copied().unwrap_or(1.0);
    let bar = if metres * above.scale > 0.5 * (size.x - 2.0 * MARGIN) { 0.5 * metres } else { metres };
    let (left, y, long) = (MARGIN + 26.0, foot + 20.0, bar * above.scale);
    canvas.line(&[(left, y - 4.0), (left, y), (left + long, y), (left + long, y - 4.0)], 1.3, INK);
    let named = if bar >= 1000.0 { format!("{} km", bar / 1000.0) } else { format!("{bar} m") };
    canvas.word(&named, (left + long + 8.0, y - 2.0), Side::Left, INK);
    let arrow = MARGIN + 8.0;
    canvas.line(&[(arrow - 4.0, y - 5.0), (arrow, y - 12.0), (arrow + 4.0, y - 5.0)], 1.3, INK);
    canvas.line(&[(arrow, y - 12.0), (arrow, y + 2.0)], 1.3, INK);
    canvas.word("N", (arrow, y + 10.0), Side::Center, INK);
    if has_scene {
        canvas.word("grey: surroundings", (size.x - MARGIN, y - 2.0), Side::Right, INK);
    }
}

fn draw_legend(canvas: &mut Canvas, scale: ColourScale, ticks: &[f64], size: DVec2) {
    let (left, y, long) = (MARGIN + 26.0, size.y - 46.0, (size.x - 2.0 * MARGIN - 52.0).min(640.0));
    let top = ticks.last().copied().unwrap_or(1.0);
    let least = scale.least(top);
    let share = |step: usize| step as f64 / STEPS as f64;
    for step in 0..STEPS {
        let (from, to) = (left + long * share(step), left + long * share(step + 1));
        canvas.line(
            &[(0.5 * (from + to), y - 7.0), (0.5 * (from + to), y + 7.0)],
            to - from + 0.5,
            scale.of_legend(step),
        );
    }
    for tick in ticks {
        let x = left + long * (tick - least) / (top - least);
        canvas.line(&[(x, y + 8.0), (x, y + 13.0)], 1.0, INK);
        canvas.word(&tick.to_string(), (x, y + 23.0), Side::Center, INK);
    }
    if let Some([low, high]) = scale.ends() {
        canvas.word(low, (left, y - 16.0), Side::Left, INK);
        canvas.word(high, (left + long, y - 16.0), Side::Right, INK);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use heliotile_core::site::place::Place;

    /// Returns axes whose y is `convergence_deg` degrees clockwise from true north.
    pub fn turned(convergence_deg: f64) -> North {
        North::new(Some(&Place { latitude_deg: 52.0, longitude_deg: 4.0, convergence_deg, epsg: None }))
    }

    /// A site of 400 m x 100 m has its views one above the other, one of 100 m x 100 m side by
    /// side. Both views have one scale, none leaves its page, and a site of 2 m or of 1e12 m has a
    /// page of at most 1420 x 1200 points.
    #[test]
    fn both_views_fit_on_the_page_in_one_scale() {
        let views = [View::above(North::default()), View::south_west(North::default())];
        let of = |first: DVec2, second: DVec2| arranged(views, [[DVec2::ZERO, first], [DVec2::ZERO, second]]);
        let (wide, width, height) = of(DVec2::new(400.0, 100.0), DVec2::new(350.0, 260.0));
        assert!(wide[1].corner.y > wide[0].corner.y && wide[0].scale == wide[1].scale);
        let (tall, ..) = of(DVec2::new(100.0, 100.0), DVec2::new(140.0, 100.0));
        assert!(tall[1].corner.x > tall[0].corner.x && tall[0].corner.y == tall[1].corner.y);
        for panel in wide {
            let end = panel.corner + panel.size();
            assert!(end.x <= width && end.y + FOOT <= height + 1.0, "{end} {width} {height}");
        }
        for size in [2.0, 1e12] {
            let (_, width, height) = of(DVec2::splat(size), DVec2::splat(size));
            assert!(width <= 1420.0 && height <= 1200.0, "{width} {height}");
        }
    }
}
