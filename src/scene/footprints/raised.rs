//! Faces of buildings from footprints. In: the footprints of all files of a scene, in scene
//! coordinates, and the ground below. Out: for each file, faces: flat roofs, walls where no
//! neighbour stands, and undersides of parts that begin above the ground.

use std::cmp::Ordering;
use std::collections::HashMap;
use std::path::Path;

use glam::DVec2;
use heliotile_core::error::{Error, Result};
use heliotile_core::site::scene_object::ObjectNote;
use heliotile_core::text::{Message, counted, message};

use crate::attributes::{object_of, text_of};
use crate::footprint::{Footprint, PlanRing, StatedHeights};
use crate::footprint_options::MAX_HEIGHT_M;
use crate::footprints::ground_below::GroundBelow;
use crate::footprints::nodes::Noded;
use crate::footprints::overlaps::{Block, groups, outlines_without_parts, overlapping, settle};
use crate::footprints::shared_walls::{FreeWall, FreeWalls, Side, Standing, free_walls};
use crate::geometry::Geometry;
use heliotile_core::site::semantics::{FaceNote, SurfaceKind};

/// Materials of the faces, named as in city models.
const ROOF: &str = "RoofSurface";
const WALL: &str = "WallSurface";
const UNDERSIDE: &str = "OuterCeilingSurface";

/// Height of a building's foot over its base below which it stands on the ground, metres.
const ON_GROUND_M: f64 = 0.1;

/// Footprints of one file.
pub(crate) struct FootprintFile<'a> {
    pub file: &'a Path,
    /// Height added to stated bases, and the base without ground, metres.
    pub elevation_m: f64,
    pub footprints: Vec<Footprint>,
    /// Geometry that the faces are added to.
    pub geometry: &'a mut Geometry,
}

/// Adds the faces of all footprints to the geometry of their files; returns notes on what was done.
pub(crate) fn raise(files: &mut [FootprintFile], ground: &GroundBelow) -> Result<Vec<Message>> {
    let mut town = Town::new(files);
    let all = town.members.len();
    let pairs = {
        let shapes: Vec<&[Vec<PlanRing>]> = town.blocks.iter().map(|block| block.polygons.as_slice()).collect();
        overlapping(&shapes)
    };
    town.refuse_without_base(files, ground)?;
    town.set_bases(ground, &groups(all, &pairs));
    town.leave_out_below_ground(files);
    let wholes = outlines_without_parts(&mut town.blocks, &pairs);
    let consist_of_parts = town.blocks.iter().filter(|block| block.polygons.is_empty()).count();
    let filled = settle(&mut town.blocks, &pairs);
    // Cut blocks have new corners, which are merged with those of neighbours before sides are
    // compared.
    if !pairs.is_empty() {
        let noded = town.noded();
        for (number, block) in town.blocks.iter_mut().enumerate() {
            block.polygons = noded.polygons(number);
        }
    }
    let noded = town.noded();
    let free = free_walls(sides_of(&noded), &town.standing());
    let mut notes = vec![message!(
        "{} and building parts raised from footprints, with flat roofs; {} of their sides touch a neighbour",
        counted((all - consist_of_parts) as u64, "building"),
        free.shared_sides
    )];
    if filled > 0 {
        notes.push(message!(
            "{} overlapped another building, which keeps the shared space",
            counted(filled as u64, "footprint")
        ));
    }
    notes.extend(town.base_notes(ground));
    town.add_faces(files, &noded, &free, &wholes)?;
    Ok(notes)
}

/// Reference to a footprint among those of all files.
#[derive(Clone, Copy)]
struct Member {
    file: usize,
    footprint: usize,
    heights: StatedHeights,
    elevation_m: f64,
}

/// All footprints of a scene, in an order that depends on them alone.
struct Town {
    members: Vec<Member>,
    /// Block of each member.
    blocks: Vec<Block>,
    /// Number of footprints without ground below, in a scene that has ground.
    beside_ground: usize,
}

