//! Receivers of any number, tile by tile. In: a `receivers.csv` of any length. Out: its receivers
//! in tiles along the Morton curve, from bounded memory.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use glam::DVec3;

use heliotile_core::archive::{Archive, tables};
use heliotile_core::error::{Error, Result};
use heliotile_core::site::content::ContentHasher;
use heliotile_core::site::model_part::ModelPart;
use heliotile_core::site::morton::{morton_key, receiver_of_key};
use heliotile_core::site::patch::Patch;
use heliotile_core::site::receiver::{Receiver, TILE};
use heliotile_core::text::excerpt;
use heliotile_files::spill::{Sorted, Sorter, damaged, number_of};
use heliotile_scene::points::receivers::{ReceiverRows, duplicate, no_receivers};

/// Receivers in Morton order, in temporary files if they exceed the memory budget.
pub struct ReceiverTiles {
    sorted: Sorted,
    folder: PathBuf,
    count: usize,
    content_hash: [u8; 32],
    farthest: Option<Receiver>,
    bounds: [DVec3; 2],
}

impl ReceiverTiles {
    /// Reads rows as [`read_receivers`](heliotile_scene::points::receivers::read_receivers) does,
    /// and sorts their receivers around `origin`. Temporary files go to `folder` if `budget_bytes`
    /// do not suffice.
    pub fn open(mut rows: ReceiverRows, origin: DVec3, folder: &Path, budget_bytes: usize) -> Result<Self> {
        let path = rows.file();
        let mut by_place = Sorter::new(folder, budget_bytes / 2);
        let mut by_id = Sorter::new(folder, budget_bytes / 2);
        let end = loop {
            match rows.read() {
                Ok(Some(receiver)) => {
                    by_id.push(receiver.id.as_bytes(), &(rows.line() as u64).to_le_bytes())?;
                    push(&mut by_place, &receiver)?;
                }
                Ok(None) => break Ok(()),
                Err(error) => break Err(error),
            }
        };
        // The error of a duplicate name comes before the error of an unreadable row, because its
        // rows come first in the file.
        if let Some(twice) = first_duplicate(by_id.finish()?, folder)? {
            return Err(duplicate(path, &twice.id, twice.first_line, twice.line));
        }
        end?;
        let tiles = ReceiverTiles::of_sorted(by_place.finish()?, origin, folder)?;
        if tiles.count == 0 { Err(no_receivers(path)) } else { Ok(tiles) }
    }

    /// Returns how the receivers differ from those of an archive, or `None` if their number and
    /// every readable tile are equal.
    pub fn difference(&mut self, archive: &Archive) -> Result<Option<String>> {
        let (found, expected) = (self.count() as u64, archive.manifest().receivers.count);
        if found != expected {
            return Ok(Some(format!("holds {found} receivers, the archive {expected}")));
        }
        for (tile, given) in self.tiles()?.enumerate() {
            let (mut given, tile) = (given?, tile as u32);
            let Ok(mut held) = tables::PartsTable::receivers(archive, tile) else { continue };
            // Patches are not compared if the archive has no overview or a damaged one.
            if !tables::OverviewTable::join(archive, tile, &mut held).unwrap_or(false) {
                given.iter_mut().for_each(|receiver| receiver.patch = Patch::default());
            }
            if given != held {
                return Ok(Some(format!("holds other receivers than tile {tile} of the archive")));
            }
        }
        Ok(None)
    }

    /// Sorts receivers that are in memory into tiles. Errors: no receiver, a number that is not
    /// finite, a normal that is none, a name that is empty or there twice.
    pub fn checked(receivers: &[Receiver], origin: DVec3, folder: &Path, budget_bytes: usize) -> Result<Self> {
        if receivers.is_empty() {
            return Err(Error::argument("receivers", "there are none", "give at least one"));
        }
        let mut names = HashSet::new();
        for (row, Receiver { id, position, normal, .. }) in receivers.iter().enumerate() {
            let refuse = |what: &str| {
                let hint = "give metres, a unit normal, and a name of its own for each receiver";
                Err(Error::argument("receivers", format!("receiver {row} (`{}`) {what}", excerpt(id, 80)), hint))
            };
            if !position.is_finite() || !normal.is_finite() {
                return refuse("has a number that is not finite");
            }
            if !normal.is_normalized() {
                return refuse("has a normal whose length is not 1");
            }
            if id.is_empty() || !names.insert(id) {
                return refuse("has no name of its own");
            }
        }
        ReceiverTiles::from_receivers(receivers, origin, folder, budget_bytes)
    }

