//! VTK's XML files, .vtu and .vtp.
//!
//! Source: "VTK XML file formats", <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.

use super::layout::{Layout, Section, damaged};
use super::numbers::{Numbers, Type, places, places_of};
use super::{Budget, CellLists, Column, DataSet, Piece, unfit};
use std::borrow::Cow;
use std::io::BufRead as _;

/// A tag with its attributes, and where it ends.
struct Tag<'a> {
    name: &'a str,
    attributes: &'a str,
    end: usize,
}

impl<'a> Tag<'a> {
    /// The tag that begins at the `<` of a place.
    fn at(bytes: &'a [u8], begin: usize) -> Option<Self> {
        let mut quoted = None;
        let length = bytes[begin..].iter().position(|byte| {
            match (quoted, byte) {
                (None, b'"' | b'\'') => quoted = Some(*byte),
                (Some(quote), byte) if quote == *byte => quoted = None,
                _ => {}
            }
            quoted.is_none() && *byte == b'>'
        })?;
        let text = std::str::from_utf8(&bytes[begin + 1..begin + length]).ok()?;
        let name = text.split(|c: char| c.is_whitespace()).next()?.trim_end_matches('/');
        Some(Tag { name, attributes: text.get(name.len()..)?, end: begin + length + 1 })
    }

    fn attribute(&self, key: &str) -> Option<&'a str> {
        let mut rest = self.attributes;
        while let Some((name, after)) = rest.split_once('=') {
            let after = after.trim_start();
            let quote = after.chars().next().filter(|c| ['"', '\''].contains(c))?;
            let (value, next) = after[1..].split_once(quote)?;
            if name.trim() == key {
                return Some(value);
            }
            rest = next;
        }
        None
    }

    fn count(&self, key: &str) -> Result<usize, String> {
        let Some(text) = self.attribute(key) else { return Ok(0) };
        text.trim().parse().map_err(|_| format!("is damaged: {key}=\"{text}\" is no count"))
    }
}

/// Where a byte stands next.
fn find(bytes: &[u8], byte: u8, from: usize) -> Option<usize> {
    // Faster than a look at each byte.
    let passed = (&bytes[from..]).skip_until(byte).ok()?;
    (from + passed).checked_sub(1).filter(|at| *at >= from && bytes[*at] == byte)
}

/// The text of an XML attribute.
fn from_xml(text: &str) -> Cow<'_, str> {
    if !text.contains('&') {
        return Cow::Borrowed(text);
    }
    let marks = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&apos;", "'"), ("&amp;", "&")];
    Cow::Owned(marks.iter().fold(text.to_owned(), |text, (mark, sign)| text.replace(mark, sign)))
}

/// An array before it is decoded.
struct Array<'a> {
    name: Cow<'a, str>,
    kind: Option<Type>,
    components: usize,
    tuples: Option<usize>,
    data: Data<'a>,
}

enum Data<'a> {
    Words(&'a [u8]),
    Inline(&'a [u8]),
    Appended(usize),
}

/// A `<Piece>` with its arrays, by the names of their sections.
struct PieceArrays<'a> {
    tag: Tag<'a>,
    arrays: Vec<(&'a str, Array<'a>)>,
}

