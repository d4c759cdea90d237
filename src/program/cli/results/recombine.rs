//! Arguments of `query`, `replay`, `compare` and `factors`.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::{ArgGroup, Args};

use crate::cli::WeatherArgs;
use crate::cli::values::{Bytes, SelectionArgs, choice, parse_depth, parse_memory, table_help};
use heliotile::materials::followed_files;
use heliotile::output::MapFormat;
use heliotile::scene::input;
use heliotile::{
    Access, BandChoice, BandList, By, Changes, CompareRequest, ComponentList, ConstantOrFile, Error, Every,
    FactorsRequest, FileRequest, Illumination, LightChoice, LightPaths, MaxBounces, Moment, Observer, Provenance,
    QueryRequest, ReceiverChoice, ReplayRequest, Result, Selection, Site, SiteOptions, SkyChoice, SkyFiles, SkyModel,
    SkyScale, Snow, StampedAt, Temperature,
};

/// Returns the help of `--output`.
fn output_help() -> String {
    let maps = MapFormat::ENDINGS.map(|(ending, _)| format!(".{ending}")).join(", ");
    format!(
        "{}; `query`, `replay`, `compare` and `sunlight` also write maps: {maps}, .parquet with --geo",
        table_help("Table to write")
    )
}

/// An archive or an atlas, and how it is read.
#[derive(Args, Debug)]
pub struct SiteArgs {
    /// Archive to read, or the folder of an atlas: a path or an address
    pub archive: PathBuf,
    /// Memory to work in, such as 512MiB or 2GiB
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
    /// Way to read the archive [default: map, or pread if the archive is large compared with
    /// --memory]
    #[arg(long, value_parser = choice::<Access>())]
    pub io: Option<Access>,
    /// Use y as north, and ignore the true north of the archive's place
    #[arg(long)]
    pub grid_north: bool,
}

/// Receivers of an archive, and the table to write.
#[derive(Args, Debug)]
pub struct TableArgs {
    #[command(flatten)]
    pub site: SiteArgs,
    #[arg(long, short, default_value = "-", help = output_help())]
    pub output: PathBuf,
    #[command(flatten)]
    pub of: SelectionArgs,
    /// Grouping of rows: what each row stands for
    #[arg(long, value_parser = choice::<By>(), default_value = "receiver")]
    pub by: By,
}

impl SiteArgs {
    /// Opens the archive with all of its receivers; results state `about`.
    pub fn open(&self, about: Provenance, observer: &dyn Observer) -> Result<Site> {
        self.open_for(None, about, observer)
    }

    fn open_for(&self, selection: Option<Selection>, about: Provenance, observer: &dyn Observer) -> Result<Site> {
        let receivers = ReceiverChoice { selection, grid_north: self.grid_north };
        let options = SiteOptions { access: self.io, memory: self.memory.into(), receivers, about };
        let site = Site::open_with(&self.archive, options)?;
        site.note_of_north().iter().for_each(|note| observer.note(note));
        Ok(site)
    }
}

impl TableArgs {
    /// Opens the archive with the chosen receivers; results state `about`.
    pub fn open(&self, about: Provenance, observer: &dyn Observer) -> Result<Site> {
        self.site.open_for(self.of.selection(), about, observer)
    }

    /// Returns the table as the only output file.
    pub fn files(&self) -> FileRequest {
        FileRequest { by: self.by, ..FileRequest::of(&self.output) }
    }
}

