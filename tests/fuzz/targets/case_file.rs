//! Bytes as a case file, from reading to a few steps.
#![no_main]

#[path = "../oracle/case.rs"]
mod case;
#[path = "../oracle/failure.rs"]
mod failure;
mod guard;
mod mutate;

use libfuzzer_sys::{fuzz_mutator, fuzz_target};
use std::path::Path;

fuzz_target!(init: guard::install(), |data: &[u8]| {
    if let Err(why) = case::judge(data, &Path::new(env!("CARGO_MANIFEST_DIR")).join("seeds/mesh")) {
        panic!("{why}");
    }
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| { mutate::mutate(data, size, max_size, seed) });
