//! Arguments for scene files and their place, as most commands take them.

use std::path::{Path, PathBuf};

use crate::cli::Metres;
use crate::cli::values::choice;
use clap::Args;

use super::rasters::RasterArgs;
use heliotile::scene::{check_elevation, check_epsg, check_rotation, check_scale};
use heliotile::{
    FootprintOptions, HeightAbove, HeightSource, ModelVersion, SceneFiles, SceneRequest, SiteFrame, UpAxis, error,
};

#[derive(Args, Clone, Debug)]
pub struct SceneArgs {
    /// Scene files, merged into one scene, or a site.toml that lists them: CityJSON (.city.json,
    /// .city.jsonl, .cityjson), CityGML (.gml, .xml, or a folder of tiles), footprints (.geojson,
    /// .shp, .gpkg, .parquet), terrain (.tif, .asc, .dem), EnergyPlus (.epjson, .idf), Honeybee
    /// (.hbjson), glTF (.gltf, .glb), .obj, .ply, .stl; also packed (.gz, .zip). Coordinates are
    /// metres, x east, y north, z up; footprints and CityGML may be in degrees
    #[arg(required_unless_present_any = ["dsm", "dem", "canopy", "landcover"], value_name = "SCENE")]
    pub scene: Vec<PathBuf>,
    #[command(flatten)]
    pub rasters: RasterArgs,
    #[command(flatten)]
    pub surfaces: MaterialsArgs,
    #[command(flatten)]
    pub place: PlaceArgs,
    #[command(flatten)]
    pub footprints: FootprintArgs,
}

/// Base and height of buildings from footprints.
#[derive(Args, Clone, Debug, Default)]
pub struct FootprintArgs {
    /// Height of buildings above their base, for files of footprints: a column, or metres for all
    /// buildings, or several, of which the first with a value counts, as in HGT,9m [default:
    /// columns such as height and building:height, then storeys]
    #[arg(long, value_delimiter = ',', value_name = "COLUMN|METRES")]
    pub height: Vec<HeightSource>,
    /// Height of a storey, for footprints that state storeys and no height [default: 3m]
    #[arg(long, value_name = "LENGTH")]
    pub storey_height: Option<Metres>,
    /// Base of buildings from footprints: a column, or metres [default: the lowest terrain below
    /// the outline, 0 without terrain]
    #[arg(long, value_name = "COLUMN|METRES")]
    pub base: Option<HeightSource>,
    /// Level from which columns of heights count: the base, or the sea for absolute heights of
    /// roofs, from which the terrain below or --base is taken [default: base]
    #[arg(long, value_name = "LEVEL", value_parser = choice::<HeightAbove>())]
    pub height_above: Option<HeightAbove>,
    /// Layer to read of a GeoPackage with several; may be given more than once [default: the layers
    /// of buildings by their names, else all]
    #[arg(long, value_name = "NAME")]
    pub layer: Vec<String>,
}

impl FootprintArgs {
    /// Returns the options of footprints.
    pub fn options(&self) -> FootprintOptions {
        FootprintOptions {
            height: self.height.clone(),
            storey_height_m: self.storey_height.map(|length| length.0),
            base: self.base.clone(),
            height_above: self.height_above,
            layer: self.layer.clone(),
        }
    }
}

/// Reflectances of surfaces, and whether ground is added.
#[derive(Args, Clone, Debug)]
pub struct MaterialsArgs {
    /// File of reflectances (TOML), one table for each material name. They replace those of the
    /// scene files; materials without a table keep their own values, or get usual ones
    #[arg(long, short)]
    pub materials: Option<PathBuf>,
    /// Ignore the materials of the scene files; --materials has to describe all of them
    #[arg(long)]
    pub materials_only: bool,
    /// Add no ground to a scene that has none [default: add a plane below it; for an EnergyPlus
    /// model, as the model states]
    #[arg(long)]
    pub no_ground: bool,
    /// Read EnergyPlus models as models of this version, whatever version they state; it decides
    /// what the fields of an IDF mean. With 25.2, `energyplus` accepts models of any version, for
    /// EnergyPlus 25.2 to run as they are
    #[arg(long, value_name = "VERSION")]
    pub assume_version: Option<ModelVersion>,
}

impl MaterialsArgs {
    /// Returns the scene request for files.
    pub fn request(&self, files: &[PathBuf]) -> SceneRequest {
        SceneRequest {
            files: files.to_vec(),
            materials: self.materials.clone(),
            materials_only: self.materials_only,
            no_ground: self.no_ground,
            assume_version: self.assume_version,
            ..SceneRequest::default()
        }
    }
}

