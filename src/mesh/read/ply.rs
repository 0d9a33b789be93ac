//! Stanford .ply, text and binary. Whole numbers of faces, edges and vertices, except colours, are groups.
//!
//! Source: G. Turk, "The PLY polygon file format". Read by hand, because `ply-rs-bw` takes neither names that other
//! programs write nor comments that are no UTF-8, and keeps every record as a list of its own.

use super::PLY_NO_MARKS;
use super::cells::{Cells, IGNORED};
use super::marks::Marks;
use super::statements::LeftOut;
use super::text::number;

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut file = File { bytes, at: 0, format: Format::Text };
    let (mut cells, mut left) = (Cells::default(), LeftOut::default());
    for element in &file.header()? {
        match element.name.as_str() {
            "vertex" | "face" | "edge" => {}
            "tristrips" if element.count > 0 => {
                return Err("holds strips of triangles; write it with faces".to_owned());
            }
            "material" | "camera" | "tristrips" => {}
            name => left.add(&format!("element {name}"), element.line),
        }
        let records = file.records(element).map_err(|why| format!("{why}, in the records \"{}\"", element.name))?;
        add(element, &records, &mut cells)?;
    }
    cells.notes.extend(left.note());
    Ok(cells)
}

/// Adds points, faces or lines, with their groups.
fn add(element: &Element, records: &Records, cells: &mut Cells) -> Result<(), String> {
    let column = |name: &str| element.properties.iter().position(|p| p.name == name && p.list.is_none());
    let is_mark = |at: &usize| element.properties[*at].is_mark(&element.name);
    let marks = (0..element.properties.len()).filter(is_mark);
    let marks = Marks::new(marks.map(|at| (element.properties[at].name.clone(), records.column(at))).collect());
    // Neighbours in the file are mostly in the same groups.
    let alike = if marks.is_empty() { Vec::new() } else { marks.first_alike(records.count) };
    let (mut names, mut latest) = (Vec::new(), None);
    let mut names_of = |at: usize| {
        if let Some(first) = alike.get(at).filter(|first| latest != Some(**first)) {
            (names, latest) = (marks.names(*first as usize), Some(*first));
        }
        names.clone()
    };
    match element.name.as_str() {
        "vertex" => {
            let [Some(x), Some(y), Some(z)] = ["x", "y", "z"].map(column) else {
                return Err("has vertices that lack one of x, y and z".to_owned());
            };
            for (at, row) in records.rows().enumerate() {
                cells.points.push([row[x], row[y], row[z]]);
                cells.name_point(&names_of(at), at as u64);
            }
        }
        "face" | "edge" => {
            let ends = ["vertex1", "vertex2"].map(column);
            let mut corners: Vec<u64> = Vec::new();
            if !marks.is_empty() {
                cells.number_cells(0);
            }
            for (at, row) in records.rows().enumerate() {
                let listed = match ends {
                    [Some(a), Some(b)] => &[row[a], row[b]][..],
                    _ => records.corners(at),
                };
                if listed.iter().any(|corner| *corner < 0.0) {
                    return Err(format!("{} {at} has a negative number of a vertex", element.name));
                }
                corners.clear();
                corners.extend(listed.iter().map(|corner| *corner as u64));
                match corners.len() {
                    0 | 1 => cells.remark(IGNORED),
                    2 => cells.add_line(&corners, false),
                    _ => cells.add_face(&corners),
                }
                if !marks.is_empty() {
                    cells.name_cells(&names_of(at));
                }
            }
        }
        _ => {}
    }
    Ok(())
}

/// Records of one kind, as the header tells them.
struct Element {
    name: String,
    count: usize,
    /// where it stands
    line: usize,
    properties: Vec<Property>,
}

struct Property {
    name: String,
    kind: Kind,
    /// the type of the length of a list
    list: Option<Kind>,
}

impl Property {
    /// Whether it marks a part.
    fn is_mark(&self, element: &str) -> bool {
        let others: &[&str] = match element {
            "vertex" => &["x", "y", "z"],
            "edge" => &["vertex1", "vertex2"],
            _ => &[],
        };
        let name = self.name.as_str();
        self.list.is_none() && self.kind.whole && !others.contains(&name) && !PLY_NO_MARKS.contains(&name)
    }

    /// Whether it lists the corners of a face.
    fn is_corners(&self) -> bool {
        self.list.is_some() && ["vertex_indices", "vertex_index"].contains(&self.name.as_str())
    }
}

/// A type of numbers.
#[derive(Clone, Copy)]
struct Kind {
    /// [byte]
    size: usize,
    whole: bool,
    signed: bool,
}

fn kind(word: &str) -> Result<Kind, String> {
    let of = |size, whole, signed| Ok(Kind { size, whole, signed });
    match word {
        "char" | "int8" => of(1, true, true),
        "uchar" | "uint8" => of(1, true, false),
        "short" | "int16" => of(2, true, true),
        "ushort" | "uint16" => of(2, true, false),
        "int" | "int32" => of(4, true, true),
        "uint" | "uint32" => of(4, true, false),
        "float" | "float32" => of(4, false, true),
        "double" | "float64" => of(8, false, true),
        other => Err(format!("\"{other}\" is no type of PLY")),
    }
}

/// The records of an element: the numbers that are no lists, row by row, and the corners of faces.
#[derive(Default)]
struct Records {
    width: usize,
    count: usize,
    numbers: Vec<f64>,
    corners: Vec<f64>,
    /// where the corners of each record end
    ends: Vec<usize>,
}

impl Records {
    fn rows(&self) -> impl Iterator<Item = &[f64]> {
        (0..self.count).map(|at| &self.numbers[at * self.width..(at + 1) * self.width])
    }

