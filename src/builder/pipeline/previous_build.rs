//! Reuse of an archive of the scene before it was changed (`build --from`). In: that archive, the
//! scene as it is now. Out: layers of receivers and cells that the change leaves as they were, to
//! the bit, because they depend only on rays that meet no added or removed triangle.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::layer_cache::{Earlier, KnownReceiver, whole_cells};
use super::mirrors::around_cell;
use super::prepared::PreparedScene;
use super::report::ReusedCounts;
use super::site_tracer::SiteTracer;
use crate::held::{check_scene, held_scene};
use crate::settings::{BuildSettings, Effect};
use crate::trace::Ray;
use crate::trace::change::{Change, ChangeInView, KnownSky};
use crate::trace::hidden::may_be_lit_since;
use crate::trace::probe::{Directions, known_probe, sky_rays};
use crate::trace::receiver::{HitTrace, SkyTrace};
use crate::trace::sky_fans::SkyFans;
use crate::trace::surroundings::{looks_around, may_cast, may_see};
use crate::trace::viewpoint::Viewpoint;
use heliotile_core::archive::Archive;
use heliotile_core::archive::format::CellKind;
use heliotile_core::error::Result;
use heliotile_core::layers::cells::Cell;
use heliotile_core::observer::Observer;
use heliotile_core::opened::OpenSite;
use heliotile_core::site::cells::CellKey;
use heliotile_core::site::material::Material;
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::counted;
use heliotile_scene::change::SceneChange;

/// Length of a mean of unit normals from which on the surface counts as plane.
const PLANE: f64 = 1.0 - 1e-6;

/// Number of cells per triangle from which on it pays to find out which backs of triangles may have
/// become lit or dark. With fewer cells, the search costs more than tracing the doubtful cells
/// again. Chosen by timing both on a tile of The Hague.
const CELLS_A_TRIANGLE: u64 = 3;

/// Archive of the scene before, and the change since.
pub(super) struct PreviousBuild<'a> {
    pub file: &'a Archive,
    pub archive: Earlier<'a>,
    pub change: Change,
    /// True if materials have the same numbers as in the archive.
    pub same_numbers: bool,
    /// True if all materials that remain have the same class.
    pub same_classes: bool,
    /// True if canopies were added or removed.
    pub of_canopies: bool,
    /// Change together with the triangles whose backs may have become lit or dark, which doubtful
    /// cells depend on. `None` if finding these would cost more than tracing the doubtful cells.
    in_doubt: Option<Change>,
    /// `[material now]`: its number in the archive.
    number_then: Vec<Option<u16>>,
    /// `[material in the archive]`: its number now.
    number_now: Vec<Option<u16>>,
    pub receivers: AtomicU64,
    pub cells: [AtomicU64; 2],
}

impl<'a> PreviousBuild<'a> {
    /// Compares an archive with a scene. Warns and returns `None` if nothing of the archive can be
    /// used. Fails if the archive is damaged or does not hold its scene.
    pub fn open(
        archive: &'a Archive,
        ready: &PreparedScene,
        settings: &BuildSettings,
        observer: &dyn Observer,
    ) -> Result<Option<Self>> {
        let scene = ready.scene;
        check_scene(archive)?;
        let useless =
            |why: &str| observer.warn(format!("{}: {why}: nothing of it is reused", archive.path().display()));
        if archive.manifest().settings.hash()? != settings.hash()? {
            let differ = archive.manifest().settings.differences(&settings.stated())?;
            useless(&format!("it was built with other settings ({})", differ.join("; ")));
            return Ok(None);
        }
        let traced = held_scene(archive)?;
        let Some(found) = SceneChange::between(&traced, scene) else {
            useless("the scene has another size or centre, so its coordinates are stored in another frame");
            return Ok(None);
        };
        if found.removed.len() == traced.triangles.len() {
            useless("none of its triangles is in the scene");
            return Ok(None);
        }
        observer.note(&match found.is_empty() {
            true => format!("{}: every triangle of the scene is the same", archive.path().display()),
            false => format!(
                "{}: {} of its {} were removed, {} added",
                archive.path().display(),
                counted(found.removed.len() as u64, "triangle"),
                traced.triangles.len(),
                found.added.len()
            ),
        });
        let mut number_then = vec![None; scene.materials.len()];
        for (then, now) in (0..).zip(&found.renumbered) {
            if let Some(place) = now.and_then(|now| number_then.get_mut(usize::from(now))) {
                *place = Some(then);
            }
        }
        let mut change = Change::new(&found, scene);
        let archive_cells = archive.manifest().counts.probes + archive.manifest().counts.bounce_cells;
        let pays = CELLS_A_TRIANGLE * scene.mesh.triangles.len() as u64 <= archive_cells;
        // The search is skipped if nothing changed, and if light may go by way of mirrors.
        let in_doubt = (pays && !found.is_empty() && !ready.reflects(settings)).then(|| {
            let all = 0..scene.mesh.triangles.len() as u32;
            let since = |&triangle: &u32| may_be_lit_since(&change, triangle, &scene.mesh, &ready.tracer);
            let doubted: Vec<u32> = all.into_par_iter().filter(since).collect();
            Change::with(&found, &doubted, scene)
        });
        if ready.reflects(settings) {
            // A change may show behind any mirror, wherever the change is.
            let mirrors = ready.mirrors.triangles().map(|triangle| scene.mesh.triangle_points(triangle as usize));
            change = change.near_to(mirrors);
        }
        let same = |of: fn(&Material) -> u8| {
            let then = traced.materials.iter().zip(&found.renumbered);
            let now = |number: &Option<u16>| number.and_then(|number| scene.materials.get(usize::from(number)));
            then.filter_map(|(then, number)| Some((then, now(number)?))).all(|(then, now)| of(then) == of(now))
        };
        let same_classes = same(|material| material.class.code());
        let numbers = found.renumbered.iter().copied().eq((0..scene.materials.len() as u16).map(Some));
        Ok(Some(PreviousBuild {
            file: archive,
            archive: Earlier::open(OpenSite::open(archive)?),
            same_numbers: numbers,
            same_classes,
            of_canopies: found.of_canopies,
            change,
            in_doubt,
            number_then,
            number_now: found.renumbered,
            receivers: AtomicU64::new(0),
            cells: Default::default(),
        }))
    }

