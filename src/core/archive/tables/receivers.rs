//! The receivers of one tile. In: receivers and their view factors. Out: a table, and back.

use glam::DVec3;
use rkyv::{Archive, Deserialize, Serialize};

use crate::archive::format::{MAX_STRING, MAX_TILE_RECEIVERS, RECEIVERS};
use crate::archive::tables::{Flaw, column, is_share, length_in, table};
use crate::site::model_part::ModelPart;
use crate::site::patch::Patch;
use crate::site::receiver::Receiver;

/// Table of one tile, schema 1; a receiver keeps its row in every block of the tile.
#[derive(Clone, Debug, Default, PartialEq, Archive, Serialize, Deserialize)]
pub struct ReceiversTable {
    /// Ids of the receivers in the input.
    pub ids: Vec<String>,
    /// Positions in input coordinates, metres.
    pub position: Vec<[f64; 3]>,
    /// Unit normals.
    pub normal: Vec<[f64; 3]>,
    /// Areas, m2; 0 is "not given".
    pub area: Vec<f64>,
    /// Names of surfaces; empty is "not given".
    pub surface: Vec<String>,
    /// Cosine-weighted shares of the hemisphere that see sky.
    pub sky_view: Vec<f32>,
    /// Cosine-weighted shares of the hemisphere that see surfaces of class ground.
    pub ground_view: Vec<f32>,
    /// Cosine-weighted shares of the hemisphere that see other surfaces.
    pub obstruction_view: Vec<f32>,
}

table!(ReceiversTable, [RECEIVERS]);

impl ReceiversTable {
    /// Returns the table of receivers, each with the shares of its hemisphere: sky, ground,
    /// obstruction.
    pub fn new<'a>(rows: impl IntoIterator<Item = (&'a Receiver, [f32; 3])>) -> Self {
        let mut table = ReceiversTable::default();
        for (receiver, [sky, ground, obstruction]) in rows {
            table.ids.push(receiver.id.clone());
            table.position.push(receiver.position.to_array());
            table.normal.push(receiver.normal.to_array());
            table.area.push(receiver.area.unwrap_or(0.0));
            table.surface.push(receiver.surface.clone().unwrap_or_default());
            table.sky_view.push(sky);
            table.ground_view.push(ground);
            table.obstruction_view.push(obstruction);
        }
        table
    }

    /// Returns the receivers that were given to [`ReceiversTable::new`], without their parts of the
    /// model and their patches, which are in other blocks.
    pub fn receivers(&self) -> Vec<Receiver> {
        let places = self.position.iter().zip(&self.normal);
        let rest = self.area.iter().zip(&self.surface);
        let receiver = |((id, (&position, &normal)), (&area, surface)): ((&String, _), (_, &String))| Receiver {
            id: id.clone(),
            position: DVec3::from_array(position),
            normal: DVec3::from_array(normal),
            area: Some(area).filter(|area| *area > 0.0),
            surface: Some(surface.clone()).filter(|name| !name.is_empty()),
            part: ModelPart::default(),
            patch: Patch::default(),
        };
        self.ids.iter().zip(places).zip(rest).map(receiver).collect()
    }

    /// Iterates over the shares of the receivers' hemispheres: sky, ground, obstruction.
    pub fn views(&self) -> impl Iterator<Item = [f32; 3]> + '_ {
        let shares = self.sky_view.iter().zip(&self.ground_view).zip(&self.obstruction_view);
        shares.map(|((&sky, &ground), &obstruction)| [sky, ground, obstruction])
    }

    /// Returns the number of receivers.
    pub fn rows(&self) -> usize {
        self.ids.len()
    }

    fn check(&self) -> Result<(), Flaw> {
        let rows = self.rows();
        if rows == 0 || rows as u64 > u64::from(MAX_TILE_RECEIVERS) {
            return Err(Flaw::new(format!("{rows} receivers"), format!("1 to {MAX_TILE_RECEIVERS} a tile")));
        }
        let text = format!("0 to {MAX_STRING} bytes");
        column("ids", &self.ids, rows, "1 to 1024 bytes", |id| !id.is_empty() && id.len() <= MAX_STRING)?;
        column("position", &self.position, rows, "finite metres", |p| p.iter().all(|x| x.is_finite()))?;
        column("normal", &self.normal, rows, "length 1 within 1e-6", |n| length_in(*n, 1.0, 1.0))?;
        column("area", &self.area, rows, "finite, 0 or more", |a| a.is_finite() && *a >= 0.0)?;
        column("surface", &self.surface, rows, &text, |name| name.len() <= MAX_STRING)?;
        for (name, views) in [
            ("sky_view", &self.sky_view),
            ("ground_view", &self.ground_view),
            ("obstruction_view", &self.obstruction_view),
        ] {
            column(name, views, rows, "0 to 1", |view| is_share(f64::from(*view)))?;
        }
        Ok(())
    }
}

