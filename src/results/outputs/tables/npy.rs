//! Tables as an array of NumPy (see [`crate::outputs::tables::numpy`]). The file `NAME.axes.json`
//! beside `NAME.npy` names the entries of its axes.

use std::io::Write;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::outputs::sink::Sink;
use crate::outputs::tables::batch::Batch;
use crate::outputs::tables::column::{Along, BinValues, Column};
use crate::outputs::tables::numpy::{NumpyArray, Units};
use crate::outputs::tables::writer::{FormatWriter, TableRequest, failed};
use heliotile_core::error::Result;

/// Array and its axes being written.
pub struct NpyTable {
    array: NumpyArray,
    values: Sink,
    axes: Sink,
    /// True if a name was written.
    has_names: bool,
    /// `[column]`: further texts of the rows, written last.
    further: Vec<Vec<String>>,
}

impl NpyTable {
    pub fn new(mut values: Sink, request: &TableRequest) -> Result<Self> {
        let mut axes = Sink::file(&NpyTable::axes_of(request.path))?;
        let array = NumpyArray::new(&request.columns, request.places.count);
        write(&mut values, &array.header())?;
        let unit = match array.units() {
            Units::One(unit) => json!(unit),
            Units::Each(units) => json!(units),
        };
        let about = request.about.cloned().unwrap_or_default();
        let mut known = format!(
            "{{\"axes\": {}, \"unit\": {unit},\n\"provenance\": {},\n\"column\": {},\n",
            json!(array.axes()),
            about.json(),
            json!(array.values())
        );
        for column in array.steps() {
            known += &format!("{}: {},\n", json!(column.name), steps(column));
        }
        known += &format!("{}: [", json!(array.axes().first()));
        write(&mut axes, known.as_bytes())?;
        let further = vec![Vec::new(); array.texts().skip(1).count()];
        Ok(NpyTable { array, values, axes, has_names: false, further })
    }

    /// Returns the path of the file beside an array that describes its axes.
    pub fn axes_of(path: &Path) -> PathBuf {
        path.with_extension("axes.json")
    }
}

impl FormatWriter for NpyTable {
    fn write(&mut self, batch: &Batch) -> Result<()> {
        let mut texts = batch.values.iter().map(|values| values.texts()).filter(|texts| !texts.is_empty());
        for name in texts.next().unwrap_or_default() {
            let comma = if self.has_names { ",\n" } else { "\n" };
            write(&mut self.axes, format!("{comma}{}", json!(name)).as_bytes())?;
            self.has_names = true;
        }
        self.further.iter_mut().zip(texts).for_each(|(all, texts)| all.extend_from_slice(texts));
        write(&mut self.values, &self.array.bytes(batch))
    }

    fn finish(mut self: Box<Self>) -> Result<u64> {
        self.array.check(self.values.path())?;
        let mut end = "]".to_owned();
        for (column, texts) in self.array.texts().skip(1).zip(&self.further) {
            end += &format!(",\n{}: {}", json!(column.name), json!(texts));
        }
        write(&mut self.axes, (end + "}\n").as_bytes())?;
        // The array is completed last: if it exists, so do its axes.
        let axes = self.axes.finish()?;
        Ok(axes + self.values.finish()?)
    }
}

/// Returns the values of a column along steps.
fn steps(column: &Column) -> Value {
    match &column.along {
        Along::Bins(BinValues::Labels(labels)) => json!(labels.text),
        Along::Bins(BinValues::Numbers(numbers)) => json!(numbers),
        Along::Rows | Along::Places => Value::Null,
    }
}

fn write(sink: &mut Sink, bytes: &[u8]) -> Result<()> {
    sink.write_all(bytes).map_err(|error| failed(sink.path(), error))
}