    /// Returns the layers that the archive holds for the receivers of a tile, in their order;
    /// `None` for other receivers.
    pub fn receivers(&self, tile: &[Receiver]) -> Vec<Option<KnownReceiver>> {
        let mut found: Vec<Option<KnownReceiver>> = tile.iter().map(|_| None).collect();
        self.archive.fill(tile, &mut found);
        found
    }

    /// Returns the numbers of receivers and cells kept so far.
    pub fn reused(&self) -> ReusedCounts {
        let [probes, bounce_cells] = self.cells.each_ref().map(|count| count.load(Ordering::Relaxed));
        ReusedCounts { receivers: self.receivers.load(Ordering::Relaxed), probes, bounce_cells }
    }

    /// Returns a cell's key with the number that its material has now; `None` if the material is
    /// gone.
    pub fn now(&self, key: CellKey) -> Option<CellKey> {
        let material = self.number_now.get(usize::from(key.material)).copied().flatten()?;
        Some(CellKey { material, ..key })
    }

    /// Returns the cells of some keys that the archive holds, with the present numbers of
    /// materials.
    fn cells(&self, kind: CellKind, keys: &[CellKey]) -> Vec<Cell> {
        let Some(source) = self.archive.source(kind) else { return Vec::new() };
        let then = |key: &CellKey| {
            let material = self.number_then.get(usize::from(key.material)).copied().flatten()?;
            Some(CellKey { material, ..*key })
        };
        let keys: Vec<CellKey> = keys.iter().filter_map(then).collect();
        // Materials are in the same order as before, so keys stay sorted.
        whole_cells(source, &keys).into_iter().filter_map(|cell| self.renumbered(cell)).collect()
    }

    /// Returns a cell with the present numbers of materials; `None` if one of its materials is
    /// gone.
    pub fn renumbered(&self, cell: Cell) -> Option<Cell> {
        let seen = |(up, key): &(bool, Option<CellKey>)| match key {
            Some(key) => self.now(*key).map(|key| (*up, Some(key))),
            None => Some((*up, None)),
        };
        let number = |material: u16| self.number_now.get(usize::from(material)).copied().flatten();
        Some(Cell {
            key: self.now(cell.key)?,
            seen: cell.seen.iter().map(seen).collect::<Option<_>>()?,
            canopy: cell.canopy.renumbered(number)?,
            ..cell
        })
    }

    /// Returns the directions of the change as seen from a receiver.
    pub fn seen(&self, view: &Viewpoint, at: &SiteTracer) -> ChangeInView {
        let origin = DVec3::from(view.origin(at.tracer).map(f64::from));
        self.change.seen_from(origin, 0.0).before(view.normal)
    }

    /// Traces the sky of a receiver, with rays only where the change may show.
    pub fn sky(
        &self,
        view: &Viewpoint,
        known: &KnownReceiver,
        seen: &ChangeInView,
        fans: &SkyFans,
        at: &SiteTracer,
    ) -> SkyTrace {
        let touched = view.parts_towards(seen, fans);
        if !touched.contains(&true) {
            return SkyTrace { texture: known.sky.clone(), bits: known.dense.clone(), rays: 0 };
        }
        let answers = known.sky.answers();
        let known = KnownSky { answers: &answers, change: &self.change, touched: &touched };
        view.sky_after(fans, at.tracer, Some(known))
    }

    /// Returns true if a hit ray of a receiver hits something else than before.
    pub fn alters_hits(&self, view: &Viewpoint, seen: &ChangeInView, at: &SiteTracer) -> bool {
        self.change.alters(&towards(seen, view.hit_rays(at.settings.hit, at.tracer)), at.tracer)
    }

