//! Thermal comfort of a person. In: archives of points with six planes each, weather. Out: mean
//! radiant temperature, UTCI and PET of each point by hour, or means and hours above thresholds
//! over periods.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `request` | [`ComfortRequest`], and its checks |
//! | `columns` | the columns of results, over hours and periods |
//! | `climate` | the air of each hour, and errors for gaps in a weather file |
//! | `persons` | the six receivers of a point, and their light |
//! | `pass` | from a stream of tiles to files |
//!
//! Formulas are in [`heliotile_comfort`], those of people in
//! [`heliotile_comfort::people`]; the page uses them, too.

mod beyond;
mod climate;
mod columns;
mod pass;
mod persons;
mod request;

pub use heliotile_comfort::people::columns::ComfortColumn;
pub use heliotile_comfort::people::model::SunOnPerson;
pub use pass::ComfortDone;
pub use request::{ClassShare, ComfortChoice, ComfortRequest, Posture, SurfaceTemperatures, WindChoice};
