//! Packets: sixteen rays walk the tree together. In: rays that start near each other and go about the same way. Out: for each
//! lane what a single ray would have answered, bit for bit.
//!
//! Where all rays share an origin, planes through origin and edges are computed once for sixteen rays (Wald et al. 2001, Boulos
//! et al. 2007 for packets; the walk is over obvhs' tree).

use super::lanes::{Kernel, LANES, Lanes, Level, Sixteen, dispatch};
use super::rays::{Hit, Ray};
use super::tree::{Child, Pair, Tree};
use super::triangle::{EdgeTriangle, intersect_f64};

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
    origin: [Sixteen; 3],
    direction: [Sixteen; 3],
    active: u16,
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

    fn ray(&self, lane: usize) -> Ray {
        let at = |v: &[Sixteen; 3]| [0, 1, 2].map(|i| v[i].0[lane]);
        Ray { origin: at(&self.origin), direction: at(&self.direction) }
    }
}

/// Lanes of each packet that meet anything.
pub fn occluded(tree: &Tree, level: Level, packets: &[Packet]) -> Vec<u16> {
    dispatch(level, Occluded { tree, packets })
}

/// First hits: sixteen for each packet.
pub fn closest(tree: &Tree, level: Level, packets: &[Packet]) -> Vec<Option<Hit>> {
    dispatch(level, Closest { tree, packets })
}

struct Occluded<'a> {
    tree: &'a Tree,
    packets: &'a [Packet],
}

impl Kernel for Occluded<'_> {
    type Output = Vec<u16>;
    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Vec<u16> {
        let mut stack = Vec::with_capacity(64);
        let mut met = Vec::with_capacity(self.packets.len());
        for packet in self.packets {
            let mut state = State::new(l, packet);
            match (packet.shared, packet.one_octant) {
                (true, true) => walk::<L, true, true, true>(l, self.tree, packet, &mut state, &mut stack),
                (true, false) => walk::<L, true, true, false>(l, self.tree, packet, &mut state, &mut stack),
                (false, true) => walk::<L, true, false, true>(l, self.tree, packet, &mut state, &mut stack),
                (false, false) => walk::<L, true, false, false>(l, self.tree, packet, &mut state, &mut stack),
            }
            met.push(state.met);
        }
        met
    }
}

struct Closest<'a> {
    tree: &'a Tree,
    packets: &'a [Packet],
}

impl Kernel for Closest<'_> {
    type Output = Vec<Option<Hit>>;
    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Vec<Option<Hit>> {
        let mut stack = Vec::with_capacity(64);
        let mut hits = Vec::with_capacity(self.packets.len() * LANES);
        for packet in self.packets {
            let mut state = State::new(l, packet);
            match (packet.shared, packet.one_octant) {
                (true, true) => walk::<L, false, true, true>(l, self.tree, packet, &mut state, &mut stack),
                (true, false) => walk::<L, false, true, false>(l, self.tree, packet, &mut state, &mut stack),
                (false, true) => walk::<L, false, false, true>(l, self.tree, packet, &mut state, &mut stack),
                (false, false) => walk::<L, false, false, false>(l, self.tree, packet, &mut state, &mut stack),
            }
            let t = l.store(state.limit).0;
            hits.extend(
                (0..LANES).map(|lane| {
                    (state.met >> lane & 1 == 1).then(|| Hit { t: t[lane], triangle: state.triangle[lane] })
                }),
            );
        }
        hits
    }
}

/// What a packet has found so far.
struct State<F> {
    /// Lanes that met something.
    met: u16,
    /// Distance beyond which a lane is not interested; -1 for lanes that are done.
    limit: F,
    triangle: [u32; LANES],
}

impl<F: Copy> State<F> {
    #[inline(always)]
    fn new<L: Lanes<F = F>>(l: L, packet: &Packet) -> Self {
        let limit = l.select(packet.active, l.splat(f32::INFINITY), l.splat(-1.0));
        State { met: 0, limit, triangle: [0; LANES] }
    }
}

/// A node that waits, and where the packet's rays enter it.
struct Waiting<F> {
    child: Child,
    near: F,
}

/// Vectors of a packet in registers.
struct Rays<F> {
    origin: [F; 3],
    direction: [F; 3],
    inverse: [F; 3],
}

