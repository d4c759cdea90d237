//! Runs of a model for comparison. In: the model before and after injection, a weather file. Out:
//! hourly output of EnergyPlus without reflections, with its own, and with injected light, and run
//! times in seconds.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use crate::comparison::{RUNS, SurfaceAreas, VARIABLES, compare};
use crate::document::Document;
use crate::eso::{HourlySeries, read_eso};
use crate::injection::{DISTRIBUTION, WITH_OWN};
use crate::new_object::NewObject;
use crate::report::Block;
use heliotile_core::error::{Error, Result};
use heliotile_core::observer::Observer;

/// The EnergyPlus program.
pub struct Engine {
    program: PathBuf,
    /// Version that the program reports.
    pub version: String,
}

/// Sections of the report on runs.
pub type Sections = Vec<(String, Vec<Block>)>;

impl Engine {
    /// Finds the program in a folder or on the search path, and asks for its version.
    pub fn find(folder: Option<&Path>) -> Result<Engine> {
        let name = format!("energyplus{}", env::consts::EXE_SUFFIX);
        let hint = "name the folder of EnergyPlus 25.2 with {energyplus} DIR, or leave {run} out";
        let program = match folder {
            Some(path) if path.is_file() => path.to_owned(),
            Some(folder) => folder.join(&name),
            None => {
                let all = env::var_os("PATH").unwrap_or_default();
                let found = env::split_paths(&all).map(|folder| folder.join(&name)).find(|path| path.is_file());
                found.ok_or_else(|| Error::argument("run", "there is no `energyplus` on the search path", hint))?
            }
        };
        let asked = Command::new(&program).arg("--version").output();
        let asked = asked
            .map_err(|error| Error::argument("run", format!("{} does not run: {error}", program.display()), hint))?;
        let version = String::from_utf8_lossy(&asked.stdout).trim().to_owned();
        if !version.contains("25.2") {
            let what = format!("{} is not EnergyPlus 25.2 but `{version}`", program.display());
            return Err(Error::argument("run", what, hint));
        }
        Ok(Engine { program, version })
    }

    /// Runs a model in a folder of its own; returns the seconds and the hourly output.
    fn run(&self, model: &Document, weather: &Path, folder: &Path) -> Result<(f64, HourlySeries)> {
        fs::create_dir_all(folder).map_err(Error::io(folder, "create"))?;
        let file = folder.join(format!("in.{}", model.ending()));
        fs::write(&file, model.bytes()).map_err(Error::io(&file, "write"))?;
        // The output of an earlier run must not be taken for this one's.
        let eso = folder.join("eplusout.eso");
        if eso.exists() {
            fs::remove_file(&eso).map_err(Error::io(&eso, "remove"))?;
        }
        let begun = Instant::now();
        let mut command = Command::new(&self.program);
        command.arg("-w").arg(weather).arg("-d").arg(folder);
        if model.objects.iter().any(|object| object.class.to_lowercase().starts_with("hvactemplate:")) {
            command.arg("-x");
        }
        let done = command.arg(&file).output().map_err(Error::io(&self.program, "run"))?;
        let seconds = begun.elapsed().as_secs_f64();
        let errors = folder.join("eplusout.err");
        if done.status.success() && !eso.is_file() {
            let what =
                "EnergyPlus finished and reported nothing: the model runs neither a weather file nor a design day";
            let hint = "set `Run Simulation for Weather File Run Periods` of its SimulationControl to Yes";
            return Err(Error::input(&file, None, what, hint));
        }
        if !done.status.success() {
            let said = fs::read(&errors).unwrap_or_default();
            let said = String::from_utf8_lossy(&said);
            let severe = said.lines().find(|line| line.contains("** Severe") || line.contains("**  Fatal"));
            let what =
                format!("EnergyPlus did not finish: {}", severe.unwrap_or("its error file names no reason").trim());
            return Err(Error::input(&file, None, what, format!("see {}", errors.display())));
        }
        let bytes = fs::read(&eso).map_err(Error::io(&eso, "read"))?;
        let series = read_eso(&eso, &bytes, &VARIABLES.map(|variable| variable.0))?;
        Ok((seconds, series))
    }
}

/// Runs all three variants and compares them. `bare` returns the model without injected light, with
/// its surroundings; `areas` are those of its surfaces outdoors.
pub fn run_all(
    engine: &Engine,
    bare: &dyn Fn() -> Result<Document>,
    injected: Document,
    weather: &Path,
    folder: &Path,
    areas: &SurfaceAreas,
    observer: &dyn Observer,
) -> Result<Sections> {
    let (mut none, mut own) = (bare()?, bare()?);
    for (with, without) in WITH_OWN {
        let stated = own.first_text("Building", DISTRIBUTION.0, DISTRIBUTION.1).to_lowercase();
        if stated == without.to_lowercase() {
            own.set("Building", DISTRIBUTION.0, DISTRIBUTION.1, with)?;
        }
        if stated == with.to_lowercase() {
            none.set("Building", DISTRIBUTION.0, DISTRIBUTION.1, without)?;
        }
    }
    let mut results = Vec::new();
    for (name, mut model) in RUNS.into_iter().zip([none, own, injected]) {
        for (variable, ..) in VARIABLES {
            let fields = [("key_value", "*"), ("variable_name", variable), ("reporting_frequency", "Hourly")];
            model.add(NewObject::new("Output:Variable", format!("heliotile {variable}"), &fields).nameless());
        }
        // A model may have switched off the output that is read here.
        model.set("OutputControl:Files", 3, "output_eso", "Yes")?;
        let (seconds, series) = engine.run(&model, weather, &folder.join(name))?;
        observer.report(format!("EnergyPlus, {name}: {seconds:.1} s\n"));
        results.push((seconds, series));
    }
    let seconds: Vec<String> = results.iter().map(|(seconds, _)| format!("{seconds:.1}")).collect();
    let head = ["", "without reflections", "EnergyPlus's own", "injected"].map(str::to_owned).to_vec();
    let row = std::iter::once("seconds".to_owned()).chain(seconds).collect();
    let mut sections = vec![(
        "Runs".to_owned(),
        vec![Block::Text(format!("{}, weather {}", engine.version, weather.display())), Block::Table(head, vec![row])],
    )];
    let series: Vec<HourlySeries> = results.into_iter().map(|(_, series)| series).collect();
    if let Ok(series) = <[HourlySeries; 3]>::try_from(series) {
        sections.extend(compare(&series, areas));
    }
    Ok(sections)
}
