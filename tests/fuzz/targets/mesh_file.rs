//! Bytes as a mesh file, given to every reader.
#![no_main]

mod guard;
#[path = "../oracle/mesh.rs"]
mod mesh;

use libfuzzer_sys::fuzz_target;

fuzz_target!(init: guard::install(), |data: &[u8]| {
    if let Err(why) = mesh::judge(data) {
        panic!("{why}");
    }
});
