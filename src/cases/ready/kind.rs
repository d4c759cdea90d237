//! Kind of a file, from its first bytes and, where these do not tell, from its name. In: a file.
//! Out: a kind that is certain, or none: then its reader decides.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use heliotile_core::archive::format;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::text::{Message, message};
use heliotile_requests::InputKind;
use heliotile_scene::format_of_name;

/// Kind that a file certainly is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Archive,
    /// A weather file, with its format.
    Weather(&'static str),
    /// A scene, with its format.
    Scene(&'static str),
    Receivers,
    Conditions,
    /// A table that heliotile wrote.
    Results,
}

/// Number of first bytes that are read.
const HEAD: u64 = 4096;

/// Refuses a file that is certainly something else, with a hint what to do with it.
pub fn check(wanted: InputKind, path: &Path) -> Result<()> {
    let Some(kind) = kind_of(path) else { return Ok(()) };
    let good = matches!(
        (wanted, kind),
        (InputKind::Any, _)
            | (InputKind::Scene | InputKind::SceneOrArchive, Kind::Scene(_))
            | (InputKind::Archive | InputKind::SceneOrArchive, Kind::Archive)
            | (InputKind::Weather, Kind::Weather(_))
            | (InputKind::Receivers, Kind::Receivers)
            | (InputKind::Conditions, Kind::Conditions)
    );
    if good {
        return Ok(());
    }
    let what = format!("is {}, not {}", kind.name(), name(wanted));
    Err(Error::input(path, None, what, advice(wanted, kind, &path.display().to_string()))
        .because(Problem::other_kind(kind.name())))
}

fn name(wanted: InputKind) -> &'static str {
    match wanted {
        InputKind::Scene => "a scene",
        InputKind::SceneOrArchive => "an archive or a scene",
        InputKind::Archive => "an archive",
        InputKind::Weather => "weather",
        InputKind::Receivers => "a table of receivers",
        InputKind::Conditions => "a table of conditions",
        InputKind::Any => "what is needed here",
    }
}

fn advice(wanted: InputKind, kind: Kind, file: &str) -> Message {
    match (wanted, kind) {
        (InputKind::Weather, Kind::Scene(_)) => {
            message!("give scene files by themselves: {{command:run}} {file} --weather WEATHER.epw")
        }
        (_, Kind::Archive) => {
            message!("replay the archive without tracing: {{command:replay}} {file} --weather WEATHER.epw")
        }
        (InputKind::Archive, Kind::Scene(_)) => {
            message!("trace the scene to an archive first: {{command:run}} {file} --weather WEATHER.epw")
        }
        (InputKind::Conditions, Kind::Weather(_)) => message!("{{command:replay}} SITE.helio --weather {file}"),
        (InputKind::SceneOrArchive, Kind::Weather(_)) => {
            message!("describe weather by: {{command:info}} --weather {file}")
        }
        (_, Kind::Weather(_)) => message!("give weather with its name: {{weather}} {file}"),
        (_, Kind::Receivers) => message!("give receivers with their name: {{receivers}} {file}"),
        (_, Kind::Conditions) => message!("{{command:replay}} SITE.helio --conditions {file}"),
        (InputKind::Receivers, Kind::Scene(_)) => {
            message!("make receivers for the scene: {{command:receivers}} {file} -o receivers.csv")
        }
        (_, Kind::Scene(_)) => {
            message!("give scene files by themselves: {{command:run}} {file} --weather WEATHER.epw")
        }
        (_, Kind::Results) => "this table holds results of heliotile: give the inputs that they were made from".into(),
    }
}

impl Kind {
    fn name(self) -> String {
        match self {
            Kind::Archive => "an archive of heliotile".into(),
            Kind::Weather(format) => format!("weather ({format})"),
            Kind::Scene(format) => format!("a scene ({format})"),
            Kind::Receivers => "a table of receivers".into(),
            Kind::Conditions => "a table of conditions".into(),
            Kind::Results => "a table of results".into(),
        }
    }
}

fn kind_of(path: &Path) -> Option<Kind> {
    let mut head = Vec::new();
    // Only regular files are read: a pipe would lose the bytes that are read here.
    let file = File::open(path).ok().filter(|file| file.metadata().is_ok_and(|about| about.is_file()))?;
    file.take(HEAD).read_to_end(&mut head).ok()?;
    // The content alone cannot tell text formats such as OBJ apart, so the name counts, too.
    by_content(&head).or_else(|| format_of_name(path).map(Kind::Scene))
}

fn by_content(head: &[u8]) -> Option<Kind> {
    for (start, kind) in [
        (format::MAGIC.as_slice(), Kind::Archive),
        (b"glTF", Kind::Scene("glTF")),
        (b"II*\0", Kind::Scene("TIFF")),
        (b"MM\0*", Kind::Scene("TIFF")),
        (b"II+\0", Kind::Scene("TIFF")),
        (b"ply\n", Kind::Scene("PLY")),
        (b"ply\r", Kind::Scene("PLY")),
    ] {
        if head.starts_with(start) {
            return Some(kind);
        }
    }
    let text = String::from_utf8_lossy(head);
    let text = text.trim_start_matches('\u{feff}').trim_start();
    let mut lines = text.lines();
    let (first, second) = (lines.next().unwrap_or_default(), lines.next().unwrap_or_default());
    let columns: Vec<&str> = first.split([',', ';', '\t']).map(str::trim).collect();
    let all = |names: &[&str]| names.iter().all(|name| columns.contains(name));
    match () {
        () if first.starts_with("LOCATION,") => Some(Kind::Weather("EPW")),
        () if second.starts_with("Date (MM/DD/YYYY)") => Some(Kind::Weather("TMY3")),
        () if text.starts_with('{') && text.contains("CityJSON") => Some(Kind::Scene("CityJSON")),
        () if all(&["receiver", "x", "y", "z"]) => Some(Kind::Receivers),
        () if all(&["condition", "dni_w_m2", "dhi_w_m2"]) => Some(Kind::Conditions),
        () if columns.iter().any(|name| ["total", "total_kwh_m2"].contains(name)) && columns.contains(&"receiver") => {
            Some(Kind::Results)
        }
        () => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each of 11 beginnings is taken for its kind, or for nothing where that is not certain.
    #[test]
    fn first_bytes_tell_the_kind_of_a_file() {
        for (head, kind) in [
            ("LOCATION,Golden,CO,USA,TMY3,724666,39.74,-105.18,-7.0,1829.0\n", Some(Kind::Weather("EPW"))),
            ("724666,\"GOLDEN\",CO,-7.0,39.7,-105.2,1829\nDate (MM/DD/YYYY),Time\n", Some(Kind::Weather("TMY3"))),
            ("\u{feff}{\"type\":\"CityJSON\",\"version\":\"2.0\"", Some(Kind::Scene("CityJSON"))),
            ("glTF\u{2}", Some(Kind::Scene("glTF"))),
            ("II*\0", Some(Kind::Scene("TIFF"))),
            ("ply\nformat", Some(Kind::Scene("PLY"))),
            ("receiver,x,y,z,nx,ny,nz\n", Some(Kind::Receivers)),
            ("condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\n", Some(Kind::Conditions)),
            ("time,receiver,total\n", Some(Kind::Results)),
            ("time,ghi,dni,dhi\n", None),
            ("v 0 0 0\n", None),
        ] {
            assert_eq!(by_content(head.as_bytes()), kind, "{head}");
        }
        assert_eq!(by_content(&format::MAGIC), Some(Kind::Archive));
    }
}
