//! The climate of an hour, equal at all points. In: the air of the hour, a model. Out: the
//! radiating surroundings of a person, and the indices of the hour by mean radiant temperature.

use super::columns::ComfortColumn;
use super::model::{ComfortModel, SurfaceModel};
use crate::humidity::relative_humidity_percent;
use crate::index_curve::IndexCurve;
use crate::pet::{PetClimate, SEA_LEVEL_HPA, pet_c};
use crate::surroundings::{ClassSurfaces, HeatAround, SurfaceHeat};
use crate::utci::{UtciInput, utci_c};
use crate::wind::{WindProfile, wind_at_height_m_s};
use heliotile_core::weather::air::Air;
use heliotile_core::weather::emission::{Emission, black_body_w_m2};

/// Air and emission of an hour; unknown values are `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HourAir {
    /// Temperature and humidity of the air.
    pub air: Air,
    /// Longwave emission of the sky and the surfaces. Surfaces with sol-air temperatures do not use
    /// it.
    pub emission: Option<Emission>,
    /// Wind at 10 m, m/s.
    pub wind_m_s: Option<f64>,
    /// Length of the interval, hours.
    pub hours: f64,
}

/// Name of a value that an hour lacks and comfort depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MissingAir(pub &'static str);

/// Values of an hour that are equal at all points.
#[derive(Clone, Debug, PartialEq)]
pub struct HourClimate {
    /// Air temperature, degrees Celsius.
    pub air_c: f64,
    /// Wind at 10 m, m/s; 0 where the file has none and no column needs it.
    pub wind_m_s: f64,
    /// Longwave emission of sky and surfaces.
    pub surroundings: HeatAround,
    /// Curve of the UTCI, if a column needs it.
    pub utci: Option<IndexCurve>,
    /// Curve of the PET, if a column needs it.
    pub pet: Option<IndexCurve>,
    /// Length of the interval, hours.
    pub hours: f64,
}

/// Air of an hour that has all values that the columns need.
struct KnownAir {
    air_c: f64,
    emission: Emission,
    wind_m_s: f64,
    /// Relative humidity, percent, if a column is an index.
    humidity_percent: Option<f64>,
}

impl MissingAir {
    /// Returns the message on the value that the hour of this label lacks.
    pub fn in_hour(self, label: &str) -> String {
        format!("{} is missing in the hour {label}; comfort depends on it", self.0)
    }
}

impl HourAir {
    /// Returns air over surfaces that are as warm as it is, with its own wind.
    pub fn new(air: Air) -> Self {
        let emission = air.sky_w_m2().zip(air.dry_bulb_c).map(|(sky_w_m2, air_c)| {
            let surface_w_m2 = black_body_w_m2(air_c);
            Emission { sky_w_m2, ground_w_m2: surface_w_m2, obstruction_w_m2: surface_w_m2 }
        });
        HourAir { air, emission, wind_m_s: air.wind_m_s, hours: 1.0 }
    }

    /// Returns the relative humidity, percent, or `None` where it is not known.
    pub fn humidity_percent(&self) -> Option<f64> {
        relative_humidity_percent(self.air.dry_bulb_c?, self.air.dew_point_c?)
    }

    /// Checks that the hour has the values that the columns depend on.
    pub fn check(&self, asked: &[ComfortColumn]) -> Result<(), MissingAir> {
        self.known(asked).map(drop)
    }

    fn known(&self, asked: &[ComfortColumn]) -> Result<KnownAir, MissingAir> {
        let air_c = self.air.dry_bulb_c.ok_or(MissingAir("dry bulb temperature"))?;
        let emission = self.emission.ok_or(MissingAir("infrared radiation of the sky"))?;
        let wants_index = asked.iter().any(|column| column.is_index());
        let wind_m_s = match self.wind_m_s {
            Some(wind_m_s) => wind_m_s,
            None if wants_index || asked.contains(&ComfortColumn::Wind) => return Err(MissingAir("wind speed")),
            None => 0.0,
        };
        let humidity = || self.humidity_percent().ok_or(MissingAir("humidity"));
        let humidity_percent = wants_index.then(humidity).transpose()?;
        Ok(KnownAir { air_c, emission, wind_m_s, humidity_percent })
    }

