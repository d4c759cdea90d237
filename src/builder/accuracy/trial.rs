//! A trial: some receivers built with some settings, and what comes out. In: a scene, receivers, settings, conditions. Out: irradiances
//! to compare with those of other settings, and what they cost.

use std::path::{Path, PathBuf};
use std::time::Duration;

use cpu_time::ProcessTime;

use crate::pipeline::{Build, Output, Plan, PreparedScene, RayCounts, ReusedArchives, Start, Workspace};
use crate::receiver_tiles::ReceiverTiles;
use crate::settings::BuildSettings;
use crate::spill::TempFiles;
use heliotile_core::archive::{Access, Archive, format};
use heliotile_core::error::Result;
use heliotile_core::light::radiosity::MaxBounces;
use heliotile_core::memory::Use;
use heliotile_core::observer::Observer;
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::Component;
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::site::receiver::Receiver;
use heliotile_core::weather::conditions::Condition;

/// What trials of one site have in common.
pub struct Bench<'a> {
    /// What is traced.
    pub scene: &'a PreparedScene<'a>,
    /// The receivers that are built, in this order.
    pub receivers: &'a [Receiver],
    /// Suns and skies that irradiances are compared under.
    pub conditions: &'a [Condition],
    /// Its folder holds archives of trials until they are not needed any more.
    pub workspace: &'a Workspace,
    /// Asked whether to stop, and told of warnings.
    pub observer: &'a dyn Observer,
}

/// A trial is a part of a longer stage: it shows nothing of its own, and stops when all is to stop.
struct Quiet<'a>(&'a dyn Observer);

impl Observer for Quiet<'_> {
    fn warn(&self, text: &str) {
        self.0.warn(text);
    }

    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

/// What was built and how it looks.
#[derive(Clone, Debug)]
pub struct Trial {
    /// What it was built with.
    pub settings: BuildSettings,
    /// The archive, in the folder of the workspace.
    pub archive: PathBuf,
    /// What its receivers get.
    pub light: Irradiances,
    /// Rays that the build cast.
    pub rays: RayCounts,
    /// Length of the archive.
    pub bytes: u64,
    /// CPU seconds of the build, compression included.
    pub build_s: f64,
}

/// Irradiances, W/m2, by what they tell of errors: `[receiver][condition]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Irradiances {
    /// Number of conditions, the faster axis of `rows`.
    pub conditions: usize,
    /// The six components, and sun_diffuse and sky_diffuse of a single reflection.
    pub rows: Vec<[f32; 8]>,
}

impl Bench<'_> {
    /// Builds the receivers and looks at them under the conditions with so many patches.
    pub fn trial(&self, settings: BuildSettings) -> Result<Trial> {
        let Workspace { folder, memory } = self.workspace;
        let path = folder.join(format!("{}.helio", format::hex(&settings.hash()?)));
        let output = Output { start: Start::Fresh, checkpoint_every: Duration::MAX, ..Output::new(path.clone()) };
        let started = ProcessTime::now();
        let origin = self.scene.scene.mesh.origin;
        let mut tiles =
            ReceiverTiles::from_receivers(self.receivers, origin, folder, memory.length(Use::SortedReceivers))?;
        let (scene, workspace, observer) = (self.scene, self.workspace, Quiet(self.observer));
        let mut build = Build { scene, receivers: &mut tiles, workspace, observer: &observer };
        let report =
            build.write(&Plan { with_scene: false, ..Plan::of(settings) }, &output, &ReusedArchives::default())?;
        let build_s = started.elapsed().as_secs_f64();
        let light = self.light(&path, settings.patches)?;
        Ok(Trial { settings, archive: path, light, rays: report.rays, bytes: report.bytes, build_s })
    }

    /// What the receivers of an archive get, with so many sky patches.
    pub fn light(&self, archive: &Path, patches: usize) -> Result<Irradiances> {
        let archive = Archive::open_with(archive, Access::Read)?;
        let (diffuse, conditions) = ([Component::SunDiffuse, Component::SkyDiffuse], self.conditions);
        let mut rows: Vec<[f32; 8]> = Vec::new();
        let storage = TempFiles::new(&self.workspace.folder);
        let settings = |depth: MaxBounces| ReplaySettings {
            patches,
            paths: depth.into(),
            memory: self.workspace.memory,
            storage: &storage,
            ..ReplaySettings::default()
        };
        let site = OpenSite::of(&archive)?;
        let all = Replay::new(&site, conditions, settings(MaxBounces::All))?;
        for tile in all.results(0..all.tiles()) {
            let (ids, values) = tile?;
            for receiver in 0..ids.len() {
                let six: [&[f32]; 6] = std::array::from_fn(|c| values.row(Component::ALL[c], receiver));
                rows.extend((0..conditions.len()).map(|i| {
                    let [a, b, c, d, e, f] = six.map(|of| of[i]);
                    [a, b, c, d, e, f, 0.0, 0.0]
                }));
            }
        }
        let once = Replay::new(&site, conditions, settings(MaxBounces::Count(1)))?;
        let mut next = 0;
        for tile in once.results(0..once.tiles()) {
            let (ids, values) = tile?;
            for receiver in 0..ids.len() {
                let [sun, sky] = diffuse.map(|component| values.row(component, receiver));
                for (sun, sky) in sun.iter().zip(sky) {
                    rows[next][6] = *sun;
                    rows[next][7] = *sky;
                    next += 1;
                }
            }
        }
        Ok(Irradiances { conditions: conditions.len(), rows })
    }
}

