//! VTK's legacy files, .vtk, in text and in binary, versions 1 to 5.
//!
//! Source: "VTK file formats", <https://docs.vtk.org/en/latest/vtk_file_formats/vtk_legacy_file_format.html>, and
//! `vtkDataReader.cxx` for what stands in files beyond it: METADATA, FIELD anywhere, types of numbers, and strings.

use super::numbers::{Numbers, Type, places, places_of};
use super::{Budget, CellLists, Column, DataSet, Piece, unfit};

/// Lists of cells of polygons, in the order in which cells are counted: their names in legacy and in XML files, and the
/// type of their cells.
pub(super) const LISTS: [(&str, &str, u8); 4] =
    [("VERTICES", "Verts", 2), ("LINES", "Lines", 4), ("POLYGONS", "Polys", 7), ("TRIANGLE_STRIPS", "Strips", 6)];

pub(super) fn read(bytes: &[u8], names: &[&str]) -> Result<DataSet, String> {
    let mut file = Reader { bytes, at: 0, binary: false, names, budget: Budget::of(bytes.len()) };
    let version = file.line().unwrap_or_default();
    if !version.to_ascii_lowercase().starts_with("# vtk datafile") {
        return Err("is not a VTK file: it begins neither with \"<\" nor with \"# vtk DataFile Version\"".to_owned());
    }
    // The title, which may be empty, or in any encoding.
    file.line();
    file.binary = match file.line().unwrap_or_default().trim().to_ascii_uppercase().as_str() {
        "ASCII" => false,
        "BINARY" => true,
        other => return Err(format!("is not a VTK file: \"{other}\" is neither ASCII nor BINARY")),
    };
    file.sections()
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    binary: bool,
    /// names of arrays that are wanted
    names: &'a [&'a str],
    budget: Budget,
}

/// Where arrays belong to.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Rows {
    File,
    Points(usize),
    Cells(usize),
}

/// Cells of one list: their points, and where those of each end.
type List = (Vec<i64>, Vec<usize>);

impl<'a> Reader<'a> {
    fn sections(&mut self) -> Result<DataSet, String> {
        let (mut data, mut piece) = (DataSet::default(), Piece::default());
        let mut lists: [List; 4] = Default::default();
        let mut grid: Option<List> = None;
        let mut rows = Rows::File;
        while let Some(line) = self.line() {
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            let Some(word) = words.first().map(|word| word.to_ascii_uppercase()) else { continue };
            let count = |at: usize| -> Result<usize, String> {
                let text = words.get(at).copied().unwrap_or_default();
                text.parse().map_err(|_| format!("is damaged: \"{text}\" is no count, in \"{line}\""))
            };
            let list = LISTS.iter().position(|(name, ..)| *name == word);
            match word.as_str() {
                "DATASET" => {
                    let kind = words.get(1).copied().unwrap_or_default().to_ascii_uppercase();
                    if !["UNSTRUCTURED_GRID", "POLYDATA"].contains(&kind.as_str()) {
                        return Err(format!("holds neither an unstructured grid nor polygons, but {kind}"));
                    }
                }
                "METADATA" => self.skip_metadata(),
                "FIELD" => {
                    for column in self.field(count(2)?, rows)? {
                        match (rows, column.numbers) {
                            (Rows::File, Numbers::Whole(numbers)) => data.fields.push((column.name, numbers)),
                            (Rows::File, _) => {}
                            (Rows::Points(_), numbers) => piece.point_data.push(Column { numbers, ..column }),
                            (Rows::Cells(_), numbers) => piece.cell_data.push(Column { numbers, ..column }),
                        }
                    }
                }
                "POINTS" => {
                    let kind = kind_of(words.get(2).copied().unwrap_or_default())?;
                    piece.points = self.places(count(1)?.saturating_mul(3), kind)?;
                }
                "CELLS" => grid = Some(self.cells(count(1)?, count(2)?)?),
                _ if list.is_some() => lists[list.unwrap_or(0)] = self.cells(count(1)?, count(2)?)?,
                "CELL_TYPES" => {
                    let types = self.numbers(count(1)?, Kind::Number(Type::Signed(4)))?.whole();
                    piece.cells.types = types.into_iter().map(|kind| u8::try_from(kind).unwrap_or(u8::MAX)).collect();
                }
                "POINT_DATA" => rows = Rows::Points(count(1)?),
                "CELL_DATA" => rows = Rows::Cells(count(1)?),
                "LOOKUP_TABLE" => drop(self.numbers(count(2)?.saturating_mul(4), self.colours())?),
                _ => {
                    let (of, rows) = match rows {
                        Rows::Points(rows) => (&mut piece.point_data, rows),
                        Rows::Cells(rows) => (&mut piece.cell_data, rows),
                        Rows::File => return Err(format!("is damaged, or not known: \"{}\"", short(&line))),
                    };
                    of.extend(self.attribute(&word, &words, rows)?);
                }
            }
        }
        let types = std::mem::take(&mut piece.cells.types);
        let mut cells = CellLists::default();
        if let Some((points, ends)) = grid {
            cells.add(points, ends, 0)?;
            if types.len() != cells.ends.len() {
                return Err(format!("has {} cells but {} cell types", cells.ends.len(), types.len()));
            }
            cells.types = types;
        }
        for ((points, ends), (_, _, kind)) in lists.into_iter().zip(LISTS) {
            cells.add(points, ends, kind)?;
        }
        piece.cells = cells;
        data.pieces.push(piece);
        Ok(data)
    }

