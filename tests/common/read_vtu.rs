//! A reader of appended .vtu files, written from the format's description.

use std::collections::HashMap;
use std::io::Read;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// What a file holds.
pub struct Vtu {
    pub points: usize,
    pub cells: usize,
    pub time: f64,
    order: Vec<String>,
    arrays: HashMap<String, Vec<u8>>,
    /// of what the arrays are
    kinds: HashMap<String, String>,
}

/// Value of an attribute in a tag.
pub fn attribute(tag: &str, key: &str) -> Option<String> {
    let (_, rest) = tag.split_once(&format!(" {key}=\""))?;
    Some(rest.split_once('"')?.0.to_owned())
}

impl Vtu {
    pub fn names(&self) -> &[String] {
        &self.order
    }
    pub fn bytes(&self, name: &str) -> &[u8] {
        &self.arrays[name]
    }
    pub fn floats(&self, name: &str) -> Vec<f64> {
        let bytes = self.bytes(name);
        match self.kinds[name].as_str() {
            "Float32" => bytes.as_chunks().0.iter().map(|chunk| f64::from(f32::from_le_bytes(*chunk))).collect(),
            "Float64" => bytes.as_chunks().0.iter().map(|chunk| f64::from_le_bytes(*chunk)).collect(),
            kind => panic!("{name} is {kind}"),
        }
    }
    pub fn integers(&self, name: &str) -> Vec<i64> {
        let bytes = self.bytes(name);
        match self.kinds[name].as_str() {
            "UInt16" => bytes.as_chunks().0.iter().map(|chunk| i64::from(u16::from_le_bytes(*chunk))).collect(),
            "Int32" => bytes.as_chunks().0.iter().map(|chunk| i64::from(i32::from_le_bytes(*chunk))).collect(),
            "Int64" => bytes.as_chunks().0.iter().map(|chunk| i64::from_le_bytes(*chunk)).collect(),
            kind => panic!("{name} is {kind}"),
        }
    }
}

/// Reads a whole file; fails with a panic on anything unexpected, as tests do.
pub fn parse(file: &[u8]) -> Vtu {
    let mark = b"<AppendedData encoding=\"";
    let split = file.windows(mark.len()).position(|window| window == mark).expect("an appended section");
    let head = std::str::from_utf8(&file[..split]).expect("text before the appended section");
    let body_start = split + file[split..].iter().position(|&b| b == b'_').expect("a mark") + 1;
    let tail = b"\n</AppendedData>\n</VTKFile>\n";
    assert!(file.ends_with(tail));
    let body = &file[body_start..file.len() - tail.len()];
    let base64 = file[split + mark.len()..].starts_with(b"base64\"");
    assert!(
        head.contains("type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\"")
    );
    let zlib = head.contains("compressor=\"vtkZLibDataCompressor\"");

    let piece = head.lines().find(|line| line.starts_with("<Piece")).expect("a piece");
    let number = |key| attribute(piece, key).expect("a count").parse().expect("a number");
    let mut vtu = Vtu {
        points: number("NumberOfPoints"),
        cells: number("NumberOfCells"),
        time: f64::NAN,
        order: vec![],
        arrays: HashMap::new(),
        kinds: HashMap::new(),
    };
    for line in head.lines().filter(|line| line.starts_with("<DataArray")) {
        let name = attribute(line, "Name").expect("a name");
        if name == "TimeValue" {
            let text = line.split(['>', '<']).nth(2).expect("a value");
            vtu.time = text.parse().expect("a time");
        } else if attribute(line, "format").is_some_and(|format| format == "ascii") {
            let text = line.split(['>', '<']).nth(2).expect("values");
            let number = |word: &str| word.parse::<i32>().expect("a whole number").to_le_bytes();
            vtu.kinds.insert(name.clone(), "Int32".to_owned());
            vtu.arrays.insert(name.clone(), text.split(' ').flat_map(number).collect());
        } else {
            let offset: usize = attribute(line, "offset").expect("an offset").parse().expect("a number");
            vtu.kinds.insert(name.clone(), attribute(line, "type").expect("a type"));
            vtu.arrays.insert(name.clone(), decode(&body[offset..], base64, zlib));
        }
        vtu.order.push(name);
    }
    vtu
}

/// `n` bytes from the start of a section, and what follows them.
fn take(section: &[u8], n: usize, base64: bool) -> (Vec<u8>, &[u8]) {
    if !base64 {
        return (section[..n].to_vec(), &section[n..]);
    }
    let text = n.div_ceil(3) * 4;
    let mut bytes = STANDARD.decode(&section[..text]).expect("base64");
    bytes.truncate(n);
    (bytes, &section[text..])
}

fn words(bytes: &[u8]) -> Vec<usize> {
    bytes.as_chunks().0.iter().map(|chunk| u64::from_le_bytes(*chunk) as usize).collect()
}

/// The first word of a section: eight bytes, which are within the first twelve characters of base64.
fn first_word(section: &[u8], base64: bool) -> usize {
    if base64 { words(&STANDARD.decode(&section[..12]).expect("base64")[..8])[0] } else { words(&section[..8])[0] }
}

fn decode(section: &[u8], base64: bool, zlib: bool) -> Vec<u8> {
    if !zlib {
        return take(section, 8 + first_word(section, base64), base64).0.split_off(8);
    }
    let first = words(&take(section, 24, base64).0);
    let (blocks, size, partial) = (first[0], first[1], first[2]);
    let (head, packed) = take(section, 8 * (3 + blocks), base64);
    let lengths = &words(&head)[3..];
    let (packed, _) = take(packed, lengths.iter().sum(), base64);
    let (mut out, mut at) = (Vec::new(), 0);
    for &length in lengths {
        let before = out.len();
        flate2::read::ZlibDecoder::new(&packed[at..at + length]).read_to_end(&mut out).expect("zlib");
        let last = at + length == packed.len() && partial != 0;
        assert_eq!(out.len() - before, if last { partial } else { size });
        at += length;
    }
    out
}
