//! Which springs of a batch carry nothing.

use crate::force::Copies;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Springs that are cut, or have broken: they carry no force, and neither do their dashpots; and whether tangents take
/// those that are slack as just taut. Shared by all that acts along them.
#[derive(Clone, Debug, Default)]
pub struct Cut {
    flags: Arc<Flags>,
    /// whether one of them can break alone
    break_alone: bool,
}

#[derive(Debug, Default)]
struct Flags {
    all: AtomicBool,
    some_broken: AtomicBool,
    slack_is_taut: AtomicBool,
    /// a bit for every spring that can break
    broken: Vec<AtomicU64>,
}

impl Clone for Flags {
    fn clone(&self) -> Self {
        let copy = |flag: &AtomicBool| AtomicBool::new(flag.load(Ordering::Relaxed));
        Flags {
            all: copy(&self.all),
            some_broken: copy(&self.some_broken),
            slack_is_taut: copy(&self.slack_is_taut),
            broken: self.broken.iter().map(|bits| AtomicU64::new(bits.load(Ordering::Relaxed))).collect(),
        }
    }
}

/// Springs by the bit of each.
const BITS: usize = u64::BITS as usize;

impl Cut {
    /// Of so many springs, each of which can break.
    pub fn of_breaking(springs: usize) -> Self {
        let broken = (0..springs.div_ceil(BITS)).map(|_| AtomicU64::new(0)).collect();
        Cut { flags: Arc::new(Flags { broken, ..Flags::default() }), break_alone: springs > 0 }
    }

    /// The same for springs that are cut with these, of which none breaks.
    #[must_use]
    pub fn of_all(&self) -> Self {
        Cut { break_alone: false, ..self.clone() }
    }

    /// Whether all are cut.
    pub fn all(&self) -> bool {
        self.flags.all.load(Ordering::Relaxed)
    }

    /// Cuts all, or makes them whole again. Returns whether that is other than before.
    pub fn set_all(&self, cut: bool) -> bool {
        self.flags.all.swap(cut, Ordering::Relaxed) != cut
    }

    /// Whether some are cut or have broken.
    #[inline]
    pub fn some(&self) -> bool {
        self.all() || self.some_broken()
    }

    /// Whether some have broken.
    pub fn some_broken(&self) -> bool {
        self.break_alone && self.flags.some_broken.load(Ordering::Relaxed)
    }

    /// Whether some of these have broken, or of a few beside them.
    pub fn some_broken_in(&self, springs: Range<usize>) -> bool {
        let near = springs.start / BITS..springs.end.div_ceil(BITS);
        let bits = self.flags.broken.get(near).unwrap_or_default();
        self.some_broken() && bits.iter().any(|bits| bits.load(Ordering::Relaxed) != 0)
    }

    /// Whether a spring is cut or has broken.
    #[inline]
    pub fn is_cut(&self, spring: usize) -> bool {
        self.some() && self.is_one_of_some(spring)
    }

    #[inline(never)]
    fn is_one_of_some(&self, spring: usize) -> bool {
        let bits = || self.flags.broken.get(spring / BITS).map_or(0, |bits| bits.load(Ordering::Relaxed));
        self.all() || self.break_alone && bits() >> (spring % BITS) & 1 != 0
    }

    /// Says of every spring that can break whether it has. Returns whether one is other than before.
    pub fn set_broken(&self, has_broken: impl Iterator<Item = bool>) -> bool {
        let (mut all, mut some, mut other) = (has_broken, false, false);
        for bits in &self.flags.broken {
            let new = all.by_ref().take(BITS).zip(0..).fold(0, |sum, (broken, bit)| sum | u64::from(broken) << bit);
            other |= bits.swap(new, Ordering::Relaxed) != new;
            some |= new != 0;
        }
        self.flags.some_broken.store(some, Ordering::Relaxed);
        other
    }

    /// Whether tangents are those with slack springs at the elongation at which they go taut, with their dashpots.
    pub fn slack_is_taut(&self) -> bool {
        self.flags.slack_is_taut.load(Ordering::Relaxed)
    }

    /// Makes tangents those with all springs taut, or those at the state again.
    pub fn set_slack_is_taut(&self, taut: bool) {
        self.flags.slack_is_taut.store(taut, Ordering::Relaxed);
    }

    /// That of another run, at first the same.
    #[must_use]
    pub(crate) fn for_run(&self, copies: &mut Copies) -> Self {
        Cut { flags: copies.of(&self.flags), break_alone: self.break_alone }
    }
}
