//! `heliotile sunlight`, `heliotile glare` and `heliotile envelope`: hours of possible sun, the sun
//! in mirrors, rules about them, and buildings that keep them.

use std::fmt::Write;

use super::replay::with_resources;
use super::{Outcome, say};
use crate::commands::console::voice::remark_aside;
use heliotile::cases::{Envelope, Glare, Sunlight};
use heliotile::{Provenance, Result, SunlightDone, shipped_rules, shipped_with};

/// `heliotile sunlight`.
pub fn run(args: &Sunlight, about: Provenance) -> Result<Outcome> {
    let done = with_resources(&args.site, |resources| {
        args.site.open(&args.receivers, about, resources.observer)?.sunlight(&args.request, &args.files, resources)
    })?;
    Ok(tell(&done))
}

/// `heliotile glare`.
pub fn glare(args: &Glare, about: Provenance) -> Result<Outcome> {
    let done = with_resources(&args.site, |resources| {
        args.site.open(&args.receivers, about, resources.observer)?.sunlight(&args.request(), &args.files, resources)
    })?;
    Ok(tell(&done))
}

/// `heliotile envelope`.
pub fn envelope(args: &Envelope, about: Provenance) -> Result<Outcome> {
    let done = with_resources(&args.site, |resources| {
        args.site.open(&args.receivers, about, resources.observer)?.envelope(&args.request, resources)
    })?;
    // Standard output may hold the table, so the remark goes to standard error.
    remark_aside(format!("{}\n", done.text()));
    Ok(Outcome::Fine)
}

fn tell(done: &SunlightDone) -> Outcome {
    // Standard output may hold the table, so the remark goes to standard error.
    remark_aside(done.text());
    Outcome::Fine
}

/// Prints the file of a rule, or the names of all rules.
pub fn rules(name: &str) -> Result<Outcome> {
    if name == "all" {
        let mut text = String::new();
        for file in &shipped_rules()? {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{}", file.name);
            for rule in &file.rules {
                let _ = writeln!(text, "  {:<20} {}", rule.name, rule.title);
            }
        }
        say(&text)?;
        return Ok(Outcome::Fine);
    }
    say(shipped_with(name)?.text)?;
    Ok(Outcome::Fine)
}
