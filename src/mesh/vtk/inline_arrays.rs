//! Arrays of VTK's XML files, rewritten: inline in base64, uncompressed.

use std::borrow::Cow;
use std::io::Read;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

/// Where a tag begins. Only places of its first byte are compared, which are rare.
pub(super) fn find(bytes: &[u8], tag: &[u8]) -> Option<usize> {
    let mut from = 0;
    while let Some(at) = bytes.get(from..)?.iter().position(|byte| Some(byte) == tag.first()) {
        if bytes[from + at..].starts_with(tag) {
            return Some(from + at);
        }
        from += at + 1;
    }
    None
}

/// The tag of the root of an XML file.
pub(super) fn first_root(bytes: &[u8]) -> &str {
    find(bytes, b"<VTKFile").map_or("", |at| first_tag(&bytes[at..]))
}

pub(super) fn damaged() -> String {
    "is damaged: a compressed or appended array has an impossible header or is cut off".to_owned()
}

/// The same file without an appended section and without compression.
pub(super) fn all_inline(bytes: &[u8]) -> Result<Cow<'_, [u8]>, String> {
    let begin = find(bytes, APPENDED.as_bytes());
    let (head, section) = bytes.split_at(begin.unwrap_or(bytes.len()));
    let root = first_root(head);
    if begin.is_none() && attribute(root, "compressor").is_none() {
        return Ok(Cow::Borrowed(bytes));
    }
    let head = std::str::from_utf8(head).map_err(|_| "is not text")?;
    let section_tag = first_tag(section);
    // The data follow an underscore.
    let mark = section.iter().skip(section_tag.len()).position(|byte| *byte == b'_');
    let layout = Layout {
        packing: match attribute(root, "compressor") {
            None => None,
            Some("vtkZLibDataCompressor") => Some(Packing::Zlib),
            Some("vtkLZ4DataCompressor") => Some(Packing::Lz4),
            Some("vtkLZMADataCompressor") => Some(Packing::Xz),
            Some(other) => return Err(format!("is compressed by {other}, which is not known; save it with zlib")),
        },
        ..Layout::of(root)
    };
    let appended = mark.map_or(&[][..], |at| &section[section_tag.len() + at + 1..]);
    let appended_as_text = attribute(section_tag, "encoding") != Some("raw");
    let mut out = String::with_capacity(head.len());
    let mut rest = head;
    while let Some((before, from)) = rest.find("<DataArray").map(|at| rest.split_at(at)) {
        let tag = first_tag(from.as_bytes());
        let after = from.get(tag.len()..).unwrap_or_default();
        let content = if tag.ends_with("/>") { "" } else { after.split('<').next().unwrap_or_default() };
        let data = match attribute(tag, "format") {
            Some("appended") => {
                let offset = attribute(tag, "offset").and_then(|offset| offset.parse().ok()).unwrap_or(0);
                let bytes = appended.get(offset..).ok_or_else(damaged)?;
                Some(layout.decode(Section { bytes, base64: appended_as_text })?)
            }
            Some("binary") if layout.packing.is_some() && !content.trim().is_empty() => {
                Some(layout.decode(Section { bytes: content.trim().as_bytes(), base64: true })?)
            }
            _ => None,
        };
        out.push_str(before);
        match data {
            Some(data) => {
                // The offset is kept, but has no meaning here.
                let open = tag.replace("format=\"appended\"", "format=\"binary\"");
                let data = STANDARD.encode([&vec![0; layout.word], data.as_slice()].concat());
                out.extend([open.trim_end_matches(['/', '>']), ">", &data, "</DataArray>"]);
                let closed = |(_, rest)| rest;
                rest = if tag.ends_with("/>") { after } else { after.split_once("</DataArray>").map_or("", closed) };
            }
            None => {
                out.push_str(tag);
                rest = after;
            }
        }
    }
    out.push_str(rest);
    if begin.is_some() {
        out.push_str("</VTKFile>");
    }
    let compressor = format!(" compressor=\"{}\"", attribute(root, "compressor").unwrap_or_default());
    Ok(Cow::Owned(out.replacen(&compressor, "", 1).into_bytes()))
}

const APPENDED: &str = "<AppendedData";

/// The tag at the start of some bytes, with its brackets, or all bytes if the tag is not closed.
fn first_tag(bytes: &[u8]) -> &str {
    let end = bytes.iter().position(|byte| *byte == b'>').map_or(bytes.len(), |end| end + 1);
    std::str::from_utf8(&bytes[..end]).unwrap_or_default()
}

/// The value of an attribute in a tag.
pub(super) fn attribute<'a>(tag: &'a str, key: &str) -> Option<&'a str> {
    let values = tag.match_indices(key).filter_map(|(at, _)| {
        let bare = tag[..at].ends_with(|c: char| c.is_ascii_whitespace());
        tag[at + key.len()..].strip_prefix("=\"").filter(|_| bare)?.split_once('"')
    });
    values.map(|(value, _)| value).next()
}

/// The layout of the arrays of a file.
pub(super) struct Layout {
    packing: Option<Packing>,
    /// [byte] size of a number in the header of an array
    word: usize,
    big_endian: bool,
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

/// The start of an array.
#[derive(Clone, Copy)]
struct Section<'a> {
    bytes: &'a [u8],
    base64: bool,
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
    /// The layout of a file without compression, by the tag of its root.
    pub(super) fn of(root: &str) -> Self {
        Layout {
            packing: None,
            word: if attribute(root, "header_type") == Some("UInt64") { 8 } else { 4 },
            big_endian: attribute(root, "byte_order") == Some("BigEndian"),
        }
    }

    /// Whole numbers of so many bits, from base64; the header of the array is not used.
    pub(super) fn whole_numbers(&self, text: &str, bits: usize) -> Option<Vec<i64>> {
        let width = Some(bits / 8).filter(|width| (1..=8).contains(width))?;
        let bytes = STANDARD.decode(text).ok()?;
        let number = |chunk: &[u8]| {
            let ordered = |i: usize| if self.big_endian { chunk[i] } else { chunk[width - 1 - i] };
            (0..width).fold(0_i64, |sum, i| (sum << 8) | i64::from(ordered(i)))
        };
        Some(bytes.get(self.word..)?.chunks_exact(width).map(number).collect())
    }

    /// The data of an array.
    fn decode(&self, section: Section<'_>) -> Result<Vec<u8>, String> {
        let data = match self.packing {
            Some(packing) => self.unpacked(packing, section),
            None => self.plain(section),
        };
        data.ok_or_else(damaged)
    }

    /// The length in bytes, then the bytes.
    fn plain(&self, section: Section<'_>) -> Option<Vec<u8>> {
        let length = *self.numbers(section, 1)?.first()?;
        let (all, _) = section.take(self.word.checked_add(length)?)?;
        all.get(self.word..).map(<[u8]>::to_vec)
    }

    /// The number of blocks, their size, the size of a last partial one, the packed size of each; then the blocks.
    fn unpacked(&self, packing: Packing, section: Section<'_>) -> Option<Vec<u8>> {
        let &[blocks, size, partial] = self.numbers(section, 3)?.first_chunk()?;
        let sizes = self.numbers(section, blocks.checked_add(3)?)?;
        let (_, packed) = section.take(sizes.len() * self.word)?;
        let lengths = sizes.get(3..)?;
        let total = lengths.iter().try_fold(0, |sum: usize, length| sum.checked_add(*length))?;
        let (packed, _) = packed.take(total)?;
        let (mut out, mut packed) = (Vec::new(), &packed[..]);
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
