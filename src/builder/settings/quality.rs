//! Named rungs of the accuracy ladder.

use heliotile_core::named::NamedValues;
use serde::{Deserialize, Serialize};

/// Named rung of the accuracy ladder. [`Rungs::new`](crate::settings::Rungs::new) says which
/// textures and cells it uses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Quality {
    /// Quick look.
    Draft,
    /// Balance near the knee of error against time.
    #[default]
    Standard,
    /// Results for publication.
    Fine,
    /// Reference to compare the other rungs with.
    Reference,
}

impl Quality {
    /// All qualities, from coarse to fine.
    pub const ALL: [Quality; 4] = [Quality::Draft, Quality::Standard, Quality::Fine, Quality::Reference];

    /// Returns the name of the quality in the manifest and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Quality::Draft => "draft",
            Quality::Standard => "standard",
            Quality::Fine => "fine",
            Quality::Reference => "reference",
        }
    }
}

impl NamedValues for Quality {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("draft", "For a quick look", Quality::Draft),
        ("standard", "For most work: the best balance of error and time", Quality::Standard),
        ("fine", "For publication", Quality::Fine),
        ("reference", "To measure the errors of the others against", Quality::Reference),
    ];
}

heliotile_core::parse_by_name!(Quality);
