//! The page that shows archives, with data embedded. In: files' names and bytes, or addresses. Out:
//! one HTML file that needs no other.

use std::io::{self, Write};
use std::path::Path;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::Value;

use super::markup::escaped;
use super::sink::Sink;
use heliotile_core::archive::ReadAt;
use heliotile_core::error::{Error, Result};
use heliotile_core::weather::options::{TimeShift, WeatherOptions};

/// HTML of the page, as `src/viewer/build` makes it.
const PAGE: &str = include_str!("../page/page.html");
/// Marker in the page that is replaced by the data of the first picture.
const MARKER: &str = "<!-- heliotile: data -->";
/// Marker behind the script that is replaced by data that the first picture does not need.
const LATER: &str = "<!-- heliotile: later -->";

/// Largest number of bytes of archives in a page: with more, browsers take seconds to read them.
pub const MAX_BYTES: u64 = 50_000_000;

/// Page with the data that goes into it.
#[derive(Default)]
pub struct ViewerPage {
    scripts: String,
    later: String,
    options: serde_json::Map<String, Value>,
    holds_archive: bool,
    /// Number of bytes of archives that are embedded.
    held: u64,
}

impl ViewerPage {
    /// Embeds an archive, if it is small enough.
    pub fn with_archive(mut self, path: &Path, archive: &dyn ReadAt) -> Result<Self> {
        self.holds_archive = match self.block("archive", path, archive)? {
            Some(block) => {
                self.scripts.push_str(&block);
                true
            }
            None => false,
        };
        Ok(self)
    }

    /// Embeds another archive, after a change, if the first is embedded and both together are small
    /// enough.
    pub fn with_after(mut self, path: &Path, archive: &dyn ReadAt) -> Result<Self> {
        if self.holds_archive
            && let Some(block) = self.block("after", path, archive)?
        {
            self.later.push_str(&block);
        }
        Ok(self)
    }

    /// Returns the script element of an archive, or `None` if it does not fit beside those that are
    /// embedded.
    fn block(&mut self, id: &str, path: &Path, archive: &dyn ReadAt) -> Result<Option<String>> {
        let all = self.held.saturating_add(archive.length());
        let Some(length) = usize::try_from(archive.length()).ok().filter(|_| all <= MAX_BYTES) else {
            return Ok(None);
        };
        let bytes = archive.copy_at(0, length).map_err(Error::unread(path))?;
        self.held = all;
        Ok(Some(script(id, &name_of(path), "", &bytes)))
    }

    /// Embeds a weather file, given by its unpacked bytes.
    pub fn with_weather(mut self, path: &Path, bytes: &[u8]) -> Result<Self> {
        let packed = packed(bytes).map_err(Error::io(path, "pack"))?;
        self.scripts.push_str(&script("weather", &name_of(path), " data-packed=\"gzip\"", &packed));
        Ok(self)
    }

    /// Sets an option of the page. The options `archive`, `after` and `weather` are addresses that
    /// it reads from.
    pub fn with_option(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.options.insert(name.into(), value.into());
        self
    }

    /// Sets how the weather file is read, where this differs from the file's own statement: texts
    /// by the names of the request's fields.
    pub fn with_weather_options(self, options: &WeatherOptions) -> Self {
        let shift = match options.shift {
            shift if shift == TimeShift::default() => None,
            TimeShift::Auto => Some("auto".to_owned()),
            TimeShift::Minutes(minutes) => Some(format!("{minutes}min")),
        };
        let said = [
            ("latitude", options.latitude_deg.map(|degrees| degrees.to_string())),
            ("longitude", options.longitude_deg.map(|degrees| degrees.to_string())),
            ("time_zone", options.zone.map(|zone| zone.option())),
            ("shift", shift),
            ("weather_stamp", options.stamped_at.map(|at| at.name().to_owned())),
            ("date_order", options.date_order.map(|order| order.name().to_owned())),
        ];
        let texts: Value =
            said.into_iter().filter_map(|(name, said)| Some((name.to_owned(), Value::from(said?)))).collect();
        self.with_option("weatherOptions", texts)
    }

    /// Returns true if the archive is embedded.
    pub fn holds_archive(&self) -> bool {
        self.holds_archive
    }

    /// Returns true if the archive after is embedded.
    pub fn holds_after(&self) -> bool {
        !self.later.is_empty()
    }

