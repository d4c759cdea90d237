//! Trees and screens before the sun. In: the sky of a receiver and its crossings of canopies. Out:
//! the part of this sky through which the sun counts as seen.

use heliotile_core::layers::canopy::{Canopy, Powers, SKY};
use heliotile_core::layers::sky_bitmap::SkyBitmap;
use heliotile_core::named::NamedValues;

/// Shade of trees and screens in hours of sun.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum TreeShade {
    /// Only opaque surfaces hide the sun
    #[default]
    Ignore,
    /// Each leaf and screen hides the sun
    Opaque,
    /// Leaves and screens hide the sun where they let less than half of its light through
    Half,
}

impl NamedValues for TreeShade {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("ignore", "Only opaque surfaces hide the sun", TreeShade::Ignore),
        ("opaque", "Each leaf and screen hides the sun", TreeShade::Opaque),
        ("half", "Leaves and screens hide the sun where they let less than half of its light through", TreeShade::Half),
    ];
}

heliotile_core::serde_by_name!(TreeShade);

heliotile_core::parse_by_name!(TreeShade);

impl TreeShade {
    /// Returns the sky of a receiver without the part that its canopies hide; `None` if they hide
    /// none of it. `powers` are the shares of light that canopies let through.
    pub(super) fn hide(self, sky: &SkyBitmap, canopy: &Canopy, powers: &Powers) -> Option<SkyBitmap> {
        let least = match self {
            TreeShade::Ignore => return None,
            TreeShade::Opaque => 1.0,
            TreeShade::Half => 0.5,
        };
        let shares = canopy.through(SKY, powers)?;
        Some(sky.within(&shares.iter().map(|share| *share >= least).collect::<Vec<_>>()))
    }
}
