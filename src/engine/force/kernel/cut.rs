//! Which springs of a batch carry nothing.

use crate::force::Copies;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Springs that are cut, or have broken: they carry no force, and neither do their dashpots; and whether tangents take
/// those that are slack as just taut. Shared by all that acts along them.
#[derive(Clone, Debug, Default)]
pub struct Cut {
    all: Arc<Flags>,
    broken: Arc<Broken>,
}

#[derive(Debug, Default)]
struct Flags {
    cut: AtomicBool,
    slack_is_taut: AtomicBool,
}

/// A bit for every spring that can break; none where none can.
#[derive(Debug, Default)]
struct Broken {
    some: AtomicBool,
    bits: Vec<AtomicU64>,
}

impl Clone for Flags {
    fn clone(&self) -> Self {
        let copy = |flag: &AtomicBool| AtomicBool::new(flag.load(Ordering::Relaxed));
        Flags { cut: copy(&self.cut), slack_is_taut: copy(&self.slack_is_taut) }
    }
}

impl Clone for Broken {
    fn clone(&self) -> Self {
        let bits = self.bits.iter().map(|bits| AtomicU64::new(bits.load(Ordering::Relaxed))).collect();
        Broken { some: AtomicBool::new(self.some.load(Ordering::Relaxed)), bits }
    }
}

/// Springs by the bit of each.
const BITS: usize = u64::BITS as usize;

impl Cut {
    /// Of so many springs, each of which can break.
    pub fn of_breaking(springs: usize) -> Self {
        let bits = (0..springs.div_ceil(BITS)).map(|_| AtomicU64::new(0)).collect();
        Cut { broken: Arc::new(Broken { some: AtomicBool::new(false), bits }), ..Cut::default() }
    }

    /// The same for springs that are cut with these, of which none breaks.
    #[must_use]
    pub fn of_all(&self) -> Self {
        Cut { broken: Arc::default(), ..self.clone() }
    }

    /// Whether all are cut.
    pub fn all(&self) -> bool {
        self.all.cut.load(Ordering::Relaxed)
    }

    /// Cuts all, or makes them whole again.
    pub fn set_all(&self, cut: bool) {
        self.all.cut.store(cut, Ordering::Relaxed);
    }

    /// Whether some are cut or have broken.
    pub fn some(&self) -> bool {
        self.all() || self.some_broken()
    }

    /// Whether some have broken.
    #[inline]
    pub fn some_broken(&self) -> bool {
        self.broken.some.load(Ordering::Relaxed)
    }

    /// Whether some of these have broken, or of a few beside them.
    pub fn some_broken_in(&self, springs: Range<usize>) -> bool {
        let near = springs.start / BITS..springs.end.div_ceil(BITS);
        let bits = self.broken.bits.get(near).unwrap_or_default();
        self.some_broken() && bits.iter().any(|bits| bits.load(Ordering::Relaxed) != 0)
    }

    /// Whether a spring is cut or has broken.
    #[inline]
    pub fn is(&self, spring: usize) -> bool {
        self.all() || self.some_broken() && self.bits_at(spring) >> (spring % BITS) & 1 != 0
    }

    fn bits_at(&self, spring: usize) -> u64 {
        self.broken.bits.get(spring / BITS).map_or(0, |bits| bits.load(Ordering::Relaxed))
    }

    /// Says of every spring that can break whether it has. Returns whether one is other than before.
    pub fn set_broken(&self, has_broken: impl Iterator<Item = bool>) -> bool {
        let mut other = false;
        let (mut all, mut some) = (has_broken.into_iter(), false);
        for bits in &self.broken.bits {
            let new = all.by_ref().take(BITS).zip(0..).fold(0, |sum, (broken, bit)| sum | u64::from(broken) << bit);
            other |= bits.swap(new, Ordering::Relaxed) != new;
            some |= new != 0;
        }
        self.broken.some.store(some, Ordering::Relaxed);
        other
    }

    /// Whether tangents are those with slack springs at the elongation at which they go taut, with their dashpots.
    pub fn slack_is_taut(&self) -> bool {
        self.all.slack_is_taut.load(Ordering::Relaxed)
    }

    /// Makes tangents those with all springs taut, or those at the state again.
    pub fn set_slack_is_taut(&self, taut: bool) {
        self.all.slack_is_taut.store(taut, Ordering::Relaxed);
    }

    /// That of another run, at first the same.
    #[must_use]
    pub(crate) fn for_run(&self, copies: &mut Copies) -> Self {
        Cut { all: copies.of(&self.all), broken: copies.of(&self.broken) }
    }
}
