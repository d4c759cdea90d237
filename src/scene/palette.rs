//! Materials of several files under names of one scene. In: the names that each file uses and the table that describes them. Out:
//! one list of names; where two files mean different things by one name, the later one's gets the file's name behind it.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};

use crate::LoadReport;
use crate::endless_ground;
use crate::endless_ground::EndlessGround;
use crate::formats::stem;
use crate::geometry::Geometry;
use crate::materials::assumed::assumed;
use crate::materials::select::{MaterialTable, select};
use crate::materials::toml_file::read_toml;
use crate::text::excerpt;
use heliotile_core::error::{Error, Result};
use heliotile_core::site::material::Material;
use heliotile_core::text::with_list;

#[derive(Default)]
pub(crate) struct Palette {
    entries: Vec<Entry>,
    /// Entries by name in the scene, and by name in their files: hostile files hold tens of thousands.
    by_name: HashMap<String, usize>,
    by_local: HashMap<String, Vec<usize>>,
    /// `materials.toml` files that were read, once each.
    tables: BTreeMap<PathBuf, MaterialTable>,
    ground: Option<(PathBuf, EndlessGround)>,
}

struct Entry {
    /// In the scene.
    name: String,
    /// The file that describes it, or ought to.
    source: PathBuf,
    /// `None` if `source` does not.
    material: Option<Material>,
    /// Nobody describes it.
    assumed: bool,
}

impl Palette {
    /// Reads a `materials.toml` if it was not read before.
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

    /// Adds the materials of a file, described by a `materials.toml` that was opened or, without one, by the file itself. Gives the
    /// scene's number of each.
    pub(crate) fn add(&mut self, file: &Path, geometry: &Geometry, materials: Option<&Path>) -> Vec<u32> {
        let names = geometry.materials.as_slice();
        names.iter().map(|name| self.add_one(name, file, &geometry.stated, materials)).collect()
    }

    fn add_one(&mut self, local: &str, file: &Path, stated: &MaterialTable, materials: Option<&Path>) -> u32 {
        let source = materials.unwrap_or(file);
        let described = match materials {
            Some(path) => self.tables.get(path).and_then(|table| table.get(local)),
            None => stated.get(local),
        };
        let assumes = described.is_none() && materials.is_none();
        let material = described.cloned().or_else(|| assumes.then(|| assumed(local)));
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
        self.entries.push(Entry { name, source: source.to_owned(), material, assumed: assumes });
        number as u32
    }

    /// The endless ground, if a table describes it, and the number of its material.
    pub(crate) fn ground(&mut self) -> Option<(EndlessGround, u32)> {
        let (path, ground) = self.ground.clone()?;
        let none = MaterialTable::new();
        Some((ground, self.add_one(endless_ground::NAME, &path, &none, Some(&path))))
    }

    /// Names in the scene, by number.
    pub(crate) fn names(&self) -> Vec<String> {
        self.entries.iter().map(|entry| entry.name.clone()).collect()
    }

    /// The materials in use, in that order, and warnings: what is assumed of which, and what is described for nothing.
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
        // What was misspelt stands in the file's table.
        let near = missing.and_then(|entry| self.tables.get(&entry.source)).cloned().unwrap_or_default();
        let (materials, _) = select(near.into_iter().chain(known).collect(), used, source)?;

        let nobody = || used.iter().filter_map(|entry| entry_of(&entry.name).filter(|entry| entry.assumed));
        report.assumed = nobody().map(|entry| entry.name.clone()).collect();
        let assumed: Vec<String> = nobody()
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
            let unused = table.keys().filter(|name| !is_used(name)).map(|name| excerpt(name.as_bytes()));
            warnings.extend(unused_warning(path, unused.collect()));
        }
        Ok(materials)
    }
}

/// So many names stand in a warning itself.
const MOST_NAMED: usize = 4;

fn assumed_warning(assumed: Vec<String>) -> Option<String> {
    let (start, end) = ("nobody says how much light", "--materials materials.toml says it");
    match assumed.len() {
        0 => None,
        1..=MOST_NAMED => Some(format!("{start} these materials reflect, assumed is: {}; {end}", assumed.join(", "))),
        count => {
            let sentence = format!("{start} {count} materials reflect, assumed is what is usual; {end}");
            Some(with_list(&sentence, assumed))
        }
    }
}

fn unused_warning(path: &Path, unused: Vec<String>) -> Option<String> {
    let of = path.display();
    match unused.len() {
        0 => None,
        1 => Some(format!("{of}: the scene does not use material `{}`", unused.concat())),
        2..=MOST_NAMED => Some(format!("{of}: the scene does not use materials `{}`", unused.join("`, `"))),
        count => Some(with_list(&format!("{of}: the scene does not use {count} of its materials"), unused)),
    }
}
