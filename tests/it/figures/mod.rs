//! Figures of README and the book. Each block of output is run again and compared, or names the
//! script that makes it. Each table with numbers names its script or says that its numbers are no
//! results.
//!
//! A mark is a comment before a block or table. `<!-- figures: run -->` compares a block with the
//! output of the `sh` block before it, `run COMMAND` with that of another command, `first COMMAND`
//! runs one before an `sh` block, `file NAME` writes a block into the folder of the page, `by PATH`
//! names a script, `none, WHY` says why no script makes it. `HELIOTILE_WRITE_FIGURES=1` writes the
//! present output of the commands into the pages. Times are not compared: numbers before `s`, `ms`
//! and `threads`, the line of a build's stages, and columns named `seconds`.

mod output;
mod page;
mod prose;

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

use page::{Item, Mark, Page};

fn root() -> PathBuf {
    PathBuf::from(crate::ROOT)
}

/// Reads README and the pages of the book.
fn pages() -> Vec<Page> {
    let book = fs::read_dir(root().join("src/book")).expect("the book").map(|entry| entry.expect("an entry").path());
    let mut paths: Vec<PathBuf> = book.filter(|path| path.extension().is_some_and(|end| end == "md")).collect();
    paths.push(root().join("README.md"));
    paths.sort();
    paths.into_iter().map(|path| Page::read(&path)).collect()
}

/// A folder with the program on the search path and the data of the tests.
struct Shell {
    folder: tempfile::TempDir,
}

impl Shell {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a scratch folder");
        let program = folder.path().join("target/release");
        fs::create_dir_all(&program).expect("a folder");
        std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_heliotile"), program.join("heliotile")).expect("a link");
        // Programs that pages name and the test does not run.
        for name in ["cargo", "energyplus"] {
            let other = program.join(name);
            fs::write(&other, "#!/bin/sh\n").expect("a file");
            fs::set_permissions(&other, std::os::unix::fs::PermissionsExt::from_mode(0o755)).expect("a program");
        }
        for name in ["tests", "tools"] {
            std::os::unix::fs::symlink(root().join(name), folder.path().join(name)).expect("a link");
        }
        Shell { folder }
    }

    /// Runs a script; returns its output and errors.
    fn run(&self, script: &str) -> String {
        let path = std::env::var("PATH").unwrap_or_default();
        let output = Command::new("bash")
            .args(["-c", &format!("exec 2>&1\n{script}")])
            .env("PATH", format!("{}:{path}", self.folder.path().join("target/release").display()))
            .current_dir(self.folder.path())
            .output()
            .expect("a shell");
        String::from_utf8_lossy(&output.stdout).into_owned()
    }
}

/// Numbers of blocks and tables of a page, by the word of their marks.
type Counts = BTreeMap<String, usize>;

/// Runs the commands of a page; returns the differences, and writes the present output into the
/// page.
fn check(page: &mut Page, counts: &mut Counts) -> Vec<String> {
    let (mut wrong, shell) = (Vec::new(), Shell::new());
    let mut printed = String::new();
    let items = page.items();
    for item in &items {
        if let Item::Block(block) = item
            && let Some(Mark::File(name)) = &block.mark
        {
            fs::write(shell.folder.path().join(name), page.text_of(block) + "\n").expect("a file");
        }
    }
    for (number, item) in items.iter().enumerate() {
        let Item::Block(block) = item else { continue };
        if let Some(Mark::Run(command)) = &block.mark {
            let output = if command.is_empty() { printed.clone() } else { shell.run(command) };
            *counts.entry("blocks checked".into()).or_default() += 1;
            if block.first == block.last {
                wrong.push(format!("{}:{}: holds no line that could be compared", page.name, block.first + 1));
                continue;
            }
            let found = output::compare(&page.lines[block.first..block.last], &output);
            if let Some(why) = found.wrong {
                wrong.push(format!("{}:{}: {why}", page.name, block.first + 1));
                // The block keeps its number of lines, so that other blocks keep their places.
                page.lines.splice(block.first..block.last, found.now);
            }
        }
        if block.kind == "sh" && is_run(&items[number + 1..]) {
            block.before.iter().for_each(|command| drop(shell.run(command)));
            printed = shell.run(&page.text_of(block));
        }
    }
    wrong
}

