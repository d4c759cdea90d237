//! Columns of light by band. In: the columns that are asked for, an open site. Out: which replays
//! they take, as the site is in their bands, and what the light of sun and sky is taken times in
//! each.
//!
//! A band is the same replay as that of all light, with other reflectances, transmittances and
//! source scales; columns whose materials reflect alike share one.

use crate::light::states::Schedule;
use crate::opened::OpenSite;
use crate::replay::components::{Component, ComponentSet};
use crate::site::bands::{Band, SourceScale};
use crate::sky::efficacy::luminous_efficacy;
use crate::weather::conditions::Condition;
use crate::weather::time::bins::Bins;

/// Photons of 400 to 700 nm in a joule of their energy, umol/J: McCree, "Test of current
/// definitions of photosynthetically active radiation against leaf photosynthesis data",
/// Agricultural Meteorology 10, 1972, for sun and sky. The direct spectrum of ASTM G173-03 has
/// 4.63, what the sky adds to it 4.41.
const PHOTONS_UMOL_J: f64 = 4.57;

/// A band whose shares of the light a user gives.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnBand {
    /// What results call it.
    pub name: String,
    /// Shares of the light of sun and sky.
    pub shares: SourceScale,
    /// The band whose reflectances and transmittances count; `None`: those for all light.
    pub optics: Option<Band>,
}

/// What the light of a condition is taken times.
#[derive(Clone, Copy, Debug)]
enum SourceScaling {
    /// One scale for all conditions.
    Constant(SourceScale),
    /// [`luminous_efficacy`].
    Luminous,
}

impl SourceScaling {
    fn of(self, condition: &Condition) -> SourceScale {
        match self {
            SourceScaling::Constant(scale) => scale,
            SourceScaling::Luminous => luminous_efficacy(condition),
        }
    }
}

/// A column of a band.
struct BandColumn {
    component: Component,
    optics: Option<Band>,
    scaling: SourceScaling,
}

impl BandColumn {
    /// The column of `component`; `None` where it belongs to no band, or to a band of a file that
    /// is not there.
    fn of(component: Component, own: &[OwnBand]) -> Option<Self> {
        let band = |band: Band, factor| {
            let scaling = SourceScaling::Constant(band.shares().times(factor));
            Some(BandColumn { component, optics: Some(band), scaling })
        };
        match component {
            Component::TotalUv => band(Band::Uv, 1.0),
            Component::TotalVisible => band(Band::Visible, 1.0),
            Component::TotalPar => band(Band::Par, 1.0),
            Component::TotalNir => band(Band::Nir, 1.0),
            Component::Ppfd => band(Band::Par, PHOTONS_UMOL_J),
            Component::Illuminance => {
                Some(BandColumn { component, optics: Some(Band::Visible), scaling: SourceScaling::Luminous })
            }
            _ => {
                let place = Component::OWN.iter().position(|one| *one == component)?;
                let OwnBand { shares, optics, .. } = own.get(place)?;
                Some(BandColumn { component, optics: *optics, scaling: SourceScaling::Constant(*shares) })
            }
        }
    }
}

/// The columns of a band: its irradiance, and what else is known by it.
pub fn columns_of(band: Band) -> &'static [Component] {
    match band {
        Band::Uv => &[Component::TotalUv],
        Band::Visible => &[Component::TotalVisible, Component::Illuminance],
        Band::Par => &[Component::TotalPar, Component::Ppfd],
        Band::Nir => &[Component::TotalNir],
    }
}

/// One replay for some columns whose materials reflect alike.
pub struct BandPass<'a> {
    /// The site as it is in the band.
    pub site: OpenSite<'a>,
    /// Schedules of its reflectances and transmittances.
    pub schedules: Vec<Schedule>,
    columns: Vec<BandColumn>,
}

impl<'a> BandPass<'a> {
    /// The replays of the columns of bands among some components, without schedules.
    pub fn all(site: &OpenSite<'a>, components: ComponentSet, own: &[OwnBand]) -> Vec<Self> {
        let mut passes: Vec<BandPass> = Vec::new();
        for column in components.iter().filter_map(|component| BandColumn::of(component, own)) {
            let site = column.optics.map_or_else(|| site.clone(), |band| site.in_band(band));
            match passes.iter_mut().find(|pass| pass.site.materials() == site.materials()) {
                Some(pass) => pass.columns.push(column),
                None => passes.push(BandPass { site, schedules: Vec::new(), columns: vec![column] }),
            }
        }
        passes
    }

    /// The columns, in the order of [`BandPass::conditions`].
    pub(super) fn components(&self) -> Vec<Component> {
        self.columns.iter().map(|column| column.component).collect()
    }

    /// The conditions, once for each column with its scale.
    pub(super) fn conditions(&self, conditions: &[Condition]) -> Vec<Condition> {
        let scaled = |scaling: SourceScaling| {
            conditions.iter().map(move |condition| Condition { scale: scaling.of(condition), ..condition.clone() })
        };
        self.columns.iter().flat_map(|column| scaled(column.scaling)).collect()
    }

    /// Where they add to: the results of the first column, then those of the next; `are_sums`:
    /// results are sums with hours / 1000.
    pub(super) fn bins(&self, bins: &Bins, are_sums: bool) -> Bins {
        let of_column = |(place, column): (usize, &BandColumn)| {
            let factor = if are_sums { column.component.measure().sum_factor() } else { 1.0 };
            bins.of_condition.iter().map(move |(bin, weight)| (place * bins.count + bin, weight * factor))
        };
        let of_condition = self.columns.iter().enumerate().flat_map(of_column).collect();
        Bins { count: self.columns.len() * bins.count, of_condition }
    }

    /// The schedules over these conditions.
    pub(super) fn repeated(&self) -> Vec<Schedule> {
        let repeat = |schedule: &Schedule| Schedule {
            materials: schedule.materials.clone(),
            values: schedule.values.repeat(self.columns.len()),
        };
        self.schedules.iter().map(repeat).collect()
    }
}
