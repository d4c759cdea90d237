//! Tables of points: receivers, modules, people, lines of travel, areas. In: CSV files, in which
//! all of them have the same column names. Out: checked rows.

pub mod areas;
mod header;
pub mod lines;
pub mod places;
pub mod receivers;
pub mod rows;