impl Town {
    /// Collects the footprints of all files.
    fn new(files: &mut [FootprintFile]) -> Town {
        let mut all: Vec<([DVec2; 2], Member, &Footprint)> = Vec::new();
        for (file, of) in files.iter().enumerate() {
            for (footprint, found) in of.footprints.iter().enumerate() {
                let member = Member { file, footprint, heights: found.heights, elevation_m: of.elevation_m };
                all.push((found.bounds(), member, found));
            }
        }
        all.sort_by(|(a, _, one), (b, _, other)| {
            let numbers = |[low, high]: &[DVec2; 2], of: &Footprint| {
                [low.x, low.y, high.x, high.y, of.heights.roof_m, of.heights.foot_m]
            };
            let order = numbers(a, one).into_iter().zip(numbers(b, other)).map(|(a, b)| a.total_cmp(&b));
            order.reduce(Ordering::then).unwrap_or(Ordering::Equal).then_with(|| one.name.cmp(&other.name))
        });
        let block =
            |found: &Footprint| Block { polygons: found.polygons.clone(), is_part: found.is_part, ..Block::default() };
        Town {
            blocks: all.iter().map(|(_, _, found)| block(found)).collect(),
            members: all.iter().map(|(_, member, _)| *member).collect(),
            beside_ground: 0,
        }
    }

    /// Sets the base of each block: the stated one, else the lowest ground below all blocks that it
    /// overlaps, else the lowest ground of all, else the height of the file.
    fn set_bases(&mut self, ground: &GroundBelow, groups: &[usize]) {
        let below = |(block, member): (&Block, &Member)| match member.heights.base_m {
            None if !ground.is_empty() => ground.lowest(block.polygons.iter().flatten()),
            _ => None,
        };
        let found: Vec<Option<f64>> = self.blocks.iter().zip(&self.members).map(below).collect();
        let lowest_of_all = found.iter().flatten().copied().reduce(f64::min);
        let mut lowest: HashMap<usize, f64> = HashMap::new();
        for (group, height) in groups.iter().zip(&found) {
            if let Some(height) = height {
                let entry = lowest.entry(*group).or_insert(*height);
                *entry = entry.min(*height);
            }
        }
        for ((block, member), group) in self.blocks.iter_mut().zip(&self.members).zip(groups) {
            let StatedHeights { roof_m, is_roof_absolute, foot_m, base_m, .. } = member.heights;
            let below = lowest.get(group).copied();
            self.beside_ground += usize::from(base_m.is_none() && below.is_none() && lowest_of_all.is_some());
            let stated = base_m.map(|base_m| base_m + member.elevation_m);
            let base_m = stated.or(below).or(lowest_of_all).unwrap_or(member.elevation_m);
            let zero_m = if is_roof_absolute { member.elevation_m } else { base_m };
            (block.foot_m, block.roof_m) = (base_m + foot_m, zero_m + roof_m);
        }
    }

    /// Refuses roofs above the sea where nothing says how high their ground is.
    fn refuse_without_base(&self, files: &[FootprintFile], ground: &GroundBelow) -> Result<()> {
        let lacks_base = |member: &&Member| member.heights.is_roof_absolute && member.heights.base_m.is_none();
        let first = self.members.iter().find(lacks_base).filter(|_| ground.is_empty());
        let Some(of) = first.and_then(|first| files.get(first.file)) else { return Ok(()) };
        let count = counted(self.members.iter().filter(lacks_base).count() as u64, "footprint");
        let what = format!("{count} with a roof above the sea and no ground: the height of the building is not known");
        let hint = "name the column of the ground as {base} (as in {base} ground), or add terrain to the scene";
        Err(Error::input(of.file, None, what, hint))
    }

    /// Leaves out buildings whose roof above the sea is not above their foot.
    fn leave_out_below_ground(&mut self, files: &mut [FootprintFile]) {
        for (block, member) in self.blocks.iter_mut().zip(&self.members) {
            let height_m = block.roof_m - (block.foot_m - member.heights.foot_m);
            let stands = block.roof_m > block.foot_m && height_m <= MAX_HEIGHT_M;
            if member.heights.is_roof_absolute && !stands {
                block.polygons.clear();
                if let Some(of) = files.get_mut(member.file) {
                    of.geometry.leave_out("whose roof above the sea is not from 0 to 1000 m above their ground");
                }
            }
        }
    }

