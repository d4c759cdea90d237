//! Formats of weather. In: bytes. Out: [`Weather`](crate::weather::series::Weather) and schedules, each row checked.

pub mod epw;
pub mod schedule_csv;
pub mod tmy3;
pub mod weather_file;
