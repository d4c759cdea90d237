//! Scan: the sky as one point sees it, block of texels by block. In: fans of rays with cones around
//! them. Out: the rays that hit anything, for each the answer of a single ray, bit for bit.
//!
//! A texture is refined where it is mixed, so one part of the sky is queried again and again. The
//! tree is therefore walked once for each part, by a beam around all its rays, and the triangles
//! that they can hit are kept. From then on rays are tested against these alone. A walk ends at a
//! triangle that covers the part, or when all wanted rays have hit something.

use prefetch_index::prefetch_index;

use crate::trace::kernel::beam::Beam;
use crate::trace::kernel::candidates::{Candidates, Listed, Rays, Sixteen};
use crate::trace::kernel::fan::{Cone, Fan};
use crate::trace::kernel::lanes::{Kernel, LANES, Lanes, Level, dispatch};
use crate::trace::kernel::planes::bits;
use crate::trace::kernel::tree::{Child, Tree, WIDTH};

/// State of the search for what hides a part of the sky.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PartOcclusion {
    /// Nothing is known yet.
    Nothing,
    /// The rays of the first query all hit something, and the walk ended there.
    FirstRaysHit,
    /// One triangle covers the part.
    Covered,
    /// All triangles that the rays of the part can hit.
    Listed(Listed),
    /// The triangles are too many for a list, or too far apart.
    Unlisted,
}

/// Largest number of candidates of a part: some ten times those of a city's skyline.
const MAX: u32 = 512;

/// Largest number of nodes that a walk enters. A broad or flat beam over a large map would visit
/// nodes that its rays, which end at near surfaces, never reach. The limit saves 45 % of the time
/// of receivers in a city of 11 km. Limits of 16 and 32 take as long as 64.
const ENTERED: usize = 64;

/// Number of queries to prefetch ahead.
const SOON: usize = 4;

/// Size of the cache of recently noted triangles.
const NOTED: usize = 1024;

/// Memory of a scan, reused for one point after the other.
pub struct ScanSpace {
    known: Vec<PartOcclusion>,
    candidates: Candidates,
    stack: Vec<Child>,
    /// Places of triangles that are still to be tested.
    pending: Vec<u32>,
    /// Number of walks so far.
    walks: u64,
    /// Walk and mesh index of recently noted triangles, by the index modulo the size of the cache.
    noted: [u64; NOTED],
}

impl Default for ScanSpace {
    fn default() -> Self {
        let (known, candidates) = Default::default();
        ScanSpace { known, candidates, stack: Vec::new(), pending: Vec::new(), walks: 0, noted: [0; NOTED] }
    }
}

/// Occlusion query for sixteen rays of a part of the sky.
#[derive(Clone, Copy, Debug)]
pub struct Question<'a> {
    /// Number of the part.
    pub part: u32,
    /// Cone around all rays of the part that any query may hold.
    pub whole: &'a Cone,
    pub fan: &'a Fan,
    /// Cone around the rays of this query.
    pub cone: Cone,
    /// Lanes that are wanted.
    pub wanted: u16,
    /// Answer: the wanted lanes that hit something; `None` if these rays have to be traced one by
    /// one.
    pub met: Option<u16>,
}

/// Scan of the sky from one point.
pub struct Scan<'a> {
    tree: &'a Tree,
    level: Level,
    origin: [f32; 3],
    space: &'a mut ScanSpace,
}

impl<'a> Scan<'a> {
    /// Starts a scan from a point, over `parts` parts of the sky.
    pub fn new(tree: &'a Tree, level: Level, origin: [f32; 3], parts: usize, space: &'a mut ScanSpace) -> Self {
        space.known.clear();
        space.known.resize(parts, PartOcclusion::Nothing);
        space.candidates.clear();
        Scan { tree, level, origin, space }
    }

    /// Answers queries.
    pub fn answer(&mut self, questions: &mut [Question]) {
        let Scan { tree, level, origin, space } = self;
        dispatch(*level, Answer { tree, origin: *origin, space, questions });
    }
}

struct Answer<'a, 'b> {
    tree: &'a Tree,
    origin: [f32; 3],
    space: &'a mut ScanSpace,
    questions: &'a mut [Question<'b>],
}

impl Kernel for Answer<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        for place in 0..self.questions.len() {
            // Queries that come soon have to be fetched from memory.
            if let Some(soon) = self.questions.get(place + SOON) {
                soon.fan.0.iter().for_each(|axis| prefetch_index(axis.0.as_slice(), 0));
            }
            let question = &mut self.questions[place];
            question.met = self.space.met(l, self.tree, self.origin, question);
        }
    }
}

