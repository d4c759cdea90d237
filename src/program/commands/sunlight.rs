//! `heliotile sunlight`, `heliotile glare` and `heliotile rules`: hours of possible sun, the sun in
//! mirrors, and rules about them.

use std::fmt::Write;

use super::replay::with_resources;
use super::{Outcome, say};
use crate::commands::console::voice::remark_aside;
use heliotile::cases::{Glare, Rules, SelectionRequest, SiteRequest, Sunlight};
use heliotile::{Error, FileRequest, Provenance, Result, SunlightRequest, shipped_rules};

/// `heliotile sunlight`.
pub fn run(args: &Sunlight, about: Provenance) -> Result<Outcome> {
    write((&args.site, &args.receivers), &args.request, &args.files, about)
}

/// `heliotile glare`.
pub fn glare(args: &Glare, about: Provenance) -> Result<Outcome> {
    write((&args.site, &args.receivers), &args.request(), &args.files, about)
}

fn write(
    (site, receivers): (&SiteRequest, &SelectionRequest),
    request: &SunlightRequest,
    files: &FileRequest,
    about: Provenance,
) -> Result<Outcome> {
    let done = with_resources(site, |resources| {
        site.open(receivers, about, resources.observer)?.sunlight(request, files, resources)
    })?;
    // Standard output may hold the table, so the remark goes to standard error.
    remark_aside(&done.text());
    Ok(Outcome::Fine)
}

/// `heliotile rules`.
pub fn rules(args: &Rules, _: Provenance) -> Result<Outcome> {
    let shipped = shipped_rules()?;
    let Some(name) = &args.name else {
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
    };
    let Some(file) = shipped.iter().find(|file| file.name == *name) else {
        let names: Vec<&str> = shipped.iter().map(|file| file.name).collect();
        let hint = format!("known rules: {}", names.join(", "));
        return Err(Error::argument("name", format!("`{name}` is not a known rule"), hint));
    };
    say(file.text)?;
    Ok(Outcome::Fine)
}
