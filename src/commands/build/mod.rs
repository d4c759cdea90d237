//! Story one: scene -> trace -> layers -> archive.

mod canopies;
mod cells;
mod forecast;
mod known;
pub mod ladder;
mod manifest;
mod mirrors;
mod plan;
mod settings;
mod tiles;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use super::accuracy::{Choice, Wish, choose};
use super::store::{Folder, Store, StoreKey, open_all};
use super::{Outcome, counted, guard_archive, guard_site, interrupt, load_scene, say, temporary_folder, warn};
use crate::cli::{AccuracyArgs, BuildArgs, Percent, PlanArgs, Wanted};
pub use crate::cli::{Effect, Effects, Share};
pub use forecast::{Forecast, NEGLIGIBLE_W_M2, SKY_W_M2, SUN_W_M2};
use heliotile_builder::receiver_tiles::ReceiverTiles;
use heliotile_builder::trace::Tracer;
use heliotile_builder::trace::canopy::Canopies;
use heliotile_builder::trace::mirror::Reflections;
use heliotile_builder::writing::Writer;
use heliotile_core::archive::accuracy::Accuracy;
use heliotile_core::archive::{Archive, Manifest, format};
use heliotile_core::error::{Error, Result};
use heliotile_core::light::response::Reflector;
use heliotile_core::site::chain::MOST_MIRRORS;
use heliotile_core::site::receiver::Receiver;
use heliotile_scene::Scene;
use heliotile_scene::mirrors::Mirrors;
use known::Known;
use ladder::Rungs;
pub use manifest::Counts;
pub use plan::{BuildPlan, Start};
pub use settings::BuildSettings;

/// What a build did.
#[derive(Clone, Debug)]
pub struct BuildReport {
    pub counts: Counts,
    /// Cast by this run: a build that was resumed cast others before.
    pub rays: Rays,
    /// Seconds by stage.
    pub seconds: Vec<(&'static str, f64)>,
    pub bytes: u64,
    pub root: [u8; 32],
    pub warnings: Vec<String>,
    /// Largest share of a receiver's light, and of a cell's, that was lost behind the last mirror followed.
    pub lost_in_mirrors: [f64; 2],
}

/// Rays cast, by purpose.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rays {
    pub sky: u64,
    pub hit: u64,
    pub probe: u64,
    pub bounce: u64,
    /// By way of mirrors, for receivers and cells.
    pub mirror: u64,
    /// Of receivers through canopies; those of cells are among `probe` and `bounce`.
    pub canopy: u64,
}

impl Rays {
    pub fn total(&self) -> u64 {
        self.sky + self.hit + self.probe + self.bounce + self.mirror + self.canopy
    }
}

/// What every part of a build works on.
struct Job<'a> {
    scene: &'a Scene,
    /// Of what stops rays.
    tracer: &'a Tracer,
    /// By material.
    reflectors: Vec<Reflector>,
    canopies: Option<&'a Canopies<'a>>,
    settings: &'a BuildSettings,
    start: Start,
    /// Where temporary files go.
    folder: PathBuf,
    /// Bytes to work in, besides the scene.
    memory: usize,
    known: Known<'a>,
    /// Only where there are mirrors.
    reflections: Option<Reflections<'a>>,
    accuracy: Option<&'a Accuracy>,
    /// Largest share of light that was lost behind the last mirror followed, as bits of an f64: of a receiver's, of a cell's.
    lost: [AtomicU64; 2],
}

/// A scene ready for rays.
pub(super) struct Ready<'a> {
    /// Of all that stops rays.
    tracer: Tracer,
    canopies: Option<Canopies<'a>>,
    mirrors: Mirrors,
    seconds: f64,
}

impl<'a> Ready<'a> {
    pub fn new(scene: &'a Scene) -> Result<Self> {
        let start = Instant::now();
        let (tracer, canopies) = Canopies::split(scene);
        let mirrors = Mirrors::find(&scene.mesh, &scene.materials)?;
        Ok(Ready { tracer, canopies, mirrors, seconds: start.elapsed().as_secs_f64() })
    }