impl ScanSpace {
    /// Returns the lanes of a query that hit something.
    #[inline(always)]
    fn met<L: Lanes>(&mut self, l: L, tree: &Tree, origin: [f32; 3], asked: &Question) -> Option<u16> {
        let part = asked.part as usize;
        let rays = || Rays::new(l, origin, asked.fan, asked.wanted);
        match self.known[part] {
            PartOcclusion::Nothing => {
                let rays = rays();
                let (known, met) = self.walk(l, tree, origin, asked.whole, Some(&rays));
                self.known[part] = known;
                if known != PartOcclusion::Unlisted {
                    return Some(met);
                }
            }
            PartOcclusion::FirstRaysHit => self.known[part] = self.walk(l, tree, origin, asked.whole, None).0,
            PartOcclusion::Covered | PartOcclusion::Listed(_) | PartOcclusion::Unlisted => {}
        }
        match self.known[part] {
            PartOcclusion::Covered => Some(asked.wanted),
            PartOcclusion::Listed(list) if list.is_empty() => Some(0),
            PartOcclusion::Listed(list) => Some(self.candidates.met(l, tree, list, &rays(), &asked.cone)),
            PartOcclusion::Nothing | PartOcclusion::FirstRaysHit | PartOcclusion::Unlisted => None,
        }
    }

    /// Walks the tree with a beam. Returns the knowledge about its part, and the rays of `first`
    /// that hit something.
    #[inline(always)]
    fn walk<L: Lanes>(
        &mut self,
        l: L,
        tree: &Tree,
        origin: [f32; 3],
        whole: &Cone,
        first: Option<&Rays<L::F>>,
    ) -> (PartOcclusion, u16) {
        let beam = Beam::of_cone(l, origin, whole);
        let begin = self.candidates.next();
        let (mut met, mut count, mut entered) = (0, 0, 0);
        self.walks += 1;
        self.pending.clear();
        self.stack.clear();
        self.stack.push(Child::default());
        loop {
            let next = self.stack.pop();
            if let Some(child) = next.filter(|child| child.count > 0) {
                self.leaf(tree, child);
            } else if let Some(child) = next {
                entered += 1;
                self.enter(l, tree, child, &beam);
            }
            // Triangles are tested by sixteens, and the rest when the walk ends.
            while self.pending.len() >= LANES || next.is_none() && !self.pending.is_empty() {
                let some = self.pending.len().min(LANES);
                let mut sixteen = Sixteen::new(l, tree, origin, &self.pending[..some]);
                self.pending.drain(..some);
                let (covered, kept) = sixteen.keep(l, whole);
                count += kept;
                let done = if covered {
                    Some((PartOcclusion::Covered, first.map_or(0, |rays| rays.wanted)))
                } else if count > MAX || entered > ENTERED {
                    Some((PartOcclusion::Unlisted, 0))
                } else if let Some(rays) = first {
                    met = sixteen.met(l, tree, rays, met);
                    (met == rays.wanted).then_some((PartOcclusion::FirstRaysHit, met))
                } else {
                    None
                };
                if let Some(done) = done {
                    self.candidates.drop_from(begin);
                    return done;
                }
                if kept > 0 {
                    self.candidates.push(sixteen);
                }
            }
            if next.is_none() {
                return (PartOcclusion::Listed(self.candidates.finish(begin)), met);
            }
        }
    }

    /// Notes the triangles of a leaf. A triangle that is cut into many leaves is mostly noted once.
    #[inline(always)]
    fn leaf(&mut self, tree: &Tree, leaf: Child) {
        for place in leaf.first..leaf.first + leaf.count {
            let id = tree.triangles[place as usize].id;
            // The number of the walk is part of the mark, so the cache is never cleared. Walks
            // count from 1, so the zeros of a new cache match nothing.
            let mark = self.walks << 32 | u64::from(id);
            let noted = &mut self.noted[id as usize % NOTED];
            if *noted != mark {
                *noted = mark;
                self.pending.push(place);
            }
        }
    }

    /// Puts the children of a node on the stack, the nearest on top.
    #[inline(always)]
    fn enter<L: Lanes>(&mut self, l: L, tree: &Tree, child: Child, beam: &Beam<L::F>) {
        let node = &tree.nodes[child.first as usize];
        let (children, nears) = beam.meets(l, node, f32::INFINITY);
        let mut entries = [(0.0_f32, 0_usize); WIDTH];
        let mut count = 0;
        for k in bits(children) {
            let k = k % WIDTH;
            tree.fetch(node.child[k]);
            let near = nears.0[k];
            let mut at = count % WIDTH;
            while at > 0 && entries[at - 1].0 < near {
                entries[at] = entries[at - 1];
                at -= 1;
            }
            entries[at] = (near, k);
            count += 1;
        }
        self.stack.extend(entries.iter().take(count).map(|entry| node.child[entry.1 % WIDTH]));
    }
}
