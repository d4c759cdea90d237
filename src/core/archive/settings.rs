//! The settings of a build. Each number is declared once, in
//! [`for_each_setting`](crate::for_each_setting): its name, its type in the manifest and in a
//! program, its range, the rungs of its accuracy ladder from coarse to fine, and its meaning. The
//! manifest's fields, `--set`, `info`, the ladder and the descriptions in
//! `schema/manifest.schema.json` follow from that.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::error::{Error, Result};

/// Hands the declarations to a macro: name, type in the manifest, type in a program, range, ladder
/// and values of its rungs, meaning.
#[macro_export]
macro_rules! for_each_setting {
    ($with:ident) => {
        $with! {
            sky_base: u32 as usize, PowerOfTwo(8, 1024), Sky [32, 64, 64, 128, 128, 128],
                "Side of the receivers' sky texture before it is refined at edges.";
            sky_fine: u32 as usize, PowerOfTwo(8, 4096), Sky [256, 512, 1024, 2048, 2048, 4096],
                "Side of the finest level of the receivers' sky texture.";
            hit: u32 as usize, PowerOfTwo(8, 256), Seen [8, 16, 32, 32, 32, 64, 64, 128],
                "Side of the hit texture.";
            cell_factor: f64 as f64, Real(0.25, 64.0), Seen [4.0, 4.0, 4.0, 4.0, 2.0, 4.0, 4.0, 8.0],
                "Edge of a cell over the footprint of a hit texel.";
            cell_floor_m: f64 as f64, Real(0.01, 256.0), Seen [1.0, 0.25, 0.02, 0.02, 0.02, 0.02, 0.02, 0.02],
                "Smallest edge of a cell that receivers see, metres.";
            probe: u32 as usize, PowerOfTwo(8, 128), Seen [8, 16, 16, 32, 32, 32, 64, 128],
                "Side of a probe's sky texture, and of the response.";
            probe_hits: u32 as usize, Whole(2, 4096), Bounced [2, 4, 4, 8, 16, 32],
                "Rays of a probe to the surfaces around it.";
            closed_m: f64 as f64, Real(0.5, 1024.0), Bounced [32.0, 32.0, 8.0, 4.0, 2.0, 1.0],
                "Edge of the bounce cells at middle distance, metres; those and coarser ones are solved together.";
            bounce_sky: u32 as usize, PowerOfTwo(8, 64), Bounced [8, 8, 16, 16, 16, 16],
                "Side of the sky texture of a bounce cell.";
            bounce_hits: u32 as usize, Whole(2, 4096), Bounced [4, 4, 4, 8, 16, 32],
                "Rays of a bounce cell to the surfaces around it.";
            patches: u32 as usize, OneOf(&[145, 577, 2305]), Patches [145, 577, 2305],
                "Sky patches that replay takes if it is not told otherwise.";
            steps: u16 as u16, Whole(1, 60), Sky [4, 6, 12, 12, 30, 60],
                "Sun positions an hour that replay takes if it is not told otherwise.";
        }
    };
}

/// Range of values that a setting accepts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SettingRange {
    /// A power of two, from the first to the second.
    PowerOfTwo(u32, u32),
    /// A whole number, from the first to the second.
    Whole(u32, u32),
    /// Any number from the first to the second.
    Real(f64, f64),
    /// One number of a list.
    OneOf(&'static [u32]),
}

impl SettingRange {
    /// Returns true if the range holds whole numbers only.
    pub fn is_whole(self) -> bool {
        !matches!(self, SettingRange::Real(..))
    }

    /// Returns true if a number is inside.
    pub fn contains(self, number: f64) -> bool {
        let inside = |low: u32, high: u32| (f64::from(low)..=f64::from(high)).contains(&number);
        let whole = number.fract() == 0.0;
        match self {
            // A power of two has no bits besides the exponent.
            SettingRange::PowerOfTwo(low, high) => inside(low, high) && number.to_bits().trailing_zeros() >= 52,
            SettingRange::Whole(low, high) => whole && inside(low, high),
            SettingRange::Real(low, high) => (low..=high).contains(&number),
            SettingRange::OneOf(list) => list.iter().any(|one| f64::from(*one) == number),
        }
    }
}

impl fmt::Display for SettingRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SettingRange::PowerOfTwo(low, high) => write!(f, "a power of two from {low} to {high}"),
            SettingRange::Whole(low, high) => write!(f, "{low} to {high}"),
            SettingRange::Real(low, high) => write!(f, "{low} to {high}"),
            SettingRange::OneOf(list) => {
                let names: Vec<String> = list.iter().map(u32::to_string).collect();
                match names.split_last() {
                    Some((last, rest)) if !rest.is_empty() => write!(f, "{} or {last}", rest.join(", ")),
                    _ => write!(f, "{}", names.concat()),
                }
            }
        }
    }
}

/// Source of error that a setting belongs to. Errors of different sources are independent, so each
/// has its own ladder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ladder {
    /// Sky textures: sun and sky seen directly or in mirrors.
    Sky,
    /// Cells that receivers see: one diffuse reflection.
    Seen,
    /// Cells that cells see: further reflections.
    Bounced,
    /// Resolution of the sky at replay.
    Patches,
}

