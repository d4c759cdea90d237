//! Fisheye picture of the upper hemisphere that a receiver sees: sky, obstructions, and the paths
//! of the sun.
//!
//! The projection is equidistant: the distance from the middle is the angle from the zenith, so
//! rings of altitude are evenly spaced. The site's y is up and x is right, and N stands at true
//! north. This matches a map under the picture and printed sun-path diagrams; somebody who looks up
//! sees east on the left.

use glam::DVec3;

use super::axes::{LETTERS, MARGIN, TITLE};
use super::drawing::{At, Drawing, INK, Image, PALE_INK, Rgb, Side, WHITE};
use super::font::Font;
use crate::outputs::provenance::Provenance;
use heliotile_core::error::Result;
use heliotile_core::replay::receiver_view::ReceiverView;
use heliotile_core::replay::seen::{Seen, SkyDisc};
use heliotile_core::site::north::North;
use heliotile_core::units::direction_from_degrees;
use heliotile_core::weather::time::sun_path::{MONTHS, SunPath};

/// Width and height of the picture, points; more than a row of names makes it higher.
const SIZE: [usize; 2] = [900, 980];
/// Position of the zenith; `RADIUS` is the distance of the horizon from it.
const CENTRE: At = (450.0, 500.0);
const RADIUS: f64 = 390.0;

/// Colour of open sky.
pub const SKY: Rgb = [198, 225, 247];
/// Colour of sky through leaves or screens.
pub const CANOPY: Rgb = [176, 208, 164];
/// Colour of surfaces of class obstruction.
pub const OBSTRUCTION: Rgb = [172, 170, 178];
/// Colour of surfaces of class ground.
pub const GROUND: Rgb = [196, 172, 132];
/// Colour of mirrors of any class.
pub const MIRROR: Rgb = [126, 158, 186];
/// Colour of directions behind the receiver's own surface.
pub const BEHIND: Rgb = [236, 234, 228];
const GRID: Rgb = [140, 150, 162];
const DAY: Rgb = [178, 46, 0];
const HIDDEN: Rgb = [120, 96, 90];
const HOUR: Rgb = [228, 126, 10];
const SUN: Rgb = [255, 220, 0];

/// Letters of the points of the compass; `SMALL` are those on the view.
const COMPASS: Font = Font::bold(15.0);
const SMALL: Font = Font::new(12.0);

/// Drawings over the view.
#[derive(Default)]
pub struct Overlay {
    /// Paths of the sun on [`MONTHS`], and the names of the place and its clock.
    pub path: Option<(SunPath, String)>,
    /// Hours of visible sun, in words.
    pub sun_hours: Vec<String>,
    /// Direction of a single sun.
    pub sun: Option<DVec3>,
    /// True north in the view's axes, for paths and sun.
    pub north: North,
    /// Colours of surfaces by direction, in place of those of classes, and their names.
    pub tint: Option<Tint>,
}

/// Colours of what is seen before the sky.
pub struct Tint {
    /// Colour in a direction.
    pub at: Box<dyn Fn(DVec3) -> Rgb + Sync>,
    /// Name of each colour, at most [`TINTS`].
    pub names: Vec<(String, Rgb)>,
}

/// Largest number of colours with names.
pub const TINTS: usize = 8;

/// Returns the picture as PNG.
pub fn fisheye(view: &ReceiverView, overlay: &Overlay, provenance: &Provenance) -> Result<Vec<u8>> {
    let disc = SkyDisc::new(view);
    let at = |x: f64, y: f64| SkyDisc::direction_at((x - CENTRE.0) / RADIUS, (CENTRE.1 - y) / RADIUS);
    let colour = |direction: DVec3| match (disc.seen(direction), &overlay.tint) {
        (Seen::Ground | Seen::Obstruction | Seen::Mirror, Some(tint)) => (tint.at)(direction),
        (seen, _) => colour_of(seen),
    };
    let names = names(view, overlay);
    let [width, height] = SIZE.map(|side| side as f64);
    let more = Drawing::new(width, height).swatches((MARGIN, 0.0), &names);
    let mut page = Drawing::new(width, height + more);
    page.image((0.0, 0.0), Image::painted(SIZE, |x, y| at(x, y).map_or(WHITE, colour)));
    draw_grid(&mut page, overlay.north);
    if let Some((path, _)) = &overlay.path {
        draw_path(&mut page, &disc, path, overlay.north);
    }
    if let Some(sun) = overlay.sun.filter(|sun| sun.z >= 0.0) {
        let sun = overlay.north.to_axes(sun);
        page.dot(place_of(sun), 8.0, INK);
        page.dot(place_of(sun), 6.5, SUN);
    }
    draw_words(&mut page, view, overlay);
    page.swatches((MARGIN, LEGEND_Y), &names);
    page.png_file(provenance)
}

