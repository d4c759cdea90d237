//! The site: all that a scene is made of. In: files on the command line, or a `site.toml` that
//! lists them. Out: one part for each file, with its materials and its place, and the statements
//! that hold for all files.

use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::Deserialize;

use crate::coordinate::is_position;
use crate::footprint_options::{FootprintOptions, HeightAbove, HeightSource};
use crate::model_version::ModelVersion;
use crate::placing::frame::{SiteFrame, UpAxis, check_elevation, check_rotation, check_scale};
use crate::region_part::RegionPart;
use crate::surface_rasters::SurfaceRasters;
use crate::text::read_toml;
use heliotile_core::error::{Error, Result};
use heliotile_files::input;
use heliotile_files::writing::guards::guard_output;
use heliotile_place::reference::Reference;

/// Files that make up one scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneFiles {
    /// Files, in the order in which they were named.
    pub parts: Vec<Part>,
    /// Place, rotation, unit and axis that hold for all files.
    pub frame: SiteFrame,
    /// Treatment of a scene in which no file has ground.
    pub missing_ground: MissingGround,
    /// Region part that is built by itself; `None` if the site is built as a whole.
    pub within: Option<RegionPart>,
}

/// Treatment of a scene whose files have no ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MissingGround {
    /// No ground is added.
    #[default]
    LeaveOut,
    /// A horizontal plane is added: as an EnergyPlus model states it, or else below the lowest
    /// point with a reflectance of 0.2.
    Assume,
}

/// One file of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Path of the file; its ending decides the format.
    pub file: PathBuf,
    /// Path of its `materials.toml`, which takes precedence over the file's own materials.
    pub materials: Option<PathBuf>,
    /// True if `materials` describes all materials, and the file's own descriptions are ignored.
    pub materials_only: bool,
    /// Translation of every position after `scale`, `up` and `rotate_deg`, metres.
    pub offset: DVec3,
    /// Metres a unit of the file; `None`: the site's scale, or 1.
    pub scale: Option<f64>,
    /// Axis that points up in the file; `None`: the axis that the format states, or the site's, or
    /// z.
    pub up: Option<UpAxis>,
    /// Direction of the file's y axis clockwise from the scene's, degrees; the file is turned about
    /// its own origin.
    pub rotate_deg: f64,
    /// Height of the file's z = 0 in the scene, metres; `None`: the site's, or 0.
    pub elevation_m: Option<f64>,
    /// Place on Earth of its own coordinates, in metres and before `offset`, in place of the file's
    /// own statement.
    pub reference: Option<Reference>,
    /// True if the file was moved into the coordinates of other files, so that its own statement of
    /// its place does not hold.
    pub is_moved: bool,
    /// Level of detail for objects that carry several; `None`: the finest.
    pub lod: Option<String>,
    /// Version of EnergyPlus that is assumed for a model; `None`: the version that the model
    /// states.
    pub assume_version: Option<ModelVersion>,
    /// Largest angle by which a raster beside other geometry may misplace the horizon, degrees; 0
    /// keeps every sample. `None`: 0.2 beside other geometry, and every sample where rasters are
    /// the whole scene.
    pub horizon_deg: Option<f64>,
    /// Sources of the heights of footprints.
    pub footprints: FootprintOptions,
    /// The raster of surface heights in `file` with its companions, if it becomes a city.
    pub surface: Option<SurfaceRasters>,
}

impl Part {
    /// Returns a file in metres at its own coordinates.
    pub fn plain(file: &Path, materials: Option<&Path>) -> Part {
        Part {
            file: file.to_owned(),
            materials: materials.map(Path::to_owned),
            materials_only: false,
            offset: DVec3::ZERO,
            scale: None,
            up: None,
            rotate_deg: 0.0,
            elevation_m: None,
            reference: None,
            is_moved: false,
            lod: None,
            assume_version: None,
            horizon_deg: None,
            footprints: FootprintOptions::default(),
            surface: None,
        }
    }

