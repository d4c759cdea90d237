//! Sixteen f32 lanes on the processor at hand. In: a kernel written once over [`Lanes`]. Out: the
//! kernel compiled for AVX-512, for AVX2 and for any processor, and run on the best level of this
//! machine.
//!
//! All levels give the same bits: they use additions, products, quotients, minima and comparisons
//! only, never a fused multiply-add.

/// Number of lanes of a packet.
pub const LANES: usize = 16;

/// Sixteen values in memory.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct F32x16(pub [f32; LANES]);

/// Half of the lanes in memory.
pub type Half = [f32; LANES / 2];

/// Arithmetic on sixteen lanes. A mask is a `u16`, lane 0 the lowest bit. NaN must not occur.
pub trait Lanes: Copy {
    /// Sixteen f32 values in registers.
    type F: Copy;
    /// Returns one value in all lanes.
    fn splat(self, x: f32) -> Self::F;
    /// Loads values from memory.
    fn load(self, x: &F32x16) -> Self::F;
    /// Stores values to memory.
    fn store(self, x: Self::F) -> F32x16;
    /// Returns a + b.
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    /// Returns a - b.
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    /// Returns a x b.
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    /// Returns a / b.
    fn div(self, a: Self::F, b: Self::F) -> Self::F;
    /// Returns the smaller of a and b.
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    /// Returns the larger of a and b.
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    /// Returns a without its sign.
    fn abs(self, a: Self::F) -> Self::F;
    /// Returns the lanes in which a < b.
    fn less(self, a: Self::F, b: Self::F) -> u16;
    /// Returns the lanes in which a <= b.
    fn less_equal(self, a: Self::F, b: Self::F) -> u16;
    /// Returns `a` where the mask is set, `b` elsewhere.
    fn select(self, mask: u16, a: Self::F, b: Self::F) -> Self::F;
    /// Joins lanes 0 to 7 (`low`) and 8 to 15 (`high`).
    fn halves(self, low: &Half, high: &Half) -> Self::F;
    /// Swaps lanes 0 to 7 with lanes 8 to 15.
    fn swap(self, a: Self::F) -> Self::F;
    /// Returns the smallest lane.
    fn lowest(self, a: Self::F) -> f32;
    /// Returns the largest lane.
    fn highest(self, a: Self::F) -> f32;
}

/// Processor level that kernels are compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Any processor.
    Baseline,
    /// x86-64-v3: AVX2, 2 x 8 lanes.
    Avx2,
    /// x86-64-v4: AVX-512, 16 lanes.
    Avx512,
}

impl Level {
    /// Returns all levels that this machine can run, best last.
    pub fn available() -> Vec<Level> {
        let mut levels = vec![Level::Baseline];
        #[cfg(target_arch = "x86_64")]
        {
            levels.extend(pulp::x86::V3::try_new().map(|_| Level::Avx2));
            levels.extend(pulp::x86::V4::try_new().map(|_| Level::Avx512));
        }
        levels
    }

    /// Returns the best level of this machine.
    pub fn best() -> Level {
        Level::available().last().copied().unwrap_or(Level::Baseline)
    }
}

/// Computation that can be compiled for any level.
pub trait Kernel {
    /// Result of the computation.
    type Output;
    /// Runs the computation, compiled for the level of `lanes`.
    fn run<L: Lanes>(self, lanes: L) -> Self::Output;
}

/// Runs a kernel at a level. A level that the machine lacks falls back to the baseline.
#[inline]
pub fn dispatch<K: Kernel>(level: Level, kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    match level {
        Level::Avx512 => {
            if let Some(v4) = pulp::x86::V4::try_new() {
                return v4.vectorize(x86::Run(v4, kernel));
            }
        }
        Level::Avx2 => {
            if let Some(v3) = pulp::x86::V3::try_new() {
                return v3.vectorize(x86::Run(v3, kernel));
            }
        }
        Level::Baseline => {}
    }
    kernel.run(Baseline)
}

/// Plain arrays, which the compiler vectorises as it can.
#[derive(Clone, Copy)]
struct Baseline;

#[inline(always)]
fn map2(a: [f32; LANES], b: [f32; LANES], f: impl Fn(f32, f32) -> f32) -> [f32; LANES] {
    std::array::from_fn(|i| f(a[i], b[i]))
}

