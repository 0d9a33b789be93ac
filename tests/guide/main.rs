//! The guide (`docs/guide`) says what the program does: its case reference is that of the schema, every case it shows
//! is accepted, its links lead somewhere, and its sentences are short.
//!
//! `GUIDE_WRITE=1 cargo test --release --test guide` writes the case reference anew.

mod cases;
mod links;
mod materials;
mod nets;
mod pages;
mod reference;
mod sentences;
