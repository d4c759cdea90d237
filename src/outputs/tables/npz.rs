//! Tables as `.npz`, which `numpy.load` reads: a zip archive, not compressed, of the arrays `values` (see [`crate::outputs::tables::npy`]), names of
//! its three axes (`receiver` or `surface`, `time` or `condition`, `column`) and the lone strings `unit` (one for each column where they differ) and `provenance` (JSON).
//!
//! NumPy's times have no zone. Those of `time` are readings of the local clock, so that days are days; `utc_offset`, a lone
//! time difference, is how far that clock is ahead of UTC.

use std::io::{self, Write};
use std::path::PathBuf;

use zip::write::{SimpleFileOptions, StreamWriter};
use zip::{CompressionMethod, ZipWriter};

use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use crate::outputs::tables::layout::Layout;
use crate::outputs::tables::npy::{array_bytes, header, incomplete};
use crate::outputs::tables::row_labels::RowLabels;
use crate::outputs::tables::table::Table;
use crate::outputs::tables::tile_columns::TileColumns;
use heliotile_core::error::{Error, Result};

/// An archive of arrays being written.
pub struct NpzTable {
    zip: ZipWriter<StreamWriter<Sink>>,
    layout: Layout,
    labels: RowLabels,
    provenance: Provenance,
    /// Of the receivers so far: they are written last.
    names: Vec<String>,
    announced: u64,
    path: PathBuf,
}

impl NpzTable {
    pub fn new(
        sink: Sink,
        layout: &Layout,
        labels: &RowLabels,
        provenance: &Provenance,
        announced: u64,
    ) -> Result<Self> {
        let path = sink.path().to_path_buf();
        let mut zip = ZipWriter::new_stream(sink);
        let shape = [announced, labels.len() as u64, layout.values().len() as u64];
        let values = header("<f4", &shape);
        start(&mut zip, "values").and_then(|()| zip.write_all(&values)).map_err(Error::io(&path, "write to"))?;
        let (layout, labels, provenance) = (layout.clone(), labels.clone(), provenance.clone());
        Ok(NpzTable { zip, layout, labels, provenance, names: Vec::new(), announced, path })
    }
}

impl Table for NpzTable {
    fn write_tile(&mut self, receivers: &[String], values: &TileColumns) -> Result<()> {
        self.names.extend_from_slice(receivers);
        let bytes = array_bytes(values);
        self.zip.write_all(&bytes).map_err(Error::io(&self.path, "write to"))
    }

    fn finish(mut self: Box<Self>) -> Result<u64> {
        if self.names.len() as u64 != self.announced {
            return Err(incomplete(&self.path, self.names.len() as u64, self.announced));
        }
        let (place, label) = (self.layout.place(), self.layout.label());
        let mut end = || {
            let zip = &mut self.zip;
            strings(zip, place, &self.names, &[self.names.len() as u64])?;
            match &self.labels.instants {
                Some(instants) => {
                    let local = instants.local_s();
                    integers(zip, label, "<M8[s]", &local, &[local.len() as u64])?;
                    integers(zip, "utc_offset", "<m8[m]", &[instants.offset.minutes().into()], &[])?;
                }
                None => strings(zip, label, &self.labels.text, &[self.labels.len() as u64])?,
            }
            strings(zip, "column", &self.layout.values(), &[self.layout.values().len() as u64])?;
            match self.layout.facts.is_empty() {
                true => strings(zip, "unit", &[self.layout.unit().to_string()], &[])?,
                false => {
                    let units: Vec<String> = self.layout.units().into_iter().map(str::to_owned).collect();
                    strings(zip, "unit", &units, &[units.len() as u64])?;
                }
            }
            strings(zip, "provenance", &[self.provenance.json().to_string()], &[])
        };
        end().map_err(Error::io(&self.path, "write to"))?;
        let sink = self.zip.finish().map_err(|e| Error::io(&self.path, "write to")(e.into()))?;
        sink.into_inner().finish()
    }
}

/// Begins an array; without a date, so that equal results are equal files.
fn start(zip: &mut ZipWriter<StreamWriter<Sink>>, name: &str) -> io::Result<()> {
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored).large_file(true);
    Ok(zip.start_file(format!("{name}.npy"), options)?)
}

/// An array of 8 bytes a value, of a type such as NumPy's times; a lone value without a shape.
fn integers(
    zip: &mut ZipWriter<StreamWriter<Sink>>,
    name: &str,
    kind: &str,
    all: &[i64],
    shape: &[u64],
) -> io::Result<()> {
    start(zip, name)?;
    zip.write_all(&header(kind, shape))?;
    zip.write_all(&all.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>())
}

/// An array of strings, a lone one without a shape: UTF-32 of the length of the longest, zeros behind.
fn strings(zip: &mut ZipWriter<StreamWriter<Sink>>, name: &str, all: &[String], shape: &[u64]) -> io::Result<()> {
    start(zip, name)?;
    let width = all.iter().map(|text| text.chars().count()).max().unwrap_or(0).max(1);
    zip.write_all(&header(&format!("<U{width}"), shape))?;
    for text in all {
        let letters = text.chars().map(u32::from).chain(std::iter::repeat(0)).take(width);
        zip.write_all(&letters.flat_map(u32::to_le_bytes).collect::<Vec<u8>>())?;
    }
    Ok(())
}