    /// Whether there are mirrors, and they are to be traced.
    fn reflects(&self, settings: &BuildSettings) -> bool {
        !self.mirrors.is_empty() && !settings.left_out.contains(Effect::Mirrors)
    }
}

impl<'a> Job<'a> {
    fn new(scene: &'a Scene, ready: &'a Ready<'a>, plan: &'a BuildPlan, known: Known<'a>) -> Self {
        let reflections =
            ready.reflects(&plan.settings).then(|| Reflections::new(&scene.mesh, &ready.tracer, &ready.mirrors));
        let canopies = ready.canopies.as_ref().filter(|_| !plan.settings.left_out.contains(Effect::Canopies));
        Job {
            scene,
            reflectors: scene.materials.iter().map(Reflector::of).collect(),
            tracer: &ready.tracer,
            settings: &plan.settings,
            start: plan.start,
            folder: temporary_folder(&plan.output).to_path_buf(),
            memory: plan.memory_bytes as usize,
            known,
            reflections,
            accuracy: plan.accuracy.as_ref(),
            lost: Default::default(),
            canopies,
        }
    }

    /// Whether an effect is to be traced, if the scene has it.
    fn traces(&self, effect: Effect) -> bool {
        let left_out = self.settings.left_out;
        !(left_out.contains(effect) || effect == Effect::Bounces && left_out.contains(Effect::Diffuse))
    }

    /// Makes what was written survive a crash, every now and then; and ends the build if the user wants it to end.
    fn checkpoint(&self, writer: &mut Writer) -> Result<()> {
        if !interrupt::requested() {
            return if writer.due() { writer.checkpoint() } else { Ok(()) };
        }
        writer.checkpoint()?;
        let (what, hint) = match writer.committed() {
            Some(done) => (
                format!("the build was stopped after {} blocks of {:.1} MB", done.blocks, done.bytes as f64 / 1e6),
                self.start.again(),
            ),
            None => ("the build was stopped before anything was written".into(), "start it again"),
        };
        Err(Error::input(writer.partial(), None, what, hint))
    }
}

/// `heliotile build`.
pub fn run(args: &BuildArgs) -> Result<Outcome> {
    guard_site(&args.output, &args.scene.site()?, &[Some(&args.receivers)])?;
    guard_archive(&args.output)?;
    let scene = load_scene(&args.scene)?;
    let mut warnings = Vec::new();
    let folder = temporary_folder(&args.output);
    let budget = args.memory.0 as usize / 8;
    let mut receivers = ReceiverTiles::open(&args.receivers, scene.mesh.origin, folder, budget, &mut warnings)?;
    warnings.iter().for_each(|w| warn(w));
    let start = match (args.resume, args.fresh) {
        (true, _) => Start::Resume,
        (_, true) => Start::Fresh,
        _ => Start::New,
    };
    let plan = BuildPlan {
        settings: BuildSettings { share: args.share, ..settings_of(&args.accuracy)? },
        output: args.output.clone(),
        memory_bytes: args.memory.0,
        start,
        checkpoint_every: Duration::from_secs(u64::from(args.checkpoint)),
        accuracy: None,
    };
    let store = args.store.as_deref().map(Folder::create).transpose()?;
    let ready = Ready::new(&scene)?;
    build_planned(
        &scene,
        &ready,
        &mut receivers,
        plan,
        &Asked { accuracy: &args.accuracy, effects: args.effects, store },
    )?;
    Ok(Outcome::Fine)
}

/// What is asked of a build besides its plan.
pub(super) struct Asked<'a> {
    pub accuracy: &'a AccuracyArgs,
    pub effects: Wanted,
    pub store: Option<Folder>,
}

