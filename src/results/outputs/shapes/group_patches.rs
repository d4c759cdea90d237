//! Patches of groups of receivers. In: receivers in the archive's order, each with its group. Out:
//! group by group, in the order of names, the properties that its receivers share and the outlines
//! of their patches. Memory holds one group; the others may wait in a temporary file.

use std::iter::Peekable;
use std::path::Path;

use super::outline::{Piece, outlines};
use super::row::{MapPolygon, MapRow};
use glam::DVec3;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::site::model_part::ModelPart;
use heliotile_core::site::patch::Patch;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::FirstNames;
use heliotile_files::spill::{Sorted, Sorter};

/// Returns the polygons of a receiver, in scene coordinates: its patch, or else a square of its
/// area. Returns `None` if it has neither, or if they vanish in the rounding to mm.
pub fn polygons(receiver: &Receiver) -> Option<Vec<MapPolygon>> {
    let square = || receiver.area.map(|area| Patch::square(receiver.normal, area));
    let patch = if receiver.patch.is_empty() { square()? } else { receiver.patch.clone() };
    let corner = |mm: &[i32; 3]| receiver.position + DVec3::from_array(mm.map(f64::from)) / 1e3;
    let polygon = |ring: &Vec<[i32; 3]>| MapPolygon { rings: vec![ring.iter().map(corner).collect()] };
    let polygons: Vec<MapPolygon> = patch.polygons().iter().map(polygon).collect();
    (!polygons.is_empty()).then_some(polygons)
}

/// Receivers that cannot be drawn.
#[derive(Default)]
pub struct Shapeless(FirstNames<3>);

impl Shapeless {
    /// Fails if any of the receivers of a file cannot be drawn.
    pub fn refuse(receivers: impl Iterator<Item = Result<Receiver>>, file: &Path) -> Result<()> {
        let mut shapeless = Shapeless::default();
        for receiver in receivers {
            let receiver = receiver?;
            if polygons(&receiver).is_none() {
                shapeless.0.add(|| receiver.id);
            }
        }
        shapeless.check(file)
    }

    /// Fails if there are any.
    fn check(&self, file: &Path) -> Result<()> {
        if self.0.count == 0 {
            return Ok(());
        }
        let what = format!("{} receivers have neither a patch nor an area: {}", self.0.count, self.0.listed());
        let hint = "a map draws surfaces: build with receivers that cover a scene, or with a column `area`, or choose others with {receivers}";
        Err(Error::input(file, None, what, hint).because(Problem::Lacks("area")))
    }
}

/// Collector of patches by group.
pub struct PatchSorter {
    sorter: Sorter,
    shapeless: Shapeless,
}

impl PatchSorter {
    pub fn new(folder: &Path, memory_bytes: usize) -> Self {
        PatchSorter { sorter: Sorter::new(folder, memory_bytes), shapeless: Shapeless::default() }
    }

    /// Adds the next receiver; `group` is the index of its group among the sorted names.
    pub fn push(&mut self, group: u32, receiver: Receiver) -> Result<()> {
        let Some(polygons) = polygons(&receiver) else {
            self.shapeless.0.add(|| receiver.id);
            return Ok(());
        };
        let part = receiver.part.texts().map(str::to_owned);
        let texts = [receiver.surface.unwrap_or_default()].into_iter().chain(part).collect();
        let normal = receiver.normal.to_array().map(|share| share as f32).to_vec();
        self.sorter.push(&group.to_be_bytes(), &MapRow { texts, numbers: normal, polygons }.bytes())
    }

    /// Returns all patches by group; fails if some receivers cannot be drawn.
    pub fn finish(self, file: &Path) -> Result<GroupPatches> {
        self.shapeless.check(file)?;
        Ok(GroupPatches { sorted: self.sorter.finish()?.peekable(), next: 0 })
    }
}

/// Patches by group.
pub struct GroupPatches {
    sorted: Peekable<Sorted>,
    next: u32,
}

impl GroupPatches {
    /// Returns the next group: a receiver with the properties that all of its receivers share, and
    /// outlines.
    pub fn next_group(&mut self) -> Result<(Receiver, Vec<MapPolygon>)> {
        let key = self.next.to_be_bytes();
        self.next += 1;
        let mut common: Option<Vec<String>> = None;
        let mut pieces = Vec::new();
        while let Some(record) = self.sorted.next_if(|record| record.as_ref().map_or(true, |(at, _)| **at == key)) {
            let MapRow { texts, numbers, polygons } = MapRow::of_bytes(&record?.1)?;
            let normal = <[f32; 3]>::try_from(numbers).unwrap_or_default().map(f64::from);
            let normal = DVec3::from_array(normal).normalize_or_zero();
            let rings = polygons.into_iter().flat_map(|polygon| polygon.rings);
            pieces.extend(rings.map(|ring| Piece { ring, normal }));
            match &mut common {
                Some(common) => common.iter_mut().zip(texts).filter(|(a, b)| *a != b).for_each(|(a, _)| a.clear()),
                None => common = Some(texts),
            }
        }
        let mut texts = common.unwrap_or_default().into_iter();
        let surface = texts.next().filter(|name| !name.is_empty());
        let part = ModelPart::of_texts([(); 5].map(|()| texts.next().unwrap_or_default()));
        let receiver = Receiver { surface, part, ..Receiver::new(String::new(), DVec3::ZERO, DVec3::Z) };
        Ok((receiver, outlines(pieces)))
    }
}
