//! Gmsh .msh: versions 1 (text), 2 and 4 (text and binary), after the Gmsh reference manual, "MSH file format".
//!
//! Physical groups become groups: curves their edges, surfaces their triangles, points their nodes. One without a name
//! is called by its number. In version 2 an element of several groups is listed once for each; in version 4 groups
//! belong to entities, which have elements.
//!
//! Read by hand: `mshio` knows 4.1 only and allocates for any count in the file before it reads the data.

mod sections;

use super::cells::{Cells, IGNORED};
use sections::{Numbers, Sections};
use std::collections::HashMap;

/// Name of the section of nodes that tell their places on curves and surfaces too.
const PARAMETRIC: &str = "ParametricNodes";

/// The point of each node tag.
#[derive(Default)]
struct Index {
    /// by tag, [`Index::NONE`] where there is none
    near: Vec<u32>,
    /// of tags far beyond the number of nodes
    far: HashMap<u64, u32>,
}

impl Index {
    const NONE: u32 = u32::MAX;
    /// Tags up to this many times the number of nodes listed so far, and some more, have a place of their own.
    const DENSE: u64 = 4;
    const ANY: u64 = 1 << 16;

    fn get(&self, tag: u64) -> Option<u64> {
        let near = usize::try_from(tag).ok().and_then(|tag| self.near.get(tag)).filter(|point| **point != Self::NONE);
        near.or_else(|| if self.far.is_empty() { None } else { self.far.get(&tag) }).copied().map(u64::from)
    }

    /// Notes the next point; false if the tag is known already.
    fn insert(&mut self, tag: u64, point: u32) -> bool {
        if self.get(tag).is_some() {
            return false;
        }
        if tag > Self::DENSE * u64::from(point) + Self::ANY {
            self.far.insert(tag, point);
            return true;
        }
        let at = tag as usize;
        if at >= self.near.len() {
            self.near.resize(at + 1, Self::NONE);
        }
        self.near[at] = point;
        true
    }
}

/// Cells and the index of every node tag.
#[derive(Default)]
struct Reader {
    cells: Cells,
    index: Index,
    /// names of physical groups by dimension and number
    names: HashMap<(i32, i32), String>,
    /// physical groups of the entities of version 4, by dimension and tag
    entities: HashMap<(i32, i32), Vec<i32>>,
}

/// How a file of version 4 is written.
#[derive(Clone, Copy)]
struct Version4 {
    binary: bool,
    /// 4.0, where tags have 4 bytes, points of the entities have a box, and a node's place stands beside its tag
    first: bool,
}

impl Version4 {
    /// A label of a node or an element.
    fn tag(self, from: &mut Numbers<'_>) -> Result<u64, String> {
        if self.first { from.tag() } else { from.size() }
    }

    /// Number of entity blocks; the blocks contain all that the totals and tag range after it say.
    fn blocks(self, from: &mut Numbers<'_>) -> Result<u64, String> {
        let blocks = from.size()?;
        for _ in 0..if self.first { 1 } else { 3 } {
            from.size()?;
        }
        Ok(blocks)
    }

    /// Dimension and tag of the entity of a block; version 4.0 turns them for nodes and elements.
    fn entity(self, from: &mut Numbers<'_>) -> Result<(i32, i32), String> {
        let (one, two) = (from.int()?, from.int()?);
        Ok(if self.first { (two, one) } else { (one, two) })
    }
}

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let sections = Sections::of(bytes)?;
    let mut reader = Reader::default();
    if let Some(nodes) = sections.get("NOD") {
        reader.cells.repeats_faces = true;
        reader.nodes_2(nodes, false, false)?;
        reader.elements_1(sections.need("ELM")?)?;
        return Ok(reader.cells);
    }
    let format = sections.get("MeshFormat").ok_or("has no $MeshFormat section, so it is no Gmsh file")?;
    let line = String::from_utf8_lossy(format.split(|&b| b == b'\n').next().unwrap_or_default()).into_owned();
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let [version, kind, size] = words[..] else {
        return Err(format!("\"{line}\" is not a $MeshFormat line"));
    };
    let binary = kind == "1";
    let one = format.get(line.len() + 1..line.len() + 5);
    if binary && (size != "8" || one != Some(&1_i32.to_le_bytes()[..])) {
        return Err("is binary but not little-endian with 8-byte sizes; save it as text".into());
    }
    reader.physical_names(&sections)?;
    match version {
        "2.2" | "2.1" | "2" => {
            reader.cells.repeats_faces = true;
            match sections.get(PARAMETRIC) {
                Some(nodes) => reader.nodes_2(nodes, binary, true)?,
                None => reader.nodes_2(sections.need("Nodes")?, binary, false)?,
            }
            reader.elements_2(sections.need("Elements")?, binary)?;
        }
        "4.1" | "4" | "4.0" => {
            let version = Version4 { binary, first: version != "4.1" };
            if let Some(body) = sections.get("Entities") {
                reader.entities_4(body, version)?;
            }
            let nodes = sections.get(PARAMETRIC).map_or_else(|| sections.need("Nodes"), Ok)?;
            reader.nodes_4(nodes, version)?;
            reader.elements_4(sections.need("Elements")?, version)?;
        }
        _ => return Err(format!("has version {version}; save it as version 4.1 or 2.2")),
    }
    Ok(reader.cells)
}

impl Reader {
    fn add_node(&mut self, tag: u64, point: [f64; 3]) -> Result<(), String> {
        if !self.index.insert(tag, self.cells.points.len() as u32) {
            return Err(format!("node {tag} is listed twice"));
        }
        self.cells.points.push(point);
        Ok(())
    }

