//! Thinning of far terrain. In: a raster and the place it is seen from. Out: triangles between few
//! samples, without cracks, whose angle to the raster is nowhere above a limit.
//!
//! The triangles are those of a right-triangulated irregular network (Evans, Kirkpatrick and
//! Townsend 2001): two halves of a square of 2^k cells, each cut in two through the middle of its
//! longest side as often as needed, down to halves of cells. A middle is kept if one of the two
//! triangles beside it is off by more than the limit at any of its samples, or if a middle is kept
//! in one of the halves. Both triangles beside a side then agree on it, so that there are no
//! cracks.

use rayon::prelude::*;

use crate::terrain::focus::Focus;
use crate::terrain::raster::Raster;

/// Column and row of a sample.
pub(crate) type Sample = [i64; 2];

/// Difference below which heights are equal but for rounding, metres.
const ROUNDING_M: f64 = 1e-6;

/// A triangle of the hierarchy: both ends of its longest side, then the corner between the other
/// two sides.
#[derive(Clone, Copy, Debug)]
struct Half {
    a: Sample,
    b: Sample,
    apex: Sample,
}

/// Triangles of a thinned surface, and figures about it.
#[derive(Debug, Default)]
pub(super) struct Thinned {
    /// Corners of each triangle, none of them nodata.
    pub triangles: Vec<[Sample; 3]>,
    /// Number of triangles left out because they touch nodata.
    pub nodata: usize,
    /// Largest angle between raster and triangles as seen from the focus, degrees.
    pub largest_deg: f64,
}

/// Thins a raster so that no point of it, seen from the focus, moves by more than `limit_deg`.
pub(super) fn thin(raster: &Raster, focus: &Focus, limit_deg: f64) -> Thinned {
    let judge = Judge {
        raster,
        // Between samples the surface is a mean of three samples of one cell. Distances are those
        // of the nearest place of the cells around a sample, so that the limit also holds between
        // samples.
        focus: focus.grown(raster.grid.step),
        limit: Limit::Angle(limit_deg.to_radians()),
    };
    judge.thinned()
}

/// Thins a raster so that no sample is off by more than `allowed_m` allows, metres; a sample that
/// allows less than 0 stays a corner.
pub(crate) fn thin_within(raster: &Raster, allowed_m: &[f32]) -> Vec<[Sample; 3]> {
    let (low, _) = raster.bounds();
    let judge = Judge { raster, focus: Focus::around(low, low), limit: Limit::Each(allowed_m) };
    judge.thinned().triangles
}

/// Limits of the distance between triangles and samples.
enum Limit<'a> {
    /// Limit in metres a metre of distance from the focus.
    Angle(f64),
    /// Limit of each sample, `[row][column]`, metres; below 0 for samples that stay.
    Each(&'a [f32]),
}

struct Judge<'a> {
    raster: &'a Raster,
    focus: Focus,
    limit: Limit<'a>,
}

/// True for each sample that is the middle of a cut side.
struct Kept {
    columns: i64,
    rows: i64,
    flags: Vec<bool>,
}

impl Kept {
    /// Returns true if a sample is kept; beyond the raster every side is cut.
    fn is(&self, [column, row]: Sample) -> bool {
        if column < 0 || row < 0 || column >= self.columns || row >= self.rows {
            return true;
        }
        self.flags.get((row * self.columns + column) as usize).copied().unwrap_or(true)
    }
}

