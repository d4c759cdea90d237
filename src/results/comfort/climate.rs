//! The climate of each hour, the same at all points. In: conditions with their air, what is known of surfaces. Out: what radiates on a person, and the
//! indices of the hour over the mean radiant temperature.

use std::path::Path;

use super::columns::ComfortColumn;
use super::request::{ComfortChoice, ComfortRequest, SurfaceTemperatures, WindChoice};
use crate::resources::Resources;
use rayon::prelude::*;

use heliotile_core::comfort::humidity::relative_humidity_percent;
use heliotile_core::comfort::index_curve::IndexCurve;
use heliotile_core::comfort::pet::{PetClimate, SEA_LEVEL_HPA, pet_c};
use heliotile_core::comfort::surroundings::{ClassSurfaces, HeatAround, SurfaceHeat};
use heliotile_core::comfort::utci::{UtciInput, utci_c};
use heliotile_core::comfort::wind::{WindProfile, wind_at_height_m_s};
use heliotile_core::error::{Error, Result};
use heliotile_core::site::material::{Class, Material};
use heliotile_core::weather::conditions::Condition;
use heliotile_core::weather::formats::schedule_csv::{Column, Rows, parse_schedule};

/// Winds of a schedule.
const WIND: Column = Column { name: "wind_m_s", low: 0.0, high: 60.0 };

/// What is the same at all points in an hour.
pub(super) struct HourClimate {
    /// Air temperature, degrees Celsius.
    pub air_c: f64,
    /// Wind at 10 m; 0 where no column asks for it.
    pub wind_m_s: f64,
    /// What radiates.
    pub surroundings: HeatAround,
    /// The UTCI, where it is asked for.
    pub utci: Option<IndexCurve>,
    /// The PET, where it is asked for.
    pub pet: Option<IndexCurve>,
    /// Length of the interval.
    pub hours: f64,
}

/// Finds the climates of conditions, which have their air.
pub(super) fn climates(
    request: &ComfortRequest,
    conditions: &[Condition],
    materials: &[Material],
    asked: &[ComfortColumn],
    resources: &Resources,
) -> Result<Vec<HourClimate>> {
    let winds = winds(request, conditions, resources)?;
    let classes = Class::ALL.map(|class| (class, absorptance(&request.choice, class, materials)));
    let of_hour = |(i, condition): (usize, &Condition)| {
        let hour = Hour { request, condition, file: &request.replay.weather };
        let wind = winds.as_ref().and_then(|winds| winds.get(i)).copied();
        hour.climate(classes, wind, asked)
    };
    conditions.par_iter().enumerate().map(of_hour).collect()
}

/// Winds of a file, one a condition.
fn winds(request: &ComfortRequest, conditions: &[Condition], resources: &Resources) -> Result<Option<Vec<f64>>> {
    let WindChoice::File(file) = &request.choice.wind else { return Ok(None) };
    let dates: Vec<_> = conditions.iter().filter_map(|condition| Some(condition.stamp?.date)).collect();
    parse_schedule(file, &(resources.files)(file)?, WIND, Rows::Dated(&dates)).map(Some)
}

/// What the surfaces of a class absorb of light: as asked for, else what its materials do not reflect in the mean.
pub(super) fn absorptance(choice: &ComfortChoice, class: Class, materials: &[Material]) -> f64 {
    let found = || {
        let of_class = materials.iter().filter(|material| material.class == class && material.transmittance.is_none());
        let absorbed: Vec<f64> = of_class.map(|material| 1.0 - material.diffuse - material.specular).collect();
        absorbed.iter().sum::<f64>() / absorbed.len() as f64
    };
    let share = choice.absorptance_of(class).unwrap_or_else(found);
    // A class without materials is not seen.
    if share.is_finite() { share.clamp(0.0, 1.0) } else { 1.0 }
}

/// An hour whose climate is looked for.
struct Hour<'h> {
    request: &'h ComfortRequest,
    condition: &'h Condition,
    file: &'h Path,
}

