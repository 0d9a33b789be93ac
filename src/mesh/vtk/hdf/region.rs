//! A file that grows at its end and is changed in place, such that what it says is true whenever the program is killed.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};

use super::header::LENGTH_AT;

/// The bytes of a file, and what waits to be written.
#[derive(Debug)]
pub(super) struct Region {
    file: File,
    /// [byte] length of the file, without what waits
    end: u64,
    /// what comes at its end
    tail: Vec<u8>,
    /// what is changed after that, in this order
    patches: Vec<(u64, Vec<u8>)>,
}

/// The number at the start of these bytes; they are at least eight.
pub(super) fn word(bytes: &[u8]) -> u64 {
    u64::from_le_bytes(std::array::from_fn(|i| bytes.get(i).copied().unwrap_or_default()))
}

impl Region {
    pub(super) fn new(file: File, end: u64) -> Self {
        Self { file, end, tail: Vec::new(), patches: Vec::new() }
    }

    /// Where the next bytes come.
    pub(super) fn end(&self) -> u64 {
        self.end + self.tail.len() as u64
    }

    /// Adds bytes at the end, up to a multiple of 8; returns where they are.
    pub(super) fn append(&mut self, bytes: &[u8]) -> u64 {
        let at = self.end();
        self.tail.extend_from_slice(bytes);
        self.tail.resize(self.tail.len().next_multiple_of(8), 0);
        at
    }

    /// Changes bytes, which may be of the tail.
    pub(super) fn patch(&mut self, at: u64, bytes: &[u8]) {
        match at.checked_sub(self.end).and_then(|at| self.tail.get_mut(at as usize..)?.get_mut(..bytes.len())) {
            Some(place) => place.copy_from_slice(bytes),
            None => self.patches.push((at, bytes.to_vec())),
        }
    }

    /// Writes all that waits: first the tail, to which nothing leads yet, then the length of the file, and then the
    /// patches in their order, of which the last makes the rest visible.
    ///
    /// # Errors
    /// Errors of the system.
    pub(super) fn write(&mut self) -> io::Result<()> {
        let (at, end) = (self.end, self.end());
        let tail = std::mem::take(&mut self.tail);
        write_at(&mut self.file, at, &tail)?;
        self.end = end;
        write_at(&mut self.file, LENGTH_AT, &end.to_le_bytes())?;
        for (at, bytes) in self.patches.drain(..) {
            write_at(&mut self.file, at, &bytes)?;
        }
        self.tail = tail;
        self.tail.clear();
        Ok(())
    }

    /// Writes the patches, and then cuts the file off.
    ///
    /// # Errors
    /// Errors of the system.
    pub(super) fn cut(&mut self, end: u64) -> io::Result<()> {
        (self.end, self.tail) = (end, Vec::new());
        self.write()?;
        self.file.set_len(end)
    }

    /// Reads bytes of the file.
    ///
    /// # Errors
    /// Errors of the system, and bytes that the file does not have.
    pub(super) fn read(&mut self, at: u64, length: usize) -> io::Result<Vec<u8>> {
        if at.checked_add(length as u64).is_none_or(|end| end > self.end) {
            return Err(io::Error::new(io::ErrorKind::InvalidData, "it is cut short, or an address in it is wrong"));
        }
        let mut bytes = vec![0; length];
        self.file.seek(SeekFrom::Start(at))?;
        self.file.read_exact(&mut bytes)?;
        Ok(bytes)
    }

    /// Makes all that was written durable.
    ///
    /// # Errors
    /// Errors of the system.
    pub(super) fn sync(&self) -> io::Result<()> {
        self.file.sync_all()
    }
}

fn write_at(file: &mut File, at: u64, bytes: &[u8]) -> io::Result<()> {
    file.seek(SeekFrom::Start(at))?;
    file.write_all(bytes)
}
