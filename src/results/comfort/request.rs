//! Request for the thermal comfort of people. In: the choices of a user. Out: these choices as one
//! value that was checked.

use std::fmt;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::files::OutputRequest;
use crate::outputs::periods::Every;
use crate::request::ReplayRequest;
use heliotile_comfort::mean_radiant::RadiantBody;
use heliotile_comfort::people::columns::ComfortColumn;
use heliotile_comfort::people::model::{ComfortModel, SunOnPerson, SurfaceModel};
use heliotile_comfort::pet::{PetPerson, PetPosture};
use heliotile_comfort::surroundings::{MIN_FILM_W_M2_K, SeenSurfaces, SurfaceMean, USUAL_FILM_W_M2_K};
use heliotile_core::error::{Error, Problem, Result, check_ranges};
use heliotile_core::named::NamedValues;
use heliotile_core::replay::components::{Component, ComponentSet};
use heliotile_core::site::material::{Class, Material, rounded};
use heliotile_requests::{DefaultRequest, Parse, Request};

/// Allowed heat transfer coefficients of surfaces, W/m2K.
const FILMS_W_M2_K: RangeInclusive<f64> = MIN_FILM_W_M2_K..=200.0;

/// Largest factor of wind.
const MAX_WIND_FACTOR: f64 = 3.0;

/// Request for the thermal comfort of people through a weather file.
#[derive(Clone, Debug, Request, Default)]
pub struct ComfortRequest {
    /// Weather, hours that count, period of a row, temperatures of surfaces, changed reflectances.
    /// Columns in it are ignored.
    #[field(flatten, without("columns", "bands", "patches", "bounces", "paths"))]
    pub replay: ReplayRequest,
    /// Properties of people, surfaces and wind.
    #[field(flatten)]
    pub choice: ComfortChoice,
}

/// Properties of people, surfaces and wind.
#[derive(Clone, Debug, Request, DefaultRequest)]
pub struct ComfortChoice {
    /// Columns to write, in this order: some of mrt, utci, pet, air, wind, shortwave and longwave
    /// (six planes each) [default: mrt,utci,pet].
    #[field(metavar = "NAMES", delimiter = ',')]
    pub columns: Vec<ComfortColumn>,
    /// Limits of the UTCI, degrees Celsius: rows of days and longer count the hours above each.
    #[field(metavar = "CELSIUS", delimiter = ',', default = "26,32,38,46", range = -100.0..=100.0, says = "give degrees Celsius, as 26,32,38")]
    pub above_c: Vec<f64>,
    /// Posture of people.
    #[field(default = "standing")]
    pub posture: Posture,
    /// Model of the direct sun on a person.
    #[field(default = "cylinder")]
    pub sun_on: SunOnPerson,
    /// Temperature of the surfaces that --temperature does not state.
    #[field(default = "sol-air")]
    pub surfaces: SurfaceTemperatures,
    /// Heat transfer coefficient between surfaces and air, radiation included, W/m2K.
    #[field(name = "film", metavar = "W/M2K", default = USUAL_FILM_W_M2_K, range = FILMS_W_M2_K, says = "give 10 to 200 W/m2K, usually 10 in calm air and 25 in wind; it includes the radiation of surfaces")]
    pub film_w_m2_k: f64,
    /// Longwave emissivity of `ground` or `obstruction`; may be repeated [default: what their
    /// materials state, else ground=0.95, obstruction=0.9].
    #[field(metavar = "CLASS=SHARE")]
    pub emissivity: Vec<ClassShare>,
    /// Share of sunlight that `ground` or `obstruction` surfaces absorb, for --surfaces sol-air;
    /// may be repeated [default: what their materials do not reflect].
    #[field(metavar = "CLASS=SHARE")]
    pub absorptance: Vec<ClassShare>,
    /// Wind speed 10 m above the ground: a factor on that of the weather file, or a CSV as for
    /// --schedule with a column `wind_m_s`.
    #[field(metavar = "FACTOR|FILE", default = "1", input = Any)]
    pub wind: WindChoice,
}

/// Posture of a person.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Posture {
    /// Upright posture.
    #[default]
    Standing,
    /// Posture on a chair.
    Sitting,
}

