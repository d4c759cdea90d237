//! Canopies: leaves, screens and volumes of leaves. They stop no ray; the tracer counts how often
//! rays cross them, and how far they go inside of volumes. In: rays and their lengths. Out: for
//! each ray the number of crossings of each such material, or the length inside, and the leaves on
//! its way that scatter light.
//!
//! Triangles that touch and are hit at one distance count as one leaf: a ray through an edge of two
//! triangles, or through the two faces of a leaf drawn from both sides, crosses once. Where faces
//! meet without a common corner, a ray through that very line may count twice.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::trace::hidden::side_met;
use crate::trace::kernel::ray::{Hit, Ray};
use crate::trace::kernel::rays::{FaceSide, Tracer};
use crate::trace::probe::{Directions, ProbeTrace};
use crate::trace::surroundings::{SeenCell, seen_from};
use crate::trace::viewpoint::Viewpoint;
use crate::trace::volume::{Draw, ONE_PLACE, Part, USUALLY_STOPPED, Volumes, touch};
use heliotile_core::hemisphere::{bit, mix, unit};
use heliotile_core::layers::canopy::{COUNTS, SeenLeaf, code_of, length_of};
use heliotile_core::light::radiosity::{SidesOf, Surround, each_ray};
use heliotile_core::site::cells::CellKey;
use heliotile_core::site::crossing::Crossing;
use heliotile_core::site::material::Material;
use heliotile_scene::Scene;
use heliotile_scene::mesh::{Mesh, bounds};

/// Directions of rays that tell whether a point is in a hull: near the axes, and along no face of a
/// hull from a raster.
const ALL_WAYS: [[f32; 3]; 6] = [
    [0.031, 0.017, 1.0],
    [-0.023, 0.041, -1.0],
    [1.0, 0.029, 0.037],
    [-1.0, 0.043, 0.019],
    [0.013, 1.0, 0.047],
    [0.027, -1.0, 0.033],
];

/// Ray of a list, and its length.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Path {
    /// Place of the ray in the list.
    pub place: u32,
    /// Start and direction.
    pub ray: Ray,
    /// Length of the ray, metres; infinite towards the sky. Leaves at this distance or beyond are
    /// not crossed.
    pub reach_m: f32,
}

/// Leaves and screens of a scene.
pub struct Canopies<'a> {
    mesh: &'a Mesh,
    tracer: Tracer,
    volumes: Volumes,
    /// `[material]`: true if its leaves scatter light.
    scatters: Vec<bool>,
    /// True if some leaf of the scene scatters light.
    some_scatter: bool,
    /// Least and greatest corner of all leaves, relative to the origin of the scene, metres.
    bounds: (DVec3, DVec3),
}

/// Ray that crosses leaves.
#[derive(Debug)]
pub(crate) struct Passage {
    /// Place of the ray in the list.
    pub place: u32,
    ray: Ray,
    /// Leaves that the ray crosses, nearest first: one triangle of each.
    leaves: Vec<Hit>,
    /// Parts of the ray in volumes of leaves, by material.
    parts: Vec<Part>,
}

/// Leaf that scatters light and that a ray crosses.
#[derive(Debug)]
pub(crate) struct LeafHit {
    /// Row of its material in the materials table.
    pub material: u16,
    /// Normal of the triangle; `None` for leaves of a volume, which face all ways.
    pub normal: Option<DVec3>,
    /// Point where the ray hits it, input coordinates.
    pub point: DVec3,
    /// Distance from the start of the ray, metres.
    pub distance_m: f64,
    /// Number of leaves that it stands for: 1, or the optical depth in a volume.
    pub weight: f64,
    /// Materials that the ray crosses before, ascending, with the number of crossings of each, or
    /// the length inside, metres.
    pub before: Vec<(u16, f64)>,
}

impl LeafHit {
    /// Returns the distance that decides the level of its cell in the view of other cells: half of
    /// its distance in a volume, whose sides differ.
    fn looked_at_m(&self) -> f64 {
        if self.normal.is_some() { self.distance_m } else { 0.5 * self.distance_m }
    }

