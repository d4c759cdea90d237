//! Request for a study of modules. In: options. Out: checked values.

use std::path::{Path, PathBuf};

use super::energy::EnergyRequest;
use heliotile_builder::planning::AccuracyRequest;
use heliotile_builder::settings::Quality;
use heliotile_core::orientation::fan::OrientationLimits;
use heliotile_core::replay::reflectances::Snow;
use heliotile_core::sky::model::SkyModel;
use heliotile_core::weather::options::{StampedAt, WeatherOptions};
use heliotile_requests::{DefaultRequest, Request};
use heliotile_results::outputs::tables::format::table_endings;
use heliotile_scene::request::SceneRequest;

/// Request for a study of modules.
#[derive(Clone, Debug, Request, DefaultRequest)]
#[request(exactly_one("points", "rows"), any_of("scene", "dsm", "dem", "canopy", "landcover", "rows"))]
pub struct PvRequest {
    /// Scene around the modules; rows of a stated number stand on an open plain without one.
    #[field(flatten, ungrouped)]
    pub scene: SceneRequest,
    /// Weather file: EPW, TMY3, WEA, SURFRAD, CSV or JSON of a service (NSRDB, PVGIS, Open-Meteo,
    /// Solcast), or any CSV or JSON with `time` and some of ghi, dni, dhi; also packed (.gz, .zip).
    #[field(short = 'w', input = Weather, required)]
    pub weather: PathBuf,
    /// Facts about the weather file that it does not state itself.
    #[field(flatten, without("latitude", "longitude"), heading = "About the weather file")]
    pub about_weather: WeatherOptions,
    /// Positions of modules, CSV with columns point,x,y, z or height (metres above the roof or
    /// ground below), and tilt_deg,azimuth_deg (from true north; may be left out with --search).
    #[field(short = 'p', metavar = "FILE", input = Any)]
    pub points: Option<PathBuf>,
    /// Rows of modules, TOML: each table `rows` has a name, an area, a surface or a number of rows
    /// and modules, tilt and azimuth, or `tracker = { hub = 1.5 }` of single-axis trackers, pitch,
    /// width, height; `cells = { across = 6, up = 10 }` adds what partial shade costs. Modules
    /// shade each other, reflect light to each other, and have a front and a rear. `ground = 0.5`
    /// adds receivers on the ground among the rows, 0.5 m apart, with the light that plants use. A
    /// --quality is finer for rows than for points: the shade on the ground below them decides the
    /// light of their rears.
    #[field(short = 'r', metavar = "FILE", input = Any)]
    pub rows: Option<PathBuf>,
    /// Bifaciality, the share of the light on the rear that is added to that on the front, for
    /// poa_global and the gain.
    #[field(default = 0.8, range = 0.0..=1.0, says = "give a share from 0 to 1, as in 0.8")]
    pub bifaciality: f64,
    /// Electrical energy and its worth.
    #[field(flatten, heading = "Energy")]
    pub energy: EnergyRequest,
    /// Folder to write: points.csv, months.csv, ground.csv, ground_months.csv, energy.csv,
    /// energy_months.csv, energy_years.csv, hourly.csv, horizon/, best.csv and the archive
    /// site.helio, or those of trackers in angles/.
    #[field(name = "output", short = 'o', metavar = "FOLDER", output = Folder(&[]), required)]
    pub folder: PathBuf,
    /// Find the best tilt and azimuth of every point: best.csv, search.csv and a picture of each;
    /// points without angles get the best ones.
    #[field(requires("points"))]
    pub search: bool,
    /// Range of tilts for --search, degrees, such as 10..60, or one tilt.
    #[field(metavar = "FROM..TO", default = "0..90", parse = parse_tilts)]
    pub tilts_deg: [f64; 2],
    /// Range of azimuths for --search, degrees clockwise from true north, such as 90..270, or
    /// 300..60 through north, or one azimuth.
    #[field(metavar = "FROM..TO", default = "0..360", parse = parse_azimuths)]
    pub azimuths_deg: [f64; 2],
    /// Write the shade of the whole array into the folder shade/: the share of the sun's beam that
    /// arrives, by azimuth and altitude, and the layouts of SAM, PVGIS, Forecast.Solar and
    /// Open-Meteo Solar Forecast.
    pub shade: bool,
    /// Model of the sky's radiance distribution.
    #[field(help = SkyModel::described, default = "perez")]
    pub sky: SkyModel,
    /// Ending of the table of hours, which chooses its format.
    #[field(default = "csv", choices = table_endings)]
    pub format: String,
    /// Write no hourly table, sums only.
    #[field(conflicts("format"), negated = "no_hourly")]
    pub hourly: bool,
    /// Time that labels a row of hours: the start, middle or end of its interval.
    #[field(default = "start")]
    pub stamp: StampedAt,
    /// Year of all dates in results, such as 2019; sun positions stay those of the weather file's
    /// dates.
    #[field(range = 1..=2999)]
    pub year: Option<i32>,
    /// Take the reflectance of all ground from the weather file: its snow depth (--snow-reflectance
    /// from 1 cm on) or its albedo.
    pub snow: Option<Snow>,
    /// Diffuse reflectance of snow.
    #[field(default = 0.6, requires("snow"), range = 0.0..=1.0, says = "give a share of the light, from 0 to 1")]
    pub snow_reflectance: f64,
    /// Accuracy of the archive.
    #[field(flatten)]
    pub accuracy: AccuracyRequest,
    /// Replace results in the folder that are of another scene, points, accuracy or weather;
    /// without this option they are an error.
    #[field(neutral)]
    pub replace: bool,
}

