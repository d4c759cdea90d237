//! Options of readers. In: what is wanted of a file. Out: answers to readers, names of files.

use std::collections::BTreeSet;
use std::path::Path;

use crate::footprint_options::FootprintOptions;
use crate::geocentric::LocalFrame;
use crate::model_version::ModelVersion;

/// Options of a reader: how to read a file, and which parts of it besides the geometry.
#[derive(Clone, Debug, Default)]
pub(crate) struct ReadOptions {
    /// True if the materials that the file itself describes are wanted.
    pub reflectances: bool,
    /// Names of the materials that the user describes elsewhere: their description in the file is
    /// ignored.
    pub described: BTreeSet<String>,
    /// Level of detail to read where an object has several; `None` for the finest.
    pub lod: Option<String>,
    /// Origin of the local metres that replace geocentric coordinates: the frame of an earlier
    /// geocentric file of the scene, if there is one.
    pub local_frame: Option<LocalFrame>,
    /// EPSG number of the plane system that longitudes and latitudes are projected to: the system
    /// of the scene, if it has one yet.
    pub system: Option<u32>,
    /// Source of the heights of footprints.
    pub footprints: FootprintOptions,
    /// Version of EnergyPlus to read models as, whatever version they state.
    pub assume_version: Option<ModelVersion>,
}

impl ReadOptions {
    /// Returns true if the file's own description of `material` is wanted.
    pub(super) fn wants(&self, material: &str) -> bool {
        self.reflectances && !self.described.contains(material)
    }
}

/// Returns the name of a file without its folder and endings, which names objects that have no
/// name.
pub(crate) fn stem(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.split('.').find(|part| !part.is_empty()).unwrap_or("scene").to_owned()
}