/// A source of error that has a ladder of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorSource {
    /// Sky textures: sun and sky, direct and in mirrors.
    Sky,
    /// Cells that are seen: one diffuse reflection.
    Seen,
    /// Further reflections.
    Bounced,
}

impl ErrorSource {
    /// All sources, in the order of their numbers.
    pub const ALL: [ErrorSource; 3] = [ErrorSource::Sky, ErrorSource::Seen, ErrorSource::Bounced];

    /// The part of a row of [`Irradiances`] that has this source, W/m2.
    pub fn of(self, row: &[f32; 8]) -> f64 {
        let [sun, sky, sun_diffuse, sky_diffuse, sun_specular, sky_specular, once_sun, once_sky] = row.map(f64::from);
        match self {
            ErrorSource::Sky => sun + sky + sun_specular + sky_specular,
            ErrorSource::Seen => once_sun + once_sky,
            ErrorSource::Bounced => sun_diffuse + sky_diffuse - once_sun - once_sky,
        }
    }
}

/// How two lights differ, W/m2.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorMeasures {
    /// Square root of the mean square.
    pub rmse: f64,
    /// Mean with its sign: above 0 where the first is larger.
    pub bias: f64,
    /// Mean of the absolute values.
    pub mean_absolute: f64,
}

fn total(row: &[f32; 8]) -> f64 {
    row.iter().take(6).map(|x| f64::from(*x)).sum()
}

impl Irradiances {
    /// Mean total.
    pub fn mean(&self) -> f64 {
        self.rows.iter().map(total).sum::<f64>() / self.rows.len().max(1) as f64
    }

    fn differ(&self, truth: &Irradiances, part: impl Fn(&[f32; 8]) -> f64) -> ErrorMeasures {
        let count = self.rows.len().max(1) as f64;
        let (mut squares, mut sum, mut absolute) = (0.0, 0.0, 0.0);
        for (row, right) in self.rows.iter().zip(&truth.rows) {
            let error = part(row) - part(right);
            squares += error * error;
            sum += error;
            absolute += error.abs();
        }
        ErrorMeasures { rmse: (squares / count).sqrt(), bias: sum / count, mean_absolute: absolute / count }
    }

    /// Errors of the total.
    pub fn total_error(&self, truth: &Irradiances) -> ErrorMeasures {
        self.differ(truth, total)
    }

    /// Errors of what has one source.
    pub fn source_error(&self, truth: &Irradiances, source: ErrorSource) -> ErrorMeasures {
        self.differ(truth, |row| source.of(row))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two rows off by +3 and -1 W/m2 of sun and +1 of a second reflection: rmse sqrt(5), bias 1, mean absolute 2 of the sky's; 1 of
    /// the bounced, 0 of the seen.
    #[test]
    fn errors_by_source() {
        let row = |sun: f32, reflected: f32| [sun, 0.0, reflected, 0.0, 0.0, 0.0, 4.0, 0.0];
        let truth = Irradiances { conditions: 2, rows: vec![row(100.0, 5.0), row(50.0, 5.0)] };
        let light = Irradiances { conditions: 2, rows: vec![row(103.0, 6.0), row(49.0, 6.0)] };
        let sky = light.source_error(&truth, ErrorSource::Sky);
        assert!((sky.rmse - 5.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!((sky.bias, sky.mean_absolute), (1.0, 2.0));
        assert_eq!(light.source_error(&truth, ErrorSource::Seen), ErrorMeasures::default());
        assert_eq!(light.source_error(&truth, ErrorSource::Bounced).rmse, 1.0);
        assert_eq!(truth.mean(), 80.0);
    }
}
