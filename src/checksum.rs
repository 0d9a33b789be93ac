//! The CRC-32 (IEEE 802.3), little-endian, after all binary data that are stored: damage is found before decoding.

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
