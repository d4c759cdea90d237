//! The light on a receiver by light path: six fisheyes side by side in one scale. In: a receiver
//! and its maps under one sky. Out: a PNG.
//!
//! Each picture is the view of a camera with an equidistant lens that lies on the surface and looks
//! away from it. The distance from the middle is the angle from the normal; up is up the surface.
//! Level receivers look up and have north on top.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use super::axes::{Axis, Frame as Bar, LETTERS, MARGIN, TITLE};
use super::colours::{STEPS, inferno};
use super::drawing::{Drawing, INK, Image, PALE_INK, Rgb, Side, WHITE};
use super::fisheye::colour_of;
use super::font::Font;
use crate::outputs::provenance::Provenance;
use heliotile_core::error::Result;
use heliotile_core::hemisphere::{Frame, texel_of};
use heliotile_core::replay::maps::Map;
use heliotile_core::replay::receiver_view::ReceiverView;
use heliotile_core::replay::seen::SkyDisc;
use heliotile_core::site::north::North;
use heliotile_core::units::direction_from_degrees;

/// Colour of letters on top of radiances.
const INSIDE: Rgb = [150, 220, 230];
const SUN: Rgb = [90, 220, 255];

/// Width and height of a picture; `RADIUS` is the radius of its circle.
const CELL: (f64, f64) = (340.0, 384.0);
const RADIUS: f64 = 150.0;
/// Middle of a circle in its cell.
const MIDDLE: (f64, f64) = (170.0, 208.0);
/// Space above the six pictures; `FOOT` is the space below.
const HEAD: f64 = 60.0;
const FOOT: f64 = 80.0;
/// Letters above each picture.
const CAPTION: Font = Font::bold(14.0);

/// Ends of the scale, W/(m2 sr): from the ground on a dark day to the sky round the sun.
const DARKEST: f64 = 0.1;
const BRIGHTEST: f64 = 1000.0;

/// Sun of the panel.
pub struct PanelSun {
    /// Direction in the site's axes.
    pub direction: DVec3,
    /// Description of sun and sky in words.
    pub called: String,
}

/// Titles of the six pictures.
const TITLES: [&str; 6] =
    ["what is seen", "sky, direct", "sun, diffuse", "sun and sky in mirrors", "sky, diffuse", "all together"];

/// Radiances by light path, W/(m2 sr): sky direct, sun diffuse, sky in mirrors, sky diffuse.
struct Radiances<'v> {
    view: &'v ReceiverView,
    maps: &'v [Map],
    frame: Frame,
}

impl Radiances<'_> {
    fn channel(&self, map: &str, channel: &str) -> Option<(usize, &[f32])> {
        let map = self.maps.iter().find(|m| m.name == map)?;
        map.channels.iter().find(|c| c.name == channel).map(|c| (map.side, c.values.as_slice()))
    }

    fn at(&self, map: &str, channel: &str, direction: DVec3) -> f64 {
        let texel = |(side, values): (usize, &[f32])| {
            let (column, row) = texel_of(direction, side);
            values.get(row * side + column).copied()
        };
        self.channel(map, channel).and_then(texel).map_or(0.0, f64::from)
    }

    /// Returns the four radiances of a direction in front of the surface.
    fn of(&self, direction: DVec3) -> [f64; 4] {
        let sky = if direction.z > 0.0 { self.at("sky", "sky_direct", direction) } else { 0.0 };
        if sky > 0.0 {
            return [sky, 0.0, 0.0, 0.0];
        }
        let local = self.frame.to_local(direction);
        let texel = self.view.nearest_seen(local);
        let on_texel = |channel| {
            let value = |(_, values): (usize, &[f32])| texel.and_then(|texel| values.get(texel).copied());
            self.channel("hit", channel).and_then(value).map_or(0.0, f64::from)
        };
        let mirrored = self.view.in_mirrors(direction);
        let mirrored = mirrored.map(|(from, share)| self.at("mirror", "sky_mirrored", from) * share);
        [0.0, on_texel("sun_reflected"), mirrored.unwrap_or(0.0), on_texel("sky_reflected")]
    }

    /// Returns the irradiance from all texels of a channel, W/m\u{b2}.
    fn sum(&self, map: &str, channel: &str) -> f64 {
        let (Some((_, values)), Some((_, weights))) = (self.channel(map, channel), self.channel(map, "weight_sr"))
        else {
            return 0.0;
        };
        values.iter().zip(weights).map(|(v, w)| f64::from(*v) * f64::from(*w)).sum()
    }
}

