//! Keyword options of the Python package. In: the commands. Out: `options.py`, a TypedDict for each
//! function.

use std::fmt::Write as _;

use heliotile::SceneRequest;
use heliotile::cases::{COMMANDS, Command};
use heliotile::requests::{InputKind, Many, Request, Role, Row};

use super::{MADE, help};

/// A class of options: its name, the function that takes them, the command, and the fields that
/// are arguments of their own or that the open archive has.
struct Class {
    name: &'static str,
    function: &'static str,
    command: &'static str,
    without: &'static [&'static str],
    /// True if the scene is an argument, so that its options are those of `Scene`.
    of_scene: bool,
}

/// Fields that an open archive has.
const OPENED: [&str; 3] = ["archive", "io", "grid_north"];

/// Fields of files that `write` has, and replays in memory have not.
const FILES: [&str; 7] = ["output", "by", "positions", "geo", "plot", "model", "honeybee"];

macro_rules! class {
    ($name:literal, $function:literal, $command:literal, [$($without:literal),*], $of_scene:literal) => {
        Class { name: $name, function: $function, command: $command, without: &[$($without),*], of_scene: $of_scene }
    };
}

const CLASSES: &[Class] = &[
    class!("ReplayOptions", "Archive.replay", "replay", ["weather", "conditions", "sun", "dni", "dhi"], false),
    class!("WriteOptions", "Archive.write", "replay", ["weather", "conditions", "output"], false),
    class!(
        "QueryOptions",
        "Archive.query",
        "replay",
        [
            "weather",
            "conditions",
            "every",
            "stamp",
            "year",
            "from",
            "to",
            "steps",
            "snow",
            "snow_reflectance",
            "temperature",
            "latitude",
            "longitude",
            "time_zone",
            "shift",
            "weather_stamp",
            "date_order"
        ],
        false
    ),
    class!("CompareOptions", "compare", "compare", ["after", "weather"], false),
    class!("BuildingsOptions", "Archive.buildings", "buildings", ["weather", "output"], false),
    class!("PlacesOptions", "Archive.places", "places", ["weather", "output"], false),
    class!("ShadingOptions", "Archive.shading", "shading", ["weather", "output"], false),
    class!("SunlightOptions", "Archive.sunlight", "sunlight", ["dates", "output"], false),
    class!("GlareOptions", "Archive.glare", "glare", ["dates", "output"], false),
    class!("EnvelopeOptions", "Archive.envelope", "envelope", ["within", "output"], false),
    class!("FactorsOptions", "Archive.factors", "energyplus factors", [], false),
    class!("ExtractOptions", "Archive.extract", "archive extract", ["receivers", "output"], false),
    class!("ExportOptions", "Archive.export", "export", ["output", "receiver", "html", "with"], false),
    class!("AuditOptions", "Archive.audit", "archive audit", ["scene"], true),
    class!("UpdateOptions", "Archive.update", "update", ["before", "output"], false),
    class!(
        "ComfortOptions",
        "Archive.comfort",
        "comfort",
        [
            "weather",
            "output",
            "points",
            "on",
            "spacing",
            "body_height",
            "quality",
            "set",
            "error",
            "error_weather",
            "folder",
            "replace"
        ],
        true
    ),
    class!(
        "PeopleOptions",
        "comfort",
        "comfort",
        [
            "weather",
            "output",
            "folder",
            "geo",
            "plot",
            "sky",
            "sky_scale",
            "sky_white",
            "clouds",
            "image_top",
            "reflectance",
            "schedule",
            "transmittance",
            "leaf_area_density",
            "every",
            "stamp",
            "year",
            "from",
            "to",
            "steps",
            "snow",
            "snow_reflectance",
            "temperature",
            "columns",
            "above",
            "posture",
            "sun_on",
            "surfaces",
            "film",
            "emissivity",
            "absorptance",
            "wind"
        ],
        true
    ),
    class!("CoverOptions", "Scene.cover", "receivers", ["output"], true),
    class!("BuildOptions", "build", "build", ["receivers", "output", "part", "grid_north", "dry_run"], true),
    class!(
        "PlanOptions",
        "plan",
        "build",
        ["receivers", "output", "part", "grid_north", "dry_run", "checkpoint", "fresh", "from", "no_scene"],
        true
    ),
    class!("RunOptions", "run", "run", ["weather", "output"], true),
    class!("PvOptions", "pv", "pv", ["weather", "output", "grid_north"], true),
    class!("EnergyplusOptions", "energyplus", "energyplus", ["model", "output"], false),
    class!("PartitionOptions", "partition", "atlas partition", ["output"], true),
    class!("TradeoffOptions", "tradeoff", "tradeoff", ["receivers", "output", "grid_north"], true),
    class!("RepairOptions", "repair", "archive repair", ["archive", "output", "grid_north"], true),
    class!("ReportOptions", "report", "report", ["tables", "output"], false),
    class!("MergeOptions", "merge", "archive merge", ["first", "second", "output"], false),
    class!("DiffOptions", "diff", "archive diff", ["first", "second"], false),
    class!("VerifyOptions", "verify", "archive verify", ["archive"], false),
    class!("CatalogueOptions", "Atlas.catalogue", "atlas catalogue", ["atlas"], false),
    class!("ViewOptions", "Archive.view", "view", ["archive", "port"], false),
];

