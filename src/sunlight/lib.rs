//! Hours of direct sunlight of receivers, from the sun's path through their sky textures. In: a
//! site, dates, sky bits. Out: spells (time intervals) of sun on each day, with a bound on their
//! error.
//!
//! No sun is sampled. The path of the sun's centre over a day is cut where it passes from texel to
//! texel, once for all receivers. The spells of a day are exact for a texture. Where an edge passes
//! through a texel the texture does not know, and the spells have a bound instead ([`SunSeen`]).

mod day_minutes;
mod mirrored;
mod path;
mod seen;
mod spells;

pub use day_minutes::DayMinutes;
pub use mirrored::{GlareAngles, HotSpot, MirrorSpells, MirrorSuns, Strongest, TileMirrors, in_any};
pub use path::{DniSpell, SunDay, SunPasses};
pub use seen::{SeenSky, SunSeen};
pub use spells::{Spell, Spells};
