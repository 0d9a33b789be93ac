//! The filters of a chunk: bytes sorted by their places in a row (shuffle), then zlib. With the places in a number, as
//! is usual, zlib of vectors takes up to 6 % more.

use flate2::bufread::ZlibDecoder;
use flate2::write::ZlibEncoder;
use std::io::{self, Read, Write};

/// The bit of zlib, the second filter, among those that a chunk leaves out.
const NO_ZLIB: u32 = 2;

/// The first bytes of all rows, then the second bytes of all, and so on; `size` is that of a row.
fn shuffle(bytes: &[u8], size: usize, out: &mut Vec<u8>) {
    out.clear();
    for place in 0..size {
        out.extend(bytes.iter().skip(place).step_by(size));
    }
}

/// The bytes as they were before [`shuffle`].
fn unshuffle(bytes: &[u8], size: usize) -> Vec<u8> {
    let rows = bytes.len() / size.max(1);
    (0..rows).flat_map(|row| (0..size).filter_map(move |place| bytes.get(place * rows + row))).copied().collect()
}

/// Packs a chunk with rows of so many bytes; the filters that were left out, because they would not make it smaller.
///
/// # Errors
/// When the encoder fails, which does not happen in memory.
pub(super) fn pack(bytes: &[u8], size: usize, shuffled: &mut Vec<u8>, out: &mut Vec<u8>) -> io::Result<u32> {
    shuffle(bytes, size, shuffled);
    out.clear();
    let mut encoder = ZlibEncoder::new(out, flate2::Compression::fast());
    encoder.write_all(shuffled)?;
    let out = encoder.finish()?;
    if out.len() < bytes.len() {
        return Ok(0);
    }
    out.clear();
    out.extend_from_slice(shuffled);
    Ok(NO_ZLIB)
}

/// The numbers of a chunk, which has so many bytes when it is unpacked.
///
/// # Errors
/// A chunk that is damaged.
pub(super) fn unpack(packed: &[u8], size: usize, left_out: u32, length: usize) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    match left_out {
        0 => drop(ZlibDecoder::new(packed).take(length as u64 + 1).read_to_end(&mut bytes)?),
        _ => bytes.extend_from_slice(packed),
    }
    if bytes.len() != length || left_out & !NO_ZLIB != 0 {
        return Err(io::Error::new(io::ErrorKind::InvalidData, "a chunk is damaged"));
    }
    Ok(unshuffle(&bytes, size))
}