    /// Returns the known hits of a receiver if none of its rays meets the change.
    pub fn hits(
        &self,
        view: &Viewpoint,
        known: &KnownReceiver,
        seen: &ChangeInView,
        at: &SiteTracer,
    ) -> Option<HitTrace> {
        // Mirrors and canopies need more of a hit than is stored, and an archive without
        // reflections stores no hits.
        let stored = at.traces(Effect::Diffuse) && at.reflections.is_none() && at.canopies.is_none();
        if !stored || self.alters_hits(view, seen, at) {
            return None;
        }
        let now = |key: &Option<CellKey>| match key {
            Some(key) if *key == CellKey::dark(key.material) => None,
            Some(key) => self.now(*key).map(Some),
            None => Some(None),
        };
        let cells = known.hits.iter().map(now).collect::<Option<Vec<_>>>()?;
        self.receivers.fetch_add(1, Ordering::Relaxed);
        Some(HitTrace { cells, nearest_m: f64::INFINITY, mirrors: Vec::new(), distances_m: Vec::new() })
    }
}

/// Keeps only the rays that go towards the change.
fn towards(seen: &ChangeInView, mut rays: Vec<Ray>) -> Vec<Ray> {
    rays.retain(|ray| seen.lies_towards(DVec3::from(ray.direction.map(f64::from))));
    rays
}

impl SiteTracer<'_> {
    /// Returns the cells of some keys, sorted by key, that need not be traced: an archive of the
    /// same scene holds them, or the change does not alter them. `rays` is the number of rays that
    /// each casts to its surroundings.
    pub(super) fn known_cells(&self, kind: CellKind, keys: &[CellKey], texture: &Directions, rays: usize) -> Vec<Cell> {
        let mut found = self.known.cells(kind, keys);
        let Some(before) = &self.before else { return found };
        let is_missing = |key: &&CellKey| found.binary_search_by_key(*key, |cell| cell.key).is_err();
        let missing: Vec<CellKey> = keys.iter().filter(is_missing).copied().collect();
        let mut kept = before.cells(kind, &missing);
        kept = kept.into_par_iter().filter(|cell| self.stands(cell, before, texture, rays)).collect();
        before.cells[usize::from(kind == CellKind::Bounces)].fetch_add(kept.len() as u64, Ordering::Relaxed);
        found.extend(kept);
        found.sort_unstable_by_key(|cell| cell.key);
        found
    }

    /// Returns true if a cell of the scene before is valid in the scene as it is now: no ray that
    /// it depends on meets the change or goes by way of a mirror.
    pub(super) fn stands(&self, cell: &Cell, before: &PreviousBuild, texture: &Directions, rays: usize) -> bool {
        let (key, change) = (cell.key, &before.change);
        if change.is_nothing() {
            return cell.mirrors.is_empty();
        }
        if cell.doubtful {
            return self.doubtful_stands(cell, before, texture, rays);
        }
        if !cell.mirrors.is_empty() || change.touches(key, texture.nearby()) {
            return false;
        }
        let (middle, spread) = change.middle(key);
        let (mut seen, normal) = (change.seen_from(middle, spread), DVec3::from(cell.normal.map(f64::from)));
        if normal.length() >= PLANE && !key.is_leaf() {
            seen = seen.before(normal);
        }
        if seen.is_nothing() || self.reflections.is_none() && !may_see(key, normal, texture, &seen) {
            return true;
        }
        // Rays are cast only if the cheap tests above do not decide.
        let probe = known_probe(key, cell.bits.clone(), texture, self.surfaces());
        let looks: Vec<Ray> = looks_around(key, &probe, texture, rays).into_iter().map(|look| look.0).collect();
        let all = sky_rays(key, &probe, texture).chain(looks.iter().copied()).collect();
        if change.alters(&towards(&seen, all), self.tracer) {
            return false;
        }
        let Some(reflections) = &self.reflections else { return true };
        let around = around_cell(reflections, key, &probe, texture.n);
        let by_mirrors: Vec<Ray> = looks.into_iter().chain(around.into_iter().map(|ray| ray.1)).collect();
        !reflections.towards_mirrors(&towards(&seen, by_mirrors)).contains(&true)
    }

    /// Does the work of [`SiteTracer::stands`] for a cell with points that may be hidden. Which
    /// points are is not known, so any may have cast any ray of the cell. Also, no ray may hit a
    /// triangle whose back may have become lit or dark.
    fn doubtful_stands(&self, cell: &Cell, before: &PreviousBuild, texture: &Directions, rays: usize) -> bool {
        let (key, normal) = (cell.key, DVec3::from(cell.normal.map(f64::from)));
        let Some(change) = &before.in_doubt else { return false };
        // For cells on backs of triangles, lit fronts would be in doubt, and these are not searched
        // for.
        if key.is_back() || change.touches(key, texture.nearby()) {
            return false;
        }
        let (middle, spread) = change.middle(key);
        let mut seen = change.seen_from(middle, spread);
        if normal.length() >= PLANE && !key.is_leaf() {
            seen = seen.before(normal);
        }
        if seen.is_nothing() {
            return true;
        }
        let probe = known_probe(key, Vec::new(), texture, self.surfaces());
        !change.alters(&may_cast(key, &probe, texture, rays, &seen), self.tracer)
    }
}
