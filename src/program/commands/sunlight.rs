//! `heliotile sunlight`, `heliotile glare` and `heliotile envelope`: hours of possible sun, the sun
//! in mirrors, rules about them, and buildings that keep them.

use std::fmt::Write;

use super::replay::with_resources;
use super::{Outcome, say};
use crate::commands::console::voice::remark_aside;
use heliotile::cases::{Envelope, Glare, Sunlight};
use heliotile::requests::Problem;
use heliotile::{Error, Provenance, Result, SunlightDone, shipped_rules};

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
    let shipped = shipped_rules()?;
    if name == "all" {
        let mut text = String::new();
        for file in &shipped {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{}", file.name);
            for rule in &file.rules {
                let _ = writeln!(text, "  {:<20} {}", rule.name, rule.title);
            }
        }
        say(&text)?;
        return Ok(Outcome::Fine);
    }
    let Some(file) = shipped.iter().find(|file| file.name == name) else {
        let names: Vec<&str> = shipped.iter().map(|file| file.name).collect();
        let hint = format!("give all, or one of {}", names.join(", "));
        let unknown = Problem::unknown(name, names);
        return Err(Error::argument("rule", format!("`{name}` is not a known rule"), hint).because(unknown));
    };
    say(file.text)?;
    Ok(Outcome::Fine)
}
