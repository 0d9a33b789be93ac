//! How the bytes of arrays of VTK's XML files are packed: raw or in base64, whole or in compressed blocks.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use std::borrow::Cow;
use std::io::Read;

pub(super) fn damaged() -> String {
    "is damaged: a compressed or appended array has an impossible header or is cut off".to_owned()
}

/// The layout of the arrays of a file.
pub(super) struct Layout {
    packing: Option<Packing>,
    /// [byte] size of a number in the header of an array
    word: usize,
    pub big_endian: bool,
}

/// How blocks of an array are compressed.
#[derive(Clone, Copy)]
enum Packing {
    Zlib,
    Lz4,
    Xz,
}

impl Packing {
    /// The bytes of a block, if there are as many as its header says.
    fn unpack(self, block: &[u8], expected: usize) -> Option<Vec<u8>> {
        // No more is read than that: a block of a kilobyte may expand to a megabyte.
        let mut out = Vec::new();
        match self {
            Packing::Zlib => {
                flate2::read::ZlibDecoder::new(block).take(expected as u64).read_to_end(&mut out).ok()?;
            }
            Packing::Lz4 => {
                // LZ4 makes at most 255 bytes of one.
                (expected <= block.len().saturating_mul(256)).then_some(())?;
                out = lz4_flex::block::decompress(block, expected).ok()?;
            }
            Packing::Xz => {
                let mut bounded = Bounded { out: &mut out, most: expected };
                lzma_rs::xz_decompress(&mut &*block, &mut bounded).ok()?;
            }
        }
        (out.len() == expected).then_some(out)
    }
}

/// Takes so many bytes and refuses more.
struct Bounded<'a> {
    out: &'a mut Vec<u8>,
    most: usize,
}

impl std::io::Write for Bounded<'_> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        if self.out.len() + bytes.len() > self.most {
            return Err(std::io::ErrorKind::InvalidData.into());
        }
        self.out.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// The start of an array, and all that follows it.
#[derive(Clone, Copy)]
pub(super) struct Section<'a> {
    pub bytes: &'a [u8],
    pub base64: bool,
}

impl<'a> Section<'a> {
    /// The first `n` bytes, and what follows them; in base64 a group of four characters is not shared.
    fn take(self, n: usize) -> Option<(Cow<'a, [u8]>, Section<'a>)> {
        let length = if self.base64 { n.div_ceil(3).checked_mul(4)? } else { n };
        let (taken, bytes) = self.bytes.split_at_checked(length)?;
        let rest = Section { bytes, ..self };
        if !self.base64 {
            return Some((Cow::Borrowed(taken), rest));
        }
        let mut decoded = STANDARD.decode(taken).ok()?;
        decoded.truncate(n);
        Some((Cow::Owned(decoded), rest))
    }
}

impl Layout {
    /// The layout of a file, by the attributes of its root.
    pub(super) fn of<'a>(attribute: impl Fn(&str) -> Option<&'a str>) -> Result<Self, String> {
        let packing = match attribute("compressor") {
            None | Some("") => None,
            Some("vtkZLibDataCompressor") => Some(Packing::Zlib),
            Some("vtkLZ4DataCompressor") => Some(Packing::Lz4),
            Some("vtkLZMADataCompressor") => Some(Packing::Xz),
            Some(other) => return Err(format!("is compressed by {other}, which is not known; save it with zlib")),
        };
        let word = if attribute("header_type") == Some("UInt64") { 8 } else { 4 };
        Ok(Layout { packing, word, big_endian: attribute("byte_order") == Some("BigEndian") })
    }

    /// The data of an array: at most so many bytes, or it is damaged.
    pub(super) fn decode<'a>(&self, section: Section<'a>, most: usize) -> Result<Cow<'a, [u8]>, String> {
        let data = match self.packing {
            Some(packing) => self.unpacked(packing, section, most).map(Cow::Owned),
            None => self.plain(section, most),
        };
        data.ok_or_else(damaged)
    }

    /// The length in bytes, then the bytes. In base64 the length may be a text of its own.
    fn plain<'a>(&self, section: Section<'a>, most: usize) -> Option<Cow<'a, [u8]>> {
        let length = *self.numbers(section, 1)?.first().filter(|length| **length <= most)?;
        let (_, after) = section.take(self.word)?;
        let alone = section.base64 && section.bytes.get(..self.word.div_ceil(3) * 4)?.contains(&b'=');
        if alone && length > 0 {
            return Some(after.take(length)?.0);
        }
        let (all, _) = section.take(self.word.checked_add(length)?)?;
        Some(match all {
            Cow::Borrowed(all) => Cow::Borrowed(all.get(self.word..)?),
            Cow::Owned(mut all) => {
                all.drain(..self.word.min(all.len()));
                Cow::Owned(all)
            }
        })
    }

    /// The number of blocks, their size, the size of a last partial one, the packed size of each; then the blocks.
    fn unpacked(&self, packing: Packing, section: Section<'_>, most: usize) -> Option<Vec<u8>> {
        let &[blocks, size, partial] = self.numbers(section, 3)?.first_chunk()?;
        if blocks == 0 {
            return Some(Vec::new());
        }
        // Nothing is inflated beyond what the counts of the file allow.
        let whole = if partial > 0 { blocks - 1 } else { blocks };
        let inflated = whole.checked_mul(size)?.checked_add(partial).filter(|bytes| *bytes <= most)?;
        let sizes = self.numbers(section, blocks.checked_add(3)?)?;
        let (_, packed) = section.take(sizes.len() * self.word)?;
        let lengths = sizes.get(3..)?;
        let total = lengths.iter().try_fold(0, |sum: usize, length| sum.checked_add(*length))?;
        let (packed, _) = packed.take(total)?;
        let (mut out, mut packed) = (Vec::with_capacity(inflated), &packed[..]);
        for (i, length) in lengths.iter().enumerate() {
            let (block, rest) = packed.split_at_checked(*length)?;
            let expected = if i + 1 == blocks && partial > 0 { partial } else { size };
            out.extend(packing.unpack(block, expected)?);
            packed = rest;
        }
        Some(out)
    }

    /// The first numbers of a header.
    fn numbers(&self, section: Section<'_>, count: usize) -> Option<Vec<usize>> {
        let (bytes, _) = section.take(count.checked_mul(self.word)?)?;
        let number = |chunk: &[u8]| {
            let wide = |mut all: [u8; 8], (i, byte): (usize, &u8)| {
                all[if self.big_endian { self.word - 1 - i } else { i }] = *byte;
                all
            };
            usize::try_from(u64::from_le_bytes(chunk.iter().enumerate().fold([0; 8], wide))).ok()
        };
        bytes.chunks_exact(self.word).map(number).collect()
    }
}
