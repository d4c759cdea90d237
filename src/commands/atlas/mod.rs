//! A region in parts: how it is cut (`partition`), and one of its parts built (`build --part`). An atlas is a folder with the plan and a
//! folder for each part that is built (`info`, `verify` look into it).

pub mod about;
pub mod catalogue;
pub mod copied;
pub mod listed;
pub mod opened;
pub mod page;
pub mod part;
pub mod partition;
pub mod plan;
mod seams;
pub mod sources;
mod thumbnails;
