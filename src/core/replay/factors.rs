//! What surroundings reflect on a receiver as factors, over positions of the sun. In: an archive, a grid of suns. Out: the five
//! factors that EnergyPlus calls `ReflFac...`, for ground that reflects all.
//!
//! One diffuse reflection, the sun in mirrors, a uniform sky (EnergyPlus, Engineering Reference, "Solar Radiation Reflected from Exterior
//! Surfaces"). Irradiance = DNI x (BmToDiffSolObs + BmToBmSolObs) + DNI sin(altitude) x reflectance of the ground x BmToDiffSolGnd
//! + DHI x SkySolObs + DHI x reflectance of the ground x SkySolGnd.

use crate::error::Result;
use crate::light::paths::LightPaths;
use crate::light::states::Schedule;
use crate::opened::OpenSite;
use crate::replay::components::{Component, ComponentSet};
use crate::replay::run::{Replay, ReplaySettings};
use crate::site::material::Class;
use crate::sky::model::SkyModel;
use crate::units::direction_from_degrees;
use crate::weather::conditions::Condition;
use crate::weather::time::bins::Bins;

/// The lowest suns stand here: below, most of the disc is cut off by the horizon.
const LOWEST_ALTITUDE_DEG: f64 = 0.5;

/// DNI of a sun, DHI of a sky.
const SOURCE_W_M2: f64 = 1000.0;

/// Positions of the sun: all azimuths at all altitudes.
#[derive(Clone, Debug, PartialEq)]
pub struct SunGrid {
    /// From 0 to 360, both of them.
    pub azimuths_deg: Vec<f64>,
    /// From 0.5 to 90.
    pub altitudes_deg: Vec<f64>,
}

impl SunGrid {
    /// Of two steps in degrees: azimuths 0, step, ... 360; altitudes 0.5, step, 2 steps, ... 90. An error: a step that does not divide 360
    /// or 90, or is below 1.
    pub fn new(azimuth_step_deg: f64, altitude_step_deg: f64) -> std::result::Result<Self, String> {
        let count = |whole: f64, step: f64| {
            let count = (whole / step).round();
            let fits = step >= 1.0 && step <= whole && (count * step - whole).abs() < 1e-9;
            fits.then_some(count as usize)
                .ok_or_else(|| format!("{step} degrees do not divide {whole}, or are below 1"))
        };
        let (around, up) = (count(360.0, azimuth_step_deg)?, count(90.0, altitude_step_deg)?);
        let azimuth = |i: usize| 360.0 * i as f64 / around as f64;
        let altitude = |i: usize| if i == 0 { LOWEST_ALTITUDE_DEG } else { 90.0 * i as f64 / up as f64 };
        Ok(SunGrid {
            azimuths_deg: (0..=around).map(azimuth).collect(),
            altitudes_deg: (0..=up).map(altitude).collect(),
        })
    }

    /// Azimuth and altitude of all suns; altitudes change faster.
    pub fn suns(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.azimuths_deg.iter().flat_map(|azimuth| self.altitudes_deg.iter().map(|altitude| (*azimuth, *altitude)))
    }

    /// A condition for each sun, without sky.
    pub fn conditions(&self, dni_w_m2: f64) -> Vec<Condition> {
        let condition = |(azimuth, altitude): (f64, f64)| {
            let sun = direction_from_degrees(azimuth, altitude);
            Condition::new(format!("{azimuth},{altitude}"), &[sun], sun, dni_w_m2, 0.0)
        };
        self.suns().map(condition).collect()
    }
}

/// Names of the factors, in the order of [`Factors::of`].
pub const FACTORS: [&str; 5] =
    ["ReflFacBmToDiffSolObs", "ReflFacBmToDiffSolGnd", "ReflFacSkySolObs", "ReflFacSkySolGnd", "ReflFacBmToBmSolObs"];

