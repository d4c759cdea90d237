//! Every pair of an output with an input or another output, of every command.

use std::fs;
use std::path::Path;

use crate::cases::{COMMANDS, Command, Given};
use heliotile_requests::{GroupKind, InputKind, Many, OutputKind, Role, Row};

/// Text that names a file in a field; `NAME=` stands before it where the field needs one.
fn text(row: &Row, file: &Path) -> String {
    let before = if row.metavar.is_some_and(|shown| shown.contains('=')) { "ground=" } else { "" };
    format!("{before}{}", file.display())
}

/// File for a field, with the ending of its kind.
fn file(row: &Row, folder: &Path) -> Option<String> {
    let ending = match row.role {
        Role::Input(InputKind::Scene | InputKind::SceneOrArchive) => "obj",
        Role::Input(InputKind::Archive) | Role::Output(OutputKind::Archive) => "helio",
        Role::Input(InputKind::Weather) => "epw",
        Role::Output(OutputKind::File) if row.name == "html" => "html",
        Role::Output(OutputKind::File) => "png",
        Role::Input(_) | Role::Output(OutputKind::Table | OutputKind::Results | OutputKind::Csv) => "csv",
        Role::Output(_) => "out",
        Role::Value | Role::Neutral => return None,
    };
    let name = match row.role {
        Role::Output(_) => format!("new-{}.{ending}", row.name),
        // A scene, an archive, weather and tables that are there.
        _ => format!("old-{}.{ending}", row.name),
    };
    let file = folder.join(name);
    if matches!(row.role, Role::Input(_)) && !file.exists() {
        let head = match row.role {
            Role::Input(InputKind::Weather) => "LOCATION,Golden\n".as_bytes(),
            Role::Input(InputKind::Receivers) => b"receiver,x,y,z,nx,ny,nz\n",
            Role::Input(InputKind::Conditions) => b"condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\n",
            Role::Input(InputKind::Archive) => &heliotile_core::archive::format::MAGIC,
            _ => b"# anything\n",
        };
        fs::write(&file, head).expect("a file");
    }
    Some(text(row, &file))
}

/// Text for a field that holds no file.
fn plain(row: &Row) -> Option<String> {
    let choices = (row.form.choices)();
    let ideas = ["1", "a", "2m", "0,0,9,9", "180,40"].map(str::to_owned);
    let first = choices.first().map(|(name, _)| (*name).to_owned());
    row.default.clone().or(first).into_iter().chain(ideas).find(|text| (row.test)(text).is_ok())
}

/// Fills `wanted` and all that they, or the command, need.
fn filled(command: &Command, wanted: &[&str], folder: &Path) -> Option<Given> {
    let rows = (command.rows)();
    let row = |name: &str| rows.iter().find(|row| row.name == name);
    let mut names: Vec<&str> = wanted.to_vec();
    let excluded = |name: &str, names: &[&str]| {
        let excludes = |one: &str, other: &str| row(one).is_some_and(|row| row.conflicts.contains(&other));
        names.iter().any(|known| excludes(known, name) || excludes(name, known))
    };
    names.extend(rows.iter().filter(|row| row.required && !wanted.contains(&row.name)).map(|row| row.name));
    for group in (command.groups)() {
        let members: Vec<&str> = group.names.iter().copied().filter(|name| row(name).is_some()).collect();
        let is_met = members.iter().any(|name| names.contains(name));
        if members.len() > 1 && group.kind != GroupKind::AtMostOne && !is_met {
            names.extend(members.into_iter().find(|name| !excluded(name, &names)));
        }
    }
    let mut at = 0;
    while let Some(name) = names.get(at).copied() {
        let needed: Vec<&str> = row(name)?.requires.iter().copied().filter(|name| row(name).is_some()).collect();
        if !needed.is_empty() && !needed.iter().any(|name| names.contains(name)) {
            names.extend(needed.first());
        }
        at += 1;
    }
    let text = |row: &Row| {
        if row.many == Many::Flag {
            Some(Vec::new())
        } else {
            file(row, folder).or_else(|| plain(row)).map(|text| vec![text])
        }
    };
    rows.iter().filter(|row| names.contains(&row.name)).map(|row| Some((row.name.to_owned(), text(row)?))).collect()
}