/// Returns the text of `options.py`.
pub fn options() -> String {
    let mut text = format!(
        "\"\"\"Keyword options of all functions: those of the command line, by their names in Python.\"\"\"\n# {MADE}\n"
    );
    text += HEAD;
    class_of(&mut text, "SceneOptions", "Scene", SceneRequest::rows(), &["scene"]);
    for class in CLASSES {
        let rows = Command::by_name(class.command).map_or(Vec::new(), |command| (command.rows)());
        let scene: Vec<&str> =
            if class.of_scene { SceneRequest::rows().iter().map(|row| row.name).collect() } else { Vec::new() };
        let in_memory = ["ReplayOptions", "QueryOptions"].contains(&class.name);
        let left_out = |row: &Row| {
            class.without.contains(&row.name)
                || scene.contains(&row.name)
                || class.function.starts_with("Archive.") && OPENED.contains(&row.name) && row.name != "before"
                || in_memory && FILES.contains(&row.name)
                || class.name == "CompareOptions" && OPENED.contains(&row.name)
        };
        let left: Vec<&str> = rows.iter().filter(|row| left_out(row)).map(|row| row.name).collect();
        class_of(&mut text, class.name, class.function, rows, &left);
    }
    text
}

const HEAD: &str = r#"
from __future__ import annotations

import datetime
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, TypeAlias, TypedDict

#: `progress(stage, done, items)` is called up to twenty times a second; `items` is None if their
#: number is unknown. An exception of it stops the work.
Progress: TypeAlias = "Callable[[str, int, int | None], object]"

#: A number, a path of a CSV file, or a value for each row of the weather, or for each month.
Follow: TypeAlias = Any

#: Ids, a table with a column `receiver`, a path of a CSV file (`pathlib.Path`), or one of
#: `{"objects": names}`, `{"surfaces": names}`, `{"bbox": (xmin, ymin, xmax, ymax)}`.
Wanted: TypeAlias = "Sequence[str] | str | os.PathLike[str] | Mapping[str, str | Sequence[str] | Sequence[float]]"

#: A path, or an address.
Place: TypeAlias = "str | os.PathLike[str]"
"#;

fn class_of(text: &mut String, name: &str, function: &str, rows: Vec<Row>, without: &[&str]) {
    let _ = write!(text, "\n\nclass {name}(TypedDict, total=False):\n    \"\"\"Options of `{function}`.\"\"\"\n");
    for row in rows.iter().filter(|row| !without.contains(&row.name)) {
        let about = help(row, &|option| {
            let field = option.replace('-', "_");
            let known = COMMANDS.iter().flat_map(|command| (command.rows)()).find(|row| row.name == field);
            format!("`{}`", known.map_or(field, |row| row.in_python().to_owned()))
        });
        let about = about.replace('\\', "\\\\").replace("\"\"\"", "'''");
        let off = if row.is_off() { "False: " } else { "" };
        let _ = write!(text, "\n    {}: {}\n    \"\"\"{off}{about}\"\"\"\n", row.in_python(), type_of(row));
    }
    let _ = write!(
        text,
        "\n    progress: Progress | None\n    \"\"\"Called now and then with the stage, the number of items done, and the number of all.\"\"\"\n"
    );
}

/// Returns the type of a field in Python.
fn type_of(row: &Row) -> String {
    let names: Vec<String> = (row.form.choices)().iter().map(|(name, _)| format!("\"{name}\"")).collect();
    let (metavar, is_list) = (row.metavar.unwrap_or_default(), row.many == Many::List);
    let one = match (row.role, row.name) {
        _ if row.many == Many::Flag => return "bool".to_owned(),
        (_, "receivers") if row.short == Some('r') && row.role == Role::Input(InputKind::Any) => "Wanted".to_owned(),
        (_, "memory") => "int | str".to_owned(),
        (_, "from" | "to") if metavar == "DAY" => "str | datetime.date".to_owned(),
        (_, "reflectance" | "schedule" | "transmittance" | "leaf_area_density" | "temperature") => {
            return "Mapping[str, Follow] | None".to_owned();
        }
        (_, "move") => return "Mapping[str, Sequence[float]] | None".to_owned(),
        (_, "set" | "emissivity" | "absorptance" | "material") if is_list => {
            return "Mapping[str, object] | None".to_owned();
        }
        (_, "height") if metavar.contains('=') => return "Mapping[str, str] | None".to_owned(),
        (Role::Input(InputKind::Weather | InputKind::Conditions | InputKind::Receivers), _) => "Any".to_owned(),
        (Role::Input(_) | Role::Output(_), _) if metavar.contains('|') => "str | os.PathLike[str] | float".to_owned(),
        (Role::Input(_) | Role::Output(_), _) => "Place".to_owned(),
        _ if !names.is_empty() => format!("Literal[{}]", names.join(", ")),
        (_, "columns" | "bands" | "paths") => "str | Sequence[str | os.PathLike[str]]".to_owned(),
        _ if ["LENGTH", "PERCENT", "COLUMN|METRES", "EPSG", "TIME"].contains(&metavar) => "str | float".to_owned(),
        _ if ["FROM..TO", "WxH", "E,N[,Z]", "BOX", "AZIMUTH,ALTITUDE"].contains(&metavar) => {
            "str | Sequence[float]".to_owned()
        }
        (_, "bounces" | "time_zone" | "zone") => "str | float".to_owned(),
        _ => row.form.python.to_owned(),
    };
    let several = if is_list { format!(" | Sequence[{one}]") } else { String::new() };
    format!("{one}{several} | None")
}