    /// Returns the cell of the leaf at a level of surfaces as far away.
    pub fn cell(&self, level: i8) -> CellKey {
        match self.normal {
            Some(normal) => CellKey::leaf(self.point, normal, self.material, level),
            None => CellKey::volume(self.point, self.material, (level - VOLUME_FINER).max(VOLUME_LEVEL)),
        }
    }
}

/// Finest level of cells of volumes, 1 m: light changes little within a fraction of the length
/// that it goes between two leaves, 2 m at 1 m2/m3.
const VOLUME_LEVEL: i8 = 0;

/// Number of levels by which cells of volumes are finer than those of surfaces as far away: the
/// lower side of a crown is darker than the whole, and at the floor of a wood it is seen alone.
const VOLUME_FINER: i8 = 2;

impl<'a> Canopies<'a> {
    /// Returns a tracer of the opaque triangles, and the canopies if the scene has any.
    pub fn split(scene: &'a Scene) -> (Tracer, Option<Self>) {
        let mesh = &scene.mesh;
        let lets_through = |&id: &u32| {
            let material = usize::from(mesh.triangle_material[id as usize]);
            scene.materials.get(material).is_some_and(|material| material.transmittance.is_some())
        };
        let (leaves, opaque): (Vec<u32>, Vec<u32>) = (0..mesh.triangles.len() as u32).partition(lets_through);
        let scatters: Vec<bool> = scene.materials.iter().map(Material::scatters).collect();
        let scatter = |&id: &u32| scatters[usize::from(mesh.triangle_material[id as usize])];
        let some_scatter = leaves.iter().any(scatter);
        let corners = leaves.iter().flat_map(|&id| mesh.triangle_points(id as usize));
        let bounds = bounds(corners);
        let canopies = (!leaves.is_empty()).then(|| {
            let tracer = Tracer::of_triangles(mesh, &leaves);
            Canopies { mesh, tracer, volumes: Volumes::new(scene), scatters, some_scatter, bounds }
        });
        (Tracer::of_triangles(mesh, &opaque), canopies)
    }

    /// Returns the tracer of leaves and screens alone.
    pub(crate) fn tracer(&self) -> &Tracer {
        &self.tracer
    }

    /// Returns the volumes of leaves.
    pub(crate) fn volumes(&self) -> &Volumes {
        &self.volumes
    }

    /// Returns true if some leaves scatter light.
    pub(crate) fn scatter(&self) -> bool {
        self.some_scatter
    }

    /// Returns true if a point, in input coordinates, is in a closed hull of faces that dim light,
    /// as of a crown: rays in all directions leave more hulls than they enter. Leaves and screens
    /// have no inside, and in volumes light is dimmed by the length of its way.
    pub fn holds(&self, point: DVec3) -> bool {
        let (from, (low, high)) = (self.mesh.grid().relative(point), self.bounds);
        if !(from.cmpge(low).all() && from.cmple(high).all()) {
            return false;
        }
        let left = |direction: &[f32; 3]| {
            let ray = Ray { origin: from.as_vec3().to_array(), direction: *direction };
            let leaves = self.passage(&Path { place: 0, ray, reach_m: f32::INFINITY }).leaves;
            let sides = leaves.iter().map(|hit| if side_met(&ray, hit, self.mesh) == FaceSide::Back { 1 } else { -1 });
            sides.sum::<i32>()
        };
        let all = ALL_WAYS.each_ref().map(left);
        // Faces of a hull may all be wound inwards.
        all.iter().all(|left| *left > 0) || all.iter().all(|left| *left < 0)
    }

    /// Returns the rays among `paths` that cross leaves, in the order of `paths`.
    pub(crate) fn passages(&self, paths: &[Path]) -> Vec<Passage> {
        let rays: Vec<Ray> = paths.iter().map(|path| path.ray).collect();
        // Most rays cross no leaf at all, and packets find that out fast.
        let met = self.tracer.occluded_many(&rays);
        let passage = |(path, _): (&Path, bool)| self.passage(path);
        paths.iter().zip(met).filter(|path| path.1).map(passage).collect()
    }

