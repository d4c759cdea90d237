//! View of a receiver over the world's upper hemisphere. In: a receiver's layers, the place. Out: a
//! class for each point of an equidistant disc, and the paths of the sun over it. The x axis of the
//! site points right, the y axis up.

use glam::DVec3;
use heliotile_core::replay::receiver_view::ReceiverView;
use heliotile_core::replay::seen::{Seen, SkyDisc};
use heliotile_core::weather::time::sun_path::{DAYS, SunPath};
use serde_json::{Value, json};

use crate::Answered;
use crate::answer::{Answer, Numbers};
use crate::failure::{Failure, Kind};
use crate::open::Opened;
use crate::weather::{LoadedWeather, location};

/// Largest number of points to a side of the disc.
const MAX: usize = 2048;

/// Answers the disc of a receiver, by rows from the top.
pub fn fisheye(opened: &Opened, weather: Option<&LoadedWeather>, tile: u32, row: usize, side: usize) -> Answered {
    if !(1..=MAX).contains(&side) {
        return Err(Failure::new(Kind::Other, format!("a disc of {side} points a side"), "ask for 1 to 2048"));
    }
    let view = ReceiverView::at(&opened.site, opened.tile(tile)?, row)?;
    let disc = SkyDisc::new(&view);
    let at = |i: usize| (i as f64 + 0.5) / side as f64 * 2.0 - 1.0;
    let class = |i: usize| match SkyDisc::direction_at(at(i % side), -at(i / side)) {
        None => 0,
        Some(direction) => code(disc.seen(direction)),
    };
    let classes: Vec<u8> = (0..side * side).map(class).collect();
    let mut paths: Vec<Value> = Vec::new();
    let mut points: Vec<f32> = Vec::new();
    // A site without a place has no paths.
    if let Ok(location) = location(weather, opened.archive.manifest().place) {
        let (path, north) = (SunPath::new(&location), opened.site.north());
        let hours = path.hours.iter().enumerate().map(|(hour, line)| (hour.to_string(), line));
        let days = path.days.iter().zip(DAYS).map(|(line, (_, _, name))| (name.to_string(), line));
        for (label, line) in days.chain(hours) {
            for run in above(line) {
                paths.push(json!([label, points.len(), 2 * run.len()]));
                let places = run.into_iter().map(|sun| SkyDisc::place_of(north.to_axes(sun)));
                points.extend(places.flat_map(|(x, y)| [x as f32, y as f32]));
            }
        }
    }
    Ok(Answer::of(json!({ "side": side, "paths": paths }))
        .with("classes", Numbers::U8(&classes))
        .with("points", Numbers::F32(&points)))
}

/// Returns the number of a class in the page; 0 is outside the disc.
fn code(seen: Seen) -> u8 {
    match seen {
        Seen::Sky => 1,
        Seen::Ground => 2,
        Seen::Obstruction => 3,
        Seen::Mirror => 4,
        Seen::Canopy => 5,
        Seen::Behind => 6,
    }
}

/// Returns the runs of a line that lie above the horizon, up to the points where they cross it.
fn above(line: &[DVec3]) -> Vec<Vec<DVec3>> {
    let mut runs = Vec::new();
    let mut run: Vec<DVec3> = Vec::new();
    for two in line.windows(2) {
        let &[a, b] = two else { continue };
        let crossing = || a.lerp(b, a.z / (a.z - b.z));
        match (a.z >= 0.0, b.z >= 0.0) {
            (true, true) if run.is_empty() => run.extend([a, b]),
            (true, true) => run.push(b),
            (false, true) => run.extend([crossing(), b]),
            (true, false) => {
                if run.is_empty() {
                    run.push(a);
                }
                run.push(crossing());
                runs.push(std::mem::take(&mut run));
            }
            (false, false) => {}
        }
    }
    runs.push(run);
    runs.retain(|run| run.len() > 1);
    runs
}
