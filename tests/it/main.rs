//! All integration tests in one binary, by question.

mod physics;
mod response;
mod scenes;
mod tidy;
