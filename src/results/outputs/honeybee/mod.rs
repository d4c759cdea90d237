//! Hourly results as Honeybee's recipes leave them. In: receivers in grids, values tile by tile. Out: a folder that honeybee-radiance-postprocess
//! and Pollination read.
//!
//! Written from their reader (honeybee-radiance-postprocess 0.5.25, `results/results.py`), whose names the files bear:
//! `grids_info.json`, `study_info.json`, `sun-up-hours.txt` and `__static_apertures__/default/total/GRID.npy`, W/m2, f32,
//! `[receiver][hour with light]`; `direct` beside `total` is the sun alone.

mod folder;
mod grids;
mod hours;

pub use folder::ResultsFolder;
pub use grids::Grids;
pub use hours::LitHours;
