//! Output for a person at the console besides results: sentences ([`voice`]), bars of progress
//! ([`terminal`]), and Ctrl-C ([`interrupt`]).

pub mod interrupt;
pub mod terminal;
pub mod voice;