/// Arguments that `query` and `replay` have in common.
#[derive(Args, Debug)]
pub struct RecombineArgs {
    #[command(flatten)]
    pub table: TableArgs,
    /// Write .parquet as a map (GeoParquet), one row with a polygon for each receiver, surface and
    /// so on
    #[arg(long)]
    pub geo: bool,
    /// Add the columns x, y, z, tilt_deg, azimuth_deg and area_m2 of each receiver to the table, which
    /// `build` can then read as its --receivers
    #[arg(long)]
    pub positions: bool,
    /// Draw a picture of the results. A name that ends with .png is a map of the sums (or of one
    /// condition), from above and from the south-west; one that ends with .svg is a chart of the
    /// mean of all receivers, weighted by area: bars by component of --every day, month or year (or
    /// of conditions), hours of the day by month of --every hour. May be repeated; a table is then
    /// written only if --output names one
    #[arg(long, value_name = "FILE")]
    pub plot: Vec<PathBuf>,
    /// Columns to write, in this order, such as total,sun_direct. sun_reflected and sky_reflected can
    /// be split by the kind of surface that the receiver sees, as in sun_reflected_ground and
    /// sun_reflected_obstruction; `replay` also has longwave [default: the six components and their
    /// total]
    #[arg(long, value_name = "NAMES")]
    pub columns: Option<ComponentList>,
    #[arg(long, value_name = "NAMES|FILE", help = BandChoice::described())]
    pub bands: Option<BandChoice>,
    #[command(flatten)]
    pub sky: SkyArgs,
    /// Number of sky patches: 145, 577 or 2305 [default: that for which the archive was built]
    #[arg(long)]
    pub patches: Option<usize>,
    /// Number of diffuse reflections that count: all, or 1 to 64 (1 counts the first one only)
    #[arg(long, default_value = "all", value_parser = parse_depth)]
    pub bounces: MaxBounces,
    /// Light paths that count besides direct sun and sky, their first diffuse reflection and the
    /// sun in mirrors: all, none (as in EnergyPlus), or some of bounces (further diffuse
    /// reflections), mirror-diffuse (diffuse light that also meets a mirror), mirror-sky (the sky
    /// in mirrors)
    #[arg(long, value_name = "NAMES", default_value = "all")]
    pub paths: LightPaths,
    #[command(flatten)]
    pub changes: ChangeArgs,
}

/// Radiance distribution of the sky, and clouds before it.
#[derive(Args, Debug)]
pub struct SkyArgs {
    #[arg(long, value_name = "NAME|FILE", help = SkyChoice::described(), default_value = "perez")]
    pub sky: SkyChoice,
    /// Scale of the radiances in a file of --sky [default: dhi for photographs, given for tables
    /// and matrices]
    #[arg(long, value_parser = choice::<SkyScale>())]
    pub sky_scale: Option<SkyScale>,
    /// Radiance of white in a photograph of --sky, W/m2/sr, for --sky-scale given [default: levels
    /// of .hdr and .exr are radiances]
    #[arg(long, value_name = "RADIANCE", value_parser = parse_positive)]
    pub sky_white: Option<f64>,
    /// Transmittance of clouds before sun and sky, 0 to 1 by direction: a table of patches as for
    /// --sky, or a square equidistant (fisheye) picture
    #[arg(long, value_name = "FILE")]
    pub clouds: Option<PathBuf>,
    /// Azimuth of the top of the pictures of --sky and --clouds, degrees clockwise from true north;
    /// their left side is 90 degrees further clockwise [default: 0, north]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = parse_azimuth)]
    pub image_top: Option<f64>,
}

impl SkyArgs {
    /// Returns the sky model, and the files that replace it or stand before it.
    pub fn parts(&self) -> (SkyModel, Box<SkyFiles>) {
        let (model, file) = self.sky.clone().parts();
        let files = SkyFiles {
            sky: file,
            scale: self.sky_scale,
            white_w_m2_sr: self.sky_white,
            clouds: self.clouds.clone(),
            image_top_deg: self.image_top,
        };
        (model, Box::new(files))
    }

    /// Returns the files that are read.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let sky = if let SkyChoice::File(file) = &self.sky { Some(file.as_path()) } else { None };
        sky.into_iter().chain(self.clouds.as_deref())
    }
}

/// Reflectances and transmittances in place of those of the archive.
#[derive(Args, Debug)]
pub struct ChangeArgs {
    /// Change a diffuse reflectance: GROUP=0.6, or a material's name, `ground` or `obstruction` in
    /// place of the group; may be repeated, the last one counts
    #[arg(long, value_name = "GROUP=VALUE", value_parser = parse_reflectance)]
    pub reflectance: Vec<(String, f64)>,
    /// Change a diffuse reflectance over time: a CSV with a column `reflectance` and a line for
    /// each condition, for each row of the weather file, or for each of 12 months; may be repeated
    #[arg(long, value_name = "GROUP=FILE", value_parser = parse_named::<PathBuf>)]
    pub schedule: Vec<(String, PathBuf)>,
    /// Change the transmittance of canopies, the share of light that each of their faces lets
    /// through: GROUP=0.4, or a CSV as for --schedule, with a column `transmittance` (leaves by
    /// season); may be repeated, the last one counts
    #[arg(long, value_name = "GROUP=VALUE|FILE", value_parser = parse_named::<ConstantOrFile>)]
    pub transmittance: Vec<(String, ConstantOrFile)>,
}

