//! When receivers see the sun, by its path through their sky textures. In: a site, dates, sky bits. Out: spells of sun on each day, with a bound
//! on how far they may be wrong.
//!
//! No sun is sampled: the path of the sun's centre over a day is cut where it passes from texel to texel, once for all receivers. What a texture
//! says of a day is then exact; what it does not say, since an edge passes through a texel, is a bound ([`SunSeen`]).

mod day_minutes;
mod mirrored;
mod path;
mod seen;
mod spells;

pub use day_minutes::DayMinutes;
pub use mirrored::{GlareAngles, MirrorSpells, MirrorSuns, Strongest, TileMirrors, in_any};
pub use path::{SunDay, SunPasses};
pub use seen::{SeenSky, SunSeen};
pub use spells::{Spell, Spells};
