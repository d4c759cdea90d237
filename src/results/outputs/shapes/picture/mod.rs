//! Maps as pictures. In: rows, the scene around. Out: PNG with two views in one scale: from above,
//! true north up and true to scale, and from the south-west. It has the page's colours, a legend, a
//! scale bar and its sources. Memory depends on the number of pixels, not on the size of the site.

mod paint;
pub mod palette;
mod raster;
pub mod thumbnail;
mod view;

use std::io::Write;

use glam::DVec2;

use super::columns::MapColumns;
use super::glb::Surroundings;
use super::rows::MapRows;
use crate::outputs::pictures::axes::{Frame, LETTERS, MARGIN};
use crate::outputs::pictures::drawing::{Drawing, INK, PALE_INK, SAMPLES, SCALE, Side};
use crate::outputs::pictures::scale::{printed, round_steps, titled};
use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use heliotile_core::error::{Error, Result};
use heliotile_core::site::north::North;
use paint::{draw_row, draw_scene, extend, extend_by_row};
use palette::Palette;
use raster::Raster;
use view::{ALTITUDE_DEG, Panel, View};

/// Largest width and height of both views together, points. The constants below are the space
/// around them.
const MAX: DVec2 = DVec2::new(1340.0, 940.0);
/// Distance between both views, points.
const GAP: f64 = 24.0;
const HEAD: f64 = 86.0;
const FOOT: f64 = 122.0;
/// Least width of a page, points: narrower ones have no room for words.
const NARROWEST: f64 = 560.0;
/// Largest width of the legend, points.
const LEGEND: f64 = 640.0;

/// Least size that is drawn, metres.
const MIN_M: f64 = 1.0;
/// Largest distance from the rows at which surroundings are in view, as a share of the longer side.
const AROUND: f64 = 0.35;

/// Contents of a picture besides rows.
pub struct Drawn<'a> {
    pub around: Option<&'a Surroundings<'a>>,
    pub north: North,
    /// Title without the unit.
    pub title: String,
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
    let palette = Palette::new(rows, columns)?;
    let views = [View::above(drawn.north), View::south_west(drawn.north)];
    let (panels, width, height) = arranged(views, extents(rows, views, drawn.around)?);
    let mut page = Drawing::new(width, height + palette.more_height());
    let unit = printed(drawn.unit);
    page.heading(&titled(&drawn.title, drawn.unit), &about.with_place(drawn.called));
    for (panel, is_above) in panels.into_iter().zip([true, false]) {
        let mut raster = Raster::new(panel);
        if let Some(around) = drawn.around {
            draw_scene(&mut raster, around, palette.darker())?;
        }
        // The view from above also shows places below roofs and trees.
        if is_above {
            raster.forget_depth();
        }
        rows.each(|row| {
            palette.ink(row).into_iter().for_each(|ink| draw_row(&mut raster, row, ink));
            Ok(())
        })?;
        page.image(panel.corner.into(), raster.image(SAMPLES / SCALE));
    }
    let (left, foot) = (MARGIN, height - FOOT);
    draw_words(&mut page, panels, foot + 20.0, drawn.around.is_some());
    // Arrows of values beyond the scale stand beside it.
    let (left, right) = (left + 20.0, left + (width - 2.0 * MARGIN - 80.0).min(LEGEND));
    let legend = Frame { left, right, top: foot + 56.0, bottom: foot + 70.0 };
    palette.draw_legend(&mut page, &legend, &unit);
    let path = sink.path().to_owned();
    sink.write_all(&page.png_file(&palette.stated(about))?).map_err(Error::io(&path, "write to"))?;
    sink.finish()
}

/// Returns the lowest and highest metres to the right and up, by view, of the rows and what stands
/// near them.
fn extents(rows: &mut MapRows, views: [View; 2], around: Option<&Surroundings>) -> Result<[[DVec2; 2]; 2]> {
    let mut found = [[DVec2::INFINITY, DVec2::NEG_INFINITY]; 2];
    rows.each(|row| {
        extend_by_row(&mut found, &views, row);
        Ok(())
    })?;
    let mut wider = found;
    around.map_or(Ok(()), |around| extend(&mut wider, &views, around))?;
    Ok([0, 1].map(|view| padded(limited(found[view], wider[view]))))
}