impl ChangeArgs {
    /// Returns the files that reflectances and transmittances follow.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        followed_files(&self.schedule, &self.transmittance)
    }

    /// Returns the changes of reflectances and transmittances.
    pub fn changes(&self, snow: Option<(Snow, f64)>) -> Changes {
        Changes {
            constant: self.reflectance.clone(),
            scheduled: self.schedule.clone(),
            transmittance: self.transmittance.clone(),
            snow,
        }
    }
}

impl RecombineArgs {
    /// Returns the light that counts.
    fn light(&self) -> Result<LightChoice> {
        let hint = "name `bounces` among the paths, or leave it out";
        let paths = self.paths.with_depth(self.bounces).map_err(|what| Error::argument("bounces", what, hint))?;
        let changes = self.changes.changes(None);
        let (sky, sky_files) = self.sky.parts();
        let bands = self.bands.as_ref().map_or(Ok(BandList::default()), |bands| bands.read(&input::read))?;
        let bands = Box::new(bands);
        let (columns, patches) = (self.columns.clone(), self.patches);
        Ok(LightChoice { columns, sky, patches, paths, changes, sky_files, bands })
    }

    /// Returns the output files.
    pub fn files(&self) -> FileRequest {
        FileRequest { positions: self.positions, geo: self.geo, plots: self.plot.clone(), ..self.table.files() }
    }

    /// Returns the files of reflectances, transmittances, skies, clouds and bands.
    pub fn schedules(&self) -> impl Iterator<Item = &Path> {
        let bands = self.bands.iter().flat_map(BandChoice::files);
        self.changes.files().chain(self.sky.files()).chain(bands)
    }
}

#[derive(Args, Debug)]
pub struct QueryArgs {
    #[command(flatten)]
    pub common: RecombineArgs,
    /// Table of suns and skies, CSV: condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2;
    /// azimuths are clockwise from true north
    #[arg(long, short)]
    pub conditions: PathBuf,
}

impl QueryArgs {
    /// Returns the request of `query`.
    pub fn request(&self) -> Result<QueryRequest> {
        Ok(QueryRequest { light: self.common.light()?, conditions: self.conditions.clone().into() })
    }
}

#[derive(Args, Debug)]
pub struct FactorsArgs {
    #[command(flatten)]
    pub table: TableArgs,
    /// Step of the sun's azimuth, degrees, from 0 to 360: a divisor of 360
    #[arg(long, value_name = "DEGREES", default_value_t = 10.0)]
    pub azimuth_step: f64,
    /// Step of the sun's altitude, degrees, from 0.5 to 90: a divisor of 90
    #[arg(long, value_name = "DEGREES", default_value_t = 5.0)]
    pub altitude_step: f64,
}

impl FactorsArgs {
    /// Returns the request of `factors`.
    pub fn request(&self) -> FactorsRequest {
        FactorsRequest {
            output: self.table.output.clone(),
            by: self.table.by,
            azimuth_step_deg: self.azimuth_step,
            altitude_step_deg: self.altitude_step,
        }
    }
}

