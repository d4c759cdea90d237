//! Bands of light in a request. In: names of bands, files of custom bands. Out: their columns, and
//! doubts about an archive in these bands.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use serde::Deserialize;

use super::archives::Archives;
use heliotile_core::error::{Error, Result};
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::bands::{OwnBand, columns_of};
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::site::bands::{Band, SourceScale};
use heliotile_core::site::material::Material;
use heliotile_core::text::listed;
use heliotile_files::input;
use heliotile_files::text::line_of_offset;

/// Hint that says what a file of bands may hold.
const KEYS: &str = "give tables [[band]] with a `name` and the shares `sun` and `sky` (0 to 1); `optics` (uv, visible, par or nir) \
                    selects the reflectances, by default those of all light; `partition = true` above the tables states that the shares add up to 1";

/// Allowed distance from 1 of the sum of a partition's shares: a share is stated to four digits.
const PARTITION_SLACK: f64 = 0.002;

/// Largest number of materials that a note names.
const NAMED: usize = 3;

/// Bands by their names, and files of custom bands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BandChoice {
    bands: Vec<Band>,
    files: Vec<PathBuf>,
}

impl BandChoice {
    /// Returns the help text that says which values are possible.
    pub fn described() -> String {
        let names: Vec<&str> = Band::ALL.into_iter().map(Band::name).collect();
        format!(
            "Further columns with light by band: some of {}, as in visible,par; or a .toml file of your own bands",
            names.join(", ")
        )
    }

    /// Returns the files of custom bands.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().map(PathBuf::as_path)
    }

    /// Returns the bands by name and those of the files; `files` gives the bytes of a file.
    pub fn read(&self, files: &dyn Fn(&Path) -> Result<Vec<u8>>) -> Result<BandList> {
        let mut own: Vec<OwnBand> = Vec::new();
        for path in &self.files {
            own.extend(own_bands(path, &String::from_utf8_lossy(&files(path)?))?);
        }
        let twice = (1..own.len()).find(|&i| own.iter().take(i).any(|other| other.name == own[i].name));
        if let Some(name) = twice.and_then(|i| own.get(i)).map(|band| &band.name) {
            let what = format!("two bands are named `{name}`");
            return Err(Error::argument("bands", what, "give each band a name of its own, and each file once"));
        }
        if own.len() > Component::OWN.len() {
            let what = "the number of bands of files".to_owned();
            return Err(Error::Limit { what: what.into(), value: own.len() as u64, max: Component::OWN.len() as u64 });
        }
        let mut list = BandList::new(&self.bands);
        list.columns.extend(Component::OWN.into_iter().take(own.len()));
        Ok(BandList { own, files: self.files.clone(), ..list })
    }
}

/// Parses lists such as `visible,par` or `visible,own.toml`.
impl FromStr for BandChoice {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let mut choice = BandChoice::default();
        for part in text.split(',').map(str::trim) {
            match Band::of_name(part) {
                Some(band) if choice.bands.contains(&band) => return Err(format!("`{part}` is given twice")),
                Some(band) => choice.bands.push(band),
                None if part.ends_with(".toml") && choice.files.iter().any(|file| file == Path::new(part)) => {
                    return Err(format!("`{part}` is given twice"));
                }
                None if part.ends_with(".toml") => choice.files.push(part.into()),
                None => {
                    let names: Vec<&str> = Band::ALL.into_iter().map(Band::name).collect();
                    let names = names.join(", ");
                    return Err(format!(
                        "`{part}` is not a known band: give some of {names}, or a .toml file of bands"
                    ));
                }
            }
        }
        Ok(choice)
    }
}

/// Columns of bands, and the definitions of custom bands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BandList {
    /// Columns that follow the columns of all light.
    pub columns: Vec<Component>,
    /// Custom bands, in the order of [`Component::OWN`] and at most as many.
    pub own: Vec<OwnBand>,
    /// Files that the custom bands were read from.
    pub files: Vec<PathBuf>,
}

