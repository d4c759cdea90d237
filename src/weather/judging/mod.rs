//! Steps that all readers of weather files share. In: rows from a file, and the options of the
//! user. Out: [`Weather`](crate::series::Weather) without gaps, with findings about
//! doubtful data. Never: bytes.

mod gaps;
mod judge;
pub(super) mod raw_weather;
pub(super) mod station;
mod sums;
mod zenith;

pub(super) use judge::judged;
