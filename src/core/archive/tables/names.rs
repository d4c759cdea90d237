//! Names in order, with the tiles that hold them, by which a reader finds receivers by name. In:
//! rows. Out: a table, and back.

use rkyv::{Archive, Deserialize, Serialize};

use crate::archive::format::{MAX_STRING, NAMES};
use crate::archive::tables::{Flaw, column, table};
use crate::site::receiver::Receiver;

/// Kind of thing that a name belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum NameOf {
    /// A receiver, by its id.
    Receiver = 0,
    /// A surface.
    Surface = 1,
    /// An object of the model.
    Object = 2,
    /// A building of the model.
    Building = 3,
}

impl NameOf {
    /// All kinds, in the order of their numbers.
    pub const ALL: [NameOf; 4] = [NameOf::Receiver, NameOf::Surface, NameOf::Object, NameOf::Building];

    /// Returns the names of a receiver; an empty name is not given.
    pub fn names(receiver: &Receiver) -> [(NameOf, &str); 4] {
        [
            (NameOf::Receiver, &receiver.id),
            (NameOf::Surface, receiver.surface.as_deref().unwrap_or_default()),
            (NameOf::Object, &receiver.part.object),
            (NameOf::Building, &receiver.part.building),
        ]
    }
}

/// A name, and a tile that holds it. In chunk 0 it is the first name of a chunk, and the number of
/// that chunk.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct NameRow {
    /// Kind of thing that the name belongs to.
    pub of: NameOf,
    /// The name, 1 to 1024 bytes.
    pub name: String,
    /// Number of the tile, or of the chunk.
    pub tile: u32,
}

/// Table of names in strictly ascending order of (kind, bytes of the name, tile), schema 1. A row
/// stores only the bytes that differ from the beginning of the name before.
#[derive(Clone, Debug, Default, PartialEq, Archive, Serialize, Deserialize)]
pub struct NamesTable {
    /// Kind: 0 receiver, 1 surface, 2 object, 3 building.
    pub of: Vec<u8>,
    /// Number of first bytes that the name shares with the name of the row before; 0 in row 0.
    pub shared: Vec<u16>,
    /// Number of the name's other bytes.
    pub own: Vec<u16>,
    /// The other bytes of all names, row by row.
    pub text: Vec<u8>,
    /// Number of the tile, or of the chunk.
    pub tile: Vec<u32>,
}

table!(NamesTable, [NAMES]);

/// Number of rows of a chunk; the last chunk may have fewer.
pub const NAMES_A_CHUNK: usize = 2048;

impl NamesTable {
    /// Returns the table of rows, which must be in order.
    pub fn new(rows: &[NameRow]) -> Self {
        let mut table = NamesTable::default();
        let mut before: &[u8] = &[];
        for NameRow { of, name, tile } in rows {
            let name = name.as_bytes();
            let shared = before.iter().zip(name).take_while(|(a, b)| a == b).count();
            let own = name.get(shared..).unwrap_or_default();
            // A name that is too long is refused when the table is written.
            let length = |bytes: usize| u16::try_from(bytes).unwrap_or(u16::MAX);
            table.of.push(*of as u8);
            table.shared.push(length(shared));
            table.own.push(length(own.len()));
            table.text.extend_from_slice(own);
            table.tile.push(*tile);
            before = name;
        }
        table
    }

    /// Returns the rows.
    pub fn names(&self) -> Vec<NameRow> {
        // The table was checked when it was read or written.
        self.decoded().unwrap_or_default()
    }

    /// Returns the number of rows.
    pub fn rows(&self) -> usize {
        self.of.len()
    }

    fn check(&self) -> Result<(), Flaw> {
        self.decoded().map(|_| ())
    }