/// Decides, builds, and says what is done.
pub(super) fn build_planned(
    scene: &Scene,
    ready: &Ready,
    receivers: &mut ReceiverTiles,
    mut plan: BuildPlan,
    asked: &Asked,
) -> Result<()> {
    interrupt::watch();
    let (forecast, choice) = decide(scene, ready, receivers, &mut plan, asked.accuracy, asked.effects)?;
    say(&forecast.table())?;
    let key = StoreKey { scene: scene.content_hash(), settings: plan.settings.hash()? };
    let earlier = asked.store.as_ref().map_or(Ok(Vec::new()), |store| open_all(store, &key))?;
    let report = build_ready(scene, ready, receivers, &plan, &earlier)?;
    if let Some(store) = &asked.store {
        store.add(&key, &plan.output, &report.root)?;
    }
    report.warnings.iter().for_each(|w| warn(w));
    say(&summary(&report, scene, &plan.output))?;
    if let Some(choice) = choice {
        let taken = report.seconds.iter().map(|stage| stage.1).sum();
        say(&choice.outcome(forecast.seconds(), taken))?;
    }
    Ok(())
}

/// `heliotile plan`.
pub fn plan(args: &PlanArgs) -> Result<Outcome> {
    let scene = load_scene(&args.scene)?;
    let (mut warnings, folder) = (Vec::new(), std::env::temp_dir());
    let budget = args.memory.0 as usize / 8;
    let mut receivers = ReceiverTiles::open(&args.receivers, scene.mesh.origin, &folder, budget, &mut warnings)?;
    warnings.iter().for_each(|w| warn(w));
    let mut plan = BuildPlan {
        settings: settings_of(&args.accuracy)?,
        output: folder.join("plan"),
        memory_bytes: args.memory.0,
        start: Start::New,
        checkpoint_every: Duration::MAX,
        accuracy: None,
    };
    let ready = Ready::new(&scene)?;
    let (forecast, _) = decide(&scene, &ready, &mut receivers, &mut plan, &args.accuracy, args.effects)?;
    say(&format!(
        "{}: {} receivers, {} triangles, {}\n{}",
        args.scene.first().display(),
        forecast.receivers,
        scene.mesh.triangles.len(),
        counted(rayon::current_num_threads() as u64, "thread"),
        forecast.table()
    ))?;
    Ok(Outcome::Fine)
}

/// What a build with some settings would trace.
pub fn foresee(scene: &Scene, receivers: &mut ReceiverTiles, plan: &BuildPlan, wanted: Wanted) -> Result<Forecast> {
    forecast(scene, &Ready::new(scene)?, receivers, plan, wanted)
}

/// Effects that the scene has and that a build of standard settings would leave out; `folder` for temporary files.
pub(super) fn left_out(
    scene: &Scene,
    ready: &Ready,
    receivers: &mut ReceiverTiles,
    folder: &Path,
    wanted: Wanted,
) -> Result<Effects> {
    let plan = BuildPlan {
        settings: BuildSettings::default(),
        output: folder.join("plan"),
        memory_bytes: 0,
        start: Start::New,
        checkpoint_every: Duration::MAX,
        accuracy: None,
    };
    Ok(forecast(scene, ready, receivers, &plan, wanted)?.left_out)
}

fn forecast(
    scene: &Scene,
    ready: &Ready,
    receivers: &mut ReceiverTiles,
    plan: &BuildPlan,
    wanted: Wanted,
) -> Result<Forecast> {
    let job = Job::new(scene, ready, plan, Known::default());
    job.forecast(receivers, ready.mirrors.orientations.len(), wanted)
}

