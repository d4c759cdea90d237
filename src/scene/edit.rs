//! Edits of a scene by the names of its objects. In: a scene as an archive holds it, edits. Out: triangles with materials and objects, and what
//! became of each object.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt;
use std::path::Path;
use std::str::FromStr;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::Scene;
use crate::change::TracedScene;
use crate::ground::endless;
use crate::mesh::bounds;
use crate::mesh_objects::{MeshObjects, SceneObject};
use heliotile_core::error::{Error, Result};
use heliotile_core::site::material::Material;
use heliotile_core::text::counted;

/// What is to become of objects; a name is that of an object, or of the building that objects are parts of.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SceneEdits {
    /// Objects that go.
    pub remove: Vec<String>,
    /// Objects that are put elsewhere.
    pub moves: Vec<ObjectMove>,
    /// Objects whose roofs go up or down.
    pub heights: Vec<ObjectHeight>,
    /// Objects that get another material.
    pub materials: Vec<ObjectMaterial>,
}

/// An object that is put elsewhere: `OBJECT=dx,dy,dz`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectMove {
    /// Its name.
    pub object: String,
    /// How far, metres along x, y and z.
    pub by_m: [f64; 3],
}

/// An object whose roofs go up or down, and its walls with them: `OBJECT=+3m`, `OBJECT=-3m` or `OBJECT=12m`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectHeight {
    /// Its name.
    pub object: String,
    /// How high it becomes.
    pub height: NewHeight,
}

/// How high an object becomes; as text `+3m`, `-3m` or `12m`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum NewHeight {
    /// By so much, metres.
    By(f64),
    /// From its lowest point to its highest one, metres.
    To(f64),
}

/// An object all of whose triangles get a material: `OBJECT=MATERIAL`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectMaterial {
    /// Its name.
    pub object: String,
    /// Name of the material.
    pub material: String,
}

/// What became of an object.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Fate {
    /// Its surfaces are where they were.
    #[default]
    Stands,
    /// It is gone.
    Removed,
    /// It is elsewhere, metres.
    Moved(DVec3),
    /// Its surfaces have other shapes.
    Reshaped,
}

/// A scene after some edits, in input coordinates.
#[derive(Clone, Debug)]
pub struct EditedScene {
    /// Triangles with their materials.
    pub triangles: Vec<([DVec3; 3], u16)>,
    /// The materials, not sorted.
    pub materials: Vec<Material>,
    /// The objects; one of each triangle.
    pub objects: Vec<SceneObject>,
    /// `[triangle]`: index into `objects`.
    pub of_triangle: Vec<u32>,
    /// `[object]`: what became of those that the scene had.
    pub fates: Vec<Fate>,
    /// Whether any triangle or material is another one.
    pub changed: bool,
}

/// The least that must stay of an object that is lowered, metres.
const LEAST_M: f64 = 0.1;

/// Faces that look up and begin lower than this over the foot of their object are no roofs, metres.
const FOOT_M: f64 = 1.0;

/// Faces whose normals rise less are walls.
const LOOKS_UP: f64 = 0.05;

/// Names that a message proposes.
const PROPOSED: usize = 3;

impl SceneEdits {
    /// Whether there is nothing to do.
    pub fn is_empty(&self) -> bool {
        self.remove.is_empty() && self.moves.is_empty() && self.heights.is_empty() && self.materials.is_empty()
    }

    /// Edits a scene; `described` are materials that objects may get besides its own, and `file` is what messages are about.
    pub fn apply(&self, scene: &TracedScene, described: &[Material], file: &Path) -> Result<EditedScene> {
        if scene.objects.list.is_empty() && !self.is_empty() {
            return Err(Error::input(
                file,
                None,
                "the archive names no objects, so none can be edited",
                "build it again from scene files: those of this release name them",
            ));
        }
        let names = Names::of(&scene.objects.list);
        let mut edited = EditedScene::of(scene);
        let mut seen: BTreeMap<u32, &str> = BTreeMap::new();
        for name in &self.remove {
            for object in names.find(name, "remove", file)? {
                edited.set_fate(object, Fate::Removed);
                seen.insert(object, name);
            }
        }
        let mut once: BTreeSet<(&str, u32)> = BTreeSet::new();
        let mut find = |name: &str, field: &'static str| -> Result<Vec<u32>> {
            let found = names.find(name, field, file)?;
            for object in &found {
                if let Some(removed) = seen.get(object) {
                    let what = format!("`{name}` is removed ({removed})");
                    return Err(Error::argument(field, what, "remove it, or edit it"));
                }
                if !once.insert((field, *object)) {
                    return Err(Error::argument(field, format!("`{name}` is given twice"), "say it once"));
                }
            }
            Ok(found)
        };
        for ObjectHeight { object: name, height } in &self.heights {
            let found = find(name, "height")?;
            edited.raise(name, &found, *height)?;
        }
        for ObjectMove { object: name, by_m } in &self.moves {
            let by = DVec3::from(*by_m);
            if !by.is_finite() {
                return Err(Error::argument("move", format!("`{name}` by {by}"), "give three numbers in metres"));
            }
            find(name, "move")?.into_iter().for_each(|object| edited.shift(object, by));
        }
        for ObjectMaterial { object: name, material } in &self.materials {
            let number = edited.material(material, described)?;
            find(name, "material")?.into_iter().for_each(|object| edited.paint(object, number));
        }
        edited.drop_removed();
        Ok(edited)
    }
}