impl Judge<'_> {
    fn thinned(&self) -> Thinned {
        let side = (self.raster.grid.columns.max(self.raster.grid.rows) - 1).next_power_of_two() as i64;
        let side = side.max(2);
        let kept = self.kept(side);
        self.collect(side, &kept)
    }

    /// Marks the samples to keep, from the smallest sides to the largest.
    fn kept(&self, side: i64) -> Kept {
        let (columns, rows) = (self.raster.grid.columns as i64, self.raster.grid.rows as i64);
        let mut kept = Kept { columns, rows, flags: vec![false; self.raster.samples()] };
        let mut size = 2;
        while size <= side {
            let half = size / 2;
            // Sides along the axes come first: their triangles are halves of those on the diagonals
            // of squares of this size.
            for diagonal in [false, true] {
                let lines = (0..=(rows - 1) / half).into_par_iter();
                let cut: Vec<usize> = lines
                    .flat_map_iter(|line| self.cut_in_row(line * half, size, diagonal, &kept))
                    .map(|[column, row]| (row * columns + column) as usize)
                    .collect();
                for place in cut {
                    if let Some(flag) = kept.flags.get_mut(place) {
                        *flag = true;
                    }
                }
            }
            size *= 2;
        }
        kept
    }

    /// Returns the middles of one row that must be kept.
    fn cut_in_row<'k>(
        &'k self,
        row: i64,
        size: i64,
        diagonal: bool,
        kept: &'k Kept,
    ) -> impl Iterator<Item = Sample> + 'k {
        let half = size / 2;
        let odd_row = row / half % 2 == 1;
        // Middles of diagonals are odd in both directions, those of other sides in one.
        let first = if diagonal == odd_row { half } else { 0 };
        let last = if diagonal && !odd_row { -1 } else { kept.columns - 1 };
        (first..=last).step_by(size as usize).map(move |column| [column, row]).filter(move |&middle| {
            let mut halves = beside(middle, half, diagonal).into_iter().filter(|half| self.has_cells(half));
            // Sides of triangles along the shortest sides have no sample in their middle.
            let cut_below = |h: &Half| (diagonal || half > 1) && h.middles().into_iter().any(|child| kept.is(child));
            halves.any(|half| cut_below(&half) || !self.fits(&half))
        })
    }

    /// Returns true if a cell of the raster may lie in a triangle: beyond the edges there is
    /// nothing to agree with.
    fn has_cells(&self, half: &Half) -> bool {
        let sizes = [self.raster.grid.columns as i64, self.raster.grid.rows as i64];
        let corners = [half.a, half.b, half.apex];
        (0..2).zip(sizes).all(|(axis, size)| {
            let along = || corners.iter().filter_map(|corner: &Sample| corner.get(axis).copied());
            along().min() < Some(size - 1) && along().max() > Some(0)
        })
    }

    /// Returns true if a triangle is within the limit of every sample in it; false if one of them
    /// is nodata.
    fn fits(&self, half: &Half) -> bool {
        let columns = self.raster.grid.columns;
        self.scan(half, |off, sample| match self.limit {
            Limit::Angle(limit) => {
                let off = off - ROUNDING_M;
                off <= 0.0 || off * off <= limit * limit * self.distance_squared(sample)
            }
            Limit::Each(allowed_m) => {
                let allowed_m = allowed_m.get(sample[1] as usize * columns + sample[0] as usize);
                let is_corner = [half.a, half.b, half.apex].contains(&sample);
                is_corner || allowed_m.is_some_and(|allowed_m| off <= f64::from(*allowed_m))
            }
        })
    }

    /// Returns the largest angle between a triangle and the samples in it, radians.
    fn angle(&self, half: &Half) -> f64 {
        let mut largest = 0.0_f64;
        self.scan(half, |off, sample| {
            if off > ROUNDING_M {
                largest = largest.max(off / self.distance_squared(sample).sqrt());
            }
            true
        });
        largest
    }

    fn distance_squared(&self, [column, row]: Sample) -> f64 {
        self.focus.distance_squared(self.raster.plan(column, row))
    }

    /// Calls `goes_on` for all samples in a triangle, edges included, with their distance from it
    /// along the vertical. Stops and returns false if `goes_on` does, or at nodata.
    fn scan(&self, half: &Half, mut goes_on: impl FnMut(f64, Sample) -> bool) -> bool {
        let [a, b, apex] = [half.a, half.b, half.apex].map(|[c, r]| f64::from(self.raster.height(c, r)));
        if !(a + b + apex).is_finite() {
            return false;
        }
        let to = |p: Sample| [(p[0] - half.apex[0]) as f64, (p[1] - half.apex[1]) as f64];
        let ([ux, uy], [vx, vy]) = (to(half.a), to(half.b));
        let turn = ux * vy - uy * vx;
        let along_x = ((a - apex) * vy - (b - apex) * uy) / turn;
        let along_y = ((b - apex) * ux - (a - apex) * vx) / turn;
        let rows = [half.a[1], half.b[1], half.apex[1]];
        for row in rows.into_iter().min().unwrap_or(0)..=rows.into_iter().max().unwrap_or(-1) {
            let (from, to) = half.columns_in(row);
            let heights = self.raster.row(row, from..=to);
            if heights.is_empty() {
                return false;
            }
            let start = apex + along_y * (row - half.apex[1]) as f64 + along_x * (from - half.apex[0]) as f64;
            for (i, &height) in heights.iter().enumerate() {
                let off = (f64::from(height) - (start + along_x * i as f64)).abs();
                // NaN is no height.
                if off.is_nan() || !goes_on(off, [from + i as i64, row]) {
                    return false;
                }
            }
        }
        true
    }

    /// Returns the triangles that remain.
    fn collect(&self, side: i64, kept: &Kept) -> Thinned {
        let mut thinned = Thinned::default();
        let (from, to) = ([0, 0], [side, side]);
        let mut open = vec![Half { a: from, b: to, apex: [side, 0] }, Half { a: to, b: from, apex: [0, side] }];
        let mut coarse = Vec::new();
        while let Some(half) = open.pop() {
            let corners = [half.a, half.b, half.apex];
            if !self.has_cells(&half) {
                continue;
            }
            let [dx, dy] = [half.b[0] - half.a[0], half.b[1] - half.a[1]];
            if dx.abs() + dy.abs() > 2 || dx == 0 || dy == 0 {
                let middle = [half.a[0] + dx / 2, half.a[1] + dy / 2];
                if kept.is(middle) {
                    open.push(Half { a: half.apex, b: half.a, apex: middle });
                    open.push(Half { a: half.b, b: half.apex, apex: middle });
                    continue;
                }
                coarse.push(half);
            } else if corners.iter().any(|&[column, row]| self.raster.height(column, row).is_nan()) {
                let inside = corners.iter().all(|&[column, row]| column < kept.columns && row < kept.rows);
                thinned.nodata += usize::from(inside);
                continue;
            }
            thinned.triangles.push(corners);
        }
        let largest = coarse.par_iter().map(|half| self.angle(half)).reduce(|| 0.0, f64::max);
        thinned.largest_deg = largest.to_degrees();
        thinned
    }
}

