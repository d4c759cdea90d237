//! Materials of several files under names of one scene. In: the names that each file uses, the
//! file's description of them, and the table that takes precedence. Out: one list of names. Where
//! two files describe one name differently, the file's name is added to the later one's.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::path::{Path, PathBuf};

use crate::LoadReport;
use crate::formats::stem;
use crate::geometry::Geometry;
use crate::ground::endless;
use crate::ground::endless::EndlessGround;
use crate::materials::assumed::assumed;
use crate::materials::select::{MaterialTable, class_of_name, nearest, select};
use crate::materials::toml_file::read_toml;
use crate::site::Part;
use crate::text::excerpt;
use heliotile_core::error::{Error, Result};
use heliotile_core::site::material::{Class, Material};
use heliotile_core::text::{Message, message, with_list};

/// Most unused names of a table that are compared with names of the scene, and most names of the
/// scene: malformed or hostile files hold tens of thousands.
const MAX_UNUSED: usize = 20;
const MAX_COMPARED: usize = 5000;

#[derive(Default)]
pub(crate) struct Palette {
    entries: Vec<Entry>,
    /// Entries by name in the scene and by name in their files: maps, because hostile files hold
    /// tens of thousands of names.
    by_name: HashMap<String, usize>,
    by_local: HashMap<String, Vec<usize>>,
    /// `materials.toml` files that were read, each once.
    tables: BTreeMap<PathBuf, MaterialTable>,
    ground: Option<(PathBuf, EndlessGround)>,
}

/// Files that may describe a material.
#[derive(Clone, Copy)]
struct Source<'a> {
    file: &'a Path,
    materials: Option<&'a Path>,
    /// True if the file's own descriptions do not count.
    only: bool,
}

struct Entry {
    /// Name in the scene.
    name: String,
    /// File that describes the material, or ought to.
    source: PathBuf,
    /// Material; `None` if `source` does not describe it.
    material: Option<Material>,
    /// True if no file describes the material, so that its optics are assumed.
    assumed: bool,
}

impl Palette {
    /// Reads a `materials.toml` unless it was read before.
    pub(crate) fn open(&mut self, path: &Path) -> Result<()> {
        if self.tables.contains_key(path) {
            return Ok(());
        }
        let (table, ground) = read_toml(path)?;
        if let Some(ground) = ground {
            if let Some((other, _)) = &self.ground {
                let what = format!("describes the endless ground, as {} does", other.display());
                return Err(Error::input(path, None, what, "a scene has one: leave one of the two tables out"));
            }
            self.ground = Some((path.to_owned(), ground));
        }
        self.tables.insert(path.to_owned(), table);
        Ok(())
    }

    /// Returns the names that a `materials.toml`, which was opened, describes.
    pub(crate) fn described(&self, materials: Option<&Path>) -> BTreeSet<String> {
        let table = materials.and_then(|path| self.tables.get(path));
        table.into_iter().flatten().map(|(name, _)| name.clone()).collect()
    }

    /// Adds the materials of a file and returns the scene's number of each. Each material is
    /// described by the file's `materials.toml`, which was opened, or else by the file itself.
    pub(crate) fn add(&mut self, part: &Part, geometry: &Geometry) -> Vec<u32> {
        let names = geometry.materials.as_slice();
        let of = Source { file: &part.file, materials: part.materials.as_deref(), only: part.materials_only };
        let add = |name: &String| self.add_one(name, &of, &geometry.stated, geometry.assumed.contains(name));
        names.iter().map(add).collect()
    }

    /// Adds one material. `is_assumed` says that what the file states is an assumption.
    fn add_one(&mut self, local: &str, of: &Source, stated: &MaterialTable, is_assumed: bool) -> u32 {
        let Source { file, materials, only } = *of;
        let table = materials.and_then(|path| Some((path, self.tables.get(path)?.get(local)?)));
        let (source, described) = match (table, materials) {
            (Some((path, material)), _) => (path, Some(material)),
            (None, Some(path)) if only => (path, None),
            _ => (file, stated.get(local)),
        };
        let assumes = described.is_none() && !(only && materials.is_some());
        let material = described.cloned().or_else(|| assumes.then(|| assumed(local)));
        let assumed = assumes || is_assumed && table.is_none() && material.is_some();
        let alike = self.by_local.entry(local.to_owned()).or_default();
        let same = |i: &&usize| self.entries.get(**i).is_some_and(|entry| entry.material == material);
        if let Some(known) = alike.iter().find(same) {
            return *known as u32;
        }
        let mut name = local.to_owned();
        let mut behind = format!(" ({})", stem(file));
        while self.by_name.contains_key(&name) {
            name = format!("{local}{behind}");
            behind.push('\'');
        }
        let number = self.entries.len();
        alike.push(number);
        self.by_name.insert(name.clone(), number);
        self.entries.push(Entry { name, source: source.to_owned(), material, assumed });
        number as u32
    }

    /// Returns the endless ground and the number of its material, if a table describes it.
    pub(crate) fn ground(&mut self) -> Option<(EndlessGround, u32)> {
        let (path, ground) = self.ground.clone()?;
        let of = Source { file: &path, materials: Some(&path), only: true };
        Some((ground, self.add_one(endless::NAME, &of, &MaterialTable::new(), false)))
    }