impl EditedScene {
    /// A scene as it is held.
    pub fn of(scene: &TracedScene) -> Self {
        let absolute = |corners: &[DVec3; 3]| corners.map(|corner| scene.grid.origin + corner);
        let triangles = scene.triangles.iter().map(absolute).zip(scene.triangle_material.iter().copied()).collect();
        EditedScene {
            triangles,
            materials: scene.materials.clone(),
            objects: scene.objects.list.clone(),
            of_triangle: scene.objects.of_triangle.clone(),
            fates: vec![Fate::Stands; scene.objects.list.len()],
            changed: false,
        }
    }

    /// Adds a scene whose objects the scene does not have yet. Materials of one name that differ are told apart by `called`. Gives the new
    /// numbers of its materials.
    pub fn add(&mut self, scene: &Scene, called: &str, file: &Path) -> Result<Vec<u16>> {
        let own: BTreeSet<&str> = self.objects.iter().map(|object| object.name.as_str()).collect();
        let there = |object: &&SceneObject| own.contains(object.name.as_str()) && object.name != endless::NAME;
        if let Some(twice) = scene.objects.list.iter().find(there) {
            let what = format!("the scene has an object `{}` already", twice.name);
            return Err(Error::input(
                file,
                None,
                what,
                "give the object in the file another name, or remove the other one",
            ));
        }
        let materials: Vec<u16> =
            scene.materials.iter().map(|material| self.own_material(material, called)).collect::<Result<_>>()?;
        let first = self.objects.len() as u32;
        let origin = scene.mesh.origin;
        for (i, material) in scene.mesh.triangle_material.iter().enumerate() {
            let corners = scene.mesh.triangle_points(i).map(|corner| origin + corner);
            self.triangles.push((corners, materials.get(usize::from(*material)).copied().unwrap_or_default()));
        }
        self.of_triangle.extend(scene.objects.of_triangle.iter().map(|object| first + object));
        self.objects.extend(scene.objects.list.iter().cloned());
        self.changed = true;
        Ok(materials)
    }

    /// The scene of it, in the frame of the one before.
    pub fn scene(&self, before: &TracedScene) -> Result<Scene> {
        let objects = match self.objects.is_empty() {
            true => MeshObjects::default(),
            false => MeshObjects { list: self.objects.clone(), of_triangle: self.of_triangle.clone() },
        };
        Scene::from_objects(&self.triangles, self.materials.clone(), &objects, Some(before.grid.origin))
    }

    /// Triangles of an object.
    fn own(&mut self, object: u32) -> impl Iterator<Item = &mut ([DVec3; 3], u16)> {
        self.triangles.iter_mut().zip(&self.of_triangle).filter(move |(_, of)| **of == object).map(|pair| pair.0)
    }

    fn set_fate(&mut self, object: u32, fate: Fate) {
        self.changed = true;
        if let Some(place) = self.fates.get_mut(object as usize) {
            *place = fate;
        }
    }

    /// What became of an object.
    pub fn fate(&self, object: u32) -> Fate {
        self.fates.get(object as usize).copied().unwrap_or_default()
    }

    fn shift(&mut self, object: u32, by: DVec3) {
        if by == DVec3::ZERO {
            return;
        }
        self.own(object).flat_map(|(corners, _)| corners).for_each(|corner| *corner += by);
        if self.fate(object) != Fate::Reshaped {
            self.set_fate(object, Fate::Moved(by));
        }
    }

