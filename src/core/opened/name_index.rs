//! Search for receivers. In: a site, names or a box. Out: the tiles that hold them, found without
//! reading the others.

use glam::DVec3;

use crate::archive::format;
use crate::archive::format::TileNumber;
use crate::archive::tables::{ExtentsTable, NameOf, NameRow, NamesTable, TILES_A_CHUNK};
use crate::error::Result;
use crate::opened::open_site::OpenSite;

/// Index of the names of a site's receivers, surfaces, objects and buildings, and of the tiles that
/// hold each. Names may be looked up in any order. In the order of the archive (the kind of name,
/// then bytes) every chunk is read once.
pub struct NameIndex<'a> {
    site: OpenSite<'a>,
    /// First row of every chunk, with the chunk's number in place of the tile's.
    firsts: Vec<NameRow>,
    /// Chunk that was read last.
    held: Option<(u32, Vec<NameRow>)>,
}

impl<'a> NameIndex<'a> {
    /// Returns the index of the names of a site.
    pub fn new(site: &OpenSite<'a>) -> Result<Self> {
        // A site without receivers has no names.
        let firsts = match site.receivers() {
            0 => Vec::new(),
            _ => NamesTable::from_block(&site.block(format::NAMES, TileNumber::FIRST)?)?.names(),
        };
        Ok(NameIndex { site: site.clone(), firsts, held: None })
    }

    /// Announces names that will be looked up soon: a remote then fetches their chunks together.
    pub fn expect<'n>(&self, names: impl IntoIterator<Item = (NameOf, &'n str)>) {
        let mut chunks: Vec<u32> = names.into_iter().flat_map(|(of, name)| self.chunks(of, name)).collect();
        chunks.dedup();
        self.site.expect(&[format::NAMES], chunks);
    }

    /// Returns the numbers of the tiles that hold a name, ascending; empty if nothing has the name.
    pub fn tiles(&mut self, of: NameOf, name: &str) -> Result<Vec<u32>> {
        let mut tiles = Vec::new();
        for chunk in self.chunks(of, name) {
            let rows = self.chunk(chunk)?;
            let from = rows.partition_point(|row| (row.of, row.name.as_str()) < (of, name));
            let found = rows.iter().skip(from).take_while(|row| row.of == of && row.name == name);
            tiles.extend(found.map(|row| row.tile));
        }
        let site = &self.site;
        match tiles.iter().find(|&&tile| tile >= site.tiles()) {
            None => Ok(tiles),
            Some(tile) => {
                let block = site.block(format::NAMES, TileNumber::FIRST)?;
                Err(block.corrupt(format!("{name} in tile {tile}"), format!("tiles below {}", site.tiles())))
            }
        }
    }

    /// Returns the numbers of the chunks that may hold a name.
    fn chunks(&self, of: NameOf, name: &str) -> Vec<u32> {
        // The name may begin behind the first row of the chunk before.
        let from = self.firsts.partition_point(|first| (first.of, first.name.as_str()) < (of, name)).saturating_sub(1);
        let behind = self.firsts.partition_point(|first| (first.of, first.name.as_str()) <= (of, name));
        self.firsts.get(from..behind).unwrap_or_default().iter().map(|first| first.tile).collect()
    }

    fn chunk(&mut self, number: u32) -> Result<&[NameRow]> {
        let held = match self.held.take() {
            Some(held) if held.0 == number => held,
            _ => (number, NamesTable::from_block(&self.site.block(format::NAMES, TileNumber(number))?)?.names()),
        };
        Ok(&self.held.insert(held).1)
    }
}

/// Returns the numbers of the tiles whose receivers' boxes meet a box, its faces included,
/// ascending; input coordinates, metres.
pub fn tiles_within(site: &OpenSite, [low, high]: [DVec3; 2]) -> Result<Vec<u32>> {
    let chunks = (site.tiles() as usize).div_ceil(TILES_A_CHUNK) as u32;
    site.expect(&[format::EXTENTS], 0..chunks);
    let mut tiles = Vec::new();
    for chunk in 0..chunks {
        let block = site.block(format::EXTENTS, TileNumber(chunk))?;
        let table = ExtentsTable::from_block(&block)?;
        let first = chunk * TILES_A_CHUNK as u32;
        let expected = (site.tiles() - first).min(TILES_A_CHUNK as u32);
        if table.rows() != expected as usize {
            return Err(block.corrupt(format!("{} tiles", table.rows()), format!("{expected}")));
        }
        let meets = |of: &[DVec3; 2]| of[0].cmple(high).all() && of[1].cmpge(low).all();
        tiles.extend((first..).zip(table.boxes()).filter(|(_, of)| meets(of)).map(|(tile, _)| tile));
    }
    Ok(tiles)
}
