//! Reads .vtu, .vtp and legacy .vtk with `vtkio`, which cannot read raw or compressed appended arrays, and requests all
//! memory for a compressed array with a damaged header. So appended or compressed arrays of XML files are first
//! rewritten: inline in base64, uncompressed.

use std::borrow::Cow;
use std::io::Read;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use vtkio::model::{Attribute, DataSet, IOBuffer, Piece};

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
            vtkio::Vtk::parse_legacy_be(&*without_field(bytes))
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

/// All arrays: their names, numbers a member, and data. Legacy files collect some in fields.
fn arrays(attributes: &[Attribute]) -> impl Iterator<Item = (&str, u32, &IOBuffer)> {
    attributes.iter().flat_map(|attribute| match attribute {
        Attribute::DataArray(array) => vec![(array.name.as_str(), array.num_comp() as u32, &array.data)],
        Attribute::Field { data_array, .. } => {
            data_array.iter().map(|array| (array.name.as_str(), array.elem, &array.data)).collect()
        }
    })
}

/// The numbers of a named array, if it exists.
pub fn named_array(attributes: &[Attribute], name: &str) -> Option<Vec<f64>> {
    arrays(attributes).find(|(known, ..)| *known == name).and_then(|(_, _, data)| data.clone().cast_into())
}

/// The arrays with one whole number a member.
pub fn whole_numbers(attributes: &[Attribute]) -> Vec<(String, Vec<i64>)> {
    let whole = arrays(attributes)
        .filter(|(_, count, data)| *count == 1 && !matches!(data, IOBuffer::F32(_) | IOBuffer::F64(_)));
    whole.filter_map(|(name, _, data)| Some((name.to_owned(), data.clone().cast_into()?))).collect()
}

/// What a frame of a run says of its points, `[n_points][3]`.
pub struct FramePoints {
    /// [m] positions
    pub positions: Vec<[f64; 3]>,
    /// [m] displacements from the mesh as given, if they are there; perhaps in single precision
    pub displacements: Option<Vec<[f64; 3]>>,
    /// [m/s] velocities, if they are there
    pub velocities: Option<Vec<[f64; 3]>>,
}

/// Reads the points of a frame.
///
/// # Errors
/// Why this is no frame of one piece.
pub fn frame_points(bytes: &[u8]) -> Result<FramePoints, String> {
    let DataSet::UnstructuredGrid { pieces, .. } = read(bytes)? else {
        return Err("holds no unstructured grid".into());
    };
    let mut pieces = pieces.into_iter();
    let (Some(piece), None) = (pieces.next(), pieces.next()) else {
        return Err("does not hold exactly one piece".into());
    };
    let piece = piece_content(piece)?;
    let values: Vec<f64> = piece.points.cast_into().ok_or("has points that are no numbers")?;
    let vectors = |values: Vec<f64>| values.as_chunks().0.to_vec();
    let array = |name| named_array(&piece.data.point, name).map(vectors);
    let (displacement, velocities) = (array("displacement"), array("velocity"));
    let positions = vectors(values);
    for list in [&displacement, &velocities].into_iter().flatten() {
        if list.len() != positions.len() {
            return Err("is damaged: an array has not one vector per point".into());
        }
    }
    if positions.iter().chain(velocities.iter().flatten()).flatten().any(|value| !value.is_finite()) {
        return Err("has numbers that are not finite".into());
    }
    Ok(FramePoints { positions, displacements: displacement, velocities })
}

/// A legacy file without the field that writers put before the points, which the library does not expect there.
fn without_field(bytes: &[u8]) -> Cow<'_, [u8]> {
    let line_at = |from: usize| {
        let rest = bytes.get(from..)?;
        let end = rest.iter().position(|byte| *byte == b'\n')?;
        Some((std::str::from_utf8(rest.get(..end)?).ok()?.trim(), from + end + 1))
    };
    let skipped = || {
        let mut at = 0;
        let mut binary = false;
        // Title, format and kind of the data come first.
        let (begin, mut at, count) = loop {
            let (line, next) = line_at(at)?;
            binary |= line == "BINARY";
            let mut words = line.split_ascii_whitespace();
            match words.next().map(str::to_ascii_uppercase).as_deref() {
                Some("FIELD") => break (at, next, words.nth(1)?.parse::<usize>().ok()?),
                Some("POINTS") => return None,
                _ => at = next,
            }
        };
        for _ in 0..count {
            let (line, next) = line_at(at)?;
            let [_, components, tuples, kind] = line.split_ascii_whitespace().collect::<Vec<_>>()[..] else {
                return None;
            };
            let numbers = components.parse::<usize>().ok()?.checked_mul(tuples.parse().ok()?)?;
            at = next;
            if binary {
                let width = match kind {
                    "double" | "long" | "unsigned_long" | "vtktypeint64" | "vtkIdType" => 8,
                    "float" | "int" | "unsigned_int" => 4,
                    "short" | "unsigned_short" => 2,
                    "char" | "unsigned_char" => 1,
                    _ => return None,
                };
                at = at.checked_add(numbers.checked_mul(width)?)?.checked_add(1)?;
            } else {
                let mut left = numbers;
                while left > 0 {
                    let (line, next) = line_at(at)?;
                    left = left.saturating_sub(line.split_ascii_whitespace().count());
                    at = next;
                }
            }
        }
        Some([bytes.get(..begin)?, bytes.get(at..)?].concat())
    };
    skipped().map_or(Cow::Borrowed(bytes), Cow::Owned)
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
fn attribute<'a>(tag: &'a str, key: &str) -> Option<&'a str> {
    let values = tag.match_indices(key).filter_map(|(at, _)| {
        let bare = tag[..at].ends_with(|c: char| c.is_ascii_whitespace());
        tag[at + key.len()..].strip_prefix("=\"").filter(|_| bare)?.split_once('"')
    });
    values.map(|(value, _)| value).next()
}

/// The layout of the arrays of a file.
struct Layout {
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
    fn of(root: &str) -> Self {
        Layout {
            packing: None,
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
