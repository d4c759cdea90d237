//! Completions for shells and manual pages, made from the definition of the command line. In: a
//! shell, or a folder. Out: a script, or pages.

use std::path::Path;

use clap::Command;
use clap_complete::Shell;
use clap_mangen::Man;

use super::{Outcome, remark, say};
use crate::cli::command_line;
use heliotile::cases::claim_folder;
use heliotile::output::write_texts;
use heliotile::text::counted;
use heliotile::{Error, Result};

/// `heliotile --completions`.
pub fn completions(shell: Shell) -> Result<Outcome> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut command_line(), "heliotile", &mut script);
    say(&String::from_utf8_lossy(&script))?;
    Ok(Outcome::Fine)
}

/// `heliotile --man`.
pub fn man(folder: &Path) -> Result<Outcome> {
    let _output = claim_folder(folder)?;
    let mut program = command_line();
    // After `build` every page knows the options of all commands, and its full name.
    program.build();
    let mut pages = Vec::new();
    add_pages(&program, "", &mut pages)?;
    std::fs::create_dir_all(folder).map_err(Error::io(folder, "create"))?;
    let texts: Vec<(&str, String)> = pages.iter().map(|(name, text)| (name.as_str(), text.clone())).collect();
    write_texts(folder, &texts)?;
    let count = counted(pages.len() as u64, "page");
    let example = folder.join("heliotile.1");
    remark(format!("{}: {count}, such as `man {}`\n", folder.display(), example.display()))?;
    Ok(Outcome::Fine)
}

/// Adds the page of a command and the pages of its subcommands: name and text.
fn add_pages(command: &Command, before: &str, pages: &mut Vec<(String, String)>) -> Result<()> {
    let name = format!("{before}{}", command.get_name());
    let (title, file) = (name.to_uppercase(), format!("{name}.1"));
    let mut page = Vec::new();
    let rendered = Man::new(command.clone()).title(title).render(&mut page);
    rendered.map_err(Error::io(file.as_ref(), "render"))?;
    pages.push((file, String::from_utf8_lossy(&page).into_owned()));
    let own = command.get_subcommands().filter(|command| !command.is_hide_set() && command.get_name() != "help");
    own.into_iter().try_for_each(|command| add_pages(command, &format!("{name}-"), pages))
}
