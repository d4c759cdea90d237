//! Shapes of the receivers of one tile, which a viewer draws before it reads anything else. In:
//! columns. Out: a table, and back.

use glam::DVec3;
use rkyv::{Archive, Deserialize, Serialize};

use crate::archive::Blocks;
use crate::archive::format::{MAX_TILE_RECEIVERS, OVERVIEW, TileNumber};
use crate::archive::tables::{Flaw, column, table};
use crate::error;
use crate::site::patch::{MAX_OFFSET_MM, Offset, Patch};
use crate::site::receiver::Receiver;

/// Table of one tile, schema 1, row by row as its receivers.
#[derive(Clone, Debug, Default, PartialEq, Archive, Serialize, Deserialize)]
pub struct OverviewTable {
    /// Positions relative to the scene's origin, metres.
    pub position: Vec<[f32; 3]>,
    /// Unit normals times 32,767.
    pub normal: Vec<[i16; 3]>,
    /// Areas, m2; 0 is "not given".
    pub area: Vec<f32>,
    /// Cosine-weighted share of the hemisphere that sees sky, times 255.
    pub sky_view: Vec<u8>,
    /// Sums over the clear year of the site's place (`weather::clear`), kWh/m2; empty where the
    /// place is not known.
    pub clear_year: Vec<f32>,
    /// Number of polygons of each receiver's patch; 0 is "not given".
    pub polygons: Vec<u8>,
    /// Number of corners of each polygon, receiver by receiver.
    pub corners: Vec<u8>,
    /// Offsets of the corners from the receiver, mm, polygon by polygon.
    pub offset: Vec<Offset>,
}

table!(OverviewTable, [OVERVIEW]);

/// Steps that normals of length 1 are written in.
pub const NORMAL_STEPS: f64 = i16::MAX as f64;

impl OverviewTable {
    /// Returns the overview of a tile of `receivers` receivers; `None` if the archive has none.
    pub fn of_tile(blocks: &dyn Blocks, tile: u32, receivers: usize) -> error::Result<Option<Self>> {
        if !blocks.has(OVERVIEW, TileNumber(tile)) {
            return Ok(None);
        }
        let block = blocks.block(OVERVIEW, TileNumber(tile))?;
        let table = OverviewTable::from_block(&block)?;
        if table.rows() != receivers {
            return Err(block.corrupt(format!("{} rows", table.rows()), format!("{receivers} receivers")));
        }
        Ok(Some(table))
    }

    /// Gives the receivers of a tile their patches. Returns true if the archive has an overview of
    /// the tile.
    pub fn join(blocks: &dyn Blocks, tile: u32, receivers: &mut [Receiver]) -> error::Result<bool> {
        let Some(overview) = OverviewTable::of_tile(blocks, tile, receivers.len())? else { return Ok(false) };
        receivers.iter_mut().zip(overview.patches()).for_each(|(receiver, patch)| receiver.patch = patch);
        Ok(true)
    }

    /// Returns the number of receivers.
    pub fn rows(&self) -> usize {
        self.position.len()
    }

    /// Iterates over the normals of the receivers.
    pub fn normals(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.normal.iter().map(|steps| DVec3::from(steps.map(f64::from)).normalize_or_zero())
    }