    /// Adds the material of a plane that no table describes; returns its number and its name in the
    /// scene.
    pub(crate) fn add_ground(&mut self, file: &Path, diffuse: f64) -> (u32, String) {
        let material = Material::matt(endless::NAME, diffuse, Class::Ground);
        let stated = MaterialTable::from([(endless::NAME.to_owned(), material)]);
        let number = self.add_one(endless::NAME, &Source { file, materials: None, only: false }, &stated, false);
        (number, self.entries.get(number as usize).map(|entry| entry.name.clone()).unwrap_or_default())
    }

    /// Returns the first-hit class of a material, and true if light goes through it.
    pub(crate) fn class(&self, number: u32) -> (Class, bool) {
        let entry = self.entries.get(number as usize);
        match entry.map(|entry| (&entry.material, &entry.name)) {
            Some((Some(material), _)) => (material.class, material.transmittance.is_some()),
            Some((None, name)) => (class_of_name(name), false),
            None => (Class::Obstruction, false),
        }
    }

    /// Returns the names in the scene, by number.
    pub(crate) fn names(&self) -> Vec<String> {
        self.entries.iter().map(|entry| entry.name.clone()).collect()
    }

    /// Returns the materials in use, in that order. Adds warnings on assumed materials and on
    /// descriptions that no material uses.
    pub(crate) fn select(&self, report: &mut LoadReport) -> Result<Vec<Material>> {
        let LoadReport { materials: used, warnings, .. } = report;
        let entry_of = |name: &str| self.by_name.get(name).and_then(|i| self.entries.get(*i));
        let described = self.entries.iter().filter_map(|entry| {
            let material = entry.material.clone()?;
            Some((entry.name.clone(), Material { name: entry.name.clone(), ..material }))
        });
        let missing = used.iter().filter_map(|entry| entry_of(&entry.name)).find(|entry| entry.material.is_none());
        let source = missing.or(self.entries.first()).map_or(Path::new(""), |entry| &entry.source);
        let known: MaterialTable = described.collect();
        // A misspelt name can only stand in the file's own table.
        let near = missing.and_then(|entry| self.tables.get(&entry.source)).cloned().unwrap_or_default();
        let (materials, _) = select(near.into_iter().chain(known).collect(), used, source)?;

        let assumed_entries = || used.iter().filter_map(|entry| entry_of(&entry.name).filter(|entry| entry.assumed));
        report.assumed = assumed_entries().map(|entry| entry.name.clone()).collect();
        let assumed: Vec<String> = assumed_entries()
            .filter_map(|entry| {
                Some(format!("`{}` {}", excerpt(entry.name.as_bytes()), entry.material.as_ref()?.optics()))
            })
            .collect();
        warnings.extend(assumed_warning(assumed));
        let names: HashSet<&str> = used.iter().map(|entry| entry.name.as_str()).collect();
        for (path, table) in &self.tables {
            let is_used = |name: &str| {
                let entries = self.by_local.get(name).into_iter().flatten().filter_map(|i| self.entries.get(*i));
                entries.filter(|entry| entry.source == *path).any(|entry| names.contains(entry.name.as_str()))
            };
            // Names that a misspelt one may stand for: those that this table does not describe.
            let mut others: Vec<&str> = self
                .by_local
                .iter()
                .filter(|(name, _)| !table.contains_key(*name))
                .map(|(name, _)| name.as_str())
                .take(MAX_COMPARED)
                .collect();
            others.sort_unstable();
            let unused = table.keys().filter(|name| !is_used(name)).enumerate();
            let unused = unused.map(|(i, name)| {
                let near = if i < MAX_UNUSED { nearest(name, &others) } else { None };
                let near =
                    near.map_or(String::new(), |near| format!(" (did you mean `{}`?)", excerpt(near.as_bytes())));
                format!("`{}`{near}", excerpt(name.as_bytes()))
            });
            warnings.extend(unused_warning(path, unused.collect()));
        }
        Ok(materials)
    }
}

/// Most names that stand in the warning itself; more become a list.
const MAX_NAMED: usize = 4;

fn assumed_warning(assumed: Vec<String>) -> Option<Message> {
    let (start, end) = ("no file states how much light", Message::from("state it in a materials.toml ({materials})"));
    match assumed.len() {
        0 => None,
        1..=MAX_NAMED => Some(message!("{start} these materials reflect; assumed: {}; ", assumed.join(", ")).and(end)),
        count => {
            let sentence = message!("{start} {count} materials reflect; usual values are assumed; ").and(end);
            Some(with_list(sentence, assumed))
        }
    }
}

fn unused_warning(path: &Path, unused: Vec<String>) -> Option<Message> {
    let of = path.display();
    match unused.len() {
        0 => None,
        1 => Some(message!("{of}: the scene does not use material {}", unused.concat())),
        2..=MAX_NAMED => Some(message!("{of}: the scene does not use materials {}", unused.join(", "))),
        count => Some(with_list(format!("{of}: the scene does not use {count} of its materials"), unused)),
    }
}
