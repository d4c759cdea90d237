//! All integration tests in one binary, by question.

mod archive;
mod cli;
mod hostile;
mod interrupt;
mod kaitai;
mod numerics;
mod physics;
mod response;
mod scenes;
mod tidy;
