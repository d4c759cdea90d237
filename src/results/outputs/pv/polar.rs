//! A point's yearly sums over all orientations, as a picture. In: the sums of a fan of
//! orientations. Out: SVG: flat in the middle, steeper outwards, north on top and east on the
//! right, as on a compass.

use std::f64::consts::TAU;

use super::search::PointSearch;
use crate::outputs::pictures::axes::{Frame, LETTERS, MARGIN, TITLE};
use crate::outputs::pictures::colours::inferno;
use crate::outputs::pictures::drawing::{At, Drawing, INK, Rgb, Side, WHITE};
use crate::outputs::pictures::font::Font;
use crate::outputs::provenance::Provenance;
use heliotile_core::orientation::fan::Orientation;

/// Side of the square picture, points; `BELOW` is the height of the captions below.
const SIDE: f64 = 520.0;
const BELOW: f64 = 90.0;
/// Letters on the disc.
const SMALL: Font = Font::new(11.0);
/// Radius of the disc; `MIDDLE` is its middle.
const RADIUS: f64 = 200.0;
const MIDDLE: (f64, f64) = (260.0, 262.0);
/// Largest loss with a colour of its own, percent: larger losses have the darkest colour, too.
const MAX_LOSS: f64 = 50.0;

/// Returns the picture of a search as SVG.
pub fn svg(search: &PointSearch, about: &Provenance) -> String {
    let mut page = Drawing::new(SIDE, SIDE + BELOW);
    let tilts: Vec<f64> = search.rings.iter().map(|(ring, _)| ring.tilt_deg).collect();
    let steepest = tilts.last().copied().unwrap_or(90.0).max(1.0);
    let step = tilts.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max).max(2.0);
    let least = search.rings.iter().flat_map(|(_, values)| values).copied().fold(f64::INFINITY, f64::min);
    let most_loss = search.loss_percent(least).clamp(1.0, MAX_LOSS);
    let place = |turn: Orientation| at(turn.tilt_deg / (steepest + 0.5 * step), turn.azimuth_deg);
    for (ring, values) in &search.rings {
        let inner = ((ring.tilt_deg - 0.5 * step).max(0.0)) / (steepest + 0.5 * step);
        let outer = (ring.tilt_deg + 0.5 * step) / (steepest + 0.5 * step);
        let count = ring.azimuths_deg.len();
        for (i, (azimuth, value)) in ring.azimuths_deg.iter().zip(values).enumerate() {
            let loss = search.loss_percent(*value);
            let half = if count == 1 && ring.tilt_deg < step { 180.0 } else { half_width(&ring.azimuths_deg, i) };
            page.polygon(vec![sector(inner, outer, *azimuth, half)], colour(1.0 - loss / most_loss));
        }
    }
    for tilt in (1..).map(|i| 30.0 * f64::from(i)).take_while(|tilt| *tilt <= steepest) {
        let radius = tilt / (steepest + 0.5 * step);
        page.ring(MIDDLE, RADIUS * radius, 0.6, WHITE);
        page.text(&format!("{tilt:.0}\u{b0}"), at(radius, 22.0), SMALL, Side::Left, WHITE);
    }
    for (name, azimuth) in [("N", 0.0), ("E", 90.0), ("S", 180.0), ("W", 270.0)] {
        page.text(name, at(1.07, azimuth), LETTERS, Side::Center, INK);
    }
    let best = place(search.best.turn);
    page.dot(best, 7.0, INK);
    page.dot(best, 5.0, [0, 158, 115]);
    captions(&mut page, search, most_loss);
    page.svg_file(about)
}

/// Returns half the angle to the nearest neighbour, degrees.
fn half_width(azimuths: &[f64], i: usize) -> f64 {
    let own = azimuths[i];
    let gaps = azimuths.iter().filter(|other| **other != own).map(|other| {
        let gap = (other - own).rem_euclid(360.0);
        gap.min(360.0 - gap)
    });
    let gap = gaps.fold(360.0, f64::min);
    if gap == 360.0 { 5.0 } else { 0.5 * gap }
}

/// Draws the best orientation and losses in words, and the scale.
fn captions(page: &mut Drawing, search: &PointSearch, most_loss: f64) {
    let turn = search.best.turn;
    page.text(&search.point, (MARGIN, 22.0), TITLE, Side::Left, INK);
    let best = format!(
        "best: tilt {:.1}\u{b0}, azimuth {:.1}\u{b0}, {:.0} kWh/m\u{b2}; flat loses {:.1} %",
        turn.tilt_deg,
        turn.azimuth_deg,
        search.best.value,
        search.loss_percent(search.flat.value)
    );
    let scale = format!("loss against the best: 0 % to {most_loss:.0} % and more");
    for (words, y) in [(best, SIDE + 12.0), (scale, SIDE + 56.0)] {
        page.text(&words, (MARGIN, y), LETTERS, Side::Left, INK);
    }
    let frame = Frame { left: MARGIN, right: 316.0, top: SIDE + 28.0, bottom: SIDE + 42.0 };
    page.colours(&frame, 100, |step| colour(1.0 - step as f64 / 99.0));
}

/// Returns the position on the disc at a share of its radius and an azimuth in degrees.
fn at(share: f64, azimuth_deg: f64) -> At {
    let (sin, cos) = (azimuth_deg / 360.0 * TAU).sin_cos();
    (MIDDLE.0 + RADIUS * share * sin, MIDDLE.1 - RADIUS * share * cos)
}

fn sector(inner: f64, outer: f64, azimuth_deg: f64, half_deg: f64) -> Vec<At> {
    let parts = (half_deg / 2.0).ceil().max(2.0) as i32;
    let arc = |share: f64| {
        (0..=2 * parts).map(move |i| at(share, azimuth_deg + half_deg * (f64::from(i) / f64::from(parts) - 1.0)))
    };
    arc(outer).chain(arc(inner).rev()).collect()
}

fn colour(share: f64) -> Rgb {
    inferno(share as f32)
}