/// Decides on what is left out and, where an error is given, on settings; the plan gets both.
fn decide(
    scene: &Scene,
    ready: &Ready,
    receivers: &mut ReceiverTiles,
    plan: &mut BuildPlan,
    accuracy: &AccuracyArgs,
    wanted: Wanted,
) -> Result<(Forecast, Option<Choice>)> {
    let first = forecast(scene, ready, receivers, plan, wanted)?;
    plan.settings.left_out = first.left_out;
    let Some(Percent(target_percent)) = accuracy.error else { return Ok((first, None)) };
    let wish = Wish {
        target_percent,
        weather: accuracy.error_weather.as_deref(),
        left_out: first.left_out,
        folder: temporary_folder(&plan.output),
        memory_bytes: plan.memory_bytes,
    };
    let choice = choose(scene, ready, receivers, &wish)?;
    say(&choice.table())?;
    (plan.settings, plan.accuracy) = (choice.settings, Some(choice.accuracy.clone()));
    let forecast = crate::commands::build::forecast(scene, ready, receivers, plan, wanted)?;
    plan.settings.left_out = forecast.left_out;
    Ok((forecast, Some(choice)))
}

/// Settings of a quality with some set by name.
pub(super) fn settings_of(accuracy: &AccuracyArgs) -> Result<BuildSettings> {
    let mut settings = Rungs::of(accuracy.quality).settings();
    accuracy.set.iter().try_for_each(|text| settings.set(text))?;
    settings.check()?;
    Ok(settings)
}

/// Traces a scene for its receivers and writes the archive; equal inputs give equal bytes, whatever the order of receivers,
/// the number of threads or the memory.
pub fn build(scene: &Scene, receivers: &mut ReceiverTiles, plan: &BuildPlan) -> Result<BuildReport> {
    build_with(scene, receivers, plan, &[])
}

/// [`build`] that traces nothing that earlier archives of the same scene and settings hold.
pub fn build_with(
    scene: &Scene,
    receivers: &mut ReceiverTiles,
    plan: &BuildPlan,
    earlier: &[Archive],
) -> Result<BuildReport> {
    build_ready(scene, &Ready::new(scene)?, receivers, plan, earlier)
}

pub(super) fn build_ready(
    scene: &Scene,
    ready: &Ready,
    receivers: &mut ReceiverTiles,
    plan: &BuildPlan,
    earlier: &[Archive],
) -> Result<BuildReport> {
    let mut clock = Clock::default();
    clock.laps.push(("tree", ready.seconds));
    let mut writer = plan.writer(&heliotile_builder::writing::Job {
        scene: scene.content_hash(),
        receivers: receivers.content_hash(),
        settings: plan.settings.hash()?,
    })?;
    match (plan.start, writer.resumed()) {
        (_, Some(done)) => warn(&format!("going on after {} blocks of {:.1} MB", done.blocks, done.bytes as f64 / 1e6)),
        (Start::Resume, None) => warn("there is no checkpoint to go on from: starting anew"),
        _ => {}
    }
    let job = Job::new(scene, ready, plan, Known::new(earlier, scene.materials.len(), ready.reflects(&plan.settings)));
    let traced = trace(&job, receivers, &mut writer, &mut clock);
    if matches!(traced, Err(Error::Io { .. })) {
        // Where another file failed, such as a temporary one, what was written can be kept.
        let _ = writer.checkpoint();
    }
    let kept = writer.committed();
    let finish = |traced: Traced| {
        let summary = writer.finish(&traced.manifest)?;
        clock.lap("finish");
        let Traced { counts, rays, warnings, lost_in_mirrors, .. } = traced;
        let (bytes, root) = (summary.bytes, summary.root);
        Ok(BuildReport { counts, rays, seconds: clock.laps, bytes, root, warnings, lost_in_mirrors })
    };
    traced.and_then(finish).map_err(|error| plan.start.kept(error, kept))
}

/// What an archive holds whose blocks are all written.
struct Traced {
    counts: Counts,
    rays: Rays,
    warnings: Vec<String>,
    manifest: Manifest,
    lost_in_mirrors: [f64; 2],
}

