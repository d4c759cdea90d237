//! Arguments of `receivers`: surfaces that receivers go on, and their density.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;

use crate::cli::SceneArgs;
use heliotile::covering::AlongRequest;
use heliotile::{CoverRequest, Density};

#[derive(Args, Debug)]
pub struct ReceiversArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Table of receivers to write, CSV, or - for standard output:
    /// receiver,x,y,z,nx,ny,nz,area_m2,surface, and the object, building and kind that each receiver
    /// stands for
    #[arg(long, short, default_value = "-")]
    pub output: PathBuf,
    #[command(flatten)]
    pub cover: CoverArgs,
    /// Table to write of receivers that are left out because they are buried in an object or the
    /// terrain, with the same columns and `reason`
    #[arg(long, value_name = "FILE")]
    pub buried: Option<PathBuf>,
    /// Put receivers along lines, such as roads, in place of surfaces, --spacing apart and facing
    /// the direction of travel: a CSV file of the corners of the lines with columns x and y, and
    /// optionally z and line (a name)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["on", "types", "per_surface", "buried", "offset", "min_area"])]
    pub along: Option<PathBuf>,
    /// Height of the receivers, the eyes of drivers, above the z of --along, or above the ground of
    /// the scene where --along states no z
    #[arg(long, value_name = "LENGTH", default_value = "1.2m", requires = "along")]
    pub eye_height: Metres,
    /// Add receivers of --along that face backwards, for travel in both directions
    #[arg(long, requires = "along")]
    pub both_ways: bool,
}

/// Surfaces that receivers go on.
#[derive(Args, Clone, Debug)]
pub struct CoverArgs {
    /// Surfaces to cover: roof, wall, window, ground, floor (surfaces that face down), shade, all,
    /// or names of materials; several with commas [default: roofs, walls and windows; of a building
    /// energy model also outdoor floors, and only surfaces that the sun can reach]
    #[arg(long, value_delimiter = ',')]
    pub on: Vec<String>,
    /// Types of city objects to cover, such as Bridge,GenericCityObject, or all [default:
    /// buildings; all types for --on ground and names of materials]
    #[arg(long, value_delimiter = ',', value_name = "TYPES")]
    pub types: Vec<String>,
    /// Distance between receivers, such as 2m or 50cm
    #[arg(long, value_name = "LENGTH", default_value = "2m", conflicts_with = "per_surface")]
    pub spacing: Metres,
    /// Number of receivers on each surface, in place of --spacing
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub per_surface: Option<u32>,
    /// Distance of receivers from their surfaces
    #[arg(long, value_name = "LENGTH", default_value = "20mm")]
    pub offset: Metres,
    /// Least area of a surface that gets receivers, m2
    #[arg(long, value_name = "AREA", default_value_t = 0.1, value_parser = parse_area)]
    pub min_area: f64,
}

impl ReceiversArgs {
    /// Returns the lines of `--along`, if they are given.
    pub fn along(&self) -> Option<AlongRequest> {
        let lines = self.along.clone()?;
        let (spacing_m, height_m) = (self.cover.spacing.0, self.eye_height.0);
        Some(AlongRequest { lines, spacing_m, height_m, both_ways: self.both_ways })
    }
}

impl CoverArgs {
    /// Returns the request for receivers on surfaces.
    pub fn request(&self) -> CoverRequest {
        CoverRequest {
            on: self.on.clone(),
            types: self.types.clone(),
            density: self.per_surface.map_or(Density::Spacing(self.spacing.0), Density::PerSurface),
            offset_m: self.offset.0,
            min_area_m2: self.min_area,
            ..CoverRequest::default()
        }
    }
}

/// A length in metres, parsed from `2m`, `50cm`, `20mm`, or a number of metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metres(pub f64);

impl FromStr for Metres {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let hint = "give a length from 1mm to 10km, such as 2m, 50cm or 20mm";
        let text = text.trim();
        let units = [("mm", 1e-3), ("cm", 1e-2), ("km", 1e3), ("m", 1.0)];
        let unit = units.into_iter().find_map(|(name, metres)| Some((text.strip_suffix(name)?, metres)));
        let (digits, metres) = unit.unwrap_or((text, 1.0));
        let number = digits.trim().parse::<f64>().map_err(|_| format!("`{text}` is not a length: {hint}"))?;
        let metres = number * metres;
        // The comparison is false for NaN.
        if (0.001..=10_000.0).contains(&metres) {
            Ok(Metres(metres))
        } else {
            Err(format!("`{text}` is out of range: {hint}"))
        }
    }
}

fn parse_area(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(area) if (0.0..=1e9).contains(&area) => Ok(area),
        _ => Err("give an area from 0 to 1e9, in square metres".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Five lengths are read in their units, six texts are refused.
    #[test]
    fn lengths_are_read_in_their_units() {
        for (text, metres) in [("2m", 2.0), ("50 cm", 0.5), ("20mm", 0.02), ("1.5", 1.5), ("0.5km", 500.0)] {
            assert_eq!(text.parse::<Metres>(), Ok(Metres(metres)), "{text}");
        }
        for text in ["", "m", "2ft", "-1m", "nan", "1e9m"] {
            assert!(text.parse::<Metres>().is_err(), "{text}");
        }
    }
}
