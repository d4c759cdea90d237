//! Candidates: the triangles that rays of a cone may hit, seen from their common origin, sixteen in
//! lanes. In: triangles of the tree and a cone. Out: the triangles that every ray of the cone
//! misses, a triangle that all of them hit, and for the rest the rays that hit.
//!
//! A ray misses a triangle if it passes an edge on the outer side, and hits it if it passes all
//! three on the inner side. A box of directions bounds how far off they pass (interval arithmetic
//! as in Boulos et al. 2006). With twice the doubt of a single ray the bounds hold whatever is
//! rounded: the product of a direction, about 1 long, with the plane of an edge, at most 3 x reach
//! x longest edge long, is known to 6e-7 of their lengths in f32, and so is a bound. Together that
//! is less than one `DOUBT`.

use crate::trace::kernel::fan::{Cone, Fan};
use crate::trace::kernel::lanes::{F32x16, LANES, Lanes};
use crate::trace::kernel::planes::{Planes, bits, meets, planes};
use crate::trace::kernel::ray::Ray;
use crate::trace::kernel::tree::Tree;

/// Sixteen triangles as seen from one origin.
#[derive(Clone, Copy, Debug)]
pub struct Sixteen {
    /// `[edge][axis]`: normals of the planes through origin and edge, signed so that hitting rays
    /// have positive products.
    edges: [[F32x16; 3]; 3],
    normal: [F32x16; 3],
    height: F32x16,
    doubt: F32x16,
    edge_on: F32x16,
    /// Places of the triangles in the tree.
    places: [u32; LANES],
    /// Lanes of the triangles that are kept.
    open: u16,
}

/// Lists of candidates.
#[derive(Default)]
pub struct Candidates {
    lists: Vec<Sixteen>,
}

/// Range of a list in [`Candidates`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Listed {
    first: u32,
    end: u32,
}

impl Listed {
    /// Returns true if the list holds no triangle.
    pub fn is_empty(self) -> bool {
        self.first == self.end
    }
}

/// Sixteen rays and the lanes that are wanted.
pub struct Rays<'a, F> {
    pub origin: [f32; 3],
    pub fan: &'a Fan,
    /// Directions of the fan in registers.
    pub directions: [F; 3],
    pub wanted: u16,
}

impl<'a, F: Copy> Rays<'a, F> {
    #[inline(always)]
    pub fn new<L: Lanes<F = F>>(l: L, origin: [f32; 3], fan: &'a Fan, wanted: u16) -> Self {
        let [x, y, z] = &fan.0;
        Rays { origin, fan, directions: [l.load(x), l.load(y), l.load(z)], wanted }
    }
}

impl Sixteen {
    /// Creates the triangles at 1 to 16 places in the tree, as seen from a point.
    #[inline(always)]
    pub fn new<L: Lanes>(l: L, tree: &Tree, origin: [f32; 3], places: &[u32]) -> Self {
        let last = places.len() - 1;
        let zero = F32x16([0.0; LANES]);
        let (mut corners, mut longest, mut of) = ([[zero; 3]; 3], zero, [0; LANES]);
        for (lane, of) in of.iter_mut().enumerate() {
            // Lanes without a triangle repeat the last one, so that they hold finite numbers;
            // `open` leaves them out.
            *of = places[lane.min(last)];
            let triangle = &tree.triangles[*of as usize];
            for (to, from) in corners.iter_mut().zip(&triangle.corners) {
                for (axis, x) in to.iter_mut().zip(from) {
                    axis.0[lane] = *x;
                }
            }
            longest.0[lane] = triangle.longest;
        }
        // Loops, because closures of `map` would not be compiled for the processor level.
        let mut loaded = [[l.splat(0.0); 3]; 3];
        for (to, from) in loaded.iter_mut().zip(&corners) {
            for (axis, x) in to.iter_mut().zip(from) {
                *axis = l.load(x);
            }
        }
        let seen = planes(l, &loaded, l.load(&longest), origin);
        let behind = l.less(seen.height, l.splat(0.0));
        let mut sixteen = Sixteen {
            edges: [[zero; 3]; 3],
            normal: [zero; 3],
            height: l.store(seen.height),
            doubt: l.store(seen.doubt),
            edge_on: l.store(seen.edge_on),
            places: of,
            open: u16::MAX >> (LANES - 1 - last),
        };
        for axis in 0..3 {
            for edge in 0..3 {
                let x = seen.edges[edge][axis];
                sixteen.edges[edge][axis] = l.store(l.select(behind, l.sub(l.splat(0.0), x), x));
            }
            sixteen.normal[axis] = l.store(seen.normal[axis]);
        }
        sixteen
    }

