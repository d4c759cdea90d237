//! The scene that an archive was built from. In: an archive, the files of its scene. Out: the scene as the archive knows it, or an error that
//! says that it is another one.

use std::path::Path;

use heliotile_core::archive::{Archive, format};
use heliotile_core::error::{Error, Result};
use heliotile_core::observer::Observer;
use heliotile_scene::Scene;
use heliotile_scene::placing::frame::SiteFrame;
use heliotile_scene::request::SceneRequest;
use heliotile_scene::site::{MissingGround, Site};

/// The files of the scene of an archive; where they lie the archive says.
pub(super) fn site_of(archive: &Path, scene: &SceneRequest) -> Result<Site> {
    let stated = SiteFrame { elevation_m: None, scale: None, up: None, ..scene.frame };
    if stated != SiteFrame::default() {
        let hint = "leave {crs}, {latitude}, {longitude} and {rotate_deg} out";
        return Err(Error::input(archive, None, "keeps the place that was stated when it was built", hint));
    }
    let mut site = scene.site()?;
    // A turn that a list of files states needs a place, which an option may have stated.
    site.frame.rotate_deg = None;
    Ok(site)
}

/// The scene of an archive, of these files.
pub(super) fn scene_of(archive: &Archive, site: &Site, first: &Path, observer: &dyn Observer) -> Result<Scene> {
    let expected = &archive.manifest().scene.content_hash;
    let hash = |scene: &Scene| format::hex(&scene.content_hash());
    let mut scene = load(site, observer)?;
    if hash(&scene) != *expected {
        // It may have been built without assumed ground, or before ground was assumed.
        let plain = Site { missing_ground: MissingGround::LeaveOut, ..site.clone() };
        scene = Some(Scene::load_site(&plain)?).filter(|plain| hash(plain) == *expected).unwrap_or(scene);
    }
    let found = hash(&scene);
    if found != *expected {
        let what = format!("is not the scene of the archive: its hash is {found}, that of the archive {expected}");
        let hint = "give the scene and the materials that the archive was built from";
        return Err(Error::input(first, None, what, hint));
    }
    // No part of the scene's content: the place may have been stated by options, the ground of months in another file.
    scene.place = archive.manifest().place;
    scene.ground.clone_from(&archive.manifest().ground);
    Ok(scene)
}

/// The scene, without a word on where north is: that is as the archive has it.
fn load(site: &Site, observer: &dyn Observer) -> Result<Scene> {
    let mut scene = Scene::load_site(site)?;
    let north = scene.place.and_then(|place| place.note());
    scene.report.notes.retain(|note| Some(note) != north.as_ref());
    scene.report.tell(observer);
    Ok(scene)
}
