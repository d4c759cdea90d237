//! `heliotile audit`: whether an archive is as exact as it says. In: an archive, its scene, weather. Out: what an independent judge finds,
//! and the verdict.

mod report;

use std::time::Duration;

use super::console::terminal::Terminal;
use super::{Outcome, original, remark, say, warn};
use crate::cli::AuditArgs;
use heliotile_builder::accuracy::CONDITIONS;
use heliotile_builder::accuracy::conditions::ErrorConditions;
use heliotile_builder::judge::{AuditRequest, audit};
use heliotile_builder::pipeline::PreparedScene;
use heliotile_builder::spill::SystemTemp;
use heliotile_core::archive::Access;
use heliotile_core::error::{Error, Result};
use heliotile_core::memory::MemoryBudget;
use heliotile_remote::places::open_archive;
use heliotile_results::outputs::provenance::Provenance;
use heliotile_results::outputs::sink::write_texts;
use heliotile_scene::input::weather::read_conditions;
use report::{AuditReport, Verdict};

/// Receivers that are asked about, if nothing is said.
const SAMPLES: u32 = 256;

/// Hours that each of them is asked about, and how many conditions of a table are few enough to ask about all.
const HOURS: usize = 8;
const FEW: usize = 64;

/// `heliotile audit`.
pub fn run(args: &AuditArgs, about: Provenance) -> Result<Outcome> {
    let archive = open_archive(&args.archive, Access::Read)?;
    let site = original::site_of(&args.archive, &args.scene)?;
    let scene = original::scene_of(&archive, &site, args.scene.first())?;
    let terminal = Terminal::default();
    let (conditions, name, hours) = match &args.conditions {
        Some(path) => {
            let read = read_conditions(path)?;
            read.warnings.iter().for_each(|text| warn(text));
            let hours = if read.conditions.len() <= FEW { read.conditions.len() } else { HOURS };
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            (read.conditions, name, hours)
        }
        None => {
            let suns = ErrorConditions::read(
                args.weather.as_deref(),
                &args.about_weather.options(false),
                scene.place,
                &terminal,
            )?;
            (suns.some(CONDITIONS), suns.name().to_string(), HOURS)
        }
    };
    let left_out = &archive.manifest().settings.left_out;
    if !left_out.is_empty() {
        remark(&format!("{} leaves out {}, and so does the judge\n", archive.path().display(), left_out.join(", ")))?;
    }
    let (prepared, storage) = (PreparedScene::new(&scene)?, SystemTemp);
    let samples = args.samples.unwrap_or(if args.seconds.is_some() { u32::MAX } else { SAMPLES });
    let audited = audit(&AuditRequest {
        archive: &archive,
        scene: &prepared,
        conditions: &conditions,
        hours: args.hours.map_or(hours, |hours| hours as usize),
        sky: args.sky,
        samples: samples as usize,
        time: args.seconds.map(Duration::from_secs_f64),
        paths: args.paths as usize,
        seed: args.seed,
        memory: MemoryBudget::new(args.memory.0),
        storage: &storage,
        observer: &terminal,
    })?;
    let stated = archive.manifest().accuracy.as_ref();
    let report = AuditReport::new(archive.path(), &audited, &conditions, &name, stated);
    say(&report.text())?;
    if let Some(folder) = &args.output {
        std::fs::create_dir_all(folder).map_err(Error::io(folder, "create"))?;
        write_texts(folder, &report.files(&about.with("weather", &name))?)?;
        say(&format!("{}: read it with a browser\n", folder.join(report::PAGE).display()))?;
    }
    Ok(match report.verdict() {
        Verdict::Refuted => Outcome::ProblemFound,
        Verdict::Holds | Verdict::NothingStated => Outcome::Fine,
    })
}
