//! Drawing as SVG. In: a drawing. Out: a text that is a file of its own or part of an HTML page, as
//! it has no ids and refers to nothing.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::drawing::{At, Drawing, Rgb, SCALE, SEAM, Shape, Side, Words};
use super::font::{BASELINE, FAMILIES};
use super::png::encoded;
use crate::outputs::markup::escaped;
use crate::outputs::provenance::Provenance;

/// Largest number of letters of words that fit in any font.
const SHORT: usize = 5;

impl Drawing {
    /// Returns the picture as an SVG file that states its sources.
    pub fn svg_file(mut self, about: &Provenance) -> String {
        self.sources(&about.sources());
        about.in_svg(&self.svg())
    }

    /// Returns the picture as SVG.
    pub fn svg(&self) -> String {
        let (width, height) = self.size;
        let size = format!("width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\"");
        let mut text = format!("<svg {size} xmlns=\"http://www.w3.org/2000/svg\" font-family=\"{FAMILIES}\">\n");
        self.shapes.iter().for_each(|shape| text += &(element(shape) + "\n"));
        text + "</svg>\n"
    }
}

fn element(shape: &Shape) -> String {
    match shape {
        Shape::Polygon { rings, fill } => {
            let path: String = rings.iter().map(|ring| format!("M{}Z", path(ring))).collect();
            format!("<path fill-rule=\"evenodd\" d=\"{path}\" fill=\"{}\"{}/>", hex(*fill), seam(*fill))
        }
        Shape::Rectangle { corners: [(left, top), (right, bottom)], fill, is_cell } => {
            let [x, y, width, height] = [*left, *top, right - left, bottom - top].map(number);
            let seam = if *is_cell { seam(*fill) } else { String::new() };
            let fill = hex(*fill);
            format!("<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" fill=\"{fill}\"{seam}/>")
        }
        Shape::Line { points, thick, colour } => {
            let (points, colour) = (path(points), hex(*colour));
            format!("<polyline fill=\"none\" stroke=\"{colour}\" stroke-width=\"{thick}\" points=\"{points}\"/>")
        }
        Shape::Dot { centre: (x, y), radius, fill } => {
            let [x, y] = [*x, *y].map(number);
            format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"{}\"/>", hex(*fill))
        }
        Shape::Text(words) => text(words),
        Shape::Image { corner: (x, y), image } => {
            let [x, y] = [*x, *y].map(number);
            let [width, height] = [image.columns, image.rows()].map(|side| side as f64 / SCALE as f64);
            // An image within the limits of a page can be encoded.
            let data = STANDARD.encode(encoded(image, &[]).unwrap_or_default());
            format!(
                "<image x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" href=\"data:image/png;base64,{data}\"/>"
            )
        }
    }
}

fn text(words: &Words) -> String {
    let anchor = match words.side {
        Side::Left => "start",
        Side::Center => "middle",
        Side::Right => "end",
    };
    let [x, y, size] = [words.at.0, words.at.1, words.font.size].map(number);
    let place = match words.turn_deg == 0.0 {
        true => format!("x=\"{x}\" y=\"{}\"", number(words.at.1 + BASELINE * words.font.size)),
        false => {
            let (turn, down) = (words.turn_deg, number(BASELINE * words.font.size));
            format!("transform=\"translate({x} {y}) rotate({turn})\" y=\"{down}\"")
        }
    };
    let weight = if words.font.is_bold { " font-weight=\"bold\"" } else { "" };
    // Other fonts of viewers are squeezed to the width of ours.
    let width = match words.text.chars().count() > SHORT {
        true => format!(" textLength=\"{}\" lengthAdjust=\"spacingAndGlyphs\"", number(words.font.width(&words.text))),
        false => String::new(),
    };
    let (colour, words) = (hex(words.colour), escaped(&words.text));
    format!(
        "<text {place} font-size=\"{size}\"{weight}{width} text-anchor=\"{anchor}\" fill=\"{colour}\">{words}</text>"
    )
}

/// Returns the line in the shape's own colour that closes cracks.
fn seam(fill: Rgb) -> String {
    format!(" stroke=\"{}\" stroke-width=\"{SEAM}\"", hex(fill))
}

/// Formats a coordinate to a hundredth of a point; NaN and infinity become 0.
fn number(value: f64) -> String {
    let value = if value.is_finite() { value } else { 0.0 };
    // Adding 0.0 turns -0 into 0.
    ((100.0 * value).round() / 100.0 + 0.0).to_string()
}

fn path(points: &[At]) -> String {
    let point = |(x, y): &At| format!("{},{}", number(*x), number(*y));
    points.iter().map(point).collect::<Vec<_>>().join(" ")
}

fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02X}{g:02X}{b:02X}")
}
