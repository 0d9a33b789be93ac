//! Reads .vtu, .vtp and legacy .vtk with `vtkio`, which cannot read raw or compressed appended arrays, and requests all
//! memory for a compressed array with a damaged header. So such arrays are first rewritten (`inline_arrays`).

use super::inline_arrays::{Layout, all_inline, attribute, damaged, find, first_root};
use std::borrow::Cow;
use vtkio::model::{Attribute, DataSet, IOBuffer, Piece};

/// The content of a file.
///
/// # Errors
/// The fault of the file, as the end of a sentence that begins with its name.
pub fn read(bytes: &[u8]) -> Result<DataSet, String> {
    Ok(read_with_fields(bytes)?.0)
}

/// Arrays of whole numbers that belong to a file as a whole, by name.
pub type FieldArrays = Vec<(String, Vec<i64>)>;

/// The content of a file, and the whole numbers of the arrays that an XML file has as a whole (`FieldData`), which the
/// library leaves out; arrays of other types are not listed.
///
/// # Errors
/// As [`read`].
pub fn read_with_fields(bytes: &[u8]) -> Result<(DataSet, FieldArrays), String> {
    let parse = || {
        let (vtk, fields) = if bytes.trim_ascii_start().starts_with(b"<") {
            let inline = all_inline(bytes)?;
            (vtkio::Vtk::parse_xml(&*inline), field_numbers(&inline)?)
        } else {
            // Binary legacy files are big-endian; in text the order does not matter.
            (vtkio::Vtk::parse_legacy_be(&*without_field(bytes)), Vec::new())
        };
        let data = vtk.map(|vtk| vtk.data).map_err(|error| format!("is not a VTK file that can be read: {error}"));
        Ok((data?, fields))
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
pub fn whole_numbers(attributes: &[Attribute]) -> FieldArrays {
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

/// The whole numbers of the arrays of a file as a whole.
fn field_numbers(inline: &[u8]) -> Result<FieldArrays, String> {
    let (begin, end) = (find(inline, FIELD.as_bytes()), find(inline, FIELD_END.as_bytes()));
    let (Some(begin), Some(end)) = (begin, end) else { return Ok(Vec::new()) };
    let section = inline.get(begin..end).and_then(|bytes| std::str::from_utf8(bytes).ok()).unwrap_or_default();
    let layout = Layout::of(first_root(inline));
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
