//! What pictures in SVG have in common. In: what to draw, in pixels. Out: a text that stands alone as a file and may stand inside an HTML page,
//! as it has no ids and refers to nothing. Equal drawings give equal bytes.

use std::io;

use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind};
use plotters::prelude::{BLACK, IntoDrawingArea, IntoFont, RGBColor, SVGBackend, Text, TextStyle, WHITE};
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::canvas::Rgb;
use heliotile_core::error::{Error, Result};

/// Units of the drawing a pixel of the picture: they are whole numbers, and a curve needs finer ones than pixels.
pub const FINE: i32 = 8;

/// What drawing gives.
pub type Drawn = std::result::Result<(), DrawingAreaErrorKind<io::Error>>;

/// A white page.
pub type Sheet<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// The picture of a width and a height in pixels.
pub fn svg(width: u32, height: u32, draw: impl FnOnce(&Sheet) -> Drawn) -> Result<String> {
    let fine = (width * FINE as u32, height * FINE as u32);
    let mut text = String::new();
    let page = SVGBackend::with_string(&mut text, fine).into_drawing_area();
    let drawn = page.fill(&WHITE).and_then(|()| draw(&page)).and_then(|()| page.present());
    drop(page);
    drawn.map_err(|e| Error::Unsupported {
        what: "drawing a picture".into(),
        found: e.to_string(),
        supported: "what SVG can hold".into(),
    })?;
    // Its units are fine ones; this is the size it is shown at.
    let shown = |(width, height): (u32, u32)| format!("<svg width=\"{width}\" height=\"{height}\"");
    Ok(text.replacen(&shown(fine), &shown((width, height)), 1))
}

/// A place on the page, pixels, in units of the drawing.
pub fn place((x, y): (f64, f64)) -> (i32, i32) {
    let fine = f64::from(FINE);
    ((x * fine).round() as i32, (y * fine).round() as i32)
}

/// Letters of a height in pixels, which the crate writes 1.24 times smaller.
pub fn letters(pixels: i32, colour: RGBColor, side: HPos) -> TextStyle<'static> {
    let font = ("sans-serif", f64::from(pixels * FINE) * 1.24).into_font();
    font.color(&colour).pos(Pos::new(side, VPos::Center))
}

/// A title and what stands below it.
pub fn heading(page: &Sheet, title: &str, called: &str) -> Drawn {
    page.draw(&Text::new(clean(title), place((16.0, 22.0)), letters(17, BLACK, HPos::Left)))?;
    page.draw(&Text::new(clean(called), place((16.0, 45.0)), letters(13, BLACK, HPos::Left)))
}

/// Text without what XML cannot hold; its own signs are escaped where they are written.
pub fn clean(text: &str) -> String {
    text.chars().map(|c| if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') { ' ' } else { c }).collect()
}

pub fn rgb([r, g, b]: Rgb) -> RGBColor {
    RGBColor(r, g, b)
}
