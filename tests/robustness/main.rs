//! Input that goes wrong: hostile cases, random cases, what fuzzers and use of the program found. What belongs where:
//! `tests/README.md`.

#[path = "../common/mod.rs"]
mod common;
mod extremes;
mod faults;
mod found;
mod properties;

// The oracles of the fuzz targets (`tests/fuzz`), which judge the cases of this program too.
#[path = "../fuzz/oracle/case.rs"]
mod case_oracle;
#[path = "../fuzz/oracle/failure.rs"]
mod failure;
#[path = "../fuzz/oracle/mesh.rs"]
mod mesh_oracle;
