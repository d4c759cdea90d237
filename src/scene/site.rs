//! What a scene is made of. In: files on the command line, or a `site.toml` that lists them. Out: one part for each, with its
//! materials and its place.

use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::Deserialize;

use crate::coordinate::is_position;
use crate::input;
use crate::text::line_of_offset;
use heliotile_core::error::{Error, Result};

/// Files that make up one scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Site {
    /// Each file, in the order in which it was named.
    pub parts: Vec<Part>,
    /// What is done where none of them has ground.
    pub missing_ground: MissingGround,
}

/// What lies below the horizon of a scene whose files have no ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MissingGround {
    /// Nothing.
    #[default]
    LeaveOut,
    /// A plane: that of an EnergyPlus model as the model says, below all else one that reflects 0.2.
    Assume,
}

/// One file of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The file; its ending says its format.
    pub file: PathBuf,
    /// Its `materials.toml`, which wins over what the file itself says.
    pub materials: Option<PathBuf>,
    /// Whether `materials` describes all of its materials, whatever the file itself says.
    pub materials_only: bool,
    /// Added to every position after `scale` and `y_up`, metres.
    pub offset: DVec3,
    /// Metres a unit of the file.
    pub scale: f64,
    /// Whether y points up and z south in the file, in place of z up and y north.
    pub y_up: bool,
    /// Level of detail where an object carries several; the finest without it.
    pub lod: Option<String>,
    /// Largest angle by which a raster beside other geometry may misplace the horizon, degrees; 0 keeps every sample. Without it
    /// 0.2 beside other geometry, and every sample where rasters are the whole scene.
    pub horizon_deg: Option<f64>,
}

impl Part {
    /// A file in metres, where it says that it lies.
    pub fn plain(file: &Path, materials: Option<&Path>) -> Part {
        Part {
            file: file.to_owned(),
            materials: materials.map(Path::to_owned),
            materials_only: false,
            offset: DVec3::ZERO,
            scale: 1.0,
            y_up: false,
            lod: None,
            horizon_deg: None,
        }
    }

    /// Where a position of the file lies in the scene.
    pub(super) fn place(&self, p: DVec3) -> DVec3 {
        let p = p * self.scale;
        let p = if self.y_up { DVec3::new(p.x, -p.z, p.y) } else { p };
        p + self.offset + 0.0
    }
}

/// `site.toml` as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    scene: Vec<Entry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    file: PathBuf,
    materials: Option<PathBuf>,
    #[serde(default)]
    materials_only: bool,
    offset: Option<[f64; 3]>,
    scale: Option<f64>,
    up: Option<Up>,
    lod: Option<String>,
    horizon_deg: Option<f64>,
}

#[derive(Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Up {
    Y,
    Z,
}

const KEYS: &str = "write a table [[scene]] for each file: file = \"town.city.json\" and optionally materials = \"town.toml\", \
                    materials_only = true, offset = [x, y, z] in metres, scale = 0.001 (metres a unit), up = \"y\", lod = \"2.2\", and for terrain horizon_deg = 0.2";

impl Site {
    /// Scene files and `site.toml` files in any mixture; `materials` is for those that name none of their own. A folder stands for the
    /// `site.toml` in it.
    pub fn of(files: &[PathBuf], materials: Option<&Path>) -> Result<Site> {
        let mut site = Site::default();
        for file in files {
            let listed = if file.is_dir() { listed_in(file)? } else { file.clone() };
            if input::ending(&listed) == "toml" {
                site.parts.extend(read_parts(&listed, materials)?);
            } else {
                site.parts.push(Part::plain(file, materials));
            }
        }
        Ok(site)
    }

    /// All files that the site is read from, besides `site.toml`.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.parts.iter().flat_map(|part| [Some(part.file.as_path()), part.materials.as_deref()]).flatten()
    }
}

/// The `site.toml` of a folder.
fn listed_in(folder: &Path) -> Result<PathBuf> {
    let listed = input::plain_or_packed(folder.join("site.toml"));
    if listed.is_file() {
        return Ok(listed);
    }
    let hint = "name the scene files in it, or list them in a site.toml there";
    Err(Error::input(folder, None, "is a folder without a site.toml", hint))
}

