//! Rows of modules in a scene. In: `rows.toml`, the scene without them. Out: the position of each
//! module, and the modules as a file of the scene, so that they shade and light one another.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};

use super::open_plain::HALF_M;
use heliotile_builder::siting::Siting;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::observer::Observer;
use heliotile_core::site::north::North;
use heliotile_core::text::{counted, message};
use heliotile_results::outputs::sink::write_texts;
use heliotile_scene::covering::surfaces::Surfaces;
use heliotile_scene::pv::layout::{Laid, Module, Outline, lay};
use heliotile_scene::pv::overlap::crossing;
use heliotile_scene::pv::rows::{MAX_MODULES, RowsGround, RowsOfModules, surface_named};
use heliotile_scene::site::{Part, SceneFiles};

/// Names of the files of modules.
pub const GEOMETRY: &str = "modules.obj";
pub const MATERIALS: &str = "modules.toml";
/// Name of the file of the ground below rows without a scene.
pub const PLAIN: &str = "plain.obj";

/// Largest number of positions that are tried for rows: those of some 10 km2.
const MAX_PLACES: f64 = 1e9;

/// Returns an open plain around rows as OBJ, for rows without a scene. Fails for rows that stand on
/// something else.
pub fn plain_below(file: &Path, rows: &[RowsOfModules]) -> Result<String> {
    let mut middle = DVec2::ZERO;
    for of in rows {
        let RowsGround::Counted { middle: at, .. } = of.ground else {
            let what = format!("the rows `{}` stand on an area or a surface, but no scene is given", of.name);
            let hint = "give a scene, or `rows = 5` and `modules = 10`, which stand on an open plain";
            return Err(Error::input(file, None, what, hint));
        };
        middle += at / rows.len() as f64;
    }
    let corners = [(-HALF_M, -HALF_M), (HALF_M, -HALF_M), (HALF_M, HALF_M), (-HALF_M, HALF_M)];
    let vertices = corners.map(|(x, y)| format!("v {} {} 0\n", middle.x + x, middle.y + y));
    Ok(format!("o plain\n{}usemtl ground\nf 1 2 3 4\n", vertices.concat()))
}

/// Rows with their modules.
pub struct LaidRows {
    fields: Vec<Field>,
}

/// Rows of one kind of module on their area.
#[derive(Clone)]
pub struct Field {
    pub rows: RowsOfModules,
    pub modules: Vec<Module>,
    pub outline: Outline,
    /// Direction of true north in the scene's axes.
    pub north: North,
}

impl LaidRows {
    /// Lays rows out on a scene.
    pub fn lay(
        file: &Path,
        rows: Vec<RowsOfModules>,
        surfaces: &Surfaces,
        siting: &Siting,
        north: North,
        observer: &dyn Observer,
    ) -> Result<Self> {
        let mut fields = Vec::new();
        for rows in rows {
            let outline = match &rows.ground {
                RowsGround::Area(corners) => Outline::of_polygon(corners),
                RowsGround::Counted { rows: count, modules, middle } => {
                    Outline::of_rows(&rows, [*count, *modules], *middle, north)
                }
                RowsGround::Surface(name) => match surface_named(surfaces, name) {
                    Ok(surface) => Outline::of_surface(surface),
                    Err(near) => {
                        let what = format!("the scene has no surface `{name}`");
                        let hint = message!("name one that `{{command:receivers}}` lists, such as {}", near.join(", "));
                        return Err(Error::input(file, None, what, hint).because(Problem::unknown(name, [])));
                    }
                },
            };
            if outline.places(rows.pitch_m) > MAX_PLACES {
                let what = format!("the rows `{}`: their area is too wide to search for places of modules", rows.name);
                let hint = "check that its corners are metres in the coordinates of the scene; split a larger field into several [[rows]]";
                return Err(Error::input(file, None, what, hint));
            }
            let below = |p: DVec2| siting.top(p.x, p.y).map(|top| top.z);
            let Laid { modules, rows: in_rows, left_out } = lay(&rows, north, &outline, below);
            if modules.is_empty() {
                let what = format!("the rows `{}`: no module fits", rows.name);
                let hint = match outline.is_empty() {
                    true => {
                        "rows stand on roofs and on the ground, and the surface is a wall; give modules of walls as points ({points})"
                    }
                    false => "give a larger area, a smaller setback or another orientation",
                };
                return Err(Error::input(file, None, what, hint).because(Problem::Empty));
            }
            let count = modules.len() as u64;
            if count > MAX_MODULES {
                return Err(Error::Limit {
                    what: "the number of modules of rows".into(),
                    value: count,
                    max: MAX_MODULES,
                });
            }
            if left_out > 0 {
                observer.warn(format!(
                    "{}: the rows `{}`: {} left out: no surface below, an object passes through, or half of it would stand higher",
                    file.display(),
                    rows.name,
                    counted(left_out as u64, "module")
                ));
            }
            observer.note(format!(
                "the rows `{}` have {} in {}",
                rows.name,
                counted(modules.len() as u64, "module"),
                counted(in_rows as u64, "row")
            ));
            fields.push(Field { rows, modules, outline, north });
        }
        let tables: Vec<&[Module]> = fields.iter().map(|field| field.modules.as_slice()).collect();
        let crossing = crossing(&tables);
        if let Some((module, other)) = crossing.first() {
            let what = format!(
                "rows pass through each other at {}, such as `{}` and `{}`",
                counted(crossing.len() as u64, "module"),
                module.name,
                other.name
            );
            let hint = "give each [[rows]] an area of its own, or `at` other places";
            return Err(Error::input(file, None, what, hint));
        }
        Ok(LaidRows { fields })
    }