/// Returns true if a block of commands is run: output before the next one is compared.
fn is_run(after: &[Item]) -> bool {
    let blocks = after.iter().filter_map(|item| if let Item::Block(block) = item { Some(block) } else { None });
    blocks.take_while(|block| block.kind != "sh").any(|block| matches!(block.mark, Some(Mark::Run(_))))
}

/// Every block that is text or a table of commas, and every table that holds digits, has a mark,
/// and each script that a mark names exists. At least 20 blocks are compared with the output of
/// their commands.
#[test]
fn figures_have_a_source() {
    let (mut missing, mut counts) = (Vec::new(), Counts::new());
    for page in pages() {
        for item in page.items() {
            let (kind, mark, line) = match &item {
                Item::Block(block) if ["text", "csv"].contains(&block.kind.as_str()) => {
                    ("blocks", &block.mark, block.first)
                }
                Item::Table(table) if table.has_digits => ("tables", &table.mark, table.first + 1),
                _ => continue,
            };
            let place = format!("{}:{line}", page.name);
            let word = match mark {
                Some(Mark::Run(_)) => "checked",
                Some(Mark::File(_)) => "inputs of what is checked",
                Some(Mark::By(_)) => "made by a script",
                Some(Mark::None(_)) => "no results",
                None => "without a mark",
            };
            *counts.entry(format!("{kind}: {word}")).or_default() += 1;
            match mark {
                Some(Mark::By(script)) if !root().join(script).exists() => {
                    missing.push(format!("{place}: there is no {script}"));
                }
                None => missing.push(format!("{place}: no mark; see tests/it/figures/mod.rs")),
                _ => {}
            }
        }
    }
    println!("{counts:#?}");
    assert!(missing.is_empty(), "{}", missing.join("\n"));
    assert!(counts["blocks: checked"] >= 20, "{counts:?}");
}

/// Output in README and the book is what the commands print, block by block, 20 or more; times are
/// not compared.
#[test]
fn figures_are_what_commands_print() {
    let (mut wrong, mut counts) = (Vec::new(), Counts::new());
    let write = std::env::var_os("HELIOTILE_WRITE_FIGURES").is_some();
    for mut page in pages() {
        let here = check(&mut page, &mut counts);
        if write && !here.is_empty() {
            fs::write(&page.path, page.lines.join("\n")).expect("a page");
        }
        wrong.extend(here);
    }
    println!("{counts:#?}");
    assert!(
        wrong.is_empty(),
        "{}\n{} blocks differ; HELIOTILE_WRITE_FIGURES=1 writes what commands print now",
        wrong.join("\n"),
        wrong.len()
    );
    assert!(counts["blocks checked"] >= 20, "{counts:?}");
}

/// README's four ranges of errors and CPU times are the smallest and the largest of the eight
/// drawn sites in the book's table, which states error, bias, CPU milliseconds and bytes.
#[test]
fn readme_has_the_ranges_of_the_book() {
    let text = |name: &str| fs::read_to_string(root().join(name)).expect(name);
    let (readme, book) = (text("README.md"), text("src/book/accuracy.md"));
    let cells =
        |line: &str| -> Vec<String> { line.trim_matches('|').split('|').map(|cell| cell.trim().to_string()).collect() };
    let number =
        |text: &str| -> f64 { text.split_whitespace().next().and_then(|word| word.parse().ok()).expect("a number") };
    let sites: Vec<Vec<String>> = book
        .lines()
        .skip_while(|line| !line.starts_with("| site | `draft`"))
        .skip(2)
        .take_while(|line| line.starts_with('|'))
        .map(cells)
        .collect();
    assert_eq!(sites.len(), 8);
    for (rung, quality) in ["draft", "standard", "fine", "reference"].into_iter().enumerate() {
        let row = readme.lines().find(|line| line.starts_with(&format!("| `{quality}`"))).expect("a row");
        for (range, part) in cells(row)[1..].iter().zip([0, 2]) {
            let of_sites: Vec<f64> =
                sites.iter().map(|site| number(site[rung + 1].split('/').nth(part).expect("a part"))).collect();
            let least = of_sites.iter().copied().fold(f64::INFINITY, f64::min);
            let most = of_sites.iter().copied().fold(0.0, f64::max);
            let stated: Vec<f64> = range.split(" to ").map(number).collect();
            assert_eq!(stated, [least, most], "{quality}: {range}");
        }
    }
}
