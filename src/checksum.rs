//! The CRC-32 (IEEE 802.3), little end first, behind everything that is stored in binary form: damage is noticed before
//! anything is decoded.

/// [byte] length of the checksum
pub const LENGTH: usize = 4;

/// Why bytes cannot be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChecksumError {
    /// They are too few to hold a checksum.
    Missing,
    /// The checksum is not that of the bytes before it.
    Differs {
        /// behind the bytes
        stored: u32,
        /// of the bytes
        computed: u32,
    },
}

/// Appends the checksum of all bytes.
pub fn append(bytes: &mut Vec<u8>) {
    let sum = crc32fast::hash(bytes);
    bytes.extend_from_slice(&sum.to_le_bytes());
}

/// The bytes before the checksum.
///
/// # Errors
/// Bytes that are too few or damaged.
pub fn verified(bytes: &[u8]) -> Result<&[u8], ChecksumError> {
    let (content, sum) = bytes.split_last_chunk::<LENGTH>().ok_or(ChecksumError::Missing)?;
    let (stored, computed) = (u32::from_le_bytes(*sum), crc32fast::hash(content));
    if stored == computed { Ok(content) } else { Err(ChecksumError::Differs { stored, computed }) }
}
