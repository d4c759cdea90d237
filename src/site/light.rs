//! Light of a site. In: receivers, suns and skies that were read. Out: tiles, columns, files.

use super::Site;
use heliotile_core::error::Result;
use heliotile_core::replay::components::{ComponentList, ComponentSet};
use heliotile_files::writing::claim::OutputGuard;
use heliotile_results::{
    BinLabels, LightRequest, OutputRequest, Provenance, ReceiverSet, Resources, Series, Tile, TileStream,
};

/// Light of the chosen receivers of a site under suns and skies. Nothing is computed before it is
/// asked for.
pub struct SiteReplay<'a> {
    pub(super) site: &'a Site,
    pub(super) receivers: ReceiverSet<'a>,
    pub(super) light: LightRequest,
    pub(super) series: Series,
    pub(super) resources: Resources<'a>,
    /// No file that is written meanwhile may replace an input.
    pub(super) _guard: OutputGuard,
}

/// Sum of a receiver over a weather file.
#[derive(Clone, Debug, PartialEq)]
pub struct ReceiverTotal {
    /// Name of the receiver.
    pub id: String,
    /// Irradiation, kWh/m2.
    pub kwh_m2: f64,
}

impl SiteReplay<'_> {
    /// Returns the receivers.
    pub fn receivers(&self) -> &ReceiverSet<'_> {
        &self.receivers
    }

    /// Returns the labels of the bins: names of conditions, or times.
    pub fn bins(&self) -> &BinLabels {
        &self.series.labels
    }

    /// Returns the columns, in the order of results.
    pub fn columns(&self) -> ComponentList {
        self.light.columns()
    }

    /// Returns the provenance that files of these results state.
    pub fn provenance(&self) -> Provenance {
        self.stream().about(self.site.archives(), &self.site.place)
    }

    /// Returns the tiles, ready to be computed.
    pub fn stream(&self) -> TileStream<'_> {
        TileStream { receivers: &self.receivers, light: &self.light, series: &self.series, resources: self.resources }
    }

    /// Computes all tiles and hands each to `take`, until it returns false.
    pub fn each(&self, components: ComponentSet, take: impl FnMut(&Tile) -> Result<bool>) -> Result<()> {
        self.stream().each(components, take)
    }

    /// Writes tables, maps, charts and models of other programs in one pass. Returns a sentence
    /// about what was written, if there is one.
    pub fn write(&self, files: &OutputRequest) -> Result<Option<String>> {
        files.write(&self.stream(), self.site.archives(), &self.site.place)
    }
}
