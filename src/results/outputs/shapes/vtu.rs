//! Maps as an unstructured grid of VTK, which ParaView and PyVista read. In: rows. Out: one XML
//! file with raw binary arrays appended (`appended`, `raw`), 64-bit coordinates of the scene.

use std::fmt::Write as _;
use std::io::{self, Write};

use super::columns::MapColumns;
use super::row::MapRow;
use super::rows::{MapFacts, MapRows};
use crate::outputs::provenance::Provenance;
use crate::outputs::sink::Sink;
use heliotile_core::error::{Error, Result};

/// VTK's type numbers of cells.
const TRIANGLE: u8 = 5;
const POLYGON: u8 = 7;

/// Arrays of a file: their XML elements, and the offset of the next one in bytes.
#[derive(Default)]
struct Arrays {
    cells: String,
    offset: u64,
}

impl Arrays {
    /// Returns an element for an array of `bytes` bytes.
    fn element(&mut self, kind: &str, name: &str, more: &str, bytes: u64) -> String {
        let offset = self.offset;
        self.offset += 8 + bytes;
        let name = name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
        format!("<DataArray type=\"{kind}\" Name=\"{name}\"{more} format=\"appended\" offset=\"{offset}\"/>\n")
    }
}

/// Moment of a time series: names of values, and the values `[name][row]`.
pub struct Step<'a> {
    pub label: &'a str,
    pub names: &'a [String],
    pub values: Vec<Vec<f32>>,
}

