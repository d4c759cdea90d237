//! Fans, the sixteen rays of a block of texels, and cones, their bounds. In: directions, or a part
//! of the sky's square. Out: directions and bounds for packets and candidates.

use crate::trace::kernel::lanes::F32x16;

/// Directions of sixteen rays from one point.
#[derive(Clone, Copy, Debug)]
pub struct Fan(pub [F32x16; 3]);

impl Fan {
    /// Returns the direction of a lane.
    pub fn direction(&self, lane: usize) -> [f32; 3] {
        [0, 1, 2].map(|i| self.0[i].0[lane])
    }
}

/// Box around some directions: `[axis]`, f32.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cone {
    pub centre: [f32; 3],
    /// Half its width, rounded up.
    pub half: [f32; 3],
    /// Axes along which all directions go backwards. Along the others all go forwards, except for
    /// [`Cone::crosses`].
    pub backwards: [bool; 3],
    /// Axes along which some directions may go forwards and some backwards.
    pub crosses: [bool; 3],
}

impl Cone {
    /// Creates the cone between two ends, which must not lie on different sides of zero.
    pub fn between(low: [f64; 3], high: [f64; 3]) -> Self {
        let centre = [0, 1, 2].map(|i| (0.5 * (low[i] + high[i])) as f32);
        // The margin is above all rounding of the ends, and far below a texel.
        let half = [0, 1, 2].map(|i| {
            let centre = f64::from(centre[i]);
            (high[i] - centre).max(centre - low[i]) as f32 * 1.000_001 + 1e-7
        });
        Cone { centre, half, backwards: [0, 1, 2].map(|i| low[i] + high[i] < 0.0), crosses: [false; 3] }
    }

    /// Returns a cone of these directions and of all that are shifted from them by up to `way`.
    pub fn moved(&self, way: [f32; 3]) -> Self {
        let mut cone = *self;
        for (i, &way) in way.iter().enumerate() {
            cone.centre[i] += 0.5 * way;
            cone.half[i] += 0.5 * way.abs() + 1e-7;
            let towards = way != 0.0 && (way < 0.0) != self.backwards[i];
            cone.crosses[i] |= towards && cone.centre[i].abs() <= cone.half[i];
        }
        cone
    }

    /// Returns bounds of the dot products with a vector, up to rounding.
    #[inline(always)]
    pub fn dot(&self, v: [f32; 3]) -> [f32; 2] {
        let middle = self.centre[0] * v[0] + self.centre[1] * v[1] + self.centre[2] * v[2];
        let reach = self.half[0] * v[0].abs() + self.half[1] * v[1].abs() + self.half[2] * v[2].abs();
        [middle - reach, middle + reach]
    }

    /// Returns the least and greatest magnitude along each axis, for axes along which directions do
    /// not cross.
    pub fn sizes(&self) -> [[f32; 2]; 3] {
        [0, 1, 2].map(|i| {
            let size = self.centre[i].abs();
            [(size - self.half[i]).max(0.0), size + self.half[i]]
        })
    }
}