    /// Raises all above the lowest roof of some objects, which may be the parts of one building.
    fn raise(&mut self, name: &str, objects: &[u32], height: NewHeight) -> Result<()> {
        let refuse = |what: String, hint: &str| Err(Error::argument("height", format!("`{name}` {what}"), hint));
        let all: Vec<[DVec3; 3]> = objects
            .iter()
            .flat_map(|object| self.own(*object).map(|(corners, _)| *corners).collect::<Vec<_>>())
            .collect();
        let (low, high) = bounds(all.iter().flatten().copied());
        let by = match height {
            NewHeight::By(by) => by,
            NewHeight::To(to) => to - (high.z - low.z),
        };
        if !by.is_finite() || matches!(height, NewHeight::To(to) if to <= 0.0) {
            return refuse(format!("by {by} m"), "give metres, such as +3m, -3m or 12m");
        }
        let looks_up = |[a, b, c]: &&[DVec3; 3]| (*b - *a).cross(*c - *a).normalize_or_zero().z > LOOKS_UP;
        let lowest = |corners: &[DVec3; 3]| corners.iter().map(|corner| corner.z).fold(f64::INFINITY, f64::min);
        let roofs = all.iter().filter(looks_up).map(lowest).filter(|z| *z > low.z + FOOT_M);
        let from = roofs.fold(f64::INFINITY, f64::min);
        if !from.is_finite() {
            return refuse(
                "has no roof: no face that looks up, more than 1 m over its foot".to_owned(),
                "remove it with {remove} and add another one with {add}",
            );
        }
        if from + by < low.z + LEAST_M {
            let what =
                format!("would go down by {:.2} m, and its lowest roof is {:.2} m over its foot", -by, from - low.z);
            return refuse(what, "lower it less, or remove it with {remove}");
        }
        if by == 0.0 {
            return Ok(());
        }
        for object in objects {
            let above = |corner: &&mut DVec3| corner.z >= from;
            self.own(*object).flat_map(|(corners, _)| corners).filter(above).for_each(|corner| corner.z += by);
            self.set_fate(*object, Fate::Reshaped);
        }
        Ok(())
    }

    fn paint(&mut self, object: u32, number: u16) {
        let mut changed = false;
        for (_, material) in self.own(object) {
            changed |= *material != number;
            *material = number;
        }
        self.changed |= changed;
    }

    /// The number of a material by its name, one of the scene or one that is described.
    fn material(&mut self, name: &str, described: &[Material]) -> Result<u16> {
        let number = |materials: &[Material]| materials.iter().position(|material| material.name == name);
        match (number(&self.materials), described.iter().find(|material| material.name == name)) {
            (Some(number), _) => Ok(number as u16),
            (None, Some(material)) => self.push_material(material.clone()),
            (None, None) => {
                let known = self.materials.iter().chain(described).map(|material| material.name.as_str());
                let hint = format!("there are {}; {{materials}} may describe others", proposed(name, known));
                Err(Error::argument("material", format!("there is no material `{name}`"), hint))
            }
        }
    }

    /// The number of a material of a file that is added.
    fn own_material(&mut self, material: &Material, called: &str) -> Result<u16> {
        if let Some(number) = self.materials.iter().position(|own| own == material) {
            return Ok(number as u16);
        }
        let mut material = material.clone();
        let mut tries = 0;
        while self.materials.iter().any(|own| own.name == material.name) {
            tries += 1;
            let number = if tries > 1 { format!(" {tries}") } else { String::new() };
            let first = material.name.split(" (").next().unwrap_or_default();
            material.name = format!("{first} ({called}{number})");
        }
        self.push_material(material)
    }

    fn push_material(&mut self, material: Material) -> Result<u16> {
        let number = self.materials.len();
        self.materials.push(material);
        u16::try_from(number).map_err(|_| Error::Limit {
            what: "the number of materials in use".to_owned(),
            value: number as u64,
            max: u64::from(u16::MAX),
        })
    }

    /// Takes out the triangles of objects that are gone.
    fn drop_removed(&mut self) {
        let gone: Vec<bool> = self.of_triangle.iter().map(|of| self.fate(*of) == Fate::Removed).collect();
        let mut each = gone.iter();
        self.triangles.retain(|_| each.next() != Some(&true));
        let mut each = gone.iter();
        self.of_triangle.retain(|_| each.next() != Some(&true));
    }
}

/// Objects by the names that they can be called by.
struct Names<'a>(HashMap<&'a str, BTreeSet<u32>>);

impl<'a> Names<'a> {
    fn of(objects: &'a [SceneObject]) -> Self {
        let mut names: HashMap<&str, BTreeSet<u32>> = HashMap::new();
        for (number, SceneObject { name, note }) in (0..).zip(objects) {
            for name in [name, &note.object, &note.building].into_iter().filter(|name| !name.is_empty()) {
                names.entry(name).or_default().insert(number);
            }
        }
        Names(names)
    }

