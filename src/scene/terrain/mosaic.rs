//! Several rasters as one ground. In: rasters in scene coordinates. Out: one raster of those that
//! touch on one grid, so that no gap of a cell stays open between tiles. Where rasters overlap on
//! different grids, the coarser one loses what the finer one covers.

use glam::DVec2;

use crate::site::Part;
use crate::terrain::raster::{Grid, MAX_SAMPLES, Raster};

/// Largest difference of positions on one grid, as a share of a cell: files state corners with six
/// digits and more.
const SAME_PLACE: f64 = 0.01;

/// Largest ratio of the samples of a joined grid to those of its tiles: tiles along a valley leave
/// most of such a grid empty.
const MAX_TIMES: u64 = 4;

/// A raster and its file; the first file if several were joined.
pub(crate) struct Tile<'p> {
    pub part: &'p Part,
    pub raster: Raster,
    /// Number of files whose samples it holds.
    pub files: usize,
}

/// A raster with its file, and its place in the order of all.
struct Placed<'p> {
    order: usize,
    part: &'p Part,
    raster: Raster,
}

/// Joins rasters that touch on one grid, and cuts overlaps out of the others. Returns notes on what
/// was done.
pub(crate) fn joined<'p>(rasters: Vec<(&'p Part, Raster)>) -> (Vec<Tile<'p>>, Vec<String>) {
    let mut notes = Vec::new();
    // Groups of files that touch, directly or through others.
    let mut groups: Vec<Vec<Placed>> = Vec::new();
    for (order, (part, raster)) in rasters.into_iter().enumerate() {
        let tile = Placed { order, part, raster };
        let (touching, apart): (Vec<_>, Vec<_>) =
            groups.into_iter().partition(|group| group.iter().any(|other| may_join(other, &tile)));
        groups = apart;
        let mut group: Vec<_> = touching.into_iter().flatten().collect();
        group.push(tile);
        group.sort_by_key(|tile| tile.order);
        groups.push(group);
    }
    groups.sort_by_key(|group| group.first().map(|tile| tile.order));
    let mut tiles: Vec<Tile> = Vec::new();
    for group in groups {
        match joined_grid(&group) {
            Some(grid) if group.len() > 1 => tiles.extend(join(group, grid)),
            _ => tiles.extend(group.into_iter().map(|Placed { part, raster, .. }| Tile { part, raster, files: 1 })),
        }
    }
    for tile in tiles.iter().filter(|tile| tile.files > 1) {
        let Grid { columns, rows, .. } = tile.raster.grid;
        notes.push(format!(
            "{} and {} more: tiles of one terrain of {columns} x {rows} samples; where they overlap the first file counts",
            tile.part.file.display(),
            tile.files - 1
        ));
    }
    tiles.sort_by(|a, b| a.raster.grid.step.max_element().total_cmp(&b.raster.grid.step.max_element()));
    let mut first = 0;
    while let Some((done, [coarse, ..])) = tiles.split_at_mut_checked(first) {
        let removed: usize = done.iter().map(|fine| cut_out(&mut coarse.raster, &fine.raster)).sum();
        if removed > 0 {
            let file = coarse.part.file.display();
            notes.push(format!("{file}: {removed} samples lie below finer terrain and are left out"));
        }
        first += 1;
    }
    tiles.retain(|tile| tile.raster.heights.iter().any(|height| !height.is_nan()));
    (tiles, notes)
}

/// Returns true if two rasters touch on one grid and have the same materials, horizon limit and
/// coordinate system.
fn may_join(a: &Placed, b: &Placed) -> bool {
    let alike = a.part.materials == b.part.materials
        && a.part.materials_only == b.part.materials_only
        && a.part.horizon_deg == b.part.horizon_deg
        && a.raster.reference == b.raster.reference;
    let (a, b) = (&a.raster.grid, &b.raster.grid);
    alike && offset(a, b).is_some_and(|at| touch(a, b, at))
}