    /// Sorts receivers that are in memory into tiles. Names are not checked for duplicates.
    pub fn from_receivers(receivers: &[Receiver], origin: DVec3, folder: &Path, budget_bytes: usize) -> Result<Self> {
        let mut by_place = Sorter::new(folder, budget_bytes);
        receivers.iter().try_for_each(|receiver| push(&mut by_place, receiver))?;
        ReceiverTiles::of_sorted(by_place.finish()?, origin, folder)
    }

    fn of_sorted(sorted: Sorted, origin: DVec3, folder: &Path) -> Result<Self> {
        // One pass over the sorted records collects count, hash and bounds, so that memory stays
        // bounded.
        let mut bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let folder = folder.to_owned();
        let mut tiles = ReceiverTiles { sorted, folder, count: 0, content_hash: [0; 32], farthest: None, bounds };
        let mut content = ContentHasher::new("heliotile receivers 1");
        let (mut count, mut farthest, mut largest_m) = (0, None, -1.0);
        for tile in tiles.tiles()? {
            for receiver in tile? {
                count += 1;
                add(&mut content, &receiver);
                bounds = [bounds[0].min(receiver.position), bounds[1].max(receiver.position)];
                let offset_m = (receiver.position - origin).abs().max_element();
                if offset_m > largest_m {
                    (farthest, largest_m) = (Some(receiver), offset_m);
                }
            }
        }
        content.length(count);
        Ok(ReceiverTiles { count, content_hash: content.finish(), farthest, bounds, ..tiles })
    }

    /// Number of receivers.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Number of tiles.
    pub fn tile_count(&self) -> usize {
        self.count.div_ceil(TILE)
    }

    /// Returns the BLAKE3 hash of all columns of the receivers in Morton order. The order of the
    /// file does not matter.
    pub fn content_hash(&self) -> [u8; 32] {
        self.content_hash
    }

    /// Returns the receiver with the largest coordinate relative to the origin, the first of
    /// several; `None` if there are no receivers.
    pub fn farthest(&self) -> Option<&Receiver> {
        self.farthest.as_ref()
    }

    /// Returns the lowest and highest coordinates of all receivers.
    pub fn bounds(&self) -> [DVec3; 2] {
        self.bounds
    }

    /// Returns the tiles in order, [`TILE`] receivers each and fewer in the last one. Every call
    /// begins with the first tile.
    pub fn tiles(&mut self) -> Result<Tiles<'_>> {
        self.sorted.rewind()?;
        Ok(Tiles { sorted: &mut self.sorted, folder: &self.folder })
    }
}

/// Iterator over the tiles of receivers, in order.
pub struct Tiles<'a> {
    sorted: &'a mut Sorted,
    folder: &'a Path,
}

impl Iterator for Tiles<'_> {
    type Item = Result<Vec<Receiver>>;

    fn next(&mut self) -> Option<Self::Item> {
        let folder = self.folder;
        let receiver = |(key, payload): (Vec<u8>, Vec<u8>)| pull(&key, &payload).ok_or_else(|| damaged(folder));
        let tile: Result<Vec<Receiver>> =
            self.sorted.by_ref().take(TILE).map(|record| record.and_then(receiver)).collect();
        match tile {
            Ok(tile) if tile.is_empty() => None,
            tile => Some(tile),
        }
    }
}

fn push(sorter: &mut Sorter, receiver: &Receiver) -> Result<()> {
    // 0 and the empty text stand for `None`: areas are above 0 and names of surfaces are not empty.
    let mut payload = receiver.area.unwrap_or_default().to_le_bytes().to_vec();
    let patch = receiver.patch.to_string();
    let texts = [receiver.surface.as_deref().unwrap_or_default(), &patch].into_iter().chain(receiver.part.texts());
    for text in texts {
        payload.extend_from_slice(&(text.len() as u32).to_le_bytes());
        payload.extend_from_slice(text.as_bytes());
    }
    sorter.push(&morton_key(receiver), &payload)
}

fn pull(key: &[u8], payload: &[u8]) -> Option<Receiver> {
    let (area, mut rest) = payload.split_first_chunk()?;
    let area = Some(f64::from_le_bytes(*area)).filter(|area| *area != 0.0);
    let mut text = || {
        let (length, behind) = rest.split_first_chunk()?;
        let (text, behind) = behind.split_at_checked(u32::from_le_bytes(*length) as usize)?;
        rest = behind;
        String::from_utf8(text.to_vec()).ok()
    };
    let surface = Some(text()?).filter(|name| !name.is_empty());
    let patch = text()?.parse().ok()?;
    let part = ModelPart::of_texts([text()?, text()?, text()?, text()?, text()?]);
    Some(Receiver { area, surface, part, patch, ..receiver_of_key(key)? })
}