    fn find(&self, name: &str, field: &'static str, file: &Path) -> Result<Vec<u32>> {
        let name = name.trim();
        match self.0.get(name) {
            Some(found) => Ok(found.iter().copied().collect()),
            None => {
                let what = format!("{} has no object or building `{name}`", file.display());
                Err(Error::argument(field, what, format!("there are {}", proposed(name, self.0.keys().copied()))))
            }
        }
    }
}

/// The names most alike, quoted.
fn proposed<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> String {
    let lower = name.to_lowercase();
    let mut near: Vec<(usize, &str)> = known.map(|other| (apart(&lower, other), other)).collect();
    near.sort_unstable();
    near.dedup();
    let words: Vec<String> = near.iter().take(PROPOSED).map(|(_, name)| format!("`{name}`")).collect();
    match near.len() > PROPOSED {
        true => format!("{} and {}", words.join(", "), counted((near.len() - PROPOSED) as u64, "other")),
        false => words.join(", "),
    }
}

/// How different a name is; one that holds what was asked for is near.
fn apart(asked: &str, other: &str) -> usize {
    let other = other.to_lowercase();
    if !asked.is_empty() && other.contains(asked) { 1 } else { strsim::osa_distance(asked, &other) }
}

/// Name and value; a name may hold an equals sign.
fn halves(text: &str) -> std::result::Result<(String, &str), String> {
    match text.rsplit_once('=') {
        Some((name, value)) if !name.trim().is_empty() => Ok((name.trim().to_owned(), value.trim())),
        _ => Err(format!("`{text}` is no object, an equals sign and a value")),
    }
}

impl FromStr for ObjectMove {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let (object, value) = halves(text)?;
        let parts: Option<Vec<f64>> = value.split(',').map(|part| part.trim().parse().ok()).collect();
        match parts.as_deref() {
            Some(&[x, y, z]) if [x, y, z].iter().all(|part| part.is_finite()) => {
                Ok(ObjectMove { object, by_m: [x, y, z] })
            }
            _ => Err(format!("`{value}` is not three numbers in metres, such as 12,0,-1.5")),
        }
    }
}

impl FromStr for ObjectHeight {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let (object, value) = halves(text)?;
        Ok(ObjectHeight { object, height: value.parse()? })
    }
}

impl FromStr for NewHeight {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let number = text.strip_suffix('m').unwrap_or(text).trim();
        let is_change = number.starts_with(['+', '-']);
        match number.parse::<f64>() {
            Ok(metres) if metres.is_finite() && is_change => Ok(NewHeight::By(metres)),
            Ok(metres) if metres.is_finite() && metres > 0.0 => Ok(NewHeight::To(metres)),
            _ => Err(format!("`{text}` is no height, such as +3m, -3m or 12m")),
        }
    }
}

impl TryFrom<String> for NewHeight {
    type Error = String;

    fn try_from(text: String) -> std::result::Result<Self, String> {
        text.parse()
    }
}

impl From<NewHeight> for String {
    fn from(height: NewHeight) -> String {
        height.to_string()
    }
}

impl FromStr for ObjectMaterial {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let (object, value) = halves(text)?;
        match value.is_empty() {
            true => Err(format!("`{text}` names no material")),
            false => Ok(ObjectMaterial { object, material: value.to_owned() }),
        }
    }
}

