//! Numbers with units and lists of numbers. In: text of the command line. Out: bytes, boxes,
//! depths, or an error.

use heliotile::memory::check_memory;
use heliotile::{Bounds, Bytes};

/// Least memory, bytes: less leaves no room for a tile.
const LEAST_MEMORY: u64 = 64 << 20;

/// Parses the memory to work in.
pub fn parse_memory(text: &str) -> Result<Bytes, String> {
    match text.parse()? {
        Bytes(bytes) if bytes < LEAST_MEMORY => Err("give at least 64MiB".into()),
        bytes => check_memory(bytes),
    }
}

/// Parses a box of positions: `xmin,ymin,xmax,ymax` of any height, or with `zmin,zmax` behind.
pub fn parse_bounds(text: &str) -> Result<Bounds, String> {
    let number = |part: &str| match part.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("`{part}` is not a number")),
    };
    Bounds::of(&text.split(',').map(number).collect::<Result<Vec<f64>, _>>()?)
}

/// Parses a number of diffuse reflections.
pub fn parse_depth(text: &str) -> Result<heliotile::MaxBounces, String> {
    use heliotile::MaxBounces;
    match (text, text.parse::<u32>()) {
        ("all", _) => Ok(MaxBounces::All),
        (_, Ok(count)) if MaxBounces::COUNTS.contains(&count) => Ok(MaxBounces::Count(count)),
        _ => Err("give `all` or a number of reflections from 1 to 64".into()),
    }
}
