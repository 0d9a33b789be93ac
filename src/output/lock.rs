//! Locks that keep two runs out of one folder. A killed program holds none.

use std::fs::{File, TryLockError};
use std::time::{Duration, Instant};

/// How long to wait for a lock that nobody means to keep: a run is ending, or its process is starting a program, which
/// has a copy of every open file until it begins.
const PATIENCE: Duration = Duration::from_millis(300);

/// Whether a file or folder is free to be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lock {
    /// locked by this handle, or on a system where that is not done
    Here,
    /// another run writes it
    Elsewhere,
}

/// Locks a file or folder against a second run. Windows would keep readers out as well, so not there; and where a file
/// system knows no locks (NFS has none of folders), there are none.
pub fn lock(file: &File) -> Lock {
    let began = Instant::now();
    loop {
        match cfg!(unix).then(|| file.try_lock()) {
            Some(Err(TryLockError::WouldBlock)) if began.elapsed() < PATIENCE => std::thread::sleep(PATIENCE / 30),
            Some(Err(TryLockError::WouldBlock)) => return Lock::Elsewhere,
            _ => return Lock::Here,
        }
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::fs::OpenOptions;

    /// Between fork and exec a starting program holds copies of all files of its process, the locked ones too.
    #[test]
    fn a_lock_that_is_soon_given_back_is_waited_for() {
        let folder = tempfile::tempdir().expect("a folder");
        let open =
            || OpenOptions::new().create(true).append(true).open(folder.path().join("history.csv")).expect("a file");
        let (held, wanted) = (open(), open());
        assert_eq!(lock(&held), Lock::Here);
        assert_eq!(lock(&wanted), Lock::Elsewhere);
        let gives_back = std::thread::spawn(move || {
            std::thread::sleep(PATIENCE / 6);
            drop(held);
        });
        assert_eq!(lock(&wanted), Lock::Here);
        gives_back.join().expect("no panic");
    }
}
