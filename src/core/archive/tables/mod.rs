//! Tables: rkyv columns inside blocks, by kind and schema id. In: a block, or columns. Out: columns
//! that hold only checked values, or a block's raw bytes. A layout that was released never changes:
//! a test of each table holds its bytes.

mod bands;
mod cells;
mod extents;
mod geometry;
mod index;
mod materials;
mod names;
mod objects;
mod optics;
mod overview;
mod parts;
mod receivers;

use std::fmt::Debug;

use crate::error::Error;

pub use bands::BandsTable;
pub use cells::{CellsTable, pack_tag, unpack_tag};
pub use extents::{ExtentsTable, TILES_A_CHUNK};
pub use geometry::{GeometryTable, MAX_TRIANGLES};
pub use index::IndexTable;
pub use materials::MaterialsTable;
pub use names::{NAMES_A_CHUNK, NameOf, NameRow, NamesTable};
pub use objects::{MAX_ATTRIBUTES, ObjectsTable};
pub use optics::{MirrorsTable, OpticsTable, VOLUME, kind_of_canopy};
pub use overview::{NORMAL_STEPS, OverviewTable};
pub use parts::PartsTable;
pub use receivers::ReceiversTable;

/// Error in a table's values.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Flaw {
    got: String,
    expected: String,
}

impl Flaw {
    fn new(got: impl Into<String>, expected: impl Into<String>) -> Self {
        Flaw { got: got.into(), expected: expected.into() }
    }

    /// Returns the error of a table that cannot be written.
    fn refuse(self, what: String) -> Error {
        Error::Unsupported { what: what.into(), found: self.got, supported: self.expected.into() }
    }
}

/// Checks a column's length and each of its values.
fn column<T: Debug>(name: &str, values: &[T], rows: usize, range: &str, good: impl Fn(&T) -> bool) -> Result<(), Flaw> {
    if values.len() != rows {
        return Err(Flaw::new(format!("column {name} of {} rows", values.len()), format!("{rows} rows")));
    }
    match values.iter().enumerate().find(|(_, value)| !good(value)) {
        None => Ok(()),
        Some((row, value)) => {
            let value: String = format!("{value:?}").chars().take(80).collect();
            Err(Flaw::new(format!("{name} {value} in row {row}"), range))
        }
    }
}

/// Checks a column of a fixed number of values (at least one) for each row.
fn flat_column(name: &str, length: usize, rows: usize) -> Result<(), Flaw> {
    match length.checked_rem(rows) {
        Some(0) if length > 0 => Ok(()),
        _ => Err(Flaw::new(format!("column {name} of {length} values"), format!("an equal number for {rows} rows"))),
    }
}

/// Returns true if a vector's length lies in a range that is widened by 1e-6; false for NaN.
fn length_in(vector: [f64; 3], low: f64, high: f64) -> bool {
    let [x, y, z] = vector;
    (low - 1e-6..=high + 1e-6).contains(&(x * x + y * y + z * z).sqrt())
}

/// Returns true if a value is a share of a whole, 0 to 1; false for NaN.
fn is_share(value: f64) -> bool {
    (0.0..=1.0).contains(&value)
}

/// Implements the conversion between a table and blocks of its kinds, for a type with `rows` and
/// `check`.
macro_rules! table {
    ($name:ident, $kinds:expr) => {
        impl $name {
            /// Kinds of the table's blocks.
            pub const KINDS: &'static [crate::archive::format::BlockKind] = &$kinds;

            /// Returns the raw bytes of a block, if all values are in range.
            pub fn to_bytes(&self) -> crate::error::Result<Vec<u8>> {
                let what = format!("writing a table of {}", stringify!($name).trim_end_matches("Table").to_lowercase());
                let refuse = |flaw: crate::archive::tables::Flaw| flaw.refuse(what);
                if let Err(flaw) = self.check() {
                    return Err(refuse(flaw));
                }
                match rkyv::to_bytes::<rkyv::rancor::Error>(self) {
                    Ok(bytes) => Ok(bytes.to_vec()),
                    Err(e) => {
                        Err(refuse(crate::archive::tables::Flaw::new(e.to_string(), "a table that fits a block")))
                    }
                }
            }

            /// Returns a block of one of the table's kinds, ready to be written.
            #[cfg(feature = "zstd")]
            pub fn encode(
                &self,
                kind: crate::archive::format::BlockKind,
                tile: crate::archive::format::TileNumber,
                level: i32,
            ) -> crate::error::Result<crate::archive::EncodedBlock> {
                if !Self::KINDS.contains(&kind) {
                    let (got, expected) = (crate::archive::format::kind_name(kind), "the table's own kind");
                    return Err(crate::archive::tables::Flaw::new(got, expected).refuse("writing a table".to_string()));
                }
                let raw = self.to_bytes()?;
                let schema = crate::archive::format::schema_of(kind).unwrap_or(0);
                // Columns of 2^32 rows do not fit a block: `encode` refuses the raw bytes.
                let items = u32::try_from(self.rows()).unwrap_or(u32::MAX);
                crate::archive::encode(kind, tile, schema, items, &raw, level)
            }

            /// Returns the table of a block, all values checked.
            pub fn from_block(block: &crate::archive::Block) -> crate::error::Result<Self> {
                block.require(Self::KINDS)?;
                let name = || format!("a table of {}", crate::archive::format::kind_name(block.entry().kind));
                let no_table = |_: rkyv::rancor::Error| block.corrupt("bytes that are no table", name());
                let archived =
                    rkyv::access::<rkyv::Archived<Self>, rkyv::rancor::Error>(block.bytes()).map_err(no_table)?;
                let table: Self = rkyv::deserialize::<Self, rkyv::rancor::Error>(archived).map_err(no_table)?;
                if u32::try_from(table.rows()).ok() != Some(block.items()) {
                    let (got, expected) = (table.rows(), block.items());
                    return Err(block.corrupt(format!("{got} rows"), format!("{expected}, as in the directory")));
                }
                table.check().map_err(|flaw| block.corrupt(flaw.got, flaw.expected))?;
                Ok(table)
            }
        }
    };
}
use table;

/// Helpers for the tests of all tables.
#[cfg(all(test, feature = "zstd"))]
mod tests {
    use std::path::Path;

    use crate::archive::codec::block;
    use crate::archive::{Block, EncodedBlock, format};
    use crate::error::Result;

    /// Returns a block as a reader gets it.
    pub fn block(encoded: &EncodedBlock) -> Block {
        block::decode(&Path::new("site.helio").into(), encoded.entry(), &encoded.stored).unwrap()
    }

    /// Reads every single-bit change of raw bytes, with right checksums, and a cut of every length.
    /// Returns the numbers (refused, accepted).
    pub fn hostile<T>(
        kind: format::BlockKind,
        items: u32,
        raw: &[u8],
        read: impl Fn(&Block) -> Result<T>,
    ) -> (usize, usize) {
        let schema = format::schema_of(kind).unwrap();
        let flips = (0..raw.len() * 8).map(|bit| {
            let mut bytes = raw.to_vec();
            bytes[bit / 8] ^= 1 << (bit % 8);
            bytes
        });
        let cuts = (1..raw.len()).map(|length| raw[..length].to_vec());
        let (mut refused, mut accepted) = (0, 0);
        for bytes in flips.chain(cuts) {
            match read(&block(&crate::archive::encode(kind, format::TileNumber(0), schema, items, &bytes, 1).unwrap()))
            {
                Ok(_) => accepted += 1,
                Err(_) => refused += 1,
            }
        }
        (refused, accepted)
    }
}
