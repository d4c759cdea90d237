//! How warm it is for a person. In: archives of points with six planes each, weather. Out: mean radiant temperature, UTCI and PET of each point by hour,
//! or means and hours above thresholds over periods.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `request` | what is asked: [`ComfortRequest`] |
//! | `columns` | the columns of results |
//! | `climate` | air, wind and surroundings of each hour, and the indices of that hour |
//! | `persons` | the six receivers of a point, and its values in each hour |
//! | `pass` | from a stream of tiles to files |
//! | `points` | where points stand, and the archive of a scene with them: [`ComfortSiteRequest`] |
//!
//! Formulas stand in [`heliotile_core::comfort`]. Nothing is traced here but by `points`.

mod climate;
mod columns;
mod pass;
mod persons;
mod points;
mod request;

pub use columns::ComfortColumn;
pub use pass::ComfortDone;
pub use points::ComfortSiteRequest;
pub use request::{ClassShare, ComfortChoice, ComfortRequest, Posture, SunOnPerson, SurfaceTemperatures, WindChoice};