pub(super) fn read(bytes: &[u8], names: &[&str]) -> Result<DataSet, String> {
    let (mut at, mut section, mut root) = (0, "", None);
    let mut fields = Vec::new();
    let mut pieces: Vec<PieceArrays<'_>> = Vec::new();
    let mut appended: Option<Section<'_>> = None;
    while let Some(begin) = find(bytes, b'<', at) {
        if bytes[begin..].starts_with(b"<!--") {
            let end = bytes[begin..].windows(3).position(|three| three == b"-->");
            at = begin + end.ok_or("is cut off: a comment does not end")? + 3;
            continue;
        }
        let tag = Tag::at(bytes, begin).ok_or("is cut off, or is no XML: a tag does not end")?;
        at = tag.end;
        match tag.name {
            "VTKFile" => root = Some(tag),
            "Piece" => pieces.push(PieceArrays { tag, arrays: Vec::new() }),
            "Points" | "Cells" | "PointData" | "CellData" | "FieldData" | "Verts" | "Lines" | "Strips" | "Polys" => {
                section = tag.name;
            }
            "DataArray" => {
                let (array, end) = array(bytes, &tag)?;
                at = end;
                match pieces.last_mut() {
                    _ if section == "FieldData" => fields.push(array),
                    Some(piece) => piece.arrays.push((section, array)),
                    None => {}
                }
            }
            "AppendedData" => {
                let base64 = tag.attribute("encoding") != Some("raw");
                // The data follow an underscore.
                let mark = bytes[at..].iter().position(|byte| *byte == b'_').ok_or_else(damaged)?;
                appended = Some(Section { bytes: &bytes[at + mark + 1..], base64 });
                break;
            }
            _ => {}
        }
    }
    let root = root.ok_or("is not a VTK file: it has no <VTKFile>")?;
    let kind = root.attribute("type").unwrap_or_default();
    let cells = match kind {
        "UnstructuredGrid" => grid_cells,
        "PolyData" => poly_cells,
        _ if kind.starts_with('P') || kind.starts_with("vtk") || kind == "Collection" => {
            return Err(format!("lists other files ({kind}); {}", name_one(&files_of(bytes))));
        }
        "" => return Err("is not a VTK file: its <VTKFile> has no type".to_owned()),
        other => return Err(format!("holds neither an unstructured grid nor polygons, but {other}")),
    };
    let layout = Layout::of(|key| root.attribute(key))?;
    let mut file = Decoder { layout, appended, budget: Budget::of(bytes.len()) };
    let mut data = DataSet::default();
    for array in fields.iter().filter(|array| array.kind.is_some_and(Type::is_whole)) {
        let most = array.tuples.map(|tuples| tuples.saturating_mul(array.components));
        data.fields.push((array.name.clone().into_owned(), file.numbers(array, most)?.whole()));
    }
    for piece in &pieces {
        data.pieces.push(file.piece(piece, cells, names)?);
    }
    Ok(data)
}

/// An array by its tag, and where it ends.
fn array<'a>(bytes: &'a [u8], tag: &Tag<'a>) -> Result<(Array<'a>, usize), String> {
    let mut end = tag.end;
    let mut text: &[u8] = &[];
    if !tag.attributes.ends_with('/') {
        // Tags within it, such as the range of its numbers, are passed over.
        let mut depth = 0;
        loop {
            let next = find(bytes, b'<', end);
            let next = next.ok_or("is cut off: an array does not end")?;
            let between = bytes[end..next].trim_ascii();
            if depth == 0 && text.is_empty() {
                text = between;
            }
            let inner = Tag::at(bytes, next).ok_or("is cut off: an array does not end")?;
            end = inner.end;
            match inner.name {
                "/DataArray" => break,
                name if name.starts_with('/') => depth -= 1,
                _ if inner.attributes.ends_with('/') => {}
                _ => depth += 1,
            }
        }
    }
    let word = tag.attribute("type").unwrap_or_default();
    let bits = |text: &str| text.parse::<usize>().ok().map(|bits| bits / 8).filter(|size| [1, 2, 4, 8].contains(size));
    let kind = match word {
        "Float32" => Some(Type::Single),
        "Float64" => Some(Type::Double),
        _ => match (word.strip_prefix("Int"), word.strip_prefix("UInt")) {
            (Some(text), _) => bits(text).map(Type::Signed),
            (_, Some(text)) => bits(text).map(Type::Unsigned),
            _ => None,
        },
    };
    let data = match tag.attribute("format") {
        Some("appended") => Data::Appended(tag.count("offset")?),
        Some("binary") => Data::Inline(text),
        _ => Data::Words(text),
    };
    let tuples = tag.attribute("NumberOfTuples").and_then(|text| text.parse().ok());
    let components = tag.count("NumberOfComponents")?.max(1);
    let name = from_xml(tag.attribute("Name").unwrap_or_default());
    Ok((Array { name, kind, components, tuples, data }, end))
}