/// Writes the file. Each step of a time series has its own values besides those of the columns.
pub fn write(
    sink: Sink,
    rows: &mut MapRows,
    columns: &MapColumns,
    step: Option<&Step>,
    about: &Provenance,
) -> Result<u64> {
    let path = sink.path().to_owned();
    let mut sink = sink;
    let MapFacts { corners, cells, cell_corners, .. } = rows.facts;
    // The XML states the offset of each array, so the lengths of texts are counted first.
    let mut lengths = vec![0_u64; columns.texts.len()];
    rows.each(|row| {
        let cells = cells_of(row);
        lengths.iter_mut().zip(&row.texts).for_each(|(length, text)| *length += cells * ended(text).len() as u64);
        Ok(())
    })?;
    let mut arrays = Arrays::default();
    let one = " NumberOfTuples=\"1\"";
    let label = ended(step.map_or("", |step| step.label));
    let note = ended(&about.json().to_string());
    let fields = arrays.element("String", "heliotile", one, note.len() as u64)
        + &arrays.element("String", "label", one, label.len() as u64);
    let points = arrays.element("Float64", "Points", " NumberOfComponents=\"3\"", 24 * corners);
    let connectivity = arrays.element("Int64", "connectivity", "", 8 * cell_corners);
    let offsets = arrays.element("Int64", "offsets", "", 8 * cells);
    let types = arrays.element("UInt8", "types", "", cells);
    let place = arrays.element("Int32", "place", "", 4 * cells);
    arrays.cells.push_str(&place);
    for (name, length) in columns.texts.iter().zip(&lengths) {
        let element = arrays.element("String", name, &format!(" NumberOfTuples=\"{cells}\""), *length);
        arrays.cells.push_str(&element);
    }
    let numbers = columns.numbers.iter().map(|(name, _)| name);
    for name in numbers.chain(step.map_or(&[][..], |step| step.names)) {
        let element = arrays.element("Float32", name, "", 4 * cells);
        arrays.cells.push_str(&element);
    }
    let main = match step {
        Some(step) => step.names.first(),
        None => columns.numbers.get(columns.colour).map(|(name, _)| name),
    };
    let mut head = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n<UnstructuredGrid>\n",
    );
    // Writing to a string cannot fail.
    let _ = write!(
        head,
        "<FieldData>\n{fields}</FieldData>\n<Piece NumberOfPoints=\"{corners}\" NumberOfCells=\"{cells}\">\n\
         <Points>\n{points}</Points>\n<Cells>\n{connectivity}{offsets}{types}</Cells>\n\
         <CellData Scalars=\"{}\">\n{}</CellData>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_",
        main.map_or("", String::as_str),
        arrays.cells
    );
    let mut out = Out { sink: &mut sink };
    let failed = |error: io::Error| Error::io(&path, "write to")(error);
    out.text(&head).map_err(failed)?;
    for text in [&note, &label] {
        out.array(text.len() as u64).and_then(|()| out.bytes(text)).map_err(failed)?;
    }
    out.array(24 * corners).map_err(failed)?;
    rows.each(|row| {
        let metres = row.polygons.iter().flat_map(|polygon| polygon.corners()).flat_map(|corner| corner.to_array());
        metres.into_iter().try_for_each(|metres| out.bytes(&metres.to_le_bytes())).map_err(failed)
    })?;
    out.array(8 * cell_corners).map_err(failed)?;
    let mut first = 0_i64;
    rows.each(|row| {
        for polygon in &row.polygons {
            for corner in polygon.cells().iter().flatten() {
                out.bytes(&(first + i64::from(*corner)).to_le_bytes()).map_err(failed)?;
            }
            first += polygon.corners().count() as i64;
        }
        Ok(())
    })?;
    out.array(8 * cells).map_err(failed)?;
    let mut end = 0_i64;
    rows.each(|row| {
        for cell in row.polygons.iter().flat_map(|polygon| polygon.cells()) {
            end += cell.len() as i64;
            out.bytes(&end.to_le_bytes()).map_err(failed)?;
        }
        Ok(())
    })?;
    out.array(cells).map_err(failed)?;
    rows.each(|row| {
        for cell in row.polygons.iter().flat_map(|polygon| polygon.cells()) {
            out.bytes(&[if cell.len() == 3 { TRIANGLE } else { POLYGON }]).map_err(failed)?;
        }
        Ok(())
    })?;
    // Writes an array in which all cells of a place have the same value.
    let mut repeated = |bytes: u64, value: &dyn Fn(usize, &MapRow) -> Vec<u8>| -> Result<()> {
        out.array(bytes).map_err(failed)?;
        let mut number = 0;
        rows.each(|row| {
            let value = value(number, row);
            number += 1;
            (0..cells_of(row)).try_for_each(|_| out.bytes(&value)).map_err(failed)
        })
    };
    repeated(4 * cells, &|number, _| (number as i32).to_le_bytes().to_vec())?;
    for (i, length) in lengths.iter().enumerate() {
        repeated(*length, &|_, row| ended(row.texts.get(i).map_or("", String::as_str)))?;
    }
    for i in 0..columns.numbers.len() {
        repeated(4 * cells, &|_, row| row.numbers.get(i).copied().unwrap_or(f32::NAN).to_le_bytes().to_vec())?;
    }
    for values in step.iter().flat_map(|step| &step.values) {
        repeated(4 * cells, &|number, _| values.get(number).copied().unwrap_or(f32::NAN).to_le_bytes().to_vec())?;
    }
    out.text("\n</AppendedData>\n</VTKFile>\n").map_err(failed)?;
    sink.finish()
}

/// Returns a text in VTK's form: with a zero byte at the end and none inside.
fn ended(text: &str) -> Vec<u8> {
    text.bytes().filter(|byte| *byte != 0).chain([0]).collect()
}

/// Returns the number of cells of a row.
fn cells_of(row: &MapRow) -> u64 {
    row.polygons.iter().map(|polygon| polygon.cells().len() as u64).sum()
}

struct Out<'a> {
    sink: &'a mut Sink,
}

impl Out<'_> {
    fn bytes(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.sink.write_all(bytes)
    }

    fn text(&mut self, text: &str) -> io::Result<()> {
        self.bytes(text.as_bytes())
    }

    /// Writes the length in front of an array.
    fn array(&mut self, bytes: u64) -> io::Result<()> {
        self.bytes(&bytes.to_le_bytes())
    }
}
