//! Trials: some receivers built with some settings. In: a scene, receivers, settings, conditions.
//! Out: irradiances to compare with those of other settings, and their cost.

use std::path::{Path, PathBuf};
use std::time::Duration;

use cpu_time::ProcessTime;

use crate::pipeline::{Build, Output, Plan, PreparedScene, RayCounts, ReusedArchives, Start};
use crate::receiver_tiles::ReceiverTiles;
use crate::settings::BuildSettings;
use heliotile_archives::Workspace;
use heliotile_core::archive::{Access, Archive, format};
use heliotile_core::error::Result;
use heliotile_core::light::radiosity::MaxBounces;
use heliotile_core::memory::Use;
use heliotile_core::observer::{Observer, Tone};
use heliotile_core::opened::OpenSite;
use heliotile_core::replay::components::Component;
use heliotile_core::replay::run::{Replay, ReplaySettings};
use heliotile_core::site::receiver::Receiver;
use heliotile_core::text::Message;
use heliotile_core::weather::conditions::Condition;
use heliotile_files::spill::TempFiles;

/// Common inputs of the trials of one site.
pub struct Bench<'a> {
    /// Scene to trace.
    pub scene: &'a PreparedScene<'a>,
    /// Receivers that are built, in this order.
    pub receivers: &'a [Receiver],
    /// Suns and skies under which irradiances are compared.
    pub conditions: &'a [Condition],
    /// Workspace, whose folder holds the archives of trials until they are no longer needed.
    pub workspace: &'a Workspace,
    /// Gets warnings, and can stop the trials.
    pub observer: &'a dyn Observer,
}

/// Observer that hides the progress of a trial, which is part of a longer stage, and passes on
/// warnings and stops.
struct Quiet<'a>(&'a dyn Observer);

impl Observer for Quiet<'_> {
    fn tell(&self, tone: Tone, message: Message) {
        if tone == Tone::Warning {
            self.0.tell(tone, message);
        }
    }

    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

/// Trial build and its results.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Settings of the build.
    pub settings: BuildSettings,
    /// Archive, in the folder of the workspace.
    pub archive: PathBuf,
    /// Irradiances of its receivers.
    pub light: Irradiances,
    /// Numbers of rays that the build cast.
    pub rays: RayCounts,
    /// Length of the archive, bytes.
    pub bytes: u64,
    /// CPU seconds of the build, including compression.
    pub build_s: f64,
}

/// Irradiances, W/m2, by source of error: `[receiver][condition]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Irradiances {
    /// Number of conditions, the faster axis of `rows`.
    pub conditions: usize,
    /// Rows of the six components, and of sun_reflected and sky_reflected after a single
    /// reflection.
    pub rows: Vec<[f32; 8]>,
}

impl Bench<'_> {
    /// Builds the receivers and replays them under the conditions.
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
            build.write(&Plan { with_scene: false, ..Plan::new(settings) }, &output, &ReusedArchives::default())?;
        let build_s = started.elapsed().as_secs_f64();
        let light = self.light(&path, settings.patches)?;
        Ok(Trial { settings, archive: path, light, rays: report.rays, bytes: report.bytes, build_s })
    }

    /// Replays the receivers of an archive with `patches` sky patches.
    pub fn light(&self, archive: &Path, patches: usize) -> Result<Irradiances> {
        let archive = Archive::open_with(archive, Access::Read)?;
        let (diffuse, conditions) = ([Component::SunReflected, Component::SkyReflected], self.conditions);
        let mut rows: Vec<[f32; 8]> = Vec::new();
        let storage = TempFiles::new(&self.workspace.folder);
        let settings = |depth: MaxBounces| ReplaySettings {
            patches,
            paths: depth.into(),
            memory: self.workspace.memory,
            storage: &storage,
            ..ReplaySettings::default()
        };
        let site = OpenSite::open(&archive)?;
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
        // A second replay with one reflection separates the errors of seen and bounced cells.
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

/// Source of error that has a ladder of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorSource {
    /// Sky textures: sun and sky, direct and in mirrors.
    Sky,
    /// Seen cells: one diffuse reflection.
    Seen,
    /// Further reflections.
    Bounced,
}

impl ErrorSource {
    /// All sources, in the order of their numbers.
    pub const ALL: [ErrorSource; 3] = [ErrorSource::Sky, ErrorSource::Seen, ErrorSource::Bounced];

    /// Returns the part of a row of [`Irradiances`] that has this source, W/m2.
    pub fn of(self, row: &[f32; 8]) -> f64 {
        let [sun, sky, sun_reflected, sky_reflected, sun_mirrored, sky_mirrored, once_sun, once_sky] =
            row.map(f64::from);
        match self {
            ErrorSource::Sky => sun + sky + sun_mirrored + sky_mirrored,
            ErrorSource::Seen => once_sun + once_sky,
            ErrorSource::Bounced => sun_reflected + sky_reflected - once_sun - once_sky,
        }
    }
}

/// Differences between two sets of irradiances, W/m2.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorMeasures {
    /// Square root of the mean square.
    pub rmse: f64,
    /// Mean with its sign: above 0 if the first set is larger.
    pub bias: f64,
    /// Mean of the absolute values.
    pub mean_absolute: f64,
}

fn total(row: &[f32; 8]) -> f64 {
    row.iter().take(6).map(|x| f64::from(*x)).sum()
}

impl Irradiances {
    /// Returns the mean total, W/m2.
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

    /// Returns the errors of the total.
    pub fn total_error(&self, truth: &Irradiances) -> ErrorMeasures {
        self.differ(truth, total)
    }

    /// Returns the errors of the part that has one source.
    pub fn source_error(&self, truth: &Irradiances, source: ErrorSource) -> ErrorMeasures {
        self.differ(truth, |row| source.of(row))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two rows are off by +3 and -1 W/m2 of sun and by +1 of a second reflection. The sky gets an
    /// RMSE of sqrt(5), a bias of 1 and a mean absolute error of 2, the bounced part an RMSE of 1,
    /// and the seen part 0.
    #[test]
    fn errors_are_counted_by_source() {
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