/// Model of the temperatures of surfaces for which none is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SurfaceTemperatures {
    /// Sol-air temperature: light, sky and air act on a surface without heat storage.
    #[default]
    SolAir,
    /// Temperature of the air.
    Air,
}

/// Share for a class of surfaces, written as in `ground=0.95`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClassShare {
    /// Class of surfaces that has this share.
    pub class: Class,
    /// Share from 0 to 1.
    pub share: f64,
}

/// Source of the wind, written as `0.7` or as the name of a file.
#[derive(Clone, Debug, PartialEq)]
pub enum WindChoice {
    /// Wind of the weather file, times a factor.
    Factor(f64),
    /// Wind of a CSV with a column `wind_m_s`, 10 m above the ground.
    File(PathBuf),
}

impl Default for WindChoice {
    fn default() -> Self {
        WindChoice::Factor(1.0)
    }
}

impl FromStr for WindChoice {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text.parse::<f64>() {
            Ok(factor) if (0.0..=MAX_WIND_FACTOR).contains(&factor) => Ok(WindChoice::Factor(factor)),
            Ok(_) => Err(format!("the wind factor {text} is not from 0 to {MAX_WIND_FACTOR}")),
            Err(_) if text.is_empty() => Err("give a factor, as 0.7, or a CSV with a column `wind_m_s`".into()),
            Err(_) => Ok(WindChoice::File(text.into())),
        }
    }
}

impl FromStr for ClassShare {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let (name, value) = text.split_once('=').unwrap_or((text, ""));
        let class = Class::of_name(name).ok_or_else(|| {
            format!("`{name}` is not a class of surfaces: give `ground` or `obstruction`, as in ground=0.95")
        })?;
        let share = value.parse::<f64>().ok().filter(|share| (0.0..=1.0).contains(share));
        share.map(|share| ClassShare { class, share }).ok_or_else(|| format!("`{value}` is not a number from 0 to 1"))
    }
}

impl fmt::Display for WindChoice {
    fn fmt(&self, to: &mut fmt::Formatter) -> fmt::Result {
        match self {
            WindChoice::Factor(factor) => write!(to, "{factor}"),
            WindChoice::File(file) => write!(to, "{}", file.display()),
        }
    }
}

impl fmt::Display for ClassShare {
    fn fmt(&self, to: &mut fmt::Formatter) -> fmt::Result {
        write!(to, "{}={}", self.class.name(), self.share)
    }
}

impl ComfortRequest {
    /// Returns a request with default choices for people under a weather file: a row for each of
    /// its hours.
    pub fn new(weather: impl Into<PathBuf>) -> Self {
        ComfortRequest { replay: ReplayRequest::new(weather), choice: ComfortChoice::default() }
    }

    /// Refuses numbers out of range and files that cannot hold such results, before an archive is
    /// opened.
    pub fn check(&self, files: &OutputRequest, inputs: &[&Path]) -> Result<()> {
        self.stream().check()?;
        check_ranges(&self.choice)?;
        if files.model.is_some() || files.honeybee.is_some() {
            return Err(Error::argument(
                "model, honeybee",
                "hold irradiance only",
                "write a table or a map of comfort",
            ));
        }
        if let Some(chart) =
            files.plots.iter().find(|plot| !plot.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")))
        {
            let what = format!("`{}` does not end with .png, and comfort is drawn only as a map", chart.display());
            return Err(Error::argument("plot", what, "give a name that ends with .png").because(Problem::Ending));
        }
        files.check(None, None, inputs)
    }

    /// Returns the files that are read besides archives.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.replay.files().chain(self.choice.wind.path())
    }

    /// Returns the replay that gives the light of each hour, with the air.
    pub fn stream(&self) -> ReplayRequest {
        // The longwave column makes the replay read the air.
        let columns = "sun_direct,total,longwave".parse();
        let light = columns.map_or_else(|_| self.replay.light.clone(), |columns| self.replay.light.only(columns));
        ReplayRequest { light, every: Every::Hour, ..self.replay.clone() }
    }

