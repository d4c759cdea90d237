//! Provenance of a file. In: the command line, the archive, the weather. Out: keys and values that
//! every format writes: metadata of Parquet and Arrow, comments of PLY, text of PNG, an element of
//! SVG, JSON. There is no time of day and no name of a machine: equal inputs give equal bytes.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value};

use super::markup::escaped;
use heliotile_core::archive::accuracy::Accuracy;
use heliotile_core::archive::manifest::Manifest;
use heliotile_core::archive::{Archive, format};
use heliotile_core::error::{Error, Result};
use heliotile_core::text::without_secrets;
use heliotile_core::weather::time::utc_offset::UtcOffset;
use heliotile_files::input::weather::weather_files;
use heliotile_weather::series::Weather;

/// Provenance of a file: names and values, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Provenance {
    entries: Vec<(&'static str, String)>,
    /// Options that change values, with their resolved values.
    options: Map<String, Value>,
}

/// Size of the largest input file that is hashed, bytes: weather, tables and rules are far smaller,
/// and hashing larger files costs seconds.
const MAX_HASHED: u64 = 64 << 20;

/// Prefix of all names.
pub const PREFIX: &str = "heliotile.";

/// Number of digits of a root that pictures show.
const ROOT_DIGITS: usize = 12;

impl Provenance {
    /// Returns the provenance of a command line: its text, and its options with resolved values.
    pub fn new(command: String, options: Map<String, Value>) -> Self {
        let version = env!("CARGO_PKG_VERSION").to_string();
        Provenance { entries: vec![("version", version), ("command", command)], options }
    }

    /// Adds a value.
    pub fn with(mut self, name: &'static str, value: impl ToString) -> Self {
        self.entries.push((name, value.to_string()));
        self
    }

    /// Adds an option whose value follows from the inputs.
    pub fn with_option(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.options.insert(name.to_string(), value.into());
        self
    }

    /// Adds the archive's file name and its root, as `info` prints it, the place of its scene, and
    /// what it states of its own error.
    pub fn with_archive(self, path: &Path, archive: &Archive) -> Self {
        let about = self.with("archive", file_name(path)).with("archive_root", format::hex(&archive.root()));
        let Manifest { place, accuracy, negligible, .. } = archive.manifest();
        about
            .with_any("place", place.as_ref())
            .with_any("stated_error", accuracy.as_ref().map(error_of))
            .with_any("left_out", negligible.as_ref())
    }

    /// Adds the BLAKE3 hashes of input files, by the names that were given; of a folder those of
    /// its weather files. Files above 64 MiB, pipes and names that are no files are left out.
    pub fn with_inputs(self, files: &[PathBuf]) -> Result<Self> {
        let in_folder = |path: &PathBuf| if path.is_dir() { weather_files(path).ok() } else { None };
        let files: Vec<PathBuf> =
            files.iter().flat_map(|path| in_folder(path).unwrap_or_else(|| vec![path.clone()])).collect();
        let mut hashes = Map::new();
        // Only regular files are read: a pipe would lose the bytes that are read here.
        let is_small = |path: &&PathBuf| fs::metadata(path).is_ok_and(|is| is.is_file() && is.len() <= MAX_HASHED);
        for path in files.iter().filter(is_small) {
            let bytes = fs::read(path).map_err(Error::io(path, "read"))?;
            hashes.insert(without_secrets(&path.to_string_lossy()), blake3::hash(&bytes).to_hex().as_str().into());
        }
        let hashes = (!hashes.is_empty()).then_some(Value::Object(hashes));
        Ok(self.with_any("inputs", hashes))
    }

    fn with_any(self, name: &'static str, value: Option<impl ToString>) -> Self {
        match value {
            Some(value) => self.with(name, value),
            None => self,
        }
    }

    /// Adds the atlas's name, and one root made of the roots of its parts, in their order.
    pub fn with_parts(self, path: &Path, roots: &[[u8; 32]]) -> Self {
        let root = Provenance::root_of_parts(roots);
        self.with("atlas", file_name(path)).with("parts", roots.len()).with("parts_root", root)
    }

    /// Returns one root made of the roots of an atlas's parts, in their order.
    pub fn root_of_parts(roots: &[[u8; 32]]) -> String {
        blake3::hash(roots.as_flattened()).to_hex().to_string()
    }

    /// Adds the weather's file name, place and clock. If the option `shift` is set, its value
    /// becomes the shift of the time stamps that was applied, in case it was found from the file.
    pub fn with_weather(mut self, path: &Path, weather: &Weather) -> Self {
        if let Some(shift) = self.options.get_mut("shift") {
            *shift = format!("{}min", weather.moved_min).into();
        }
        // Some files pad names with blanks.
        let place = weather.place.split_whitespace().collect::<Vec<_>>().join(" ");
        self.with("weather", file_name(path))
            .with("weather_place", place)
            .with("weather_latitude_deg", weather.site.latitude_deg)
            .with("weather_longitude_deg", weather.site.longitude_deg)
            .with("utc_offset", UtcOffset::of_hours(weather.site.zone_hours))
    }

    /// Returns the names, with their prefix, and the values.
    pub fn entries(&self) -> Vec<(String, String)> {
        let options = (!self.options.is_empty()).then(|| ("options", Value::Object(self.options.clone()).to_string()));
        let all = self.entries.iter().cloned().chain(options);
        all.map(|(name, value)| (format!("{PREFIX}{name}"), value)).collect()
    }

