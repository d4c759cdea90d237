//! The program `heliotile`: its code is in the library.

use std::ffi::OsString;
use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(heliotile_program::program(&std::env::args_os().collect::<Vec<OsString>>()))
}
