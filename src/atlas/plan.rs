//! `atlas.json`: how a region is cut into parts. In: the request of `partition`, and where objects
//! lie. Out: parts with their places and the site of each, the same wherever and whenever it is
//! read.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::seams::Seams;
use heliotile_builder::planning::AccuracyRequest;
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::text::message;
use heliotile_core::units::parse_metres;
use heliotile_files::input;
use heliotile_remote::Directory;
use heliotile_remote::naming::shown;
use heliotile_requests::{DefaultRequest, Request};
use heliotile_scene::region_part::RegionPart;
use heliotile_scene::request::SceneRequest;
use heliotile_scene::site::SceneFiles;
use heliotile_scene::survey::FileSurvey;
use heliotile_studies::covering::CoverRequest;

pub use heliotile_remote::places::ATLAS as FILE;

/// Number of the layout that is written, and the only one that is read.
const LAYOUT: u32 = 4;

/// Hint for a plan that cannot be used.
const AGAIN: &str = "make it again with `{command:atlas partition}`";

/// A region cut into parts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AtlasPlan {
    heliotile_atlas: u32,
    /// How the region was cut.
    #[serde(flatten)]
    pub cut: CutRequest,
    /// Error that the halo makes, if it was estimated.
    pub seams: Option<Seams>,
    /// All files of the site, in the order of the site.
    pub files: Vec<PlannedFile>,
    /// BLAKE3 hashes of these files, of the list that names them and of materials, by path.
    checksums: BTreeMap<PathBuf, String>,
    /// Parts, in the order of their cells (x, then y).
    pub parts: Vec<PlannedPart>,
}

/// A file of the site and the box that it fills, metres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlannedFile {
    /// Path of the file.
    pub file: PathBuf,
    /// Lowest corner of its box.
    pub low: [f64; 3],
    /// Highest corner of its box.
    pub high: [f64; 3],
}

/// A part that an object touches.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlannedPart {
    /// Name of the part and of its folder: its corner in multiples of the part's size.
    pub name: String,
    /// South-west corner, metres.
    pub low: [f64; 2],
    /// Number of objects that touch the part. Objects wider than a part are not counted: terrain is
    /// everywhere.
    pub objects: usize,
}

/// Settings of a cut, common to all parts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Request, DefaultRequest)]
#[serde(deny_unknown_fields)]
pub struct CutRequest {
    /// Side of a square part; its corners lie at multiples of this length in the scene's
    /// coordinates.
    #[field(metavar = "LENGTH", default = "500m", parse = parse_metres)]
    pub part_size_m: f64,
    /// Width of the zone around a part in which all objects count.
    #[field(metavar = "LENGTH", default = "300m", parse = parse_metres)]
    pub halo_m: f64,
    /// Angle above the horizon, degrees: objects beyond the halo count only if they rise higher
    /// than this, as seen from the part.
    #[field(metavar = "DEGREES", default = 5.0, range = 0.1..=90.0, says = "give an angle from 0.1 to 90 degrees; with 90, nothing beyond the halo counts")]
    pub skyline_deg: f64,
    /// Scene files and their options.
    #[field(flatten, without("grid_north"))]
    pub scene: SceneRequest,
    /// Surfaces and density of receivers.
    #[field(flatten)]
    pub cover: CoverRequest,
    /// Accuracy of all parts; a target error is not accepted.
    #[field(flatten, without("error", "error_weather"))]
    pub accuracy: AccuracyRequest,
    /// Leave the scene's triangles out of the archives, if they may not be passed on.
    #[field(python = "with_scene")]
    pub no_scene: bool,
}

/// Most parts of an atlas: a country in parts of 100 m.
const MAX_PARTS: usize = 10_000_000;

