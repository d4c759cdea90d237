//! Request for a scene. In: files, and statements about them. Out: one value that can be stored and
//! read again, and the site that it describes.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::footprint_options::FootprintOptions;
use crate::model_version::ModelVersion;
use crate::placing::frame::SiteFrame;
use crate::site::{MissingGround, Part, SceneFiles};
use crate::surface_rasters::SurfaceRasters;
use heliotile_core::error::{Error, Result};
use heliotile_requests::Request;

/// Request for a scene: its files, and statements about them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, Request)]
#[serde(deny_unknown_fields)]
#[request(any_of("scene", "dsm", "dem", "canopy", "landcover"))]
pub struct SceneRequest {
    /// Scene files, merged into one scene, or a site.toml that lists them: CityJSON (.city.json,
    /// .city.jsonl, .cityjson), CityGML (.gml, .xml, or a folder of tiles), footprints (.geojson,
    /// .shp, .gpkg, .parquet), terrain (.tif, .asc, .dem), EnergyPlus (.epjson, .idf), Honeybee
    /// (.hbjson), glTF (.gltf, .glb), .obj, .ply, .stl; also packed (.gz, .zip). Coordinates are
    /// metres, x east, y north, z up; footprints and CityGML may be in degrees.
    #[field(name = "scene", positional, metavar = "SCENE", input = Scene)]
    pub files: Vec<PathBuf>,
    /// File of reflectances (TOML), one table for each material name. They replace those of the
    /// scene files; materials without a table keep their own values, or get usual ones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[field(short = 'm', input = Any)]
    pub materials: Option<PathBuf>,
    /// Ignore the materials of the scene files; --materials has to describe all of them.
    #[serde(default)]
    pub materials_only: bool,
    /// Add no ground to a scene that has none [default: add a plane below it; for an EnergyPlus
    /// model, as the model states].
    #[serde(default)]
    pub no_ground: bool,
    /// Read EnergyPlus models as models of this version, whatever version they state; it decides
    /// what the fields of an IDF mean. With 25.2, `energyplus` accepts models of any version, for
    /// EnergyPlus 25.2 to run as they are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[field(metavar = "VERSION")]
    pub assume_version: Option<ModelVersion>,
    /// Sources of the heights of footprints, unless a list of files states them.
    #[serde(default, skip_serializing_if = "FootprintOptions::is_default")]
    #[field(flatten)]
    pub footprints: FootprintOptions,
    /// Place and rotation of the scene, and unit of its files.
    #[serde(default)]
    #[field(flatten)]
    pub frame: SiteFrame,
    /// Rasters that a city is read from, besides the files.
    #[serde(default, skip_serializing_if = "SurfaceRasters::is_none")]
    #[field(flatten)]
    pub surface: SurfaceRasters,
}

impl SceneRequest {
    /// Returns a request for files, with nothing else stated.
    pub fn of<P: AsRef<Path>>(files: impl IntoIterator<Item = P>) -> Self {
        let files = files.into_iter().map(|file| file.as_ref().to_owned()).collect();
        SceneRequest { files, ..SceneRequest::default() }
    }

    /// Returns the site of the files. Fails if a number is out of range or a list cannot be read.
    pub fn site(&self) -> Result<SceneFiles> {
        let hint = "state the coordinate system, place or unit of the scene's coordinates";
        self.frame.check().map_err(|(field, what)| Error::argument(field, what, hint))?;
        self.footprints.check().map_err(|(field, what)| Error::argument(field, what, "give metres above 0"))?;
        let mut site = SceneFiles::new(&self.files, self.materials.as_deref())?;
        if let Some(rasters) = &self.surface.settled() {
            let hint =
                if rasters.dsm.as_os_str().is_empty() { SurfaceRasters::NEEDED } else { "give a value in that range" };
            rasters.check().map_err(|(field, what)| Error::argument(field, what, hint))?;
            site.parts.push(Part::surface(rasters, self.materials.as_deref()));
        }
        if !self.no_ground {
            site.missing_ground = MissingGround::Assume;
        }
        for part in &mut site.parts {
            part.materials_only |= self.materials_only;
            part.assume_version = self.assume_version.or(part.assume_version);
            part.footprints = part.footprints.or(&self.footprints);
        }
        Ok(site.framed(&self.frame))
    }

    /// Returns the first file, which stands for the scene in messages.
    pub fn first(&self) -> &Path {
        let raster = self.surface.all().next();
        self.files.first().map(PathBuf::as_path).or(raster).unwrap_or(Path::new(""))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A request with 3 of its 8 fields set is read back as it was written; an unknown field is
    /// refused.
    #[test]
    fn a_request_is_read_as_it_was_written() {
        let request = SceneRequest {
            files: vec!["town.city.json".into()],
            assume_version: ModelVersion::parse("9.6"),
            frame: SiteFrame { epsg: Some(28992), ..SiteFrame::default() },
            ..SceneRequest::default()
        };
        let text = serde_json::to_string(&request).expect("JSON");
        assert_eq!(serde_json::from_str::<SceneRequest>(&text).expect("a request"), request);
        assert!(text.contains("\"assume_version\":\"9.6\"") && text.contains("\"frame\":{\"epsg\":28992}"), "{text}");
        assert!(serde_json::from_str::<SceneRequest>("{\"files\": [], \"colour\": 1}").is_err());
    }
}