    /// Counts the crossings of each material by each ray, by place and material.
    pub(crate) fn counted(&self, passages: &[Passage]) -> Vec<Crossing> {
        let crossings = |passage: &Passage| {
            let ray = passage.place;
            let count = move |(material, amount)| Crossing { ray, material, count: self.code(material, amount) };
            self.crossed_before(passage, f64::INFINITY).into_iter().map(count)
        };
        let mut found: Vec<Crossing> = passages.iter().flat_map(crossings).collect();
        found.sort_unstable();
        found
    }

    /// Returns the count or the code of a length by which crossings of a material are stored.
    pub(crate) fn code(&self, material: u16, amount: f64) -> u16 {
        match self.volumes.stopped(material) {
            Some(_) => code_of(amount),
            None => amount.min((COUNTS - 1) as f64) as u16,
        }
    }

    /// Returns the count of crossings of a material, or the code of a length, rounded to a multiple
    /// of `step`; `None` for next to nothing.
    fn rounded(&self, material: u16, count: u16, step: u16) -> Option<u16> {
        match self.volumes.stopped(material) {
            Some(_) => Some((count + step / 2).min(COUNTS as u16 - 1) / step * step).filter(|code| *code > 0),
            None => Some(count),
        }
    }

    /// Returns the crossings of the rays of a cell, with rounded lengths.
    fn counted_of_cell(&self, passages: &[Passage]) -> Vec<Crossing> {
        let rounded = |crossing: Crossing| {
            let count = self.rounded(crossing.material, crossing.count, CODES_OF_CELL)?;
            Some(Crossing { count, ..crossing })
        };
        self.counted(passages).into_iter().filter_map(rounded).collect()
    }

    /// Returns the materials that a ray crosses nearer than a distance, ascending, with the number
    /// of crossings or the length inside, metres.
    pub(crate) fn crossed_before(&self, passage: &Passage, distance_m: f64) -> Vec<(u16, f64)> {
        let faces = passage.leaves.iter().take_while(|hit| f64::from(hit.t) < distance_m);
        let parts = passage.parts.iter().filter(|part| part.from_m < distance_m);
        let inside = parts.map(|part| (part.material, part.to_m.min(distance_m) - part.from_m));
        let mut amounts: Vec<(u16, f64)> = Vec::new();
        for (material, amount) in faces.map(|hit| (self.material(hit), 1.0)).chain(inside) {
            match amounts.iter_mut().find(|known| known.0 == material) {
                Some(known) => known.1 += amount,
                None => amounts.push((material, amount)),
            }
        }
        amounts.sort_unstable_by_key(|(material, _)| *material);
        amounts
    }

    /// Returns the leaves on the way of a ray that scatter light: the faces that it crosses, and a
    /// point in each volume, which `draw` draws by its material.
    pub(crate) fn leaves(&self, passage: &Passage, mut draw: impl FnMut(u16) -> f64) -> Vec<LeafHit> {
        let [from, direction] = [passage.ray.origin, passage.ray.direction].map(|v| DVec3::from(v.map(f64::from)));
        let at = |distance_m: f64| self.mesh.grid().absolute(from) + direction * distance_m;
        let scatters = |material: u16| self.scatters[usize::from(material)];
        let mut found = Vec::new();
        for hit in passage.leaves.iter().filter(|hit| scatters(self.material(hit))) {
            let (distance_m, normal) = (f64::from(hit.t), Some(self.mesh.normal(hit.triangle as usize)));
            let before = self.crossed_before(passage, distance_m);
            found.push(LeafHit {
                material: self.material(hit),
                normal,
                point: at(distance_m),
                distance_m,
                weight: 1.0,
                before,
            });
        }
        for parts in passage.parts.chunk_by(|a, b| a.material == b.material) {
            let material = parts[0].material;
            let drawn = scatters(material).then(|| self.volumes.draw(parts, draw(material))).flatten();
            if let Some(Draw { distance_m, weight }) = drawn {
                let (point, before) = (at(distance_m), self.crossed_before(passage, distance_m));
                found.push(LeafHit { material, normal: None, point, distance_m, weight, before });
            }
        }
        found
    }

