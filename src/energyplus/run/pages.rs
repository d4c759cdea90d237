//! The report of an injection. In: the changes to the model. Out: sections of the report.

use super::{Physics, Targets, Task};
use crate::injection::Changed;
use crate::report::{Block, Report};
use crate::sun_tables::{GroundRange, SurfaceLight};
use heliotile_core::archive::{Archive, format};
use heliotile_core::named::name_of;
use heliotile_core::replay::factors::SunGrid;
use heliotile_core::text::{Message, message};

/// Contents of the report.
pub struct ReportContents<'a> {
    pub task: &'a Task<'a>,
    pub archive: &'a Archive,
    pub lights: &'a [SurfaceLight],
    pub ground: GroundRange,
    pub targets: &'a Targets,
    pub changed: &'a Changed,
    pub warnings: &'a [Message],
}

/// Returns all sections but those of runs.
pub fn report(told: &ReportContents) -> Report {
    let model = told.task.request.model.file_name().unwrap_or_default().to_string_lossy();
    Report {
        title: format!("{model} with reflected sun"),
        sections: vec![
            ("What was done".into(), vec![Block::List(done(told))]),
            ("Surfaces".into(), surfaces(told)),
            ("Not injected".into(), vec![left_out(told.targets)]),
            ("What to know".into(), vec![Block::List(told.task.worded(told.warnings))]),
        ],
    }
}

/// Describes the injected light.
pub fn physics_lines(physics: Physics) -> Vec<Message> {
    let light = match physics {
        Physics::Full => "all diffuse reflections, mirrors, the sky of Perez 1990",
        Physics::EnergyPlus => {
            "one diffuse reflection, the mirrored sun and a uniform sky, as EnergyPlus computes them"
        }
    };
    vec![message!("light: `{{physics}} {}`: {light}", name_of(&physics))]
}

fn done(told: &ReportContents) -> Vec<String> {
    let grid = SunGrid::USUAL;
    let mut list = told.task.worded(&physics_lines(told.task.request.physics));
    list.extend([
        format!(
            "tables over the sun's azimuth in steps of {} and altitude in steps of {} degrees, for any weather, design day and time step",
            grid.azimuth_step_deg, grid.altitude_step_deg
        ),
        "direct light of sun and sky is EnergyPlus's own".into(),
        format!("archive root {}", format::hex(&told.archive.root())),
        format!("heliotile {}, for EnergyPlus 25.2", env!("CARGO_PKG_VERSION")),
    ]);
    if told.task.request.physics == Physics::Full {
        let bend = told.lights.iter().map(|light| light.bend_w_m2).fold(0.0, f64::max);
        let ground = told.ground;
        list.push(format!(
            "light of several reflections is not linear in the ground's reflectance: tables are exact at {:.3} and {:.3}, and off by at \
             most {bend:.2} W/m2 of 1000 between them",
            ground.low, ground.high
        ));
    }
    if told.lights.iter().any(|light| light.mirrored.iter().any(|value| *value > 0.0)) {
        let fine = SunGrid::FINE;
        list.push(format!(
            "tables of the mirrored sun have steps of {} and {} degrees",
            fine.azimuth_step_deg, fine.altitude_step_deg
        ));
    }
    list.extend(told.task.worded(&told.changed.notes));
    list
}

/// Returns the table of surfaces, one row a surface.
fn surfaces(told: &ReportContents) -> Vec<Block> {
    let head = [
        "surface",
        "kind",
        "zone",
        "area m2",
        "receivers",
        "sun, fixed",
        "sun, by ground",
        "sun in mirrors",
        "sky, fixed",
        "sky, by ground",
    ];
    let row = |light: &SurfaceLight| {
        let number = |value: f64| format!("{value:.2}");
        let [sun, sun_ground] = light.sun.mean();
        let [sky, sky_ground] = light.sky.mean();
        let mut cells =
            vec![light.name.clone(), light.kind.clone(), light.zone.clone(), format!("{:.2}", light.area_m2)];
        cells.push(light.receivers.to_string());
        let mirrored = light.mirrored.iter().sum::<f64>() / light.mirrored.len().max(1) as f64;
        cells.extend([sun, sun_ground, mirrored, sky, sky_ground].map(number));
        cells
    };
    let note = "W/m2: means over all suns of the table for a DNI of 1000 W/m2 (sun), and for a sky of 1000 W/m2 (sky). Fixed: light that \
                does not depend on the ground's reflectance. By ground: light that a ground of reflectance 1 adds.";
    vec![
        Block::Text(note.into()),
        Block::Table(head.map(str::to_owned).to_vec(), told.lights.iter().map(row).collect()),
    ]
}

/// Returns the list of surfaces that are hidden or get the light of their wall.
pub fn left_out(targets: &Targets) -> Block {
    let Targets { by_wall, hidden, partly, .. } = targets;
    let mut list: Vec<String> = hidden
        .iter()
        .map(|name| format!("{name}: all of it is hidden by a neighbour or the ground, and it gets no reflected light"))
        .collect();
    list.extend(partly.iter().map(|surface| {
        format!(
            "{}: {:.2} of {:.2} m2 get light, the rest is hidden by a neighbour or the ground; the surface gets the mean of both",
            surface.name, surface.free_m2, surface.whole_m2
        )
    }));
    let beyond = |(name, wall): &(String, String)| {
        format!("{name}: reaches over an edge of `{wall}` or over another window; it gets the light of that wall")
    };
    list.extend(by_wall.iter().map(beyond));
    if list.is_empty() {
        list.push("no surface that the sun may reach".into());
    }
    Block::List(list)
}