fn read_parts(path: &Path, materials: Option<&Path>) -> Result<Vec<Part>> {
    let bytes = input::read(path)?;
    let text = String::from_utf8_lossy(&bytes);
    let document: Document = toml::from_str(&text).map_err(|error| {
        let line = error.span().map(|span| line_of_offset(text.as_bytes(), span.start));
        Error::input(path, line, error.message(), KEYS)
    })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let refuse = |entry: &Entry, what: String| {
        Err(Error::input(path, None, format!("the scene {}: {what}", entry.file.display()), KEYS))
    };
    let mut parts = Vec::new();
    for entry in &document.scene {
        let (offset, scale) = (DVec3::from(entry.offset.unwrap_or_default()), entry.scale.unwrap_or(1.0));
        if !is_position(offset) {
            return refuse(entry, format!("`offset` is {offset}"));
        }
        // NaN compares false.
        if !(1e-6..=1e6).contains(&scale) {
            return refuse(entry, format!("`scale` is {scale}, not from 1e-6 to 1e6"));
        }
        if let Some(angle) = entry.horizon_deg.filter(|angle| !(0.0..=10.0).contains(angle)) {
            return refuse(entry, format!("`horizon_deg` is {angle}, not from 0 to 10"));
        }
        parts.push(Part {
            file: folder.join(&entry.file),
            materials: entry.materials.as_ref().map(|own| folder.join(own)).or(materials.map(Path::to_owned)),
            materials_only: entry.materials_only,
            offset,
            scale,
            y_up: entry.up == Some(Up::Y),
            lod: entry.lod.clone(),
            horizon_deg: entry.horizon_deg,
        });
    }
    if parts.is_empty() {
        return Err(Error::input(path, None, "lists no scene", KEYS));
    }
    Ok(parts)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::Scene;

    const SQUARE: &str = "v 0 0 0\nv 2 0 0\nv 2 0 -2\nv 0 0 -2\nusemtl wall\nf 1 2 3 4\n";

    fn site(toml: &str) -> (tempfile::TempDir, Result<Site>) {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("written");
        write("a.obj", SQUARE);
        write("b.obj", SQUARE);
        write("a.toml", "[wall]\ndiffuse = 0.5\n");
        write("b.toml", "[wall]\ndiffuse = 0.1\n");
        write("site.toml", toml);
        let site = Site::of(&[folder.path().to_owned()], None);
        (folder, site)
    }

    /// Two files with one material name and two tables keep 0.5 and 0.1; offset, scale and axis put the second where it belongs.
    #[test]
    fn merges() {
        let (_folder, site) = site(
            "[[scene]]\nfile = \"a.obj\"\nmaterials = \"a.toml\"\n[[scene]]\nfile = \"b.obj\"\nmaterials = \"b.toml\"\n\
             offset = [10, 20, 30]\nscale = 0.5\nup = \"y\"\n",
        );
        let scene = Scene::load_site(&site.expect("readable")).expect("a scene");
        let found: Vec<(&str, f64)> = scene.materials.iter().map(|m| (m.name.as_str(), m.diffuse)).collect();
        assert_eq!(found, [("wall", 0.5), ("wall (b)", 0.1)]);
        let (low, high) = scene.mesh.bounds();
        // y up: z = -2 becomes y = 1 at half the size; the first one hangs below z = 0.
        assert_eq!(
            (low + scene.mesh.origin, high + scene.mesh.origin),
            (DVec3::new(0., 0., -2.), DVec3::new(11., 21., 30.))
        );
        assert_eq!((scene.mesh.triangles.len(), scene.report.warnings.len()), (4, 0));
    }

    /// One file twice under one table is one material, and the order of the parts does not change the hash of two scenes.
    #[test]
    fn order_of_parts() {
        let parts = [
            "[[scene]]\nfile = \"a.obj\"\nmaterials = \"a.toml\"\n",
            "[[scene]]\nfile = \"b.obj\"\nmaterials = \"a.toml\"\noffset = [5, 0, 0]\n",
        ];
        let hash = |order: [usize; 2]| {
            let (_folder, site) = site(&format!("{}{}", parts[order[0]], parts[order[1]]));
            let scene = Scene::load_site(&site.expect("readable")).expect("a scene");
            (scene.materials.len(), scene.content_hash())
        };
        assert_eq!(hash([0, 1]), hash([1, 0]));
        assert_eq!(hash([0, 1]).0, 1);
    }

    /// Seven wrong site files are refused by name, with a line where there is one.
    #[test]
    fn refusals() {
        for (toml, quoted) in [
            ("", "missing field `scene`"),
            ("scene = []", "lists no scene"),
            ("[[scene]]\nfle = \"a.obj\"\n", "line 2"),
            ("[[scene]]\nfile = \"a.obj\"\nscale = 0\n", "`scale` is 0"),
            ("[[scene]]\nfile = \"a.obj\"\nscale = nan\n", "`scale` is NaN"),
            ("[[scene]]\nfile = \"a.obj\"\noffset = [0, inf, 0]\n", "`offset` is"),
            ("[[scene]]\nfile = \"a.obj\"\nup = \"x\"\n", "line 3"),
        ] {
            let message = site(toml).1.expect_err(toml).to_string();
            assert!(message.contains("site.toml") && message.contains(quoted), "{toml:?}: {message}");
        }
    }
}