struct Decoder<'a> {
    layout: Layout,
    appended: Option<Section<'a>>,
    budget: Budget,
}

/// An array, whose bytes are not numbers yet.
enum Decoded<'a> {
    Numbers(Numbers),
    Bytes(Cow<'a, [u8]>, Type),
}

impl<'a> Decoder<'a> {
    /// An array; with `most`, not more than so many numbers.
    fn decoded<'b>(&mut self, array: &Array<'b>, most: Option<usize>) -> Result<Decoded<'b>, String>
    where
        'a: 'b,
    {
        let kind = array.kind.ok_or_else(|| format!("has no numbers in its array \"{}\"", array.name))?;
        let most = most.unwrap_or(self.budget.left / 8).min(self.budget.left / 8 + 1);
        let section = match array.data {
            Data::Words(text) => {
                let text = std::str::from_utf8(text).map_err(|_| "has an array that is not text")?;
                let numbers = Numbers::of_words(text.split_ascii_whitespace(), kind, most)?;
                self.budget.take(numbers.len())?;
                return Ok(Decoded::Numbers(numbers));
            }
            Data::Inline([]) => return Ok(Decoded::Numbers(Numbers::of_bytes(&[], kind, false))),
            Data::Inline(bytes) => Section { bytes, base64: true },
            Data::Appended(offset) => {
                let section = self.appended.ok_or_else(damaged)?;
                Section { bytes: section.bytes.get(offset..).ok_or_else(damaged)?, ..section }
            }
        };
        let bytes = self.layout.decode(section, most.saturating_mul(kind.size()))?;
        self.budget.take(bytes.len() / kind.size())?;
        Ok(Decoded::Bytes(bytes, kind))
    }

    fn numbers(&mut self, array: &Array<'_>, most: Option<usize>) -> Result<Numbers, String> {
        Ok(match self.decoded(array, most)? {
            Decoded::Numbers(numbers) => numbers,
            Decoded::Bytes(bytes, kind) => Numbers::of_bytes(&bytes, kind, self.layout.big_endian),
        })
    }

    /// Three numbers a point.
    fn places(&mut self, array: &Array<'_>, points: usize) -> Result<Vec<[f64; 3]>, String> {
        let made = match self.decoded(array, Some(points.saturating_mul(3)))? {
            Decoded::Numbers(numbers) => places_of(&numbers.reals()),
            Decoded::Bytes(bytes, kind) => places(&bytes, kind, self.layout.big_endian),
        };
        made.ok_or_else(|| "has points without three coordinates".to_owned())
    }

    /// Types of cells.
    fn types(&mut self, array: &Array<'_>, count: usize) -> Result<Vec<u8>, String> {
        let whole = match self.decoded(array, Some(count))? {
            Decoded::Bytes(bytes, Type::Unsigned(1)) => return Ok(bytes.into_owned()),
            Decoded::Bytes(bytes, kind) => Numbers::of_bytes(&bytes, kind, self.layout.big_endian).whole(),
            Decoded::Numbers(numbers) => numbers.whole(),
        };
        Ok(whole.into_iter().map(|kind| u8::try_from(kind).unwrap_or(u8::MAX)).collect())
    }

    fn piece(&mut self, piece: &PieceArrays<'_>, cells: CellsOf, names: &[&str]) -> Result<Piece, String> {
        let points = piece.tag.count("NumberOfPoints")?;
        let mut made = Piece::default();
        if let Some((_, array)) = piece.arrays.iter().find(|(section, _)| *section == "Points") {
            made.points = self.places(array, points)?;
        }
        if made.points.len() != points {
            return Err(format!("is damaged: it has {} of {points} points", made.points.len()));
        }
        made.cells = cells(self, piece)?;
        let rows = [("PointData", points), ("CellData", made.cells.ends.len())];
        for ((of, rows), columns) in rows.into_iter().zip([&mut made.point_data, &mut made.cell_data]) {
            for (_, array) in piece.arrays.iter().filter(|(section, _)| *section == of) {
                let marks = array.components == 1 && array.kind.is_some_and(Type::is_whole);
                if !(marks || names.contains(&array.name.as_ref()) && array.kind.is_some()) {
                    continue;
                }
                let numbers = self.numbers(array, Some(rows.saturating_mul(array.components)))?;
                columns.push(Column { name: array.name.to_string(), components: array.components, numbers });
            }
        }
        Ok(made)
    }

    /// The points of cells, and where those of each end.
    fn lists(&mut self, piece: &PieceArrays<'_>, of: &str, count: usize) -> Result<(Vec<i64>, Vec<usize>), String> {
        let find = |name: &str| piece.arrays.iter().find(|(section, array)| *section == of && array.name == name);
        if count == 0 {
            return Ok(Default::default());
        }
        let (_, offsets) = find("offsets").ok_or_else(unfit)?;
        // Newer files may begin with the offset 0.
        let offsets = self.numbers(offsets, Some(count + 1))?.whole();
        let ends = offsets.into_iter().filter(|end| *end != 0).map(usize::try_from);
        let ends: Vec<usize> = ends.collect::<Result<_, _>>().map_err(|_| unfit())?;
        if ends.len() != count {
            return Err(unfit());
        }
        let (_, points) = find("connectivity").ok_or_else(unfit)?;
        let points = self.numbers(points, Some(ends.last().copied().unwrap_or(0)))?.whole();
        Ok((points, ends))
    }
}

