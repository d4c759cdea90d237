//! All integration tests in one binary, by question.

mod accuracy;
mod archive;
mod canopy;
mod cli;
mod damage;
mod export;
mod ground;
mod hostile;
mod interrupt;
mod kaitai;
mod longwave;
mod mirrors;
mod numerics;
mod physics;
mod plan;
mod reader;
mod reflectance;
mod replay;
mod response;
mod results;
mod scenes;
mod store;
mod study;
mod tidy;
mod transfer;
mod weather;
