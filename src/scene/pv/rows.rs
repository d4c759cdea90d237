//! Rows of modules from a file. In: `rows.toml`, rows of modules on an area or a face. Out: checked
//! numbers.

use std::path::Path;

use glam::DVec2;
use serde::Deserialize;

use super::cells::{CellGrid, CellsEntry};
use super::tracker::Tracker;
use crate::coordinate::MAX_COORDINATE_M;
use crate::covering::surfaces::{Surface, Surfaces};
use crate::points::places::Rating;
use crate::text::read_toml;
use heliotile_core::error::{Error, Result};
use heliotile_core::orientation::fan::Orientation;
use heliotile_core::site::receiver::MAX_NAME_BYTES;
use heliotile_files::input;

/// Largest number of modules: more are a mix-up of metres and millimetres.
pub const MAX_MODULES: u64 = 1_000_000;

const KEYS: &str = "each [[rows]] has a name, an area = [[x, y], ...], a surface = \"NAME\", or rows = 5 and modules = 10 (with at = [x, y], their middle), tilt and azimuth or tracker = { hub = 1.5 }, pitch, \
                    width, height, and maybe clearance, setback, gap, thickness, front, rear, samples, ground, kwp, string, cells = { across = 6, up = 10 }";

/// Rows of modules of one kind.
#[derive(Clone, Debug, PartialEq)]
pub struct RowsOfModules {
    /// Name of the rows, with which names of modules begin: `field/2/5` is the fifth module of the
    /// second row.
    pub name: String,
    /// Area or surface that the rows stand on.
    pub ground: RowsGround,
    /// Orientation of modules, by true north; rows run across it. Level for trackers.
    pub turn: Orientation,
    /// Trackers that turn the modules; `None` of fixed rows.
    pub tracker: Option<Tracker>,
    /// Pitch from the lower edge of a row to that of the next, in plan, metres.
    pub pitch_m: f64,
    /// Width of a module along its row, metres.
    pub width_m: f64,
    /// Height of a module up its slope, metres.
    pub height_m: f64,
    /// Clearance of the lowest corner above the surface below, metres.
    pub clearance_m: f64,
    /// Setback from the edge of the area, in plan, metres.
    pub setback_m: f64,
    /// Gap between modules of a row, metres.
    pub gap_m: f64,
    /// Thickness from the front to the rear, metres.
    pub thickness_m: f64,
    /// Diffuse reflectances of front and rear.
    pub reflectances: [f64; 2],
    /// Number of receivers on each side, up the slope; fronts with cells have one a cell.
    pub samples: usize,
    /// Cells of the modules, as they are wired, if they are stated.
    pub cells: Option<CellGrid>,
    /// Distance of receivers on the ground among the rows, metres; `None`: no such receivers.
    pub ground_step_m: Option<f64>,
    /// Rated power of a module, and the string of the rows.
    pub rating: Rating,
}

impl RowsOfModules {
    /// Returns the depth of a module in plan, metres.
    pub(super) fn depth_m(&self) -> f64 {
        self.height_m * self.turn.normal().z.max(0.0)
    }

    /// Returns the height of modules over the pitch, which backtracking depends on.
    pub fn cover(&self) -> f64 {
        self.height_m / self.pitch_m
    }

    /// Returns true if these rows and others have the same angle at all times, or all are fixed.
    fn turns_like(&self, other: &RowsOfModules) -> bool {
        match (&self.tracker, &other.tracker) {
            (None, None) => true,
            (Some(a), Some(b)) => {
                let same_cover = (self.cover() - other.cover()).abs() < 1e-9;
                Tracker { hub_m: a.hub_m, ..*b } == *a && (same_cover || !a.backtracks)
            }
            _ => false,
        }
    }
}

