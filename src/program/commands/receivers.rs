//! `heliotile receivers`: receivers on the surfaces of a scene, or along lines in it. In: a scene.
//! Out: `receivers.csv`, without receivers that are buried in a neighbour or the terrain; these are
//! counted.

use std::path::Path;

use super::console::terminal::Terminal;
use super::console::voice::remark_aside;
use super::{Outcome, remark};
use heliotile::cases::Receivers;
use heliotile::text::Message;
use heliotile::{Provenance, Result};

/// `heliotile receivers`.
pub fn run(args: &Receivers, _: Provenance) -> Result<Outcome> {
    let text = args.write(&Terminal::default())?;
    // Standard output may hold the table, so the summary goes to standard error.
    if args.output() == Path::new("-") {
        remark_aside(text);
    } else {
        remark(Message::from(format!("{}: ", args.output().display())).and(text))?;
    }
    Ok(Outcome::Fine)
}