    /// Iterates over the sky view factors of the receivers.
    pub fn sky_views(&self) -> impl Iterator<Item = f32> + '_ {
        self.sky_view.iter().map(|steps| f32::from(*steps) / 255.0)
    }

    /// Returns the patches of the receivers; empty where they are unknown.
    pub fn patches(&self) -> Vec<Patch> {
        let (mut corners, mut offsets) = (self.corners.iter(), self.offset.iter().copied());
        let mut polygon = || offsets.by_ref().take(corners.next().copied().unwrap_or_default().into()).collect();
        let of_row = |count: &u8| Patch::new((0..*count).map(|_| polygon()).collect()).unwrap_or_default();
        self.polygons.iter().map(of_row).collect()
    }

    fn check(&self) -> Result<(), Flaw> {
        let rows = self.rows();
        if rows == 0 || rows as u64 > u64::from(MAX_TILE_RECEIVERS) {
            return Err(Flaw::new(format!("{rows} receivers"), format!("1 to {MAX_TILE_RECEIVERS} a tile")));
        }
        let near = |place: &[f32; 3]| place.iter().all(|x| f64::from(x.abs()) <= FARTHEST_M);
        column("position", &self.position, rows, "2e9 m from the origin at most", near)?;
        let unit = |normal: &[i16; 3]| {
            let length = normal.iter().map(|&x| f64::from(x).powi(2)).sum::<f64>().sqrt();
            (length - NORMAL_STEPS).abs() <= 2.0
        };
        column("normal", &self.normal, rows, "length 32,767 within 2", unit)?;
        column("area", &self.area, rows, "finite, 0 or more", |area| area.is_finite() && *area >= 0.0)?;
        column("sky_view", &self.sky_view, rows, "0 to 255", |_| true)?;
        if !self.clear_year.is_empty() {
            column("clear_year", &self.clear_year, rows, "finite, 0 or more", |sum| sum.is_finite() && *sum >= 0.0)?;
        }
        column("polygons", &self.polygons, rows, "0 to 255", |_| true)?;
        let polygons = self.polygons.iter().map(|&count| usize::from(count)).sum();
        column("corners", &self.corners, polygons, "3 corners or more", |count| *count >= 3)?;
        let corners = self.corners.iter().map(|&count| usize::from(count)).sum();
        let here = |offset: &Offset| offset.iter().all(|mm| mm.unsigned_abs() <= MAX_OFFSET_MM as u32);
        column("offset", &self.offset, corners, "2^30 mm at most", here)
    }
}

/// Largest distance of a receiver outside its scene, metres: two of the largest coordinates of
/// inputs.
const FARTHEST_M: f64 = 2e9;

#[cfg(all(test, feature = "zstd"))]
mod tests {
    use super::*;
    use crate::archive::format;
    use crate::archive::tables::tests::{block, hostile};

    fn two() -> OverviewTable {
        OverviewTable {
            position: vec![[0.5, 0.25, 1.5], [1.0, 0.0, 2.0]],
            normal: vec![[0, 0, 32_767], [19_660, -26_214, 0]],
            area: vec![1.0, 0.0],
            sky_view: vec![255, 64],
            clear_year: vec![1875.5, 902.0],
            polygons: vec![1, 0],
            corners: vec![4],
            offset: vec![[-500, -500, 0], [500, -500, 0], [500, 500, 0], [-500, 500, 0]],
        }
    }

    /// Known values have the known 172 bytes and come back with the patches that they stand for,
    /// one of them empty. None of more than 1,500 changes of a bit and cuts ends the program.
    #[test]
    fn layout_is_frozen() {
        let (known, raw) = (two(), two().to_bytes().unwrap());
        assert_eq!((raw.len(), format::hex(&format::checksum(&raw))), (172, "5c2f8a9be5b9fc6c".to_string()));
        let back = OverviewTable::from_block(&block(&known.encode(OVERVIEW, TileNumber::FIRST, 9).unwrap())).unwrap();
        let square = "-500 -500 0;500 -500 0;500 500 0;-500 500 0".parse().unwrap();
        assert_eq!((back.patches(), &back), (vec![square, Patch::default()], &known));
        let (refused, accepted) = hostile(OVERVIEW, 2, &raw, |block| OverviewTable::from_block(block).map(|_| ()));
        assert!(refused > 200 && refused + accepted > 1_500, "{refused} {accepted}");
    }

    /// Each of 8 values out of range is refused; a table without sums is not.
    #[test]
    fn ranges_are_checked() {
        let flaws: [fn(&mut OverviewTable); 8] = [
            |o| o.position[0][1] = f32::NAN,
            |o| o.normal[1][2] = 30_000,
            |o| o.area[0] = -1.0,
            |o| o.clear_year.truncate(1),
            |o| o.clear_year[1] = f32::INFINITY,
            |o| o.polygons[1] = 1,
            |o| o.corners[0] = 2,
            |o| o.offset[2][0] = i32::MIN,
        ];
        let refused = flaws.iter().filter(|flaw| {
            let mut wrong = two();
            flaw(&mut wrong);
            wrong.to_bytes().is_err()
        });
        assert_eq!(refused.count(), 8);
        assert!(OverviewTable { clear_year: Vec::new(), ..two() }.to_bytes().is_ok());
    }
}