    fn base_notes(&self, ground: &GroundBelow) -> Vec<Message> {
        let others = self.members.iter().filter(|member| member.heights.base_m.is_none()).count();
        let mut notes = Vec::new();
        if others > 0 {
            let base = match ground.is_empty() {
                true => "stand at the height of their file (0 m, or {elevation}), because no file has terrain",
                false => "stand on the lowest ground below their outline",
            };
            notes.push(message!("{} ", counted(others as u64, "footprint")).and(base));
        }
        if self.beside_ground > 0 {
            let beside = counted(self.beside_ground as u64, "footprint");
            notes.push(message!("{beside} outside of the terrain: the lowest base of all footprints is used"));
        }
        notes
    }

    fn noded(&self) -> Noded {
        let polygons: Vec<&[Vec<PlanRing>]> = self.blocks.iter().map(|block| block.polygons.as_slice()).collect();
        Noded::new(&polygons)
    }

    fn standing(&self) -> Vec<Standing> {
        let standing = |(block, member): (&Block, &Member)| Standing {
            foot_m: block.foot_m,
            roof_m: block.roof_m,
            on_ground: member.heights.foot_m < ON_GROUND_M,
        };
        self.blocks.iter().zip(&self.members).map(standing).collect()
    }

    /// Adds faces in the order of the files and their features.
    fn add_faces(
        &self,
        files: &mut [FootprintFile],
        noded: &Noded,
        free: &FreeWalls,
        wholes: &[Option<usize>],
    ) -> Result<()> {
        let mut walls: Vec<&FreeWall> = free.walls.iter().collect();
        walls.sort_by_key(|wall| wall.side.footprint);
        let mut order: Vec<usize> = (0..self.members.len()).collect();
        order.sort_by_key(|&i| self.members.get(i).map(|member| (member.file, member.footprint)));
        for number in order {
            let (Some(member), Some(block)) = (self.members.get(number), self.blocks.get(number)) else { continue };
            let whole = wholes.get(number).copied().flatten().and_then(|whole| self.members.get(whole));
            let whole = whole.and_then(|whole| files.get(whole.file)?.footprints.get(whole.footprint)).cloned();
            let Some(of) = files.get_mut(member.file) else { continue };
            let Some(footprint) = of.footprints.get(member.footprint) else { continue };
            if block.polygons.is_empty() {
                continue;
            }
            let first = walls.partition_point(|wall| (wall.side.footprint as usize) < number);
            let walls = walls.get(first..).unwrap_or_default();
            let count = match member.heights.has_walls {
                true => walls.partition_point(|wall| wall.side.footprint as usize == number),
                false => 0,
            };
            of.geometry.is_raised = true;
            let object = of.geometry.objects.id(&footprint.name);
            of.geometry.object_notes.insert(object, note_of(footprint, whole.as_ref()));
            let solid = Solid {
                block,
                polygons: noded.footprints.get(number).map(Vec::as_slice).unwrap_or_default(),
                positions: &noded.positions,
                walls: walls.get(..count).unwrap_or_default(),
                has_underside: member.heights.foot_m >= ON_GROUND_M,
            };
            let line = footprint.number;
            Faces { file: of.file, geometry: of.geometry, object, line, corners: HashMap::new() }.add(&solid)?;
        }
        Ok(())
    }
}

/// Everything that the faces of a footprint are made from.
struct Solid<'a> {
    block: &'a Block,
    /// Polygons of the footprint on nodes.
    polygons: &'a [Vec<Vec<u32>>],
    /// Positions of all nodes.
    positions: &'a [DVec2],
    walls: &'a [&'a FreeWall],
    has_underside: bool,
}

/// Returns the note of a building; a part also has the attributes of its whole.
fn note_of(footprint: &Footprint, whole: Option<&Footprint>) -> ObjectNote {
    let building = match (footprint.building.is_empty(), whole) {
        (true, Some(whole)) => whole.name.clone(),
        (true, None) => footprint.name.clone(),
        (false, _) => footprint.building.clone(),
    };
    let attributes = match whole {
        Some(whole) => {
            let mut all = object_of(&whole.attributes);
            all.extend(object_of(&footprint.attributes));
            text_of(all)
        }
        None => footprint.attributes.clone(),
    };
    let object_type = if footprint.is_part { "BuildingPart" } else { "Building" };
    ObjectNote { building, object_type: object_type.to_owned(), attributes, ..ObjectNote::default() }
}