/// Refuses an input that is one of the files `names` of the output folder. Returns how many were
/// tried.
fn inputs_in_folder(command: &Command, output: &Row, input: &Row, names: &[&str]) -> usize {
    let folder = tempfile::tempdir().expect("a folder");
    let Some(mut given) = filled(command, &[output.name, input.name], folder.path()) else { return 0 };
    if (command.check)(&given).is_err() {
        return 0;
    }
    let path = |row: &Row| {
        file(row, folder.path()).map(|text| text.rsplit('=').next().unwrap_or_default().to_owned()).unwrap_or_default()
    };
    let (written, read) = (path(output), path(input));
    for name in names {
        fs::create_dir_all(&written).expect("a folder");
        let moved = Path::new(&written).join(name);
        fs::copy(&read, &moved).expect("a copy");
        let from = given.iter_mut().find(|(field, _)| field == input.name).expect("the input");
        from.1 = vec![text(input, &moved)];
        assert!((command.check)(&given).is_err(), "{}: {} in {}", command.name, input.name, output.name);
    }
    names.len()
}

/// A pair of an output with an input, or with another output, is refused where both are one file,
/// by its own name, through a link and through `./`, and so is an input in a folder that would be
/// written over it; with two files each request passes. 207 pairs of 16 commands, and 20 of files
/// in folders; no byte of an input is changed.
#[test]
fn no_output_is_an_input_or_another_output() {
    let (mut pairs, mut inside, mut commands, mut skipped) = (0, 0, 0, Vec::new());
    for command in COMMANDS {
        let rows = (command.rows)();
        let outputs = rows.iter().filter(|row| matches!(row.role, Role::Output(_)));
        let mut pairs_here = 0;
        for output in outputs {
            for other in rows.iter().filter(|row| matches!(row.role, Role::Input(_) | Role::Output(_))) {
                let is_folder = |row: &Row| matches!(row.role, Role::Output(OutputKind::Folder(_)));
                if let (Role::Output(OutputKind::Folder(names)), Role::Input(_)) = (output.role, other.role) {
                    inside += inputs_in_folder(command, output, other, names);
                }
                if other.name == output.name || is_folder(other) != is_folder(output) {
                    continue;
                }
                let folder = tempfile::tempdir().expect("a folder");
                let Some(mut given) = filled(command, &[output.name, other.name], folder.path()) else {
                    skipped.push(format!("{} {} {}: not filled", command.name, output.name, other.name));
                    continue;
                };
                if let Err(error) = (command.check)(&given) {
                    // Fields that exclude each other are never filled together.
                    skipped.push(format!("{} {} {}: {error}", command.name, output.name, other.name));
                    continue;
                }
                let path = |row: &Row| {
                    file(row, folder.path()).map(|text| text.rsplit('=').next().unwrap_or_default().to_owned())
                };
                let existing = path(other).expect("a file");
                let before = fs::read(&existing).ok();
                let mut ways = vec![existing.clone(), existing.replace("/new-", "/./new-").replace("/old-", "/./old-")];
                let link = folder.path().join(format!("link.{}", existing.rsplit('.').next().unwrap_or_default()));
                #[cfg(unix)]
                if before.is_some() && std::os::unix::fs::symlink(&existing, &link).is_ok() {
                    ways.push(link.display().to_string());
                }
                for way in ways {
                    let to = given.iter_mut().find(|(name, _)| name == output.name).expect("the output");
                    to.1 = vec![text(output, Path::new(&way))];
                    let refused = (command.check)(&given);
                    assert!(refused.is_err(), "{}: {} and {} are {way}", command.name, output.name, other.name);
                    assert_eq!(fs::read(&existing).ok(), before);
                }
                (pairs, pairs_here) = (pairs + 1, pairs_here + 1);
            }
        }
        commands += usize::from(pairs_here > 0);
    }
    let skips = skipped.join("\n");
    assert!(pairs >= 207 && commands >= 16, "{pairs} pairs of {commands} commands; skipped:\n{skips}");
    assert!(inside >= 20, "{inside} pairs of folders");
}
