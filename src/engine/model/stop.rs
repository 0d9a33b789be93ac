//! Requests to stop a computation, by Ctrl-C or a signal.

use std::sync::atomic::{AtomicBool, Ordering};

/// Flags that a computation checks between two pieces of work: none, one or two.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stop<'a>([Option<&'a AtomicBool>; 2]);

impl<'a> Stop<'a> {
    /// No request is possible.
    pub const NEVER: Stop<'static> = Stop([None; 2]);

    /// A request when the flag is set.
    pub fn on(flag: &'a AtomicBool) -> Self {
        Stop([Some(flag), None])
    }

    /// A request when this or the other flag is set; only the first flag of each counts.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Stop([self.0[0], other.0[0]])
    }

    /// Whether the computation must end.
    pub fn asked(self) -> bool {
        self.0.iter().flatten().any(|flag| flag.load(Ordering::Relaxed))
    }
}