    /// Returns a raster of surface heights that becomes a city, with its companions.
    pub fn surface(rasters: &SurfaceRasters, materials: Option<&Path>) -> Part {
        Part { surface: Some(rasters.clone()), ..Part::plain(&rasters.dsm, materials) }
    }

    /// Returns this part with the scale, elevation and up axis of the site where it states none.
    /// Rasters are not asked for it: they are in metres above the sea.
    pub(super) fn in_frame(&self, frame: &SiteFrame) -> Part {
        let up = self.up.or(frame.up.filter(|_| has_no_up(&self.file)));
        let (scale, elevation_m) = (self.scale.or(frame.scale), self.elevation_m.or(frame.elevation_m));
        Part { scale, elevation_m, up, ..self.clone() }
    }

    /// Returns true if neither the format of the file nor the user states which axis points up, and
    /// y of the file is y of the scene.
    pub(super) fn lacks_up(&self) -> bool {
        self.up.is_none() && self.rotate_deg == 0.0 && has_no_up(&self.file)
    }

    /// Returns the metres a unit of the file.
    pub(super) fn metres(&self) -> f64 {
        self.scale.unwrap_or(1.0)
    }

    /// Returns the translation of positions, metres.
    pub(super) fn shift(&self) -> DVec3 {
        self.offset + DVec3::new(0.0, 0.0, self.elevation_m.unwrap_or_default())
    }

    /// Returns the scene position of a position in the file.
    pub(super) fn place(&self, p: DVec3) -> DVec3 {
        let p = p * self.metres();
        let p = if self.up == Some(UpAxis::Y) { DVec3::new(p.x, -p.z, p.y) } else { p };
        let p = if self.rotate_deg == 0.0 {
            p
        } else {
            let (sin, cos) = self.rotate_deg.to_radians().sin_cos();
            DVec3::new(p.x * cos + p.y * sin, p.y * cos - p.x * sin, p.z)
        };
        p + self.shift() + 0.0
    }
}

/// Endings of formats whose files do not state which axis points up.
const NO_UP: [&str; 3] = ["obj", "ply", "stl"];

fn has_no_up(file: &Path) -> bool {
    NO_UP.contains(&input::ending(file).as_str())
}

/// Contents of a `site.toml`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    scene: Vec<Entry>,
    #[serde(default)]
    site: FrameEntry,
}

/// Table `[site]`, which holds for all files.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct FrameEntry {
    epsg: Option<u32>,
    latitude_deg: Option<f64>,
    longitude_deg: Option<f64>,
    rotate_deg: Option<f64>,
    elevation_m: Option<f64>,
    scale: Option<f64>,
    up: Option<UpAxis>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    file: Option<PathBuf>,
    materials: Option<PathBuf>,
    #[serde(default)]
    materials_only: bool,
    offset: Option<[f64; 3]>,
    scale: Option<f64>,
    up: Option<UpAxis>,
    rotate_deg: Option<f64>,
    elevation_m: Option<f64>,
    epsg: Option<u32>,
    latitude_deg: Option<f64>,
    longitude_deg: Option<f64>,
    lod: Option<String>,
    assume_version: Option<String>,
    horizon_deg: Option<f64>,
    height: Option<Heights>,
    storey_height: Option<f64>,
    base: Option<HeightSource>,
    height_above: Option<HeightAbove>,
    layer: Option<Layers>,
    dsm: Option<PathBuf>,
    dem: Option<PathBuf>,
    canopy: Option<PathBuf>,
    landcover: Option<PathBuf>,
    step_m: Option<f64>,
    least_building_m2: Option<f64>,
    trunk_share: Option<f64>,
    trunk_zone: Option<PathBuf>,
    leaf_area_density: Option<f64>,
}

/// Value of `height`: `height = "HGT"`, `height = 9.5`, or a list of such.
#[derive(Deserialize)]
#[serde(untagged)]
enum Heights {
    Metres(f64),
    One(HeightSource),
    Several(Vec<HeightSource>),
}

/// Value of `layer`: `layer = "buildings"`, or a list of such.
#[derive(Deserialize)]
#[serde(untagged)]
enum Layers {
    One(String),
    Several(Vec<String>),
}