    fn decoded(&self) -> Result<Vec<NameRow>, Flaw> {
        let rows = self.rows();
        if rows == 0 {
            return Err(Flaw::new("0 names", "at least 1"));
        }
        column("shared", &self.shared, rows, "0 to 1024 bytes", |n| usize::from(*n) <= MAX_STRING)?;
        column("own", &self.own, rows, "0 to 1024 bytes", |n| usize::from(*n) <= MAX_STRING)?;
        column("tile", &self.tile, rows, "a number", |_| true)?;
        let (mut name, mut text): (Vec<u8>, &[u8]) = (Vec::new(), &self.text);
        let mut names: Vec<NameRow> = Vec::with_capacity(rows);
        let lengths = self.shared.iter().zip(&self.own);
        for (row, ((&of, (&shared, &own)), &tile)) in self.of.iter().zip(lengths).zip(&self.tile).enumerate() {
            let flaw = |got: &str, expected: &str| Flaw::new(format!("{got} in row {row}"), expected);
            let of = NameOf::ALL.get(usize::from(of)).ok_or_else(|| flaw("a name of an unknown kind", "0 to 3"))?;
            let (here, rest) = text
                .split_at_checked(usize::from(own))
                .ok_or_else(|| flaw("a name beyond the text", "text for all names"))?;
            if usize::from(shared) > name.len() {
                return Err(flaw("more shared bytes than there are", "at most the bytes of the name before"));
            }
            name.truncate(usize::from(shared));
            name.extend_from_slice(here);
            text = rest;
            if name.is_empty() || name.len() > MAX_STRING {
                return Err(flaw("a name of a wrong length", "1 to 1024 bytes"));
            }
            let utf8 = std::str::from_utf8(&name).map_err(|_| flaw("a name that is no UTF-8", "text"))?;
            let found = NameRow { of: *of, name: utf8.to_owned(), tile };
            // Look-ups bisect the rows, so they must ascend strictly.
            if names.last().is_some_and(|last| *last >= found) {
                return Err(flaw("a name out of order", "names in order"));
            }
            names.push(found);
        }
        if text.is_empty() {
            Ok(names)
        } else {
            Err(Flaw::new(format!("{} bytes that belong to no name", text.len()), "none"))
        }
    }
}

#[cfg(all(test, feature = "zstd"))]
mod tests {
    use super::*;
    use crate::archive::format;
    use crate::archive::format::TileNumber;
    use crate::archive::tables::tests::{block, hostile};

    fn row(of: NameOf, name: &str, tile: u32) -> NameRow {
        NameRow { of, name: name.to_owned(), tile }
    }

    fn five() -> Vec<NameRow> {
        vec![
            row(NameOf::Receiver, "house/r1", 0),
            row(NameOf::Receiver, "house/r2", 0),
            row(NameOf::Surface, "Dach", 0),
            row(NameOf::Surface, "Dach", 7),
            row(NameOf::Building, "Häuser", 7),
        ]
    }

    /// Five names have the known bytes and come back. A row stores only the bytes after the shared
    /// ones: 20 bytes of 31. No change of a bit and no cut ends the program.
    #[test]
    fn layout_is_frozen() {
        let table = NamesTable::new(&five());
        let raw = table.to_bytes().unwrap();
        assert_eq!((raw.len(), format::hex(&format::checksum(&raw))), (108, "dd09b2f7461cbcf8".to_string()));
        assert_eq!((table.text.len(), &table.shared[..]), (20, &[0, 7, 0, 4, 0][..]));
        let back = NamesTable::from_block(&block(&table.encode(NAMES, TileNumber(1), 9).unwrap())).unwrap();
        assert_eq!(back.names(), five());
        let (refused, accepted) = hostile(NAMES, 5, &raw, |block| NamesTable::from_block(block).map(|_| ()));
        assert!(refused > accepted && accepted > 0, "{refused} {accepted}");
    }

    /// Each of 9 invalid tables is refused.
    #[test]
    fn ranges_are_checked() {
        let flaws: [fn(&mut NamesTable); 9] = [
            |t| t.of[4] = 4,
            |t| t.shared[0] = 1,
            |t| t.own[4] = 8,
            |t| t.text.push(b'x'),
            |t| t.text[19] = 0xff,
            |t| t.tile[3] = 0,
            |t| t.of[2] = 0,
            |t| t.tile.truncate(4),
            |t| *t = NamesTable::default(),
        ];
        for (number, flaw) in flaws.iter().enumerate() {
            let mut wrong = NamesTable::new(&five());
            flaw(&mut wrong);
            assert!(wrong.to_bytes().is_err(), "{number}");
        }
        assert!(NamesTable::new(&[row(NameOf::Object, &"x".repeat(1025), 0)]).to_bytes().is_err());
    }
}
