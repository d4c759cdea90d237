//! Beam: bounds of the rays of a packet, or of some of them. In: a node. Out: the children that any
//! of the rays may enter, all eight boxes in one test.
//!
//! Interval arithmetic on slabs (Boulos et al. 2006, "Geometric and arithmetic culling methods for
//! entire ray packets"): for each axis the least and the greatest reciprocal direction bound where
//! the rays enter and leave. Rounding is monotone, so a beam never refuses a box that one of its
//! rays enters by the same arithmetic.

use crate::trace::kernel::fan::Cone;
use crate::trace::kernel::lanes::{F32x16, LANES, Lanes};
use crate::trace::kernel::ray::{FAR_PAD, inverse};
use crate::trace::kernel::tree::{Node, WIDTH};

/// Bounds of some rays. Lanes 0 to 7 are for the sides at which the rays enter the eight boxes, and
/// lanes 8 to 15 for the sides at which they leave, with the sign reversed.
#[derive(Clone, Copy)]
pub struct Beam<F> {
    origin: [F; 3],
    /// Smallest and largest magnitude of the reciprocal directions.
    inverse: [[F; 2]; 3],
    /// Side at which the rays enter: 1 if they go backwards.
    side: [usize; 3],
}

impl<F: Copy> Beam<F> {
    /// Bounds all rays of a packet, which agree on the sign of each axis.
    #[inline(always)]
    pub fn whole<L: Lanes<F = F>>(l: L, origin: &[F; 3], inverse: &[F; 3]) -> Self {
        let axis = |i: usize| Axis {
            origin: [l.lowest(origin[i]), l.highest(origin[i])],
            inverse: [l.lowest(inverse[i]), l.highest(inverse[i])],
        };
        Beam::new(l, &[axis(0), axis(1), axis(2)])
    }

    /// Bounds two rays of a packet, or one ray given twice.
    #[inline(always)]
    pub fn of_two<L: Lanes<F = F>>(l: L, origin: &[F32x16; 3], inverse: &[F32x16; 3], a: usize, b: usize) -> Self {
        let (a, b) = (a % LANES, b % LANES);
        let mut axes = [Axis::default(); 3];
        for i in 0..3 {
            let (from, ends) = ([origin[i].0[a], origin[i].0[b]], [inverse[i].0[a], inverse[i].0[b]]);
            let ends = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            axes[i] = Axis { origin: [from[0].min(from[1]), from[0].max(from[1])], inverse: ends };
        }
        Beam::new(l, &axes)
    }

    /// Bounds all rays from a point in a cone. An axis along which they cross bounds nothing.
    #[inline(always)]
    pub fn of_cone<L: Lanes<F = F>>(l: L, origin: [f32; 3], cone: &Cone) -> Self {
        let (sizes, mut axes) = (cone.sizes(), [Axis::default(); 3]);
        for i in 0..3 {
            let [most, least] = sizes[i].map(inverse);
            let inverse = if cone.backwards[i] { [-most, -least] } else { [least, most] };
            let bounded = Axis { origin: [origin[i]; 2], inverse };
            axes[i] = if cone.crosses[i] { UNBOUNDED } else { bounded };
        }
        Beam::new(l, &axes)
    }

    #[inline(always)]
    fn new<L: Lanes<F = F>>(l: L, axes: &[Axis; 3]) -> Self {
        let zero = l.splat(0.0);
        let mut beam = Beam { origin: [zero; 3], inverse: [[zero; 2]; 3], side: [0; 3] };
        for (i, axis) in axes.iter().enumerate() {
            let Axis { origin: [low, high], inverse: [first, last] } = *axis;
            beam.side[i] = usize::from(last < 0.0);
            let (near, far) = if last < 0.0 { (-low, high) } else { (high, -low) };
            beam.origin[i] = l.select(ENTERING, l.splat(near), l.splat(far));
            beam.inverse[i] = [l.splat(first.abs()), l.splat(last.abs())];
        }
        beam
    }

    /// Returns the children whose boxes the rays may enter before `reach`, one bit each, and the
    /// least distance at which they enter.
    #[inline(always)]
    pub fn meets<L: Lanes<F = F>>(&self, l: L, node: &Node, reach: f32) -> (u16, F32x16) {
        // Absent children are entered at infinity, and so refused.
        let reach = reach.min(f32::MAX / 2.0);
        // Half of f32::MAX, because FAR_PAD would lift f32::MAX itself to infinity, and absent
        // children would pass.
        let mut bounds = l.select(ENTERING, l.splat(0.0), l.splat(-reach));
        for i in 0..3 {
            let side = self.side[i] & 1;
            let planes = l.halves(&node.planes[i][side], &node.planes[i][side ^ 1]);
            let from = l.sub(planes, self.origin[i]);
            // Distances of leaving are negated, so one maximum over the axes gives both the last
            // entry and the first exit. The smaller product is the bound, whichever sign `from`
            // has.
            bounds = l.max(bounds, l.min(l.mul(from, self.inverse[i][0]), l.mul(from, self.inverse[i][1])));
        }
        let far = l.mul(l.sub(l.splat(0.0), l.swap(bounds)), l.splat(FAR_PAD));
        (l.less_equal(bounds, far) & ENTERING, l.store(bounds))
    }
}

/// Lanes of the sides at which rays enter.
const ENTERING: u16 = 0x00ff;

/// Axis without bounds: its planes are so far off that rays enter before any start and leave after
/// any end.
const UNBOUNDED: Axis = Axis { origin: [-1e30, 1e30], inverse: [1.0; 2] };

/// Bounds along one axis.
#[derive(Clone, Copy, Default)]
struct Axis {
    origin: [f32; 2],
    inverse: [f32; 2],
}

const _: () = assert!(2 * WIDTH == LANES);
