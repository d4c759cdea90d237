//! Checks before the work begins. In: a request. Out: a refusal if a file to read is not there or
//! is of another kind, or a file to write has a wrong extension or no folder: at once, not after an
//! hour.

mod kind;
#[cfg(test)]
mod pairs_tests;

use std::path::Path;

use heliotile_core::error::{Error, Problem, Result};
use heliotile_core::text::message;
use heliotile_files::input;
use heliotile_files::writing::claim::{ClaimedOutput, OutputGuard};
use heliotile_files::writing::copy::folder_of;
use heliotile_files::writing::guards::check_archive_name;
use heliotile_remote::naming::{is_address, shown};
use heliotile_remote::places::require_file;
use heliotile_requests::{InputKind, OutputKind, Request, Role};
use heliotile_results::outputs::city_model::is_city_model;
use heliotile_results::outputs::result_file::ResultFormat;
use heliotile_results::outputs::tables::format::{Format, files_of};
use heliotile_studies::covering::check_name;

/// Refuses a request whose files cannot work, and claims its outputs: until the guard is dropped,
/// no other run writes them, and no file replaces an input. `geo`: Parquet is a map; `in_memory`
/// tells names that stand for tables in memory.
pub fn ready<R: Request>(request: &R, geo: bool, in_memory: &dyn Fn(&Path) -> bool) -> Result<OutputGuard> {
    let (mut inputs, mut outputs) = (Vec::new(), Vec::new());
    let skipped = request.skips();
    request.files(&mut |name, role, path| match role {
        _ if skipped.contains(&name) || in_memory(path) => {}
        Role::Input(kind) => inputs.push((path.to_path_buf(), kind)),
        Role::Output(kind) => outputs.push((path.to_path_buf(), kind)),
        Role::Value | Role::Neutral => {}
    });
    outputs.iter().try_for_each(|(path, kind)| check_output(path, *kind, geo))?;
    inputs.iter().try_for_each(|(path, wanted)| match wanted {
        // The reader of an address checks it when it opens it.
        InputKind::Archive | InputKind::SceneOrArchive if is_address(path) => Ok(()),
        _ => {
            require_file(path, "only archives are read from addresses")?;
            input::check(path)?;
            kind::check(*wanted, path)
        }
    })?;
    let inputs: Vec<&Path> = inputs.iter().map(|(path, _)| path.as_path()).filter(|path| !is_address(path)).collect();
    let outputs: Vec<ClaimedOutput> = outputs.iter().filter_map(|(path, kind)| output_of(path, *kind)).collect();
    OutputGuard::new(&inputs, &outputs)
}

/// Claims a folder of one run.
pub fn claim_folder(path: &Path) -> Result<OutputGuard> {
    check_output(path, OutputKind::Folder(&[]), false)?;
    OutputGuard::new(&[], &[ClaimedOutput::folder(path, &[])])
}

/// Returns an output with all files that it consists of; `None` for standard output.
fn output_of(path: &Path, written: OutputKind) -> Option<ClaimedOutput> {
    match written {
        OutputKind::Archive => Some(ClaimedOutput::archive(path)),
        OutputKind::Folder(names) => Some(ClaimedOutput::folder(path, names)),
        _ if path == Path::new("-") => None,
        OutputKind::Table | OutputKind::Results | OutputKind::Csv => {
            Some(ClaimedOutput::file(path, files_of(path).into_iter().skip(1).collect()))
        }
        OutputKind::File => Some(ClaimedOutput::file(path, Vec::new())),
    }
}

fn check_output(path: &Path, written: OutputKind, geo: bool) -> Result<()> {
    if path == Path::new("-") && !matches!(written, OutputKind::Archive | OutputKind::Folder(_)) {
        return Ok(());
    }
    if is_address(path) {
        let hint = message!("write a file, and then: {{command:archive copy}} FILE {}", shown(path).display());
        return Err(Error::input(
            &shown(path),
            None,
            "is an address, and only `archive copy` writes to addresses",
            hint,
        ));
    }
    match written {
        OutputKind::Archive => check_archive_name(path)?,
        OutputKind::Table => drop(Format::by_ending(path)?),
        // `replay` names the other formats that it writes.
        OutputKind::Results if is_city_model(path) => {}
        OutputKind::Results => drop(ResultFormat::by_ending(path, geo)?),
        OutputKind::Csv => check_name(path)?,
        OutputKind::Folder(_) if FILES.contains(&ending(path).as_str()) && !path.is_dir() => {
            let what = "has the ending of a file, and the output is a folder of several files";
            return Err(Error::input(
                path,
                None,
                what,
                format!("give a folder: {}", path.with_extension("").display()),
            )
            .because(Problem::Ending));
        }
        OutputKind::Folder(_) if path.exists() && !path.is_dir() => {
            let what = "is an existing file, and the output is a folder";
            return Err(Error::input(path, None, what, "give the folder another name").because(Problem::Exists));
        }
        // The folder is made together with its parents.
        OutputKind::Folder(_) => return Ok(()),
        OutputKind::File => {}
    }
    let folder = folder_of(path);
    if folder.is_dir() {
        return Ok(());
    }
    let (what, hint) = match folder.exists() {
        true => (format!("{} is not a folder", folder.display()), "give a path in a folder".into()),
        false => (format!("there is no folder {}", folder.display()), format!("mkdir -p {}", folder.display())),
    };
    Err(Error::input(path, None, what, hint).because(Problem::Lacks("folder")))
}

/// Extensions that no folder is meant to have.
const FILES: [&str; 19] = [
    "helio", "csv", "parquet", "arrow", "feather", "npy", "npz", "json", "geojson", "gpkg", "ply", "obj", "epw",
    "toml", "png", "exr", "svg", "html", "txt",
];

/// Returns the extension of an output's name, in small letters.
fn ending(path: &Path) -> String {
    path.extension().map_or(String::new(), |ending| ending.to_string_lossy().to_lowercase())
}