impl BandList {
    /// Returns the columns of bands by name, without custom bands.
    pub fn new(bands: &[Band]) -> Self {
        let columns = bands.iter().flat_map(|band| columns_of(*band)).copied().collect();
        BandList { columns, ..BandList::default() }
    }

    /// Returns the names of the columns of custom bands in results.
    pub fn own_names(&self) -> Vec<String> {
        self.own.iter().map(|band| format!("total_{}", band.name)).collect()
    }

    /// Returns what a user should know about archives whose columns of bands are requested: no
    /// material states values by band, or the light that a material gives back in a band, by its
    /// other values, is not a share from 0 to 1.
    pub(super) fn doubts(&self, archives: Archives, components: ComponentSet) -> Result<Vec<String>> {
        let optics = |component: Component| {
            let band = Band::ALL.into_iter().find(|band| columns_of(*band).contains(&component));
            let own = || self.own.get(Component::OWN.iter().position(|one| *one == component)?)?.optics;
            band.or_else(own)
        };
        let is_asked = |band: &Band| components.iter().any(|component| optics(component) == Some(*band));
        let bands: Vec<Band> = Band::ALL.into_iter().filter(is_asked).collect();
        if bands.is_empty() {
            return Ok(Vec::new());
        }
        let site = OpenSite::open(archives.first())?;
        let stated = site.materials().iter().filter(|material| !material.bands.is_empty());
        if stated.clone().next().is_none() {
            return Ok(vec![format!(
                "{}: no material has values by band: materials reflect alike in all bands, and bands differ only by their shares of sun and sky",
                site.path().display()
            )]);
        }
        let of_band = |band: &Band| {
            let misfit = |material: &Material| Some(format!("`{}`: {}", material.name, material.misfit(*band)?));
            let found: Vec<String> = stated.clone().filter_map(misfit).collect();
            let names = listed(found.iter().take(NAMED), found.len());
            (!found.is_empty()).then(|| format!(
                "values of materials in {} that follow from their other values are not from 0 to 1; the nearest possible value is used: \
                 {names}",
                band.name()
            ))
        };
        Ok(bands.iter().filter_map(of_band).collect())
    }
}

/// Contents of a file of bands.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BandFile {
    #[serde(default)]
    partition: bool,
    band: Vec<toml::Spanned<StatedBand>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StatedBand {
    name: String,
    sun: f64,
    sky: f64,
    optics: Option<String>,
}

/// Reads the custom bands of a file's text.
fn own_bands(path: &Path, text: &str) -> Result<Vec<OwnBand>> {
    let refuse = |offset: Option<usize>, what: String| {
        Error::input(path, offset.map(|offset| line_of_offset(text.as_bytes(), offset)), what, KEYS)
    };
    let file: BandFile = toml::from_str(text)
        .map_err(|error| refuse(error.span().map(|span| span.start), error.message().to_owned()))?;
    let mut all: Vec<OwnBand> = Vec::new();
    for band in &file.band {
        let StatedBand { name, sun, sky, optics } = band.get_ref();
        let refuse = |what: String| Err(refuse(Some(band.span().start), what));
        let is_word = name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
        if name.is_empty() || !is_word || Band::of_name(name).is_some() || all.iter().any(|other| other.name == *name) {
            return refuse(format!(
                "`{name}` cannot name a band: use lowercase letters, digits and _, no name of a built-in band and no name twice"
            ));
        }
        if let Some((key, value)) =
            [("sun", sun), ("sky", sky)].into_iter().find(|(_, value)| !(0.0..=1.0).contains(*value))
        {
            return refuse(format!("`{key}` of band `{name}` is {value}, not a share from 0 to 1"));
        }
        let optics = match optics.as_deref() {
            None => None,
            Some(of) => match Band::of_name(of) {
                Some(band) => Some(band),
                None => return refuse(format!("`optics` of band `{name}` is `{of}`, which is not a known band")),
            },
        };
        all.push(OwnBand { name: name.clone(), shares: SourceScale { sun: *sun, sky: *sky }, optics });
    }
    if all.is_empty() {
        return Err(refuse(None, "holds no band".to_owned()));
    }
    let sums = [
        ("sun", all.iter().map(|band| band.shares.sun).sum::<f64>()),
        ("sky", all.iter().map(|band| band.shares.sky).sum()),
    ];
    match sums.into_iter().find(|(_, sum)| file.partition && (sum - 1.0).abs() > PARTITION_SLACK) {
        Some((key, sum)) => {
            Err(refuse(None, format!("states `partition = true`, but the shares `{key}` add up to {sum:.4}, not to 1")))
        }
        None => Ok(all),
    }
}