impl PvRequest {
    /// Returns the options that results depend on besides archive and weather file, as text.
    pub(super) fn value_options(&self) -> String {
        let PvRequest { bifaciality, energy, sky, year, snow, snow_reflectance, .. } = self;
        let searched = (self.tilts_deg, self.azimuths_deg);
        format!("{:?}", (bifaciality, energy, sky, year, snow, snow_reflectance, searched, &self.about_weather))
    }

    /// Returns a study of the modules of a table of points.
    pub fn new(
        scene: SceneRequest,
        weather: impl Into<PathBuf>,
        points: impl Into<PathBuf>,
        folder: impl Into<PathBuf>,
    ) -> Self {
        let (weather, points, folder) = (weather.into(), Some(points.into()), folder.into());
        PvRequest { scene, weather, points, folder, ..PvRequest::default() }
    }

    /// Returns the table of points or the file of rows, for messages.
    pub(super) fn modules_file(&self) -> &Path {
        self.points.as_deref().or(self.rows.as_deref()).unwrap_or(Path::new(""))
    }

    /// Returns the accuracy of the build. Nearly all light of a rear comes from ground within some
    /// metres, on which the rows' own shade lies, so for rows probes and cells are finer than a
    /// quality has them for buildings (`tools/pv/run rears`). Settings by name come after these.
    pub(super) fn accuracy(&self) -> AccuracyRequest {
        let is_finer = self.rows.is_some() && self.accuracy.error_percent.is_none();
        let finer: &[&str] = match self.accuracy.quality {
            Quality::Standard if is_finer => &["probe=32", "cell_factor=2"],
            Quality::Fine if is_finer => &["probe=64", "cell_factor=1"],
            Quality::Reference if is_finer => &["probe=128", "cell_factor=2"],
            _ => &[],
        };
        let set = finer.iter().map(|text| (*text).to_owned()).chain(self.accuracy.set.iter().cloned()).collect();
        AccuracyRequest { set, ..self.accuracy.beside(Some(&self.weather), &self.about_weather) }
    }

    /// Returns the orientations that a search may choose.
    pub(super) fn limits(&self) -> OrientationLimits {
        OrientationLimits { tilts_deg: self.tilts_deg, azimuths_deg: self.azimuths_deg }
    }
}

/// Parses `10..60`, or one number for both ends.
fn parse_range(text: &str) -> std::result::Result<[f64; 2], String> {
    let number = |part: &str| match part.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("`{part}` is not a number: give degrees, as in 10..60")),
    };
    match text.split_once("..") {
        Some((from, to)) => Ok([number(from)?, number(to)?]),
        None => Ok([number(text)?; 2]),
    }
}

fn parse_tilts(text: &str) -> std::result::Result<[f64; 2], String> {
    match parse_range(text)? {
        [from, to] if 0.0 <= from && from <= to && to <= 180.0 => Ok([from, to]),
        _ => Err("tilts are from 0 (up) to 180 (down), the smaller one first".into()),
    }
}

fn parse_azimuths(text: &str) -> std::result::Result<[f64; 2], String> {
    let [from, to] = parse_range(text)?;
    if [from, to].iter().any(|azimuth| azimuth.abs() > 360.0) {
        return Err("azimuths are from -360 to 360, clockwise from true north".into());
    }
    let to = if to < from { to + 360.0 } else { to };
    if to - from > 360.0 {
        Err("the range is more than a full circle: give azimuths as in 90..270".into())
    } else {
        Ok([from, to])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows at `standard` have probes of 32 and cells of 2 footprints, a setting by name replaces
    /// one of them, and points have those of buildings, 16 and 4.
    #[test]
    fn rows_are_traced_finer_than_points() {
        let of = |request: &PvRequest| {
            let settings = request.accuracy().settings().expect("settings");
            (settings.probe, settings.cell_factor)
        };
        let points = PvRequest::default();
        let rows = PvRequest { rows: Some("rows.toml".into()), ..PvRequest::default() };
        assert_eq!((of(&points), of(&rows)), ((16, 4.0), (32, 2.0)));
        let own = AccuracyRequest { set: vec!["probe=64".into()], ..AccuracyRequest::default() };
        assert_eq!(of(&PvRequest { accuracy: own, ..rows }), (64, 2.0));
    }

    /// Ranges, one number and a sector over north are read; 7 wrong texts are refused.
    #[test]
    fn ranges_of_azimuths_may_cross_north() {
        assert_eq!((parse_tilts("10..60"), parse_tilts("30")), (Ok([10.0, 60.0]), Ok([30.0, 30.0])));
        assert_eq!((parse_azimuths("300..60"), parse_azimuths("180")), (Ok([300.0, 420.0]), Ok([180.0, 180.0])));
        assert_eq!(parse_azimuths("-90..90"), Ok([-90.0, 90.0]));
        for text in ["", "200", "60..10", "a..b", "-1..30"] {
            assert!(parse_tilts(text).is_err(), "{text}");
        }
        assert!(parse_azimuths("-360..360").is_err() && parse_azimuths("0..400").is_err());
    }
}