    /// Number and place; parametric ones also tell dimension and tag of their entity, and their parameters on it.
    fn nodes_2(&mut self, body: &[u8], binary: bool, parametric: bool) -> Result<(), String> {
        let (count, mut from) = Numbers::counted(body, binary)?;
        for _ in 0..count {
            let tag = from.tag()?;
            let point = [from.real()?, from.real()?, from.real()?];
            self.add_node(tag, point)?;
            if parametric {
                let (dimension, _) = (from.int()?, from.int()?);
                for _ in 0..if matches!(dimension, 1 | 2) { dimension } else { 0 } {
                    from.real()?;
                }
            }
        }
        from.at_end("Nodes")
    }

    /// Number, type, physical and elementary group, number of nodes, nodes.
    fn elements_1(&mut self, body: &[u8]) -> Result<(), String> {
        let (count, mut from) = Numbers::counted(body, false)?;
        for _ in 0..count {
            let (_, kind, physical, _, _) = (from.tag()?, from.int()?, from.int()?, from.int()?, from.int()?);
            let groups = self.named(dimension(kind), &[physical]);
            self.element(kind, &groups, || from.tag())?;
        }
        from.at_end("ELM")
    }

    fn elements_2(&mut self, body: &[u8], binary: bool) -> Result<(), String> {
        let (count, mut from) = Numbers::counted(body, binary)?;
        let mut done = 0;
        // Neighbours in the file are mostly in the same group.
        let (mut groups, mut latest) = (Vec::new(), None);
        while done < count {
            // In text each element tells its type; in binary a block of them.
            let first = if binary { 0 } else { from.tag()? };
            let kind = from.int()?;
            let block = if binary { from.tag()? } else { 1 };
            let tags = from.tag()?;
            if block == 0 {
                return Err("has an empty block of elements".into());
            }
            for _ in 0..block {
                let _number = if binary { from.tag()? } else { first };
                // The first tag is the physical group, 0 without one.
                let mut physical = 0;
                for i in 0..tags {
                    let tag = from.int()?;
                    physical = if i == 0 { tag } else { physical };
                }
                if latest != Some((kind, physical)) {
                    (groups, latest) = (self.named(dimension(kind), &[physical]), Some((kind, physical)));
                }
                self.element(kind, &groups, || from.tag())?;
                done += 1;
            }
        }
        from.at_end("Elements")
    }

    fn nodes_4(&mut self, body: &[u8], version: Version4) -> Result<(), String> {
        let from = &mut Numbers::of(body, version.binary)?;
        for _ in 0..version.blocks(from)? {
            let (dimension, _) = version.entity(from)?;
            let (parametric, count) = (from.int()?, from.size()?);
            let parameters = if parametric == 0 { 0 } else { dimension };
            let node = |reader: &mut Self, from: &mut Numbers<'_>, tag: u64| {
                let point = [from.real()?, from.real()?, from.real()?];
                for _ in 0..parameters {
                    from.real()?;
                }
                reader.add_node(tag, point)
            };
            if version.first {
                for _ in 0..count {
                    let tag = version.tag(from)?;
                    node(self, from, tag)?;
                }
                continue;
            }
            // Grows with the data, because the count may be wrong.
            let mut tags = Vec::new();
            for _ in 0..count {
                tags.push(version.tag(from)?);
            }
            for tag in tags {
                node(self, from, tag)?;
            }
        }
        from.at_end("Nodes")
    }

    fn elements_4(&mut self, body: &[u8], version: Version4) -> Result<(), String> {
        let from = &mut Numbers::of(body, version.binary)?;
        for _ in 0..version.blocks(from)? {
            let (dimension, entity) = version.entity(from)?;
            let (kind, count) = (from.int()?, from.size()?);
            let physical = self.entities.get(&(dimension, entity)).cloned().unwrap_or_default();
            let groups = self.named(dimension, &physical);
            for _ in 0..count {
                version.tag(from)?;
                self.element(kind, &groups, || version.tag(from))?;
            }
        }
        from.at_end("Elements")
    }

    /// Dimension, number and name in quotes of each physical group, which are text in every format.
    fn physical_names(&mut self, sections: &Sections<'_>) -> Result<(), String> {
        let Some(body) = sections.get("PhysicalNames") else { return Ok(()) };
        let text = super::text::text(body);
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
    fn entities_4(&mut self, body: &[u8], version: Version4) -> Result<(), String> {
        let from = &mut Numbers::of(body, version.binary)?;
        let counts = [from.size()?, from.size()?, from.size()?, from.size()?];
        for (dimension, count) in (0..).zip(counts) {
            for _ in 0..count {
                let tag = from.int()?;
                // A point has its place, all else the corners of a box around it.
                for _ in 0..if dimension == 0 && !version.first { 3 } else { 6 } {
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
        from.at_end("Entities")
    }

    /// Nodes of one element of a Gmsh type, which is in these groups.
    fn element(
        &mut self,
        kind: i32,
        groups: &[String],
        mut tag: impl FnMut() -> Result<u64, String>,
    ) -> Result<(), String> {
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
        let mut nodes = [0; 4];
        for node in &mut nodes[..count] {
            let tag = tag()?;
            let known = self.index.get(tag);
            *node = known.ok_or_else(|| format!("an element names node {tag}, which is not listed"))?;
        }
        match kind {
            1 => self.cells.add_line(&nodes[..2], false),
            15 if groups.is_empty() => self.cells.remark(IGNORED),
            15 => self.cells.name_point(groups, nodes[0]),
            _ => self.cells.add_face(&nodes[..count]),
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
