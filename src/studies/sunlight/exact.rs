//! Exact moments of the sun at edges within a texel. In: the spells that a texture gives for a day,
//! rays of the scene. Out: spells whose uncertain parts are decided by rays.

use glam::DVec3;
use rayon::prelude::*;

use heliotile_builder::held::held_scene;
use heliotile_core::archive::format::TileNumber;
use heliotile_core::archive::{Archive, format};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_scene::Scene;
use heliotile_sunlight::{Spells, SunDay, SunSeen};

/// Minutes between rays near edges.
pub const EDGE_STEP_MIN: f64 = 0.1;

/// Minutes between rays towards mirrors.
pub const MIRROR_STEP_MIN: f64 = 0.25;

/// Number of bisections of these steps: moments are found to a quarter of a second.
const BISECTIONS: usize = 6;

/// Returns the scene that an archive was traced from. Fails if the archive does not hold it.
pub fn scene_of(archive: &Archive) -> Result<Scene> {
    if !archive.has(format::SCENE, TileNumber::FIRST) {
        let what = "the archive does not hold its scene, so no ray can be cast";
        let hint = "build it again without {no_scene}; {exact}, {spells}, {panes}, calendars and \
                    {command:envelope} need the scene";
        return Err(Error::input(archive.path(), None, what, hint).because(Problem::Lacks("scene")));
    }
    let held = held_scene(archive)?;
    let origin = held.grid.origin;
    let place = |corners: &[DVec3; 3]| corners.map(|corner| origin + corner);
    let triangles: Vec<([DVec3; 3], u16)> = held.triangles.par_iter().map(place).zip(held.triangle_material).collect();
    Scene::from_objects(&triangles, held.materials, &held.objects, None)
}

/// Returns the spells in which the sun is seen on a day. Where the texture is uncertain, rays are
/// cast `step_min` minutes apart; `sees` returns which of some suns a receiver sees.
pub fn refined(seen: &SunSeen, day: &SunDay, step_min: f64, sees: impl Fn(&[DVec3]) -> Vec<bool>) -> SunSeen {
    let mut by_rays = Spells::default();
    for doubt in seen.possible.without(&seen.sure).iter() {
        let steps = (doubt.minutes() / step_min).ceil().max(1.0) as usize;
        let moment = |step: usize| doubt.start_min + doubt.minutes() * step as f64 / steps as f64;
        let suns: Vec<DVec3> = (0..=steps).map(|step| day.sun(moment(step))).collect();
        let lit = sees(&suns);
        let mut since = doubt.start_min;
        for (step, two) in lit.windows(2).enumerate() {
            if two[0] == two[1] {
                continue;
            }
            let (mut low, mut high) = (moment(step), moment(step + 1));
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (low + high);
                let is_as_before = sees(&[day.sun(middle)]) == [two[0]];
                if is_as_before { low = middle } else { high = middle }
            }
            let change = 0.5 * (low + high);
            if two[0] {
                by_rays.push(since, change);
            }
            since = change;
        }
        if lit.last() == Some(&true) {
            by_rays.push(since, doubt.end_min);
        }
    }
    SunSeen::certain(seen.sure.and(&by_rays))
}