/// Returns the columns eastwards and rows southwards from the first sample of a grid to that of
/// another; `None` if the other sample lies between samples, or the steps differ.
fn offset(a: &Grid, b: &Grid) -> Option<[i64; 2]> {
    let longest = a.columns.max(a.rows).max(b.columns).max(b.rows) as f64;
    let steps = ((a.step - b.step) / a.step).abs() * longest;
    let apart = (b.first - a.first) / a.step * DVec2::new(1.0, -1.0);
    let on_one = steps.max_element() <= SAME_PLACE && (apart - apart.round()).abs().max_element() <= SAME_PLACE;
    on_one.then(|| [apart.x.round() as i64, apart.y.round() as i64])
}

/// Returns true if two grids overlap or lie next to each other, with one cell between them as their
/// seam.
fn touch(a: &Grid, b: &Grid, [column, row]: [i64; 2]) -> bool {
    let near = |at: i64, of_a: usize, of_b: usize| at <= of_a as i64 && at + of_b as i64 >= 0;
    near(column, a.columns, b.columns) && near(row, a.rows, b.rows)
}

/// Returns the grid of all rasters of a group, if it is not too large.
fn joined_grid(group: &[Placed]) -> Option<Grid> {
    let first = &group.first()?.raster;
    let (mut low, mut high) = ([0_i64; 2], [0_i64; 2]);
    for Placed { raster, .. } in group {
        let [column, row] = offset(&first.grid, &raster.grid)?;
        low = [low[0].min(column), low[1].min(row)];
        high = [high[0].max(column + raster.grid.columns as i64), high[1].max(row + raster.grid.rows as i64)];
    }
    let [columns, rows] = [high[0] - low[0], high[1] - low[1]].map(|count| count as u64);
    let samples: u64 = group.iter().map(|tile| tile.raster.heights.len() as u64).sum();
    let all = columns.checked_mul(rows).filter(|all| *all <= MAX_SAMPLES && *all <= MAX_TIMES * samples)?;
    let step = first.grid.step;
    let north_west = first.grid.first + DVec2::new(low[0] as f64, -(low[1] as f64)) * step;
    let grid = Grid { columns: columns as usize, rows: rows as usize, first: north_west, step };
    // Steps that differ a little give different grids where they are long.
    (all > 0 && group.iter().all(|tile| offset(&grid, &tile.raster.grid).is_some())).then_some(grid)
}

/// Returns one raster of a group; the first raster with a height at a sample counts.
fn join(group: Vec<Placed>, grid: Grid) -> Option<Tile> {
    let mut heights = vec![f32::NAN; grid.columns * grid.rows];
    for Placed { raster, .. } in group.iter().rev() {
        let [column, row] = offset(&grid, &raster.grid)?.map(|count| usize::try_from(count).unwrap_or_default());
        for (i, line) in raster.heights.chunks(raster.grid.columns).enumerate() {
            let start = (row + i) * grid.columns + column;
            let to = heights.get_mut(start..start + line.len()).unwrap_or_default();
            for (to, from) in to.iter_mut().zip(line).filter(|(_, from)| !from.is_nan()) {
                *to = *from;
            }
        }
    }
    let files = group.len();
    let mut group = group.into_iter();
    let Placed { part, raster: first, .. } = group.next()?;
    let mut warnings = first.warnings;
    warnings.extend(group.flat_map(|tile| tile.raster.warnings));
    let raster = Raster { grid, heights, warnings, is_joined: true, ..first };
    Some(Tile { part, raster, files })
}

