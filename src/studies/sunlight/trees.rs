//! Trees and screens before the sun. In: the sky of a receiver and its crossings of canopies. Out:
//! the part of this sky through which the sun counts as seen.

use heliotile_core::layers::canopy::{Canopy, Powers, SKY, sky_side};
use heliotile_core::layers::sky_bitmap::SkyBitmap;
use heliotile_core::named::NamedValues;
use heliotile_core::opened::SiteSettings;

/// Canopies (trees, screens) before the sun in hours of sun.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum TreesBeforeSun {
    /// Only opaque surfaces hide the sun
    #[default]
    Ignore,
    /// Each leaf and screen hides the sun
    Opaque,
    /// Leaves and screens hide the sun where they let less than half of its light through
    Half,
}

impl NamedValues for TreesBeforeSun {
    const VALUES: &'static [(&'static str, &'static str, Self)] = &[
        ("ignore", "Only opaque surfaces hide the sun", TreesBeforeSun::Ignore),
        ("opaque", "Each leaf and screen hides the sun", TreesBeforeSun::Opaque),
        (
            "half",
            "Leaves and screens hide the sun where they let less than half of its light through",
            TreesBeforeSun::Half,
        ),
    ];
}

heliotile_core::serde_by_name!(TreesBeforeSun);

heliotile_core::parse_by_name!(TreesBeforeSun);

impl TreesBeforeSun {
    /// Returns the sky of a receiver without the part that its canopies hide; `None` if they hide
    /// none of it. `powers` are the shares of light that canopies let through.
    pub(super) fn hide(
        self,
        sky: &SkyBitmap,
        canopy: &Canopy,
        powers: &Powers,
        settings: &SiteSettings,
    ) -> Option<SkyBitmap> {
        let least = match self {
            TreesBeforeSun::Ignore => return None,
            TreesBeforeSun::Opaque => 1.0,
            TreesBeforeSun::Half => 0.5,
        };
        let shares = canopy.through(SKY, powers)?;
        let side = sky_side(settings.sky_base, settings.sky_fine);
        // A texel of the square covers whole fine texels.
        let fine = sky.side() * sky.block() / side;
        Some(sky.within(|column, row| shares[row / fine * side + column / fine] >= least))
    }
}
