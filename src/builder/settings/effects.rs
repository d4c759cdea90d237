//! Effects: the light paths that a build may leave out. In: the choice of the user. Out: a set of
//! effects.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Kind of light path. Sun and sky seen directly are always traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Effect {
    /// First diffuse reflection by surfaces.
    Diffuse,
    /// Second and later diffuse reflections.
    Bounces,
    /// Mirrors and glass.
    Mirrors,
    /// Leaves and screens, which dim the light that passes through them. If left out, they are
    /// absent.
    Canopies,
    /// Light scattered by leaves and screens. If left out, they absorb the light they stop.
    Leaves,
}

impl Effect {
    /// All effects, in the order of their numbers.
    pub const ALL: [Effect; 5] = [Effect::Diffuse, Effect::Bounces, Effect::Mirrors, Effect::Canopies, Effect::Leaves];

    /// Returns the name of the effect in options and in the manifest.
    pub fn name(self) -> &'static str {
        match self {
            Effect::Diffuse => "diffuse",
            Effect::Bounces => "bounces",
            Effect::Mirrors => "mirrors",
            Effect::Canopies => "canopies",
            Effect::Leaves => "leaves",
        }
    }
}

/// Set of effects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effects(u8);

impl Effects {
    /// No effect.
    pub const NONE: Effects = Effects(0);
    /// Every effect.
    pub const ALL: Effects = Effects(0b1_1111);

    /// Returns true if the set holds `effect`.
    pub fn contains(self, effect: Effect) -> bool {
        self.0 & 1 << effect as u8 != 0
    }

    /// Adds an effect and the effects it needs: bounces need diffuse light, and scattering leaves
    /// need diffuse light and canopies.
    #[must_use]
    pub fn with(self, effect: Effect) -> Self {
        let implied: &[Effect] = match effect {
            Effect::Bounces => &[Effect::Diffuse],
            Effect::Leaves => &[Effect::Diffuse, Effect::Canopies],
            _ => &[],
        };
        Effects(implied.iter().fold(self.0 | 1 << effect as u8, |set, effect| set | 1 << *effect as u8))
    }

    /// Returns the names of the effects, in the order of [`Effect::ALL`].
    pub fn names(self) -> Vec<String> {
        Effect::ALL.into_iter().filter(|e| self.contains(*e)).map(|e| e.name().to_string()).collect()
    }

    /// Returns the effects with these names, as a manifest lists them. Names of a later release are
    /// ignored.
    pub fn of_names(names: &[String]) -> Self {
        let named = Effect::ALL.into_iter().filter(|e| names.iter().any(|name| name == e.name()));
        Effects(named.fold(0, |set, effect| set | 1 << effect as u8))
    }
}

/// Effects that the user wants to be traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Default)]
#[serde(into = "String", try_from = "String")]
pub enum EffectChoice {
    /// Effects that the scene calls for.
    #[default]
    Auto,
    /// Exactly these effects.
    These(Effects),
}

impl fmt::Display for EffectChoice {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            EffectChoice::Auto => write!(f, "auto"),
            EffectChoice::These(effects) if *effects == Effects::ALL => write!(f, "all"),
            EffectChoice::These(effects) if *effects == Effects::NONE => write!(f, "none"),
            EffectChoice::These(effects) => write!(f, "{}", effects.names().join(",")),
        }
    }
}

impl From<EffectChoice> for String {
    fn from(choice: EffectChoice) -> String {
        choice.to_string()
    }
}

impl TryFrom<String> for EffectChoice {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

/// Parses `auto`, `all`, `none` or names separated by commas.
impl FromStr for EffectChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let one = |name: &str| {
            let names = Effect::ALL.map(Effect::name).join(", ");
            let unknown = || {
                format!(
                    "there is no effect `{name}`: give auto, all, none, or some of {names} with commas between them"
                )
            };
            Effect::ALL.into_iter().find(|e| e.name() == name).ok_or_else(unknown)
        };
        match text.trim() {
            "auto" => Ok(EffectChoice::Auto),
            "all" => Ok(EffectChoice::These(Effects::ALL)),
            "none" => Ok(EffectChoice::These(Effects::NONE)),
            list => {
                let named = |set: Effects, name: &str| Ok(set.with(one(name.trim())?));
                list.split(',').try_fold(Effects::NONE, named).map(EffectChoice::These)
            }
        }
    }
}

heliotile_requests::parse_by_text!(EffectChoice: heliotile_requests::Form::TEXT);

#[cfg(test)]
mod tests {
    use super::*;

    /// Lists come back as they were written. Bounces imply diffuse light (2 effects), leaves imply
    /// canopies and diffuse light (3). An unknown or empty name is refused with all 5 names.
    #[test]
    fn effects_imply_those_they_need() {
        for text in ["auto", "all", "none", "mirrors", "diffuse,bounces", "diffuse,mirrors"] {
            assert_eq!(text.parse::<EffectChoice>().expect(text).to_string(), text);
        }
        assert_eq!("bounces".parse::<EffectChoice>().expect("one").to_string(), "diffuse,bounces");
        assert_eq!("leaves".parse::<EffectChoice>().expect("one").to_string(), "diffuse,canopies,leaves");
        for text in ["", "mirrors,", "glare", "all,mirrors"] {
            let message = text.parse::<EffectChoice>().expect_err(text).to_string();
            assert!(Effect::ALL.into_iter().all(|e| message.contains(e.name())), "{message}");
        }
        let some = Effects::NONE.with(Effect::Mirrors);
        assert_eq!(Effects::of_names(&["mirrors".into(), "fog".into()]), some);
    }
}