    /// Returns the triangles that some rays of a cone may hit, and those that all of them hit.
    #[inline(always)]
    fn pass<L: Lanes>(&self, l: L, cone: &Cone) -> (u16, u16) {
        let doubt = l.load(&self.doubt);
        // An origin in the plane of a triangle decides nothing.
        let infinite = l.splat(f32::INFINITY);
        let margin = l.select(l.less(l.load(&self.edge_on), infinite), l.add(doubt, doubt), infinite);
        let minus_margin = l.sub(l.splat(0.0), margin);
        let (mut missed, mut hit) = (0, u16::MAX);
        for edge in &self.edges {
            let (mut middle, mut reach) = (l.splat(0.0), l.splat(0.0));
            for (x, (centre, half)) in edge.iter().zip(cone.centre.iter().zip(&cone.half)) {
                let x = l.load(x);
                middle = l.add(middle, l.mul(l.splat(*centre), x));
                reach = l.add(reach, l.mul(l.splat(*half), l.abs(x)));
            }
            missed |= l.less(l.add(middle, reach), minus_margin);
            hit &= l.less(margin, l.sub(middle, reach));
        }
        (self.open & !missed & !hit, self.open & !missed & hit)
    }

    /// Drops the triangles that all rays of a cone miss. Returns true if all rays hit one of the
    /// others, and how many are left.
    #[inline(always)]
    pub fn keep<L: Lanes>(&mut self, l: L, cone: &Cone) -> (bool, u32) {
        let (open, hit) = self.pass(l, cone);
        self.open = open;
        (hit != 0, open.count_ones())
    }

    /// Returns the wanted rays that hit a triangle set in `open`. `met` are rays that are known to
    /// hit something.
    #[inline(always)]
    fn hits<L: Lanes>(&self, l: L, tree: &Tree, rays: &Rays<L::F>, open: u16, mut met: u16) -> u16 {
        for lane in bits(open) {
            let lane = lane % LANES;
            let splat = |v: &[F32x16; 3]| [l.splat(v[0].0[lane]), l.splat(v[1].0[lane]), l.splat(v[2].0[lane])];
            let seen = Planes {
                edges: [splat(&self.edges[0]), splat(&self.edges[1]), splat(&self.edges[2])],
                normal: splat(&self.normal),
                height: l.splat(self.height.0[lane]),
                doubt: l.splat(self.doubt.0[lane]),
                edge_on: l.splat(self.edge_on.0[lane]),
            };
            let corners = &tree.triangles[self.places[lane] as usize].corners;
            let ray = |lane: usize| Ray { origin: rays.origin, direction: rays.fan.direction(lane) };
            met |= meets(l, &seen, corners, rays.wanted & !met, &rays.directions, ray).0;
            if met == rays.wanted {
                break;
            }
        }
        met
    }

    /// Returns the wanted rays that hit a kept triangle. `met` are rays that are known to hit
    /// something.
    #[inline(always)]
    pub fn met<L: Lanes>(&self, l: L, tree: &Tree, rays: &Rays<L::F>, met: u16) -> u16 {
        self.hits(l, tree, rays, self.open, met)
    }
}

impl Candidates {
    /// Removes all lists.
    pub fn clear(&mut self) {
        self.lists.clear();
    }

    /// Returns the place where the next list begins.
    pub fn next(&self) -> u32 {
        self.lists.len() as u32
    }

    /// Adds sixteen triangles to the last list.
    pub fn push(&mut self, sixteen: Sixteen) {
        self.lists.push(sixteen);
    }

    /// Drops the list that begins at `first`.
    pub fn drop_from(&mut self, first: u32) {
        self.lists.truncate(first as usize);
    }

    /// Ends the list that begins at `first`.
    pub fn finish(&self, first: u32) -> Listed {
        Listed { first, end: self.next() }
    }

    /// Returns the wanted rays of a cone that hit a triangle of a list.
    #[inline(always)]
    pub fn met<L: Lanes>(&self, l: L, tree: &Tree, list: Listed, rays: &Rays<L::F>, cone: &Cone) -> u16 {
        let mut met = 0;
        for sixteen in &self.lists[list.first as usize..list.end as usize] {
            let (open, hit) = sixteen.pass(l, cone);
            if hit != 0 {
                return rays.wanted;
            }
            met = sixteen.hits(l, tree, rays, open, met);
            if met == rays.wanted {
                break;
            }
        }
        met
    }
}
