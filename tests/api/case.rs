//! Case files: what is accepted, what is refused and how, and what a case becomes.
//!
//! Where tests go: a fault that a value causes is one row of a table in `refused`; what a good case turns into stands
//! in `built`; text, encoding and syntax in `reading`; the schema in `schema`.

mod built;
mod common;
mod contact;
mod faults;
mod reading;
mod refused;
mod schema;
