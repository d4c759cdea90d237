//! Triangles in lanes. In: a triangle and the rays of a packet. Out: which lanes hit it and where; the arithmetic of
//! [`crate::trace::kernel::triangle`] lane by lane.

use crate::trace::kernel::lanes::Lanes;
use crate::trace::kernel::packet::Packet;
use crate::trace::kernel::triangle::{EdgeTriangle, intersect_f64};

/// Vectors of a packet in registers.
pub struct PacketRays<F> {
    pub origin: [F; 3],
    pub direction: [F; 3],
    pub inverse: [F; 3],
}

/// Those of the wanted lanes that hit, and at which distance.
#[inline(always)]
pub fn intersect<L: Lanes, const SHARED: bool>(
    l: L,
    triangle: &EdgeTriangle,
    wanted: u16,
    rays: &PacketRays<L::F>,
    packet: &Packet,
) -> (u16, L::F) {
    let seen = if SHARED { shared(l, triangle, packet.ray(0).origin) } else { apart(l, triangle, &rays.origin) };
    let dot = |e: &[L::F; 3]| {
        let xy = l.add(l.mul(rays.direction[0], e[0]), l.mul(rays.direction[1], e[1]));
        l.add(xy, l.mul(rays.direction[2], e[2]))
    };
    let (u, v, w) = (dot(&seen.edges[0]), dot(&seen.edges[1]), dot(&seen.edges[2]));
    let (low, high) = (l.min(l.min(u, v), w), l.max(l.max(u, v), w));
    let minus_doubt = l.sub(l.splat(0.0), seen.doubt);
    let missed = l.less(low, minus_doubt) & l.less(seen.doubt, high);
    let near_edge = l.less(low, seen.doubt) & l.less(minus_doubt, high);
    if wanted & !missed == 0 {
        return (0, low);
    }
    let slope = dot(&seen.normal);
    let doubtful = wanted & !missed & (near_edge | l.less(l.abs(slope), seen.edge_on));
    // Lanes that are decided in f64 divide by one here: no infinity or NaN is made.
    let t = l.div(seen.height, l.select(missed | doubtful, l.splat(1.0), slope));
    let forward = l.less(l.splat(0.0), t) & l.less(t, l.splat(f32::INFINITY));
    let hit = wanted & !missed & !doubtful & forward;
    if doubtful != 0 { decide(l, triangle, packet, doubtful, t, hit) } else { (hit, t) }
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
) -> (u16, L::F) {
    let mut distances = l.store(t);
    for lane in bits(doubtful) {
        let ray = packet.ray(lane);
        if let Some(t) = intersect_f64(ray.origin, ray.direction, &triangle.corners) {
            distances.0[lane] = t;
            hit |= 1 << lane;
        }
    }
    (hit, l.load(&distances))
}

/// Set bits, lowest first.
#[inline(always)]
pub fn bits(mask: u16) -> impl Iterator<Item = usize> {
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
    let edges = [cross(&b, fixed.bc), cross(&a, fixed.ca), cross(&a, fixed.ab)];
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
