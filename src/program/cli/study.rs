//! Arguments of `study`.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, Subcommand};

use heliotile::tracing::HemisphereMapping;

#[derive(Args, Debug)]
pub struct StudyArgs {
    #[command(subcommand)]
    pub command: StudyCommand,
}

#[derive(Debug, Subcommand)]
pub enum StudyCommand {
    /// Compute Fig. 5: form factor of a wall of 10 m x 10 m at 1 to 50 m, by three maps of the
    /// hemisphere and three numbers of rays
    Wall(WallArgs),
}

#[derive(Args, Debug)]
pub struct WallArgs {
    /// Folder to write wall.csv, wall.svg and wall_error.svg into; created if it does not exist
    #[arg(long, short, value_name = "DIR")]
    pub output: PathBuf,
    /// Maps of the hemisphere: longitude-latitude (equal angles), solid-angle (as in archives),
    /// cosine (every ray counts the same)
    #[arg(long, value_name = "MAPS", value_delimiter = ',', default_value = "longitude-latitude,solid-angle,cosine")]
    pub mapping: Vec<HemisphereMapping>,
    /// Numbers of rays per hemisphere, each a square, as every map has n x n texels; wall.svg shows
    /// the middle one
    #[arg(long, value_name = "NUMBERS", value_delimiter = ',', default_value = "256,1024,4096")]
    pub rays: Vec<RaySquare>,
    /// Distances of the wall, metres: 1..50 in steps of 1, or a list such as 1,2.5,10
    #[arg(long, value_name = "METRES", default_value = "1..50", allow_hyphen_values = true)]
    pub distances: Distances,
    /// Number of points of the receiver, spread evenly over 1 m x 1 m; form factors are their means
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub points: u32,
}

/// Most texels on a side of a map.
const MOST_SIDE: usize = 1024;

/// Number of rays of a hemisphere: `side` x `side`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct RaySquare {
    pub side: usize,
}

impl RaySquare {
    pub fn count(self) -> usize {
        self.side * self.side
    }
}

impl FromStr for RaySquare {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let hint = format!("give squares from 1 to {}, such as 256,1024,4096", MOST_SIDE * MOST_SIDE);
        let count: usize = text.trim().parse().map_err(|_| format!("`{text}` is not a number of rays: {hint}"))?;
        let side = count.isqrt();
        if !(1..=MOST_SIDE).contains(&side) {
            return Err(format!("{count} rays are out of range: {hint}"));
        }
        if side * side != count {
            let (below, above) = (side * side, (side + 1) * (side + 1));
            return Err(format!("{count} is not a square, the nearest squares are {below} and {above}: {hint}"));
        }
        Ok(RaySquare { side })
    }
}

/// Distances in metres, ascending: at least one, each above 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Distances(pub Vec<f64>);

/// Largest distance, metres: farther away the wall is narrower than a ray's rounding error.
const FARTHEST_M: f64 = 10_000.0;

impl FromStr for Distances {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let hint = format!("give metres above 0 and up to {FARTHEST_M}, as in 1..50 or 1,2.5,10");
        let number = |part: &str| match part.trim().parse::<f64>() {
            Ok(metres) if metres > 0.0 && metres <= FARTHEST_M => Ok(metres),
            Ok(metres) => Err(format!("{metres} m is out of range: {hint}")),
            Err(_) => Err(format!("`{part}` is not a distance: {hint}")),
        };
        let mut all = Vec::new();
        for part in text.split(',') {
            match part.split_once("..") {
                None => all.push(number(part)?),
                Some((first, last)) => {
                    let (first, last) = (number(first)?, number(last)?);
                    if first > last {
                        return Err(format!("`{part}` ends before it starts: {hint}"));
                    }
                    all.extend((0..).map(|k| first + f64::from(k)).take_while(|metres| *metres <= last));
                }
            }
        }
        all.sort_by(f64::total_cmp);
        all.dedup();
        Ok(Distances(all))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1..50 is 50 distances, lists and ranges mix (4), and 7 texts without distances are refused
    /// with a hint.
    #[test]
    fn ranges_and_lists_of_distances_mix() {
        let read = |text: &str| text.parse::<Distances>().map(|d| d.0);
        assert_eq!(read("1..50").map(|d| (d.len(), d[49])), Ok((50, 50.0)));
        assert_eq!(read("0.5, 2..3.5,10"), Ok(vec![0.5, 2.0, 3.0, 10.0]));
        for text in ["", "-1", "0", "nan", "5..1", "1..", "10001"] {
            assert!(read(text).is_err_and(|message| message.contains("1..50")), "{text}");
        }
    }

    /// Squares are taken (4 of 4), anything else is refused with a hint (6 of 6); for 1000 the hint
    /// names 961 and 1024.
    #[test]
    fn only_squares_are_numbers_of_rays() {
        for (text, side) in [("1", 1), ("100", 10), ("4096", 64), ("1048576", 1024)] {
            assert_eq!(text.parse(), Ok(RaySquare { side }));
        }
        for text in ["0", "", "-4", "1000", "2.25", "18446744073709551615"] {
            assert!(text.parse::<RaySquare>().is_err_and(|message| message.contains("256,1024,4096")), "{text}");
        }
        let message = "1000".parse::<RaySquare>().expect_err("no square");
        assert!(message.contains("961 and 1024"), "{message}");
    }
}
