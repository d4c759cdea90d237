//! Hourly results in the layout of Honeybee's recipes. In: receivers in grids, values tile by tile.
//! Out: a folder that honeybee-radiance-postprocess and Pollination read.
//!
//! The layout follows the reader (honeybee-radiance-postprocess 0.5.25, `results/results.py`) and
//! its names: `grids_info.json`, `study_info.json`, `sun-up-hours.txt` and
//! `__static_apertures__/default/total/GRID.npy`, W/m2, f32, `[receiver][hour with light]`;
//! `direct` beside `total` is the sun alone.

mod folder;
mod grids;
mod hours;

pub use folder::ResultsFolder;
pub use grids::Grids;
pub use hours::LitHours;
