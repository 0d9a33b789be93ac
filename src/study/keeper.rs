//! When a run of a study is saved, and when it is stopped.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::error::StudyError;
use crate::drive::observer::Occasion;

/// An unfinished run is saved this often, so that a kill costs no more.
const SAVED_EVERY: Duration = Duration::from_secs(20);
/// The clock is read once in so many steps of scenes with fewer than so many degrees of freedom: reading it takes as
/// long as a step of a pendulum.
const CLOCK_EVERY: u32 = 64;
const SMALL: usize = 1000;

/// Whether a run goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Course {
    GoesOn,
    Ends,
}

/// Saves a run from time to time and when it is interrupted, and ends it at an interrupt or when the budget is spent.
pub(super) struct Keeper<'a> {
    interrupt: &'a AtomicBool,
    deadline: Option<Instant>,
    /// boundaries between two looks at the clock
    between: u32,
    countdown: u32,
    saved: Instant,
    failed: Option<StudyError>,
}

impl<'a> Keeper<'a> {
    /// For a scene with `unknowns` degrees of freedom.
    pub(super) fn new(unknowns: usize, interrupt: &'a AtomicBool, deadline: Option<Instant>) -> Self {
        let between = if unknowns < SMALL { CLOCK_EVERY } else { 0 };
        Keeper { interrupt, deadline, between, countdown: 0, saved: Instant::now(), failed: None }
    }

    /// Called wherever the run may be saved; `save` saves it.
    pub(super) fn goes_on(&mut self, occasion: Occasion, save: impl FnOnce() -> Result<(), StudyError>) -> Course {
        let ends = |yes: bool| if yes { Course::Ends } else { Course::GoesOn };
        let interrupted = self.interrupt.load(Ordering::Relaxed);
        if occasion != Occasion::Interrupted {
            if self.countdown > 0 {
                self.countdown -= 1;
                return ends(interrupted);
            }
            self.countdown = self.between;
            let now = Instant::now();
            let over = self.deadline.is_some_and(|deadline| now >= deadline);
            if interrupted || over || now.duration_since(self.saved) < SAVED_EVERY {
                return ends(interrupted || over);
            }
            self.saved = now;
        }
        self.failed = save().err();
        ends(self.failed.is_some())
    }

    /// What went wrong when the run was saved.
    pub(super) fn done(self) -> Result<(), StudyError> {
        self.failed.map_or(Ok(()), Err)
    }
}
