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

/// Request for a scene: its files, and statements about them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneRequest {
    /// Scene files, or `site.toml` files that list them.
    pub files: Vec<PathBuf>,
    /// File of optics by the names of materials; they take precedence over those that the scene
    /// files state.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub materials: Option<PathBuf>,
    /// True if `materials` names all of them and the scene files' own descriptions are ignored.
    #[serde(default)]
    pub materials_only: bool,
    /// True if no ground is assumed for a scene without ground.
    #[serde(default)]
    pub no_ground: bool,
    /// Version of EnergyPlus that is assumed for models; `None`: the version that each model
    /// states.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub assume_version: Option<ModelVersion>,
    /// Sources of the heights of footprints, unless a list of files states them.
    #[serde(default, skip_serializing_if = "FootprintOptions::is_default")]
    pub footprints: FootprintOptions,
    /// Place and rotation of the scene, and unit of its files.
    #[serde(default)]
    pub frame: SiteFrame,
    /// Rasters that a city is read from, besides the files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<SurfaceRasters>,
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
        let mut site = SceneFiles::of(&self.files, self.materials.as_deref())?;
        if let Some(rasters) = &self.surface {
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
        let raster = self.surface.as_ref().map(|rasters| &rasters.dsm);
        self.files.first().or(raster).map_or(Path::new(""), PathBuf::as_path)
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
