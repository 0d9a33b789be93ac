//! Buffers that are kept from one use to the next.

use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, PoisonError};

/// A pool of such buffers, as many as were in use at the same time. No lock is held during use: a thread that waits for
/// its share of a pass may begin another caller's pass meanwhile, which then gets a buffer of its own.
#[derive(Debug, Default)]
pub(in crate::force) struct BufferPool<T>(Mutex<Vec<T>>);

/// Returns the value to the pool when dropped.
pub(in crate::force) struct Pooled<'a, T: Default> {
    what: T,
    pool: &'a BufferPool<T>,
}

impl<T: Default> BufferPool<T> {
    /// The value that was returned last, or a new one if all are in use.
    pub(crate) fn take(&self) -> Pooled<'_, T> {
        let what = self.0.lock().unwrap_or_else(PoisonError::into_inner).pop();
        Pooled { what: what.unwrap_or_default(), pool: self }
    }
}

impl<T: Default> Deref for Pooled<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.what
    }
}

impl<T: Default> DerefMut for Pooled<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.what
    }
}

impl<T: Default> Drop for Pooled<'_, T> {
    fn drop(&mut self) {
        let what = std::mem::take(&mut self.what);
        self.pool.0.lock().unwrap_or_else(PoisonError::into_inner).push(what);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_put_back_is_there_again_and_nobody_waits_for_it() {
        let pool = BufferPool::<Vec<u8>>::default();
        {
            let mut first = pool.take();
            first.push(1);
            let mut second = pool.take();
            assert!(second.is_empty(), "the first is in use");
            second.push(2);
        }
        let (first, second) = (pool.take(), pool.take());
        assert_eq!((&**first, &**second), (&[1][..], &[2][..]));
        assert!(pool.take().is_empty());
    }
}