    /// Returns the leaves that one ray crosses, one hit of each, and its parts in volumes.
    fn passage(&self, path: &Path) -> Passage {
        let hits = self.tracer.crossed(path.ray);
        let (hulls, faces): (Vec<Hit>, Vec<Hit>) =
            hits.into_iter().partition(|hit| self.volumes.bounds(self.mesh, hit.triangle));
        let faces: Vec<Hit> = faces.into_iter().take_while(|hit| hit.t < path.reach_m).collect();
        let is_new = |&i: &usize| {
            let (hit, before) = (faces[i], faces[..i].iter().rev());
            let mut near = before.take_while(|before| hit.t - before.t <= ONE_PLACE * hit.t);
            !near.any(|before| self.one_leaf(before.triangle, hit.triangle))
        };
        let leaves = (0..faces.len()).filter(is_new).map(|i| faces[i]).collect();
        let parts = self.volumes.parts(self.mesh, &path.ray, &hulls, path.reach_m);
        Passage { place: path.place, ray: path.ray, leaves, parts }
    }

    fn material(&self, hit: &Hit) -> u16 {
        self.mesh.triangle_material[hit.triangle as usize]
    }

    /// Returns true if two triangles have the same material and a common corner.
    fn one_leaf(&self, a: u32, b: u32) -> bool {
        let material = |triangle: u32| self.mesh.triangle_material[triangle as usize];
        material(a) == material(b) && touch(self.mesh, a, b)
    }
}

impl Passage {
    /// Returns a random number from 0 to 1: the direction of the ray decides, in any scene.
    fn draw(&self) -> f64 {
        let seed = self.ray.direction.iter();
        unit(seed.fold(u64::from(self.place), |seed, part| mix(seed, u64::from(part.to_bits()))))
    }
}

/// Returns a warning about a number of receivers in closed hulls of canopies, if there are any.
pub fn in_hulls(count: u64) -> Option<String> {
    let (what, see) = match count {
        0 => return None,
        1 => ("1 receiver stands in the closed hull of a canopy".to_owned(), "it sees"),
        many => (format!("{many} receivers stand in closed hulls of canopies"), "they see"),
    };
    Some(format!(
        "{what}, such as crowns of trees: {see} at most what a wall of the hull lets through, in all directions; place receivers below \
         or beside crowns, or state a higher transmittance"
    ))
}

/// Cell of leaves, and the materials that are crossed before it, with counts or codes of lengths.
type LeafKey = (CellKey, Vec<(u16, u16)>);

/// Seen leaves, gathered by cell and by the leaves in front of them.
pub(crate) struct SeenLeaves<'a> {
    canopies: &'a Canopies<'a>,
    shares: BTreeMap<LeafKey, f64>,
}

impl<'a> SeenLeaves<'a> {
    pub fn new(canopies: &'a Canopies) -> Self {
        SeenLeaves { canopies, shares: BTreeMap::new() }
    }

    /// Adds the leaves on a ray that stands for `share` of the hemisphere. `cell` returns the cell
    /// that is seen of a leaf.
    pub fn add(&mut self, passage: &Passage, share: f64, cell: impl Fn(&LeafHit) -> CellKey) {
        let draw = passage.draw();
        for leaf in self.canopies.leaves(passage, |material| unit(mix(draw.to_bits(), u64::from(material)))) {
            let code = |&(material, amount): &(u16, f64)| {
                let code = self.canopies.code(material, amount);
                Some((material, self.canopies.rounded(material, code, CODES_BEFORE)?))
            };
            let before = leaf.before.iter().filter_map(code).collect();
            *self.shares.entry((cell(&leaf), before)).or_default() += share * leaf.weight;
        }
    }

