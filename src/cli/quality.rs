//! Quality: the named rungs of the accuracy ladder.

use std::fmt;

/// A named rung. What it means in textures and cells stands in `commands::build::ladder`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Quality {
    /// A quick look
    Draft,
    /// The knee of error against time
    #[default]
    Standard,
    /// For publication
    Fine,
    /// To judge the others by
    Reference,
}

impl Quality {
    pub const ALL: [Quality; 4] = [Quality::Draft, Quality::Standard, Quality::Fine, Quality::Reference];

    pub fn name(self) -> &'static str {
        match self {
            Quality::Draft => "draft",
            Quality::Standard => "standard",
            Quality::Fine => "fine",
            Quality::Reference => "reference",
        }
    }
}

impl fmt::Display for Quality {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}