    /// Returns the climate of the hour, with the indices that the columns need. The error names the
    /// first missing value.
    pub fn climate(&self, model: &ComfortModel, asked: &[ComfortColumn]) -> Result<HourClimate, MissingAir> {
        let KnownAir { air_c, emission, wind_m_s, humidity_percent } = self.known(asked)?;
        let surfaces = |of: &SurfaceModel, sent_w_m2: f64| ClassSurfaces {
            heat: of.sol_air.map_or(SurfaceHeat::Given(sent_w_m2), SurfaceHeat::SolAir),
            emissivity: of.emissivity,
        };
        let surroundings = HeatAround {
            sky_w_m2: emission.sky_w_m2,
            air_c,
            film_w_m2_k: model.film_w_m2_k,
            ground: surfaces(&model.ground, emission.ground_w_m2),
            obstruction: surfaces(&model.obstruction, emission.obstruction_w_m2),
        };
        let of = |column, index: &dyn Fn(f64, f64) -> Option<f64>| {
            let humidity_percent = humidity_percent.filter(|_| asked.contains(&column))?;
            Some(IndexCurve::new(air_c, |mean_radiant_c| index(mean_radiant_c, humidity_percent)))
        };
        let utci = of(ComfortColumn::Utci, &|mean_radiant_temperature_c, relative_humidity_percent| {
            let input = UtciInput {
                air_temperature_c: air_c,
                mean_radiant_temperature_c,
                wind_10m_m_s: wind_m_s,
                relative_humidity_percent,
            };
            utci_c(&input.with_calm_raised())
        });
        let at_body = wind_at_height_m_s(wind_m_s, &WindProfile::default());
        let pet = of(ComfortColumn::Pet, &|mean_radiant_temperature_c, relative_humidity_percent| {
            let climate = PetClimate {
                air_temperature_c: air_c,
                mean_radiant_temperature_c,
                wind_m_s: at_body?,
                relative_humidity_percent,
                pressure_hpa: SEA_LEVEL_HPA,
            };
            pet_c(&climate, &model.person)
        });
        Ok(HourClimate { air_c, wind_m_s, surroundings, utci, pet, hours: self.hours })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Air without a temperature, sky, wind or humidity is refused by the name of that value where
    /// a column depends on it. The mean radiant temperature needs neither wind nor humidity.
    #[test]
    fn missing_air_is_refused_by_its_name() {
        let air = Air {
            dry_bulb_c: Some(25.0),
            dew_point_c: Some(13.0),
            infrared_w_m2: Some(350.0),
            wind_m_s: Some(1.0),
            ..Air::default()
        };
        let lacks = |air: Air, asked| HourAir::new(air).check(&[asked]).err().map(|missing| missing.in_hour("h"));
        let (mrt, utci) = (ComfortColumn::MeanRadiant, ComfortColumn::Utci);
        assert_eq!(lacks(air, utci), None);
        for (air, word) in [
            (Air { dry_bulb_c: None, ..air }, "dry bulb"),
            (Air { infrared_w_m2: None, ..air }, "infrared"),
            (Air { dew_point_c: None, ..air }, "humidity"),
            (Air { wind_m_s: None, ..air }, "wind speed"),
        ] {
            assert!(lacks(air, utci).is_some_and(|what| what.starts_with(word)), "{word}");
        }
        assert_eq!(lacks(Air { dew_point_c: None, wind_m_s: None, ..air }, mrt), None);
    }

    /// A climate for one index holds the curve of that index only, and the curve gives the index of
    /// its air at a mean radiant temperature within 0.01 K.
    #[test]
    fn a_climate_holds_curves_of_requested_indices_only() {
        let air = Air {
            dry_bulb_c: Some(25.0),
            dew_point_c: Some(13.0),
            infrared_w_m2: Some(350.0),
            wind_m_s: Some(2.0),
            ..Air::default()
        };
        let climate = HourAir::new(air).climate(&ComfortModel::usual(&[]), &[ComfortColumn::Utci]).expect("all there");
        assert!(climate.pet.is_none());
        let expected = utci_c(&UtciInput {
            air_temperature_c: 25.0,
            mean_radiant_temperature_c: 41.3,
            wind_10m_m_s: 2.0,
            relative_humidity_percent: relative_humidity_percent(25.0, 13.0).expect("in range"),
        });
        let found = climate.utci.and_then(|curve| curve.at(41.3));
        assert!(found.zip(expected).is_some_and(|(found, expected)| (found - expected).abs() < 0.01));
    }
}