    /// Returns the light of a leaf behind others, per share, that it is likely to send.
    fn weight(&self, before: &[(u16, u16)], share: f64) -> f64 {
        let behind = |&(material, count): &(u16, u16)| match self.canopies.volumes.stopped(material) {
            Some(_) => (-USUALLY_STOPPED * length_of(count)).exp(),
            None => BEHIND_ONE.powi(i32::from(count)),
        };
        share * before.iter().map(behind).product::<f64>().max(MIN_BEHIND)
    }

    /// Returns all leaves, or draws about `most` of them evenly by the light they may send
    /// (systematic sampling: Madow 1949). The shares of drawn leaves stand for the others, too.
    pub fn gathered(self, most: usize, seed: u64) -> Vec<SeenLeaf> {
        let all: f64 = self.shares.iter().map(|((_, before), share)| self.weight(before, *share)).sum();
        let step = if self.shares.len() > most { all / most as f64 } else { 0.0 };
        let mut at = unit(mix(seed, 0x6c65_6166)) * step;
        // A leaf is drawn once for every `step` that its weight spans.
        let mut drawn = |((cell, before), share): (&LeafKey, &f64)| {
            let own = self.weight(before, *share);
            let mut share = *share;
            if step > 0.0 {
                // `at` is the weight up to the next draw: below 0, the draw lies within this leaf.
                at -= own;
                let count = (-at / step).ceil().max(0.0);
                at += count * step;
                share *= count * step / own;
            }
            (share > 0.0).then(|| SeenLeaf { cell: *cell, before: before.clone(), share: share as f32 })
        };
        self.shares.iter().filter_map(&mut drawn).collect()
    }
}

/// Step of the codes of lengths before leaves: 17 % of the length, 8.6 cm of short ones. So leaves
/// of a cell behind about as many others are one.
const CODES_BEFORE: u16 = 32;

/// Step of the codes of lengths along the rays of a cell: 4 % of the length, 2 cm of short ones. A
/// cell reflects the mean of its texels.
const CODES_OF_CELL: u16 = 8;

/// Factor by which each leaf in front is likely to dim the light of a leaf, and the smallest one of
/// all leaves in front: a replay with fewer leaves must not lose the light of all leaves behind.
const BEHIND_ONE: f64 = 0.5;
const MIN_BEHIND: f64 = 1.0 / 16.0;

impl Viewpoint {
    /// Returns the rays of an n x n hit texture with their lengths: all of them, or only those that
    /// hit a surface.
    pub(crate) fn hit_paths(&self, n: usize, distances_m: &[f32], all: bool, tracer: &Tracer) -> Vec<Path> {
        let (origin, direction) = (self.origin(tracer), self.hit_directions(n));
        let wanted = distances_m.iter().enumerate().filter(|(_, distance)| all || distance.is_finite());
        let path = |(texel, &reach_m): (usize, &f32)| {
            let ray = Ray { origin, direction: direction(texel).as_vec3().to_array() };
            Path { place: texel as u32, ray, reach_m }
        };
        wanted.map(path).collect()
    }
}

/// Largest number of leaves of a cell, per ray to its surroundings. In scenes of trees, keeping
/// all leaves took 2.6 times the bytes and lowered no error.
const LEAVES_OF_RAY: usize = 2;

/// Crossings of the rays of a cell.
#[derive(Clone, Debug, Default)]
pub(crate) struct CellCrossings {
    /// Crossings by texel of the sky, for texels that see sky.
    pub sky: Vec<Crossing>,
    /// Crossings by ray to the surroundings. Rays are numbered in ascending order of the cells that
    /// they hit, as tables of cells hold them.
    pub seen: Vec<Crossing>,
    /// Seen leaves that scatter light.
    pub leaves: Vec<SeenLeaf>,
    /// Number of rays cast.
    pub rays: u64,
}