/// Declaration of one numeric setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Key in the manifest, and in `--set`.
    pub name: &'static str,
    /// Sentence that says what the setting is, with its unit.
    pub meaning: &'static str,
    /// Values that a build accepts.
    pub range: SettingRange,
    /// Source of error that it belongs to.
    pub ladder: Ladder,
    /// Values on the rungs of its ladder, from coarse to fine.
    pub rungs: &'static [f64],
}

macro_rules! declare {
    ($($name:ident: $stored:ty as $native:ty, $range:ident($($bound:expr),*), $ladder:ident $rungs:tt, $meaning:literal;)*) => {
        /// All numeric settings, in the order of the manifest's text.
        pub const SETTINGS: &[Setting] = &[$(Setting {
            name: stringify!($name),
            meaning: $meaning,
            range: SettingRange::$range($($bound),*),
            ladder: Ladder::$ladder,
            rungs: as_f64!($rungs),
        }),*];

        /// The settings of a build, as the manifest states them.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        pub struct Settings {
            /// Name of the rung of the accuracy ladder, such as `fine`; empty if the settings are
            /// not those of a named one.
            pub quality: String,
            $(#[doc = $meaning] pub $name: $stored,)*
            /// Sharing of probes: `cells`, or `none` for the reference with a hemisphere a hit.
            pub share: String,
            /// Number of bounces that the response holds: `all`, or a number.
            pub bounces: String,
            /// Effects that the scene has and that were not traced.
            #[serde(default, skip_serializing_if = "Vec::is_empty")]
            pub left_out: Vec<String>,
            /// Version of the tracing. A release that traces the same scene differently states
            /// another one.
            pub tracing: u32,
            /// Keys that this release does not know.
            #[serde(flatten)]
            pub other: BTreeMap<String, Value>,
        }

        impl Settings {
            /// Iterates over the numbers with their declarations.
            pub fn numbers(&self) -> impl Iterator<Item = (&'static Setting, f64)> {
                SETTINGS.iter().zip([$(f64::from(self.$name)),*])
            }
        }
    };
}

/// Returns numbers of any type as a list of f64.
macro_rules! as_f64 {
    ([$($number:literal),*]) => { &[$($number as f64),*] };
}

for_each_setting!(declare);

impl Settings {
    /// Returns the default number of sky patches at replay.
    pub fn patches(&self) -> usize {
        self.patches as usize
    }

    /// Returns the default number of sun positions an hour at replay.
    pub fn steps(&self) -> u16 {
        self.steps
    }

    /// Returns the hash of the settings, made of their JSON. Other settings, also those of a later
    /// release, have another hash.
    pub fn hash(&self) -> Result<[u8; 32]> {
        let json = serde_json::to_vec(self).map_err(unnamed)?;
        Ok(*blake3::hash(&json).as_bytes())
    }

    /// Returns the settings that have another value now, in words: `hit 16, now 24`.
    pub fn differences(&self, now: &Self) -> Result<Vec<String>> {
        let stated = |settings: &Self| -> Result<BTreeMap<String, Value>> {
            serde_json::to_value(settings).and_then(serde_json::from_value).map_err(unnamed)
        };
        let (then, now) = (stated(self)?, stated(now)?);
        let value = |of: Option<&Value>| of.map_or_else(|| "not stated".to_string(), Value::to_string);
        let names: BTreeSet<&String> = then.keys().chain(now.keys()).collect();
        let other = names.into_iter().filter(|name| then.get(*name) != now.get(*name));
        Ok(other.map(|name| format!("{name} {}, now {}", value(then.get(name)), value(now.get(name)))).collect())
    }
}

fn unnamed(error: serde_json::Error) -> Error {
    Error::Unsupported {
        what: "naming settings".into(),
        found: error.to_string(),
        supported: "what JSON can hold".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every rung of the 12 numbers lies in its range. The numbers of one ladder have equally many
    /// rungs (6, 8, 6, 3). No range holds 0, -1 or NaN.
    #[test]
    fn rungs_lie_in_their_ranges() {
        for setting in SETTINGS {
            assert!(setting.rungs.iter().all(|rung| setting.range.contains(*rung)), "{}", setting.name);
            assert!([0.0, -1.0, f64::NAN].iter().all(|wrong| !setting.range.contains(*wrong)), "{}", setting.name);
            let count = match setting.ladder {
                Ladder::Sky | Ladder::Bounced => 6,
                Ladder::Seen => 8,
                Ladder::Patches => 3,
            };
            assert_eq!(setting.rungs.len(), count, "{}", setting.name);
        }
        assert_eq!(SETTINGS.len(), 12);
    }

    /// The 12 descriptions and types of the JSON Schema are those that are declared here.
    #[test]
    fn the_schema_holds_the_declared_settings() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../schema/manifest.schema.json");
        let schema: Value = serde_json::from_slice(&std::fs::read(path).expect("a file")).expect("JSON");
        let properties = &schema["properties"]["settings"]["properties"];
        for setting in SETTINGS {
            let stated = &properties[setting.name];
            assert_eq!(stated["description"], setting.meaning, "{}", setting.name);
            let kind = if setting.range.is_whole() { "integer" } else { "number" };
            assert_eq!(stated["type"], kind, "{}", setting.name);
        }
        let more = ["quality", "share", "bounces", "left_out", "tracing"];
        assert_eq!(properties.as_object().expect("an object").len(), SETTINGS.len() + more.len());
    }
}
