//! Builds and their plans. In: requests, a scene that was read. Out: an archive, or its forecast.

use std::path::Path;
use std::time::Duration;

use heliotile_atlas::part::{PartRequest, build_parts};
use heliotile_atlas::plan::FILE;
use heliotile_builder::accuracy::conditions::ErrorConditions;
use heliotile_builder::pipeline::{Output, Start};
use heliotile_builder::planning::{BuildDone, EffectsUnder, PlanReport, tables};
use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::observer::Observer;
use heliotile_core::text::counted;
use heliotile_results::Resources;
use heliotile_scene::Scene;
use heliotile_scene::points::receivers::ReceiverCsv;
use heliotile_studies::SiteBuild;
use heliotile_studies::site_build::check_output;

use super::Build;

/// Seconds between checkpoints, if none are given.
const CHECKPOINT_S: u32 = 30;

/// Forecast of a build.
pub struct Planned {
    /// Forecast, and the light that each light path adds.
    pub report: PlanReport,
    /// Number of receivers.
    pub receivers: usize,
    /// Forecast and light as text.
    pub text: String,
}

impl Build {
    /// Checks the output before minutes of tracing. Returns the archive to write, and the table of
    /// receivers.
    pub fn check(&self) -> Result<(&Path, &Path)> {
        let (Some(receivers), Some(output)) = (&self.receivers, &self.output) else { return Err(self.unnamed()) };
        let inputs = [
            Some(receivers.as_path()),
            self.accuracy.error_weather.as_deref(),
            self.weather.as_deref(),
            self.from.as_deref(),
        ];
        check_output(output, &self.scene.site()?, &inputs)?;
        Ok((output, receivers))
    }

    /// Returns the table of receivers.
    pub fn receivers(&self) -> Result<&Path> {
        self.receivers.as_deref().ok_or_else(|| self.unnamed())
    }

    /// Returns the error of a build that names no receivers or no archive.
    fn unnamed(&self) -> Error {
        match self.scene.files.as_slice() {
            [only] if only.join(FILE).is_file() => {
                let hint = "give {part} all, or the name or number of a part; the atlas states its inputs";
                let what = format!("{} is an atlas, and the part to build is not given", only.display());
                Error::argument("part", what, hint).because(Problem::Missing)
            }
            _ if self.dry_run => Error::argument("receivers", "is not given", "give it too").because(Problem::Missing),
            _ => Error::argument(
                "receivers, output",
                "are not both given",
                "give a table of receivers, and an archive to write",
            )
            .because(Problem::Missing),
        }
    }

    /// Builds a part of an atlas, or all parts. Fails if no part, or not one atlas, is named.
    pub fn parts(&self, part: &str, observer: &dyn Observer) -> Result<()> {
        let [place] = self.scene.files.as_slice() else {
            let what = format!("a part belongs to one atlas, and {} files are given", self.scene.files.len());
            let hint = "give only the folder or the address of the atlas, which lists its scene files";
            return Err(Error::argument("part", what, hint));
        };
        let request = PartRequest { part, fresh: self.fresh, memory: self.memory, from: self.from.as_deref() };
        build_parts(place, &request, observer)
    }

    /// Traces the archive of the scene of this request and of receivers.
    pub fn trace(
        &self,
        scene: &Scene,
        receivers: ReceiverCsv,
        output: &Path,
        resources: &Resources,
    ) -> Result<BuildDone> {
        let weighed_under = self.weighed_under(scene, resources)?;
        let output = Output {
            path: output.to_owned(),
            start: if self.fresh { Start::Fresh } else { Start::Resume },
            checkpoint_every: Duration::from_secs(u64::from(self.checkpoint.unwrap_or(CHECKPOINT_S))),
        };
        let accuracy = self.accuracy.beside(self.weather.as_deref(), &self.about_weather);
        let build = SiteBuild {
            share: self.share,
            under: effects_under(weighed_under.as_ref(), self.negligible_percent),
            effects: self.effects,
            with_scene: !self.no_scene,
            from: self.from.as_deref(),
            memory: self.memory,
            files: resources.files,
            ..SiteBuild::new(scene, receivers, &accuracy)
        };
        build.build(&output, resources.observer)
    }

    /// Forecasts the build of the scene of this request and of receivers.
    pub fn forecast(&self, scene: &Scene, receivers: ReceiverCsv, resources: &Resources) -> Result<Planned> {
        let weighed_under = self.weighed_under(scene, resources)?;
        let accuracy = self.accuracy.beside(self.weather.as_deref(), &self.about_weather);
        let build = SiteBuild {
            share: self.share,
            under: effects_under(weighed_under.as_ref(), self.negligible_percent),
            effects: self.effects,
            memory: self.memory,
            files: resources.files,
            ..SiteBuild::new(scene, receivers, &accuracy)
        };
        let (report, receivers) = build.plan(resources.observer)?;
        let mut text = format!(
            "{}: {} receivers, {} triangles, {}\n{}",
            self.scene.first().display(),
            receivers,
            scene.mesh.triangles.len(),
            counted(rayon::current_num_threads() as u64, "thread"),
            tables::forecast(&report.forecast)
        );
        report.losses.iter().for_each(|losses| text += &tables::losses(losses));
        Ok(Planned { report, receivers, text })
    }

    /// Returns the weather under which effects are weighed, if a file is given.
    fn weighed_under(&self, scene: &Scene, resources: &Resources) -> Result<Option<ErrorConditions>> {
        let Some(file) = &self.weather else { return Ok(None) };
        let (about, place) = (&self.about_weather, scene.place);
        ErrorConditions::read(Some(file), about, place, resources.files, resources.observer).map(Some)
    }
}

fn effects_under(weather: Option<&ErrorConditions>, negligible_percent: Option<f64>) -> Option<EffectsUnder<'_>> {
    weather.map(|weather| EffectsUnder { weather, negligible_percent })
}