/// Walks the tree nearest child first; `ANY` stops a lane at its first hit, `SHARED` says that all rays start at one point,
/// `OCTANT` that they agree on the sign of each axis.
#[inline(always)]
fn walk<L: Lanes, const ANY: bool, const SHARED: bool, const OCTANT: bool>(
    l: L,
    tree: &Tree,
    packet: &Packet,
    state: &mut State<L::F>,
    stack: &mut Vec<Waiting<L::F>>,
) {
    let load = |v: &[Sixteen; 3]| [l.load(&v[0]), l.load(&v[1]), l.load(&v[2])];
    let direction = load(&packet.direction);
    let inverse = [inverses(l, direction[0]), inverses(l, direction[1]), inverses(l, direction[2])];
    let rays = Rays { origin: load(&packet.origin), direction, inverse };
    let first = packet.ray(0);
    // Which way the packet goes: the first ray speaks for all, which costs only time where it is wrong.
    let way = first.direction;
    stack.clear();
    let mut child = tree.root;
    loop {
        if child.count > 0 {
            for k in child.first as usize..(child.first + child.count) as usize {
                test::<L, ANY, SHARED>(l, tree, k, &rays, packet, first.origin, state);
            }
            if ANY && state.met == packet.active {
                return;
            }
        } else {
            let pair = &tree.pairs[child.first as usize];
            let (near0, in0) = enter::<L, SHARED, OCTANT>(l, pair, 0, &rays, &first, state.limit);
            let (near1, in1) = enter::<L, SHARED, OCTANT>(l, pair, 1, &rays, &first, state.limit);
            if in0 != 0 && in1 != 0 {
                let ahead = |i: usize| (pair.low[1][i] + pair.high[1][i]) - (pair.low[0][i] + pair.high[0][i]);
                let left_first = ahead(0) * way[0] + ahead(1) * way[1] + ahead(2) * way[2] >= 0.0;
                let (near, far, entry) = if left_first { (0, 1, near1) } else { (1, 0, near0) };
                stack.push(Waiting { child: pair.child[far], near: entry });
                child = pair.child[near];
                continue;
            } else if in0 != 0 {
                child = pair.child[0];
                continue;
            } else if in1 != 0 {
                child = pair.child[1];
                continue;
            }
        }
        loop {
            let Some(next) = stack.pop() else { return };
            if l.not_above(next.near, state.limit) != 0 {
                child = next.child;
                break;
            }
        }
    }
}

/// [`inverse`] in lanes.
#[inline(always)]
fn inverses<L: Lanes>(l: L, d: L::F) -> L::F {
    let tiny = l.less(l.abs(d), l.splat(1e-20));
    let negative = l.less(d, l.splat(0.0));
    let smallest = l.select(negative, l.splat(-1e-20), l.splat(1e-20));
    l.div(l.splat(1.0), l.select(tiny, smallest, d))
}

/// Entry distances into one box and the lanes that enter it before their limit.
#[inline(always)]
fn enter<L: Lanes, const SHARED: bool, const OCTANT: bool>(
    l: L,
    pair: &Pair,
    side: usize,
    rays: &Rays<L::F>,
    first: &Ray,
    limit: L::F,
) -> (L::F, u16) {
    let mut near = l.splat(0.0);
    let mut far = l.splat(f32::INFINITY);
    for i in 0..3 {
        let plane = |at: f32| {
            let from = if SHARED { l.splat(at - first.origin[i]) } else { l.sub(l.splat(at), rays.origin[i]) };
            l.mul(from, rays.inverse[i])
        };
        let (low, high) = (pair.low[side][i], pair.high[side][i]);
        let (enter, leave) = if OCTANT {
            let backwards = first.direction[i] < 0.0;
            (plane(if backwards { high } else { low }), plane(if backwards { low } else { high }))
        } else {
            let (a, b) = (plane(low), plane(high));
            (l.min(a, b), l.max(a, b))
        };
        near = l.max(near, enter);
        far = l.min(far, leave);
    }
    let far = l.min(l.mul(far, l.splat(FAR_PAD)), limit);
    (near, l.not_above(near, far))
}

/// Tests one triangle; the arithmetic of [`super::triangle::intersect`] lane by lane.
#[inline(always)]
fn test<L: Lanes, const ANY: bool, const SHARED: bool>(
    l: L,
    tree: &Tree,
    index: usize,
    rays: &Rays<L::F>,
    packet: &Packet,
    origin: [f32; 3],
    state: &mut State<L::F>,
) {
    let triangle = &tree.triangles[index];
    let seen = if SHARED { shared(l, triangle, origin) } else { apart(l, triangle, &rays.origin) };
    let dot = |e: &[L::F; 3]| {
        let xy = l.add(l.mul(rays.direction[0], e[0]), l.mul(rays.direction[1], e[1]));
        l.add(xy, l.mul(rays.direction[2], e[2]))
    };
    let (u, v, w) = (dot(&seen.edges[0]), dot(&seen.edges[1]), dot(&seen.edges[2]));
    let (low, high) = (l.min(l.min(u, v), w), l.max(l.max(u, v), w));
    let minus_doubt = l.sub(l.splat(0.0), seen.doubt);
    let wanted = packet.active & if ANY { !state.met } else { u16::MAX };
    let missed = l.less(low, minus_doubt) & l.less(seen.doubt, high);
    let near_edge = l.less(low, seen.doubt) & l.less(minus_doubt, high);
    if wanted & !missed == 0 {
        return;
    }
    let slope = dot(&seen.normal);
    let doubtful = wanted & !missed & (near_edge | l.less(l.abs(slope), seen.edge_on));
    // Lanes that are decided in f64 divide by one here: no infinity or NaN is made.
    let t = l.div(seen.height, l.select(missed | doubtful, l.splat(1.0), slope));
    let forward = l.less(l.splat(0.0), t) & l.less(t, l.splat(f32::INFINITY));
    let mut hit = wanted & !missed & !doubtful & forward;
    let mut t = t;
    if doubtful != 0 {
        (t, hit) = decide(l, triangle, packet, doubtful, t, hit);
    }
    if hit == 0 {
        return;
    }
    if ANY {
        state.met |= hit;
        state.limit = l.select(hit, l.splat(-1.0), state.limit);
    } else {
        let id = tree.mesh_triangle[index];
        let mut better = hit & l.less(t, state.limit);
        let equal = hit & !better & l.not_above(t, state.limit);
        for lane in bits(equal) {
            better |= u16::from(id < state.triangle[lane]) << lane;
        }
        for lane in bits(better) {
            state.triangle[lane] = id;
        }
        state.met |= better;
        state.limit = l.select(better, t, state.limit);
    }
}

