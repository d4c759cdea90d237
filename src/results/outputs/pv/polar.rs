//! A point's year over all turns, as a picture. In: what the turns of a fan get. Out: SVG: flat in the middle, steeper outwards, north on
//! top and east on the right, as on a compass.

use std::f64::consts::TAU;

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::search::PointSearch;
use crate::outputs::pictures::colours::inferno;
use crate::outputs::pictures::sheet::{self, Drawn, FINE, Sheet, clean, letters, place as whole, rgb};
use crate::outputs::provenance::Provenance;
use heliotile_core::error::Result;
use heliotile_core::orientation::fan::Turn;

/// Of the picture, pixels.
const SIDE: i32 = 520;
const BELOW: i32 = 70;
/// Of the disc.
const RADIUS: f64 = 200.0;
const MIDDLE: (f64, f64) = (260.0, 262.0);
/// Losses from here on have the darkest colour, percent.
const MOST_LOSS: f64 = 50.0;

/// The picture of a search.
pub fn svg(search: &PointSearch, about: &Provenance) -> Result<String> {
    let text = sheet::svg(SIDE as u32, (SIDE + BELOW) as u32, |page| draw(search, page))?;
    Ok(about.in_svg(&text))
}

fn draw(search: &PointSearch, root: &Sheet) -> Drawn {
    let tilts: Vec<f64> = search.rings.iter().map(|(ring, _)| ring.tilt_deg).collect();
    let steepest = tilts.last().copied().unwrap_or(90.0).max(1.0);
    let step = tilts.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max).max(2.0);
    let least = search.rings.iter().flat_map(|(_, values)| values).copied().fold(f64::INFINITY, f64::min);
    let most_loss = (100.0 * (1.0 - least / search.best.value)).clamp(1.0, MOST_LOSS);
    let place = |turn: Turn| at(turn.tilt_deg / (steepest + 0.5 * step), turn.azimuth_deg);
    for (ring, values) in &search.rings {
        let inner = ((ring.tilt_deg - 0.5 * step).max(0.0)) / (steepest + 0.5 * step);
        let outer = (ring.tilt_deg + 0.5 * step) / (steepest + 0.5 * step);
        let count = ring.azimuths_deg.len();
        for (i, (azimuth, value)) in ring.azimuths_deg.iter().zip(values).enumerate() {
            let loss = 100.0 * (1.0 - value / search.best.value);
            let half = if count == 1 && ring.tilt_deg < step { 180.0 } else { half_width(&ring.azimuths_deg, i) };
            let points = sector(inner, outer, *azimuth, half);
            root.draw(&Polygon::new(points, colour(1.0 - loss / most_loss).filled()))?;
        }
    }
    for tilt in (1..).map(|i| 30.0 * f64::from(i)).take_while(|tilt| *tilt <= steepest) {
        let radius = tilt / (steepest + 0.5 * step);
        let ring: Vec<(i32, i32)> = (0..=120).map(|i| at(radius, 3.0 * f64::from(i))).collect();
        root.draw(&PathElement::new(ring, RGBColor(255, 255, 255).mix(0.6).stroke_width(FINE as u32)))?;
        let label = format!("{tilt:.0}\u{b0}");
        root.draw(&Text::new(label, at(radius, 22.0), letters(10, WHITE, HPos::Left)))?;
    }
    for (name, azimuth) in [("N", 0.0), ("E", 90.0), ("S", 180.0), ("W", 270.0)] {
        root.draw(&Text::new(name, at(1.07, azimuth), letters(13, BLACK, HPos::Center)))?;
    }
    let best = place(search.best.turn);
    root.draw(&Circle::new(best, 7 * FINE, BLACK.filled()))?;
    root.draw(&Circle::new(best, 5 * FINE, RGBColor(0, 158, 115).filled()))?;
    captions(root, search, most_loss)
}

/// Half the way to the neighbours, degrees.
fn half_width(azimuths: &[f64], i: usize) -> f64 {
    let own = azimuths[i];
    let gaps = azimuths.iter().filter(|other| **other != own).map(|other| {
        let gap = (other - own).rem_euclid(360.0);
        gap.min(360.0 - gap)
    });
    let gap = gaps.fold(360.0, f64::min);
    if gap == 360.0 { 5.0 } else { 0.5 * gap }
}

/// Best turn and losses in words, and the scale.
fn captions(root: &Sheet, search: &PointSearch, most_loss: f64) -> Drawn {
    let turn = search.best.turn;
    let line = |row: i32, words: String, size: i32| {
        root.draw(&Text::new(words, whole((16.0, f64::from(row))), letters(size, BLACK, HPos::Left)))
    };
    line(20, clean(&search.point), 14)?;
    let words = format!(
        "best: tilt {:.1}\u{b0}, azimuth {:.1}\u{b0}, {:.0} kWh/m\u{b2}; flat loses {:.1} %",
        turn.tilt_deg,
        turn.azimuth_deg,
        search.best.value,
        search.loss_percent(&search.flat)
    );
    line(SIDE + 12, words, 12)?;
    for i in 0..100 {
        let (x, share) = (16.0 + 3.0 * f64::from(i), 1.0 - f64::from(i) / 99.0);
        let y = f64::from(SIDE) + 26.0;
        let corners = [whole((x, y)), whole((x + 3.2, y + 14.0))];
        root.draw(&Rectangle::new(corners, colour(share).filled()))?;
    }
    line(SIDE + 58, format!("lost beside the best: 0 % to {most_loss:.0} % and more"), 11)
}

/// A place of the disc: share of its radius, azimuth in degrees.
fn at(share: f64, azimuth_deg: f64) -> (i32, i32) {
    let (sin, cos) = (azimuth_deg / 360.0 * TAU).sin_cos();
    whole((MIDDLE.0 + RADIUS * share * sin, MIDDLE.1 - RADIUS * share * cos))
}

fn sector(inner: f64, outer: f64, azimuth_deg: f64, half_deg: f64) -> Vec<(i32, i32)> {
    let parts = (half_deg / 2.0).ceil().max(2.0) as i32;
    let arc = |share: f64| {
        (0..=2 * parts).map(move |i| at(share, azimuth_deg + half_deg * (f64::from(i) / f64::from(parts) - 1.0)))
    };
    arc(outer).chain(arc(inner).rev()).collect()
}

fn colour(share: f64) -> RGBColor {
    rgb(inferno(share.clamp(0.0, 1.0) as f32))
}