const KEYS: &str = "write a table [[scene]] for each file: file = \"town.city.json\" and optionally materials = \"town.toml\", \
                    materials_only = true, offset = [x, y, z] in metres, scale = 0.001 (metres a unit), up = \"y\", \
                    rotate_deg = 30 (clockwise), elevation_m = 512, epsg = 28992 or latitude_deg and longitude_deg, \
                    lod = \"2.2\", assume_version = \"25.2\" of EnergyPlus, for terrain horizon_deg = 0.2, for footprints \
                    height = \"height\" (a column, metres, or a list of such), storey_height = 3.0, base = \"ground\", height_above = \"sea\" and layer = \"buildings\"; in place of \
                    file for rasters of a city dsm = \"dsm.tif\" and optionally dem, canopy (both without dsm for trees alone), landcover, step_m, least_building_m2, \
                    trunk_share, trunk_zone, leaf_area_density; what holds for all files stands in a table [site]: epsg, latitude_deg, \
                    longitude_deg, rotate_deg, elevation_m, scale, up";

impl SceneFiles {
    /// Returns the site of scene files and `site.toml` files in any mixture. `materials` is for
    /// files that name none of their own. A folder stands for the `site.toml` in it, or without one
    /// for the tiles of CityGML in it.
    pub fn new(files: &[PathBuf], materials: Option<&Path>) -> Result<SceneFiles> {
        let mut site = SceneFiles::default();
        for file in files {
            let listed = if file.is_dir() { listed_in(file)? } else { Some(file.clone()) };
            let Some(listed) = listed else {
                for folder in input::members::theme_folders(file).iter().chain([file]) {
                    let tiles = input::members::of_folder(folder, &TILES)?;
                    site.parts.extend(tiles.iter().map(|tile| Part::plain(tile, materials)));
                }
                continue;
            };
            if input::ending(&listed) == "toml" {
                let SceneFiles { parts, frame, .. } = read_site(&listed, materials)?;
                site.parts.extend(parts);
                site.frame = site.frame.joined(&frame).map_err(|key| {
                    let what = format!("its [site] states another `{key}` than the site file before it");
                    Error::input(&listed, None, what, "a scene has one frame: state it once")
                })?;
            } else {
                site.parts.push(Part::plain(file, materials));
            }
        }
        Ok(site)
    }

    /// Returns this site with what `frame` states in place of its own frame.
    pub fn framed(self, frame: &SiteFrame) -> SceneFiles {
        SceneFiles { frame: self.frame.under(frame), ..self }
    }

    /// Returns a warning if the frame states which axis points up and no file has a format that
    /// needs it.
    pub(crate) fn unused_up(&self) -> Option<String> {
        let used = self.frame.up.is_none() || self.parts.iter().any(|part| has_no_up(&part.file));
        (!used).then(|| {
            "the stated up axis has no effect: it applies to OBJ, PLY and STL, and no file is one of these".to_owned()
        })
    }

    /// Returns all files that the site is read from, except `site.toml`.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.parts.iter().flat_map(move |part| {
            let own = [Some(part.file.as_path()), part.materials.as_deref()].into_iter().flatten();
            own.chain(part.surface.iter().flat_map(|rasters| rasters.files().skip(1)))
        })
    }
}

/// Returns the `site.toml` of a folder; `None` if the folder has tiles of CityGML instead.
fn listed_in(folder: &Path) -> Result<Option<PathBuf>> {
    let listed = input::plain_or_packed(folder.join("site.toml"));
    if listed.is_file() {
        return Ok(Some(listed));
    }
    if !input::members::theme_folders(folder).is_empty() || !input::members::of_folder(folder, &TILES)?.is_empty() {
        return Ok(None);
    }
    let hint = "name the scene files in it, or list them in a site.toml there";
    Err(Error::input(folder, None, "is a folder without a site.toml or tiles of CityGML (.gml)", hint))
}

