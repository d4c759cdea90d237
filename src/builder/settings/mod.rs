//! Settings: the numbers and left-out effects that decide how exact an archive is. In: a quality,
//! or names and numbers of the user. Out: numbers in range. Each number is declared in
//! [`heliotile_core::archive::settings`]. Never: scenes, rays, files.

mod effects;
pub mod ladder;
mod quality;
mod values;

pub use effects::{Effect, EffectChoice, Effects};
pub use ladder::Rungs;
pub use quality::Quality;
pub use values::{BuildSettings, Share, patches};
