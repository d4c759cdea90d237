//! Folder of hourly results in the layout of Honeybee's recipes. In: a stream of hours. Out: the
//! folder.

use std::path::Path;

use crate::outputs::honeybee::{Grids, LitHours, ResultsFolder};
use crate::outputs::periods::Every;
use crate::outputs::provenance::Provenance;
use crate::outputs::tables::layout::By;
use crate::stream::{Tile, TileSink, TileStream};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::replay::components::{Component, ComponentList, ComponentSet};
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::counted;

/// Components that such a folder can hold.
const COMPONENTS: [Component; 2] = [Component::Total, Component::SunDirect];

/// Refuses requests that such a folder cannot hold.
pub fn check(columns: Option<&ComponentList>, every: Option<Every>, folder: &Path) -> Result<()> {
    let Some(every) = every else {
        let what = "a folder of Honeybee results holds hours of weather, not suns and skies by themselves";
        return Err(Error::argument("honeybee", what, "give {weather}").because(Problem::needs("weather")));
    };
    if every != Every::Hour {
        let hint = "leave {every} out: Honeybee makes sums from the hours";
        return Err(Error::argument("every", "a folder of Honeybee results holds hours only", hint)
            .because(Problem::excludes("honeybee")));
    }
    let known = |component: &Component| COMPONENTS.contains(component);
    if columns.is_some_and(|columns| !columns.as_slice().iter().all(known)) {
        let hint = "give total, sun_direct or both";
        return Err(Error::argument(
            "columns",
            "a folder of Honeybee results holds only `total` and `direct`, the sun alone",
            hint,
        )
        .because(Problem::excludes("honeybee")));
    }
    ResultsFolder::check(folder)
}

/// Writes the folder and returns a line that says so.
pub fn write(stream: &TileStream, by: By, folder: &Path, about: Provenance) -> Result<String> {
    let series = stream.series;
    let hours = LitHours::new(&series.conditions).map_err(|(what, hint)| {
        Error::input(&series.source, None, format!("has {what}, which Honeybee cannot read"), hint)
    })?;
    let grids = Grids::new(stream.receivers.receivers(), by)?;
    let components = stream.light.chosen_columns().map_or(COMPONENTS.to_vec(), |columns| columns.as_slice().to_vec());
    let mut sink = HoneybeeSink {
        receivers: stream.receivers.receivers(),
        components: ComponentSet::new(&components),
        start: Some(Box::new(|| ResultsFolder::create(folder, grids, hours, &components, &about))),
        folder: None,
    };
    stream.feed(&mut sink)?;
    let count = sink.folder.map_or(Ok(0), ResultsFolder::finish)?;
    let (grids, receivers) = (counted(count as u64, "grid"), counted(stream.receivers.count(), "receiver"));
    Ok(format!("{}: {receivers} in {grids}\n", folder.display()))
}

struct HoneybeeSink<'a, R> {
    receivers: R,
    components: ComponentSet,
    start: Option<Box<dyn FnOnce() -> Result<ResultsFolder> + 'a>>,
    folder: Option<ResultsFolder>,
}

impl<R: Iterator<Item = Result<Receiver>>> TileSink for HoneybeeSink<'_, R> {
    fn components(&self) -> ComponentSet {
        self.components
    }

    fn start(&mut self) -> Result<()> {
        self.folder = self.start.take().map(|start| start()).transpose()?;
        Ok(())
    }

    fn take(&mut self, tile: &Tile) -> Result<bool> {
        let here = self.receivers.by_ref().take(tile.ids.len()).collect::<Result<Vec<_>>>()?;
        self.folder.as_mut().map_or(Ok(()), |folder| folder.write(&here, tile.values))?;
        Ok(true)
    }
}
