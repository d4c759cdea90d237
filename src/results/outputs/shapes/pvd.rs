//! Maps through time for ParaView: a VTK grid for each bin, and a `.pvd` file that lists them.
//! In: rows, tiles of values. Out: the files, in a folder of the same name beside the `.pvd`. The
//! `.pvd` is written last, so the files it lists are complete.

use std::fs;
use std::path::{Path, PathBuf};

use super::columns::{MapColumns, ending};
use super::rows::MapRows;
use super::vtu::{self, Step};
use crate::outputs::provenance::Provenance;
use crate::outputs::quantities::{PlaceValues, ValueSource};
use crate::outputs::sink::{Sink, write_texts};
use crate::outputs::tables::bin_labels::BinLabels;
use crate::outputs::tables::layout::Layout;
use heliotile_core::error::{Error, Result};
use heliotile_core::light::scratch::{Scratch, ScratchSpace};
use heliotile_core::text::message;

/// Largest number of files of a series; `MAX_BYTES` are their largest total bytes. Each file holds
/// the whole geometry.
const MAX_FILES: u64 = 10_000;
const MAX_BYTES: u64 = 16 << 30;

/// Memory for the values of bins that are read together, bytes.
const AT_ONCE: u64 = 64 << 20;

/// Values that wait for the geometry.
pub struct Series {
    scratch: Box<dyn Scratch>,
    /// Offset of each tile's values, `[bin][source][place]`, and its number of places.
    tiles: Vec<(u64, u64)>,
    length: u64,
    bins: BinLabels,
    sources: Vec<ValueSource>,
    names: Vec<String>,
}

impl Series {
    pub fn new(layout: &Layout, bins: &BinLabels, storage: &dyn ScratchSpace) -> Result<Self> {
        if bins.len() as u64 > MAX_FILES {
            let what = "the number of files of a time series (choose fewer with {from} and {to}, or a longer {every})";
            return Err(Error::Limit { what: what.into(), value: bins.len() as u64, max: MAX_FILES });
        }
        let sources = layout.quantities.iter().map(|one| one.source).collect();
        let names = layout.quantities.iter().map(|one| one.with_ending(ending(layout))).collect();
        Ok(Series { scratch: storage.scratch()?, tiles: Vec::new(), length: 0, bins: bins.clone(), sources, names })
    }

    /// Adds the values of the next places.
    pub fn add(&mut self, values: &PlaceValues) -> Result<()> {
        let mut bytes = Vec::new();
        for bin in 0..values.bins() {
            for source in &self.sources {
                bytes.extend((0..values.places()).flat_map(|place| values.value(*source, place, bin).to_le_bytes()));
            }
        }
        self.scratch.write(self.length, &bytes)?;
        self.tiles.push((self.length, values.places() as u64));
        self.length += bytes.len() as u64;
        Ok(())
    }

    /// Reads the values of some bins, `[bin][source][place]`.
    fn read(&self, first: u64, count: u64) -> Result<Vec<Vec<Vec<f32>>>> {
        let sources = self.sources.len() as u64;
        let mut found = vec![vec![Vec::new(); self.sources.len()]; count as usize];
        for (offset, places) in self.tiles.iter().filter(|(_, places)| *places > 0) {
            let of_bin = 4 * sources * places;
            let mut bytes = vec![0; (count * of_bin) as usize];
            self.scratch.read(offset + first * of_bin, &mut bytes)?;
            let values = bytes.as_chunks().0.iter().map(|four| f32::from_le_bytes(*four));
            let values: Vec<f32> = values.collect();
            let columns = found.iter_mut().flatten();
            columns.zip(values.chunks(*places as usize)).for_each(|(column, here)| column.extend(here));
        }
        Ok(found)
    }

    /// Returns hours since the first bin, or the indices of bins if these are no increasing
    /// times.
    fn times(&self) -> Vec<f64> {
        let count = 0..self.bins.len();
        match &self.bins.instants {
            Some(instants) if instants.utc_s.is_sorted_by(|a, b| a < b) => {
                let first = instants.utc_s.first().copied().unwrap_or_default();
                instants.utc_s.iter().map(|seconds| (seconds - first) as f64 / 3600.0).collect()
            }
            _ => count.map(|number| number as f64).collect(),
        }
    }
}

/// Returns the folder of the grids: the name without its ending.
fn folder_of(path: &Path) -> PathBuf {
    path.with_extension("")
}

/// Writes the files and returns the number of their bytes.
pub fn write(
    path: &Path,
    rows: &mut MapRows,
    columns: &MapColumns,
    series: &Series,
    about: &Provenance,
) -> Result<u64> {
    let facts = rows.facts;
    let of_cells = 17 + 4 * (1 + columns.numbers.len() + series.names.len()) as u64;
    let each = 24 * facts.corners + 8 * facts.cell_corners + of_cells * facts.cells;
    let bins = series.bins.len() as u64;
    // Each file repeats the geometry, so the total size is checked before anything is written.
    if each * bins > MAX_BYTES {
        let what = message!(
            "the size in bytes of a time series of {bins} files (choose fewer with {{from}} and {{to}}, a longer {{every}}, {{by}} \
             building or {{receivers}})"
        );
        return Err(Error::Limit { what, value: each * bins, max: MAX_BYTES });
    }
    let folder = folder_of(path);
    fs::create_dir_all(&folder).map_err(Error::io(&folder, "create"))?;
    let (stem, times) = (folder.file_name().unwrap_or_default().to_string_lossy().into_owned(), series.times());
    let of_bin = 4 * (series.sources.len() as u64 * facts.rows).max(1);
    let (at_once, mut bytes) = ((AT_ONCE / of_bin).clamp(1, bins.max(1)), 0);
    let mut list = String::new();
    for first in (0..bins).step_by(at_once as usize) {
        let some = series.read(first, at_once.min(bins - first))?;
        for (number, values) in (first as usize..).zip(some) {
            let name = format!("{stem}_{number:04}.vtu");
            let bin = series.bins.text.get(number).map_or("", String::as_str);
            let step = Step { label: bin, names: &series.names, values };
            bytes += vtu::write(Sink::file(&folder.join(&name))?, rows, columns, Some(&step), about)?;
            let time = times.get(number).copied().unwrap_or_default();
            let file = escaped(&format!("{stem}/{name}"));
            list.push_str(&format!("<DataSet timestep=\"{time}\" file=\"{file}\"/>\n"));
        }
    }
    let text = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
         <Collection>\n{list}</Collection>\n</VTKFile>\n"
    );
    bytes += text.len() as u64;
    let beside = path.parent().unwrap_or(Path::new(""));
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    write_texts(beside, &[(&name, text)])?;
    Ok(bytes)
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
