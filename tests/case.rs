//! Case files: what is accepted, what is refused and how, and what a case becomes.
//!
//! Where tests go: a fault that a value causes is one row of a table in `refused`; what a good case turns into stands
//! in `built`; text, encoding and syntax in `reading`; the schema in `schema`.

#[path = "case/built.rs"]
mod built;
#[path = "case/common.rs"]
mod common;
#[path = "case/faults.rs"]
mod faults;
#[path = "case/reading.rs"]
mod reading;
#[path = "case/refused.rs"]
mod refused;
#[path = "case/schema.rs"]
mod schema;
