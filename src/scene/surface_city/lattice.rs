//! Values on a grid. In: spots, by column and row, inside or outside of the grid. Out: the value at
//! a spot, or the value that stands for none.

use std::collections::VecDeque;

/// Column eastwards and row southwards, of a cell or of a corner of cells.
pub(super) type Spot = [i64; 2];

/// Steps to the four neighbours: east, south, west, north.
pub(super) const STEPS: [Spot; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];

/// Returns the neighbour in one of the directions of [`STEPS`].
pub(super) fn beside(spot: Spot, step: Spot) -> Spot {
    [spot[0] + step[0], spot[1] + step[1]]
}

/// Grid of values, `[row][column]`, row 0 in the north.
#[derive(Clone, Debug)]
pub(super) struct Lattice<T> {
    pub columns: usize,
    pub rows: usize,
    values: Vec<T>,
    /// Value beyond the edges.
    none: T,
}

impl<T: Copy> Lattice<T> {
    /// Returns a grid that holds one value, which also counts beyond its edges.
    pub(super) fn filled(columns: usize, rows: usize, none: T) -> Lattice<T> {
        Lattice { columns, rows, values: vec![none; columns * rows], none }
    }

    /// Returns a grid of the same size that holds one value.
    pub(super) fn like<U: Copy>(&self, none: U) -> Lattice<U> {
        Lattice::filled(self.columns, self.rows, none)
    }

    /// Returns the index of a spot's value, if the spot is on the grid.
    fn index(&self, [column, row]: Spot) -> Option<usize> {
        let (column, row) = (usize::try_from(column).ok()?, usize::try_from(row).ok()?);
        (column < self.columns && row < self.rows).then_some(row * self.columns + column)
    }

    /// Returns true if a spot is on the grid.
    pub(super) fn holds(&self, spot: Spot) -> bool {
        self.index(spot).is_some()
    }

    /// Returns the value of a spot.
    #[inline]
    pub(super) fn at(&self, spot: Spot) -> T {
        self.index(spot).and_then(|index| self.values.get(index)).copied().unwrap_or(self.none)
    }

    /// Sets the value of a spot on the grid.
    #[inline]
    pub(super) fn set(&mut self, spot: Spot, value: T) {
        if let Some(slot) = self.index(spot).and_then(|index| self.values.get_mut(index)) {
            *slot = value;
        }
    }

    /// Returns all spots, row by row from the north-west.
    pub(super) fn spots(&self) -> impl Iterator<Item = Spot> + use<T> {
        let (columns, rows) = (self.columns as i64, self.rows as i64);
        (0..rows).flat_map(move |row| (0..columns).map(move |column| [column, row]))
    }

    /// Returns the values, row by row.
    pub(super) fn into_values(self) -> Vec<T> {
        self.values
    }

    /// Numbers the connected pieces of spots for which `belongs` is true, from 0 in the order of
    /// their first spot; neighbours are connected if `joins` is true. Returns the number of each
    /// spot, `u32::MAX` for none, and the spots of each piece.
    pub(super) fn pieces(
        &self,
        belongs: impl Fn(Spot) -> bool,
        joins: impl Fn(Spot, Spot) -> bool,
    ) -> (Lattice<u32>, Vec<Vec<Spot>>) {
        let (mut numbers, mut pieces) = (self.like(u32::MAX), Vec::new());
        for spot in self.spots() {
            if numbers.at(spot) != u32::MAX || !belongs(spot) {
                continue;
            }
            let number = pieces.len() as u32;
            let (mut piece, mut next) = (Vec::new(), VecDeque::from([spot]));
            numbers.set(spot, number);
            while let Some(spot) = next.pop_front() {
                piece.push(spot);
                for other in STEPS.map(|step| beside(spot, step)) {
                    let is_on = self.index(other).is_some();
                    if is_on && numbers.at(other) == u32::MAX && belongs(other) && joins(spot, other) {
                        numbers.set(other, number);
                        next.push_back(other);
                    }
                }
            }
            pieces.push(piece);
        }
        (numbers, pieces)
    }
}

impl Lattice<f32> {
    /// Gives each spot without a height the height of the nearest spot with one, along rows and
    /// columns.
    pub(super) fn fill(&mut self) {
        let mut next: VecDeque<Spot> = self.spots().filter(|spot| !self.at(*spot).is_nan()).collect();
        while let Some(spot) = next.pop_front() {
            for other in STEPS.map(|step| beside(spot, step)) {
                if self.index(other).is_some() && self.at(other).is_nan() {
                    self.set(other, self.at(spot));
                    next.push_back(other);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On a grid of 3 x 2, two spots that touch along a side are one piece, and a spot that touches
    /// only at a corner is another. Spots beyond the edges hold nothing.
    #[test]
    fn pieces_hold_together_along_sides() {
        let mut grid = Lattice::filled(3, 2, 0_u8);
        [[0, 0], [1, 0], [2, 1]].into_iter().for_each(|spot| grid.set(spot, 1));
        grid.set([3, 0], 1);
        let (numbers, pieces) = grid.pieces(|spot| grid.at(spot) == 1, |_, _| true);
        assert_eq!(pieces.iter().map(Vec::len).collect::<Vec<_>>(), [2, 1]);
        assert_eq!([numbers.at([1, 0]), numbers.at([2, 1]), numbers.at([0, 1])], [0, 1, u32::MAX]);
        assert_eq!((grid.at([3, 0]), grid.at([-1, 0])), (0, 0));
    }

    /// A spot without a height gets the 5 m of its neighbour, not the 9 m two spots further.
    #[test]
    fn gaps_take_the_nearest_height() {
        let mut heights = Lattice::filled(4, 1, f32::NAN);
        heights.set([0, 0], 5.0);
        heights.set([3, 0], 9.0);
        heights.fill();
        assert_eq!(heights.into_values(), [5.0, 5.0, 9.0, 9.0]);
    }
}
