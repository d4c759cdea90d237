//! Formats of weather. In: bytes. Out: [`Weather`](crate::series::Weather) and schedules,
//! each row checked.

mod date_text;
pub mod epw;
mod stamp_text;
mod stamped;
mod surfrad;
mod tmy3;
mod wea;
mod weather_csv;
pub mod weather_file;