/// Doubtful lanes one by one in f64.
#[cold]
#[inline(never)]
fn decide<L: Lanes>(
    l: L,
    triangle: &EdgeTriangle,
    packet: &Packet,
    doubtful: u16,
    t: L::F,
    mut hit: u16,
) -> (L::F, u16) {
    let mut distances = l.store(t);
    for lane in bits(doubtful) {
        let ray = packet.ray(lane);
        if let Some(t) = intersect_f64(ray.origin, ray.direction, &triangle.corners) {
            distances.0[lane] = t;
            hit |= 1 << lane;
        }
    }
    (l.load(&distances), hit)
}

/// Set bits, lowest first.
#[inline(always)]
fn bits(mask: u16) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(mask), |m| Some(m & m.wrapping_sub(1)))
        .take_while(|&m| m != 0)
        .map(|m| m.trailing_zeros() as usize)
}

/// A triangle as the lanes see it.
struct Planes<F> {
    edges: [[F; 3]; 3],
    normal: [F; 3],
    height: F,
    doubt: F,
    edge_on: F,
}

/// One origin for all lanes: computed once.
#[inline(always)]
fn shared<L: Lanes>(l: L, triangle: &EdgeTriangle, origin: [f32; 3]) -> Planes<L::F> {
    let seen = triangle.seen_from(origin);
    let splat = |v: [f32; 3]| [l.splat(v[0]), l.splat(v[1]), l.splat(v[2])];
    Planes {
        edges: [splat(seen.edges[0]), splat(seen.edges[1]), splat(seen.edges[2])],
        normal: splat(seen.normal),
        height: l.splat(seen.height),
        doubt: l.splat(seen.doubt),
        edge_on: l.splat(seen.edge_on),
    }
}

/// An origin for each lane: [`EdgeTriangle::seen_from`] in lanes.
#[inline(always)]
fn apart<L: Lanes>(l: L, triangle: &EdgeTriangle, origin: &[L::F; 3]) -> Planes<L::F> {
    let fixed = triangle.fixed();
    let relative = |corner: usize| {
        let c = triangle.corners[corner];
        [l.sub(l.splat(c[0]), origin[0]), l.sub(l.splat(c[1]), origin[1]), l.sub(l.splat(c[2]), origin[2])]
    };
    let (a, b, c) = (relative(0), relative(1), relative(2));
    let cross = |p: &[L::F; 3], e: [f32; 3]| {
        let e = [l.splat(e[0]), l.splat(e[1]), l.splat(e[2])];
        [
            l.sub(l.mul(p[1], e[2]), l.mul(p[2], e[1])),
            l.sub(l.mul(p[2], e[0]), l.mul(p[0], e[2])),
            l.sub(l.mul(p[0], e[1]), l.mul(p[1], e[0])),
        ]
    };
    let lower = |edge: usize, from: [L::F; 3], to: [L::F; 3]| if triangle.backwards[edge] { to } else { from };
    let edges = [cross(&lower(0, b, c), fixed.bc), cross(&lower(1, c, a), fixed.ca), cross(&lower(2, a, b), fixed.ab)];
    let normal = [l.splat(fixed.normal[0]), l.splat(fixed.normal[1]), l.splat(fixed.normal[2])];
    let xy = l.add(l.mul(a[0], normal[0]), l.mul(a[1], normal[1]));
    let height = l.add(xy, l.mul(a[2], normal[2]));
    let longest_of = |p: &[L::F; 3]| l.max(l.max(l.abs(p[0]), l.abs(p[1])), l.abs(p[2]));
    let reach = l.max(l.max(longest_of(&a), longest_of(&b)), longest_of(&c));
    let flat = l.splat(fixed.flat);
    let in_plane = l.less(l.abs(height), l.mul(flat, reach));
    Planes {
        edges,
        normal,
        height,
        doubt: l.mul(l.splat(fixed.doubt), reach),
        edge_on: l.select(in_plane, l.splat(f32::INFINITY), flat),
    }
}
