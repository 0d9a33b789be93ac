//! Whether whoever started a computation asks for its end, by Ctrl-C or a signal.

use std::sync::atomic::{AtomicBool, Ordering};

/// Flags that a computation looks at between two pieces of work: none, one or two.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stop<'a>([Option<&'a AtomicBool>; 2]);

impl<'a> Stop<'a> {
    /// Nobody asks.
    pub const NEVER: Stop<'static> = Stop([None; 2]);

    /// Asked once the flag is set.
    pub fn on(flag: &'a AtomicBool) -> Self {
        Stop([Some(flag), None])
    }

    /// Asked once this or the other flag is set; of each no more than its first flag counts.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Stop([self.0[0], other.0[0]])
    }

    /// Whether the computation is to end.
    pub fn asked(self) -> bool {
        self.0.iter().flatten().any(|flag| flag.load(Ordering::Relaxed))
    }
}
