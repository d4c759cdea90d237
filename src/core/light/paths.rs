//! The light paths that count. In: names. Out: the number of diffuse reflections that are followed,
//! and the paths by mirrors.

use std::str::FromStr;

use crate::light::radiosity::MaxBounces;

/// Light paths that may be left out. Light straight from sun and sky, by one diffuse reflection, or
/// from the sun in mirrors always counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightPaths {
    /// Number of diffuse reflections that are followed.
    pub depth: MaxBounces,
    /// True if diffusely reflected light that also meets a mirror counts: light that mirrors throw
    /// on surfaces, and surfaces that are seen in mirrors.
    pub mirror_diffuse: bool,
    /// True if the sky that is seen in mirrors counts, column `sky_mirrored`.
    pub mirror_sky: bool,
}

impl LightPaths {
    /// All light paths.
    pub const ALL: LightPaths = LightPaths { depth: MaxBounces::All, mirror_diffuse: true, mirror_sky: true };

    /// None of the optional paths: the light paths of EnergyPlus (Engineering Reference, "Solar
    /// Radiation Reflected from Exterior Surfaces").
    pub const FIRST: LightPaths = LightPaths { depth: MaxBounces::Count(1), mirror_diffuse: false, mirror_sky: false };

    /// Returns the paths with at most `depth` diffuse reflections. It is an error to ask for
    /// several where only the first counts.
    pub fn with_depth(self, depth: MaxBounces) -> Result<Self, String> {
        match (self.depth, depth) {
            (MaxBounces::All, depth) => Ok(LightPaths { depth, ..self }),
            (first, MaxBounces::All | MaxBounces::Count(1)) => Ok(LightPaths { depth: first, ..self }),
            (_, MaxBounces::Count(count)) => {
                Err(format!("{count} diffuse reflections need `{}` among the paths", NAMES[0]))
            }
        }
    }
}

/// All paths by mirrors, and at most the given number of diffuse reflections.
impl From<MaxBounces> for LightPaths {
    fn from(depth: MaxBounces) -> Self {
        LightPaths { depth, ..LightPaths::ALL }
    }
}

/// Names of the three options, in the order of the fields.
const NAMES: [&str; 3] = ["bounces", "mirror-diffuse", "mirror-sky"];

/// Parses `all`, `none`, or some of `bounces,mirror-diffuse,mirror-sky`.
impl FromStr for LightPaths {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim() {
            "all" => return Ok(LightPaths::ALL),
            "none" => return Ok(LightPaths::FIRST),
            _ => {}
        }
        let mut counted = [false; NAMES.len()];
        for part in text.split(',').map(str::trim) {
            let Some(place) = NAMES.iter().position(|name| *name == part) else {
                return Err(format!(
                    "`{part}` is not a known light path; give all, none, or some of {}",
                    NAMES.join(", ")
                ));
            };
            if std::mem::replace(&mut counted[place], true) {
                return Err(format!("`{part}` is named twice"));
            }
        }
        let [bounces, mirror_diffuse, mirror_sky] = counted;
        let depth = if bounces { MaxBounces::All } else { MaxBounces::Count(1) };
        Ok(LightPaths { depth, mirror_diffuse, mirror_sky })
    }
}

heliotile_requests::parse_by_text!(LightPaths: heliotile_requests::Form::TEXT);

/// Reads a number of diffuse reflections, or `all`.
pub fn parse_depth(text: &str) -> Result<MaxBounces, String> {
    match (text, text.parse::<u32>()) {
        ("all", _) => Ok(MaxBounces::All),
        (_, Ok(count)) if MaxBounces::COUNTS.contains(&count) => Ok(MaxBounces::Count(count)),
        _ => Err("give `all` or a number of reflections from 1 to 64".into()),
    }
}

impl heliotile_requests::Parse for MaxBounces {
    fn parse(text: &str) -> Result<Self, heliotile_requests::Wrong> {
        Ok(parse_depth(text)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The three names together, in any order, are `all`. One name leaves the other two out. 4 of 4
    /// bad texts are refused.
    #[test]
    fn path_names_come_back_and_bad_ones_are_refused() {
        let of = |text: &str| text.parse::<LightPaths>();
        assert_eq!(of("mirror-sky, bounces,mirror-diffuse"), Ok(LightPaths::ALL));
        assert_eq!((of("all"), of("none")), (Ok(LightPaths::ALL), Ok(LightPaths::FIRST)));
        assert_eq!(of("mirror-sky"), Ok(LightPaths { mirror_sky: true, ..LightPaths::FIRST }));
        for text in ["", "all,bounces", "bounces,bounces", "mirror"] {
            assert!(of(text).is_err(), "{text}");
        }
    }

    /// A limit of 3 reflections is accepted among all paths, and refused where only the first
    /// counts. There, 1 and all give 1.
    #[test]
    fn several_reflections_need_all_paths() {
        let three = MaxBounces::Count(3);
        assert_eq!(LightPaths::ALL.with_depth(three), Ok(LightPaths { depth: three, ..LightPaths::ALL }));
        assert!(LightPaths::FIRST.with_depth(three).is_err());
        for depth in [MaxBounces::All, MaxBounces::Count(1)] {
            assert_eq!(LightPaths::FIRST.with_depth(depth), Ok(LightPaths::FIRST));
        }
    }
}