    /// An array of one kind of attribute, if it is wanted.
    fn attribute(&mut self, word: &str, words: &[&str], rows: usize) -> Result<Option<Column>, String> {
        let name = plain(words.get(1).copied().unwrap_or_default());
        let number = |at: usize, absent: usize| words.get(at).and_then(|text| text.parse().ok()).unwrap_or(absent);
        let kind = |at: usize| kind_of(words.get(at).copied().unwrap_or_default());
        let (components, kind) = match word {
            "SCALARS" => (number(3, 1), kind(2)?),
            "COLOR_SCALARS" => (number(2, 1), self.colours()),
            "VECTORS" | "NORMALS" => (3, kind(2)?),
            "TEXTURE_COORDINATES" => (number(2, 1), kind(3)?),
            "TENSORS" => (9, kind(2)?),
            "TENSORS6" => (6, kind(2)?),
            "GLOBAL_IDS" | "PEDIGREE_IDS" | "EDGE_FLAGS" => (1, kind(2)?),
            other => return Err(format!("is damaged, or not known: \"{}\"", short(other))),
        };
        if word == "SCALARS" {
            // The name of a table of colours, which may be left out.
            let here = self.at;
            if !self.line().is_some_and(|line| line.trim_start().to_ascii_uppercase().starts_with("LOOKUP_TABLE")) {
                self.at = here;
            }
        }
        self.column(name, components, rows, kind)
    }

    /// The arrays of a FIELD.
    fn field(&mut self, count: usize, rows: Rows) -> Result<Vec<Column>, String> {
        let mut columns = Vec::new();
        for _ in 0..count {
            let line = loop {
                let line = self.line().ok_or("is cut off within a FIELD")?;
                match line.split_ascii_whitespace().next() {
                    None => {}
                    Some("METADATA") => self.skip_metadata(),
                    Some(_) => break line,
                }
            };
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            let &[name, components, tuples, kind] = &words[..] else {
                // An array that is not there.
                if words == ["NULL_ARRAY"] {
                    continue;
                }
                return Err(format!("is damaged: \"{}\" begins no array of a FIELD", short(&line)));
            };
            let size = |text: &str| text.parse::<usize>().map_err(|_| format!("is damaged: \"{text}\" is no count"));
            let (components, tuples) = (size(components)?, size(tuples)?);
            let fits = match rows {
                Rows::File => true,
                Rows::Points(rows) | Rows::Cells(rows) => tuples == rows,
            };
            let column = self.column(plain(name), components, tuples, kind_of(kind)?)?;
            columns.extend(column.filter(|_| fits));
        }
        Ok(columns)
    }

    /// An array, if it is wanted.
    fn column(&mut self, name: String, components: usize, rows: usize, kind: Kind) -> Result<Option<Column>, String> {
        let count = components.saturating_mul(rows);
        let marks = components == 1 && matches!(kind, Kind::Number(kind) if kind.is_whole());
        if !marks && !self.names.contains(&name.as_str()) {
            self.skip(count, kind)?;
            return Ok(None);
        }
        Ok(Some(Column { name, components, numbers: self.numbers(count, kind)? }))
    }