/// Period of a weather file that counts, and periods of rows.
#[derive(Args, Debug)]
pub struct PeriodArgs {
    /// Period of a row: means in W/m2 of hours, sums in kWh/m2 of longer periods
    #[arg(long, value_parser = choice::<Every>(), default_value = "hour")]
    pub every: Every,
    /// Time that labels a row of means: the start, middle or end of its interval, as 06:00, 06:30
    /// or 07:00 for the hour from 06:00 to 07:00 (the last hour of a day ends at 00:00 of the
    /// next); sums are labelled with the start of their period
    #[arg(long, value_parser = choice::<StampedAt>(), default_value = "start")]
    pub stamp: StampedAt,
    /// Year of all dates in results, such as 2019, for example for a typical year, whose months
    /// come from different ones. Sun positions stay those of the file's dates; 29 February is left
    /// out if the year has none. --from and --to then refer to this year
    #[arg(long, value_parser = clap::value_parser!(i32).range(1..=2999))]
    pub year: Option<i32>,
    /// First day that counts, such as 2019-03-01, or 03-01 of any year (for typical years and
    /// winters), or a time such as 03-01T06:00
    #[arg(long, value_name = "DAY")]
    pub from: Option<Moment>,
    /// Last day that counts, up to its end; if it is before --from, that day of the next year, as
    /// in --from 11-01 --to 02-28
    #[arg(long, value_name = "DAY")]
    pub to: Option<Moment>,
    /// Number of sun positions within each interval of the weather file, 1 to 60 [default: the
    /// number per hour for which the archive was built]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=60))]
    pub steps: Option<u16>,
    /// Change the reflectance of all ground by the weather file: its snow depth (--snow-reflectance
    /// from 1 cm on) or its albedo
    #[arg(long, value_parser = choice::<Snow>())]
    pub snow: Option<Snow>,
    /// Diffuse reflectance of snow
    #[arg(long, default_value_t = 0.6, value_parser = parse_share, requires = "snow")]
    pub snow_reflectance: f64,
    /// Temperature of `ground` or `obstruction` surfaces for the column `longwave`: degrees
    /// Celsius, or a CSV as for --schedule with a column `temperature_c`; may be repeated, the last
    /// one counts [default: the weather file's dry bulb temperature]
    #[arg(long, value_name = "CLASS=CELSIUS|FILE")]
    pub temperature: Vec<Temperature>,
}

impl PeriodArgs {
    /// Returns the request for a replay of a weather file.
    fn request(&self, weather: &Path, common: &RecombineArgs, about: &WeatherArgs) -> Result<ReplayRequest> {
        let mut light = common.light()?;
        light.changes.snow = self.snow();
        Ok(ReplayRequest { light, about_weather: about.options(false), ..self.replay(weather) })
    }

    /// Returns the source of snow, and its reflectance.
    pub fn snow(&self) -> Option<(Snow, f64)> {
        self.snow.map(|snow| (snow, self.snow_reflectance))
    }

    /// Returns a replay of a weather file with default options of the file and the default light.
    pub fn replay(&self, weather: &Path) -> ReplayRequest {
        ReplayRequest {
            span: (self.from, self.to),
            year: self.year,
            steps: self.steps.map(usize::from),
            every: self.every,
            stamp: self.stamp,
            temperatures: self.temperature.clone(),
            ..ReplayRequest::of(weather)
        }
    }
}

#[derive(Args, Debug)]
pub struct ReplayArgs {
    #[command(flatten)]
    pub common: RecombineArgs,
    /// Weather file: EPW, TMY3, WEA, SURFRAD, CSV or JSON of a service (NSRDB, PVGIS, Open-Meteo,
    /// Solcast), or any CSV or JSON with `time` and some of ghi, dni, dhi; also packed (.gz, .zip)
    #[arg(long, short)]
    pub weather: PathBuf,
    #[command(flatten)]
    pub period: PeriodArgs,
    /// City model (CityJSON or CityJSONSeq) on whose surfaces the receivers were placed: an
    /// --output that ends with .city.json or .city.jsonl is this model with the sums added, and
    /// with a material theme `irradiation`
    #[arg(long, value_name = "INPUT.city.json", conflicts_with_all = ["honeybee", "plot"])]
    pub model: Option<PathBuf>,
    /// Write a folder of hourly results that Honeybee and Pollination read, in place of a table,
    /// with a grid for each object (a room, a city object); --by building, surface or kind makes
    /// other grids
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["output", "plot"])]
    pub honeybee: Option<PathBuf>,
    #[command(flatten)]
    pub about_weather: WeatherArgs,
}

impl ReplayArgs {
    /// Returns the request of `replay`.
    pub fn request(&self) -> Result<ReplayRequest> {
        self.period.request(&self.weather, &self.common, &self.about_weather)
    }

    /// Returns true if the hours of all receivers would go to standard output as text.
    pub fn prints_hours(&self) -> bool {
        let RecombineArgs { table, plot, .. } = &self.common;
        self.period.every == Every::Hour && table.output == Path::new("-") && plot.is_empty() && self.honeybee.is_none()
    }