impl fmt::Display for NewHeight {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            NewHeight::By(metres) => write!(f, "{metres:+}m"),
            NewHeight::To(metres) => write!(f, "{metres}m"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::semantics::ObjectNote;
    use heliotile_core::site::material::Class;

    /// A flat box of 4 m x 4 m from z to z + h, its walls and its roof.
    fn block(x: f64, z: f64, h: f64) -> Vec<([DVec3; 3], u16)> {
        let at = |i: usize, z: f64| {
            let (dx, dy) = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)][i % 4];
            DVec3::new(x + dx, dy, z)
        };
        let quad = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| [[a, b, c], [a, c, d]];
        let walls = (0..4).flat_map(|i| quad(at(i, z), at(i + 1, z), at(i + 1, z + h), at(i, z + h)));
        let roof = quad(at(0, z + h), at(1, z + h), at(2, z + h), at(3, z + h));
        walls.chain(roof).map(|corners| (corners, 0)).collect()
    }

    /// A house of two parts, 6 m high with an annex of 3 m, and a shed of 2.5 m.
    fn town() -> TracedScene {
        let parts = [block(0.0, 0.0, 6.0), block(4.0, 0.0, 3.0), block(20.0, 1.0, 2.5)];
        let names = [("house-1", "house"), ("house-2", "house"), ("shed", "")];
        let named = |(name, building): (&str, &str)| SceneObject {
            name: name.to_owned(),
            note: ObjectNote { building: building.to_owned(), ..ObjectNote::default() },
        };
        let of_triangle: Vec<u32> = (0..).zip(&parts).flat_map(|(i, part)| vec![i; part.len()]).collect();
        let objects = MeshObjects { list: names.map(named).to_vec(), of_triangle };
        let materials = vec![Material::matt("wall", 0.4, Class::Obstruction)];
        let scene = Scene::from_objects(&parts.concat(), materials, &objects, None).expect("a scene");
        let points = (0..scene.mesh.triangles.len()).map(|triangle| scene.mesh.triangle_points(triangle));
        TracedScene {
            grid: scene.mesh.grid(),
            triangles: points.collect(),
            triangle_material: scene.mesh.triangle_material.clone(),
            materials: scene.materials,
            objects: scene.objects,
        }
    }

    fn edited(edits: SceneEdits) -> EditedScene {
        edits.apply(&town(), &[], Path::new("town.helio")).expect("an edited scene")
    }

    /// Lowest and highest point of an object.
    fn heights(scene: &EditedScene, name: &str) -> (f64, f64) {
        let own =
            scene.triangles.iter().zip(&scene.of_triangle).filter(|(_, of)| scene.objects[**of as usize].name == name);
        let (low, high) = bounds(own.flat_map(|((corners, _), _)| corners).copied());
        (low.z, high.z)
    }

    /// A building is removed with both its parts, 20 triangles of 30; a part with its own 10.
    #[test]
    fn objects_go_by_their_name_or_that_of_their_building() {
        for (name, left) in [("house", 10), ("house-2", 20), (" shed ", 20)] {
            let scene = edited(SceneEdits { remove: vec![name.to_owned()], ..SceneEdits::default() });
            assert_eq!((scene.triangles.len(), scene.of_triangle.len()), (left, left), "{name}");
            assert!(scene.changed);
        }
    }

    /// A storey on a house lifts both roofs, 6 to 9 m and 3 to 6 m, and leaves the foot; a height of 2 m lowers the shed, which stands 1 m
    /// high, to 3 m. What is moved keeps its height.
    #[test]
    fn roofs_go_up_and_down() {
        let heights_of = |text: &str| SceneEdits { heights: vec![text.parse().expect(text)], ..SceneEdits::default() };
        let up = edited(heights_of("house=+3m"));
        assert_eq!([heights(&up, "house-1"), heights(&up, "house-2")], [(0.0, 9.0), (0.0, 6.0)]);
        assert_eq!(up.fates, [Fate::Reshaped, Fate::Reshaped, Fate::Stands]);
        assert_eq!(heights(&edited(heights_of("shed=2m")), "shed"), (1.0, 3.0));
        let moves = vec!["shed=1,-2,0.5".parse().expect("a move")];
        let moved = edited(SceneEdits { moves, ..SceneEdits::default() });
        assert_eq!((heights(&moved, "shed"), moved.fates[2]), ((1.5, 4.0), Fate::Moved(DVec3::new(1.0, -2.0, 0.5))));
    }

    /// 4 heights come back from their text; 4 texts are none.
    #[test]
    fn heights_are_text() {
        for text in ["+3m", "-2.5m", "12m", "0.5m"] {
            let height: NewHeight = text.parse().expect(text);
            assert_eq!(serde_json::to_string(&height).expect("JSON"), format!("\"{text}\""));
        }
        for text in ["", "m", "tall", "0m"] {
            assert!(text.parse::<NewHeight>().is_err(), "{text}");
        }
    }

    /// A file whose `wall` differs brings it as `wall (tower)`; an equal one is the scene's own.
    #[test]
    fn materials_are_told_apart() {
        let objects = MeshObjects {
            list: vec![SceneObject { name: "tower".to_owned(), note: ObjectNote::default() }],
            of_triangle: vec![0; 10],
        };
        for (diffuse, names) in [(0.4, vec!["wall"]), (0.7, vec!["wall", "wall (tower)"])] {
            let materials = vec![Material::matt("wall", diffuse, Class::Obstruction)];
            let tower = Scene::from_objects(&block(9.0, 0.0, 30.0), materials, &objects, None).expect("a scene");
            let mut scene = edited(SceneEdits::default());
            scene.add(&tower, "tower", Path::new("tower.obj")).expect("an object");
            assert_eq!(scene.materials.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), names);
            assert!(scene.add(&tower, "tower", Path::new("tower.obj")).is_err());
        }
    }
}