    /// Cells: in old files each with its number of points before them, in newer ones as two arrays.
    fn cells(&mut self, count: usize, size: usize) -> Result<List, String> {
        let here = self.at;
        let line = loop {
            match self.line() {
                Some(line) if line.trim().is_empty() => {}
                line => break line.unwrap_or_default(),
            }
        };
        if line.trim_start().starts_with("OFFSETS") {
            let kind = |line: &str| kind_of(line.split_ascii_whitespace().nth(1).unwrap_or_default());
            let offsets = self.numbers(count, kind(&line)?)?.whole();
            let line = loop {
                match self.line().ok_or_else(unfit)? {
                    line if line.trim().is_empty() => {}
                    line if line.trim() == "METADATA" => self.skip_metadata(),
                    line => break line,
                }
            };
            let points = self.numbers(size, kind(&line)?)?.whole();
            let ends = offsets.into_iter().skip(1).map(usize::try_from);
            return Ok((points, ends.collect::<Result<_, _>>().map_err(|_| unfit())?));
        }
        self.at = here;
        let list = if self.binary {
            let words = self.take(size.checked_mul(4))?.as_chunks().0;
            self.budget.take(size)?;
            split(words.iter().map(|word| i32::from_be_bytes(*word).into()), count)
        } else {
            split(self.numbers(size, Kind::Number(Type::Signed(4)))?.whole().into_iter(), count)
        };
        list.ok_or_else(unfit)
    }

    /// The next line, with its bytes as Latin-1, without its end.
    fn line(&mut self) -> Option<String> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
        self.at += length + 1;
        Some(rest[..length].iter().map(|byte| char::from(*byte)).collect::<String>().trim_end_matches('\r').to_owned())
    }

    /// Text up to an empty line.
    fn skip_metadata(&mut self) {
        while self.line().is_some_and(|line| !line.trim().is_empty()) {}
    }

    /// Colours are bytes in binary, and real numbers in text.
    fn colours(&self) -> Kind {
        Kind::Number(if self.binary { Type::Unsigned(1) } else { Type::Single })
    }

    /// The next word of a text.
    fn word(&mut self) -> Option<&str> {
        let rest = self.bytes.get(self.at..)?;
        let begin = rest.iter().position(|byte| !byte.is_ascii_whitespace())?;
        let length = rest[begin..].iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len() - begin);
        self.at += begin + length;
        std::str::from_utf8(&rest[begin..begin + length]).ok()
    }

    /// The bytes of so many numbers, in binary.
    fn take(&mut self, bytes: Option<usize>) -> Result<&'a [u8], String> {
        let taken = bytes.and_then(|bytes| self.bytes.get(self.at..)?.get(..bytes));
        let taken = taken.ok_or("is cut off: an array is longer than the rest of the file")?;
        self.at += taken.len();
        Ok(taken)
    }

    /// Refuses more words than the rest of the file can hold.
    fn check_words(&self, count: usize) -> Result<(), String> {
        let rest = self.bytes.len().saturating_sub(self.at);
        if count > rest.div_ceil(2) {
            Err("is cut off: an array is longer than the rest of the file".to_owned())
        } else {
            Ok(())
        }
    }

    fn numbers(&mut self, count: usize, kind: Kind) -> Result<Numbers, String> {
        let Kind::Number(kind) = kind else {
            return Err("has text where numbers are expected".to_owned());
        };
        if self.binary {
            let bytes = self.take(count.checked_mul(kind.size()))?;
            self.budget.take(count)?;
            return Ok(Numbers::of_bytes(bytes, kind, true));
        }
        self.check_words(count)?;
        self.budget.take(count)?;
        let mut words = Vec::with_capacity(count);
        let mut whole = Vec::new();
        for _ in 0..count {
            let word = self.word().ok_or("is cut off: an array is longer than the rest of the file")?;
            let fault = || format!("has \"{}\" where a number is expected", short(word));
            if kind.is_whole() {
                whole.push(word.parse::<i64>().map_err(|_| fault())?);
            } else {
                words.push(word.parse::<f64>().map_err(|_| fault())?);
            }
        }
        Ok(if kind.is_whole() { Numbers::Whole(whole) } else { Numbers::Real(words) })
    }

    /// Places of so many numbers.
    fn places(&mut self, count: usize, kind: Kind) -> Result<Vec<[f64; 3]>, String> {
        let made = match kind {
            Kind::Number(kind) if self.binary => {
                let bytes = self.take(count.checked_mul(kind.size()))?;
                self.budget.take(count)?;
                places(bytes, kind, true)
            }
            kind => places_of(&self.numbers(count, kind)?.reals()),
        };
        made.ok_or_else(unfit)
    }

    /// Passes over an array.
    fn skip(&mut self, count: usize, kind: Kind) -> Result<(), String> {
        match (kind, self.binary) {
            (Kind::Number(kind), true) => drop(self.take(count.checked_mul(kind.size()))?),
            (Kind::Bits, true) => drop(self.take(Some(count.div_ceil(8)))?),
            (Kind::Text, true) => {
                for _ in 0..count {
                    let first = *self.take(Some(1))?.first().ok_or_else(unfit)?;
                    // The first two bits tell how many bytes the length has.
                    let more = [7, 3, 1, 0][usize::from(first >> 6)];
                    let mut length = usize::from(first & 0x3f);
                    for byte in self.take(Some(more))? {
                        length = length.saturating_mul(256).saturating_add(usize::from(*byte));
                    }
                    self.take(Some(length))?;
                }
            }
            (Kind::Text, false) => {
                self.check_words(count)?;
                // Each stands in a line of its own, and may be empty.
                for _ in 0..count {
                    self.line().ok_or("is cut off within an array of text")?;
                }
            }
            (_, false) => {
                self.check_words(count)?;
                for _ in 0..count {
                    self.word().ok_or("is cut off: an array is longer than the rest of the file")?;
                }
            }
        }
        Ok(())
    }
}