/// Removes from a raster the samples that lie wholly below a finer one; returns their number.
/// Samples whose cells the finer one covers in part stay.
fn cut_out(coarse: &mut Raster, fine: &Raster) -> usize {
    let (low, high) = fine.bounds();
    let (columns, step) = (coarse.grid.columns, coarse.grid.step);
    let (west_north, south_east) = coarse.bounds();
    if high.cmplt(west_north).any() || low.cmpgt(south_east).any() {
        return 0;
    }
    let around = [-1.0, 0.0, 1.0].map(|x| [-1.0, 0.0, 1.0].map(|y| DVec2::new(x, y) * step));
    let mut removed = 0;
    for i in 0..coarse.heights.len() {
        let place = coarse.plan((i % columns) as i64, (i / columns) as i64);
        let covered = || around.iter().flatten().all(|by| fine.has_height_at(place + *by));
        if let Some(height) = coarse.heights.get_mut(i)
            && !height.is_nan()
            && covered()
        {
            *height = f32::NAN;
            removed += 1;
        }
    }
    removed
}

impl Raster {
    /// Returns true if the sample nearest to a place is known; false beyond the outermost samples.
    fn has_height_at(&self, place: DVec2) -> bool {
        let at = (place - self.grid.first) / self.grid.step * DVec2::new(1.0, -1.0);
        let last = DVec2::new(self.grid.columns as f64 - 1.0, self.grid.rows as f64 - 1.0);
        let inside = at.cmpge(DVec2::ZERO).all() && at.cmple(last).all();
        inside && !self.height(at.x.round() as i64, at.y.round() as i64).is_nan()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::terrain::raster::Meaning;

    fn raster(first: [f64; 2], [columns, rows]: [usize; 2], step: f64, height: f32) -> Raster {
        let grid = Grid { columns, rows, first: first.into(), step: DVec2::splat(step) };
        Raster::new(Path::new("r"), grid, vec![height; columns * rows], &Meaning::default(), Vec::new())
            .expect("heights")
    }

    /// Two tiles of 4 x 3 samples side by side become one of 8 x 3, and a third one below them
    /// makes it 8 x 6; a tile that begins half a cell off stays by itself.
    #[test]
    fn tiles_are_one_grid() {
        let part = Part::plain(Path::new("r"), None);
        let tiles = vec![
            (&part, raster([40.0, 0.0], [4, 3], 10.0, 2.0)),
            (&part, raster([0.0, 0.0], [4, 3], 10.0, 1.0)),
            (&part, raster([0.001, -30.0], [4, 3], 10.0, 3.0)),
            (&part, raster([45.0, -30.0], [4, 3], 10.0, 4.0)),
        ];
        let (found, notes) = joined(tiles);
        assert_eq!((found.len(), notes.len()), (2, 1));
        let one = &found[0].raster;
        assert_eq!((one.grid.columns, one.grid.rows, found[0].files), (8, 6, 3));
        assert!((one.grid.first - DVec2::ZERO).length() < 0.01);
        assert_eq!([one.height(0, 0), one.height(3, 2), one.height(4, 2), one.height(0, 3)], [1.0, 1.0, 2.0, 3.0]);
        assert!(one.height(7, 5).is_nan());
    }

    /// Where two tiles overlap by 2 of 4 columns the first one counts, and 6 x 3 samples are left.
    /// Where a tile of 1 m lies in one of 10 m, the 3 x 3 samples of the coarse one whose cells it
    /// covers are removed.
    #[test]
    fn overlaps_count_once() {
        let part = Part::plain(Path::new("r"), None);
        let overlapping =
            vec![(&part, raster([0.0; 2], [4, 3], 10.0, 1.0)), (&part, raster([20.0, 0.0], [4, 3], 10.0, 2.0))];
        let (found, _) = joined(overlapping);
        let one = &found[0].raster;
        assert_eq!((found.len(), one.heights.len()), (1, 18));
        assert_eq!([3, 4].map(|column| one.height(column, 1)), [1.0, 2.0]);
        let coarse = raster([0.0, 100.0], [11, 11], 10.0, 1.0);
        let fine = raster([30.0, 70.0], [41, 41], 1.0, 2.0);
        let (found, notes) = joined(vec![(&part, coarse), (&part, fine)]);
        let gone = found[1].raster.heights.iter().filter(|height| height.is_nan()).count();
        assert_eq!((found.len(), gone), (2, 9));
        assert!(notes[0].contains("9 samples lie below finer terrain"), "{notes:?}");
    }
}
