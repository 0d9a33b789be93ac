//! Bytes as a case file, from reading to a few steps.
#![no_main]

#[path = "../oracle/case.rs"]
mod case;
#[path = "../oracle/failure.rs"]
mod failure;
mod guard;

use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(init: guard::install(), |data: &[u8]| {
    if let Err(why) = case::judge(data, &Path::new(env!("CARGO_MANIFEST_DIR")).join("seeds/mesh")) {
        panic!("{why}");
    }
});