/// Place, rotation and unit of a scene; each option counts more than the files.
#[derive(Args, Clone, Debug, Default)]
pub struct PlaceArgs {
    /// Coordinate reference system of the scene's coordinates, in metres: EPSG:28992 or 28992
    #[arg(long, value_name = "EPSG", value_parser = parse_crs)]
    pub crs: Option<u32>,
    /// Latitude of the scene, degrees, north positive; y is then true north, unless a coordinate
    /// system states otherwise
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, requires = "longitude", value_parser = parse_latitude)]
    pub latitude: Option<f64>,
    /// Longitude of the scene, degrees, east positive
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, requires = "latitude", value_parser = parse_longitude)]
    pub longitude: Option<f64>,
    /// Angle of the model's y axis from north, degrees, clockwise as seen from above (the north
    /// axis of EnergyPlus); coordinates stay
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = parse_rotation)]
    pub rotate_deg: Option<f64>,
    /// Height above sea level of z = 0, metres, for all files but terrain
    #[arg(long, value_name = "METRES", allow_negative_numbers = true, value_parser = parse_elevation)]
    pub elevation: Option<f64>,
    /// Metres per unit of all files but terrain: 0.001 for millimetres. 0.3048 and 0.3048006 (feet)
    /// also apply to terrain whose file does not state its unit
    #[arg(long, value_name = "METRES", value_parser = parse_scale)]
    pub scale: Option<f64>,
    /// The axis that points up in OBJ, PLY and STL files: z, with y to the north, or y, with z to
    /// the south [default: z]
    #[arg(long, value_name = "AXIS", value_parser = parse_up)]
    pub up: Option<UpAxis>,
}

/// Direction that azimuths in tables of points count from.
#[derive(Args, Debug)]
pub struct TableNorthArgs {
    /// Count azimuths in the table of points from the y axis, in place of true north
    #[arg(long)]
    pub grid_north: bool,
}

impl SceneArgs {
    /// Returns the request for a scene whose points come from a table.
    pub fn request_by(&self, north: &TableNorthArgs) -> SceneRequest {
        let mut request = self.request();
        request.frame.grid_north = north.grid_north;
        request
    }

    /// Returns the scene request.
    pub fn request(&self) -> SceneRequest {
        let (frame, footprints, surface) = (self.place.frame(), self.footprints.options(), self.rasters.request());
        SceneRequest { frame, footprints, surface, ..self.surfaces.request(&self.scene) }
    }

    /// Returns the files of the scene.
    pub fn site(&self) -> error::Result<SceneFiles> {
        self.request().site()
    }

    /// Returns the first file, which messages about the scene name.
    pub fn first(&self) -> &Path {
        self.scene.first().or(self.rasters.files().next()).map_or(Path::new(""), PathBuf::as_path)
    }
}

impl PlaceArgs {
    /// Returns the frame of the scene.
    pub fn frame(&self) -> SiteFrame {
        SiteFrame {
            epsg: self.crs,
            latitude_deg: self.latitude,
            longitude_deg: self.longitude,
            rotate_deg: self.rotate_deg,
            grid_north: false,
            elevation_m: self.elevation,
            scale: self.scale,
            up: self.up,
        }
    }
}

/// Parses `EPSG:28992`, `epsg:28992` or `28992`.
pub fn parse_crs(text: &str) -> Result<u32, String> {
    let upper = text.trim().to_ascii_uppercase();
    let digits = upper.strip_prefix("EPSG:").unwrap_or(&upper);
    let number = digits.parse().map_err(|_| "give the number of a system in the EPSG register, such as EPSG:28992")?;
    check_epsg(number)
}

fn parse_number(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| format!("`{text}` is not a number"))
}

pub fn parse_latitude(text: &str) -> Result<f64, String> {
    let degrees = parse_number(text)?;
    let hint = "give degrees from -90 to 90, north positive";
    if (-90.0..=90.0).contains(&degrees) { Ok(degrees) } else { Err(hint.into()) }
}

pub fn parse_longitude(text: &str) -> Result<f64, String> {
    let degrees = parse_number(text)?;
    let hint = "give degrees from -180 to 180, east positive";
    if (-180.0..=180.0).contains(&degrees) { Ok(degrees) } else { Err(hint.into()) }
}

fn parse_rotation(text: &str) -> Result<f64, String> {
    check_rotation(parse_number(text)?)
}

fn parse_elevation(text: &str) -> Result<f64, String> {
    check_elevation(parse_number(text)?)
}

fn parse_up(text: &str) -> Result<UpAxis, String> {
    match text.to_ascii_lowercase().as_str() {
        "y" => Ok(UpAxis::Y),
        "z" => Ok(UpAxis::Z),
        _ => Err("give y or z".into()),
    }
}

fn parse_scale(text: &str) -> Result<f64, String> {
    check_scale(parse_number(text)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three spellings of RD New are 28992. A system in degrees, an unknown one and a name are
    /// refused with a hint. Two axes may point up.
    #[test]
    fn three_spellings_name_one_system() {
        for text in ["28992", "EPSG:28992", " epsg:28992"] {
            assert_eq!(parse_crs(text), Ok(28992), "{text}");
        }
        for (text, word) in [("4326", "degrees"), ("EPSG:99999", "not known"), ("RD New", "such as EPSG:28992")] {
            assert!(parse_crs(text).expect_err(text).contains(word), "{text}");
        }
        for (text, axis) in [("y", Some(UpAxis::Y)), ("Z", Some(UpAxis::Z)), ("x", None)] {
            assert_eq!(parse_up(text).ok(), axis, "{text}");
        }
        assert!(parse_latitude("91").is_err() && parse_longitude("-180.5").is_err() && parse_scale("nan").is_err());
    }
}