    /// Writes the page.
    pub fn write(&self, path: &Path) -> Result<()> {
        let mut sink = Sink::file(path)?;
        sink.write_all(self.html().as_bytes()).map_err(Error::io(path, "write to"))?;
        sink.finish().map(|_| ())
    }

    /// Returns the page as HTML.
    pub fn html(&self) -> String {
        // `<` is replaced, so that no text can end the script element.
        let options = Value::Object(self.options.clone()).to_string().replace('<', "\\u003c");
        let data = format!("<script type=\"application/json\" id=\"options\">{options}</script>\n{}", self.scripts);
        // The data contain no marker: text in them contains no `<`.
        PAGE.replacen(MARKER, &data, 1).replacen(LATER, &self.later, 1)
    }
}

/// Returns a script element whose bytes the page finds by `id`.
fn script(id: &str, name: &str, more: &str, bytes: &[u8]) -> String {
    let name = escaped(name).replace('"', "&quot;");
    let mut text = format!("<script type=\"application/octet-stream\" id=\"{id}\" data-name=\"{name}\"{more}>");
    BASE64_STANDARD.encode_string(bytes, &mut text);
    text.push_str("</script>\n");
    text
}

/// Compresses bytes with gzip, which browsers unpack themselves.
pub fn packed(bytes: &[u8]) -> io::Result<Vec<u8>> {
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    packed.write_all(bytes)?;
    packed.finish()
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use heliotile_requests::filled;

    use super::*;

    /// The page has one marker for data and one for later data. Names with `<`, `>` and quotes
    /// cannot break out of their attribute: one script of each kind is in the page.
    #[test]
    fn names_stay_in_their_place() {
        assert_eq!([MARKER, LATER].map(|marker| PAGE.matches(marker).count()), [1, 1]);
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("\"><script>alert(1)<.helio");
        let page = ViewerPage::default().with_archive(&path, &b"not an archive".to_vec()).expect("read");
        let html = page.with_option("archive", "</script><script>alert(1)").html();
        let count = |text: &str| html.matches(text).count() - PAGE.matches(text).count();
        assert_eq!((count("<script>alert"), count("<script type="), count("id=\"archive\"")), (0, 2, 1));
        assert!(html.contains(&BASE64_STANDARD.encode(b"not an archive")));
    }

    /// The texts that a page states fill a request with the options that it was given.
    #[test]
    fn options_of_weather_arrive() {
        let given = [
            ("latitude", "-12.25"),
            ("longitude", "4.5"),
            ("time_zone", "Europe/Amsterdam"),
            ("shift", "-30min"),
            ("weather_stamp", "end"),
            ("date_order", "dmy"),
        ];
        let texts = given.map(|(name, text)| (name.to_owned(), vec![text.to_owned()]));
        let options: WeatherOptions = filled(&texts).expect("options");
        let page = ViewerPage::default().with_weather_options(&options);
        let stated: Vec<_> = page.options["weatherOptions"]
            .as_object()
            .expect("an object")
            .iter()
            .map(|(name, text)| (name.clone(), vec![text.as_str().expect("a text").to_owned()]))
            .collect();
        assert_eq!((stated.len(), filled::<WeatherOptions>(&stated).expect("options")), (6, options));
    }

    /// Two archives of 30 MB do not fit together, and none is embedded beside one that is too
    /// large; the second of two small ones stands behind the script: 1 of 3.
    #[test]
    fn archives_of_60_mb_do_not_fit_into_a_page() {
        let page = |sizes: [usize; 2]| {
            let [one, other] = sizes.map(|bytes| vec![7; bytes]);
            let page = ViewerPage::default().with_archive(Path::new("a.helio"), &one).expect("read");
            page.with_after(Path::new("b.helio"), &other).expect("read")
        };
        let held = |page: &ViewerPage| [page.holds_archive(), page.holds_after()];
        assert_eq!(held(&page([30_000_000, 30_000_000])), [true, false]);
        assert_eq!(held(&page([60_000_000, 10])), [false, false]);
        let small = page([10, 10]);
        let html = small.html();
        let place = |text: &str| html.find(text).expect("there");
        assert_eq!(held(&small), [true, true]);
        assert!(place("id=\"archive\"") < place("id=\"engine\"") && place("id=\"engine\"") < place("id=\"after\""));
    }
}
