//! Wavefront .obj: `v`, `p`, `l` and `f` records. `o`, `g` and `usemtl` name the groups of the records after them:
//! nodes of `p`, edges of `l`, triangles of `f`. Everything else (normals, texture) is ignored.
//!
//! Read by hand because `tobj` renumbers the vertices by use and separates them between objects, which would change the
//! user's node numbers and divide the mesh.

use super::cells::Cells;
use super::statements::LeftOut;
use super::text::text;

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let text = text(bytes);
    let mut file = File::default();
    // A line that ends in a backslash goes on in the next one.
    let mut begun = String::new();
    for (number, line) in (1..).zip(text.lines()) {
        let whole = line.trim_end().strip_suffix('\\');
        if whole.is_some() || !begun.is_empty() {
            begun.push_str(whole.unwrap_or(line));
            begun.push(' ');
        }
        if whole.is_none() {
            let line = if begun.is_empty() { line } else { begun.as_str() };
            file.read_line(number, line).map_err(|reason| format!("line {number}: {reason}"))?;
            begun.clear();
        }
    }
    file.finish()
}

/// Records that mean nothing for a mesh.
///
/// Source: Wavefront, "Object Files (.obj)", appendix B1 of the Advanced Visualizer manual.
const PASSED_OVER: [&str; 30] = [
    "vt",
    "vn",
    "vp",
    "s",
    "mg",
    "mtllib",
    "usemap",
    "maplib",
    "lod",
    "bevel",
    "c_interp",
    "d_interp",
    "shadow_obj",
    "trace_obj",
    "cstype",
    "deg",
    "bmat",
    "step",
    "parm",
    "trim",
    "hole",
    "scrv",
    "sp",
    "end",
    "con",
    "ctech",
    "stech",
    "res",
    "csh",
    "vs",
];

#[derive(Default)]
struct File {
    cells: Cells,
    left: LeftOut,
    /// line and vertex, counted from 1, of references to vertices that were not yet defined
    ahead: Vec<(usize, u64)>,
    /// names that stand at the moment: of the object, the groups and the material
    names: [Vec<String>; 3],
    /// the groups that follow from them, each once, until a name changes
    groups: Option<Vec<String>>,
}

impl File {
    fn read_line(&mut self, number: usize, line: &str) -> Result<(), String> {
        let mut words = line.split('#').next().unwrap_or_default().split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                let mut point = [0.0; 3];
                for c in &mut point {
                    let word = words.next().ok_or("a vertex needs three coordinates")?;
                    *c = word.parse().map_err(|_| format!("\"{word}\" is not a number"))?;
                }
                self.cells.points.push(point);
            }
            Some("l") => {
                let nodes = self.indices(number, words)?;
                self.cells.add_line(&nodes, false);
                self.name_cells();
            }
            Some("p") => {
                let nodes = self.indices(number, words)?;
                let groups = self.groups();
                for node in nodes {
                    self.cells.name_point(&groups, node);
                }
                self.groups = Some(groups);
            }
            Some("g") => {
                (self.groups, self.names[1]) =
                    (None, words.filter(|name| *name != "default").map(str::to_owned).collect())
            }
            Some(of @ ("o" | "usemtl")) => {
                let name = words.collect::<Vec<_>>().join(" ");
                let names = &mut self.names[if of == "o" { 0 } else { 2 }];
                *names = if name.is_empty() { Vec::new() } else { vec![name] };
                self.groups = None;
            }
            Some("f" | "fo") => {
                let nodes = self.indices(number, words)?;
                self.cells.add_face(&nodes);
                self.name_cells();
            }
            Some("curv" | "curv2" | "surf") => {
                self.cells.remark("curves and free-form surfaces were left out: export a mesh")
            }
            Some("call") => return Err("call: its data are in another file; write the mesh into one file".to_owned()),
            Some(other) if !PASSED_OVER.contains(&other) => self.left.add(other, number),
            _ => {}
        }
        Ok(())
    }

    /// The groups that stand at the moment, each once.
    fn groups(&mut self) -> Vec<String> {
        if let Some(groups) = self.groups.take() {
            return groups;
        }
        let mut names = self.names.concat();
        names.sort_unstable();
        names.dedup();
        names
    }

    fn name_cells(&mut self) {
        let groups = self.groups();
        self.cells.name_cells(&groups);
        self.groups = Some(groups);
    }

    /// Vertex numbers of `3`, `3/1`, `3//2` …; they count from 1, or from the latest vertex backwards if negative.
    fn indices<'a>(&mut self, line: usize, words: impl Iterator<Item = &'a str>) -> Result<Vec<u64>, String> {
        let vertices = self.cells.points.len();
        let index = |word: &str| {
            let first = word.split('/').next().unwrap_or_default();
            let number: i64 = first.parse().map_err(|_| format!("\"{word}\" is not a vertex number"))?;
            let index = if number > 0 { number.checked_sub(1) } else { number.checked_add(vertices as i64) };
            match (number, index.and_then(|i| u64::try_from(i).ok())) {
                (0, _) | (_, None) => Err(format!("there is no vertex {number}")),
                (_, Some(index)) => Ok(index),
            }
        };
        let indices: Vec<u64> = words.map(index).collect::<Result<_, String>>()?;
        let ahead = indices.iter().filter(|index| **index >= vertices as u64);
        self.ahead.extend(ahead.map(|index| (line, index + 1)));
        Ok(indices)
    }

    /// Faces may come before their vertices, so vertex numbers can be checked only at the end of the file.
    fn finish(mut self) -> Result<Cells, String> {
        self.cells.notes.extend(self.left.note());
        let vertices = self.cells.points.len();
        match self.ahead.iter().find(|(_, vertex)| *vertex > vertices as u64) {
            Some((line, vertex)) => {
                Err(format!("line {line}: there is no vertex {vertex}; the file has {vertices}, counted from 1"))
            }
            None => Ok(self.cells),
        }
    }
}