/// Ground that rows are put on.
#[derive(Clone, Debug, PartialEq)]
pub enum RowsGround {
    /// Corners in plan, input coordinates, metres; heights are those of the roof or ground below.
    Area(Vec<DVec2>),
    /// Name of a surface of the scene, as `heliotile receivers` gives it.
    Surface(String),
    /// Rows of equal length around a place.
    Counted {
        /// Number of rows.
        rows: u32,
        /// Number of modules of a row.
        modules: u32,
        /// Middle of all in plan, input coordinates, metres.
        middle: DVec2,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    rows: Vec<Entry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: String,
    area: Option<Vec<[f64; 2]>>,
    surface: Option<String>,
    rows: Option<u32>,
    modules: Option<u32>,
    at: Option<[f64; 2]>,
    tilt: Option<f64>,
    azimuth: Option<f64>,
    tracker: Option<TrackerEntry>,
    pitch: f64,
    width: f64,
    height: f64,
    clearance: Option<f64>,
    #[serde(default)]
    setback: f64,
    #[serde(default)]
    gap: f64,
    #[serde(default = "usual_thickness")]
    thickness: f64,
    #[serde(default = "usual_reflectance")]
    front: f64,
    #[serde(default = "usual_reflectance")]
    rear: f64,
    #[serde(default = "usual_samples")]
    samples: usize,
    ground: Option<f64>,
    kwp: Option<f64>,
    #[serde(default)]
    string: String,
    cells: Option<CellsEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table, as in { hub = 1.5 }")]
struct TrackerEntry {
    hub: f64,
    #[serde(default = "usual_axis")]
    axis_azimuth: f64,
    #[serde(default = "usual_max_angle")]
    max_angle: f64,
    #[serde(default = "usual_backtrack")]
    backtrack: bool,
    #[serde(default = "usual_step")]
    step: f64,
}

/// Returns the default direction of axes, degrees: they lie north to south.
fn usual_axis() -> f64 {
    180.0
}

/// Returns the default largest angle, degrees, that of most trackers.
fn usual_max_angle() -> f64 {
    60.0
}

fn usual_backtrack() -> bool {
    true
}

/// Returns the default step between traced angles, degrees.
fn usual_step() -> f64 {
    10.0
}

/// Returns the default thickness, metres: a pane and its frame.
fn usual_thickness() -> f64 {
    0.03
}

/// Returns the default reflectance, close to those of pvfactors' modules: front 0.03, rear 0.05.
fn usual_reflectance() -> f64 {
    0.05
}

fn usual_samples() -> usize {
    4
}

/// Reads the rows of a file. Fails without a table.
pub fn read_rows(path: &Path) -> Result<Vec<RowsOfModules>> {
    let bytes = input::read(path)?;
    let text = String::from_utf8_lossy(&bytes);
    let document: Document = read_toml(path, &text, KEYS)?;
    let mut all: Vec<RowsOfModules> = Vec::new();
    for entry in document.rows {
        let name = entry.name.clone();
        let refuse = |what: String| Error::input(path, None, format!("the rows `{name}`: {what}"), KEYS);
        let rows = checked(entry).map_err(refuse)?;
        if all.iter().any(|other| other.name == name) {
            return Err(refuse("another table has this name, too".into()));
        }
        if all.first().is_some_and(|first| !first.turns_like(&rows)) {
            let what = "they do not turn like the rows above; give them a file of their own (trackers of a file have one \
                        axis_azimuth, max_angle, backtrack and step, and with backtrack one height over pitch)";
            return Err(refuse(what.into()));
        }
        all.push(rows);
    }
    if all.is_empty() { Err(Error::input(path, None, "lists no rows", KEYS)) } else { Ok(all) }
}

/// Largest number of names that an error suggests.
const SUGGESTED: usize = 4;

/// Returns the surface of a name; an error holds the most similar names.
pub fn surface_named<'s>(surfaces: &'s Surfaces, name: &str) -> std::result::Result<&'s Surface, Vec<&'s str>> {
    let near = || {
        let mut all: Vec<(usize, &str)> = surfaces
            .list
            .iter()
            .map(|surface| (strsim::osa_distance(name, &surface.name), surface.name.as_str()))
            .collect();
        all.sort_unstable();
        all.into_iter().take(SUGGESTED).map(|(_, name)| name).collect()
    };
    surfaces.list.iter().find(|surface| surface.name == name).ok_or_else(near)
}

fn checked(entry: Entry) -> std::result::Result<RowsOfModules, String> {
    let within = |name: &str, value: f64, [least, most]: [f64; 2]| match (least..=most).contains(&value) {
        true => Ok(value),
        false => Err(format!("`{name}` is {value}, not from {least} to {most}")),
    };
    if entry.name.is_empty() || entry.name.contains(['/', '\\', '"', ',']) || entry.name.chars().any(char::is_control) {
        return Err("the name is empty, or holds one of / \\ \" ,".into());
    }
    if entry.string.len() > MAX_NAME_BYTES || entry.string.chars().any(char::is_control) {
        return Err("`string` is longer than a name may be, or holds a line end".into());
    }
    let is_place = |p: &DVec2| p.is_finite() && p.abs().max_element() <= MAX_COORDINATE_M;
    let ground = match (entry.area, entry.surface, entry.rows, entry.modules) {
        (Some(corners), None, None, None) => {
            let all: Vec<DVec2> = corners.into_iter().map(DVec2::from).collect();
            if all.len() < 3 || !all.iter().all(is_place) {
                return Err("`area` needs three corners or more, [x, y] in metres".into());
            }
            RowsGround::Area(all)
        }
        (None, Some(surface), None, None) => RowsGround::Surface(surface),
        (None, None, Some(rows), Some(modules)) => {
            let middle = DVec2::from(entry.at.unwrap_or_default());
            if u64::from(rows) * u64::from(modules) > MAX_MODULES || rows == 0 || modules == 0 {
                return Err(format!("`rows` x `modules` is {rows} x {modules}, not from 1 to {MAX_MODULES} modules"));
            }
            if !is_place(&middle) {
                return Err("`at` needs [x, y] in metres".into());
            }
            RowsGround::Counted { rows, modules, middle }
        }
        (None, None, None, None) => return Err("no `area`, `surface`, or `rows` and `modules` are stated".into()),
        (None, None, ..) => return Err("`rows` and `modules` belong together; one is missing".into()),
        _ => return Err("more than one of `area`, `surface`, and `rows` with `modules` is stated; give one".into()),
    };
    if entry.at.is_some() && !matches!(ground, RowsGround::Counted { .. }) {
        return Err("`at` goes with `rows` and `modules` alone".into());
    }
    let turning = |name: &str, value: f64| Ok::<f64, String>(within(name, value, [-360.0, 360.0])?.rem_euclid(360.0));
    let (turn, tracker) = match (entry.tilt, entry.azimuth, entry.tracker) {
        (Some(tilt), Some(azimuth), None) => {
            let tilt_deg = within("tilt", tilt, [0.0, 90.0])?;
            (Orientation { tilt_deg, azimuth_deg: turning("azimuth", azimuth)? }, None)
        }
        (None, None, Some(stated)) => {
            let tracker = Tracker {
                axis_deg: turning("axis_azimuth", stated.axis_azimuth)?,
                hub_m: within("hub", stated.hub, [0.01, 1000.0])?,
                max_deg: within("max_angle", stated.max_angle, [1.0, 90.0])?,
                backtracks: stated.backtrack,
                step_deg: within("step", stated.step, [1.0, 90.0])?,
            };
            (tracker.turn(0.0), Some(tracker))
        }
        (_, _, None) => return Err("`tilt` and `azimuth` belong together, or `tracker` replaces both".into()),
        _ => return Err("`tracker` replaces `tilt` and `azimuth`; give one or the other".into()),
    };
    let tilt_deg = turn.tilt_deg;
    let thickness_m = within("thickness", entry.thickness, [0.001, 1.0])?;
    let [width_m, height_m] =
        [within("width", entry.width, [0.01, 1000.0])?, within("height", entry.height, [0.01, 1000.0])?];
    let pitch_m = within("pitch", entry.pitch, [0.01, 1000.0])?;
    let depth_m = height_m * tilt_deg.to_radians().cos();
    if pitch_m < depth_m - 1e-9 {
        return Err(format!("`pitch` is {pitch_m} m, but modules are {depth_m:.3} m deep in plan: rows would overlap"));
    }
    let metres = |name, value| within(name, value, [0.0, 1000.0]);
    let share = |name, value| within(name, value, [0.0, 1.0]);
    let clearance_m = match (entry.clearance, tracker) {
        (Some(_), Some(_)) => {
            return Err("`clearance` is that of fixed rows; a tracker has `hub`, the height of its axis".into());
        }
        (clearance, None) => metres("clearance", clearance.unwrap_or_default())?,
        (None, Some(Tracker { hub_m, max_deg, .. })) => {
            let (sin, cos) = max_deg.to_radians().sin_cos();
            let least = 0.5 * height_m * sin + thickness_m * cos;
            if hub_m < least {
                return Err(format!(
                    "`hub` is {hub_m} m, but at {max_deg} degrees modules reach {least:.3} m below it"
                ));
            }
            hub_m - thickness_m
        }
    };
    if tracker.is_some() && entry.ground.is_some() {
        return Err("`ground` is for fixed rows: the shade below trackers moves with them".into());
    }
    if tracker.is_some() && entry.cells.is_some() {
        return Err("`cells` is for fixed rows: trackers are traced at some angles only".into());
    }
    if !(1..=100).contains(&entry.samples) {
        return Err(format!("`samples` is {}, not from 1 to 100", entry.samples));
    }
    Ok(RowsOfModules {
        name: entry.name,
        ground,
        turn,
        tracker,
        pitch_m,
        width_m,
        height_m,
        clearance_m,
        setback_m: metres("setback", entry.setback)?,
        gap_m: metres("gap", entry.gap)?,
        thickness_m,
        reflectances: [share("front", entry.front)?, share("rear", entry.rear)?],
        samples: entry.samples,
        cells: entry.cells.map(CellsEntry::checked).transpose()?,
        ground_step_m: entry.ground.map(|step| within("ground", step, [0.01, 1000.0])).transpose()?,
        rating: Rating {
            kwp: entry.kwp.map(|kwp| within("kwp", kwp, [0.0, Rating::MAX_KW])).transpose()?,
            string: entry.string,
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_files::TestFolder;

    fn read(text: &str) -> Result<Vec<RowsOfModules>> {
        let folder = TestFolder::new();
        read_rows(&folder.write("rows.toml", text))
    }

    const AREA: &str = "area = [[0, 0], [9, 0], [9, 9]]\n";
    const GOOD: &str = "[[rows]]\nname = \"a\"\narea = [[0, 0], [9, 0], [9, 9]]\ntilt = 60\nazimuth = -90\npitch = 3\nwidth = 1\nheight = 2\n";

    /// Rows with only the required fields have the defaults: 4 samples, 0.05, 3 cm; an azimuth of
    /// -90 is 270, west.
    #[test]
    fn required_fields_alone_give_the_defaults() {
        let rows = &read(GOOD).expect("rows")[0];
        assert_eq!(
            (rows.turn.azimuth_deg, rows.samples, rows.thickness_m, rows.reflectances),
            (270.0, 4, 0.03, [0.05; 2])
        );
        assert_eq!((rows.clearance_m, rows.setback_m, rows.gap_m), (0.0, 0.0, 0.0));
        assert_eq!(rows.ground_step_m, None);
        let with_ground = &read(&format!("{GOOD}ground = 0.5\n")).expect("rows")[0];
        assert_eq!(with_ground.ground_step_m, Some(0.5));
    }

    const TURNS: &str = "tilt = 60\nazimuth = -90\n";
    const TRACKS: &str = "tracker = { hub = 1.2 }\n";

    /// Trackers turn to 60 degrees about axes to the south; their axis is 1.2 m above the surface
    /// below. Seven wrong ones are refused by name.
    #[test]
    fn trackers_have_a_hub_and_one_angle() {
        let text = GOOD.replace(TURNS, TRACKS);
        let rows = &read(&text).expect("rows")[0];
        let tracker = rows.tracker.expect("tracker");
        assert_eq!(
            (tracker.axis_deg, tracker.max_deg, tracker.backtracks, tracker.step_deg),
            (180.0, 60.0, true, 10.0)
        );
        assert!((rows.clearance_m - 1.17).abs() < 1e-12 && rows.turn.tilt_deg == 0.0, "{rows:?}");
        let twice = |other: &str| format!("{text}{}", text.replace("\"a\"", "\"b\"").replace(TRACKS, other));
        assert_eq!(read(&twice("tracker = { hub = 2 }\n")).expect("two hubs").len(), 2);
        for (wrong, expected) in [
            (text.replace(TRACKS, &format!("{TRACKS}tilt = 3\n")), "`tracker` replaces `tilt` and `azimuth`"),
            (text.replace(TRACKS, "tilt = 3\n"), "belong together"),
            (text.replace("hub = 1.2", "hub = 0.8"), "at 60 degrees modules reach 0.881 m below it"),
            (text.replace(TRACKS, &format!("{TRACKS}clearance = 3\n")), "`clearance` is that of fixed rows"),
            (text.replace(TRACKS, &format!("{TRACKS}ground = 1\n")), "`ground` is for fixed rows"),
            (twice("tracker = { hub = 1.2, max_angle = 50 }\n"), "`b`: they do not turn like the rows above"),
            (twice(TURNS), "`b`: they do not turn like the rows above"),
        ] {
            let message = read(&wrong).expect_err(expected).to_string();
            assert!(message.contains(expected), "{message}");
        }
    }

    /// Twenty wrong files are refused by name, with what is wrong.
    #[test]
    fn wrong_rows_are_refused_by_name() {
        for (from, to, expected) in [
            ("tilt = 60", "tilt = 200", "`tilt` is 200, not from 0 to 90"),
            ("pitch = 3", "pitch = 0.9", "modules are 1.000 m deep in plan: rows would overlap"),
            ("[9, 9]]", "]", "three corners or more"),
            ("name = \"a\"", "name = \"a/b\"", "holds one of"),
            ("width = 1", "width = nan", "`width` is NaN"),
            ("width = 1", "width = 1\nfront = 2", "`front` is 2"),
            ("width = 1", "widht = 1", "line 7"),
            ("area", "surface = \"x\"\narea", "more than one of `area`"),
            ("area", "rows = 2\nmodules = 3\narea", "more than one of `area`"),
            ("area", "at = [1, 2]\narea", "`at` goes with"),
            (AREA, "rows = 2\n", "one is missing"),
            (AREA, "rows = 2\nmodules = 0\n", "2 x 0, not from 1"),
            (AREA, "rows = 2000\nmodules = 2000\n", "not from 1 to 1000000 modules"),
            (AREA, "", "no `area`, `surface`, or"),
            ("width = 1", "width = 1\nsamples = 0", "`samples` is 0"),
            ("width = 1", "width = 1\nground = 0", "`ground` is 0, not from 0.01 to 1000"),
            ("width = 1", "width = 1\nground = -1", "`ground` is -1"),
            ("width = 1", "width = 1\nground = nan", "`ground` is NaN"),
            ("width = 1", "width = 1\nground = 1e-9", "`ground` is 0.000000001, not from 0.01 to 1000"),
            ("width = 1", "width = 1\ngrund = 1", "samples, ground"),
        ] {
            let message = read(&GOOD.replace(from, to)).expect_err(to).to_string();
            assert!(message.contains("rows.toml") && message.contains(expected), "{to}: {message}");
        }
        assert!(read(&format!("{GOOD}{GOOD}")).expect_err("twice").to_string().contains("has this name, too"));
    }
}