#[cfg(all(test, feature = "zstd"))]
mod tests {
    use super::*;
    use crate::archive::format::{BlockKind, TileNumber};
    use crate::archive::tables::tests::{block, hostile};
    use crate::archive::{encode, format};

    fn known() -> ReceiversTable {
        ReceiversTable {
            ids: vec!["r1".to_string(), "facade-south-0002".to_string()],
            position: vec![[85_000.5, 446_000.25, 1.5], [0.0, -1.0, 2.0]],
            normal: vec![[0.0, 0.0, 1.0], [0.6, -0.8, 0.0]],
            area: vec![0.0, 2.25],
            surface: vec![String::new(), "wall:1".to_string()],
            sky_view: vec![1.0, 0.25],
            ground_view: vec![0.0, 0.5],
            obstruction_view: vec![0.0, 0.125],
        }
    }

    /// The known value has the known 256 bytes, so the layout of schema 1 is unchanged. It reads
    /// back equal.
    #[test]
    fn layout_is_frozen() {
        let raw = known().to_bytes().unwrap();
        assert_eq!((raw.len(), format::hex(&format::checksum(&raw))), (256, "1f1296ef4af86e64".to_string()));
        let back =
            ReceiversTable::from_block(&block(&known().encode(RECEIVERS, TileNumber::FIRST, 9).unwrap())).unwrap();
        assert_eq!(back, known());
    }

    /// Two receivers, one without area and surface, go into columns and come back equal, with their
    /// 3 shares.
    #[test]
    fn receivers_come_back() {
        let table = known();
        let receivers = table.receivers();
        assert_eq!((receivers[0].area, receivers[0].surface.as_deref()), (None, None));
        assert_eq!((receivers[1].area, receivers[1].surface.as_deref()), (Some(2.25), Some("wall:1")));
        assert_eq!(table.views().nth(1), Some([0.25, 0.5, 0.125]));
        assert_eq!(ReceiversTable::new(receivers.iter().zip(table.views())), table);
    }

    /// A value out of range in any of 9 ways is refused on writing and, under right checksums, on
    /// reading.
    #[test]
    fn ranges_are_checked() {
        let flaws: [fn(&mut ReceiversTable); 9] = [
            |r| r.ids[0].clear(),
            |r| r.ids[1] = "x".repeat(1025),
            |r| r.position[0][1] = f64::NAN,
            |r| r.normal[1][0] = 0.61,
            |r| r.area[0] = -1.0,
            |r| r.area[1] = f64::INFINITY,
            |r| r.sky_view[0] = 1.1,
            |r| r.ground_view[1] = f32::NAN,
            |r| r.obstruction_view.truncate(1),
        ];
        for (number, flaw) in flaws.into_iter().enumerate() {
            let mut wrong = known();
            flaw(&mut wrong);
            assert!(wrong.to_bytes().is_err(), "{number}");
            let raw = rkyv::to_bytes::<rkyv::rancor::Error>(&wrong).unwrap();
            let error =
                ReceiversTable::from_block(&block(&encode(RECEIVERS, TileNumber::FIRST, 1, 2, &raw, 9).unwrap()))
                    .unwrap_err();
            assert!(error.to_string().contains("block receivers/0"), "{number}: {error}");
        }
    }

    /// No change of one bit and no cut ends the program, though checksums are right: each of 2048
    /// changes is read or refused, and all 255 cuts are refused.
    #[test]
    fn hostile_bytes_are_survived() {
        let raw = known().to_bytes().unwrap();
        let (refused, accepted) = hostile(RECEIVERS, 2, &raw, ReceiversTable::from_block);
        assert_eq!(refused + accepted, raw.len() * 9 - 1);
        assert!(refused >= raw.len() - 1, "{refused}");
    }

    /// A block of another kind, one of schema 2 and one of 3 rows for 2 are refused: 3 of 3.
    #[test]
    fn other_blocks_are_refused() {
        let raw = known().to_bytes().unwrap();
        let refused = [(10, 1, 2), (1, 2, 2), (1, 1, 3)].into_iter().filter(|&(kind, schema, items)| {
            ReceiversTable::from_block(&block(
                &encode(BlockKind(kind), TileNumber::FIRST, schema, items, &raw, 9).unwrap(),
            ))
            .is_err()
        });
        assert_eq!(refused.count(), 3);
    }
}
