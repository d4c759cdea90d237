//! Columns of light by band. In: the requested columns, an open site. Out: the replays that the
//! columns take, the site as it is in each band, and the factors of the light of sun and sky in
//! each.
//!
//! A band is a replay like that of all light, with other reflectances, transmittances and source
//! scales. Columns whose materials reflect alike share a replay.

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

/// Band whose shares of the light a user gives.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnBand {
    /// Name of the band in results.
    pub name: String,
    /// Shares of the light of sun and sky.
    pub shares: SourceScale,
    /// Band whose reflectances and transmittances apply; `None`: those for all light.
    pub optics: Option<Band>,
}

/// Factors of the light of a condition.
#[derive(Clone, Copy, Debug)]
enum SourceScaling {
    /// One scale for all conditions.
    Constant(SourceScale),
    /// Factors of [`luminous_efficacy`], by condition.
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

/// Column of a band.
struct BandColumn {
    component: Component,
    optics: Option<Band>,
    scaling: SourceScaling,
}

impl BandColumn {
    /// Returns the column of `component`, or `None` if it belongs to no band, or to a user's band
    /// that is not given.
    fn new(component: Component, own: &[OwnBand]) -> Option<Self> {
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

/// Returns the columns of a band: its irradiance, and the quantity that follows from it.
pub fn columns_of(band: Band) -> &'static [Component] {
    match band {
        Band::Uv => &[Component::TotalUv],
        Band::Visible => &[Component::TotalVisible, Component::Illuminance],
        Band::Par => &[Component::TotalPar, Component::Ppfd],
        Band::Nir => &[Component::TotalNir],
    }
}

/// Replay for the columns whose materials reflect alike.
pub struct BandPass<'a> {
    /// Site as it is in the band.
    pub site: OpenSite<'a>,
    /// Schedules of the reflectances and transmittances.
    pub schedules: Vec<Schedule>,
    columns: Vec<BandColumn>,
}

impl<'a> BandPass<'a> {
    /// Returns the replays of those components that are columns of bands, without schedules.
    pub fn all(site: &OpenSite<'a>, components: ComponentSet, own: &[OwnBand]) -> Vec<Self> {
        let mut passes: Vec<BandPass> = Vec::new();
        for column in components.iter().filter_map(|component| BandColumn::new(component, own)) {
            let site = column.optics.map_or_else(|| site.clone(), |band| site.in_band(band));
            match passes.iter_mut().find(|pass| pass.site.materials() == site.materials()) {
                Some(pass) => pass.columns.push(column),
                None => passes.push(BandPass { site, schedules: Vec::new(), columns: vec![column] }),
            }
        }
        passes
    }

    /// Returns the columns, in the order of [`BandPass::conditions`].
    pub(super) fn components(&self) -> Vec<Component> {
        self.columns.iter().map(|column| column.component).collect()
    }

    /// Returns the conditions once for each column, with the column's scale.
    pub(super) fn conditions(&self, conditions: &[Condition]) -> Vec<Condition> {
        let scaled = |scaling: SourceScaling| {
            conditions.iter().map(move |condition| Condition { scale: scaling.of(condition), ..condition.clone() })
        };
        self.columns.iter().flat_map(|column| scaled(column.scaling)).collect()
    }

    /// Returns the bins: the results of the first column, then those of the next. `are_sums` says
    /// that results are sums with hours / 1000.
    pub(super) fn bins(&self, bins: &Bins, are_sums: bool) -> Bins {
        let of_column = |(place, column): (usize, &BandColumn)| {
            let factor = if are_sums { column.component.measure().sum_factor() } else { 1.0 };
            bins.of_condition.iter().map(move |(bin, weight)| (place * bins.count + bin, weight * factor))
        };
        let of_condition = self.columns.iter().enumerate().flat_map(of_column).collect();
        Bins { count: self.columns.len() * bins.count, of_condition }
    }

    /// Returns the schedules, repeated for the conditions of each column.
    pub(super) fn repeated(&self) -> Vec<Schedule> {
        let repeat = |schedule: &Schedule| Schedule {
            materials: schedule.materials.clone(),
            values: schedule.values.repeat(self.columns.len()),
        };
        self.schedules.iter().map(repeat).collect()
    }
}