/// What factors are made of.
pub const PARTS: [Component; 5] = [
    Component::SunDiffuseObstruction,
    Component::SunDiffuseGround,
    Component::SkyDiffuseObstruction,
    Component::SkyDiffuseGround,
    Component::SunSpecular,
];

/// Factors of an archive's receivers.
pub struct Factors<'a> {
    grid: SunGrid,
    replay: Replay<'a>,
}

impl<'a> Factors<'a> {
    /// Makes suns and a sky ready; `settings` say what memory it takes, their light is not looked at. Errors as of [`Replay::scheduled`].
    pub fn new(site: &OpenSite<'a>, grid: SunGrid, settings: ReplaySettings) -> Result<Self> {
        let mut conditions = grid.conditions(SOURCE_W_M2);
        let up = direction_from_degrees(0.0, 90.0);
        conditions.push(Condition::new("sky".into(), &[up], up, 0.0, SOURCE_W_M2));
        let all = |m: &usize| site.materials()[*m].class == Class::Ground && !site.is_canopy(*m as u16);
        let grounds: Vec<usize> = (0..site.materials().len()).filter(all).collect();
        let schedules = match grounds.is_empty() {
            true => Vec::new(),
            false => vec![Schedule { materials: grounds, values: vec![1.0; conditions.len()] }],
        };
        let components = ComponentSet::of(&PARTS);
        let settings = ReplaySettings { sky: SkyModel::Uniform, paths: LightPaths::FIRST, components, ..settings };
        let bins = Bins::each(conditions.len());
        Ok(Factors { replay: Replay::scheduled(site, &conditions, settings, &bins, &schedules)?, grid })
    }

    /// Positions of the sun.
    pub fn grid(&self) -> &SunGrid {
        &self.grid
    }

    /// Number of irradiances of a part: a label for each sun, and one for the sky.
    pub fn labels(&self) -> usize {
        self.grid.azimuths_deg.len() * self.grid.altitudes_deg.len() + 1
    }

    /// The irradiances that factors are made of, [`PARTS`], by [`Factors::labels`].
    pub fn irradiances(&self) -> &Replay<'a> {
        &self.replay
    }

    /// Factors of each sun, of the irradiances of a receiver, or of means over some: `row` gives those of a part by label.
    pub fn of<'r>(&'r self, row: impl Fn(Component) -> &'r [f32]) -> impl Iterator<Item = [f64; 5]> + 'r {
        let [obstruction, ground, sky_obstruction, sky_ground, mirrored] = PARTS.map(row);
        let share = |rows: &[f32], label: usize| rows.get(label).map_or(0.0, |v| f64::from(*v) / SOURCE_W_M2);
        let sky = self.labels() - 1;
        self.grid.suns().enumerate().map(move |(sun, (_, altitude))| {
            // Altitudes are above 0.
            let on_ground = share(ground, sun) / altitude.to_radians().sin();
            let by_sky = [sky_obstruction, sky_ground].map(|rows| share(rows, sky));
            [share(obstruction, sun), on_ground, by_sky[0], by_sky[1], share(mirrored, sun)]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps of 10 and 5 degrees are 37 x 19 = 703 suns from 0.5 degrees up, altitudes first; three steps that do not fit are refused.
    #[test]
    fn grids() {
        let grid = SunGrid::new(10.0, 5.0).expect("a grid");
        let suns: Vec<(f64, f64)> = grid.suns().collect();
        assert_eq!(
            (suns.len(), suns[0], suns[1], suns[19], suns[702]),
            (703, (0.0, 0.5), (0.0, 5.0), (10.0, 0.5), (360.0, 90.0))
        );
        assert!(grid.conditions(1.0).iter().all(|condition| condition.suns.len() == 1));
        for (azimuth, altitude) in [(7.0, 5.0), (10.0, 0.5), (f64::NAN, 5.0)] {
            assert!(SunGrid::new(azimuth, altitude).is_err());
        }
    }
}