impl AtlasPlan {
    /// Cuts a site with the surveyed objects. Errors: too many parts; a file that cannot be read
    /// again.
    pub fn new(cut: CutRequest, surveyed: &[FileSurvey]) -> Result<Self> {
        let any = !(cut.cover.on.is_empty() && cut.cover.types.is_empty());
        let mut touched: BTreeMap<[i64; 2], usize> = BTreeMap::new();
        for object in surveyed.iter().flat_map(|file| &file.objects).filter(|object| any || object.is_usual) {
            let [low, high] = object.bounds.map(|corner| (corner.truncate() / cut.part_size_m).floor().as_i64vec2());
            // Terrain is everywhere: it must not decide in which parts the halo is tried.
            let is_wider = (object.bounds[1] - object.bounds[0]).truncate().max_element() > cut.part_size_m;
            for x in low.x..=high.x {
                for y in low.y..=high.y {
                    *touched.entry([x, y]).or_default() += usize::from(!is_wider);
                    if touched.len() > MAX_PARTS {
                        let (what, max) = ("the number of parts".to_owned(), MAX_PARTS as u64);
                        return Err(Error::Limit { what: what.into(), value: max + 1, max });
                    }
                }
            }
        }
        let part = |([x, y], objects): ([i64; 2], usize)| PlannedPart {
            name: format!("x{x}_y{y}"),
            low: [x as f64, y as f64].map(|number| number * cut.part_size_m),
            objects,
        };
        let file = |found: &FileSurvey| PlannedFile {
            file: found.file.clone(),
            low: found.bounds[0].to_array(),
            high: found.bounds[1].to_array(),
        };
        let site = cut.scene.site()?;
        let all = site.files().map(Path::to_path_buf).chain(said_in(&cut.scene));
        let checksums = all.map(|path| Ok((path.clone(), checksum(&path)?))).collect::<Result<_>>()?;
        let parts = touched.into_iter().map(part).collect();
        Ok(AtlasPlan {
            heliotile_atlas: LAYOUT,
            checksums,
            cut,
            seams: None,
            files: surveyed.iter().map(file).collect(),
            parts,
        })
    }

    /// Reads the plan of a local or remote folder.
    pub fn read(atlas: &Path) -> Result<Self> {
        let folder = Directory::at(atlas);
        let found = if folder.is_remote() { folder.read(FILE, true)? } else { Some(input::read(&folder.join(FILE))?) };
        let nothing = || {
            let hint = "give the folder of an atlas.json; `{command:archive copy} ATLAS ADDRESS` copies an atlas to an address";
            Error::input(&shown(atlas), None, "holds no atlas.json, so it is not an atlas", hint)
        };
        AtlasPlan::of_file(&shown(&folder.join(FILE)), &found.ok_or_else(nothing)?)
    }

    /// Parses the bytes of a plan; `path` is for messages.
    pub fn of_file(path: &Path, bytes: &[u8]) -> Result<Self> {
        let refuse = |what: String| Error::input(path, None, what, AGAIN).because(Problem::Damaged);
        #[derive(Deserialize)]
        struct Stated {
            heliotile_atlas: u32,
        }
        let stated: Stated =
            serde_json::from_slice(bytes).map_err(|error| refuse(format!("is no plan of an atlas: {error}")))?;
        if stated.heliotile_atlas != LAYOUT {
            return Err(Error::Unsupported {
                what: format!("layout of {}", path.display()).into(),
                found: stated.heliotile_atlas.to_string(),
                supported: message!("{LAYOUT} only: cut the region again with `{{command:atlas partition}}`"),
            });
        }
        let plan: AtlasPlan = serde_json::from_slice(bytes).map_err(|error| refuse(error.to_string()))?;
        plan.check().map_err(refuse)?;
        Ok(plan)
    }

    /// Checks the numbers and names of the plan; the error says what is wrong.
    fn check(&self) -> std::result::Result<(), String> {
        let numbers = [self.cut.part_size_m, self.cut.halo_m, self.cut.skyline_deg];
        if !numbers.iter().all(|number| number.is_finite() && *number > 0.0) {
            return Err(format!(
                "the part size is {} m, the halo {} m and the skyline {} degrees; each must be above 0",
                numbers[0], numbers[1], numbers[2]
            ));
        }
        let boxes = self.files.iter().flat_map(|file| file.low.iter().chain(&file.high));
        if !boxes.chain(self.parts.iter().flat_map(|part| &part.low)).all(|number| number.is_finite()) {
            return Err("a coordinate of a file or part is not a finite number".to_owned());
        }
        let is_name =
            |name: &str| !name.is_empty() && name.bytes().all(|b| b.is_ascii_alphanumeric() || b"_-".contains(&b));
        if let Some(part) = self.parts.iter().find(|part| !is_name(&part.name)) {
            return Err(format!("`{}` is not a valid name of a part: letters, digits, - and _ only", part.name));
        }
        let mut names = BTreeSet::new();
        match self.parts.iter().find(|part| !names.insert(part.name.to_lowercase())) {
            Some(part) => Err(format!("lists the part `{}` twice: its receivers would count twice", part.name)),
            None => Ok(()),
        }
    }

    /// Returns the part with a name, or with a number from 0.
    pub fn part(&self, asked: &str, atlas: &Path) -> Result<&PlannedPart> {
        let by_name = self.parts.iter().find(|part| part.name == asked);
        let numbered = || asked.parse::<usize>().ok().and_then(|number| self.parts.get(number));
        by_name.or_else(numbered).ok_or_else(|| {
            let names: Vec<&str> = self.parts.iter().map(|part| part.name.as_str()).take(5).collect();
            let what = format!("{} has no part `{asked}`", atlas.display());
            let last = self.parts.len().saturating_sub(1);
            Error::argument(
                "part",
                what,
                format!("give a number from 0 to {last}, `all`, or a name: {}, ...", names.join(", ")),
            )
            .because(Problem::unknown(asked, []))
        })
    }