/// Returns the position in the picture of a direction above the horizon: x to the right, y down.
pub fn place_of(direction: DVec3) -> At {
    let (x, y) = SkyDisc::place_of(direction);
    (CENTRE.0 + RADIUS * x, CENTRE.1 - RADIUS * y)
}

/// Returns the colour of a kind of surface or sky.
pub(super) fn colour_of(seen: Seen) -> Rgb {
    match seen {
        Seen::Sky => SKY,
        Seen::Canopy => CANOPY,
        Seen::Ground => GROUND,
        Seen::Obstruction => OBSTRUCTION,
        Seen::Mirror => MIRROR,
        Seen::Behind => BEHIND,
    }
}

/// Draws altitude rings every 15 degrees and azimuth rays every 30, from true north.
fn draw_grid(page: &mut Drawing, north: North) {
    for altitude in [15.0, 30.0, 45.0, 60.0, 75.0] {
        page.ring(CENTRE, RADIUS * (1.0 - altitude / 90.0), 0.7, GRID);
        let at = (CENTRE.0 + 4.0, CENTRE.1 - RADIUS * (1.0 - altitude / 90.0) - 7.0);
        page.text(&format!("{altitude}\u{b0}"), at, SMALL, Side::Left, INK);
    }
    for azimuth in (0..360).step_by(30) {
        let ray = |altitude| place_of(north.to_axes(direction_from_degrees(f64::from(azimuth), altitude)));
        page.line(&[ray(75.0), ray(0.0)], 0.7, GRID);
        let (sin, cos) = (f64::from(azimuth) - north.y_deg()).to_radians().sin_cos();
        let at = (CENTRE.0 + (RADIUS + 20.0) * sin, CENTRE.1 - (RADIUS + 16.0) * cos);
        match azimuth % 90 {
            0 => page.text(["N", "E", "S", "W"][azimuth as usize / 90], at, COMPASS, Side::Center, INK),
            _ => page.text(&format!("{azimuth}\u{b0}"), at, SMALL, Side::Center, INK),
        }
    }
    page.ring(CENTRE, RADIUS, 1.3, INK);
}

/// Draws paths of the sun, thick if the sun is visible, thin and grey if it is hidden.
fn draw_path(page: &mut Drawing, disc: &SkyDisc, path: &SunPath, north: North) {
    let turned = |lines: &[Vec<DVec3>]| -> Vec<Vec<DVec3>> {
        lines.iter().map(|line| line.iter().map(|&sun| north.to_axes(sun)).collect()).collect()
    };
    let (hours, days) = (turned(&path.hours), turned(&path.days));
    hours.iter().for_each(|hour| draw_sky_line(page, hour, 0.7, HOUR));
    let is_seen = |sun: &DVec3| matches!(disc.seen(*sun), Seen::Sky | Seen::Canopy);
    for day in &days {
        day.chunk_by(|a, b| is_seen(a) == is_seen(b)).fold(None, |before: Option<DVec3>, run| {
            // Each run begins at the last point of the one before, so that there are no gaps.
            let line: Vec<DVec3> = before.into_iter().chain(run.iter().copied()).collect();
            let (thick, colour) = if run.first().is_some_and(is_seen) { (1.8, DAY) } else { (0.8, HIDDEN) };
            draw_sky_line(page, &line, thick, colour);
            run.last().copied()
        });
    }
    // The name of a day stands beside the sun shortly before it sets.
    let setting = |day: &Vec<DVec3>| {
        let two = day.windows(2).rev().find(|two| two[0].z >= NAMED_Z && two[1].z < NAMED_Z)?;
        let (x, y) = place_of(two[0]);
        Some((x + 9.0, y - 9.0))
    };
    let named: Vec<(At, &str)> =
        days.iter().zip(MONTHS).filter_map(|(day, (_, _, name))| Some((setting(day)?, name))).collect();
    named.iter().for_each(|(at, name)| page.text(name, *at, SMALL, Side::Left, DAY));
    let is_free = |(x, y): At| {
        let apart = |((left, middle), name): &(At, &str)| {
            let half = SMALL.width(name) / 2.0;
            (left + half - x).abs() > half + SMALL.width("00") || (middle - y).abs() > SMALL.size
        };
        named.iter().all(apart)
    };
    for (hour, points) in hours.iter().enumerate() {
        // The highest point of an hour's loop is near the summer solstice; the hour's name stands
        // there, moved towards the middle, unless a day's name does.
        if let Some(top) = points.iter().copied().max_by(|a, b| a.z.total_cmp(&b.z)).filter(|top| top.z > 0.05) {
            let (x, y) = place_of(top);
            let inwards = 13.0 / (CENTRE.0 - x).hypot(CENTRE.1 - y).max(13.0);
            let at = (x + (CENTRE.0 - x) * inwards, y + (CENTRE.1 - y) * inwards);
            if is_free(at) {
                page.text(&hour.to_string(), at, SMALL, Side::Center, DAY);
            }
        }
    }
}

