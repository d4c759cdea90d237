//! Named rungs of the accuracy ladder.

use heliotile_core::named::NamedValues;
use serde::{Deserialize, Serialize};

/// A named rung of the accuracy ladder; what it means in textures and cells follows from [`Rungs::of`](crate::settings::Rungs::of).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Quality {
    /// A quick look.
    Draft,
    /// Near the knee of error against time.
    #[default]
    Standard,
    /// For publication.
    Fine,
    /// To judge the others by.
    Reference,
}

impl Quality {
    /// From coarse to fine.
    pub const ALL: [Quality; 4] = [Quality::Draft, Quality::Standard, Quality::Fine, Quality::Reference];

    /// As the manifest and the command line name it.
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
        ("draft", "A quick look", Quality::Draft),
        ("standard", "Near the knee of error against time", Quality::Standard),
        ("fine", "For publication", Quality::Fine),
        ("reference", "To judge the others by", Quality::Reference),
    ];
}
