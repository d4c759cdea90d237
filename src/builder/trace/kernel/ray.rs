//! Rays, their hits and packets of rays. In: starts and directions, f32, relative to the scene
//! origin. Out: up to sixteen rays side by side, lane by lane.

use crate::trace::kernel::lanes::{F32x16, LANES};

/// Ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start relative to the scene origin, metres.
    pub origin: [f32; 3],
    /// Direction, about unit length.
    pub direction: [f32; 3],
}

/// First hit of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in units of the direction's length.
    pub t: f32,
    /// Index of the triangle in the mesh.
    pub triangle: u32,
}

/// Factor by which distances to the far side of a box are widened. It is 1 + 6 x 2^-24, one
/// rounding each for the difference, the reciprocal and the product of the near and of the far
/// distance (Ize 2013, "Robust BVH ray traversal", JCGT 2(2)).
pub const FAR_PAD: f32 = 1.000_000_4;

/// Returns the reciprocal of a direction's component. A component of exactly zero would give 0 x
/// infinity in the slab test, so it is replaced by a tiny one.
#[inline(always)]
pub fn inverse(d: f32) -> f32 {
    // The reciprocal is at most 1e20, so its product with any distance below 1e18 m is finite in
    // f32.
    1.0 / if d.abs() >= 1e-20 {
        d
    } else if d < 0.0 {
        -1e-20
    } else {
        1e-20
    }
}

/// Up to sixteen rays that agree on the sign of each axis. Lanes beyond them repeat the last ray
/// and are not active.
#[derive(Clone, Copy, Debug)]
pub struct Packet {
    pub(super) origin: [F32x16; 3],
    pub(super) direction: [F32x16; 3],
    pub(super) active: u16,
    /// Distance beyond which hits do not count.
    pub(super) reach: f32,
    /// True if all rays start at one point.
    pub(super) shared: bool,
    /// Places of the rays in the list of all rays.
    pub(super) places: [u32; LANES],
}

impl Packet {
    /// Creates a packet of 1 to 16 of some rays.
    pub(super) fn new(rays: &[Ray], places: &[u32], reach: f32) -> Self {
        let last = places.len().min(LANES) - 1;
        let ray = |lane: usize| rays[places[lane.min(last)] as usize];
        let from = ray(0).origin;
        let shared = (1..=last).all(|lane| ray(lane).origin == from);
        let mut packet = Packet {
            origin: from.map(|x| F32x16([x; LANES])),
            direction: [F32x16([0.0; LANES]); 3],
            active: u16::MAX >> (LANES - 1 - last),
            reach,
            shared,
            places: std::array::from_fn(|lane| places[lane.min(last)]),
        };
        for lane in 0..LANES {
            let ray = ray(lane);
            for axis in 0..3 {
                packet.direction[axis].0[lane] = ray.direction[axis];
                if !shared {
                    packet.origin[axis].0[lane] = ray.origin[axis];
                }
            }
        }
        packet
    }

    /// Returns the ray of a lane.
    pub(super) fn ray(&self, lane: usize) -> Ray {
        let at = |v: &[F32x16; 3]| [0, 1, 2].map(|i| v[i].0[lane]);
        Ray { origin: at(&self.origin), direction: at(&self.direction) }
    }
}
