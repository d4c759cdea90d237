//! Tables as arrays of NumPy: f32, `[receiver][label][component]`, C order. What the places of an axis mean stands in
//! `NAME.axes.json` beside `NAME.npy`, or in further arrays of an `.npz` file (see [`crate::outputs::tables::npz`]).
//!
//! Format: NumPy enhancement proposal 1 (Kern 2007), version 1.0: magic, length of the header, a Python dictionary, values.

use std::io::Write;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde_json::{Value, json};

use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use crate::outputs::tables::layout::Layout;
use crate::outputs::tables::row_labels::RowLabels;
use crate::outputs::tables::table::Table;
use crate::outputs::tables::tile_columns::TileColumns;
use heliotile_core::error::{Error, Result};

/// Values begin at a multiple of this, as NumPy writes them, so that they can be mapped.
const ALIGNMENT: usize = 64;

/// What stands before the values of an array; `kind` as NumPy's `dtype.str`.
pub fn header(kind: &str, shape: &[u64]) -> Vec<u8> {
    let sizes = match shape {
        [one] => format!("{one},"),
        more => more.iter().map(u64::to_string).collect::<Vec<_>>().join(", "),
    };
    let mut text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({sizes}), }}");
    // Ten bytes before the text, a line end behind it.
    let length = (10 + text.len() + 1).next_multiple_of(ALIGNMENT);
    text.extend(std::iter::repeat_n(' ', length - 11 - text.len()));
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(((length - 10) as u16).to_le_bytes());
    bytes.extend(text.bytes());
    bytes.push(b'\n');
    bytes
}

/// The values of a tile as they stand in an array.
pub(super) fn array_bytes(values: &TileColumns) -> Vec<u8> {
    let row = values.count() * size_of::<f32>();
    let size = values.labels() * row;
    let mut bytes = vec![0; values.receivers() * size];
    bytes.par_chunks_mut(size.max(1)).enumerate().for_each(|(receiver, out)| {
        let columns = values.rows(receiver);
        for (label, out) in out.chunks_exact_mut(row.max(1)).enumerate() {
            for (column, out) in columns.iter().zip(out.chunks_exact_mut(size_of::<f32>())) {
                out.copy_from_slice(&column.get(label).copied().unwrap_or_default().to_le_bytes());
            }
        }
    });
    bytes
}

/// The unit of all columns, or that of each where they differ.
fn unit(layout: &Layout) -> Value {
    if layout.facts.is_empty() { json!(layout.unit()) } else { json!(layout.units()) }
}

/// The error of a table that got fewer or more receivers than its shape says.
pub(super) fn incomplete(path: &Path, got: u64, announced: u64) -> Error {
    let what = format!("{got} receivers came, {announced} were announced");
    Error::input(path, None, what, "this is a defect, report it")
}

/// An array and its axes being written.
pub struct NpyTable {
    values: Sink,
    axes: Sink,
    announced: u64,
    done: u64,
}

impl NpyTable {
    pub fn new(
        path: &Path,
        layout: &Layout,
        labels: &RowLabels,
        provenance: &Provenance,
        announced: u64,
    ) -> Result<Self> {
        let mut values = Sink::file(path)?;
        let mut axes = Sink::file(&NpyTable::axes_of(path))?;
        let shape = [announced, labels.len() as u64, layout.values().len() as u64];
        write(&mut values, &header("<f4", &shape))?;
        let known = format!(
            "{{\"axes\": {}, \"unit\": {},\n\"provenance\": {},\n\"column\": {},\n{}: {},\n{}: [",
            json!([layout.place(), layout.label(), "column"]),
            unit(layout),
            provenance.json(),
            json!(layout.values()),
            json!(layout.label()),
            json!(labels.text),
            json!(layout.place()),
        );
        write(&mut axes, known.as_bytes())?;
        Ok(NpyTable { values, axes, announced, done: 0 })
    }

    /// The file beside an array that says what is where in it.
    pub fn axes_of(path: &Path) -> PathBuf {
        path.with_extension("axes.json")
    }
}

impl Table for NpyTable {
    fn write_tile(&mut self, receivers: &[String], values: &TileColumns) -> Result<()> {
        for name in receivers {
            let comma = if self.done == 0 { "\n" } else { ",\n" };
            write(&mut self.axes, format!("{comma}{}", json!(name)).as_bytes())?;
            self.done += 1;
        }
        write(&mut self.values, &array_bytes(values))
    }

    fn finish(mut self: Box<Self>) -> Result<u64> {
        if self.done != self.announced {
            return Err(incomplete(self.values.path(), self.done, self.announced));
        }
        write(&mut self.axes, b"]}\n")?;
        // The array last: where it is, so are its axes.
        let axes = self.axes.finish()?;
        Ok(axes + self.values.finish()?)
    }
}

fn write(sink: &mut Sink, bytes: &[u8]) -> Result<()> {
    sink.write_all(bytes).map_err(|e| Error::io(sink.path(), "write to")(e))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A header is what NumPy 2.4 writes for the same array: 128 bytes, of which 118 follow the length.
    #[test]
    fn header_is_numpys() {
        let bytes = header("<f4", &[3, 2, 7]);
        let text = "{'descr': '<f4', 'fortran_order': False, 'shape': (3, 2, 7), }";
        assert_eq!((bytes.len(), &bytes[..10]), (128, &b"\x93NUMPY\x01\x00\x76\x00"[..]));
        assert!(bytes[10..].starts_with(text.as_bytes()) && bytes.ends_with(b" \n"));
        assert_eq!(header("<U9", &[1]).len() % 64, 0);
    }
}
