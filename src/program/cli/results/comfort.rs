//! Arguments of `comfort`.

use std::path::{Path, PathBuf};

use clap::Args;

use super::recombine::{ChangeArgs, PeriodArgs, SkyArgs};
use crate::cli::values::{Bytes, choice, parse_memory, table_help};
use crate::cli::{AccuracyArgs, ClockArgs, Metres, SceneArgs};
use heliotile::output::folder_beside;
use heliotile::{
    ClassShare, ComfortChoice, ComfortColumn, ComfortRequest, ComfortSiteRequest, Error, FileRequest, LightChoice,
    Posture, ReplayRequest, Result, Site, SunOnPerson, SurfaceTemperatures, Temperature, WindChoice,
};

/// Returns the help of `--output`.
fn output_help() -> String {
    format!("{}; also maps, as for `replay`", table_help("Table to write"))
}

#[derive(Args, Debug)]
#[command(mut_arg("scene", |arg| arg.help(
    "Archive of people that an earlier `comfort` built, or an atlas of people: a path or an address; or scene files, for which --folder then gets an archive of people"
)))]
pub struct ComfortArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Weather file with air temperature, humidity and wind: EPW, TMY3, SURFRAD, CSV or JSON of a
    /// service; also packed (.gz, .zip)
    #[arg(long, short)]
    pub weather: PathBuf,
    #[arg(long, short, default_value = "-", help = output_help())]
    pub output: PathBuf,
    /// Write .parquet as a map (GeoParquet), one row with a polygon for each point
    #[arg(long)]
    pub geo: bool,
    /// Draw a map (.png), from above and from the south-west; may be repeated. A table is then
    /// written only if --output names one
    #[arg(long, value_name = "FILE")]
    pub plot: Vec<PathBuf>,
    /// Columns to write, in this order: some of mrt, utci, pet, air, wind, shortwave and longwave
    /// (six planes each) [default: mrt,utci,pet]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub columns: Vec<ComfortColumn>,
    /// Limits of the UTCI, degrees Celsius: rows of days and longer count the hours above each
    #[arg(
        long,
        value_name = "CELSIUS",
        value_delimiter = ',',
        allow_negative_numbers = true,
        default_value = "26,32,38,46"
    )]
    pub above: Vec<f64>,
    /// Posture of people
    #[arg(long, value_parser = choice::<Posture>(), default_value = "standing")]
    pub posture: Posture,
    /// Model of the direct sun on a person
    #[arg(long, value_parser = choice::<SunOnPerson>(), default_value = "cylinder")]
    pub sun_on: SunOnPerson,
    /// Temperature of the surfaces that --temperature does not state
    #[arg(long, value_parser = choice::<SurfaceTemperatures>(), default_value = "sol-air")]
    pub surfaces: SurfaceTemperatures,
    /// Heat transfer coefficient between surfaces and air, radiation included, W/m2K
    #[arg(long, value_name = "W/M2K", default_value_t = ComfortChoice::default().film_w_m2_k)]
    pub film: f64,
    /// Longwave emissivity of `ground` or `obstruction`; may be repeated [default: what their
    /// materials state, else ground=0.95, obstruction=0.9]
    #[arg(long, value_name = "CLASS=SHARE")]
    pub emissivity: Vec<ClassShare>,
    /// Share of sunlight that `ground` or `obstruction` surfaces absorb, for --surfaces sol-air;
    /// may be repeated [default: what their materials do not reflect]
    #[arg(long, value_name = "CLASS=SHARE")]
    pub absorptance: Vec<ClassShare>,
    /// Wind speed 10 m above the ground: a factor on that of the weather file, or a CSV as for
    /// --schedule with a column `wind_m_s`
    #[arg(long, value_name = "FACTOR|FILE", default_value = "1")]
    pub wind: WindChoice,
    #[command(flatten)]
    pub period: PeriodArgs,
    #[command(flatten)]
    pub sky: SkyArgs,
    #[command(flatten)]
    pub changes: ChangeArgs,
    #[command(flatten)]
    pub people: PeopleArgs,
    #[command(flatten)]
    pub accuracy: AccuracyArgs,
    /// Memory to work in, such as 512MiB or 2GiB
    #[arg(long, default_value = "4GiB", value_parser = parse_memory)]
    pub memory: Bytes,
    #[command(flatten)]
    pub about_weather: ClockArgs,
}

