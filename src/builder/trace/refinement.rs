//! Which texels of a cell's sky texture follow from others. In: one texel of each two by two, traced. Out: what it tells about the three beside it:
//! its own answer where its neighbours agree with it, nothing where they do not.

use heliotile_core::hemisphere::bit;

/// Below this share of open texels all are traced: an opening smaller than a texel of the base is found by chance, and would count for all of it.
const LITTLE_SKY: f64 = 0.03;

/// What one texel of four tells about the three beside it.
pub struct Refinement {
    /// Side of the texture.
    n: usize,
    /// `[base texel]`: whether it is open; `None` where its ray lies behind the surface.
    open: Vec<Option<bool>>,
    /// `[base texel]`: the texel that was traced.
    traced: Vec<usize>,
    /// There is so little sky that none tells anything.
    is_dark: bool,
}

impl Refinement {
    /// From the texels of an n x n texture that were traced, one in each two by two, with their bits; some lie before their point's surface, others behind
    /// it.
    pub fn of(n: usize, first: &[usize], bits: &[u8], is_before: impl Fn(usize) -> bool) -> Self {
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

    /// Whether a texel is one of those that were traced.
    pub fn is_traced(&self, texel: usize) -> bool {
        self.traced[self.base(texel)] == texel
    }

    fn base(&self, texel: usize) -> usize {
        texel / self.n / 2 * (self.n / 2) + texel % self.n / 2
    }

    /// Whether a texel is open, if its base texel and those beside that agree.
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

    /// A half of a 64 x 64 sky is open: of its 1,024 base texels the 64 beside the edge tell nothing, the other 960 what is the case, also where
    /// a quarter lies behind the surface. A sky of 30 open base texels of 1,024 tells nothing at all.
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
        let base = Refinement::of(n, &first, &bits, |_| true);
        let told: Vec<(usize, bool)> = first.iter().filter_map(|&t| Some((t, base.told(t)?))).collect();
        assert_eq!(told.len(), 1024 - 64);
        assert!(told.iter().all(|&(t, open)| open == left(t) && base.is_traced(t) && !base.is_traced(t - 1)));
        let behind = Refinement::of(n, &first, &bits, |t| t / n >= n / 4);
        let is_told = |t: usize| t / n >= n / 4 && !(15..=16).contains(&(t % n / 2));
        assert!((0..n * n).all(|t| behind.told(t).is_some() == is_told(t)));
        let dark = Refinement::of(n, &first, &bits_of(&|t| t / n < 2 && t % n < 60), |_| true);
        assert!((0..n * n).all(|t| dark.told(t).is_none()));
    }
}