type CellsOf = fn(&mut Decoder<'_>, &PieceArrays<'_>) -> Result<CellLists, String>;

fn grid_cells(file: &mut Decoder<'_>, piece: &PieceArrays<'_>) -> Result<CellLists, String> {
    let count = piece.tag.count("NumberOfCells")?;
    let (points, ends) = file.lists(piece, "Cells", count)?;
    let mut cells = CellLists::default();
    cells.add(points, ends, 0)?;
    if count > 0 {
        let types = piece.arrays.iter().find(|(section, array)| *section == "Cells" && array.name == "types");
        let (_, types) = types.ok_or_else(unfit)?;
        cells.types = file.types(types, count)?;
        if cells.types.len() != count {
            return Err(format!("has {count} cells but {} cell types", cells.types.len()));
        }
    }
    Ok(cells)
}

fn poly_cells(file: &mut Decoder<'_>, piece: &PieceArrays<'_>) -> Result<CellLists, String> {
    let mut cells = CellLists::default();
    for (section, kind) in super::legacy::LISTS.iter().map(|(_, section, kind)| (*section, *kind)) {
        let count = piece.tag.count(&format!("NumberOf{section}"))?;
        let (points, ends) = file.lists(piece, section, count)?;
        cells.add(points, ends, kind)?;
    }
    Ok(cells)
}

/// Names of the files that an XML file lists.
pub(super) fn files_of(bytes: &[u8]) -> Vec<String> {
    let mut names = Vec::new();
    let mut at = 0;
    while let Some(begin) = find(bytes, b'<', at) {
        let Some(tag) = Tag::at(bytes, begin) else { break };
        at = tag.end;
        let name = tag.attribute("file").or_else(|| tag.attribute("Source"));
        names.extend(name.map(|name| from_xml(name).into_owned()));
    }
    names
}

/// What to do about a file that lists others.
pub(crate) fn name_one(files: &[String]) -> String {
    let shown: Vec<&str> = files.iter().take(5).map(String::as_str).collect();
    let rest = if files.len() > 5 { format!(", … ({} in all)", files.len()) } else { String::new() };
    if shown.is_empty() { "it lists none".to_owned() } else { format!("name one of them: {}{rest}", shown.join(", ")) }
}
