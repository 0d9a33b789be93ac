//! The CRC-32 (IEEE 802.3), little-endian, after all binary data that are stored: damage is found before decoding.

use serde::{Deserialize, Serialize};

/// [byte] length of the checksum
pub const LENGTH: usize = 4;

/// Why bytes are not valid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChecksumError {
    /// They are too few to hold a checksum.
    Missing,
    /// The checksum is not that of the bytes before it.
    Differs {
        /// stored after the bytes
        stored: u32,
        /// of the bytes
        computed: u32,
    },
}

/// The first `bytes` of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct FilePrefix {
    /// their number
    pub bytes: u64,
    /// their CRC-32
    pub crc: u32,
}

/// A [`FilePrefix`] that grows as data is written to it.
#[derive(Clone, Debug, Default)]
pub struct RunningChecksum {
    bytes: u64,
    crc: crc32fast::Hasher,
}

impl RunningChecksum {
    /// Continues after a prefix.
    pub fn after(prefix: FilePrefix) -> Self {
        let FilePrefix { bytes, crc } = prefix;
        RunningChecksum { bytes, crc: crc32fast::Hasher::new_with_initial_len(crc, bytes) }
    }

    /// Adds the next bytes.
    pub fn add(&mut self, data: &[u8]) {
        self.bytes += data.len() as u64;
        self.crc.update(data);
    }

    /// All bytes so far.
    pub fn mark(&self) -> FilePrefix {
        FilePrefix { bytes: self.bytes, crc: self.crc.clone().finalize() }
    }

    /// Number of bytes so far.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}

impl std::io::Write for RunningChecksum {
    fn write(&mut self, data: &[u8]) -> std::io::Result<usize> {
        self.add(data);
        Ok(data.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Appends the checksum of all bytes.
pub fn append(bytes: &mut Vec<u8>) {
    let sum = crc32fast::hash(bytes);
    bytes.extend_from_slice(&sum.to_le_bytes());
}

/// The bytes before the checksum.
///
/// # Errors
/// Too few bytes, or damaged ones.
pub fn verified(bytes: &[u8]) -> Result<&[u8], ChecksumError> {
    let (content, sum) = bytes.split_last_chunk::<LENGTH>().ok_or(ChecksumError::Missing)?;
    let (stored, computed) = (u32::from_le_bytes(*sum), crc32fast::hash(content));
    if stored == computed { Ok(content) } else { Err(ChecksumError::Differs { stored, computed }) }
}
