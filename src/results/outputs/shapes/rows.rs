//! Rows of a map that are stored until all are known. In: rows one by one. Out: the rows, as often
//! as needed, and the facts of all that a header states.

use std::path::Path;

use glam::DVec3;

use super::columns::MapColumns;
use super::row::MapRow;
use crate::outputs::pictures::colours::ColourScale;
use heliotile_core::error::Result;
use heliotile_files::spill::{Sorted, Sorter};

/// Facts about all rows.
#[derive(Clone, Copy, Debug)]
pub struct MapFacts {
    pub rows: u64,
    pub polygons: u64,
    /// Number of corners of all polygons.
    pub corners: u64,
    /// Number of convex cells, which are polygons or their triangles; `cell_corners` is the number
    /// of their corners.
    pub cells: u64,
    pub cell_corners: u64,
    /// Number of triangles if all polygons are cut.
    pub triangles: u64,
    /// Lowest and highest corner, metres.
    pub bounds: [DVec3; 2],
    /// Largest number of the colour column; the largest absolute number if its scale has two sides.
    pub largest: f32,
}

/// Collector of rows.
pub struct RowSpool {
    sorter: Sorter,
    colour: usize,
    scale: ColourScale,
    facts: MapFacts,
}

impl RowSpool {
    /// Returns a collector of rows with these columns; `folder` holds what does not fit into
    /// `memory_bytes`.
    pub fn new(folder: &Path, memory_bytes: usize, columns: &MapColumns) -> Self {
        let bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let facts = MapFacts {
            rows: 0,
            polygons: 0,
            corners: 0,
            cells: 0,
            cell_corners: 0,
            triangles: 0,
            bounds,
            largest: 0.0,
        };
        RowSpool { sorter: Sorter::new(folder, memory_bytes), colour: columns.colour, scale: columns.scale, facts }
    }

    pub fn push(&mut self, row: &MapRow) -> Result<()> {
        let facts = &mut self.facts;
        for polygon in &row.polygons {
            let cells = polygon.cells();
            facts.polygons += 1;
            facts.corners += polygon.corners().count() as u64;
            // Triangles are counted, not computed from corners: ear clipping finds fewer if corners
            // lie on a line.
            facts.triangles += polygon.triangles().len() as u64;
            facts.cells += cells.len() as u64;
            facts.cell_corners += cells.iter().map(|cell| cell.len() as u64).sum::<u64>();
            for corner in polygon.corners() {
                facts.bounds = [facts.bounds[0].min(*corner), facts.bounds[1].max(*corner)];
            }
        }
        let value = row.numbers.get(self.colour).copied().unwrap_or_default();
        facts.largest = facts.largest.max(self.scale.reach(value));
        self.sorter.push(&facts.rows.to_be_bytes(), &row.bytes())?;
        facts.rows += 1;
        Ok(())
    }

    pub fn finish(self) -> Result<MapRows> {
        Ok(MapRows { rows: self.sorter.finish()?, facts: self.facts })
    }
}

/// All rows of a map.
pub struct MapRows {
    rows: Sorted,
    pub facts: MapFacts,
}

impl MapRows {
    /// Calls `take` for all rows, in order.
    pub fn each(&mut self, mut take: impl FnMut(&MapRow) -> Result<()>) -> Result<()> {
        self.rows.rewind()?;
        for record in self.rows.by_ref() {
            take(&MapRow::of_bytes(&record?.1)?)?;
        }
        Ok(())
    }
}
