//! Walk of one packet through the tree, step by step. In: a packet. Out: the lanes that hit
//! something, with distances and triangles.
//!
//! At a node, a beam around the packet tests all eight boxes at once. The boxes that remain are
//! tested lane by lane, so that each child only waits for the lanes that enter it. If no more than
//! two lanes remain, the beam is drawn around these.

use crate::trace::kernel::beam::Beam;
use crate::trace::kernel::lanes::{F32x16, LANES, Lanes};
use crate::trace::kernel::planes::{PacketRays, bits, intersect};
use crate::trace::kernel::ray::{FAR_PAD, Packet};
use crate::trace::kernel::tree::{Child, Node, Tree, WIDTH};

/// Child that waits for the lanes that enter its box.
#[derive(Clone, Copy)]
pub struct Waiting {
    child: Child,
    entry: Entry,
}

/// Children that wait, the next one last.
pub type Stack = Vec<Waiting>;

/// Least entry distance into a box, number of the child, and lanes: bits 32 to 63, 16 to 18 and 0
/// to 15. It is one number because fields that are written apart and read together cost more than
/// all arithmetic on them. Distances are not negative, so entries sort as numbers do.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Entry(u64);

impl Entry {
    #[inline(always)]
    fn new(near: f32, child: usize, lanes: u16) -> Self {
        Entry(u64::from(near.to_bits()) << 32 | (child as u64) << 16 | u64::from(lanes))
    }
    #[inline(always)]
    fn near(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }
    #[inline(always)]
    fn child(self) -> usize {
        (self.0 >> 16) as usize % WIDTH
    }
    #[inline(always)]
    fn lanes(self) -> u16 {
        self.0 as u16
    }
}

/// Packet on its way through the tree.
pub struct Walk<'a, F> {
    pub packet: &'a Packet,
    rays: PacketRays<F>,
    inverse: [F32x16; 3],
    beam: Beam<F>,
    backwards: [bool; 3],
    /// Stack, reused for one packet after the other.
    pub stack: Stack,
    /// Lanes that hit something.
    pub met: u16,
    /// Distance beyond which hits of a lane do not count; -1 for lanes that are done.
    pub limit: F,
    /// Largest limit of all lanes.
    reach: f32,
    /// Mesh triangles of the lanes that hit something.
    pub triangle: [u32; LANES],
}

impl<'a, F: Copy> Walk<'a, F> {
    /// Starts with the next packet, at the root.
    #[inline(always)]
    pub fn restart<L: Lanes<F = F>>(&mut self, l: L, packet: &'a Packet) {
        *self = Walk::new(l, packet, std::mem::take(&mut self.stack));
    }

    /// Starts with a packet at the root.
    #[inline(always)]
    pub fn new<L: Lanes<F = F>>(l: L, packet: &'a Packet, mut stack: Stack) -> Self {
        let [x, y, z] = &packet.origin;
        let origin = [l.load(x), l.load(y), l.load(z)];
        let [x, y, z] = &packet.direction;
        let direction = [l.load(x), l.load(y), l.load(z)];
        let inverse = [inverses(l, direction[0]), inverses(l, direction[1]), inverses(l, direction[2])];
        stack.clear();
        stack.push(Waiting { child: Child::default(), entry: Entry::new(0.0, 0, packet.active) });
        Walk {
            packet,
            rays: PacketRays { origin, direction, inverse },
            inverse: [l.store(inverse[0]), l.store(inverse[1]), l.store(inverse[2])],
            beam: Beam::whole(l, &origin, &inverse),
            // Rays of a packet agree on their signs, so lane 0 tells them for all.
            backwards: [x.0[0] < 0.0, y.0[0] < 0.0, z.0[0] < 0.0],
            stack,
            met: 0,
            limit: l.select(packet.active, l.splat(packet.reach), l.splat(-1.0)),
            reach: packet.reach,
            triangle: [0; LANES],
        }
    }

