//! Numbers with units and several at once, as command lines give them. In: text. Out: bytes, boxes, depths; what is wrong with them.

use std::str::FromStr;

use heliotile_builder::transfer::Bounds;

/// A number of bytes: `2GiB`, `512MiB`, `800MB`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bytes(pub u64);

/// Less than this leaves no room for a tile.
const LEAST_MEMORY: u64 = 64 << 20;

impl FromStr for Bytes {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
        let hint = "give a number and MiB, GiB, MB or GB, as in 512MiB";
        let unit = match &text[digits.len()..] {
            "GiB" | "G" => 1 << 30,
            "MiB" | "M" => 1 << 20,
            "GB" => 1_000_000_000,
            "MB" => 1_000_000,
            "" => return Err(format!("there is no unit: {hint}")),
            other => return Err(format!("`{other}` is not a unit: {hint}")),
        };
        let number = digits.trim().parse::<f64>().ok().filter(|number| *number >= 0.0);
        let number = number.ok_or_else(|| format!("`{digits}` is not a number of bytes: {hint}"))?;
        // `as` saturates.
        Ok(Bytes((number * unit as f64) as u64))
    }
}

/// Memory to work in.
pub fn parse_memory(text: &str) -> Result<Bytes, String> {
    match text.parse()? {
        Bytes(bytes) if bytes < LEAST_MEMORY => Err("the least is 64MiB".into()),
        bytes => Ok(bytes),
    }
}

/// A box of positions: `xmin,ymin,xmax,ymax` of any height, or with `zmin,zmax` behind.
pub fn parse_bounds(text: &str) -> Result<Bounds, String> {
    let number = |part: &str| match part.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("`{part}` is not a number")),
    };
    Bounds::of(&text.split(',').map(number).collect::<Result<Vec<f64>, _>>()?)
}

/// A number of reflections.
pub fn parse_depth(text: &str) -> Result<heliotile_core::light::radiosity::MaxBounces, String> {
    use heliotile_core::light::radiosity::MaxBounces;
    match (text, text.parse::<u32>()) {
        ("all", _) => Ok(MaxBounces::All),
        (_, Ok(count @ 1..=64)) => Ok(MaxBounces::Count(count)),
        _ => Err("give `all` or a number of reflections from 1 to 64".into()),
    }
}
