//! The scene that an archive was built from. In: an archive, the files of its scene. Out: that
//! scene with the archive's place, or an error if the files hold another scene.

use std::path::Path;

use heliotile_core::archive::{Archive, format};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::observer::Observer;
use heliotile_scene::Scene;
use heliotile_scene::placing::frame::SiteFrame;
use heliotile_scene::request::SceneRequest;
use heliotile_scene::site::{MissingGround, SceneFiles};

/// Returns the site of the scene's files. Its place is stated by the archive, so options must not
/// state one.
pub(super) fn site_of(archive: &Path, scene: &SceneRequest) -> Result<SceneFiles> {
    let stated = SiteFrame { elevation_m: None, scale: None, up: None, grid_north: false, ..scene.frame };
    if stated != SiteFrame::default() {
        let hint = "leave {crs}, {latitude}, {longitude} and {rotate_deg} out";
        return Err(Error::input(archive, None, "keeps the place that was stated when it was built", hint)
            .because(Problem::other_kind("archive")));
    }
    let mut site = scene.site()?;
    // A turn in a list of files needs a place, which an option may have stated at the build.
    site.frame.rotate_deg = None;
    Ok(site)
}

/// Loads the scene of an archive from its files; refuses another scene.
pub(super) fn scene_of(archive: &Archive, site: &SceneFiles, first: &Path, observer: &dyn Observer) -> Result<Scene> {
    let expected = &archive.manifest().scene.content_hash;
    let hash = |scene: &Scene| format::hex(&scene.content_hash());
    let mut scene = load(site, observer)?;
    if hash(&scene) != *expected {
        // The archive may have been built without assumed ground, or by a release that assumed
        // none.
        let plain = SceneFiles { missing_ground: MissingGround::LeaveOut, ..site.clone() };
        scene = Some(Scene::load_site(&plain)?).filter(|plain| hash(plain) == *expected).unwrap_or(scene);
    }
    let found = hash(&scene);
    if found != *expected {
        let what = format!("is not the scene of the archive: its hash is {found}, that of the archive {expected}");
        let hint = "give the scene and the materials that the archive was built from";
        return Err(Error::input(first, None, what, hint).because(Problem::OtherInputs));
    }
    // Place and ground are not part of the content hash: options may have stated the place, another
    // file the ground by month.
    scene.place = archive.manifest().place;
    scene.ground.clone_from(&archive.manifest().ground);
    Ok(scene)
}

/// Loads the scene without its note on the direction of north, which the archive states.
fn load(site: &SceneFiles, observer: &dyn Observer) -> Result<Scene> {
    let mut scene = Scene::load_site(site)?;
    let north = scene.place.and_then(|place| place.note());
    scene.report.notes.retain(|note| north.as_ref().is_none_or(|north| !note.contains(north)));
    scene.report.tell(observer);
    Ok(scene)
}