/// So many cells of numbers in which the number of points of each stands before them.
fn split(mut numbers: impl ExactSizeIterator<Item = i64>, count: usize) -> Option<List> {
    let size = numbers.len();
    let (mut points, mut ends) = (Vec::with_capacity(size.saturating_sub(count)), Vec::with_capacity(count.min(size)));
    while let Some(length) = numbers.next() {
        let length = usize::try_from(length).ok().filter(|length| *length <= numbers.len())?;
        points.extend(numbers.by_ref().take(length));
        ends.push(points.len());
    }
    (ends.len() == count).then_some((points, ends))
}

/// What an array holds.
#[derive(Clone, Copy)]
enum Kind {
    Number(Type),
    Bits,
    Text,
}

fn kind_of(word: &str) -> Result<Kind, String> {
    Ok(Kind::Number(match word.to_ascii_lowercase().as_str() {
        "char" | "signed_char" | "vtktypeint8" => Type::Signed(1),
        "unsigned_char" | "vtktypeuint8" => Type::Unsigned(1),
        "short" | "vtktypeint16" => Type::Signed(2),
        "unsigned_short" | "vtktypeuint16" => Type::Unsigned(2),
        // VTK writes its numbers of points and cells as int.
        "int" | "vtkidtype" | "vtktypeint32" => Type::Signed(4),
        "unsigned_int" | "vtktypeuint32" => Type::Unsigned(4),
        "long" | "long_long" | "vtktypeint64" | "__int64" => Type::Signed(8),
        "unsigned_long" | "unsigned_long_long" | "vtktypeuint64" | "unsigned___int64" => Type::Unsigned(8),
        "float" => Type::Single,
        "double" => Type::Double,
        "bit" => return Ok(Kind::Bits),
        "string" | "utf8_string" | "unicode_string" | "variant" => return Ok(Kind::Text),
        other => return Err(format!("has an array of the type \"{}\", which is not known", short(other))),
    }))
}

fn short(text: &str) -> String {
    text.chars().take(40).collect()
}

/// A name without its escapes: %20 is a blank.
fn plain(name: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest: Vec<u8> = name.chars().map(|c| u8::try_from(u32::from(c)).unwrap_or(b'?')).collect();
    rest.reverse();
    while let Some(byte) = rest.pop() {
        let digits =
            [rest.last(), rest.get(rest.len().wrapping_sub(2))].map(|d| d.and_then(|d| char::from(*d).to_digit(16)));
        match (byte, digits) {
            (b'%', [Some(high), Some(low)]) => {
                bytes.push((16 * high + low) as u8);
                rest.truncate(rest.len() - 2);
            }
            _ => bytes.push(byte),
        }
    }
    String::from_utf8(bytes).unwrap_or_else(|error| error.into_bytes().into_iter().map(char::from).collect())
}