/// Endings of tiles of CityGML. The first one found in a folder counts, because code lists end with
/// .xml as well.
const TILES: [&str; 3] = ["gml", "citygml", "xml"];

fn read_site(path: &Path, materials: Option<&Path>) -> Result<SceneFiles> {
    let bytes = input::read(path)?;
    let text = String::from_utf8_lossy(&bytes);
    let document: Document = read_toml(path, &text, KEYS)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut parts = Vec::new();
    for entry in &document.scene {
        let name = entry.file.as_ref().or(entry.dsm.as_ref()).cloned().unwrap_or_default();
        let refuse = |what: String| Error::input(path, None, format!("the scene {}: {what}", name.display()), KEYS);
        parts.push(part(entry, folder, materials).map_err(refuse)?);
    }
    if parts.is_empty() {
        return Err(Error::input(path, None, "lists no scene", KEYS));
    }
    let FrameEntry { epsg, latitude_deg, longitude_deg, rotate_deg, elevation_m, scale, up } = document.site;
    let grid_north = false;
    let stated = SiteFrame { epsg, latitude_deg, longitude_deg, rotate_deg, grid_north, elevation_m, scale, up };
    let frame = stated.checked().map_err(|what| Error::input(path, None, format!("the table [site]: {what}"), KEYS))?;
    Ok(SceneFiles { parts, frame, ..SceneFiles::default() })
}

/// Returns the part of an entry; an error says what is wrong.
fn part(entry: &Entry, folder: &Path, materials: Option<&Path>) -> std::result::Result<Part, String> {
    let offset = DVec3::from(entry.offset.unwrap_or_default());
    if !is_position(offset) {
        return Err(format!("`offset` is {offset}"));
    }
    if let Some(angle) = entry.horizon_deg.filter(|angle| !(0.0..=10.0).contains(angle)) {
        return Err(format!("`horizon_deg` is {angle}, not from 0 to 10"));
    }
    let (latitude_deg, longitude_deg) = (entry.latitude_deg, entry.longitude_deg);
    let stated = SiteFrame { epsg: entry.epsg, latitude_deg, longitude_deg, ..SiteFrame::default() };
    let reference = match stated.checked()?.references() {
        [Some(_), Some(_)] => return Err("both `epsg` and a latitude are stated; give one of them".to_owned()),
        [epsg, place] => epsg.or(place),
    };
    let surface = surface(entry, folder)?;
    let file = match (&entry.file, &surface) {
        (Some(file), None) => folder.join(file),
        (None, Some(rasters)) => rasters.dsm.clone(),
        _ => return Err("either `file` or `dsm` must be given, and not both".to_owned()),
    };
    Ok(Part {
        file,
        materials: entry.materials.as_ref().map(|own| folder.join(own)).or(materials.map(Path::to_owned)),
        materials_only: entry.materials_only,
        offset,
        scale: entry.scale.map(check_scale).transpose()?,
        up: entry.up,
        rotate_deg: entry.rotate_deg.map(check_rotation).transpose()?.unwrap_or_default(),
        elevation_m: entry.elevation_m.map(check_elevation).transpose()?,
        reference,
        is_moved: false,
        lod: entry.lod.clone(),
        assume_version: entry.assume_version.as_ref().map(|text| text.parse()).transpose()?,
        horizon_deg: entry.horizon_deg,
        footprints: footprints_of(entry)?,
        surface,
    })
}

/// Returns the footprint options of an entry.
fn footprints_of(entry: &Entry) -> std::result::Result<FootprintOptions, String> {
    let height = match &entry.height {
        None => Vec::new(),
        Some(Heights::Metres(metres)) => vec![HeightSource::Metres(*metres)],
        Some(Heights::One(source)) => vec![source.clone()],
        Some(Heights::Several(sources)) => sources.clone(),
    };
    let layer = match &entry.layer {
        None => Vec::new(),
        Some(Layers::One(name)) => vec![name.clone()],
        Some(Layers::Several(names)) => names.clone(),
    };
    let (base, height_above) = (entry.base.clone(), entry.height_above);
    let options = FootprintOptions { height, storey_height_m: entry.storey_height, base, height_above, layer };
    options.check().map_err(|(_, what)| what)?;
    Ok(options)
}

