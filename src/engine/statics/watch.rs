//! How far a search has come, for who waits for it.

/// What a search has reached.
#[derive(Clone, Copy, Debug)]
pub struct SearchProgress {
    /// Newton iterations made
    pub iterations: u64,
    /// [N] Euclidean norm of the forces that are left
    pub residual: f64,
    /// [N] what it is compared with
    pub scale: f64,
    /// [-] share of the loads that is applied
    pub level: f64,
}

/// Who is told after every solve.
#[derive(Clone, Copy)]
pub struct Watcher<'a>(pub &'a dyn Fn(SearchProgress));

impl Watcher<'_> {
    /// Nobody.
    pub const NONE: Watcher<'static> = Watcher(&|_| {});
}

impl std::fmt::Debug for Watcher<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Watcher")
    }
}