/// Returns the panel as PNG. `maps` are the receiver's maps under one sun and sky.
pub fn panel(view: &ReceiverView, maps: &[Map], sun: &PanelSun, north: North, about: &Provenance) -> Result<Vec<u8>> {
    let frame = Frame::new(view.receiver.normal);
    let (radiances, disc) = (Radiances { view, maps, frame }, SkyDisc::new(view));
    let (width, height) = (3.0 * CELL.0, HEAD + 2.0 * CELL.1 + FOOT);
    let paint = |x: f64, y: f64| {
        let (column, row) = ((x / CELL.0).floor(), ((y - HEAD) / CELL.1).floor());
        if !(0.0..2.0).contains(&row) {
            return WHITE;
        }
        let picture = (row * 3.0 + column) as usize;
        let at = (x - column * CELL.0 - MIDDLE.0, y - HEAD - row * CELL.1 - MIDDLE.1);
        let Some(direction) = direction_at(&radiances.frame, at) else { return WHITE };
        if picture == 0 {
            return colour_of(disc.seen(direction));
        }
        let [sky, of_sun, mirrored, of_sky] = radiances.of(direction);
        colour(match picture {
            1 => sky,
            2 => of_sun,
            3 => mirrored,
            4 => of_sky,
            _ => sky + of_sun + mirrored + of_sky,
        })
    };
    let mut page = Drawing::new(width, height);
    page.image((0.0, 0.0), Image::painted([width as usize, height as usize], paint));
    let irradiances = [
        String::new(),
        format!(
            "{:.1} W/m\u{b2}, the sun {:.1}",
            radiances.sum("sky", "sky_direct"),
            radiances.sum("sky", "sun_direct")
        ),
        format!("{:.1} W/m\u{b2}", radiances.sum("hit", "sun_reflected")),
        format!(
            "{:.1} W/m\u{b2}, the sun {:.1}",
            radiances.sum("mirror", "sky_mirrored"),
            radiances.sum("mirror", "sun_mirrored")
        ),
        format!("{:.1} W/m\u{b2}", radiances.sum("hit", "sky_reflected")),
        format!("{:.1} W/m\u{b2}", total(&radiances)),
    ];
    for (picture, (title, irradiance)) in TITLES.iter().zip(&irradiances).enumerate() {
        let (left, top) = ((picture % 3) as f64 * CELL.0, HEAD + (picture / 3) as f64 * CELL.1);
        let middle = (left + MIDDLE.0, top + MIDDLE.1);
        page.ring(middle, RADIUS, 1.3, INK);
        page.text(title, (left + MIDDLE.0, top + 12.0), CAPTION, Side::Center, INK);
        page.text(irradiance, (left + MIDDLE.0, top + 30.0), LETTERS, Side::Center, INK);
        for (azimuth, name) in [(0.0, "N"), (90.0, "E"), (180.0, "S"), (270.0, "W")] {
            let way = north.to_axes(direction_from_degrees(azimuth, 0.0));
            if radiances.frame.to_local(way).z > -1e-6 {
                let (x, y) = place_at(&radiances.frame, way);
                let length = x.hypot(y).max(1.0);
                let (scale, ink) = if length > RADIUS - 2.0 { ((RADIUS + 9.0) / length, INK) } else { (1.0, INSIDE) };
                let ink = if picture == 0 { INK } else { ink };
                page.text(name, (middle.0 + x * scale, middle.1 + y * scale), LETTERS, Side::Center, ink);
            }
        }
        for place in suns(&radiances, sun.direction, picture) {
            let at = (middle.0 + place.0, middle.1 + place.1);
            page.dot(at, 4.5, INK);
            page.dot(at, 3.0, SUN);
        }
    }
    draw_words(&mut page, view, sun);
    page.png_file(about)
}

fn total(radiances: &Radiances) -> f64 {
    let of = |(map, names): (&str, [&str; 2])| names.map(|name| radiances.sum(map, name)).iter().sum::<f64>();
    let all = [
        ("sky", ["sky_direct", "sun_direct"]),
        ("hit", ["sun_reflected", "sky_reflected"]),
        ("mirror", ["sky_mirrored", "sun_mirrored"]),
    ];
    all.into_iter().map(of).sum()
}