    fn column(&self, at: usize) -> Vec<i64> {
        self.rows().map(|row| row[at] as i64).collect()
    }

    fn corners(&self, at: usize) -> &[f64] {
        let begin = if at == 0 { 0 } else { self.ends[at - 1] };
        &self.corners[begin..self.ends[at]]
    }
}

#[derive(Clone, Copy)]
enum Format {
    Text,
    Little,
    Big,
}

impl Format {
    /// As the header calls it.
    fn of(word: &str) -> Result<Self, String> {
        match word {
            "ascii" => Ok(Format::Text),
            "binary_little_endian" => Ok(Format::Little),
            "binary_big_endian" => Ok(Format::Big),
            other => Err(format!("\"{other}\" is no format of PLY")),
        }
    }
}

struct File<'a> {
    bytes: &'a [u8],
    at: usize,
    format: Format,
}

impl File<'_> {
    fn header(&mut self) -> Result<Vec<Element>, String> {
        let mut elements: Vec<Element> = Vec::new();
        for at in 1.. {
            let line = self.line().ok_or("is not a PLY file, or is cut off: its header has no end")?;
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            let done = match words[..] {
                ["ply"] if at == 1 => Ok(()),
                _ if at == 1 => return Err("is not a PLY file: its first line is not \"ply\"".to_owned()),
                ["end_header"] => return Ok(elements),
                ["format", format, _] => Format::of(format).map(|format| self.format = format),
                [] | ["comment" | "obj_info", ..] => Ok(()),
                ["element", name, count] => number(Some(count)).map(|count| {
                    elements.push(Element { name: name.to_owned(), count, line: at, properties: Vec::new() });
                }),
                ["property", ref own @ ..] => property(own).and_then(|property| {
                    let element = elements.last_mut().ok_or("a property of no element")?;
                    element.properties.push(property);
                    Ok(())
                }),
                _ => Err("no line of a header".to_owned()),
            };
            done.map_err(|why| format!("is not a PLY file that can be read: line {at}: {why}"))?;
        }
        Ok(elements)
    }

    /// The next line, with its bytes as Latin-1.
    fn line(&mut self) -> Option<String> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|byte| [b'\n', b'\r'].contains(byte)).unwrap_or(rest.len());
        self.at += length + if rest.get(length..length + 2) == Some(b"\r\n") { 2 } else { 1 };
        Some(rest[..length].iter().map(|byte| char::from(*byte)).collect())
    }

    /// The records of an element; there are none without properties.
    fn records(&mut self, element: &Element) -> Result<Records, String> {
        let properties = &element.properties;
        let mut records = Records { width: properties.len(), ..Records::default() };
        // Each takes a byte at least.
        if properties.is_empty() || element.count > self.bytes.len().saturating_sub(self.at) {
            return if properties.is_empty() { Ok(records) } else { Err(cut_off()) };
        }
        records.count = element.count;
        let with_corners = properties.iter().any(Property::is_corners);
        for _ in 0..element.count {
            for property in properties {
                match property.list {
                    None => {
                        let number = self.number(property.kind)?;
                        records.numbers.push(number);
                    }
                    Some(length) => {
                        records.numbers.push(0.0);
                        for _ in 0..self.number(length)? as usize {
                            let number = self.number(property.kind)?;
                            if property.is_corners() {
                                records.corners.push(number);
                            }
                        }
                    }
                }
            }
            if with_corners {
                records.ends.push(records.corners.len());
            }
        }
        if !with_corners {
            records.ends = vec![0; element.count];
        }
        Ok(records)
    }

    fn number(&mut self, kind: Kind) -> Result<f64, String> {
        let rest = self.bytes.get(self.at..).ok_or_else(cut_off)?;
        if let Format::Text = self.format {
            let begin = rest.iter().position(|byte| !byte.is_ascii_whitespace()).ok_or_else(cut_off)?;
            let length = rest[begin..].iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len() - begin);
            self.at += begin + length;
            let word = std::str::from_utf8(&rest[begin..begin + length]).map_err(|_| "has a number that is no text")?;
            return number(Some(word));
        }
        let (number, size) = match kind.size {
            1 => (self.binary(rest, |b| if kind.signed { i8::from_le_bytes(b).into() } else { b[0].into() }), 1),
            2 if kind.signed => (self.binary(rest, |b| i16::from_le_bytes(b).into()), 2),
            2 => (self.binary(rest, |b| u16::from_le_bytes(b).into()), 2),
            4 if !kind.whole => (self.binary(rest, |b| f32::from_le_bytes(b).into()), 4),
            4 if kind.signed => (self.binary(rest, |b| i32::from_le_bytes(b).into()), 4),
            4 => (self.binary(rest, |b| u32::from_le_bytes(b).into()), 4),
            _ => (self.binary(rest, f64::from_le_bytes), 8),
        };
        self.at += size;
        number.ok_or_else(cut_off)
    }

    /// A number of `N` bytes.
    fn binary<const N: usize>(&self, rest: &[u8], number: impl Fn([u8; N]) -> f64) -> Option<f64> {
        let mut word = *rest.first_chunk()?;
        if let Format::Big = self.format {
            word.reverse();
        }
        Some(number(word))
    }
}

fn cut_off() -> String {
    "is cut off: it has fewer records than it says".to_owned()
}

fn property(words: &[&str]) -> Result<Property, String> {
    match *words {
        ["list", length, of, name] => {
            Ok(Property { name: name.to_owned(), kind: kind(of)?, list: Some(kind(length)?) })
        }
        [of, name] => Ok(Property { name: name.to_owned(), kind: kind(of)?, list: None }),
        _ => Err("a property has a type and a name".to_owned()),
    }
}
