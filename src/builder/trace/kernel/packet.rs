//! Packets: sixteen rays traverse the tree together. In: rays that start near each other and have
//! similar directions. Out: for each lane the answer of a single ray, bit for bit.
//!
//! If all rays share an origin, planes through origin and edges are computed once for sixteen rays
//! (Wald et al. 2001, Boulos et al. 2007 for packets). A walk mostly waits for memory, so some
//! packets take turns.

use std::cell::RefCell;

use crate::trace::kernel::lanes::{Kernel, LANES, Lanes, Level, dispatch};
use crate::trace::kernel::planes::bits;
use crate::trace::kernel::ray::{Hit, Packet, Ray};
use crate::trace::kernel::tree::Tree;
use crate::trace::kernel::walk::{Stack, Walk};

/// Returns for each ray true if it hits anything.
pub fn occluded(tree: &Tree, level: Level, rays: &[Ray]) -> Vec<bool> {
    let mut met = vec![false; rays.len()];
    trace::<true>(tree, level, rays, f32::INFINITY, &mut met, &mut []);
    met
}

/// Returns the first hit of each ray, no farther away than `reach`.
pub fn closest(tree: &Tree, level: Level, rays: &[Ray], reach: f32) -> Vec<Option<Hit>> {
    let mut hits = vec![None; rays.len()];
    trace::<false>(tree, level, rays, reach, &mut [], &mut hits);
    hits
}

/// Memory of a thread for its packets. Most calls are for a few packets only, and allocations would
/// cost as much as their first steps.
#[derive(Default)]
struct Space {
    order: Vec<u32>,
    packets: Vec<Packet>,
    stacks: Vec<Stack>,
}

thread_local! {
    static SPACE: RefCell<Space> = RefCell::default();
}

fn trace<const ANY: bool>(
    tree: &Tree,
    level: Level,
    rays: &[Ray],
    reach: f32,
    met: &mut [bool],
    hits: &mut [Option<Hit>],
) {
    SPACE.with_borrow_mut(|Space { order, packets, stacks }| {
        // Counting sort by octant is stable, so rays that the caller put together stay together.
        let mut counts = [0; 8];
        rays.iter().for_each(|ray| counts[octant(ray)] += 1);
        let mut sum = 0;
        let mut next = counts.map(|count| {
            sum += count;
            sum - count
        });
        order.resize(rays.len(), 0);
        for (place, ray) in rays.iter().enumerate() {
            let at = &mut next[octant(ray)];
            order[*at] = place as u32;
            *at += 1;
        }
        // Each entry of `next` has now moved on to the end of its octant, which is the start of the
        // one after it.
        let starts = [0].into_iter().chain(next);
        let alike = starts.zip(next).flat_map(|(start, end)| order[start..end].chunks(LANES));
        packets.clear();
        packets.extend(alike.map(|places| Packet::new(rays, places, reach)));
        dispatch(level, Traced::<ANY> { tree, packets, stacks, met, hits });
    });
}

/// Returns the signs of a ray's direction as one number.
fn octant(ray: &Ray) -> usize {
    ray.direction.iter().fold(0, |octant, &d| octant << 1 | usize::from(d < 0.0))
}

/// Number of packets that are walked in turns: while one waits for memory, the others go on.
const TURNS: usize = 4;

/// Kernel that traces packets: it notes which rays hit anything or, unless `ANY` hit will do, their
/// first hits.
struct Traced<'a, const ANY: bool> {
    tree: &'a Tree,
    packets: &'a [Packet],
    stacks: &'a mut Vec<Stack>,
    met: &'a mut [bool],
    hits: &'a mut [Option<Hit>],
}

impl<const ANY: bool> Kernel for Traced<'_, ANY> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) {
        self.alike::<L, true>(l);
        self.alike::<L, false>(l);
    }
}

impl<const ANY: bool> Traced<'_, ANY> {
    /// Traces the packets whose rays start at one point (`SHARED`), or the others.
    #[inline(always)]
    fn alike<L: Lanes, const SHARED: bool>(&mut self, l: L) {
        let packets = self.packets;
        let mut waiting = packets.iter().filter(|packet| packet.shared == SHARED);
        let mut walks: [Option<Walk<L::F>>; TURNS] =
            std::array::from_fn(|_| Some(Walk::new(l, waiting.next()?, self.stacks.pop().unwrap_or_default())));
        let mut under_way = walks.iter().flatten().count();
        let mut turn = 0;
        while under_way > 0 {
            turn = (turn + 1) % TURNS;
            let Some(walk) = &mut walks[turn] else { continue };
            if walk.step::<L, ANY, SHARED>(l, self.tree) {
                continue;
            }
            let (places, t) = (&walk.packet.places, l.store(walk.limit).0);
            for lane in bits(walk.met) {
                let place = places[lane] as usize;
                if ANY {
                    self.met[place] = true;
                } else {
                    self.hits[place] = Some(Hit { t: t[lane], triangle: walk.triangle[lane] });
                }
            }
            match waiting.next() {
                Some(next) => walk.restart(l, next),
                None => {
                    self.stacks.push(std::mem::take(&mut walk.stack));
                    walks[turn] = None;
                    under_way -= 1;
                }
            }
        }
    }
}