    /// Returns the model of people and of surfaces among these materials. Surfaces of given
    /// temperature need no sol-air model.
    pub(super) fn model(&self, materials: &[Material]) -> ComfortModel {
        let choice = &self.choice;
        let surfaces = |class| {
            let is_given = self.replay.temperatures.iter().any(|given| given.class == class);
            let is_sol_air = choice.surfaces == SurfaceTemperatures::SolAir && !is_given;
            let SurfaceMean { emissivity, absorptance } =
                choice.over_mean(class, SurfaceMean::of_class(class, materials));
            SurfaceModel { emissivity, sol_air: is_sol_air.then_some(absorptance) }
        };
        ComfortModel {
            body: choice.body(),
            person: choice.person(),
            sun: choice.sun_on,
            film_w_m2_k: choice.film_w_m2_k,
            ground: surfaces(Class::Ground),
            obstruction: surfaces(Class::Obstruction),
        }
    }

    /// Returns the components of a replay that comfort needs.
    pub(super) fn components(&self) -> ComponentSet {
        ComponentSet::new(&[Component::SunDirect, Component::Total])
    }
}

impl ComfortChoice {
    /// Returns the body that absorbs radiation.
    pub(super) fn body(&self) -> RadiantBody {
        match self.posture {
            Posture::Standing => RadiantBody::STANDING,
            Posture::Sitting => RadiantBody::SITTING,
        }
    }

    /// Returns the person of the PET.
    pub(super) fn person(&self) -> PetPerson {
        let posture = match self.posture {
            Posture::Standing => PetPosture::Standing,
            Posture::Sitting => PetPosture::Sitting,
        };
        PetPerson { posture, ..PetPerson::VDI_3787 }
    }

    /// Returns the surfaces that a plane sees; requested emissivities and absorptances replace
    /// those of the materials.
    pub(super) fn over(&self, seen: SeenSurfaces) -> SeenSurfaces {
        let over = |class, mean: Option<SurfaceMean>| mean.map(|mean| self.over_mean(class, mean));
        SeenSurfaces {
            ground: over(Class::Ground, seen.ground),
            obstruction: over(Class::Obstruction, seen.obstruction),
        }
    }

    fn over_mean(&self, class: Class, mean: SurfaceMean) -> SurfaceMean {
        SurfaceMean {
            emissivity: last_of(&self.emissivity, class).unwrap_or(mean.emissivity),
            absorptance: last_of(&self.absorptance, class).unwrap_or(mean.absorptance),
        }
    }

    /// Returns the emissivity or absorptance of the surfaces of a class in words: one number, or
    /// the lowest and the highest of its materials.
    pub(super) fn said_of(&self, class: Class, materials: &[Material], of: fn(&SurfaceMean) -> f64) -> String {
        let mut values: Vec<f64> =
            SurfaceMean::of_solids(class, materials).map(|mean| of(&self.over_mean(class, mean))).collect();
        values.sort_by(f64::total_cmp);
        let whole = of(&self.over_mean(class, SurfaceMean::of_class(class, materials)));
        match (values.first(), values.last()) {
            (Some(low), Some(high)) if low < high => format!("{} to {} by material", rounded(*low), rounded(*high)),
            _ => rounded(whole).to_string(),
        }
    }
}

fn last_of(shares: &[ClassShare], class: Class) -> Option<f64> {
    shares.iter().rev().find(|share| share.class == class).map(|share| share.share)
}

impl NamedValues for Posture {
    const VALUES: &'static [(&'static str, &'static str, Self)] =
        &[("standing", "Upright", Posture::Standing), ("sitting", "On a chair", Posture::Sitting)];
}

impl NamedValues for SurfaceTemperatures {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("sol-air", "In balance with light, sky and air, without storage of heat", SurfaceTemperatures::SolAir),
        ("air", "As warm as the air", SurfaceTemperatures::Air),
    ];
}

heliotile_core::serde_by_name!(Posture, SurfaceTemperatures);

heliotile_core::parse_by_name!(Posture, SurfaceTemperatures);

heliotile_requests::parse_by_text!(ClassShare: heliotile_requests::Form::TEXT);

impl Parse for WindChoice {
    fn parse(text: &str) -> std::result::Result<Self, heliotile_requests::Wrong> {
        Ok(text.parse::<Self>()?)
    }

    fn path(&self) -> Option<&Path> {
        if let WindChoice::File(file) = self { Some(file) } else { None }
    }
}

heliotile_core::serde_by_text!(ClassShare, WindChoice);