    /// Returns the output files.
    pub fn files(&self) -> FileRequest {
        FileRequest { model: self.model.clone(), honeybee: self.honeybee.clone(), ..self.common.files() }
    }
}

/// Options that apply to weather files only.
const OF_WEATHER: [&str; 9] =
    ["every", "stamp", "year", "from", "to", "steps", "snow", "snow_reflectance", "temperature"];

#[derive(Args, Debug)]
#[command(
    group(ArgGroup::new("suns").required(true).args(["weather", "conditions"])),
    mut_arg("archive", |arg| arg.index(1).value_name("BEFORE").help("Archive before the change, or the folder of an atlas: a path or an address")),
    mut_arg("columns", |arg| arg.help("Columns to compare, in this order, such as total,sun_direct, as for `replay` [default: total]")),
    mut_arg("every", |arg| arg.default_value("total")),
    // A changed argument moves behind the others; the index keeps AFTER behind BEFORE.
    mut_arg("after", |arg| arg.index(2)),
)]
pub struct CompareArgs {
    #[command(flatten)]
    pub common: RecombineArgs,
    /// Archives or atlases after the change; for several, only a summary is written
    #[arg(required = true)]
    pub after: Vec<PathBuf>,
    /// Weather file, as for `replay`
    #[arg(long, short)]
    pub weather: Option<PathBuf>,
    /// Table of suns and skies in place of weather, as for `query`
    #[arg(long, short, conflicts_with_all = OF_WEATHER)]
    pub conditions: Option<PathBuf>,
    #[command(flatten)]
    pub period: PeriodArgs,
    #[arg(long, value_name = "FILE", help = table_help("Table to write with a row for each AFTER: means, and how many receivers, windows and buildings lose more than 5, 10 and 20 %"))]
    pub summary: Option<PathBuf>,
    #[arg(long, value_name = "FILE", help = table_help("Table to write of the receivers that only one of the archives holds"))]
    pub unmatched: Option<PathBuf>,
    #[command(flatten)]
    pub about_weather: WeatherArgs,
}

impl CompareArgs {
    /// Returns the request of `compare`.
    pub fn request(&self) -> Result<CompareRequest> {
        let under = match (&self.weather, &self.conditions) {
            (Some(weather), _) => {
                let request = self.period.request(weather, &self.common, &self.about_weather)?;
                Illumination::Weather(Box::new(request))
            }
            (None, Some(conditions)) => {
                let (light, conditions) = (self.common.light()?, conditions.clone().into());
                Illumination::Conditions(Box::new(QueryRequest { light, conditions }))
            }
            (None, None) => return Err(Error::argument("weather, conditions", "neither is given", "give one of them")),
        };
        let (after, summary, unmatched) = (self.after.clone(), self.summary.clone(), self.unmatched.clone());
        Ok(CompareRequest { after, under, summary, unmatched })
    }
}

/// Parses `NAME=VALUE`: a group, material or class, and its value.
fn parse_named<T: FromStr<Err: std::fmt::Display>>(text: &str) -> std::result::Result<(String, T), String> {
    // The last equals sign counts: a name may hold one, a number does not.
    match text.rsplit_once('=') {
        Some((name, value)) if !name.is_empty() => {
            let value = value.trim().parse().map_err(|error| format!("`{value}`: {error}"))?;
            Ok((name.to_string(), value))
        }
        _ => Err("give a group or a material, an equals sign and a value".into()),
    }
}

fn parse_reflectance(text: &str) -> std::result::Result<(String, f64), String> {
    match parse_named(text)? {
        (name, value) if (0.0..=1.0).contains(&value) => Ok((name, value)),
        (_, value) => Err(format!("a reflectance is from 0 to 1, not {value}")),
    }
}

pub(super) fn parse_share(text: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.0..=1.0).contains(&value) => Ok(value),
        _ => Err("give a number from 0 to 1".into()),
    }
}

fn parse_positive(text: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("give a number above 0".into()),
    }
}

fn parse_azimuth(text: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (-360.0..=360.0).contains(&value) => Ok(value),
        _ => Err("give degrees from -360 to 360".into()),
    }
}