    /// Returns all fields, in the order of the file.
    pub fn fields(&self) -> &[Field] {
        &self.fields
    }

    /// Returns the rows with all modules at an angle of their trackers, degrees.
    pub fn at(&self, angle_deg: f64) -> LaidRows {
        let field = |field: &Field| {
            let Some(tracker) = field.rows.tracker else { return field.clone() };
            let turned = |module: &Module| tracker.turned(module, angle_deg, field.north);
            Field {
                rows: RowsOfModules { turn: tracker.turn(angle_deg), ..field.rows.clone() },
                modules: field.modules.iter().map(turned).collect(),
                ..field.clone()
            }
        };
        LaidRows { fields: self.fields.iter().map(field).collect() }
    }

    /// Returns all modules, with their rows.
    pub fn modules(&self) -> impl Iterator<Item = (&Module, &RowsOfModules)> {
        self.fields.iter().flat_map(|Field { rows, modules, .. }| modules.iter().map(move |module| (module, rows)))
    }

    /// Writes the modules into a folder and adds them to a site.
    pub fn add_to(&self, site: &mut SceneFiles, folder: &Path) -> Result<()> {
        let (geometry, materials) = self.texts();
        write_texts(folder, &[(GEOMETRY, geometry), (MATERIALS, materials)])?;
        let (geometry, materials): (PathBuf, PathBuf) = (folder.join(GEOMETRY), folder.join(MATERIALS));
        // The modules are in metres of the scene, whatever applies to its other files.
        let part = Part::plain(&geometry, Some(&materials));
        site.parts.push(Part { scale: Some(1.0), elevation_m: Some(0.0), ..part });
        Ok(())
    }

    /// Returns the OBJ file and the file of its materials' reflectances.
    fn texts(&self) -> (String, String) {
        let (mut obj, mut toml, mut corner) = (String::new(), String::new(), 0);
        for Field { rows, modules, .. } in &self.fields {
            let [front, rear] = ["front", "rear"].map(|side| format!("pv {side} {}", rows.name));
            for (material, reflectance) in [&front, &rear].into_iter().zip(rows.reflectances) {
                let _ = writeln!(toml, "[\"{material}\"]\ndiffuse = {reflectance}\nclass = \"obstruction\"");
            }
            for module in modules {
                let _ = writeln!(obj, "o {}", module.name);
                let all: Vec<DVec3> = module.front.into_iter().chain(module.rear()).collect();
                for p in all {
                    let _ = writeln!(obj, "v {} {} {}", p.x, p.y, p.z);
                }
                let face = |of: [usize; 4]| of.map(|i| (corner + i).to_string()).join(" ");
                let _ = writeln!(obj, "usemtl {front}\nf {}\nusemtl {rear}", face([1, 2, 3, 4]));
                for of in [[8, 7, 6, 5], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 8, 4], [4, 8, 5, 1]] {
                    let _ = writeln!(obj, "f {}", face(of));
                }
                corner += 8;
            }
        }
        (obj, toml)
    }
}
