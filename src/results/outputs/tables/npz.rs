//! Tables as `.npz`, which `numpy.load` reads: an uncompressed zip archive. It contains the array
//! `values` (see [`crate::outputs::tables::numpy`]), an array for each column of text and of steps,
//! and `column`, the names of the last axis. It also contains the scalar strings `unit` (or an
//! array, one for each column, if they differ) and `provenance` (JSON).
//!
//! NumPy's times have no zone. The values of `time` are readings of the local clock, so that days
//! are days; the scalar `utc_offset`, a time difference, is the clock's offset from UTC.

use std::io::{self, Write};
use std::path::PathBuf;

use zip::write::{SimpleFileOptions, StreamWriter};
use zip::{CompressionMethod, ZipWriter};

use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use crate::outputs::tables::batch::Batch;
use crate::outputs::tables::column::{Along, BinValues, Column};
use crate::outputs::tables::numpy::{COLUMN_AXIS, NumpyArray, Units, header};
use crate::outputs::tables::writer::{FormatWriter, TableRequest, failed};
use heliotile_core::error::Result;

/// Archive of arrays being written.
pub struct NpzTable {
    zip: ZipWriter<StreamWriter<Sink>>,
    array: NumpyArray,
    /// `[column]`: texts of the places or rows so far, which are written last.
    texts: Vec<Vec<String>>,
    about: Provenance,
    path: PathBuf,
}

impl NpzTable {
    pub fn new(sink: Sink, request: &TableRequest) -> Result<Self> {
        let path = sink.path().to_path_buf();
        let mut zip = ZipWriter::new_stream(sink);
        let array = NumpyArray::new(&request.columns, request.places.count);
        let head = array.header();
        start(&mut zip, "values").and_then(|()| zip.write_all(&head)).map_err(|error| failed(&path, error))?;
        let texts = vec![Vec::new(); array.texts().count()];
        Ok(NpzTable { zip, array, texts, about: request.about.cloned().unwrap_or_default(), path })
    }

    /// Writes all arrays that follow the values.
    fn end(&mut self) -> io::Result<()> {
        let zip = &mut self.zip;
        let texts: Vec<(&Column, &Vec<String>)> = self.array.texts().zip(&self.texts).collect();
        let (names, further) = texts.split_at(texts.len().min(1));
        names.iter().try_for_each(|(column, all)| strings(zip, &column.name, all))?;
        self.array.steps().try_for_each(|column| steps(zip, column))?;
        strings(zip, COLUMN_AXIS, &self.array.values())?;
        match self.array.units() {
            Units::One(unit) => string(zip, "unit", &unit)?,
            Units::Each(units) => strings(zip, "unit", &units)?,
        }
        string(zip, "provenance", &self.about.json().to_string())?;
        further.iter().try_for_each(|(column, all)| strings(zip, &column.name, all))
    }
}

impl FormatWriter for NpzTable {
    fn write(&mut self, batch: &Batch) -> Result<()> {
        let texts = batch.values.iter().map(|values| values.texts()).filter(|texts| !texts.is_empty());
        self.texts.iter_mut().zip(texts).for_each(|(all, texts)| all.extend_from_slice(texts));
        let bytes = self.array.bytes(batch);
        self.zip.write_all(&bytes).map_err(|error| failed(&self.path, error))
    }

    fn finish(mut self: Box<Self>) -> Result<u64> {
        self.array.check(&self.path)?;
        self.end().map_err(|error| failed(&self.path, error))?;
        let sink = self.zip.finish().map_err(|error| failed(&self.path, io::Error::from(error)))?;
        sink.into_inner().finish()
    }
}

/// Begins an array, without a date, so that equal results give equal files.
fn start(zip: &mut ZipWriter<StreamWriter<Sink>>, name: &str) -> io::Result<()> {
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored).large_file(true);
    Ok(zip.start_file(format!("{name}.npy"), options)?)
}

/// Writes the values of a column along steps.
fn steps(zip: &mut ZipWriter<StreamWriter<Sink>>, column: &Column) -> io::Result<()> {
    match (&column.along, column.instants()) {
        (_, Some(instants)) => {
            let local = instants.local_s();
            array(
                zip,
                &column.name,
                &header("<M8[s]", &[local.len() as u64]),
                local.into_iter().map(i64::to_le_bytes),
            )?;
            let minutes = i64::from(instants.offset.minutes());
            array(zip, "utc_offset", &header("<m8[m]", &[]), [minutes.to_le_bytes()].into_iter())
        }
        (Along::Bins(BinValues::Labels(labels)), None) => strings(zip, &column.name, &labels.text),
        (Along::Bins(BinValues::Numbers(numbers)), None) => {
            let head = header("<f8", &[numbers.len() as u64]);
            array(zip, &column.name, &head, numbers.iter().map(|number| number.to_le_bytes()))
        }
        (Along::Rows | Along::Places, None) => Ok(()),
    }
}

/// Writes an array with 8 bytes a value.
fn array(
    zip: &mut ZipWriter<StreamWriter<Sink>>,
    name: &str,
    head: &[u8],
    values: impl Iterator<Item = [u8; 8]>,
) -> io::Result<()> {
    start(zip, name)?;
    zip.write_all(head)?;
    zip.write_all(&values.flatten().collect::<Vec<u8>>())
}

/// Writes a scalar string, whose shape is empty.
fn string(zip: &mut ZipWriter<StreamWriter<Sink>>, name: &str, text: &str) -> io::Result<()> {
    letters(zip, name, &[text], &[])
}

/// Writes an array of strings.
fn strings(zip: &mut ZipWriter<StreamWriter<Sink>>, name: &str, all: &[String]) -> io::Result<()> {
    letters(zip, name, all, &[all.len() as u64])
}

/// Writes strings in UTF-32, padded with zeros to the length of the longest.
fn letters(
    zip: &mut ZipWriter<StreamWriter<Sink>>,
    name: &str,
    all: &[impl AsRef<str>],
    shape: &[u64],
) -> io::Result<()> {
    start(zip, name)?;
    let width = all.iter().map(|text| text.as_ref().chars().count()).max().unwrap_or(0).max(1);
    zip.write_all(&header(&format!("<U{width}"), shape))?;
    for text in all {
        let letters = text.as_ref().chars().map(u32::from).chain(std::iter::repeat(0)).take(width);
        zip.write_all(&letters.flat_map(u32::to_le_bytes).collect::<Vec<u8>>())?;
    }
    Ok(())
}
