//! Triangles in lanes. In: a triangle and the rays of a packet. Out: the lanes that hit it and the
//! distances, by the arithmetic of [`crate::trace::kernel::triangle`] lane by lane.

use crate::trace::kernel::lanes::Lanes;
use crate::trace::kernel::ray::{Packet, Ray};
use crate::trace::kernel::triangle::{Corners, DOUBT, EdgeTriangle, intersect_f64};

/// Vectors of a packet in registers.
pub struct PacketRays<F> {
    pub origin: [F; 3],
    pub direction: [F; 3],
    pub inverse: [F; 3],
}

/// Returns the wanted lanes that hit, and their distances.
#[inline(always)]
pub fn intersect<L: Lanes, const SHARED: bool>(
    l: L,
    triangle: &EdgeTriangle,
    wanted: u16,
    rays: &PacketRays<L::F>,
    packet: &Packet,
) -> (u16, L::F) {
    let seen = if SHARED { shared(l, triangle, packet.ray(0).origin) } else { apart(l, triangle, &rays.origin) };
    meets(l, &seen, &triangle.corners, wanted, &rays.direction, |lane| packet.ray(lane))
}

/// Does the work of [`intersect`] for a triangle as the lanes see it. `ray` gives the ray of a
/// lane.
#[inline(always)]
pub fn meets<L: Lanes>(
    l: L,
    seen: &Planes<L::F>,
    corners: &Corners,
    wanted: u16,
    direction: &[L::F; 3],
    ray: impl Fn(usize) -> Ray,
) -> (u16, L::F) {
    let dot = |e: &[L::F; 3]| {
        let xy = l.add(l.mul(direction[0], e[0]), l.mul(direction[1], e[1]));
        l.add(xy, l.mul(direction[2], e[2]))
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
    // Lanes that f64 decides divide by one here, so no infinity or NaN arises.
    let t = l.div(seen.height, l.select(missed | doubtful, l.splat(1.0), slope));
    let forward = l.less(l.splat(0.0), t) & l.less(t, l.splat(f32::INFINITY));
    let hit = wanted & !missed & !doubtful & forward;
    if doubtful != 0 { decide(l, corners, ray, doubtful, t, hit) } else { (hit, t) }
}

/// Decides doubtful lanes one by one in f64.
#[cold]
#[inline(never)]
fn decide<L: Lanes>(
    l: L,
    corners: &Corners,
    ray: impl Fn(usize) -> Ray,
    doubtful: u16,
    t: L::F,
    mut hit: u16,
) -> (u16, L::F) {
    let mut distances = l.store(t);
    for lane in bits(doubtful) {
        let ray = ray(lane);
        if let Some(t) = intersect_f64(ray.origin, ray.direction, corners) {
            distances.0[lane] = t;
            hit |= 1 << lane;
        }
    }
    (hit, l.load(&distances))
}

/// Returns the set bits, lowest first.
#[inline(always)]
pub fn bits(mask: u16) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(mask), |m| Some(m & m.wrapping_sub(1)))
        .take_while(|&m| m != 0)
        .map(|m| m.trailing_zeros() as usize)
}

/// Triangle as the lanes see it, or one triangle in each lane.
pub struct Planes<F> {
    pub edges: [[F; 3]; 3],
    pub normal: [F; 3],
    pub height: F,
    pub doubt: F,
    pub edge_on: F,
}

/// Returns a triangle as seen from one origin for all lanes, computed once.
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

/// Returns a triangle as seen from an origin for each lane.
#[inline(always)]
fn apart<L: Lanes>(l: L, triangle: &EdgeTriangle, origin: &[L::F; 3]) -> Planes<L::F> {
    let fixed = triangle.fixed();
    let splat = |v: [f32; 3]| [l.splat(v[0]), l.splat(v[1]), l.splat(v[2])];
    let [a, b, c] = triangle.corners;
    let corners =
        [difference(l, &splat(a), origin), difference(l, &splat(b), origin), difference(l, &splat(c), origin)];
    let edges = [splat(fixed.ab), splat(fixed.bc), splat(fixed.ca)];
    seen(l, &corners, &edges, splat(fixed.normal), l.splat(fixed.doubt), l.splat(fixed.flat))
}

/// Returns a triangle in each lane, seen from one point. `longest` is the largest extent of an
/// edge.
#[inline(always)]
pub fn planes<L: Lanes>(l: L, corners: &[[L::F; 3]; 3], longest: L::F, origin: [f32; 3]) -> Planes<L::F> {
    let [a, b, c] = corners;
    let edges = [difference(l, b, a), difference(l, c, b), difference(l, a, c)];
    let normal = cross(l, &edges[2], &edges[0]);
    let doubt = l.mul(l.splat(DOUBT), longest);
    let origin = [l.splat(origin[0]), l.splat(origin[1]), l.splat(origin[2])];
    let corners = [difference(l, a, &origin), difference(l, b, &origin), difference(l, c, &origin)];
    seen(l, &corners, &edges, normal, doubt, l.mul(doubt, longest))
}

/// Does the work of [`EdgeTriangle::seen_from`] in lanes, from corners relative to the origin and
/// the values of [`EdgeTriangle::fixed`].
#[inline(always)]
fn seen<L: Lanes>(
    l: L,
    [a, b, c]: &[[L::F; 3]; 3],
    [ab, bc, ca]: &[[L::F; 3]; 3],
    normal: [L::F; 3],
    doubt: L::F,
    flat: L::F,
) -> Planes<L::F> {
    let edges = [cross(l, b, bc), cross(l, a, ca), cross(l, a, ab)];
    let xy = l.add(l.mul(a[0], normal[0]), l.mul(a[1], normal[1]));
    let height = l.add(xy, l.mul(a[2], normal[2]));
    let longest_of = |p: &[L::F; 3]| l.max(l.max(l.abs(p[0]), l.abs(p[1])), l.abs(p[2]));
    let reach = l.max(l.max(longest_of(a), longest_of(b)), longest_of(c));
    let in_plane = l.less(l.abs(height), l.mul(flat, reach));
    let edge_on = l.select(in_plane, l.splat(f32::INFINITY), flat);
    Planes { edges, normal, height, doubt: l.mul(doubt, reach), edge_on }
}

#[inline(always)]
fn difference<L: Lanes>(l: L, p: &[L::F; 3], q: &[L::F; 3]) -> [L::F; 3] {
    [l.sub(p[0], q[0]), l.sub(p[1], q[1]), l.sub(p[2], q[2])]
}

#[inline(always)]
fn cross<L: Lanes>(l: L, p: &[L::F; 3], q: &[L::F; 3]) -> [L::F; 3] {
    [
        l.sub(l.mul(p[1], q[2]), l.mul(p[2], q[1])),
        l.sub(l.mul(p[2], q[0]), l.mul(p[0], q[2])),
        l.sub(l.mul(p[0], q[1]), l.mul(p[1], q[0])),
    ]
}
