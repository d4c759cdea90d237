//! Light on a surface with nothing around it. In: orientations, the ground below, the replay of an
//! archive. Out: sums on an endless plain of that ground with an open horizon, traced as the site
//! is, with its settings.

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;

use super::aside::trace_aside;
use heliotile_builder::pipeline::PreparedScene;
use heliotile_builder::settings::BuildSettings;
use heliotile_core::archive::Archive;
use heliotile_core::error::Result;
use heliotile_core::observer::Observer;
use heliotile_core::orientation::fan::Orientation;
use heliotile_core::site::material::{Class, Material};
use heliotile_core::site::north::North;
use heliotile_core::site::receiver::Receiver;
use heliotile_scene::Scene;

/// Half the side of the plain, metres. Seen from 1 m above it, its rim is 0.003 degrees below the
/// horizon.
pub(super) const HALF_M: f64 = 20_000.0;

/// Orientation above a ground: index of the material, and the bits of the normal.
type Key = (Option<u16>, [u64; 3]);

/// Sums on open plains, of the type that a replay gives.
pub struct OpenPlain<'a, T> {
    scene: &'a Scene,
    settings: BuildSettings,
    folder: &'a Path,
    known: HashMap<Key, T>,
}

fn key(ground: Option<u16>, turn: Orientation) -> Key {
    (ground, turn.normal().to_array().map(f64::to_bits))
}

impl<'a, T: Clone + Default> OpenPlain<'a, T> {
    /// Prepares plains with the settings of the site's archive; `folder` holds temporary files.
    pub fn new(scene: &'a Scene, archive: &Archive, folder: &'a Path) -> Self {
        let settings = BuildSettings::of(&archive.manifest().settings);
        OpenPlain { scene, settings, folder, known: HashMap::new() }
    }

    /// Traces orientations above their grounds and keeps the sums that `replayed` returns by
    /// receiver. Without a ground the plain is black.
    pub fn learn(
        &mut self,
        wanted: impl Iterator<Item = (Option<u16>, Orientation)>,
        replayed: impl Fn(&Archive) -> Result<HashMap<String, T>>,
        observer: &dyn Observer,
    ) -> Result<()> {
        let mut of_ground: HashMap<Option<u16>, HashMap<[u64; 3], DVec3>> = HashMap::new();
        for (ground, turn) in wanted {
            let (_, bits) = key(ground, turn);
            of_ground.entry(ground).or_default().insert(bits, turn.normal());
        }
        for (ground, normals) in of_ground {
            let plain = self.plain(ground)?;
            let north = North::new(plain.place.as_ref());
            let all: Vec<([u64; 3], DVec3)> = normals.into_iter().collect();
            let receiver = |(i, (_, normal)): (usize, &([u64; 3], DVec3))| {
                Receiver::new(i.to_string(), DVec3::Z, north.to_axes(*normal))
            };
            let receivers: Vec<Receiver> = all.iter().enumerate().map(receiver).collect();
            let prepared = PreparedScene::new(&plain)?;
            let traced = trace_aside(&prepared, &receivers, &self.settings, self.folder, observer)?;
            for (id, sums) in replayed(traced.archive())? {
                let found = id.parse::<usize>().ok().and_then(|i| all.get(i));
                if let Some((bits, _)) = found {
                    self.known.insert((ground, *bits), sums);
                }
            }
        }
        Ok(())
    }

    /// Returns the sums of an orientation that [`OpenPlain::learn`] traced.
    pub fn sums(&self, ground: Option<u16>, turn: Orientation) -> T {
        self.known.get(&key(ground, turn)).cloned().unwrap_or_default()
    }

    /// Returns an endless plain of a material at the place of the scene.
    pub fn plain(&self, ground: Option<u16>) -> Result<Scene> {
        plain(self.scene, ground)
    }
}

/// Returns an endless plain of a scene's ground at the scene's place.
pub fn plain(scene: &Scene, ground: Option<u16>) -> Result<Scene> {
    let stated = ground.and_then(|ground| scene.materials.get(usize::from(ground))).cloned();
    let material = stated.unwrap_or_else(|| Material::matt("ground", 0.0, Class::Ground));
    let corner = |x: f64, y: f64| DVec3::new(x * HALF_M, y * HALF_M, 0.0);
    let [a, b, c, d] = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let plain = Scene::from_triangles(&[([a, b, c], 0), ([a, c, d], 0)], vec![material])?;
    Ok(Scene { place: scene.place, ground: scene.ground.clone(), ..plain })
}
