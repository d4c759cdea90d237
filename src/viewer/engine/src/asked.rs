//! Queries of the page: light, a sky, changed reflectances, columns. In: JSON. Out: the core's
//! options. Equal queries have equal answers, so results for one tile serve the next.

use std::collections::BTreeMap;

use heliotile_core::error::{Error, Result};
use heliotile_core::replay::components::Component;
use heliotile_core::replay::reflectances::{self, ConstantOrFile};
use heliotile_core::sky::model::SkyModel;
use heliotile_core::weather::options::WeatherOptions;
use heliotile_requests::{Wrong, filled};
use serde::Deserialize;

use crate::weather::LoadedWeather;

/// Reflectances and transmittances, as `--reflectance` and `--transmittance` take them.
#[derive(Clone, Debug, Default, Deserialize, PartialEq)]
pub struct Changes {
    pub reflectance: Vec<(String, f64)>,
    pub transmittance: Vec<(String, f64)>,
}

impl Changes {
    /// Returns the changes as the core takes them, or an error if a value is not from 0 to 1.
    pub fn checked(&self) -> Result<reflectances::Changes> {
        for (option, values) in [("reflectance", &self.reflectance), ("transmittance", &self.transmittance)] {
            if let Some((name, value)) = values.iter().find(|(_, value)| !(0.0..=1.0).contains(value)) {
                let what = format!("`{name}` is {value}");
                return Err(Error::argument(option, what, "give a number from 0 to 1"));
            }
        }
        let through = |(name, value): &(String, f64)| (name.clone(), ConstantOrFile::Value(*value));
        Ok(reflectances::Changes {
            constant: self.reflectance.clone(),
            transmittance: self.transmittance.iter().map(through).collect(),
            ..reflectances::Changes::default()
        })
    }
}

/// Texts of the options of a weather file, by the names of the request's fields.
#[derive(Clone, Debug, Default, Deserialize)]
pub struct WeatherTexts(BTreeMap<String, String>);

impl WeatherTexts {
    /// Returns the options for the reader of the file.
    pub fn options(&self) -> Result<WeatherOptions> {
        let given: Vec<_> = self.0.iter().map(|(name, text)| (name.clone(), vec![text.clone()])).collect();
        filled(&given).map_err(Error::refused)
    }
}

/// Source of the light of a moment.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "camelCase", tag = "kind")]
pub enum Light {
    /// Row of the weather file.
    Weather { hour: usize },
    /// Sun by its azimuth from true north and its altitude above the horizon, degrees; DNI and DHI,
    /// W/m2.
    Sun { azimuth: f64, altitude: f64, dni: f64, dhi: f64 },
}

/// Source of the air of a moment.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "camelCase", tag = "kind")]
pub enum AirAsk {
    /// Row of the weather file.
    Weather { hour: usize },
    /// Temperature, degrees Celsius; humidity, percent; wind at 10 m, m/s; clouds, tenths of the
    /// sky.
    Own { temperature: f64, humidity: f64, wind: f64, cover: f64 },
}

impl AirAsk {
    /// Returns the name of the air in messages.
    pub fn label(self, weather: Option<&LoadedWeather>) -> String {
        let of_row = |hour: usize| Some(weather?.weather.rows.get(hour)?.interval.label());
        match self {
            AirAsk::Weather { hour } => of_row(hour).unwrap_or_default(),
            AirAsk::Own { .. } => "of these numbers".into(),
        }
    }
}

/// Part of the weather file that is summed.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "camelCase", rename_all_fields = "camelCase", tag = "kind")]
pub enum Span {
    Year,
    Month { month: u32 },
    Day { day_of_year: u32 },
}

/// Query for the irradiances of a moment.
#[derive(Clone, Debug, Deserialize, PartialEq)]
pub struct MomentAsk {
    pub light: Light,
    pub sky: String,
    pub changes: Changes,
    pub components: Vec<String>,
}

/// Query for sums over part of the weather file.
#[derive(Clone, Debug, Deserialize, PartialEq)]
pub struct SumAsk {
    pub span: Span,
    pub sky: String,
    pub changes: Changes,
    pub components: Vec<String>,
}

/// Query for the minutes of sun on a day.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "camelCase")]
pub struct MinutesAsk {
    pub day_of_year: u32,
    /// True for the sun in mirrors, false for the sun itself.
    pub in_mirrors: bool,
}

/// Returns columns by their names, in the order asked for, or an error for an unknown name.
pub fn columns(names: &[String]) -> Result<Vec<Component>> {
    let of = |name: &String| Component::ALL.into_iter().find(|component| component.name() == name);
    match names.iter().find(|name| of(name).is_none()) {
        Some(unknown) => {
            let known = Component::ALL.map(Component::name).join(", ");
            Err(Error::argument("components", format!("`{unknown}` is none"), format!("name some of {known}")))
        }
        None => Ok(names.iter().filter_map(of).collect()),
    }
}

/// Returns a sky model by the name that `--sky` takes.
pub fn sky_of(name: &str) -> Result<SkyModel> {
    name.parse().map_err(|wrong: Wrong| Error::refused(wrong.in_field("sky")))
}
