//! A scan: all that one point sees of the sky, block of texels by block. In: fans of rays with cones around them. Out: which of them meet
//! anything, for each what a single ray would have answered, bit for bit.
//!
//! A texture is refined where it is mixed, so one part of the sky is asked about again and again. The tree is therefore walked once for
//! each part, by a beam around all its rays, and the triangles that they can meet are kept; from then on rays meet these alone. A walk ends
//! at a triangle that covers the part, and where all that is asked for is met.

use prefetch_index::prefetch_index;

use crate::trace::kernel::beam::Beam;
use crate::trace::kernel::candidates::{Candidates, Listed, Rays, Sixteen};
use crate::trace::kernel::fan::{Cone, Fan};
use crate::trace::kernel::lanes::{Kernel, LANES, Lanes, Level, dispatch};
use crate::trace::kernel::planes::bits;
use crate::trace::kernel::tree::{Child, Tree, WIDTH};

/// What is known of a part of the sky.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Known {
    /// Nothing.
    Nothing,
    /// The first rays all met something, and the walk ended there.
    Met,
    /// One triangle covers it.
    Covered,
    /// All triangles that its rays can meet.
    Listed(Listed),
    /// They are more than are worth a list, or too far apart.
    Unlisted,
}

/// Candidates of a part at most: some ten times those of a city's skyline.
const MOST: u32 = 512;

/// Nodes of the tree that a walk enters at most: a beam that is broad or flat over a large map finds what its rays, which end at what is near,
/// never come to.
const ENTERED: usize = 64;

/// Questions that are looked ahead.
const SOON: usize = 4;

/// Triangles that are remembered to have been noted.
const NOTED: usize = 1024;

/// Memory for a scan, which serves one point after the other.
pub struct ScanSpace {
    known: Vec<Known>,
    candidates: Candidates,
    stack: Vec<Child>,
    /// Places of triangles that are still to be looked at.
    pending: Vec<u32>,
    /// Walks so far.
    walks: u64,
    /// Walk and mesh index of triangles that were noted lately, by the end of their index.
    noted: [u64; NOTED],
}

impl Default for ScanSpace {
    fn default() -> Self {
        let (known, candidates) = Default::default();
        ScanSpace { known, candidates, stack: Vec::new(), pending: Vec::new(), walks: 0, noted: [0; NOTED] }
    }
}

/// Sixteen rays of a part of the sky.
#[derive(Clone, Copy, Debug)]
pub struct Question<'a> {
    /// Number of the part.
    pub part: u32,
    /// Around all rays of the part that are ever asked about.
    pub whole: &'a Cone,
    pub fan: &'a Fan,
    /// Around these rays.
    pub cone: Cone,
    /// Lanes that are asked about.
    pub wanted: u16,
    /// The answer: those of them that meet something; `None` if these rays have to find their own way.
    pub met: Option<u16>,
}

/// What one point sees.
pub struct Scan<'a> {
    tree: &'a Tree,
    level: Level,
    origin: [f32; 3],
    space: &'a mut ScanSpace,
}

impl<'a> Scan<'a> {
    /// From a point, over so many parts of the sky.
    pub fn new(tree: &'a Tree, level: Level, origin: [f32; 3], parts: usize, space: &'a mut ScanSpace) -> Self {
        space.known.clear();
        space.known.resize(parts, Known::Nothing);
        space.candidates.clear();
        Scan { tree, level, origin, space }
    }

    /// Answers questions.
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
            // What comes soon has to come from memory.
            if let Some(soon) = self.questions.get(place + SOON) {
                soon.fan.0.iter().for_each(|axis| prefetch_index(axis.0.as_slice(), 0));
            }
            let question = &mut self.questions[place];
            question.met = self.space.met(l, self.tree, self.origin, question);
        }
    }
}

impl ScanSpace {
    /// Lanes that meet something.
    #[inline(always)]
    fn met<L: Lanes>(&mut self, l: L, tree: &Tree, origin: [f32; 3], asked: &Question) -> Option<u16> {
        let part = asked.part as usize;
        let rays = || Rays::new(l, origin, asked.fan, asked.wanted);
        match self.known[part] {
            Known::Nothing => {
                let rays = rays();
                let (known, met) = self.walk(l, tree, origin, asked.whole, Some(&rays));
                self.known[part] = known;
                if known != Known::Unlisted {
                    return Some(met);
                }
            }
            Known::Met => self.known[part] = self.walk(l, tree, origin, asked.whole, None).0,
            Known::Covered | Known::Listed(_) | Known::Unlisted => {}
        }
        match self.known[part] {
            Known::Covered => Some(asked.wanted),
            Known::Listed(list) if list.is_empty() => Some(0),
            Known::Listed(list) => Some(self.candidates.met(l, tree, list, &rays(), &asked.cone)),
            Known::Nothing | Known::Met | Known::Unlisted => None,
        }
    }

    /// Walks the tree with a beam: what is known of its rays from then on, and which of the first ones meet something.
    #[inline(always)]
    fn walk<L: Lanes>(
        &mut self,
        l: L,
        tree: &Tree,
        origin: [f32; 3],
        whole: &Cone,
        first: Option<&Rays<L::F>>,
    ) -> (Known, u16) {
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
            while self.pending.len() >= LANES || next.is_none() && !self.pending.is_empty() {
                let some = self.pending.len().min(LANES);
                let mut sixteen = Sixteen::new(l, tree, origin, &self.pending[..some]);
                self.pending.drain(..some);
                let (covered, kept) = sixteen.keep(l, whole);
                count += kept;
                let done = if covered {
                    Some((Known::Covered, first.map_or(0, |rays| rays.wanted)))
                } else if count > MOST || entered > ENTERED {
                    Some((Known::Unlisted, 0))
                } else if let Some(rays) = first {
                    met = sixteen.met(l, tree, rays, met);
                    (met == rays.wanted).then_some((Known::Met, met))
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
                return (Known::Listed(self.candidates.finish(begin)), met);
            }
        }
    }

    /// Notes the triangles of a leaf. One that is cut into many leaves is mostly noted once.
    #[inline(always)]
    fn leaf(&mut self, tree: &Tree, leaf: Child) {
        for place in leaf.first..leaf.first + leaf.count {
            let id = tree.triangles[place as usize].id;
            let mark = self.walks << 32 | u64::from(id);
            let noted = &mut self.noted[id as usize % NOTED];
            if *noted != mark {
                *noted = mark;
                self.pending.push(place);
            }
        }
    }

    /// Lets the children of a node wait, the nearest in front.
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
