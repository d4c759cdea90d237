//! What readers of weather files have in common. In: rows as they stand in a file, and what the user says about it. Out:
//! [`Weather`](crate::weather::series::Weather) without gaps, and what is doubtful about it. Never: bytes.

mod gaps;
mod judge;
pub(super) mod raw_weather;
pub(super) mod station;

pub(super) use judge::judged;
