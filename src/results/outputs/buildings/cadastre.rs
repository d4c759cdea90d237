//! Running sums of buildings and their roof faces. In: all receivers once, for the building and
//! face they belong to; then again with their sums. Out: the numbers of the tables. Memory holds 8
//! bytes a receiver, the numbers of each building and face, and patches of faces that are not
//! complete.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use super::face::{AreaSum, OnRoof, RoofFace, Usable};
use super::place::{Envelope, building_of, face_of};
use crate::outputs::kinds_and_sides::side;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::site::north::North;
use heliotile_core::site::patch::Patch;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::{FirstNames, counted};
use heliotile_core::units::tilt_and_azimuth;

/// Orientations, in the order of columns.
pub const SIDES: [&str; 5] = ["flat", "north", "east", "south", "west"];

/// Sums of a building.
#[derive(Clone, Debug, Default)]
pub struct BuildingSums {
    pub roof: AreaSum,
    /// Sums by side, in the order of [`SIDES`], kWh.
    pub roof_sides: [f64; 5],
    pub facade: AreaSum,
    pub facade_sides: [f64; 5],
}

/// Building or face that the sum of a receiver is added to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Target {
    Face(u32),
    Facade(u32),
    Nowhere,
}

/// Buildings of a site and their roof faces.
pub struct Cadastre {
    pub usable: Usable,
    north: North,
    /// Names of buildings, sorted.
    pub names: Vec<String>,
    /// `[building]`: sums.
    pub buildings: Vec<BuildingSums>,
    pub faces: Vec<RoofFace>,
    /// `[receiver]`: building or face that it counts to.
    targets: Vec<Target>,
    done: usize,
    /// Highest sum of a receiver on a roof, kWh/m2.
    pub best_kwh_m2: f64,
}

/// Receivers without a required property, for an error message.
#[derive(Default)]
struct Lacking(FirstNames<3>);

impl Lacking {
    fn check(&self, file: &Path, what: &str, hint: &'static str) -> Result<()> {
        if self.0.count == 0 {
            return Ok(());
        }
        let count = counted(self.0.count, "receiver");
        let what = format!("{count} of roofs and facades {what}: {}", self.0.listed());
        Err(Error::input(file, None, what, hint))
    }
}

impl Cadastre {
    /// Reads the receivers of `file`, which must come in the same order as their sums.
    pub fn new(
        receivers: impl Iterator<Item = Result<Receiver>>,
        usable: Usable,
        north: North,
        file: &Path,
    ) -> Result<Self> {
        let mut numbers: BTreeMap<String, u32> = BTreeMap::new();
        let mut faces: Vec<RoofFace> = Vec::new();
        let mut face_numbers: HashMap<(u32, String), u32> = HashMap::new();
        let mut targets = Vec::new();
        let (mut homeless, mut without_area) = (Lacking::default(), Lacking::default());
        let mut kinds: BTreeMap<String, u64> = BTreeMap::new();
        for receiver in receivers {
            let receiver = receiver?;
            let envelope = Envelope::new(&receiver);
            if envelope == Envelope::Neither {
                targets.push(Target::Nowhere);
                *kinds.entry(receiver.part.kind).or_default() += 1;
                continue;
            }
            let Some(name) = building_of(&receiver) else {
                homeless.0.add(|| receiver.id);
                continue;
            };
            let next = numbers.len() as u32;
            let building = *numbers.entry(name.to_owned()).or_insert(next);
            if receiver.area.is_none() {
                without_area.0.add(|| receiver.id);
                continue;
            }
            if envelope == Envelope::Facade {
                targets.push(Target::Facade(building));
                *kinds.entry("wall".into()).or_default() += 1;
                continue;
            }
            let name = face_of(&receiver).to_owned();
            let number = *face_numbers.entry((building, name)).or_insert_with_key(|(building, name)| {
                faces.push(RoofFace::new(*building, name.clone()));
                faces.len() as u32 - 1
            });
            if let Some(face) = faces.get_mut(number as usize) {
                face.receivers += 1;
            }
            targets.push(Target::Face(number));
        }
        let hint = "build with names in a column `building` or `object`, as `{command:receivers}` writes them";
        let lacks = |name| move |error: Error| error.because(Problem::Lacks(name));
        homeless.check(file, "without a building or an object", hint).map_err(lacks("building"))?;
        let hint = "build with a column `area`, as `{command:receivers}` writes it";
        without_area.check(file, "without an area", hint).map_err(lacks("area"))?;
        if faces.is_empty() {
            let found: Vec<String> =
                kinds.iter().map(|(kind, count)| format!("{} on `{kind}`", counted(*count, "receiver"))).collect();
            let what = format!("has no receivers on roofs, only {}", found.join(", "));
            let hint = "cover roofs too, with {on} roof,wall or without {on}";
            return Err(Error::input(file, None, what, hint).because(Problem::Lacks("roofs")));
        }
        // Buildings were numbered by first appearance; results list them by name.
        let mut places = vec![0; numbers.len()];
        for (place, number) in (0..).zip(numbers.values()) {
            places[*number as usize] = place;
        }
        faces.iter_mut().for_each(|face| face.building = places[face.building as usize]);
        for target in &mut targets {
            if let Target::Facade(building) = target {
                *building = places[*building as usize];
            }
        }
        let buildings = vec![BuildingSums::default(); numbers.len()];
        let names = numbers.into_keys().collect();
        Ok(Cadastre { usable, north, names, buildings, faces, targets, done: 0, best_kwh_m2: 0.0 })
    }

    /// Adds the sum of the next receiver.
    pub fn add(&mut self, receiver: &Receiver, patch: Patch, sky_view: f64, kwh_m2: f64) {
        let target = self.targets.get(self.done).copied().unwrap_or(Target::Nowhere);
        self.done += 1;
        let area_m2 = receiver.area.unwrap_or_default();
        let lit = AreaSum { area_m2, kwh: area_m2 * kwh_m2 };
        let (tilt, azimuth) = tilt_and_azimuth(self.north.to_true(receiver.normal));
        match target {
            Target::Nowhere => {}
            Target::Facade(building) => {
                let sums = &mut self.buildings[building as usize];
                sums.facade.add(lit);
                // Any facade counts to a compass side, even a leaning wall: its tilt is taken as 90
                // degrees.
                sums.facade_sides[place_of(side(90.0, azimuth))] += lit.kwh;
            }
            Target::Face(number) => {
                let face = &mut self.faces[number as usize];
                let sums = &mut self.buildings[face.building as usize];
                sums.roof.add(lit);
                sums.roof_sides[place_of(side(tilt, azimuth))] += lit.kwh;
                self.best_kwh_m2 = self.best_kwh_m2.max(kwh_m2);
                let (place, normal) = (receiver.position, receiver.normal);
                face.add(OnRoof { place, normal, patch, sky_view, area_m2, kwh_m2 }, self.usable);
            }
        }
    }

    /// Returns tilt and azimuth of a face, degrees, the latter from true north.
    pub fn direction(&self, face: &RoofFace) -> (f64, f64) {
        tilt_and_azimuth(self.north.to_true(face.normal()))
    }

    /// Returns the number of faces that count as one region because patches are unknown.
    pub fn vague(&self) -> usize {
        self.faces.iter().filter(|face| face.is_vague).count()
    }
}

/// Returns the index of a side in [`SIDES`]; surfaces that face down count as flat.
fn place_of(side: &str) -> usize {
    SIDES.iter().position(|name| *name == side).unwrap_or_default()
}
