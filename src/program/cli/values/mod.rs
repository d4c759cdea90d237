//! Values of options: names, selections of receivers, numbers with units.

mod choice;
mod chosen;
mod numbers;

pub use choice::{choice, table_endings, table_help};
pub use chosen::SelectionArgs;
pub use heliotile::Bytes;
pub use numbers::{parse_bounds, parse_depth, parse_memory};
