//! What must hold of every case, tried on random ones: hostile magnitudes with every method, and the symmetries of the
//! equations.
//!
//! The cases are the same in every run. `PROPTEST_CASES=10000 cargo test --release --test robustness properties` goes
//! deeper, with `PROPTEST_RNG_SEED=7` elsewhere. What once failed is in `found.txt` and is tried first.

mod calls;
mod hostile;
mod nets;
mod symmetry;

use proptest::test_runner::{Config, FileFailurePersistence, RngSeed};

/// `cases` cases from a fixed seed, unless the environment asks for others.
fn config(cases: u32) -> Config {
    let asked = |name: &str| std::env::var_os(name).is_some();
    let mut config = Config::default();
    if !asked("PROPTEST_CASES") {
        config.cases = cases;
    }
    if !asked("PROPTEST_RNG_SEED") {
        config.rng_seed = RngSeed::Fixed(0x00CA_0091);
    }
    let found = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/robustness/properties/found.txt");
    config.failure_persistence = Some(Box::new(FileFailurePersistence::Direct(found)));
    config
}