/// Returns wider corners, at most [`AROUND`] from those of the rows.
fn limited([low, high]: [DVec2; 2], wider: [DVec2; 2]) -> [DVec2; 2] {
    let most = AROUND * (high - low).max_element();
    [wider[0].max(low - most), wider[1].min(high + most)]
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
        // Corners lie on whole points.
        corner: corner.round(),
    };
    let corner = DVec2::new(MARGIN, HEAD);
    let (next, size) = if beside >= above {
        let next = corner + DVec2::new(first.x * scale + GAP, 0.0);
        (next, DVec2::new((first.x + second.x) * scale + GAP, first.y.max(second.y) * scale))
    } else {
        let next = corner + DVec2::new(0.0, first.y * scale + GAP);
        (next, DVec2::new(first.x.max(second.x) * scale, (first.y + second.y) * scale + GAP))
    };
    let (width, height) = ((size.x + 2.0 * MARGIN).max(NARROWEST).ceil(), (size.y + HEAD + FOOT).ceil());
    ([panel(0, corner), panel(1, next)], width, height)
}

/// Draws captions, and in a row at `y` the north arrow and the scale bar of the view from above.
fn draw_words(page: &mut Drawing, [above, oblique]: [Panel; 2], y: f64, has_scene: bool) {
    let width = page.size.0;
    let oblique_words = format!("from the south-west, {ALTITUDE_DEG}\u{b0} high");
    for (panel, words) in [(above, "from above"), (oblique, &oblique_words)] {
        page.text(words, (panel.corner.x, panel.corner.y - 11.0), LETTERS, Side::Left, PALE_INK);
    }
    let steps = round_steps(0.25 * above.size_m.x.max(60.0 / above.scale), 1);
    let metres = steps.last().copied().unwrap_or(1.0);
    let bar = if metres * above.scale > 0.5 * (width - 2.0 * MARGIN) { 0.5 * metres } else { metres };
    let (left, long) = (MARGIN + 28.0, bar * above.scale);
    page.line(&[(left, y - 4.0), (left, y), (left + long, y), (left + long, y - 4.0)], 1.3, INK);
    let named = if bar >= 1000.0 { format!("{} km", bar / 1000.0) } else { format!("{bar} m") };
    page.text(&named, (left + long + 8.0, y - 2.0), LETTERS, Side::Left, INK);
    let arrow = MARGIN + 8.0;
    page.polygon(vec![vec![(arrow - 5.0, y + 1.0), (arrow, y - 14.0), (arrow + 5.0, y + 1.0), (arrow, y - 3.0)]], INK);
    page.text("N", (arrow, y + 9.0), LETTERS, Side::Center, INK);
    if has_scene {
        page.text("grey: surroundings", (width - MARGIN, y - 2.0), LETTERS, Side::Right, PALE_INK);
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

    /// Surroundings near the rows are in view whole, others up to 35 % of the longer side.
    #[test]
    fn surroundings_near_the_rows_are_in_view() {
        let rows = [DVec2::ZERO, DVec2::new(100.0, 40.0)];
        let found = limited(rows, [DVec2::new(-12.0, -900.0), DVec2::new(100.0, 41.0)]);
        assert_eq!(found, [DVec2::new(-12.0, -35.0), DVec2::new(100.0, 41.0)]);
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
            let end = panel.corner + panel.size_m * panel.scale;
            assert!(end.x <= width && end.y + FOOT <= height + 1.0, "{end} {width} {height}");
        }
        for size in [2.0, 1e12] {
            let (_, width, height) = of(DVec2::splat(size), DVec2::splat(size));
            assert!(width <= 1420.0 && height <= 1200.0, "{width} {height}");
        }
    }
}