/// Returns the positions of visible suns in a picture: direct in the picture of the sky, and
/// mirrored in that of mirrors.
fn suns(radiances: &Radiances, sun: DVec3, picture: usize) -> Vec<(f64, f64)> {
    let view = radiances.view;
    let mut found = Vec::new();
    if [1, 5].contains(&picture) && radiances.at("sky", "sun_direct", sun) > 0.0 {
        found.push(sun);
    }
    if [3, 5].contains(&picture) {
        found.extend(view.mirror_images(sun));
    }
    found.into_iter().map(|direction| place_at(&radiances.frame, direction)).collect()
}

/// Returns the position of a direction relative to the middle of a picture: x to the right, y down.
fn place_at(frame: &Frame, direction: DVec3) -> (f64, f64) {
    let local = frame.to_local(direction);
    let across = local.x.hypot(local.y);
    let r = RADIUS * across.atan2(local.z) / FRAC_PI_2;
    let scale = if across > 0.0 { r / across } else { 0.0 };
    (-local.x * scale, -local.y * scale)
}

/// Returns the direction at a position relative to the middle of a picture; `None` outside the
/// circle.
fn direction_at(frame: &Frame, at: (f64, f64)) -> Option<DVec3> {
    let (x, y) = at;
    let r = x.hypot(y);
    let angle = r / RADIUS * FRAC_PI_2;
    let scale = if r > 0.0 { angle.sin() / r } else { 0.0 };
    (r <= RADIUS).then(|| frame.to_world(DVec3::new(-x * scale, -y * scale, angle.cos())))
}

fn colour(radiance: f64) -> Rgb {
    // The logarithm of 0 is below any scale.
    let share = (radiance / DARKEST).ln() / (BRIGHTEST / DARKEST).ln();
    inferno(share as f32)
}

fn draw_words(page: &mut Drawing, view: &ReceiverView, sun: &PanelSun) {
    let (width, height) = page.size;
    let [sky, ground, obstruction] = view.views;
    let shares = format!("view factors: sky {sky:.3}, ground {ground:.3}, obstructions {obstruction:.3}");
    page.text(&TITLE.fitted(&view.receiver.id, 0.6 * width), (MARGIN, 20.0), TITLE, Side::Left, INK);
    page.text(&shares, (MARGIN, 42.0), LETTERS, Side::Left, INK);
    page.text(&sun.called, (width - MARGIN, 20.0), LETTERS, Side::Right, INK);
    let lens = "as a camera on the surface sees it, equidistant";
    page.text(lens, (width - MARGIN, 42.0), LETTERS, Side::Right, PALE_INK);
    let top = height - FOOT + 10.0;
    let bar = Bar { left: 150.0, right: width - 150.0, top, bottom: top + 16.0 };
    page.colours(&bar, STEPS, |step| inferno(step as f32 / (STEPS - 1) as f32));
    let decades = (BRIGHTEST / DARKEST).log10().round() as i32;
    let tick = |decade| (f64::from(decade) / f64::from(decades), format!("{}", DARKEST * 10_f64.powi(decade)));
    page.axis(&bar, Axis::Below, &(0..=decades).map(tick).collect::<Vec<_>>(), false);
    let (right, y) = bar.at(1.0, 0.5);
    page.text("W/(m\u{b2} sr)", (right + 12.0, y), LETTERS, Side::Left, INK);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The positions of 300 directions in front of a wall lead back to the directions; up is up,
    /// and a view to the south has east on the left: 2 of 2.
    #[test]
    fn a_view_to_the_south_has_east_on_the_left() {
        let south = Frame::new(-DVec3::Y);
        for i in 0..300 {
            let d = direction_from_degrees(180.0 + f64::from(i % 17) * 10.0 - 80.0, f64::from(i % 13) * 13.0 - 78.0);
            let back = direction_at(&south, place_at(&south, d)).expect("in front");
            assert!((back - d).length() < 1e-12, "{d}");
        }
        assert!(place_at(&south, direction_from_degrees(180.0, 30.0)).1 < -40.0);
        assert!(place_at(&south, direction_from_degrees(120.0, 0.0)).0 < -40.0);
    }
}
