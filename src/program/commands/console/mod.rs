//! Output for a person at the console besides results: sentences ([`voice`]), bars or lines of
//! progress ([`terminal`]), and Ctrl-C ([`interrupt`]).

pub mod interrupt;
mod progress_lines;
pub mod terminal;
pub mod voice;