/// Writes all blocks that a writer does not have.
fn trace(job: &Job, receivers: &mut ReceiverTiles, writer: &mut Writer, clock: &mut Clock) -> Result<Traced> {
    let farthest = receivers.farthest().and_then(|receiver| far_away(job.tracer, job.scene, receiver));
    let mut warnings: Vec<String> = farthest.into_iter().collect();
    let mut rays = Rays::default();

    let mut misplaced = Vec::new();
    let keys = job.write_receivers(receivers, writer, &mut rays, &mut misplaced)?;
    clock.lap("receivers");
    let probes = job.write_probes(keys, writer, &mut rays)?;
    let bounce_cells = job.write_bounces(probes.seen, writer, &mut rays)?;
    clock.lap("cells");

    if !writer.has(format::MATERIALS, 0) {
        writer.append(job.materials_block()?)?;
        for block in job.optics_blocks()? {
            writer.append(block)?;
        }
    }
    let tiles = receivers.tile_count() as u32;
    let counts = Counts { receivers: receivers.count() as u64, tiles, probes: probes.count, bounce_cells };
    job.write_responses(tiles, writer, clock)?;
    let manifest = job.manifest(&counts, writer.layers());
    warnings.extend(tiles::warnings(&misplaced));
    let lost_in_mirrors = job.lost.each_ref().map(|lost| f64::from_bits(lost.load(Ordering::Relaxed)));
    Ok(Traced { counts, rays, warnings, manifest, lost_in_mirrors })
}

/// Seconds by stage.
struct Clock {
    start: Instant,
    laps: Vec<(&'static str, f64)>,
}

impl Default for Clock {
    fn default() -> Self {
        Clock { start: Instant::now(), laps: Vec::new() }
    }
}

impl Clock {
    fn lap(&mut self, name: &'static str) {
        self.laps.push((name, self.start.elapsed().as_secs_f64()));
        self.start = Instant::now();
    }
}

/// Rays start this far off surfaces (metres) before it is worth a warning.
const LARGE_OFFSET_M: f64 = 0.01;

/// A warning if some receiver lies so far from the scene's origin that details near it are lost.
fn far_away(tracer: &Tracer, scene: &Scene, worst: &Receiver) -> Option<String> {
    let (offset_m, o) = (tracer.grid().offset_m(worst.position), scene.mesh.origin);
    (offset_m > LARGE_OFFSET_M).then(|| {
        format!(
            "receiver {} lies far from the scene's centre ({:.0}, {:.0}, {:.0}): rays start {:.1} mm off its surface and finer \
             details are lost; look for stray geometry, or build the site in parts",
            worst.id,
            o.x,
            o.y,
            o.z,
            offset_m * 1e3
        )
    })
}

/// The summary that a build ends with.
fn summary(report: &BuildReport, scene: &Scene, output: &Path) -> String {
    let counts = &report.counts;
    let total: f64 = report.seconds.iter().map(|s| s.1).sum();
    let rays = report.rays.total();
    let each = |x: f64| x / counts.receivers.max(1) as f64;
    let stages: Vec<String> = report.seconds.iter().map(|(name, s)| format!("{name} {s:.2}")).collect();
    let mirrors = match report.lost_in_mirrors {
        [0.0, 0.0] => String::new(),
        lost => {
            let [receivers, cells] = lost.map(|share| share * 100.0);
            format!(
                "  behind {MOST_MIRRORS} mirrors, where no light is followed, lies at most {receivers:.1} % of what a receiver sees, \
                 {cells:.1} % of what a cell sees\n"
            )
        }
    };
    format!(
        "{}: {} receivers, {} triangles\n  {} probes, {} bounce cells, {:.1} Mray ({:.0} a receiver), {:.2} MB ({:.0} bytes a \
         receiver)\n{mirrors}  {total:.2} s: {}\n  root {}\n",
        output.display(),
        counts.receivers,
        scene.mesh.triangles.len(),
        counts.probes,
        counts.bounce_cells,
        rays as f64 / 1e6,
        each(rays as f64),
        report.bytes as f64 / 1e6,
        each(report.bytes as f64),
        stages.join(", "),
        format::hex(&report.root),
    )
}
