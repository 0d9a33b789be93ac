//! Whether whoever started a computation asks for its end, by Ctrl-C or a signal.

use std::sync::atomic::{AtomicBool, Ordering};

/// A flag that a computation looks at between two pieces of work, or none.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stop<'a>(Option<&'a AtomicBool>);

impl<'a> Stop<'a> {
    /// Nobody asks.
    pub const NEVER: Stop<'static> = Stop(None);

    /// Asked once the flag is set.
    pub fn on(flag: &'a AtomicBool) -> Self {
        Stop(Some(flag))
    }

    /// Whether the computation is to end.
    pub fn asked(self) -> bool {
        self.0.is_some_and(|flag| flag.load(Ordering::Relaxed))
    }
}