/// View of cells on leaves.
#[derive(Clone, Copy)]
pub(crate) struct LeafView<'a> {
    pub canopies: &'a Canopies<'a>,
    /// Level of the cells at middle distance; `None` if no scattering leaves are looked for.
    pub closed_level: Option<i8>,
}

impl CellCrossings {
    /// Returns the crossings of a traced cell; empty without canopies. `around` is the part of the
    /// hemisphere that its rays below and above the horizon stand for.
    pub fn new(
        view: Option<LeafView>,
        key: CellKey,
        probe: &ProbeTrace,
        texture: &Directions,
        seen: &[SeenCell],
        around: impl FnOnce() -> Surround,
    ) -> Self {
        let Some(view) = view.filter(|_| !probe.points.is_empty()) else { return CellCrossings::default() };
        let (canopies, directions) = (view.canopies, texture.of(key));
        let sky = |texel: usize| {
            let ray = probe.starts.ray(usize::from(probe.owner[texel]), directions[texel]);
            Path { place: texel as u32, ray, reach_m: f32::INFINITY }
        };
        let open = |&texel: &usize| bit(&probe.bits, texel);
        let sky: Vec<Path> = texture.texels().filter(open).map(sky).collect();
        // Rays are numbered in the order in which tables of cells sort their hits.
        let mut order: Vec<&SeenCell> = seen.iter().collect();
        order.sort_by_key(|seen| (!seen.up, seen.cell.is_none(), seen.cell));
        let path = |(seen, place): (&&SeenCell, u32)| seen.path.map(|(ray, reach_m)| Path { place, ray, reach_m });
        let seen: Vec<Path> = order.iter().zip(0..).filter_map(path).collect();
        let rays = (sky.len() + seen.len()) as u64;
        let [to_sky, to_seen] = [canopies.passages(&sky), canopies.passages(&seen)];
        let [sky, seen] = [&to_sky, &to_seen].map(|passages| canopies.counted_of_cell(passages));
        let mut leaves = SeenLeaves::new(canopies);
        if let Some(closed) = view.closed_level.filter(|_| !(to_sky.is_empty() && to_seen.is_empty())) {
            let mut see = |passage: &Passage, share: f64| {
                leaves.add(passage, share, |leaf| seen_from(key, leaf.looked_at_m(), closed, |level| leaf.cell(level)));
            };
            let texel = 2.0 / (texture.n * texture.n) as f64;
            for passage in &to_sky {
                let cosine = probe.normal.dot(directions[passage.place as usize]) as f32;
                see(passage, texel * f64::from(SidesOf(key).cosine(cosine)));
            }
            let each = each_ray(&order.iter().map(|seen| seen.as_hit()).collect::<Vec<u32>>(), around());
            for passage in &to_seen {
                see(passage, each[usize::from(order[passage.place as usize].up)]);
            }
        }
        CellCrossings { rays, sky, seen, leaves: leaves.gathered(LEAVES_OF_RAY * order.len(), key.seed()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use heliotile_core::site::material::{Class, Material};

    /// In a hull of 4 x 4 x 3 m, wound outwards or inwards, and where two hulls overlap, the middle
    /// is inside, and points below, beside and above it are not. Between two screens nothing is
    /// inside.
    #[test]
    fn only_closed_hulls_hold_points() {
        let crown =
            |name: &str| Material { transmittance: Some(0.17), ..Material::matt(name, 0.0, Class::Obstruction) };
        let holds = |triangles: &[([DVec3; 3], u16)], points: &[[f64; 3]]| -> Vec<bool> {
            let scene = Scene::from_triangles(triangles, vec![crown("crown")]).expect("a scene");
            let canopies = Canopies::split(&scene).1.expect("canopies");
            points.iter().map(|point| canopies.holds(DVec3::from(*point))).collect()
        };
        let hull = |at: DVec3, faces: usize| {
            let corner = |i: usize| at + DVec3::new(4.0 * (i & 1) as f64, 2.0 * (i & 2) as f64, 0.75 * (i & 4) as f64);
            let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]];
            let halves = |s: [usize; 4]| [([s[0], s[1], s[2]].map(corner), 0), ([s[0], s[2], s[3]].map(corner), 0)];
            sides.into_iter().take(faces).flat_map(halves).collect::<Vec<_>>()
        };
        let points = [[2.0, 2.0, 3.5], [2.0, 2.0, 1.0], [6.0, 2.0, 3.5], [2.0, 2.0, 6.0]];
        let one = hull(DVec3::new(0.0, 0.0, 2.0), 6);
        let turned: Vec<_> = one.iter().map(|([a, b, c], material)| ([*c, *b, *a], *material)).collect();
        let two = [one.clone(), hull(DVec3::new(1.0, 1.0, 1.5), 6)].concat();
        assert_eq!(holds(&one, &points), [true, false, false, false]);
        assert_eq!(holds(&turned, &points), [true, false, false, false]);
        assert_eq!(holds(&two, &points), [true, false, false, false]);
        // The first two faces are the underside and the top.
        assert_eq!(holds(&hull(DVec3::new(0.0, 0.0, 2.0), 2), &points), [false; 4]);
        assert_eq!(in_hulls(0), None);
        assert!(in_hulls(3).is_some_and(|text| text.starts_with("3 receivers stand in closed hulls")));
    }

    /// A leaf of six triangles around a corner, drawn from both sides, lies below a quad of two.
    /// Rays through the corner, an edge, a diagonal and the middle of triangles cross 2 leaves
    /// each, 1 of each material. A ray that ends between them crosses 1, and one beside them none.
    #[test]
    fn one_place_is_one_leaf() {
        let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let mut triangles = Vec::new();
        for k in 0..6 {
            let corner = |k: i32| {
                let a = f64::from(k) * std::f64::consts::FRAC_PI_3;
                at(4.0 * a.cos(), 4.0 * a.sin(), 2.0)
            };
            let (a, b) = (corner(k), corner(k + 1));
            triangles.push(([at(0.0, 0.0, 2.0), a, b], 0));
            triangles.push(([at(0.0, 0.0, 2.0), b, a], 0));
        }
        let [a, b, c, d] = [(-4.0, -4.0), (4.0, -4.0), (4.0, 4.0), (-4.0, 4.0)].map(|(x, y)| at(x, y, 3.0));
        triangles.extend([([a, b, c], 1), ([a, c, d], 1)]);
        let screen =
            |name: &str| Material { transmittance: Some(0.5), ..Material::matt(name, 0.0, Class::Obstruction) };
        let scene = Scene::from_triangles(&triangles, vec![screen("a"), screen("b")]).expect("a scene");
        let (opaque, canopies) = Canopies::split(&scene);
        let canopies = canopies.expect("canopies");
        let origin = scene.mesh.origin;
        let path = |(x, y, reach_m): (f64, f64, f32)| {
            let from = (at(x, y, 0.0) - origin).as_vec3().to_array();
            Path { place: 7, ray: Ray { origin: from, direction: [0.0, 0.0, 1.0] }, reach_m }
        };
        let far = f32::INFINITY;
        let count = |material, count| Crossing { ray: 7, material, count };
        for through in [(0.0, 0.0, far), (2.0, 0.0, far), (1.0, 1.0, far), (0.3, -1.1, far), (-1.7, 1.2, far)] {
            assert_eq!(
                canopies.counted(&canopies.passages(&[path(through)])),
                [count(0, 1), count(1, 1)],
                "{through:?}"
            );
            assert!(!opaque.occluded(path(through).ray));
        }
        assert_eq!(canopies.counted(&canopies.passages(&[path((0.3, 0.3, 2.5))])), [count(0, 1)]);
        assert_eq!(canopies.counted(&canopies.passages(&[path((9.0, 0.3, far))])), []);
    }
}