    /// Returns the square of a part, and which surroundings count.
    pub fn region_part(&self, part: &PlannedPart) -> RegionPart {
        let low = DVec2::from(part.low);
        let high = low + DVec2::splat(self.cut.part_size_m);
        RegionPart { low, high, halo_m: self.cut.halo_m, skyline_deg: self.cut.skyline_deg }
    }

    /// Returns the site of a part: the files that may hold objects that count.
    pub fn site(&self, within: RegionPart, atlas: &Path) -> Result<SceneFiles> {
        let mut site = self.cut.scene.site()?;
        if !site.parts.iter().map(|part| &part.file).eq(self.files.iter().map(|planned| &planned.file)) {
            let what = "the scene lists other files than when the region was cut";
            return Err(Error::input(&atlas.join(FILE), None, what, AGAIN));
        }
        let bounds = |file: &PlannedFile| (file.low.into(), file.high.into());
        let here = self.files.iter().filter(|file| {
            let (low, high) = bounds(file);
            within.touches(low, high)
        });
        let base_m = here.map(|file| file.low[2]).fold(f64::INFINITY, f64::min);
        let mut counts = self.files.iter().map(|file| {
            let (low, high) = bounds(file);
            within.counts(low, high, base_m)
        });
        site.parts.retain(|_| counts.next() == Some(true));
        site.within = Some(within);
        Ok(site)
    }

    /// Returns the first file of a part that has changed since the region was cut.
    pub fn changed(&self, site: &SceneFiles) -> Result<Option<PathBuf>> {
        let is_far = |path: &PathBuf| self.files.iter().any(|planned| planned.file == *path);
        let lists = said_in(&self.cut.scene).filter(|path| !is_far(path));
        for path in site.files().map(Path::to_path_buf).chain(lists) {
            if self.checksums.get(&path) != Some(&checksum(&path)?) {
                return Ok(Some(path));
            }
        }
        Ok(None)
    }

    /// Returns the plan as JSON.
    pub fn to_json(&self) -> Result<String> {
        let text =
            serde_json::to_string_pretty(self).map_err(|error| Error::io(Path::new(FILE), "write")(error.into()))?;
        Ok(text + "\n")
    }
}

/// Returns the files that the request names: scenes, their lists, the lists of folders, materials.
fn said_in(scene: &SceneRequest) -> impl Iterator<Item = PathBuf> {
    let list = |path: &PathBuf| {
        let lists = ["site.toml", "site.toml.gz"].map(|name| path.join(name));
        [path.clone()].into_iter().chain(lists)
    };
    let named = scene.files.iter().flat_map(list).chain(scene.materials.clone());
    named.filter(|path| path.is_file()).collect::<Vec<_>>().into_iter()
}

/// Returns the BLAKE3 hash of a file. A file that this process has hashed is not read again as long
/// as its length and modification time stay.
fn checksum(path: &Path) -> Result<String> {
    type Known = HashMap<PathBuf, ((u64, Option<SystemTime>), String)>;
    static KNOWN: Mutex<Option<Known>> = Mutex::new(None);
    let file = fs::File::open(path).map_err(Error::io(path, "open"))?;
    let about = file.metadata().map_err(Error::io(path, "read the length of"))?;
    let version = (about.len(), about.modified().ok());
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let known = known.get_or_insert_default();
    if let Some((of, hash)) = known.get(path)
        && *of == version
    {
        return Ok(hash.clone());
    }
    let hash = blake3::Hasher::new().update_reader(file).map_err(Error::io(path, "read"))?.finalize();
    let hash = hash.to_hex().to_string();
    known.insert(path.to_path_buf(), (version, hash.clone()));
    Ok(hash)
}

/// Makes the paths of scene files absolute, as parts may be built from any folder.
pub fn absolute(scene: &SceneRequest) -> Result<SceneRequest> {
    let whole = |path: &PathBuf| std::path::absolute(path).map_err(Error::io(path, "find"));
    let mut scene = scene.clone();
    scene.files = scene.files.iter().map(whole).collect::<Result<_>>()?;
    scene.materials = scene.materials.as_ref().map(whole).transpose()?;
    if let Some(rasters) = scene.surface.settled() {
        scene.surface = rasters.with_paths(whole)?;
    }
    Ok(scene)
}

/// Returns true if a folder holds an atlas.
pub fn is_atlas(path: &Path) -> bool {
    fs::metadata(path.join(FILE)).is_ok_and(|found| found.is_file())
}

