//! Time: dates, years, the sun above a place, and the result that each condition adds to. In:
//! numbers of files. Out: instants and directions.

pub mod bins;
pub mod calendar;
pub mod clock_zone;
pub mod sun;
pub mod sun_path;
pub mod utc_offset;
pub mod years;
