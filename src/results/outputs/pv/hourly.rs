//! Hourly irradiance in pvlib's names. In: light on one side of a point or on both, hour by hour.
//! Out: a table of any format, point after point.
//!
//! One side has the columns of pvlib's `get_total_irradiance`. Two sides have those of
//! `pvlib.bifacial.infinite_sheds.get_irradiance`, whose `poa_global` is the front plus the rear
//! times the bifaciality.

use std::path::Path;

use super::sums::PARTS;
use crate::outputs::provenance::Provenance;
use crate::outputs::tables::batch::{Batch, Values};
use crate::outputs::tables::bin_labels::BinLabels;
use crate::outputs::tables::column::{Column, Digits, Kind, TableColumns};
use crate::outputs::tables::table::Table;
use crate::outputs::tables::writer::Places;
use heliotile_core::error::Result;
use heliotile_core::replay::components::Component;

/// Columns of points with one side.
pub const ONE_SIDE: [&str; 5] = ["poa_global", "poa_direct", "poa_diffuse", "poa_sky_diffuse", "poa_ground_diffuse"];

/// Columns of modules with a rear side.
pub const TWO_SIDES: [&str; 11] = [
    "poa_global",
    "poa_front",
    "poa_front_direct",
    "poa_front_diffuse",
    "poa_front_sky_diffuse",
    "poa_front_ground_diffuse",
    "poa_back",
    "poa_back_direct",
    "poa_back_diffuse",
    "poa_back_sky_diffuse",
    "poa_back_ground_diffuse",
];

/// Column of the angle of trackers, degrees: the mean while the sun is up, else 0.
pub const ANGLE: &str = "tracker_theta";

/// Unit of light.
const UNIT: &str = "W/m2";

/// Light on one side, `[part][hour]`, W/m2, in the order of [`PARTS`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SideHours(pub [Vec<f32>; PARTS.len()]);

impl SideHours {
    /// Returns the light of irradiances by component, `[hour]`, W/m2.
    pub fn new<'v>(component: impl Fn(Component) -> &'v [f32]) -> Self {
        SideHours(PARTS.map(|part| component(part).to_vec()))
    }

    /// Adds the light of another side times the share of each hour.
    pub fn add(&mut self, other: &SideHours, shares: impl Iterator<Item = f32> + Clone) {
        for (sum, more) in self.0.iter_mut().zip(&other.0) {
            sum.resize(more.len().max(sum.len()), 0.0);
            sum.iter_mut().zip(more).zip(shares.clone()).for_each(|((sum, value), share)| *sum += share * value);
        }
    }

    /// Returns the direct light of the sun in an hour, and all other light, W/m2.
    pub fn sun_and_rest(&self, hour: usize) -> [f64; 2] {
        let [sun, rest @ ..] = self.0.each_ref().map(|part| part.get(hour).copied().map_or(0.0, f64::from));
        [sun, rest.iter().sum()]
    }

    /// Returns the direct light of the sun and all other light, `[hour]`, W/m2.
    pub fn suns_and_rests(&self) -> Vec<[f32; 2]> {
        let hours = 0..self.0.first().map_or(0, Vec::len);
        hours.map(|hour| self.sun_and_rest(hour).map(|light| light as f32)).collect()
    }

    /// Returns total, direct, diffuse, and the two parts of diffuse: the sky, direct and by
    /// mirrors, and what ground and surroundings reflect diffusely.
    fn columns(&self) -> [Vec<f32>; 5] {
        let both = |a: &[f32], b: &[f32]| -> Vec<f32> { a.iter().zip(b).map(|(a, b)| a + b).collect() };
        let [sun, sky, sun_reflected, sky_reflected, sun_mirrored, sky_mirrored] = &self.0;
        let (direct, sky) = (both(sun, sun_mirrored), both(sky, sky_mirrored));
        let reflected = both(sun_reflected, sky_reflected);
        let diffuse = both(&sky, &reflected);
        [both(&direct, &diffuse), direct, diffuse, sky, reflected]
    }

    /// Returns the columns of a point with one side, in the order of [`ONE_SIDE`].
    pub fn one_side(&self) -> Vec<Vec<f32>> {
        self.columns().into()
    }

    /// Returns the columns of a module with a rear side, in the order of `TWO_SIDES`.
    pub fn with_rear(&self, rear: &SideHours, bifaciality: f32) -> Vec<Vec<f32>> {
        let (front, back) = (self.columns(), rear.columns());
        let global = front[0].iter().zip(&back[0]).map(|(front, back)| front + bifaciality * back).collect();
        std::iter::once(global).chain(front).chain(back).collect()
    }
}

/// Table of hours being written.
pub struct HourlyTable {
    table: Table,
}

impl HourlyTable {
    /// Starts a table of `points` points, in the format given by the ending of the path.
    pub fn create(path: &Path, columns: &[&str], labels: &BinLabels, points: u64, about: &Provenance) -> Result<Self> {
        let mut all = vec![Column::of_bins("time", Kind::Text, labels), Column::of_places("point", Kind::Text)];
        let unit = |name: &str| if name == ANGLE { "degree" } else { UNIT };
        all.extend(columns.iter().map(|name| Column::float(*name, Digits::Decimals(3)).with_unit(unit(name))));
        let table = Table::create(path, TableColumns::new(all), Places::counted(points), Some(about))?;
        Ok(HourlyTable { table })
    }

    /// Writes all hours of a point: `[column][hour]`.
    pub fn write(&mut self, point: &str, columns: &[Vec<f32>]) -> Result<()> {
        let names = Values::Texts(vec![point.to_owned()].into());
        let columns = columns.iter().map(|column| Values::Floats(column.into()));
        self.table.write(&Batch { places: 1, values: std::iter::once(names).chain(columns).collect() })
    }

    /// Completes the table; its file appears only now.
    pub fn finish(self) -> Result<()> {
        self.table.finish().map(drop)
    }
}