/// Sine of the altitude at which days are named.
const NAMED_Z: f64 = 0.1;

/// Draws the part of a line above the horizon.
fn draw_sky_line(page: &mut Drawing, line: &[DVec3], thick: f64, colour: Rgb) {
    let mut run: Vec<At> = Vec::new();
    for two in line.windows(2) {
        let (a, b) = (two[0], two[1]);
        let crossing = || place_of(a.lerp(b, a.z / (a.z - b.z)));
        match (a.z >= 0.0, b.z >= 0.0) {
            (true, true) => run.extend([place_of(a), place_of(b)]),
            (false, true) => run.extend([crossing(), place_of(b)]),
            (true, false) => {
                run.extend([place_of(a), crossing()]);
                page.line(&std::mem::take(&mut run), thick, colour);
            }
            (false, false) => {}
        }
    }
    page.line(&run, thick, colour);
}

/// Vertical position of the first row of names, points.
const LEGEND_Y: f64 = SIZE[1] as f64 - 40.0;

/// Returns the names of colours.
fn names<'a>(view: &ReceiverView, overlay: &'a Overlay) -> Vec<(&'a str, Rgb)> {
    let own = overlay.tint.iter().flat_map(|tint| &tint.names).map(|(name, colour)| (name.as_str(), *colour));
    let surfaces = [("obstruction", OBSTRUCTION), ("ground", GROUND)];
    let mirror = view.has_mirrors().then_some(("mirror", MIRROR));
    let classes = surfaces.into_iter().chain(mirror).filter(|_| overlay.tint.is_none());
    [("sky", SKY)].into_iter().chain(own).chain(classes).chain([("behind the surface", BEHIND)]).collect()
}

fn draw_words(page: &mut Drawing, view: &ReceiverView, overlay: &Overlay) {
    let (receiver, right) = (&view.receiver, page.size.0 - MARGIN);
    page.text(&receiver.id, (MARGIN, 22.0), TITLE, Side::Left, INK);
    let n = receiver.normal;
    let azimuth = overlay.north.azimuth_deg(n);
    let tilt = n.z.clamp(-1.0, 1.0).acos().to_degrees();
    let towards = if n.x.hypot(n.y) < 1e-6 { String::new() } else { format!(" towards {azimuth:.0}\u{b0}") };
    let at = receiver.position;
    let place = format!("at {:.2}, {:.2}, {:.2} m, tilted {tilt:.0}\u{b0}{towards}", at.x, at.y, at.z);
    let [sky, ground, obstruction] = view.views;
    let shares = format!("view factors: sky {sky:.3}, ground {ground:.3}, obstructions {obstruction:.3}");
    for (line, y) in [place, shares].iter().zip([43.0, 60.0]) {
        page.text(line, (MARGIN, y), LETTERS, Side::Left, INK);
    }
    for (line, y) in overlay.sun_hours.iter().zip([77.0, 94.0]) {
        page.text(line, (MARGIN, y), LETTERS, Side::Left, DAY);
    }
    let seen = if overlay.north.is_y() { "seen on a map: east is right" } else { "seen on a plan: x is right" };
    for (line, y) in [seen, "equidistant: rings of altitude"].iter().zip([43.0, 60.0]) {
        page.text(line, (right, y), LETTERS, Side::Right, PALE_INK);
    }
    if let Some((_, clock)) = &overlay.path {
        page.text(clock, (right, 77.0), LETTERS, Side::Right, DAY);
    }
}
