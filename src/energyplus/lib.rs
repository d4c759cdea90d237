//! Injection of reflected light into EnergyPlus models. In: a model, an archive of its surfaces.
//! Out: the model with tables over the sun's position and programs that read them, or with a series
//! beside it, and a report as a page. Objects of the user stay as they were typed, but for names of
//! files.

pub mod checks;
pub mod comparison;
pub mod document;
pub mod erl;
pub mod eso;
pub mod injection;
pub mod named_files;
pub mod neighbours;
pub mod new_object;
pub mod report;
pub mod run;
pub mod series;
pub mod sun_tables;

pub use run::{EnergyplusRequest, Physics};
