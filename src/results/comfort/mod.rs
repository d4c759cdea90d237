//! How warm it is for a person. In: archives of points with six planes each, weather. Out: mean radiant temperature, UTCI and PET of each point by hour,
//! or means and hours above thresholds over periods.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `request` | what is asked: [`ComfortRequest`] |
//! | `columns` | the columns of results, over hours and periods |
//! | `climate` | the air of each hour, and what a weather file lacks |
//! | `persons` | the six receivers of a point, and their light |
//! | `pass` | from a stream of tiles to files |
//! | `points` | where points stand, and the archive of a scene with them: [`ComfortSiteRequest`] |
//!
//! Formulas stand in [`heliotile_core::comfort`], what becomes of people in [`heliotile_core::comfort::people`], which the page uses too. Nothing is traced here but by `points`.

mod climate;
mod columns;
mod pass;
mod persons;
mod points;
mod request;

pub use heliotile_core::comfort::people::columns::ComfortColumn;
pub use heliotile_core::comfort::people::model::SunOnPerson;
pub use pass::ComfortDone;
pub use points::ComfortSiteRequest;
pub use request::{ClassShare, ComfortChoice, ComfortRequest, Posture, SurfaceTemperatures, WindChoice};