#[cfg(test)]
mod tests {
    use super::*;
    use heliotile_scene::footprint_options::FootprintOptions;
    use heliotile_scene::placing::frame::{SiteFrame, UpAxis};
    use heliotile_studies::covering::Density;

    /// Returns a plan in which every field has a value.
    fn full() -> AtlasPlan {
        let frame = SiteFrame {
            epsg: Some(28992),
            latitude_deg: Some(52.0),
            longitude_deg: Some(4.3),
            rotate_deg: Some(10.0),
            grid_north: false,
            elevation_m: Some(2.0),
            scale: Some(0.001),
            up: Some(UpAxis::Z),
        };
        let scene = SceneRequest {
            files: vec!["town.city.json".into()],
            materials: Some("m.toml".into()),
            footprints: FootprintOptions { storey_height_m: Some(3.0), ..FootprintOptions::default() },
            assume_version: heliotile_scene::ModelVersion::parse("9.6"),
            frame,
            surface: heliotile_scene::SurfaceRasters {
                canopy: Some("cdsm.tif".into()),
                ..heliotile_scene::SurfaceRasters::new("dsm.tif")
            },
            ..SceneRequest::default()
        };
        AtlasPlan {
            heliotile_atlas: LAYOUT,
            cut: CutRequest {
                part_size_m: 250.0,
                scene,
                cover: CoverRequest { density: Density::PerSurface(3), ..CoverRequest::default() },
                accuracy: AccuracyRequest { set: vec!["hit=16".into()], ..AccuracyRequest::default() },
                no_scene: true,
                ..CutRequest::default()
            },
            seams: Some(Seams {
                receivers: 32,
                parts: 2,
                rmse_percent: 0.5,
                at_most_percent: 0.9,
                bias_percent: -0.1,
                components_percent: BTreeMap::from([("sun_direct".into(), 0.4)]),
            }),
            files: vec![PlannedFile { file: "town.city.json".into(), low: [0.0; 3], high: [9.0; 3] }],
            checksums: BTreeMap::from([("town.city.json".into(), "00".into())]),
            parts: vec![PlannedPart { name: "x0_y0".into(), low: [0.0; 2], objects: 4 }],
        }
    }

    /// A plan is read again as it was written. For layout 3 the message says to cut the region
    /// again. An unknown key is refused, beside the keys of a plan and in place of one, and so is a
    /// plan without a key.
    #[test]
    fn a_plan_is_read_again_as_it_was_written() {
        let text = full().to_json().expect("JSON");
        let read = |text: &str| AtlasPlan::of_file(Path::new("atlas.json"), text.as_bytes());
        assert_eq!(read(&text).ok(), Some(full()));
        let older =
            read(&text.replace("\"heliotile_atlas\": 4", "\"heliotile_atlas\": 3")).expect_err("older").to_string();
        assert!(older.contains("cut the region again"), "{older}");
        assert!(read(&text.replace("\"no_scene\"", "\"no_scenes\"")).is_err());
        assert!(read(&text.replace("\"no_scene\"", "\"no_scenes\": true, \"no_scene\"")).is_err());
        let without = text.lines().filter(|line| !line.contains("skyline_deg")).collect::<String>();
        assert!(read(&without).expect_err("no skyline").to_string().contains("skyline_deg"));
    }

    /// `schema/atlas.md` names every key that a plan has, and every key in its tables is a key of a
    /// plan.
    #[test]
    fn the_schema_names_every_key_of_a_plan() {
        fn keys(value: &serde_json::Value, found: &mut std::collections::BTreeSet<String>) {
            match value {
                serde_json::Value::Object(map) => map.iter().for_each(|(key, value)| {
                    found.insert(key.clone());
                    keys(value, found);
                }),
                serde_json::Value::Array(list) => list.iter().for_each(|value| keys(value, found)),
                _ => {}
            }
        }
        let mut found = std::collections::BTreeSet::new();
        keys(&serde_json::to_value(full()).expect("JSON"), &mut found);
        // Names of files and of columns are keys of maps, not of the format.
        found.retain(|key| !["town.city.json", "sun_direct"].contains(&key.as_str()));
        let text = include_str!("../../schema/atlas.md");
        let missing: Vec<_> = found.iter().filter(|key| !text.contains(key.as_str())).collect();
        assert!(missing.is_empty(), "not in schema/atlas.md: {missing:?}");
        let rows = text.lines().filter_map(|line| line.strip_prefix("| `")?.split_once('`')).map(|row| row.0);
        let unknown: Vec<_> = rows.filter(|key| !found.contains(*key)).collect();
        assert!(unknown.is_empty(), "in schema/atlas.md alone: {unknown:?}");
    }
}