impl Half {
    /// Returns the middles of the shorter sides.
    fn middles(&self) -> [Sample; 2] {
        [self.a, self.b].map(|[x, y]| [(x + self.apex[0]) / 2, (y + self.apex[1]) / 2])
    }

    /// Returns the first and last column of the triangle's samples in one of its rows. The sides
    /// are straight, upright or slanted by one column a row.
    fn columns_in(&self, row: i64) -> (i64, i64) {
        let (mut from, mut to) = (i64::MAX, i64::MIN);
        for [[x0, y0], [x1, y1]] in [[self.a, self.b], [self.b, self.apex], [self.apex, self.a]] {
            if row < y0.min(y1) || row > y0.max(y1) {
                continue;
            }
            let ends = if y0 == y1 { [x0, x1] } else { [x0 + (x1 - x0).signum() * (row - y0).abs(); 2] };
            for x in ends {
                (from, to) = (from.min(x), to.max(x));
            }
        }
        (from, to)
    }
}

/// Returns both triangles beside the side with this middle.
fn beside([x, y]: Sample, half: i64, diagonal: bool) -> [Half; 2] {
    if diagonal {
        // The diagonal goes through the middle of the square of twice the size: through the corner
        // that is an odd multiple of the size in both directions.
        let corner =
            |c: i64| if (c - half) / (2 * half) % 2 == 0 { (c - half, c + half) } else { (c + half, c - half) };
        let ((even_x, odd_x), (even_y, odd_y)) = (corner(x), corner(y));
        let (a, b) = ([even_x, even_y], [odd_x, odd_y]);
        [Half { a, b, apex: [odd_x, even_y] }, Half { a, b, apex: [even_x, odd_y] }]
    } else if x / half % 2 == 1 {
        let (a, b) = ([x - half, y], [x + half, y]);
        [Half { a, b, apex: [x, y - half] }, Half { a, b, apex: [x, y + half] }]
    } else {
        let (a, b) = ([x, y - half], [x, y + half]);
        [Half { a, b, apex: [x - half, y] }, Half { a, b, apex: [x + half, y] }]
    }
}

#[cfg(test)]
#[path = "thinning_tests.rs"]
mod tests;
