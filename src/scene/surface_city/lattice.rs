//! Values on a grid. In: places, by column and row, inside or outside of it. Out: the value there, or the one that stands for none.

use std::collections::VecDeque;

/// Column eastwards and row southwards, of a cell or of a corner of cells.
pub(super) type Spot = [i64; 2];

/// Steps to the four neighbours: east, south, west, north.
pub(super) const STEPS: [Spot; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];

/// The neighbour in one of the directions of [`STEPS`].
pub(super) fn beside(spot: Spot, step: Spot) -> Spot {
    [spot[0] + step[0], spot[1] + step[1]]
}

/// `[row][column]`, row 0 in the north.
#[derive(Clone, Debug)]
pub(super) struct Lattice<T> {
    pub columns: usize,
    pub rows: usize,
    values: Vec<T>,
    /// What lies beyond the edges.
    none: T,
}

impl<T: Copy> Lattice<T> {
    /// A grid that holds one value, which stands for what lies beyond its edges, too.
    pub(super) fn filled(columns: usize, rows: usize, none: T) -> Lattice<T> {
        Lattice { columns, rows, values: vec![none; columns * rows], none }
    }

    /// A grid of the same size.
    pub(super) fn like<U: Copy>(&self, none: U) -> Lattice<U> {
        Lattice::filled(self.columns, self.rows, none)
    }

    /// Where the value of a place stands, if it is on the grid.
    fn index(&self, [column, row]: Spot) -> Option<usize> {
        let (column, row) = (usize::try_from(column).ok()?, usize::try_from(row).ok()?);
        (column < self.columns && row < self.rows).then_some(row * self.columns + column)
    }

    /// The value of a place.
    #[inline]
    pub(super) fn at(&self, spot: Spot) -> T {
        self.index(spot).and_then(|index| self.values.get(index)).copied().unwrap_or(self.none)
    }

    /// Sets the value of a place on the grid.
    #[inline]
    pub(super) fn set(&mut self, spot: Spot, value: T) {
        if let Some(slot) = self.index(spot).and_then(|index| self.values.get_mut(index)) {
            *slot = value;
        }
    }

    /// All places, row by row from the north-west.
    pub(super) fn spots(&self) -> impl Iterator<Item = Spot> + use<T> {
        let (columns, rows) = (self.columns as i64, self.rows as i64);
        (0..rows).flat_map(move |row| (0..columns).map(move |column| [column, row]))
    }

    /// The values, row by row.
    pub(super) fn into_values(self) -> Vec<T> {
        self.values
    }

    /// Numbers the pieces of those places that `belongs` takes, from 0 in the order of their first place; neighbours are of one piece if
    /// `joins` says so. Gives the number of each place, `u32::MAX` for none, and the places of each piece.
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
    /// Gives each place without a height that of the nearest place with one, along rows and columns.
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

    /// Of 3 x 2 places, two touch along a side and one only at a corner: 2 pieces of 2 and 1; places beyond the edges hold nothing.
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

    /// A place without a height gets the 5 m of its neighbour, not the 9 m two places further.
    #[test]
    fn gaps_take_the_nearest_height() {
        let mut heights = Lattice::filled(4, 1, f32::NAN);
        heights.set([0, 0], 5.0);
        heights.set([3, 0], 9.0);
        heights.fill();
        assert_eq!(heights.into_values(), [5.0, 5.0, 9.0, 9.0]);
    }
}
