//! Refinement of a cell's sky texture. In: one traced texel of each 2 x 2. Out: for the other three
//! its answer if its neighbours agree with it, else nothing.

use heliotile_core::hemisphere::bit;

/// Share of open texels below which all texels are traced. An opening smaller than a base texel is
/// found by chance, and would count for the whole texel.
const LITTLE_SKY: f64 = 0.03;

/// Answers of one texel of four for the three beside it.
pub struct Refinement {
    /// Side of the texture.
    n: usize,
    /// `[base texel]`: true if it is open; `None` if its ray lies behind the surface.
    open: Vec<Option<bool>>,
    /// `[base texel]`: the texel that was traced.
    traced: Vec<usize>,
    /// True if there is so little sky that no base texel decides others.
    is_dark: bool,
}

impl Refinement {
    /// Creates the answers from the texels of an n x n texture that were traced first, one in each
    /// 2 x 2, and their bits. `is_before` is true for texels in front of the surface of their
    /// point.
    pub fn new(n: usize, first: &[usize], bits: &[u8], is_before: impl Fn(usize) -> bool) -> Self {
        let m = n / 2;
        let (mut open, mut traced) = (vec![None; m * m], vec![0; m * m]);
        let (mut asked, mut found) = (0, 0);
        for &texel in first {
            let at = texel / n / 2 * m + texel % n / 2;
            traced[at] = texel;
            if is_before(texel) {
                let is_open = bit(bits, texel);
                open[at] = Some(is_open);
                asked += 1;
                found += usize::from(is_open);
            }
        }
        Refinement { n, open, traced, is_dark: (found as f64) < LITTLE_SKY * f64::from(asked) }
    }

    /// Returns true if a texel was traced first.
    pub fn is_traced(&self, texel: usize) -> bool {
        self.traced[self.base(texel)] == texel
    }

    fn base(&self, texel: usize) -> usize {
        texel / self.n / 2 * (self.n / 2) + texel % self.n / 2
    }

    /// Returns if a texel is open, provided that its base texel and the neighbours of that agree.
    pub fn told(&self, texel: usize) -> Option<bool> {
        let (m, at) = (self.n / 2, self.base(texel));
        let own = self.open[at]?;
        let (row, column) = (at / m, at % m);
        let agrees = |at: usize| self.open[at].is_none_or(|open| open == own);
        let agree = (row == 0 || agrees(at - m))
            && (row + 1 == m || agrees(at + m))
            && (column == 0 || agrees(at - 1))
            && (column + 1 == m || agrees(at + 1));
        (agree && !self.is_dark).then_some(own)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half of a 64 x 64 sky is open. Of its 1,024 base texels the 64 beside the edge decide
    /// nothing, and the other 960 are right, also if a quarter lies behind the surface. A sky with
    /// 30 open base texels of 1,024 decides nothing.
    #[test]
    fn texels_follow_from_their_neighbours() {
        let n = 64;
        let first: Vec<usize> = (0..n * n).filter(|t| t % n % 2 == 1 && t / n % 2 == 0).collect();
        let bits_of = |is_open: &dyn Fn(usize) -> bool| {
            let mut bits = vec![0_u8; n * n / 8];
            first.iter().filter(|&&t| is_open(t)).for_each(|t| bits[t / 8] |= 1 << (t % 8));
            bits
        };
        let left = |t: usize| t % n < n / 2;
        let bits = bits_of(&left);
        let base = Refinement::new(n, &first, &bits, |_| true);
        let told: Vec<(usize, bool)> = first.iter().filter_map(|&t| Some((t, base.told(t)?))).collect();
        assert_eq!(told.len(), 1024 - 64);
        assert!(told.iter().all(|&(t, open)| open == left(t) && base.is_traced(t) && !base.is_traced(t - 1)));
        let behind = Refinement::new(n, &first, &bits, |t| t / n >= n / 4);
        let is_told = |t: usize| t / n >= n / 4 && !(15..=16).contains(&(t % n / 2));
        assert!((0..n * n).all(|t| behind.told(t).is_some() == is_told(t)));
        let dark = Refinement::new(n, &first, &bits_of(&|t| t / n < 2 && t % n < 60), |_| true);
        assert!((0..n * n).all(|t| dark.told(t).is_none()));
    }
}
