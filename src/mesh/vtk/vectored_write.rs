//! The pieces of a file, written in one call without copying.

use std::io::{self, IoSlice, Write};
use std::ops::Range;

/// [byte] Largest size of one call: some systems refuse 2 GiB and more, instead of writing a part.
const AT_ONCE: usize = 1 << 30;

/// The parts of a file after its header.
pub(super) struct Appended<'a> {
    parts: Vec<Segment<'a>>,
    /// [byte] of all parts
    len: usize,
}

/// A piece of it.
pub(super) enum Segment<'a> {
    /// a range of the writer's body
    Body(Range<usize>),
    /// an array in its own memory
    Numbers(&'a [u8]),
}

impl<'a> Appended<'a> {
    /// Starts with a piece.
    pub(super) fn from(first: Segment<'a>) -> Self {
        let mut made = Appended { parts: Vec::new(), len: 0 };
        made.push(first);
        made
    }

    /// [byte] of all pieces.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// Appends a piece.
    pub(super) fn push(&mut self, part: Segment<'a>) {
        self.len += match &part {
            Segment::Body(range) => range.len(),
            Segment::Numbers(bytes) => bytes.len(),
        };
        self.parts.push(part);
    }

    /// Writes the header of a file, its pieces (some of them ranges of `body`), and its end.
    ///
    /// # Errors
    /// Errors of `out`.
    pub(super) fn write(&self, out: &mut impl Write, body: &[u8], [head, tail]: [&[u8]; 2]) -> io::Result<()> {
        let pieces = self.parts.iter().map(|part| match part {
            Segment::Body(range) => &body[range.clone()],
            Segment::Numbers(bytes) => bytes,
        });
        write_all(out, std::iter::once(head).chain(pieces).chain([tail]), AT_ONCE)
    }
}

/// Writes all parts, in calls of at most this many bytes; in one call if possible.
fn write_all<'a>(out: &mut impl Write, parts: impl Iterator<Item = &'a [u8]>, at_once: usize) -> io::Result<()> {
    let mut parts: Vec<_> = parts.flat_map(|part| part.chunks(at_once)).map(IoSlice::new).collect();
    let mut parts = parts.as_mut_slice();
    while !parts.is_empty() {
        let ends = parts.iter().scan(0, |end, part| {
            *end += part.len();
            Some(*end)
        });
        let count = ends.take_while(|end| *end <= at_once).count();
        match out.write_vectored(&parts[..count]) {
            Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
            Ok(written) => IoSlice::advance_slices(&mut parts, written),
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Accepts a few bytes at a time, of one or two pieces, and is sometimes interrupted.
    #[derive(Default)]
    struct Slow {
        taken: Vec<u8>,
        calls: usize,
        /// refuses calls with more bytes, if above 0
        most: usize,
    }

    impl Write for Slow {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.write_vectored(&[IoSlice::new(bytes)])
        }

        fn write_vectored(&mut self, parts: &[IoSlice<'_>]) -> io::Result<usize> {
            self.calls += 1;
            if self.most > 0 && parts.iter().map(|part| part.len()).sum::<usize>() > self.most {
                return Err(io::ErrorKind::InvalidInput.into());
            }
            if self.calls.is_multiple_of(3) {
                return Err(io::ErrorKind::Interrupted.into());
            }
            let room = self.calls % 7 + 1;
            let bytes = parts.iter().take(2).flat_map(|part| part.iter().copied());
            let before = self.taken.len();
            self.taken.extend(bytes.take(room));
            Ok(self.taken.len() - before)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn whatever_is_taken_at_a_time_all_is_written_in_order() {
        let body: Vec<u8> = (0..40).collect();
        let mut pieces = Appended::from(Segment::Body(0..17));
        pieces.push(Segment::Numbers(&[101, 102, 103]));
        pieces.push(Segment::Body(17..17));
        pieces.push(Segment::Body(17..40));
        assert_eq!(pieces.len(), 43);
        let mut out = Slow::default();
        pieces.write(&mut out, &body, [b"head", b"tail"]).expect("a patient writer");
        assert_eq!(out.taken, [b"head", &body[..17], &[101, 102, 103], &body[17..], b"tail"].concat());
        assert!(out.calls > 10);
    }

    /// Data that the system refuses in one call are written in several.
    #[test]
    fn no_call_asks_for_more_than_the_system_takes() {
        let long: Vec<u8> = (0..37).collect();
        let parts = || [b"head", &long[..], b"", b"a", &long[..9], b"tail"].into_iter();
        let mut out = Slow { most: 10, ..Slow::default() };
        write_all(&mut out, parts(), 10).expect("small calls");
        assert_eq!(out.taken, parts().flatten().copied().collect::<Vec<_>>());
        let fault = write_all(&mut Slow { most: 10, ..Slow::default() }, parts(), 11);
        assert_eq!(fault.map_err(|e| e.kind()), Err(io::ErrorKind::InvalidInput));
    }

    #[test]
    fn what_takes_nothing_is_told() {
        let mut full: &mut [u8] = &mut [0; 5];
        let fault = Appended::from(Segment::Numbers(b"abc")).write(&mut full, &[], [b"head", b"tail"]);
        assert_eq!(fault.map_err(|e| e.kind()), Err(io::ErrorKind::WriteZero));
    }
}