fn add(content: &mut ContentHasher, receiver: &Receiver) {
    content.bytes(receiver.id.as_bytes());
    content.point(&receiver.position);
    content.point(&receiver.normal);
    content.number(receiver.area.unwrap_or_default());
    content.bytes(receiver.surface.as_deref().unwrap_or_default().as_bytes());
    if !receiver.part.is_empty() {
        content.raw(b"part");
        receiver.part.texts().iter().for_each(|text| content.bytes(text.as_bytes()));
    }
    if !receiver.patch.is_empty() {
        content.raw(b"patch");
        content.bytes(receiver.patch.to_string().as_bytes());
    }
}

/// Name that two rows have in common.
struct Twice {
    id: String,
    first_line: usize,
    line: usize,
}

/// Returns the repetition that comes first in the file.
fn first_duplicate(lines_by_id: Sorted, folder: &Path) -> Result<Option<Twice>> {
    let mut found: Option<Twice> = None;
    let mut previous: Option<(Vec<u8>, usize)> = None;
    for record in lines_by_id {
        let (id, payload) = record?;
        let line = number_of(&payload, folder)? as usize;
        match &previous {
            // Rows of equal names keep the order of the file, so this is the second or a later one.
            Some((same, first_line)) if *same == id => {
                if found.as_ref().is_none_or(|twice| line < twice.line) {
                    let id = String::from_utf8_lossy(&id).into_owned();
                    found = Some(Twice { id, first_line: *first_line, line });
                }
            }
            _ => previous = Some((id, line)),
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use heliotile_core::site::morton::morton_order;
    use heliotile_core::site::north::North;
    use heliotile_scene::points::receivers::read_receivers_with_warnings;

    const ORIGIN: DVec3 = DVec3::new(78_002.0, 457_002.0, 1.0);

    struct Folder(tempfile::TempDir);

    impl Folder {
        fn with(text: &str) -> (Self, PathBuf) {
            let folder = Folder(tempfile::tempdir().expect("a scratch folder"));
            let path = folder.0.path().join("receivers.csv");
            fs::write(&path, text).expect("written");
            (folder, path)
        }

        fn open(&self, path: &Path, budget: usize) -> Result<(ReceiverTiles, Vec<String>)> {
            let mut warnings = Vec::new();
            let rows = ReceiverRows::open(path, North::default(), &mut warnings)?;
            Ok((
                ReceiverTiles::open(rows, ORIGIN, self.0.path(), budget)?,
                warnings.iter().map(|said| said.plain()).collect(),
            ))
        }
    }

    fn rows(count: u32) -> Vec<String> {
        (0..count)
            .map(|i| {
                let scatter = |k: u32| f64::from(i / 2 * k % 997) * 0.31;
                let (x, y, z) = (78_000.0 + scatter(7), 457_000.0 + scatter(11), scatter(13));
                let area = if i % 3 == 0 { format!("{}.5", i % 7) } else { String::new() };
                let surface = if i % 5 == 0 { "\"roof, left\"" } else { "" };
                format!("r{i},{x},{y},{z},0,{},1,{area},{surface},x", i % 2)
            })
            .collect()
    }

    fn file(rows: &[String]) -> String {
        format!("receiver,x,y,z,nx,ny,nz,area,surface,note\n{}\n", rows.join("\n"))
    }

    fn all(tiles: &mut ReceiverTiles) -> Vec<Vec<Receiver>> {
        tiles.tiles().expect("rewound").collect::<Result<_>>().expect("readable")
    }

    /// Reading 20,000 receivers with 128 KiB gives the same 313 tiles as reading them in memory,
    /// twice. 64 MiB, receivers from memory and a file in reverse order give the same tiles and the
    /// same hash. Each of 4 changes of a receiver changes the hash.
    #[test]
    fn tiles_equal_those_of_reading_in_memory() {
        let mut rows = rows(20_000);
        let (folder, path) = Folder::with(&file(&rows));
        let mut plain_warnings = Vec::new();
        let receivers = read_receivers_with_warnings(&path, North::default(), &mut plain_warnings).expect("readable");
        let order = morton_order(&receivers);
        let plain: Vec<Vec<Receiver>> =
            order.chunks(TILE).map(|tile| tile.iter().map(|&i| receivers[i].clone()).collect()).collect();
        let (mut tiles, warnings) = folder.open(&path, 128 << 10).expect("readable");
        assert_eq!(warnings, plain_warnings.iter().map(|said| said.plain()).collect::<Vec<_>>());
        assert_eq!((tiles.count(), tiles.tile_count()), (20_000, 313));
        tiles.tiles().expect("rewound").next().expect("a tile").expect("readable");
        assert!(all(&mut tiles) == plain && all(&mut tiles) == plain);
        let offset = |r: &Receiver| (r.position - ORIGIN).abs().max_element();
        let farthest = receivers.iter().map(offset).fold(0.0, f64::max);
        assert_eq!(tiles.farthest().map(offset), Some(farthest));

        let mut others = vec![folder.open(&path, 64 << 20).expect("readable").0];
        others.push(ReceiverTiles::from_receivers(&receivers, ORIGIN, folder.0.path(), 0).expect("sorted"));
        rows.reverse();
        let (reversed, path) = Folder::with(&file(&rows));
        others.push(reversed.open(&path, 128 << 10).expect("readable").0);
        for mut other in others {
            assert!(all(&mut other) == plain);
            assert_eq!((other.content_hash(), other.farthest()), (tiles.content_hash(), tiles.farthest()));
        }
        let text = file(&rows);
        for (old, new) in [("r77,", "r77b,"), ("roof, left", "roof, right"), ("6.5,", "6.25,"), (",0,1,1,", ",0,2,1,")]
        {
            assert!(text.contains(old), "{old}");
            let (folder, path) = Folder::with(&text.replacen(old, new, 1));
            let (other, _) = folder.open(&path, 1 << 20).expect("readable");
            assert_ne!(other.content_hash(), tiles.content_hash(), "{old}");
        }
    }

    /// Nine broken files, among them duplicates before and after broken rows, are refused with the
    /// messages of the reader that works in memory.
    #[test]
    fn broken_files_are_refused_as_in_memory() {
        let good = rows(4_000);
        let with = |changes: &[(usize, &str)]| {
            let mut rows = good.clone();
            changes.iter().for_each(|(i, row)| rows[*i] = (*row).to_owned());
            file(&rows)
        };
        let (twice, again) = ("r7,0,0,0,0,0,1,,,", "r900,0,0,0,0,0,1,,,");
        for (text, line) in [
            (
                with(&[(3_000, twice), (2_500, again)]),
                "line 2502: column `receiver` is `r900`, the name of the receiver in line 902",
            ),
            (
                with(&[(3_000, twice), (2_999, twice)]),
                "line 3001: column `receiver` is `r7`, the name of the receiver in line 9",
            ),
            (with(&[(3_000, again), (2_999, "a,b")]), "line 3001: the row `a,b` has 2 cells"),
            (with(&[(3_000, again), (3_001, "a,b")]), "line 3002: column `receiver` is `r900`"),
            (with(&[(3, "\n\nb,nan,0,0,0,0,1,,,")]), "line 7: column `x` is `nan`"),
            (with(&[(3_999, "b,0,0,0,0,0,0,,,")]), "line 4001: column `nx,ny,nz`"),
            (file(&[]), "no receivers"),
            (String::new(), "the file is empty"),
            ("receiver,x\n".to_owned(), "line 1: column `y` is missing"),
        ] {
            let (folder, path) = Folder::with(&text);
            let message = folder.open(&path, 128 << 10).err().expect("refused").to_string();
            let plain = read_receivers_with_warnings(&path, North::default(), &mut Vec::new())
                .expect_err("refused")
                .to_string();
            assert_eq!(message, plain);
            assert!(message.contains(line), "{message}");
        }
        let nowhere = Path::new("/nowhere/receivers.csv");
        let refused = ReceiverRows::open(nowhere, North::default(), &mut Vec::new());
        let message = refused.err().expect("no file").to_string();
        assert!(message.starts_with("cannot read /nowhere/receivers.csv: "), "{message}");
    }

    /// A byte order mark, CRLF and quoted line ends are counted as the reader that works in memory
    /// counts them: the error is in line 6.
    #[test]
    fn errors_name_the_line_of_the_file() {
        let text = "\u{feff}receiver,x,y,z,nx,ny,nz\r\n\"a\r\nb\",0,0,0,0,0,1\r\n\r\nc,0,0,0,0,0,1\r\nc,0,0,0,0,0,1";
        let (folder, path) = Folder::with(text);
        let message = folder.open(&path, 0).err().expect("refused").to_string();
        assert!(message.contains("line 6: column `receiver` is `c`, the name of the receiver in line 5"), "{message}");
    }
}
