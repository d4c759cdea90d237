//! Further maps of a run's annual sums, beside `annual.ply`. In: its archive, the sums of its receivers. Out: files as `replay` writes them.

use glam::DVec3;

use super::folder::Files;
use crate::cli::RunArgs;
use crate::commands::replay::mapped::{crs_of, say_large, surroundings};
use crate::commands::temporary_files;
use crate::outputs::annual::AnnualRow;
use crate::outputs::periods::Every;
use crate::outputs::provenance::Provenance;
use crate::outputs::shapes::MapCrs;
use crate::outputs::shapes::group_patches::Shapeless;
use crate::outputs::shapes::writer::{MapFormat, MapRequest, MapWriter, PlaceShapes};
use crate::outputs::tables::layout::{By, Labels, Layout};
use crate::outputs::tables::row_labels::RowLabels;
use heliotile_builder::transfer::{ArchiveReceivers, Shown};
use heliotile_core::archive::Archive;
use heliotile_core::error::Result;
use heliotile_core::memory::{MemoryBudget, Use};
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::{Component, ComponentList};
use heliotile_core::replay::values::TileValues;
use heliotile_core::site::place::Place;
use heliotile_core::site::receiver::{Receiver, TILE};

/// Refuses maps that a scene of this place cannot have, before any work.
pub fn check(args: &RunArgs, place: Option<&Place>) -> Result<()> {
    let crs = MapCrs::of(place, DVec3::ZERO);
    args.map.iter().try_for_each(|format| format.check(&crs))
}

/// Writes the maps that are asked for; receivers that cannot be drawn are an error.
pub fn write(args: &RunArgs, files: &Files, archive: &Archive, rows: &[AnnualRow], about: &Provenance) -> Result<()> {
    if args.map.is_empty() {
        return Ok(());
    }
    let site = OpenSite::of(archive)?;
    let shown = || {
        let rows = ArchiveReceivers::<Shown>::new(&site);
        rows.map(|row| row.map(|row| Receiver { patch: row.layers.patch, ..row.receiver }))
    };
    Shapeless::refuse(shown(), &files.archive)?;
    let layout = Layout { labels: Labels::Sums, by: By::Receiver, components: ComponentList::all(), facts: Vec::new() };
    let (labels, storage) = (RowLabels::words(vec!["total".into()]), temporary_files());
    for format in &args.map {
        let path = files.further_map(*format);
        let request = MapRequest {
            path: &path,
            format: *format,
            layout: &layout,
            labels: &labels,
            every: Some(Every::Total),
            crs: crs_of(archive),
            around: (*format == MapFormat::Glb).then(|| surroundings(archive, &site)).flatten(),
            about: about.clone(),
            folder: std::env::temp_dir(),
            storage: &storage,
            memory_bytes: MemoryBudget::new(args.memory.0).length(Use::MapRows),
        };
        let mut map = MapWriter::create(request, PlaceShapes::Receivers(Box::new(shown()), site.north()))?;
        for some in rows.chunks(TILE) {
            let names: Vec<String> = some.iter().map(|row| row.receiver.id.clone()).collect();
            let mut values = TileValues::new(some.len(), 1);
            for component in Component::ALL {
                let column = values.component_mut(component);
                column.iter_mut().zip(some).for_each(|(to, row)| *to = row.kwh_m2[component as usize]);
            }
            map.write_tile(&names, &values, &[])?;
        }
        say_large(&path, &map.finish()?);
    }
    Ok(())
}