/// Returns the rasters of a city that an entry lists, if any.
fn surface(entry: &Entry, folder: &Path) -> std::result::Result<Option<SurfaceRasters>, String> {
    let Entry { dsm, dem, canopy, landcover, .. } = entry;
    let files = SurfaceRasters::of_files(dsm.clone(), dem.clone(), canopy.clone(), landcover.clone());
    let found = SurfaceRasters {
        step_m: entry.step_m,
        least_building_m2: entry.least_building_m2,
        trunk_share: entry.trunk_share,
        trunk_zone: entry.trunk_zone.clone(),
        leaf_area_density: entry.leaf_area_density,
        ..files.unwrap_or_default()
    };
    match found.dsm.as_os_str().is_empty() {
        true if found == SurfaceRasters::default() => Ok(None),
        true => Err("rasters of a city need a `dsm`, or `dem` and `canopy` for trees alone".to_owned()),
        false => {
            found.check().map_err(|(_, what)| what)?;
            found.with_paths(|path| Ok(folder.join(path))).map(Some)
        }
    }
}

/// Refuses an output that would replace a file of the scene or another input.
pub fn guard_site(output: &Path, site: &SceneFiles, others: &[Option<&Path>]) -> Result<()> {
    let inputs: Vec<&Path> = site.files().chain(others.iter().copied().flatten()).collect();
    guard_output(output, &inputs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;
    use crate::test_files::TestFolder;

    const SQUARE: &str = "v 0 0 0\nv 2 0 0\nv 2 0 -2\nv 0 0 -2\nusemtl wall\nf 1 2 3 4\n";

    fn site(toml: &str) -> (TestFolder, Result<SceneFiles>) {
        let folder = TestFolder::new();
        folder.write("a.obj", SQUARE);
        folder.write("b.obj", SQUARE);
        folder.write("a.toml", "[wall]\ndiffuse = 0.5\n");
        folder.write("b.toml", "[wall]\ndiffuse = 0.1\n");
        folder.write("site.toml", toml);
        let site = SceneFiles::new(&[folder.at("")], None);
        (folder, site)
    }

    /// Two files with one material name and two tables keep 0.5 and 0.1; offset, scale and axis put
    /// the second file where it belongs.
    #[test]
    fn two_files_keep_their_own_materials() {
        let (_folder, site) = site(
            "[[scene]]\nfile = \"a.obj\"\nmaterials = \"a.toml\"\n[[scene]]\nfile = \"b.obj\"\nmaterials = \"b.toml\"\n\
             offset = [10, 20, 30]\nscale = 0.5\nup = \"y\"\n",
        );
        let scene = Scene::load_site(&site.expect("readable")).expect("a scene");
        let found: Vec<(&str, f64)> = scene.materials.iter().map(|m| (m.name.as_str(), m.diffuse)).collect();
        assert_eq!(found, [("wall", 0.5), ("wall (b)", 0.1)]);
        let (low, high) = scene.mesh.bounds();
        // With y up, z = -2 becomes y = 1 at half the size; the first file hangs below z = 0.
        assert_eq!(
            (low + scene.mesh.origin, high + scene.mesh.origin),
            (DVec3::new(0., 0., -2.), DVec3::new(11., 21., 30.))
        );
        assert_eq!((scene.mesh.triangles.len(), scene.report.warnings.len()), (4, 0));
    }

    /// With y up for the whole site the square of OBJ stands upright, 2 m high; a file that states
    /// z for itself lies flat, and a site of glTF alone gets a warning.
    #[test]
    fn y_up_of_the_site_turns_obj_upright() {
        let files = "[[scene]]\nfile = \"a.obj\"\n[[scene]]\nfile = \"b.obj\"\nup = \"z\"\noffset = [9, 0, 0]\n";
        let (_folder, site) = site(files);
        let site = site.expect("readable").framed(&SiteFrame { up: Some(UpAxis::Y), ..SiteFrame::default() });
        let scene = Scene::load_site(&site).expect("a scene");
        let (low, high) = scene.mesh.bounds();
        // The first file spans y 0 to 2 at z = 0, the second one z -2 to 0 at y = 0.
        assert_eq!((high - low).to_array(), [11.0, 2.0, 2.0]);
        assert_eq!(site.unused_up(), None);
        let plain = SceneFiles { parts: vec![Part::plain(Path::new("a.glb"), None)], ..site };
        assert!(plain.unused_up().is_some_and(|said| said.contains("no file is one of these")));
    }

    /// One material name in two files under one table is one material, and the order of the parts
    /// does not change the hash.
    #[test]
    fn the_order_of_parts_keeps_the_hash() {
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

    /// A folder of two tiles, one of them packed, and a code list is a site of the two tiles,
    /// sorted by name; a `site.toml` in it takes precedence.
    #[test]
    fn a_folder_of_tiles_is_a_site_of_them() {
        let folder = TestFolder::new();
        for name in ["2.gml.gz", "1.gml", "codes.xml", "readme.txt"] {
            folder.write(name, "");
        }
        let parts = || SceneFiles::new(&[folder.at("")], None).expect("a site").parts;
        let names: Vec<_> = parts().iter().map(|part| part.file.file_name().expect("a name").to_owned()).collect();
        assert_eq!(names, ["1.gml", "2.gml.gz"]);
        folder.write("site.toml", "[[scene]]\nfile = \"a.obj\"\n");
        assert_eq!(parts().len(), 1);
    }

    /// Seventeen wrong site files are refused by name, with a line where there is one.
    #[test]
    fn wrong_site_files_are_refused_by_name() {
        for (toml, quoted) in [
            ("", "missing field `scene`"),
            ("scene = []", "lists no scene"),
            ("[[scene]]\nfle = \"a.obj\"\n", "line 2"),
            ("[[scene]]\nfile = \"a.obj\"\nscale = 0\n", "`scale` is 0"),
            ("[[scene]]\nfile = \"a.obj\"\nscale = nan\n", "`scale` is NaN"),
            ("[[scene]]\nfile = \"a.obj\"\noffset = [0, inf, 0]\n", "`offset` is"),
            ("[[scene]]\nfile = \"a.obj\"\nup = \"x\"\n", "line 3"),
            ("[[scene]]\nfile = \"a.obj\"\nrotate_deg = 400\n", "`rotate_deg` is 400"),
            ("[[scene]]\nfile = \"a.obj\"\nelevation_m = inf\n", "`elevation_m` is inf"),
            ("[[scene]]\nfile = \"a.obj\"\nlatitude_deg = 50\n", "belong together"),
            ("[[scene]]\nfile = \"a.obj\"\nepsg = 4326\n", "EPSG:4326 has coordinates in degrees"),
            ("[[scene]]\nfile = \"a.obj\"\nepsg = 28992\nlatitude_deg = 50\nlongitude_deg = 5\n", "both `epsg` and"),
            (
                "[site]\nlatitude_deg = 95\nlongitude_deg = 5\n[[scene]]\nfile = \"a.obj\"\n",
                "[site]: `latitude_deg` is 95",
            ),
            ("[[scene]]\ndsm = \"a.tif\"\nfile = \"a.obj\"\n", "either `file` or `dsm`"),
            ("[[scene]]\nfile = \"a.obj\"\ncanopy = \"c.tif\"\n", "need a `dsm`"),
            ("[[scene]]\ndsm = \"a.tif\"\ntrunk_share = 2\n", "`trunk_share` is 2"),
            ("[[scene]]\ndsm = \"a.tif\"\ntrunk_zone = \"b.tif\"\n", "lower part of a `canopy`"),
            ("[site]\ncrs = 28992\n[[scene]]\nfile = \"a.obj\"\n", "line 2"),
        ] {
            let message = site(toml).1.expect_err(toml).to_string();
            assert!(message.contains("site.toml") && message.contains(quoted), "{toml:?}: {message}");
        }
    }
}
