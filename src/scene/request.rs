//! A scene as it is asked for. In: files, and what is said of them. Out: one value that can be kept and read again, and the site of it.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::footprint_options::FootprintOptions;
use crate::model_version::ModelVersion;
use crate::placing::frame::SiteFrame;
use crate::site::{MissingGround, Part, Site};
use crate::surface_rasters::SurfaceRasters;
use heliotile_core::error::{Error, Result};

/// Files that make up a scene, and what is said of them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneRequest {
    /// Scene files, or one list of them.
    pub files: Vec<PathBuf>,
    /// Reflectances by the names of materials; they win over those that the files state.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub materials: Option<PathBuf>,
    /// Whether `materials` names all of them, and what the files state is passed over.
    #[serde(default)]
    pub materials_only: bool,
    /// Whether a scene without ground stays without.
    #[serde(default)]
    pub no_ground: bool,
    /// Version of EnergyPlus that models are taken for; none: the one that they state.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub assume_version: Option<ModelVersion>,
    /// Where heights of footprints come from, unless a list of files says it.
    #[serde(default, skip_serializing_if = "FootprintOptions::is_default")]
    pub footprints: FootprintOptions,
    /// Where the scene lies, how it is turned, and the unit of its files.
    #[serde(default)]
    pub frame: SiteFrame,
    /// Rasters that a city is read from, besides the files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<SurfaceRasters>,
}

impl SceneRequest {
    /// Files of which nothing else is said.
    pub fn of<P: AsRef<Path>>(files: impl IntoIterator<Item = P>) -> Self {
        let files = files.into_iter().map(|file| file.as_ref().to_owned()).collect();
        SceneRequest { files, ..SceneRequest::default() }
    }

    /// The files of the scene as a site. An error: a number that is not in range, a list that cannot be read.
    pub fn site(&self) -> Result<Site> {
        let hint = "give what the scene's coordinates are in";
        self.frame.check().map_err(|(field, what)| Error::argument(field, what, hint))?;
        self.footprints.check().map_err(|(field, what)| Error::argument(field, what, "give metres above 0"))?;
        let mut site = Site::of(&self.files, self.materials.as_deref())?;
        if let Some(rasters) = &self.surface {
            rasters.check().map_err(|(field, what)| Error::argument(field, what, "give a value in that range"))?;
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

    /// The first file, which messages about the scene are about.
    pub fn first(&self) -> &Path {
        let raster = self.surface.as_ref().map(|rasters| &rasters.dsm);
        self.files.first().or(raster).map_or(Path::new(""), PathBuf::as_path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A request is read again as it was written, with 3 of its 7 fields in 1 object each; what is not known is refused.
    #[test]
    fn requests_are_kept() {
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