impl Hour<'_> {
    fn climate(&self, classes: [(Class, f64); 2], wind: Option<f64>, asked: &[ComfortColumn]) -> Result<HourClimate> {
        let Hour { request, condition, .. } = *self;
        let air = condition.air.unwrap_or_default();
        let air_c = air.dry_bulb_c.ok_or_else(|| self.missing("dry bulb temperature"))?;
        let emission = condition.emission.ok_or_else(|| self.missing("infrared radiation of the sky"))?;
        let surfaces = classes.map(|(class, absorbed)| {
            let is_given = request.replay.temperatures.iter().any(|given| given.class == class);
            let sent = match class {
                Class::Ground => emission.ground_w_m2,
                Class::Obstruction => emission.obstruction_w_m2,
            };
            let heat = match request.choice.surfaces {
                SurfaceTemperatures::SolAir if !is_given => SurfaceHeat::SolAir(absorbed),
                _ => SurfaceHeat::Given(sent),
            };
            ClassSurfaces { heat, emissivity: request.choice.emissivity_of(class) }
        });
        let [ground, obstruction] = surfaces;
        let (sky_w_m2, film_w_m2_k) = (emission.sky_w_m2, request.choice.film_w_m2_k);
        let surroundings = HeatAround { sky_w_m2, air_c, film_w_m2_k, ground, obstruction };
        let wants = |column| asked.contains(&column);
        let (wants_utci, wants_pet) = (wants(ComfortColumn::Utci), wants(ComfortColumn::Pet));
        let wind_m_s = match (&request.choice.wind, wind) {
            (_, Some(wind)) => wind,
            (WindChoice::Factor(factor), None) => match air.wind_m_s {
                Some(wind) => factor * wind,
                None if wants_utci || wants_pet || wants(ComfortColumn::Wind) => return Err(self.missing("wind speed")),
                None => 0.0,
            },
            (WindChoice::File(_), None) => return Err(self.missing("wind speed")),
        };
        let (mut utci, mut pet) = (None, None);
        if wants_utci || wants_pet {
            let dew_c = air.dew_point_c.ok_or_else(|| self.missing("humidity"))?;
            let humidity = relative_humidity_percent(air_c, dew_c).ok_or_else(|| self.missing("humidity"))?;
            let of_utci = |mean_radiant_c: f64| {
                let input = UtciInput {
                    air_temperature_c: air_c,
                    mean_radiant_temperature_c: mean_radiant_c,
                    wind_10m_m_s: wind_m_s,
                    relative_humidity_percent: humidity,
                };
                utci_c(&input.with_calm_raised())
            };
            let at_body = wind_at_height_m_s(wind_m_s, &WindProfile::default());
            let person = request.choice.person();
            let of_pet = |mean_radiant_c: f64| {
                let climate = PetClimate {
                    air_temperature_c: air_c,
                    mean_radiant_temperature_c: mean_radiant_c,
                    wind_m_s: at_body?,
                    relative_humidity_percent: humidity,
                    pressure_hpa: SEA_LEVEL_HPA,
                };
                pet_c(&climate, &person)
            };
            utci = wants_utci.then(|| IndexCurve::of(air_c, of_utci));
            pet = wants_pet.then(|| IndexCurve::of(air_c, of_pet));
        }
        let hours = condition.stamp.map_or(1.0, |stamp| stamp.hours);
        Ok(HourClimate { air_c, wind_m_s, surroundings, utci, pet, hours })
    }

    /// The error of an hour that lacks something.
    fn missing(&self, what: &str) -> Error {
        let what = format!("{what} is missing in the hour {}, which comfort depends on", self.condition.label);
        let hint = "fill the column in, leave such rows out with {from} and {to}, or ask for less, as with {columns} mrt; {wind} gives a wind";
        Error::input(self.file, None, what, hint)
    }
}
