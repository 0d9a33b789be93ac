//! Studies: many runs of one case, and what can be learnt from them.

pub mod stability;
