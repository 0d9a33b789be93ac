//! Work space that is kept from one use to the next.

use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, PoisonError};

/// Where it is kept. No lock is held while it is in use: a thread of a pool that waits for its share of a pass may begin another caller's pass meanwhile, which then
/// has room of its own.
#[derive(Debug, Default)]
pub(super) struct Shelf<T>(Mutex<T>);

/// Is put back in the end.
pub(super) struct Taken<'a, T: Default> {
    what: T,
    shelf: &'a Shelf<T>,
}

impl<T: Default> Shelf<T> {
    /// What was put back last, or a new one while that is in use.
    pub fn take(&self) -> Taken<'_, T> {
        Taken { what: std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner)), shelf: self }
    }
}

impl<T: Default> Deref for Taken<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.what
    }
}

impl<T: Default> DerefMut for Taken<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.what
    }
}

impl<T: Default> Drop for Taken<'_, T> {
    fn drop(&mut self) {
        *self.shelf.0.lock().unwrap_or_else(PoisonError::into_inner) = std::mem::take(&mut self.what);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_put_back_is_there_again_and_nobody_waits_for_it() {
        let shelf = Shelf::<Vec<u8>>::default();
        {
            let mut first = shelf.take();
            first.push(1);
            assert!(shelf.take().is_empty(), "in use");
        }
        assert_eq!(*shelf.take(), [1]);
        assert_eq!(*shelf.take(), [1], "put back unchanged");
    }
}
