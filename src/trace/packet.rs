//! Packets: sixteen rays walk the tree together. In: rays that start near each other and go about the same way. Out: for each
//! lane what a single ray would have answered, bit for bit.
//!
//! Where all rays share an origin, planes through origin and edges are computed once for sixteen rays (Wald et al. 2001, Boulos
//! et al. 2007 for packets). Memory is what a walk waits for most, so some packets take turns.

use super::lanes::{Kernel, LANES, Lanes, Level, Sixteen, dispatch};
use super::planes::bits;
use super::rays::{Hit, Ray};
use super::tree::Tree;
use super::walk::Walk;

/// Distances to the far side of a box are widened by this factor.
pub const FAR_PAD: f32 = 1.000_000_4;

/// Reciprocal of a direction's component; one of exactly zero would give 0 x infinity in the slab test.
#[inline(always)]
pub fn inverse(d: f32) -> f32 {
    1.0 / if d.abs() >= 1e-20 {
        d
    } else if d < 0.0 {
        -1e-20
    } else {
        1e-20
    }
}

/// Sixteen rays; lanes beyond the given rays repeat the last one and are not active.
#[derive(Clone, Copy, Debug)]
pub struct Packet {
    pub(super) origin: [Sixteen; 3],
    pub(super) direction: [Sixteen; 3],
    pub(super) active: u16,
    /// All rays start at one point.
    shared: bool,
    /// All rays go up, or all go down, along each axis.
    one_octant: bool,
}

impl Packet {
    /// A packet of 1 to 16 rays.
    pub fn new(rays: &[Ray]) -> Self {
        let last = rays.len().min(LANES) - 1;
        let first = rays[0];
        let shared = rays[1..=last].iter().all(|r| r.origin == first.origin);
        let mut packet = Packet {
            origin: first.origin.map(|x| Sixteen([x; LANES])),
            direction: [Sixteen([0.0; LANES]); 3],
            active: u16::MAX >> (LANES - 1 - last),
            shared,
            one_octant: true,
        };
        for lane in 0..LANES {
            let ray = &rays[lane.min(last)];
            for axis in 0..3 {
                packet.direction[axis].0[lane] = ray.direction[axis];
                packet.one_octant &= (ray.direction[axis] < 0.0) == (first.direction[axis] < 0.0);
            }
            if !shared {
                for axis in 0..3 {
                    packet.origin[axis].0[lane] = ray.origin[axis];
                }
            }
        }
        packet
    }

    /// The ray of a lane.
    pub(super) fn ray(&self, lane: usize) -> Ray {
        let at = |v: &[Sixteen; 3]| [0, 1, 2].map(|i| v[i].0[lane]);
        Ray { origin: at(&self.origin), direction: at(&self.direction) }
    }
}

/// Lanes of each packet that meet anything.
pub fn occluded(tree: &Tree, level: Level, packets: &[Packet]) -> Vec<u16> {
    dispatch(level, Traced::<true> { tree, packets }).0
}

/// First hits: sixteen for each packet.
pub fn closest(tree: &Tree, level: Level, packets: &[Packet]) -> Vec<Option<Hit>> {
    dispatch(level, Traced::<false> { tree, packets }).1
}

/// Packets that are walked in turns: while one waits for memory, the others go on.
const TURNS: usize = 4;

/// Lanes that meet anything and, unless `ANY` hit will do, what they meet first.
struct Traced<'a, const ANY: bool> {
    tree: &'a Tree,
    packets: &'a [Packet],
}

/// Of each packet the lanes that met something, of each lane the first hit.
type Found = (Vec<u16>, Vec<Option<Hit>>);

impl<const ANY: bool> Kernel for Traced<'_, ANY> {
    type Output = Found;
    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Found {
        let hits = if ANY { 0 } else { self.packets.len() * LANES };
        let mut found = (vec![0; self.packets.len()], vec![None; hits]);
        self.alike::<L, true, true>(l, &mut found);
        self.alike::<L, true, false>(l, &mut found);
        self.alike::<L, false, true>(l, &mut found);
        self.alike::<L, false, false>(l, &mut found);
        found
    }
}

impl<const ANY: bool> Traced<'_, ANY> {
    /// Traces those packets whose rays start at one point (`SHARED`) and agree on the sign of each axis (`OCTANT`), or do not.
    #[inline(always)]
    fn alike<L: Lanes, const SHARED: bool, const OCTANT: bool>(&self, l: L, found: &mut Found) {
        let alike = |&i: &usize| (self.packets[i].shared, self.packets[i].one_octant) == (SHARED, OCTANT);
        let mut waiting = (0..self.packets.len()).filter(alike);
        let mut walks = Vec::new();
        for index in waiting.by_ref().take(TURNS) {
            walks.push((index, Walk::new(l, &self.packets[index])));
        }
        let mut turn = 0;
        while !walks.is_empty() {
            turn = if turn + 1 < walks.len() { turn + 1 } else { 0 };
            let (index, walk) = &mut walks[turn];
            if walk.step::<L, ANY, SHARED, OCTANT>(l, self.tree) {
                continue;
            }
            found.0[*index] = walk.met;
            if !ANY {
                let t = l.store(walk.limit).0;
                for lane in bits(walk.met) {
                    found.1[*index * LANES + lane] = Some(Hit { t: t[lane], triangle: walk.triangle[lane] });
                }
            }
            match waiting.next() {
                Some(next) => {
                    *index = next;
                    walk.restart(l, &self.packets[next]);
                }
                None => {
                    walks.swap_remove(turn);
                }
            }
        }
    }
}