    /// Returns the entries in ASCII without control characters, for formats that allow nothing
    /// else: `\u{e9}` for an e with an accent.
    pub fn ascii(&self) -> Vec<(String, String)> {
        let plain = |c: char| if (' '..='~').contains(&c) { c.to_string() } else { c.escape_unicode().to_string() };
        let text = |text: String| text.chars().map(plain).collect();
        self.entries().into_iter().map(|(name, value)| (name, text(value))).collect()
    }

    /// Returns the entries as one JSON object; the options in it are an object, too.
    pub fn json(&self) -> Value {
        let text = |(name, value): &(&str, String)| (format!("{PREFIX}{name}"), Value::String(value.clone()));
        let mut all: Map<String, Value> = self.entries.iter().map(text).collect();
        if !self.options.is_empty() {
            all.insert(format!("{PREFIX}options"), Value::Object(self.options.clone()));
        }
        Value::Object(all)
    }

    /// Returns the program, the archive and the weather in one line, for the foot of a picture.
    pub fn sources(&self) -> String {
        let value = |name: &str| self.value(name);
        let rooted = |file: &str, root: Option<&str>| match root.and_then(|root| root.get(..ROOT_DIGITS)) {
            Some(root) => format!("{file}, root {root}"),
            None => file.to_owned(),
        };
        let archive = value("archive").map(|file| rooted(file, value("archive_root")));
        let atlas = value("atlas").map(|file| rooted(file, value("parts_root")));
        let program = value("version").map(|version| format!("heliotile {version}"));
        let conditions = value("weather").or(value("conditions")).map(str::to_owned);
        [program, archive, atlas, conditions].into_iter().flatten().collect::<Vec<_>>().join("; ")
    }

    /// Returns a description in words with the place of the weather, for the heading of a picture.
    pub fn with_place(&self, called: &str) -> String {
        match self.value("weather_place") {
            Some(place) if !place.is_empty() => format!("{called}; weather of {place}"),
            _ => called.to_owned(),
        }
    }

    fn value(&self, name: &str) -> Option<&str> {
        self.entries.iter().find(|(other, _)| *other == name).map(|(_, value)| value.as_str())
    }

    /// Returns a picture with this provenance in an element `metadata`.
    pub fn in_svg(&self, svg: &str) -> String {
        match svg.split_once('>') {
            Some((head, rest)) => {
                let text = escaped(&self.json().to_string());
                format!("{head}>\n<metadata>{text}</metadata>{rest}")
            }
            None => svg.to_string(),
        }
    }
}

/// Returns the error that an archive states, in words.
fn error_of(accuracy: &Accuracy) -> String {
    let Accuracy { rmse_percent, yearly_percent, sample, conditions, weather, .. } = accuracy;
    format!(
        "RMSE of totals {rmse_percent:.2} % of their mean by hour, {yearly_percent:.2} % of sums, from {sample} \
         receivers under {conditions} conditions ({weather})"
    )
}

fn file_name(path: &Path) -> String {
    let shown = without_secrets(&path.to_string_lossy());
    let name = Path::new(&shown).file_name();
    name.map_or_else(|| shown.clone(), |name| name.to_string_lossy().into_owned())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Returns an example with an accent, a markup character and a line end.
    pub fn example() -> Provenance {
        let options = [("every".to_string(), Value::from("hour"))].into_iter().collect();
        Provenance::new("heliotile replay été.helio".into(), options).with("weather", "a<b>\n.epw")
    }

    /// Four entries have the prefix, with the options last; in ASCII they have no accents and no
    /// line ends; in JSON the options are an object.
    #[test]
    fn entries_have_the_prefix_and_options_come_last() {
        let all = example().with_option("steps", 6).entries();
        let names: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["heliotile.version", "heliotile.command", "heliotile.weather", "heliotile.options"]);
        assert_eq!(all[3].1, r#"{"every":"hour","steps":6}"#);
        let ascii = example().ascii();
        assert_eq!(ascii[1].1, r"heliotile replay \u{e9}t\u{e9}.helio");
        assert_eq!(ascii[2].1, r"a<b>\u{a}.epw");
        assert_eq!(example().json()["heliotile.options"]["every"], "hour");
        assert!(Provenance::default().entries().is_empty());
    }

    /// The line of sources names program, archive with the start of its root and weather; the place
    /// of the weather follows a description.
    #[test]
    fn sources_name_archive_and_weather() {
        let about = Provenance::new(String::new(), Map::new()).with("archive", "a.helio");
        let about =
            about.with("archive_root", "0123456789abcdef").with("weather", "w.epw").with("weather_place", "Golden");
        let expected = format!("heliotile {}; a.helio, root 0123456789ab; w.epw", env!("CARGO_PKG_VERSION"));
        assert_eq!(about.sources(), expected);
        assert_eq!(about.with_place("a year"), "a year; weather of Golden");
        assert_eq!([Provenance::default().sources(), Provenance::default().with_place("x")], ["", "x"]);
    }

    /// A picture gets one element after its first tag, with 2 of its characters escaped.
    #[test]
    fn a_picture_gets_one_escaped_element() {
        let svg = example().in_svg("<svg width=\"1\">\n<path/></svg>\n");
        assert!(
            svg.starts_with("<svg width=\"1\">\n<metadata>{\"heliotile.command\"") && svg.ends_with("<path/></svg>\n")
        );
        assert!(svg.contains("a&lt;b&gt;\\n.epw") && svg.matches("<metadata>").count() == 1, "{svg}");
    }
}
