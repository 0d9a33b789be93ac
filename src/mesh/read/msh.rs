//! Gmsh .msh: versions 2.2 (text) and 4.1 (text and binary), after the Gmsh reference manual, "MSH file format".
//!
//! Physical groups become groups: curves their edges, surfaces their triangles, points their nodes. One without a name
//! is called by its number. In version 2 an element of several groups is listed once for each; in version 4 groups
//! belong to entities, which have elements.
//!
//! Read by hand: `mshio` knows 4.1 only and allocates for any count in the file before it reads the data.

use super::cells::Cells;
use std::collections::HashMap;

/// Numbers of a section, from text or from little-endian binary.
enum Numbers<'a> {
    Text(std::str::SplitAsciiWhitespace<'a>),
    Binary(&'a [u8]),
}

impl Numbers<'_> {
    fn text<T: std::str::FromStr>(words: &mut std::str::SplitAsciiWhitespace<'_>) -> Result<T, String> {
        let word = words.next().ok_or("ends too early")?;
        word.parse().map_err(|_| format!("\"{word}\" is not a number"))
    }

    fn bytes<const N: usize>(rest: &mut &[u8]) -> Result<[u8; N], String> {
        let (head, tail) = rest.split_first_chunk::<N>().ok_or("ends too early")?;
        *rest = tail;
        Ok(*head)
    }

    fn int(&mut self) -> Result<i32, String> {
        match self {
            Self::Text(words) => Self::text(words),
            Self::Binary(rest) => Self::bytes(rest).map(i32::from_le_bytes),
        }
    }

    fn size(&mut self) -> Result<u64, String> {
        match self {
            Self::Text(words) => Self::text(words),
            Self::Binary(rest) => Self::bytes(rest).map(u64::from_le_bytes),
        }
    }

    fn real(&mut self) -> Result<f64, String> {
        match self {
            Self::Text(words) => Self::text(words),
            Self::Binary(rest) => Self::bytes(rest).map(f64::from_le_bytes),
        }
    }
}

/// Cells and the index of every node tag.
#[derive(Default)]
struct Reader {
    cells: Cells,
    index: HashMap<u64, u64>,
    /// names of physical groups by dimension and number
    names: HashMap<(i32, i32), String>,
    /// physical groups of the entities of version 4, by dimension and tag
    entities: HashMap<(i32, i32), Vec<i32>>,
}

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let format = section(bytes, "$MeshFormat").ok_or("has no $MeshFormat section, so it is no Gmsh file")?;
    let line = String::from_utf8_lossy(format.split(|&b| b == b'\n').next().unwrap_or_default()).into_owned();
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let [version, kind, size] = words[..] else {
        return Err(format!("\"{line}\" is not a $MeshFormat line"));
    };
    let binary = kind == "1";
    let mut reader = Reader::default();
    reader.physical_names(bytes)?;
    match (version, binary) {
        ("2.2" | "2.1" | "2", false) => {
            reader.cells.repeats_faces = true;
            reader.nodes_2(&mut numbers(bytes, "$Nodes", false)?)?;
            reader.elements_2(&mut numbers(bytes, "$Elements", false)?)?;
        }
        ("2.2" | "2.1" | "2", true) => {
            return Err("is a binary file of version 2; save it as text (gmsh -save -bin 0) or as version 4.1".into());
        }
        ("4.1", _) => {
            let one = format.get(line.len() + 1..line.len() + 5);
            if binary && (size != "8" || one != Some(&1_i32.to_le_bytes()[..])) {
                return Err("is binary but not little-endian with 8-byte sizes; save it as text".into());
            }
            if section(bytes, "$Entities").is_some() {
                reader.entities_4(&mut numbers(bytes, "$Entities", binary)?)?;
            }
            reader.nodes_4(&mut numbers(bytes, "$Nodes", binary)?)?;
            reader.elements_4(&mut numbers(bytes, "$Elements", binary)?)?;
        }
        _ => return Err(format!("has version {version}; save it as version 4.1 or 2.2")),
    }
    Ok(reader.cells)
}

/// The rest of the file after the title of a section.
fn section<'a>(bytes: &'a [u8], title: &str) -> Option<&'a [u8]> {
    let at = bytes.windows(title.len()).position(|w| w == title.as_bytes())?;
    let rest = &bytes[at + title.len()..];
    let end = rest.iter().position(|&b| b == b'\n')?;
    Some(&rest[end + 1..])
}

fn numbers<'a>(bytes: &'a [u8], title: &str, binary: bool) -> Result<Numbers<'a>, String> {
    let rest = section(bytes, title).ok_or_else(|| format!("has no {title} section"))?;
    if binary {
        return Ok(Numbers::Binary(rest));
    }
    let end = rest.iter().position(|&b| b == b'$').ok_or_else(|| format!("{title} has no end"))?;
    let text = std::str::from_utf8(&rest[..end]).map_err(|_| format!("{title} is not text"))?;
    Ok(Numbers::Text(text.split_ascii_whitespace()))
}

impl Reader {
    fn add_node(&mut self, tag: u64, point: [f64; 3]) -> Result<(), String> {
        if self.index.insert(tag, self.cells.points.len() as u64).is_some() {
            return Err(format!("node {tag} is listed twice"));
        }
        self.cells.points.push(point);
        Ok(())
    }

    fn nodes_2(&mut self, from: &mut Numbers<'_>) -> Result<(), String> {
        for _ in 0..from.size()? {
            let tag = from.size()?;
            let point = [from.real()?, from.real()?, from.real()?];
            self.add_node(tag, point)?;
        }
        Ok(())
    }