impl heliotile_requests::Parse for BandList {
    /// Reads the names, and the files of custom bands.
    fn parse(text: &str) -> std::result::Result<Self, heliotile_requests::Wrong> {
        text.parse::<BandChoice>()?.read(&input::read).map_err(|error| error.to_string().into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two names and a file are read and give 6 columns; 5 of 5 wrong lists are refused with a
    /// message that names the mistake.
    #[test]
    fn wrong_lists_of_bands_are_refused() {
        let choice: BandChoice = "visible, par,own.toml".parse().expect("bands");
        let text = "partition = true\n[[band]]\nname = \"half\"\nsun = 0.5\nsky = 0.5\n[[band]]\nname = \"rest\"\nsun = 0.5\nsky = 0.5\noptics = \"nir\"";
        let list = choice.read(&|_| Ok(text.into())).expect("a file");
        assert_eq!(list.columns.len(), 6);
        assert_eq!(list.own_names(), ["total_half", "total_rest"]);
        assert_eq!(list.own.iter().map(|band| band.optics).collect::<Vec<_>>(), [None, Some(Band::Nir)]);
        for (text, says) in [
            ("visible,red", "`red` is not a known band: give some of uv, visible, par, nir"),
            ("par,par", "`par` is given twice"),
            ("a.toml,a.toml", "`a.toml` is given twice"),
            ("", "`` is not a known band"),
            ("visible,", "`` is not a known band"),
        ] {
            assert!(text.parse::<BandChoice>().expect_err(text).contains(says), "{text}");
        }
    }

    /// Ten wrong files are refused with a message that names the mistake, eight of them with the
    /// line; nine bands are one too many.
    #[test]
    fn wrong_files_of_bands_are_refused_with_their_line() {
        let read = |text: &str| own_bands(Path::new("own.toml"), text);
        let band = |lines: &str| format!("\n[[band]]\n{lines}\n");
        for (text, says) in [
            (band("name = \"a\"\nsun = 1.2\nsky = 0.1"), "own.toml, line 2: `sun` of band `a` is 1.2, not a share"),
            (band("name = \"a\"\nsun = 0.2\nsky = nan"), "line 2: `sky` of band `a` is NaN"),
            (band("name = \"par\"\nsun = 0.2\nsky = 0.1"), "line 2: `par` cannot name a band"),
            (band("name = \"A b\"\nsun = 0.2\nsky = 0.1"), "line 2: `A b` cannot name a band"),
            (band("name = \"a\"\nsun = 0.2"), "missing field `sky`"),
            (band("name = \"a\"\nsun = 0.2\nsky = 0.2\noptics = \"red\""), "`red`, which is not a known band"),
            (band("name = \"a\"\nsun = 0.2\nsky = 0.2\nshare = 1"), "line 6: unknown field `share`"),
            (band("name = \"a\"\nsun = 0.2\nsky = 0.2").repeat(2), "line 7: `a` cannot name a band"),
            (
                format!("partition = true{}", band("name = \"a\"\nsun = 0.2\nsky = 1")),
                "`sun` add up to 0.2000, not to 1",
            ),
            ("band = []".into(), "holds no band"),
        ] {
            let error = read(&text).expect_err(says).to_string();
            assert!(error.contains(says), "{says}: {error}");
        }
        let many: String = (0..9).map(|i| band(&format!("name = \"b{i}\"\nsun = 0.1\nsky = 0.1"))).collect();
        let choice: BandChoice = "many.toml".parse().expect("a file");
        assert!(matches!(choice.read(&|_| Ok(many.clone().into())), Err(Error::Limit { value: 9, max: 8, .. })));
    }
}
