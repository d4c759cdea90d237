//! Edits of a scene by the names of its objects. In: a scene as an archive holds it, and edits.
//! Out: triangles with materials and objects, and the fate of each object.

mod edited;
mod names;

heliotile_requests::parse_by_text!(ObjectMove: Form::TEXT, ObjectHeight: Form::TEXT, ObjectMaterial: Form::TEXT);

heliotile_core::serde_by_text!(NewHeight);

#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::Path;
use std::str::FromStr;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::change::TracedScene;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::site::material::Material;
use heliotile_requests::{Form, Request};
use names::ObjectNames;

pub use edited::{EditedScene, Fate};

/// Edits of objects. A name is that of an object, or of the building that objects are parts of.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, Request)]
#[serde(default, deny_unknown_fields)]
pub struct SceneEdits {
    /// Remove an object or a building; may be repeated, as --move, --height and --material may.
    #[field(metavar = "OBJECT")]
    pub remove: Vec<String>,
    /// Move an object by these metres along x, y and z; its receivers go with it.
    #[field(name = "move", metavar = "OBJECT=DX,DY,DZ")]
    pub moves: Vec<ObjectMove>,
    /// Raise or lower the roofs of an object, and its walls with them: by +3m or -3m, or to a
    /// height of 12m over its lowest point.
    #[field(name = "height", metavar = "OBJECT=HEIGHT")]
    pub heights: Vec<ObjectHeight>,
    /// Give all surfaces of an object a material of the scene or of --materials.
    #[field(name = "material", metavar = "OBJECT=MATERIAL")]
    pub materials: Vec<ObjectMaterial>,
}

/// Move of an object: `OBJECT=dx,dy,dz`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectMove {
    /// Name of the object.
    pub object: String,
    /// Translation along x, y and z, metres.
    pub by_m: [f64; 3],
}

/// Change of an object's height, roofs and walls together: `OBJECT=+3m`, `OBJECT=-3m` or
/// `OBJECT=12m`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectHeight {
    /// Name of the object.
    pub object: String,
    /// New height.
    pub height: NewHeight,
}

/// New height of an object; as text `+3m`, `-3m` or `12m`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NewHeight {
    /// Change of the height, metres.
    By(f64),
    /// Height from the lowest point to the highest one, metres.
    To(f64),
}

/// New material of all triangles of an object: `OBJECT=MATERIAL`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectMaterial {
    /// Name of the object.
    pub object: String,
    /// Name of the material.
    pub material: String,
}

impl SceneEdits {
    /// Returns true if there is nothing to edit.
    pub fn is_empty(&self) -> bool {
        self.remove.is_empty() && self.moves.is_empty() && self.heights.is_empty() && self.materials.is_empty()
    }

    /// Edits a scene. `described` are materials that objects may get besides the scene's own;
    /// messages name `file`.
    pub fn apply(&self, scene: &TracedScene, described: &[Material], file: &Path) -> Result<EditedScene> {
        if scene.objects.list.is_empty() && !self.is_empty() {
            return Err(Error::input(
                file,
                None,
                "the archive names no objects, so none can be edited",
                "build it again from scene files: archives of this release name their objects",
            ));
        }
        let names = ObjectNames::new(&scene.objects.list);
        let mut edited = EditedScene::new(scene);
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
                    let what = format!("`{name}` is to be removed, too ({removed})");
                    return Err(Error::argument(field, what, "either remove it or edit it")
                        .because(Problem::excludes("remove")));
                }
                if !once.insert((field, *object)) {
                    return Err(Error::argument(field, format!("`{name}` is given twice"), "give it once")
                        .because(Problem::duplicate(name)));
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

/// Splits a text at its last equals sign into name and value; a name may hold an equals sign.
fn halves(text: &str) -> std::result::Result<(String, &str), String> {
    match text.rsplit_once('=') {
        Some((name, value)) if !name.trim().is_empty() => Ok((name.trim().to_owned(), value.trim())),
        _ => Err(format!("`{text}` is not an object, an equals sign and a value")),
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
            _ => Err(format!("`{text}` is not a height, such as +3m, -3m or 12m")),
        }
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
