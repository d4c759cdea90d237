//! The fuzzer of all targets; `HELIOTILE_FUZZ_TARGET` names one, `list` lists them, `seeds` writes valid inputs to the corpus.
#![no_main]

mod memory;
mod seeds;
mod targets;

use std::sync::OnceLock;

use libfuzzer_sys::fuzz_target;
use targets::{TARGETS, Target};

static TARGET: OnceLock<Target> = OnceLock::new();

fuzz_target!(
    init: {
        let name = std::env::var("HELIOTILE_FUZZ_TARGET").unwrap_or_default();
        match name.as_str() {
            "list" => {
                TARGETS.iter().for_each(|(name, _)| println!("{name}"));
                std::process::exit(0);
            }
            "seeds" => {
                seeds::write();
                std::process::exit(0);
            }
            _ => {}
        }
        let found = TARGETS.iter().find(|(known, _)| *known == name);
        TARGET.set(found.expect("the name of a target").1).expect("once");
    },
    |data: &[u8]| {
        TARGET.get().expect("chosen")(data);
    }
);
