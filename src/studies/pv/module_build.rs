//! Build of modules in their scene. In: laid rows or points, a scene. Out: the archive of their
//! receivers, or those of trackers at each traced angle.

use std::fs;
use std::path::{Path, PathBuf};

use super::folder::PvFolder;
use super::ground::GroundSpot;
use super::modules::LaidRows;
use super::request::PvRequest;
use super::spots::Spots;
use crate::site_build::{FolderOption, SiteBuild, SiteFolder};
use heliotile_builder::siting::Siting;
use heliotile_core::archive::Archive;
use heliotile_core::error::{Error, Result};
use heliotile_core::observer::{Observer, Tone};
use heliotile_core::site::north::North;
use heliotile_core::text::Message;
use heliotile_files::writing::copy::folder_of;
use heliotile_results::resources::Resources;
use heliotile_scene::Scene;
use heliotile_scene::points::receivers::ReceiverCsv;
use heliotile_scene::pv::tracker::Tracker;
use heliotile_scene::site::SceneFiles;

/// Observer of the build of one of several angles, whose warnings are those of level modules.
struct Unwarned<'a>(&'a dyn Observer);

impl Observer for Unwarned<'_> {
    fn begin(&self, stage: &'static str, items: Option<u64>) {
        self.0.begin(stage, items);
    }

    fn advance(&self, stage: &'static str, items: u64) {
        self.0.advance(stage, items);
    }

    fn end(&self, stage: &'static str) {
        self.0.end(stage);
    }

    fn tell(&self, tone: Tone, message: Message) {
        if tone != Tone::Warning {
            self.0.tell(tone, message);
        }
    }

    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

/// How modules are traced.
#[derive(Clone, Copy)]
pub struct ModuleBuild<'a> {
    pub request: &'a PvRequest,
    pub site: &'a SceneFiles,
    /// Scene without modules.
    pub scene: &'a Scene,
    pub files: &'a PvFolder,
    pub resources: &'a Resources<'a>,
    pub north: North,
    pub observer: &'a dyn Observer,
}

impl ModuleBuild<'_> {
    /// Returns the archives of trackers, one for each of their angles. The files of level modules
    /// go to `beside`.
    pub fn trace_angles(
        &self,
        tracker: Tracker,
        laid: &LaidRows,
        siting: &Siting,
        beside: &Path,
    ) -> Result<Vec<Archive>> {
        let unwarned = Unwarned(self.observer);
        let others = beside.join("angle");
        fs::create_dir_all(&others).map_err(Error::io(&others, "create"))?;
        let angle = |(angle_deg, archive): (f64, &PathBuf)| {
            let turned = laid.at(angle_deg);
            let spots = Spots::of_modules(turned.modules(), siting);
            let (build, beside) = match angle_deg {
                0.0 => (*self, beside),
                _ => (ModuleBuild { observer: &unwarned, ..*self }, others.as_path()),
            };
            build.trace(&spots, &[], Some(&turned), archive, beside)
        };
        tracker.angles_deg().into_iter().zip(&self.files.archives).map(angle).collect()
    }

    /// Returns the archive of modules, which shade and reflect: they are part of the traced scene.
    /// Their files and the receivers go to `beside`.
    pub fn trace(
        &self,
        spots: &Spots,
        ground: &[GroundSpot],
        laid: Option<&LaidRows>,
        archive: &Path,
        beside: &Path,
    ) -> Result<Archive> {
        let with_modules = match laid {
            Some(laid) => {
                let mut site = self.site.clone();
                laid.add_to(&mut site, beside)?;
                Some(Scene::load_site(&site)?)
            }
            None => None,
        };
        let traced = with_modules.as_ref().unwrap_or(self.scene);
        let receivers = spots.write_receivers(ground, beside, self.north)?;
        let accuracy = self.request.accuracy();
        let Resources { memory, files, .. } = *self.resources;
        // Messages about receivers name the user's file.
        let text = fs::read(&receivers).map_err(Error::io(&receivers, "read"))?;
        let receivers = ReceiverCsv::Text { name: self.request.modules_file(), text: &text };
        let build = SiteBuild { memory, files, ..SiteBuild::new(traced, receivers, &accuracy) };
        let parent = folder_of(archive);
        fs::create_dir_all(parent).map_err(Error::io(parent, "create"))?;
        let folder = SiteFolder {
            folder: &self.files.folder,
            archive,
            replace: self.request.replace,
            named_by: FolderOption::Output,
        };
        build.ensure(&folder, self.observer)
    }
}