    fn elements_2(&mut self, from: &mut Numbers<'_>) -> Result<(), String> {
        for _ in 0..from.size()? {
            let (_, kind, tags) = (from.size()?, from.int()?, from.size()?);
            // The first tag is the physical group, 0 without one.
            let mut physical = 0;
            for i in 0..tags {
                let tag = from.int()?;
                physical = if i == 0 { tag } else { physical };
            }
            let groups = self.named(dimension(kind), &[physical]);
            self.element(kind, &groups, from)?;
        }
        Ok(())
    }

    fn nodes_4(&mut self, from: &mut Numbers<'_>) -> Result<(), String> {
        let blocks = header_4(from)?;
        for _ in 0..blocks {
            let (dimension, _, parametric, count) = (from.int()?, from.int()?, from.int()?, from.size()?);
            // Grows with the data, because the count may be wrong.
            let mut tags = Vec::new();
            for _ in 0..count {
                tags.push(from.size()?);
            }
            for tag in tags {
                let point = [from.real()?, from.real()?, from.real()?];
                let parameters = if parametric == 0 { 0 } else { dimension };
                for _ in 0..parameters {
                    from.real()?;
                }
                self.add_node(tag, point)?;
            }
        }
        Ok(())
    }

    fn elements_4(&mut self, from: &mut Numbers<'_>) -> Result<(), String> {
        let blocks = header_4(from)?;
        for _ in 0..blocks {
            let (dimension, entity, kind, count) = (from.int()?, from.int()?, from.int()?, from.size()?);
            let physical = self.entities.get(&(dimension, entity)).cloned().unwrap_or_default();
            let groups = self.named(dimension, &physical);
            for _ in 0..count {
                from.size()?;
                self.element(kind, &groups, from)?;
            }
        }
        Ok(())
    }

    /// Dimension, number and name in quotes of each physical group, which are text in every format.
    fn physical_names(&mut self, bytes: &[u8]) -> Result<(), String> {
        let Some(rest) = section(bytes, "$PhysicalNames") else { return Ok(()) };
        let end = rest.windows(8).position(|w| w == b"$EndPhys").ok_or("$PhysicalNames has no end")?;
        let text = String::from_utf8_lossy(&rest[..end]);
        for line in text.lines().skip(1).map(str::trim).filter(|line| !line.is_empty()) {
            let mut words = line.splitn(3, char::is_whitespace);
            let mut number = || words.next().and_then(|word| word.parse::<i32>().ok());
            let (dimension, tag) = (number(), number());
            let name = words.next().map(|name| name.trim().trim_matches('"').trim());
            let (Some(dimension), Some(tag), Some(name)) = (dimension, tag, name) else {
                return Err(format!("\"{line}\" in $PhysicalNames is no dimension, number and name"));
            };
            if !name.is_empty() {
                self.names.insert((dimension, tag), name.to_owned());
            }
        }
        Ok(())
    }

    /// The names of physical groups. A negative number means that the entity is turned in the group.
    fn named(&self, dimension: i32, physical: &[i32]) -> Vec<String> {
        let name = |tag: u32| match i32::try_from(tag).ok().and_then(|tag| self.names.get(&(dimension, tag))) {
            Some(name) => name.clone(),
            None => tag.to_string(),
        };
        let mut names: Vec<String> =
            physical.iter().filter(|tag| **tag != 0).map(|tag| name(tag.unsigned_abs())).collect();
        names.sort_unstable();
        names.dedup();
        names
    }

    /// The physical groups of each entity.
    fn entities_4(&mut self, from: &mut Numbers<'_>) -> Result<(), String> {
        let counts = [from.size()?, from.size()?, from.size()?, from.size()?];
        for (dimension, count) in (0..).zip(counts) {
            for _ in 0..count {
                let tag = from.int()?;
                // A point has its place, all else the corners of a box around it.
                for _ in 0..if dimension == 0 { 3 } else { 6 } {
                    from.real()?;
                }
                let mut physical = Vec::new();
                for _ in 0..from.size()? {
                    physical.push(from.int()?);
                }
                if dimension > 0 {
                    for _ in 0..from.size()? {
                        from.int()?;
                    }
                }
                if !physical.is_empty() {
                    self.entities.insert((dimension, tag), physical);
                }
            }
        }
        Ok(())
    }

    /// Nodes of one element of a Gmsh type, which is in these groups.
    fn element(&mut self, kind: i32, groups: &[String], from: &mut Numbers<'_>) -> Result<(), String> {
        let count = match kind {
            1 => 2,
            2 => 3,
            3 => 4,
            15 => 1,
            _ => {
                return Err(format!(
                    "holds elements of Gmsh type {kind}; only lines (1), triangles (2), quads (3) and points (15) of first \
                     order are read. Save the surface mesh alone, with Mesh.ElementOrder = 1"
                ));
            }
        };
        let mut nodes = Vec::new();
        for _ in 0..count {
            let tag = from.size()?;
            nodes.push(
                *self.index.get(&tag).ok_or_else(|| format!("an element names node {tag}, which is not listed"))?,
            );
        }
        match kind {
            1 => self.cells.add_line(&nodes, false),
            15 if groups.is_empty() => self.cells.ignored += 1,
            15 => nodes.iter().for_each(|node| self.cells.name_point(groups, *node)),
            _ => self.cells.add_face(&nodes)?,
        }
        self.cells.name_cells(groups);
        Ok(())
    }
}

/// The dimension of an element of a Gmsh type.
fn dimension(kind: i32) -> i32 {
    match kind {
        15 => 0,
        1 => 1,
        _ => 2,
    }
}

/// Number of entity blocks; the blocks contain all that the totals and tag range after it say.
fn header_4(from: &mut Numbers<'_>) -> Result<u64, String> {
    let blocks = from.size()?;
    for _ in 0..3 {
        from.size()?;
    }
    Ok(blocks)
}