    /// Visits the nearest child that waits, and returns false at the end. `ANY` stops a lane at its
    /// first hit; `SHARED` means that all rays start at one point.
    #[inline(always)]
    pub fn step<L: Lanes<F = F>, const ANY: bool, const SHARED: bool>(&mut self, l: L, tree: &Tree) -> bool {
        let (child, lanes) = loop {
            let Some(Waiting { child, entry }) = self.stack.pop() else { return false };
            // Not less than the limit: at an equal distance the triangle with the lower index
            // counts.
            let wanted = if ANY { !self.met } else { l.less_equal(l.splat(entry.near()), self.limit) };
            if entry.lanes() & wanted != 0 {
                break (child, entry.lanes() & wanted);
            }
        };
        if child.count == 0 {
            self.enter(l, tree, child, lanes);
            return true;
        }
        for triangle in &tree.triangles[child.first as usize..(child.first + child.count) as usize] {
            let (hit, t) = intersect::<L, SHARED>(l, triangle, lanes, &self.rays, self.packet);
            if ANY {
                self.met |= hit;
            } else if hit != 0 {
                self.keep(l, hit, t, triangle.id);
            }
        }
        !ANY || self.met != self.packet.active
    }

    /// Keeps nearer hits. Among equal distances the triangle with the lower index counts.
    #[inline(always)]
    fn keep<L: Lanes<F = F>>(&mut self, l: L, hit: u16, t: F, id: u32) {
        let mut better = hit & l.less(t, self.limit);
        let equal = hit & !better & l.less_equal(t, self.limit);
        for lane in bits(equal) {
            better |= u16::from(id < self.triangle[lane]) << lane;
        }
        for lane in bits(better) {
            self.triangle[lane] = id;
        }
        self.met |= better;
        self.limit = l.select(better, t, self.limit);
        self.reach = l.highest(self.limit);
    }

    /// Puts the children of a node on the stack, the nearest on top.
    #[inline(always)]
    fn enter<L: Lanes<F = F>>(&mut self, l: L, tree: &Tree, child: Child, lanes: u16) {
        let node = &tree.nodes[child.first as usize];
        // All lanes but the lowest. `step` enters a node with at least one lane, so the difference
        // does not underflow.
        let others = lanes & (lanes - 1);
        let (children, nears) = if others & others.wrapping_sub(1) == 0 {
            let (a, b) = (lanes.trailing_zeros(), 15 - lanes.leading_zeros());
            let beam = Beam::of_two(l, &self.packet.origin, &self.inverse, a as usize, b as usize);
            beam.meets(l, node, self.reach)
        } else {
            self.beam.meets(l, node, self.reach)
        };
        let mut entries = [Entry(0); WIDTH];
        let mut count = 0;
        for k in bits(children) {
            let k = k % WIDTH;
            // A beam of one lane is exact.
            let lanes = if others == 0 { lanes } else { lanes & self.meets(l, node, k) };
            if lanes != 0 {
                tree.fetch(node.child[k]);
                let entry = Entry::new(nears.0[k], k, lanes);
                let mut at = count % WIDTH;
                while at > 0 && entries[at - 1] < entry {
                    entries[at] = entries[at - 1];
                    at -= 1;
                }
                entries[at] = entry;
                count += 1;
            }
        }
        self.stack.extend(entries.iter().take(count).map(|&entry| Waiting { child: node.child[entry.child()], entry }));
    }

    /// Returns the lanes that enter the box of a child before their limit.
    #[inline(always)]
    fn meets<L: Lanes<F = F>>(&self, l: L, node: &Node, child: usize) -> u16 {
        let mut near = l.splat(0.0);
        let mut far = l.splat(f32::INFINITY);
        for i in 0..3 {
            let plane = |at: f32| l.mul(l.sub(l.splat(at), self.rays.origin[i]), self.rays.inverse[i]);
            let (low, high) = (node.planes[i][0][child], -node.planes[i][1][child]);
            let (first, last) = if self.backwards[i] { (high, low) } else { (low, high) };
            near = l.max(near, plane(first));
            far = l.min(far, plane(last));
        }
        l.less_equal(near, l.min(l.mul(far, l.splat(FAR_PAD)), self.limit))
    }
}

/// Does the work of `ray::inverse` in lanes.
#[inline(always)]
fn inverses<L: Lanes>(l: L, d: L::F) -> L::F {
    let tiny = l.less(l.abs(d), l.splat(1e-20));
    let negative = l.less(d, l.splat(0.0));
    let smallest = l.select(negative, l.splat(-1e-20), l.splat(1e-20));
    l.div(l.splat(1.0), l.select(tiny, smallest, d))
}
