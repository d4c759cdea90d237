//! A page of Markdown as blocks and tables. In: its lines. Out: each with its mark.

use std::fs;
use std::path::{Path, PathBuf};

/// Content of a comment before a block or table.
#[derive(Clone, Debug, PartialEq)]
pub enum Mark {
    /// The block is printed by this command, or by the commands before if it is empty.
    Run(String),
    /// The block is written into the folder of the page under this name.
    File(String),
    /// The figures are made by this script.
    By(String),
    /// No script makes the figures; the reason.
    None(String),
}

/// A fenced block.
#[derive(Clone, Debug)]
pub struct Block {
    /// Index of the first line between the fences.
    pub first: usize,
    /// Index of the line of the closing fence.
    pub last: usize,
    /// Word behind the opening fence.
    pub kind: String,
    pub mark: Option<Mark>,
    /// Commands that are run before those of the block.
    pub before: Vec<String>,
}

/// A table in Markdown.
#[derive(Clone, Debug)]
pub struct Table {
    pub first: usize,
    pub has_digits: bool,
    pub mark: Option<Mark>,
}

#[derive(Clone, Debug)]
pub enum Item {
    Block(Block),
    Table(Table),
}

pub struct Page {
    pub path: PathBuf,
    /// Path below the root of the project.
    pub name: String,
    pub lines: Vec<String>,
}

impl Page {
    pub fn read(path: &Path) -> Self {
        let text = fs::read_to_string(path).expect("a page");
        let name = path.strip_prefix(super::root()).unwrap_or(path).display().to_string();
        Page { path: path.into(), name, lines: text.split('\n').map(String::from).collect() }
    }

    pub fn text_of(&self, block: &Block) -> String {
        self.lines[block.first..block.last].join("\n")
    }

    /// Returns the blocks and tables in order.
    pub fn items(&self) -> Vec<Item> {
        let (mut items, mut mark, mut before) = (Vec::new(), None, Vec::new());
        let mut at = 0;
        while at < self.lines.len() {
            let line = self.lines[at].trim();
            if let Some(says) = line.strip_prefix("<!-- figures: ").and_then(|rest| rest.strip_suffix(" -->")) {
                match says.split_once(' ').unwrap_or((says, "")) {
                    ("run", command) => mark = Some(Mark::Run(command.into())),
                    ("first", command) => before.push(command.into()),
                    ("file", name) => mark = Some(Mark::File(name.into())),
                    ("by", script) => mark = Some(Mark::By(script.into())),
                    ("none,", why) => mark = Some(Mark::None(why.into())),
                    _ => panic!("{}:{}: `{says}` is no mark", self.name, at + 1),
                }
                at += 1;
            } else if let Some(kind) = line.strip_prefix("```") {
                let first = at + 1;
                let length = self.lines[first..].iter().position(|line| line.trim() == "```").expect("a closing fence");
                let (mark, before) = (mark.take(), std::mem::take(&mut before));
                items.push(Item::Block(Block { first, last: first + length, kind: kind.into(), mark, before }));
                at = first + length + 1;
            } else if line.starts_with('|') {
                let rows = self.lines[at..].iter().take_while(|line| line.starts_with('|')).count();
                let digits = |line: &String| line.contains(|c: char| c.is_ascii_digit());
                let has_digits = self.lines[at..at + rows].iter().any(digits);
                items.push(Item::Table(Table { first: at, has_digits, mark: mark.take() }));
                at += rows;
            } else {
                at += 1;
            }
        }
        items
    }
}
