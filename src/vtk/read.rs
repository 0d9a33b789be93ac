//! Reads .vtu, .vtp and legacy .vtk with `vtkio`, which cannot read raw or compressed appended arrays, and requests all
//! memory for a compressed array with a damaged header. So appended or compressed arrays of XML files are first
//! rewritten: inline in base64, uncompressed.

use std::borrow::Cow;
use std::io::Read;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use vtkio::model::{Attribute, DataSet, Piece};

/// The content of a file.
///
/// # Errors
/// The fault of the file, as the end of a sentence that begins with its name.
pub fn read(bytes: &[u8]) -> Result<DataSet, String> {
    let parse = || {
        let vtk = if bytes.trim_ascii_start().starts_with(b"<") {
            vtkio::Vtk::parse_xml(&*all_inline(bytes)?)
        } else {
            // Binary legacy files are big-endian; in text the order does not matter.
            vtkio::Vtk::parse_legacy_be(bytes)
        };
        vtk.map(|vtk| vtk.data).map_err(|error| format!("is not a VTK file that can be read: {error}"))
    };
    // The library may panic on a damaged file, which must not end the program.
    std::panic::catch_unwind(parse)
        .unwrap_or_else(|_| Err("is damaged; the parser gave up on it. Write it anew".to_owned()))
}

/// The content of a piece; `Err` for one that refers to another file.
///
/// # Errors
/// As [`read`].
pub fn piece_content<P>(piece: Piece<P>) -> Result<P, String> {
    match piece {
        Piece::Inline(piece) => Ok(*piece),
        _ => Err("refers to other files; read those one by one".into()),
    }
}

/// The numbers of a named array, if it exists.
pub fn named_array(attributes: Vec<Attribute>, name: &str) -> Option<Vec<f64>> {
    attributes.into_iter().find_map(|attribute| match attribute {
        Attribute::DataArray(array) if array.name == name => array.data.cast_into(),
        _ => None,
    })
}

/// The whole numbers of the arrays that an XML file has as a whole (`FieldData`), which the library leaves out; arrays
/// of other types are not listed.
///
/// # Errors
/// As [`read`].
pub fn field_numbers(bytes: &[u8]) -> Result<Vec<(String, Vec<i64>)>, String> {
    let inline = all_inline(bytes)?;
    let begin = inline.windows(FIELD.len()).position(|w| w == FIELD.as_bytes());
    let end = inline.windows(FIELD_END.len()).position(|w| w == FIELD_END.as_bytes());
    let (Some(begin), Some(end)) = (begin, end) else { return Ok(Vec::new()) };
    let section = inline.get(begin..end).and_then(|bytes| std::str::from_utf8(bytes).ok()).unwrap_or_default();
    let layout = Layout::of(first_root(&inline));
    let mut arrays = Vec::new();
    for from in section.split("<DataArray").skip(1) {
        let (tag, rest) = from.split_once('>').unwrap_or_default();
        let content = rest.split('<').next().unwrap_or_default().trim();
        let bits = attribute(tag, "type").and_then(|t| t.trim_start_matches('U').strip_prefix("Int")?.parse().ok());
        let (Some(name), Some(bits)) = (attribute(tag, "Name"), bits) else { continue };
        let numbers = if attribute(tag, "format") == Some("binary") {
            layout.whole_numbers(content, bits)
        } else {
            content.split_ascii_whitespace().map(|word| word.parse().ok()).collect()
        };
        arrays.push((from_xml(name), numbers.ok_or_else(damaged)?));
    }
    Ok(arrays)
}

const FIELD: &str = "<FieldData";
const FIELD_END: &str = "</FieldData>";

/// The text of an XML attribute.
fn from_xml(text: &str) -> String {
    let marks = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&apos;", "'"), ("&amp;", "&")];
    marks.iter().fold(text.to_owned(), |text, (mark, sign)| text.replace(mark, sign))
}

/// The tag of the root of an XML file.
fn first_root(bytes: &[u8]) -> &str {
    bytes.windows(8).position(|w| w == b"<VTKFile").map_or("", |at| first_tag(&bytes[at..]))
}

fn damaged() -> String {
    "is damaged: a compressed or appended array has an impossible header or is cut off".to_owned()
}

/// The same file without an appended section and without compression.
fn all_inline(bytes: &[u8]) -> Result<Cow<'_, [u8]>, String> {
    let begin = bytes.windows(APPENDED.len()).position(|w| w == APPENDED.as_bytes());
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
        zlib: match attribute(root, "compressor") {
            None => false,
            Some("vtkZLibDataCompressor") => true,
            Some(_) => {
                return Err("is compressed with another method than zlib; save it uncompressed or with zlib".into());
            }
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
            Some("binary") if layout.zlib && !content.trim().is_empty() => {
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
fn attribute<'a>(tag: &'a str, key: &str) -> Option<&'a str> {
    let values = tag.match_indices(key).filter_map(|(at, _)| {
        let bare = tag[..at].ends_with(|c: char| c.is_ascii_whitespace());
        tag[at + key.len()..].strip_prefix("=\"").filter(|_| bare)?.split_once('"')
    });
    values.map(|(value, _)| value).next()
}

/// The layout of the arrays of a file.
struct Layout {
    zlib: bool,
    /// [byte] size of a number in the header of an array
    word: usize,
    big_endian: bool,
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
    fn of(root: &str) -> Self {
        Layout {
            zlib: false,
            word: if attribute(root, "header_type") == Some("UInt64") { 8 } else { 4 },
            big_endian: attribute(root, "byte_order") == Some("BigEndian"),
        }
    }

    /// Whole numbers of so many bits, from base64; the header of the array is not used.
    fn whole_numbers(&self, text: &str, bits: usize) -> Option<Vec<i64>> {
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
        let data = if self.zlib { self.unpacked(section) } else { self.plain(section) };
        data.ok_or_else(damaged)
    }

    /// The length in bytes, then the bytes.
    fn plain(&self, section: Section<'_>) -> Option<Vec<u8>> {
        let length = *self.numbers(section, 1)?.first()?;
        let (all, _) = section.take(self.word.checked_add(length)?)?;
        all.get(self.word..).map(<[u8]>::to_vec)
    }

    /// The number of blocks, their size, the size of a last partial one, the packed size of each; then the blocks.
    fn unpacked(&self, section: Section<'_>) -> Option<Vec<u8>> {
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
            let before = out.len();
            // Not more than the size in the header: a block of a kilobyte may expand to a megabyte.
            flate2::read::ZlibDecoder::new(block).take(expected as u64).read_to_end(&mut out).ok()?;
            (out.len() - before == expected).then_some(())?;
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