#[inline(always)]
fn mask2(a: [f32; LANES], b: [f32; LANES], f: impl Fn(f32, f32) -> bool) -> u16 {
    (0..LANES).fold(0, |mask, i| mask | u16::from(f(a[i], b[i])) << i)
}

impl Lanes for Baseline {
    type F = [f32; LANES];
    #[inline(always)]
    fn splat(self, x: f32) -> Self::F {
        [x; LANES]
    }
    #[inline(always)]
    fn load(self, x: &F32x16) -> Self::F {
        x.0
    }
    #[inline(always)]
    fn store(self, x: Self::F) -> F32x16 {
        F32x16(x)
    }
    #[inline(always)]
    fn add(self, a: Self::F, b: Self::F) -> Self::F {
        map2(a, b, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, a: Self::F, b: Self::F) -> Self::F {
        map2(a, b, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, a: Self::F, b: Self::F) -> Self::F {
        map2(a, b, |a, b| a * b)
    }
    #[inline(always)]
    fn div(self, a: Self::F, b: Self::F) -> Self::F {
        map2(a, b, |a, b| a / b)
    }
    #[inline(always)]
    fn min(self, a: Self::F, b: Self::F) -> Self::F {
        // As `minps`: of +0 and -0 the second counts at every level. `f32::min` leaves that open.
        map2(a, b, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn max(self, a: Self::F, b: Self::F) -> Self::F {
        map2(a, b, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn abs(self, a: Self::F) -> Self::F {
        a.map(f32::abs)
    }
    #[inline(always)]
    fn less(self, a: Self::F, b: Self::F) -> u16 {
        mask2(a, b, |a, b| a < b)
    }
    #[inline(always)]
    fn less_equal(self, a: Self::F, b: Self::F) -> u16 {
        mask2(a, b, |a, b| a <= b)
    }
    #[inline(always)]
    fn select(self, mask: u16, a: Self::F, b: Self::F) -> Self::F {
        std::array::from_fn(|i| if mask >> i & 1 == 1 { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn halves(self, low: &Half, high: &Half) -> Self::F {
        std::array::from_fn(|i| if i < LANES / 2 { low[i] } else { high[i - LANES / 2] })
    }
    #[inline(always)]
    fn swap(self, a: Self::F) -> Self::F {
        std::array::from_fn(|i| a[i ^ (LANES / 2)])
    }
    #[inline(always)]
    fn lowest(self, a: Self::F) -> f32 {
        a.iter().fold(a[0], |m, &x| if x < m { x } else { m })
    }
    #[inline(always)]
    fn highest(self, a: Self::F) -> f32 {
        a.iter().fold(a[0], |m, &x| if x > m { x } else { m })
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::{__m256, __m256i, __m512, _CMP_LE_OQ, _CMP_LT_OQ};

    use pulp::x86::{V3, V4};
    use pulp::{NullaryFnOnce, cast};

    use super::{F32x16, Half, Kernel, LANES, Lanes};

    /// Kernel with the level it is compiled for.
    pub(super) struct Run<L, K>(pub L, pub K);

    impl<L: Lanes, K: Kernel> NullaryFnOnce for Run<L, K> {
        type Output = K::Output;
        #[inline(always)]
        fn call(self) -> K::Output {
            self.1.run(self.0)
        }
    }

    impl Lanes for V4 {
        type F = __m512;
        #[inline(always)]
        fn splat(self, x: f32) -> __m512 {
            self.avx512f._mm512_set1_ps(x)
        }
        #[inline(always)]
        fn load(self, x: &F32x16) -> __m512 {
            cast(x.0)
        }
        #[inline(always)]
        fn store(self, x: __m512) -> F32x16 {
            F32x16(cast(x))
        }
        #[inline(always)]
        fn add(self, a: __m512, b: __m512) -> __m512 {
            self.avx512f._mm512_add_ps(a, b)
        }
        #[inline(always)]
        fn sub(self, a: __m512, b: __m512) -> __m512 {
            self.avx512f._mm512_sub_ps(a, b)
        }
        #[inline(always)]
        fn mul(self, a: __m512, b: __m512) -> __m512 {
            self.avx512f._mm512_mul_ps(a, b)
        }
        #[inline(always)]
        fn div(self, a: __m512, b: __m512) -> __m512 {
            self.avx512f._mm512_div_ps(a, b)
        }
        #[inline(always)]
        fn min(self, a: __m512, b: __m512) -> __m512 {
            self.avx512f._mm512_min_ps(a, b)
        }
        #[inline(always)]
        fn max(self, a: __m512, b: __m512) -> __m512 {
            self.avx512f._mm512_max_ps(a, b)
        }
        #[inline(always)]
        fn abs(self, a: __m512) -> __m512 {
            self.avx512f._mm512_abs_ps(a)
        }
        #[inline(always)]
        fn less(self, a: __m512, b: __m512) -> u16 {
            self.avx512f._mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b)
        }
        #[inline(always)]
        fn less_equal(self, a: __m512, b: __m512) -> u16 {
            self.avx512f._mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b)
        }
        #[inline(always)]
        fn select(self, mask: u16, a: __m512, b: __m512) -> __m512 {
            self.avx512f._mm512_mask_blend_ps(mask, b, a)
        }
        #[inline(always)]
        fn halves(self, low: &Half, high: &Half) -> __m512 {
            let low = self.avx512f._mm512_castps256_ps512(cast(*low));
            self.avx512dq._mm512_insertf32x8::<1>(low, cast(*high))
        }
        #[inline(always)]
        fn swap(self, a: __m512) -> __m512 {
            // Quarters of 128 bits in the order 2, 3, 0, 1.
            self.avx512f._mm512_shuffle_f32x4::<0b01_00_11_10>(a, a)
        }
        #[inline(always)]
        fn lowest(self, a: __m512) -> f32 {
            self.avx512f._mm512_reduce_min_ps(a)
        }
        #[inline(always)]
        fn highest(self, a: __m512) -> f32 {
            self.avx512f._mm512_reduce_max_ps(a)
        }
    }

    /// Two halves of eight lanes.
    type Pair = (__m256, __m256);

    impl Lanes for V3 {
        type F = Pair;
        #[inline(always)]
        fn splat(self, x: f32) -> Pair {
            let half = self.avx._mm256_set1_ps(x);
            (half, half)
        }
        #[inline(always)]
        fn load(self, x: &F32x16) -> Pair {
            let halves: [[f32; LANES / 2]; 2] = cast(x.0);
            (cast(halves[0]), cast(halves[1]))
        }
        #[inline(always)]
        fn store(self, x: Pair) -> F32x16 {
            let halves: [[f32; LANES / 2]; 2] = [cast(x.0), cast(x.1)];
            F32x16(cast(halves))
        }
        #[inline(always)]
        fn add(self, a: Pair, b: Pair) -> Pair {
            (self.avx._mm256_add_ps(a.0, b.0), self.avx._mm256_add_ps(a.1, b.1))
        }
        #[inline(always)]
        fn sub(self, a: Pair, b: Pair) -> Pair {
            (self.avx._mm256_sub_ps(a.0, b.0), self.avx._mm256_sub_ps(a.1, b.1))
        }
        #[inline(always)]
        fn mul(self, a: Pair, b: Pair) -> Pair {
            (self.avx._mm256_mul_ps(a.0, b.0), self.avx._mm256_mul_ps(a.1, b.1))
        }
        #[inline(always)]
        fn div(self, a: Pair, b: Pair) -> Pair {
            (self.avx._mm256_div_ps(a.0, b.0), self.avx._mm256_div_ps(a.1, b.1))
        }
        #[inline(always)]
        fn min(self, a: Pair, b: Pair) -> Pair {
            (self.avx._mm256_min_ps(a.0, b.0), self.avx._mm256_min_ps(a.1, b.1))
        }
        #[inline(always)]
        fn max(self, a: Pair, b: Pair) -> Pair {
            (self.avx._mm256_max_ps(a.0, b.0), self.avx._mm256_max_ps(a.1, b.1))
        }
        #[inline(always)]
        fn abs(self, a: Pair) -> Pair {
            let sign = self.avx._mm256_set1_ps(-0.0);
            (self.avx._mm256_andnot_ps(sign, a.0), self.avx._mm256_andnot_ps(sign, a.1))
        }
        #[inline(always)]
        fn less(self, a: Pair, b: Pair) -> u16 {
            let low = self.avx._mm256_cmp_ps::<_CMP_LT_OQ>(a.0, b.0);
            let high = self.avx._mm256_cmp_ps::<_CMP_LT_OQ>(a.1, b.1);
            bits(self, low, high)
        }
        #[inline(always)]
        fn less_equal(self, a: Pair, b: Pair) -> u16 {
            let low = self.avx._mm256_cmp_ps::<_CMP_LE_OQ>(a.0, b.0);
            let high = self.avx._mm256_cmp_ps::<_CMP_LE_OQ>(a.1, b.1);
            bits(self, low, high)
        }
        #[inline(always)]
        fn select(self, mask: u16, a: Pair, b: Pair) -> Pair {
            let half = |shift: u16, a, b| self.avx._mm256_blendv_ps(b, a, lanes_of(self, mask >> shift));
            (half(0, a.0, b.0), half(8, a.1, b.1))
        }
        #[inline(always)]
        fn halves(self, low: &Half, high: &Half) -> Pair {
            (cast(*low), cast(*high))
        }
        #[inline(always)]
        fn swap(self, a: Pair) -> Pair {
            (a.1, a.0)
        }
        #[inline(always)]
        fn lowest(self, a: Pair) -> f32 {
            let eight: Half = cast(self.avx._mm256_min_ps(a.0, a.1));
            eight.iter().fold(eight[0], |m, &x| if x < m { x } else { m })
        }
        #[inline(always)]
        fn highest(self, a: Pair) -> f32 {
            let eight: Half = cast(self.avx._mm256_max_ps(a.0, a.1));
            eight.iter().fold(eight[0], |m, &x| if x > m { x } else { m })
        }
    }

    #[inline(always)]
    fn bits(v3: V3, low: __m256, high: __m256) -> u16 {
        (v3.avx._mm256_movemask_ps(low) | v3.avx._mm256_movemask_ps(high) << 8) as u16
    }

    /// Turns the lowest eight bits of a mask into the sign bits of eight lanes.
    #[inline(always)]
    fn lanes_of(v3: V3, mask: u16) -> __m256 {
        // Bit i moves to bit 31, the only one that a blend looks at.
        let places: __m256i = cast([31_i32, 30, 29, 28, 27, 26, 25, 24]);
        cast(v3.avx2._mm256_sllv_epi32(v3.avx._mm256_set1_epi32(i32::from(mask)), places))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All operations on 16 lanes of signed values.
    struct Everything(F32x16, F32x16);

    impl Kernel for Everything {
        type Output = (Vec<u32>, Vec<u16>);
        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> Self::Output {
            let (a, b) = (l.load(&self.0), l.load(&self.1));
            let values = [
                l.add(a, b),
                l.sub(a, b),
                l.mul(a, b),
                l.div(a, b),
                l.min(a, b),
                l.max(a, b),
                l.abs(a),
                l.select(0x9b35, a, b),
                l.splat(0.1),
                l.splat(l.lowest(a)),
                l.splat(l.highest(a)),
                l.swap(a),
                l.halves(&[0.1; LANES / 2], &[0.2; LANES / 2]),
                // A fused multiply-add would differ here.
                l.add(l.mul(a, b), l.mul(b, b)),
            ];
            let bits = values.iter().flat_map(|&v| l.store(v).0.map(f32::to_bits)).collect();
            (bits, vec![l.less(a, b), l.less_equal(a, b), l.less(b, a)])
        }
    }

    /// Every level of this machine gives the same bits as the baseline, on 1,000 pairs of vectors.
    #[test]
    fn all_processor_levels_give_equal_bits() {
        for round in 0..1000_u32 {
            let number = |i: usize, salt: u32| {
                let h = (i as u32 + 17 * round + salt).wrapping_mul(2_654_435_761);
                (h as f32 / u32::MAX as f32 - 0.5) * 10.0_f32.powi((h % 7) as i32)
            };
            let a = F32x16(std::array::from_fn(|i| number(i, 0)));
            let b = F32x16(std::array::from_fn(|i| if i % 5 == 0 { a.0[i] } else { number(i, 99) }));
            let reference = Everything(a, b).run(Baseline);
            for level in Level::available() {
                assert_eq!(dispatch(level, Everything(a, b)), reference, "{level:?}");
            }
        }
    }
}