/// Positions of the people of a scene.
#[derive(Args, Debug)]
#[command(next_help_heading = "People of a scene")]
pub struct PeopleArgs {
    /// Positions of people, CSV with columns point,x,y and optionally z or height [default: on the
    /// ground, --spacing apart]
    #[arg(long, value_name = "FILE", conflicts_with_all = ["on", "spacing"])]
    pub points: Option<PathBuf>,
    /// Kinds of surfaces, or materials, that people stand on; several with commas
    #[arg(long, value_name = "KINDS", value_delimiter = ',', default_value = "ground")]
    pub on: Vec<String>,
    /// Distance between people, such as 2m
    #[arg(long, value_name = "LENGTH", default_value = "2m")]
    pub spacing: Metres,
    /// Height of the middle of a person above the ground
    #[arg(long, value_name = "LENGTH", default_value = "1.1m")]
    pub body_height: Metres,
    /// Folder to write: receivers.csv and site.helio, which a later call with the same inputs uses
    /// again [default: the name of the first scene file, with .people]
    #[arg(long, value_name = "FOLDER")]
    pub folder: Option<PathBuf>,
    /// Replace results in the folder that are of another scene, points or accuracy; without this
    /// option they are an error
    #[arg(long)]
    pub replace: bool,
}

impl ComfortArgs {
    /// Returns the archive or atlas of people, if one is named.
    pub fn place(&self) -> Option<&PathBuf> {
        let [only] = self.scene.scene.as_slice() else { return None };
        Site::is_at(only).then_some(only)
    }

    /// Refuses positions of people if an archive holds them already.
    pub fn check(&self) -> Result<()> {
        let PeopleArgs { points, folder, replace, .. } = &self.people;
        if self.place().is_some() && (points.is_some() || folder.is_some() || *replace) {
            let what = "apply to scene files only: an archive states where people stand";
            return Err(Error::argument(
                "points, folder, replace",
                what,
                "leave them out, or give the scene files in place of the archive",
            ));
        }
        Ok(())
    }

    /// Returns the tables that are read by row of the weather file.
    pub fn tables(&self) -> impl Iterator<Item = &Path> {
        let wind = match &self.wind {
            WindChoice::File(file) => Some(file.as_path()),
            WindChoice::Factor(_) => None,
        };
        self.period
            .temperature
            .iter()
            .filter_map(Temperature::file)
            .chain(self.changes.files())
            .chain(self.sky.files())
            .chain(wind)
    }

    /// Returns the request to build the archive of people.
    pub fn site(&self) -> ComfortSiteRequest {
        let scene = self.scene.request();
        let beside = || folder_beside(scene.first(), "people");
        let folder = self.people.folder.clone().unwrap_or_else(beside);
        ComfortSiteRequest {
            points: self.people.points.clone(),
            on: self.people.on.clone(),
            spacing_m: self.people.spacing.0,
            height_m: self.people.body_height.0,
            accuracy: self.accuracy.request_beside(Some(&self.weather), &self.about_weather),
            replace: self.people.replace,
            ..ComfortSiteRequest::of(scene, folder)
        }
    }

    /// Returns the request of `comfort`.
    pub fn request(&self) -> ComfortRequest {
        let changes = self.changes.changes(self.period.snow());
        let (sky, sky_files) = self.sky.parts();
        let light = LightChoice { sky, sky_files, changes, ..LightChoice::default() };
        let about_weather = self.about_weather.options(true);
        ComfortRequest {
            replay: ReplayRequest { light, about_weather, ..self.period.replay(&self.weather) },
            choice: ComfortChoice {
                columns: self.columns.clone(),
                above_c: self.above.clone(),
                posture: self.posture,
                sun_on: self.sun_on,
                surfaces: self.surfaces,
                film_w_m2_k: self.film,
                emissivity: self.emissivity.clone(),
                absorptance: self.absorptance.clone(),
                wind: self.wind.clone(),
            },
        }
    }

    /// Returns the output files.
    pub fn files(&self) -> FileRequest {
        FileRequest { geo: self.geo, plots: self.plot.clone(), ..FileRequest::of(&self.output) }
    }
}
