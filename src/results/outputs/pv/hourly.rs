//! Hourly irradiance in pvlib's names. In: light on one side of a point or on both, hour by hour.
//! Out: a table of any format, point after point.
//!
//! One side has the columns of pvlib's `get_total_irradiance`. Two sides have those of
//! `pvlib.bifacial.infinite_sheds.get_irradiance`, whose `poa_global` is the front plus the rear
//! times the bifaciality.

use std::path::Path;

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

/// Unit of all columns.
const UNIT: &str = "W/m2";

/// Light on one side, `[hour]`, W/m2.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SideHours {
    /// Light of the sun, direct.
    pub sun: Vec<f32>,
    /// Light of the sun by mirrors.
    pub mirrored: Vec<f32>,
    /// Light of the sky, direct and by mirrors.
    pub sky: Vec<f32>,
    /// Light that ground and surroundings reflect diffusely.
    pub reflected: Vec<f32>,
}

impl SideHours {
    /// Returns the light of irradiances by component, `[hour]`, W/m2.
    pub fn new<'v>(component: impl Fn(Component) -> &'v [f32]) -> Self {
        let both = |a: Component, b: Component| component(a).iter().zip(component(b)).map(|(a, b)| a + b).collect();
        SideHours {
            sun: component(Component::SunDirect).to_vec(),
            mirrored: component(Component::SunMirrored).to_vec(),
            sky: both(Component::SkyDirect, Component::SkyMirrored),
            reflected: both(Component::SunReflected, Component::SkyReflected),
        }
    }

    /// Adds `share` times the light of another side, hour by hour.
    pub fn add(&mut self, other: &SideHours, share: f32) {
        let pairs = [(&mut self.sun, &other.sun), (&mut self.mirrored, &other.mirrored)];
        let more = [(&mut self.sky, &other.sky), (&mut self.reflected, &other.reflected)];
        for (sum, more) in pairs.into_iter().chain(more) {
            sum.resize(more.len().max(sum.len()), 0.0);
            sum.iter_mut().zip(more).for_each(|(sum, value)| *sum += share * value);
        }
    }

    /// Returns the direct light of the sun in an hour, and all other light, W/m2.
    pub fn sun_and_rest(&self, hour: usize) -> [f64; 2] {
        let at = |values: &[f32]| values.get(hour).copied().map_or(0.0, f64::from);
        [at(&self.sun), at(&self.mirrored) + at(&self.sky) + at(&self.reflected)]
    }

    /// Returns total, direct, diffuse, and the two parts of diffuse.
    fn columns(&self) -> [Vec<f32>; 5] {
        let direct: Vec<f32> = self.sun.iter().zip(&self.mirrored).map(|(a, b)| a + b).collect();
        let diffuse: Vec<f32> = self.sky.iter().zip(&self.reflected).map(|(a, b)| a + b).collect();
        let global = direct.iter().zip(&diffuse).map(|(a, b)| a + b).collect();
        [global, direct, diffuse, self.sky.clone(), self.reflected.clone()]
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
        all.extend(columns.iter().map(|name| Column::float(*name, Digits::Decimals(3)).with_unit(UNIT)));
        let table = Table::create(path, TableColumns::new(all), Places::counted(points), Some(about))?;
        Ok(HourlyTable { table })
    }

    /// Writes all hours of a point: `[column][hour]`, W/m2.
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