/// Writer of the faces of a footprint.
struct Faces<'a> {
    file: &'a Path,
    geometry: &'a mut Geometry,
    object: u32,
    line: usize,
    /// Vertices by node and height.
    corners: HashMap<(u32, u64), u32>,
}

impl Faces<'_> {
    fn add(&mut self, solid: &Solid) -> Result<()> {
        let Solid { block, has_underside, .. } = *solid;
        match &block.free_roof {
            Some(free) => self.flats(free, block.roof_m, false)?,
            None => self.noded_flats(solid, block.roof_m, false)?,
        }
        for wall in solid.walls {
            self.wall(wall, solid.positions)?;
        }
        match &block.free_underside {
            Some(free) if has_underside => self.flats(free, block.foot_m, true),
            None if has_underside => self.noded_flats(solid, block.foot_m, true),
            _ => Ok(()),
        }
    }

    fn wall(&mut self, wall: &FreeWall, positions: &[DVec2]) -> Result<()> {
        let FreeWall { side: Side { from, to, .. }, foot_m, roof_m } = *wall;
        for (node, height_m) in [(from, foot_m), (to, foot_m), (to, roof_m), (from, roof_m)] {
            let corner = self.corner(node, height_m, positions)?;
            self.geometry.push_corner(corner);
        }
        self.end(WALL, SurfaceKind::Wall);
        Ok(())
    }

    /// Adds a roof or an underside on nodes.
    fn noded_flats(&mut self, solid: &Solid, height_m: f64, below: bool) -> Result<()> {
        let is_area = |polygon: &&Vec<Vec<u32>>| polygon.first().is_some_and(|outline| outline.len() > 2);
        for polygon in solid.polygons.iter().filter(is_area) {
            for (number, ring) in polygon.iter().filter(|ring| ring.len() > 2).enumerate() {
                let corners = ring.iter().map(|node| self.corner(*node, height_m, solid.positions));
                let corners = corners.collect::<Result<_>>()?;
                self.ring(number, corners, below);
            }
            self.end_flat(below);
        }
        Ok(())
    }

    /// Adds a roof or an underside of polygons in plan.
    fn flats(&mut self, polygons: &[Vec<PlanRing>], height_m: f64, below: bool) -> Result<()> {
        for polygon in polygons {
            for (number, ring) in polygon.iter().enumerate() {
                let corners = ring.iter().map(|corner| self.geometry.push_vertex(self.file, corner.extend(height_m)));
                let corners = corners.collect::<Result<_>>()?;
                self.ring(number, corners, below);
            }
            self.end_flat(below);
        }
        Ok(())
    }

    fn ring(&mut self, number: usize, mut corners: Vec<u32>, below: bool) {
        if number > 0 {
            self.geometry.begin_hole();
        }
        if below {
            corners.reverse();
        }
        corners.into_iter().for_each(|corner| self.geometry.push_corner(corner));
    }

    fn end_flat(&mut self, below: bool) {
        if below { self.end(UNDERSIDE, SurfaceKind::Floor) } else { self.end(ROOF, SurfaceKind::Roof) }
    }

    fn end(&mut self, material: &str, kind: SurfaceKind) {
        let material = self.geometry.materials.id(material);
        self.geometry.end_face(material, self.object, self.line);
        self.geometry.note_face(FaceNote { kind: Some(kind), ..FaceNote::default() });
    }

    fn corner(&mut self, node: u32, height_m: f64, positions: &[DVec2]) -> Result<u32> {
        if let Some(known) = self.corners.get(&(node, height_m.to_bits())) {
            return Ok(*known);
        }
        let place = positions.get(node as usize).copied().unwrap_or_default();
        let corner = self.geometry.push_vertex(self.file, place.extend(height_m))?;
        self.corners.insert((node, height_m.to_bits()), corner);
        Ok(corner)
    }
}

/// Returns all sides of all footprints.
fn sides_of(noded: &Noded) -> Vec<Side> {
    let mut sides = Vec::new();
    for (footprint, polygons) in (0..).zip(&noded.footprints) {
        for ring in polygons.iter().flatten().filter(|ring| ring.len() > 2) {
            let pairs = ring.iter().zip(ring.iter().cycle().skip(1));
            sides.extend(pairs.map(|(from, to)| Side { from: *from, to: *to, footprint }));
        }
    }
    sides
}
