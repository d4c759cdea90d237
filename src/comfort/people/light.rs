//! The radiation at a point. In: irradiance of its six planes in each hour, their view factors,
//! climates. Out: the values of the point in each hour.

use super::climate::HourClimate;
use super::columns::ComfortColumn;
use super::model::{ComfortModel, SunOnPerson};
use crate::index_curve::IndexCurve;
use crate::mean_radiant::{
    DirectSun, RadiationField, mean_radiant_temperature_c, mean_radiant_temperature_of_cylinder_c,
};
use crate::surroundings::{SixPlanes, ViewShares};

/// Values of a point in all hours.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PersonNumbers {
    /// `[number][hour]`; NaN where there is no value.
    pub values: Vec<Vec<f32>>,
    /// Hours that are too hot for an index to have a value.
    pub beyond: Vec<BeyondIndex>,
}

/// An hour whose mean radiant temperature lies above the range of an index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeyondIndex {
    /// The index.
    pub column: ComfortColumn,
    /// Place of the index among the numbers.
    pub number: usize,
    /// The hour.
    pub hour: usize,
    /// Lower bound of the index, degrees Celsius.
    pub least_c: f64,
}

impl PersonNumbers {
    /// Sets the values that are missing for heat to their lower bounds.
    pub fn bound(&mut self) {
        for beyond in &self.beyond {
            let value = self.values.get_mut(beyond.number).and_then(|values| values.get_mut(beyond.hour));
            if let Some(value) = value {
                *value = beyond.least_c as f32;
            }
        }
    }
}

/// Shortwave irradiance of a point, `[plane][hour]`, W/m2.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PersonLight {
    total: [Vec<f32>; 6],
    direct: [Vec<f32>; 6],
}

impl PersonLight {
    /// Stores the irradiance of a plane in all hours, and the part of it that comes directly from
    /// the sun.
    pub fn put(&mut self, plane: usize, total: &[f32], direct: &[f32]) {
        for (to, from) in [(&mut self.total, total), (&mut self.direct, direct)] {
            if let Some(to) = to.get_mut(plane) {
                *to = from.to_vec();
            }
        }
    }

    /// Returns the values of all hours, in the order of `asked`.
    pub fn numbers(
        &self,
        views: &SixPlanes<ViewShares>,
        climates: &[HourClimate],
        asked: &[ComfortColumn],
        model: &ComfortModel,
    ) -> PersonNumbers {
        let count = asked.iter().map(|column| column.width()).sum();
        let mut numbers = vec![Vec::with_capacity(climates.len()); count];
        let mut beyond = Vec::new();
        for (hour, climate) in climates.iter().enumerate() {
            let shortwave = at_hour(&self.total, hour);
            let longwave = climate.surroundings.longwave(views, &shortwave);
            let field = RadiationField { shortwave: shortwave.into(), longwave: longwave.into() };
            let mean_radiant_c = match model.sun {
                SunOnPerson::Box => mean_radiant_temperature_c(&field, &model.body),
                SunOnPerson::Cylinder => {
                    let direct = at_hour(&self.direct, hour);
                    // The cylinder takes direct sun by its altitude, so the planes keep the rest
                    // only.
                    let diffuse = shortwave.less(&direct).into();
                    let field = RadiationField { shortwave: diffuse, ..field };
                    mean_radiant_temperature_of_cylinder_c(&field, &sun_of(&direct), &model.body)
                }
            };
            let index = |curve: &Option<IndexCurve>| curve.as_ref()?.at(mean_radiant_c?);
            let mut number = 0;
            for column in asked {
                let curve = match column {
                    ComfortColumn::Utci => &climate.utci,
                    ComfortColumn::Pet => &climate.pet,
                    _ => &None,
                };
                let bound = curve.as_ref().zip(mean_radiant_c).and_then(|(curve, c)| curve.least_beyond(c));
                beyond.extend(bound.map(|least_c| BeyondIndex { column: *column, number, hour, least_c }));
                number += column.width();
            }
            let mut to = numbers.iter_mut();
            let mut push = |value: Option<f64>| {
                if let Some(to) = to.next() {
                    to.push(value.map_or(f32::NAN, |value| value as f32));
                }
            };
            for column in asked {
                match column {
                    ComfortColumn::Air => push(Some(climate.air_c)),
                    ComfortColumn::Wind => push(Some(climate.wind_m_s)),
                    ComfortColumn::MeanRadiant => push(mean_radiant_c),
                    ComfortColumn::Utci => push(index(&climate.utci)),
                    ComfortColumn::Pet => push(index(&climate.pet)),
                    ComfortColumn::Shortwave => shortwave.each(|value| push(Some(value))),
                    ComfortColumn::Longwave => longwave.each(|value| push(Some(value))),
                }
            }
        }
        PersonNumbers { values: numbers, beyond }
    }
}

fn at_hour(planes: &[Vec<f32>; 6], hour: usize) -> SixPlanes<f64> {
    let [up, down, north, east, south, west] =
        planes.each_ref().map(|plane| plane.get(hour).copied().map_or(0.0, f64::from));
    SixPlanes { up, down, sides: [north, east, south, west] }
}

/// Returns the sun that gives this direct irradiance. Of two opposite planes only one faces the
/// sun, so the differences of opposite planes are the vector of the beam.
fn sun_of(direct: &SixPlanes<f64>) -> DirectSun {
    let [north, east, south, west] = direct.sides;
    // Half of all hours are dark.
    if direct.up == 0.0 && direct.down == 0.0 && direct.sides == [0.0; 4] {
        return DirectSun { beam_normal_w_m2: 0.0, altitude_deg: 0.0 };
    }
    let (up, horizontal) = (direct.up - direct.down, (north - south).hypot(east - west));
    DirectSun { beam_normal_w_m2: up.hypot(horizontal), altitude_deg: up.atan2(horizontal).to_degrees() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A beam of 800 W/m2 from azimuth 120 at 35 degrees is found from the irradiance of the six
    /// planes.
    #[test]
    fn a_beam_is_found_from_six_planes() {
        let (azimuth, altitude) = (120.0_f64.to_radians(), 35.0_f64.to_radians());
        let (east, north) = (azimuth.sin() * altitude.cos(), azimuth.cos() * altitude.cos());
        let on = |cos: f64| 800.0 * cos.max(0.0);
        let sides = [on(north), on(east), on(-north), on(-east)];
        let sun = sun_of(&SixPlanes { up: on(altitude.sin()), down: 0.0, sides });
        assert!((sun.beam_normal_w_m2 - 800.0).abs() < 1e-9 && (sun.altitude_deg - 35.0).abs() < 1e-9, "{sun:?}");
    }
}
