//! .stl, text or binary. Every solid of a text file is a group. Corners at one place become one node.
//!
//! Read by hand, because `stl_io` reads the first solid only, and takes a binary file for text if its header begins
//! with "solid".

use super::cells::Cells;
use super::text::{point, text};
use std::collections::HashMap;

/// [byte] header with the number of facets, and a facet
const HEADER: usize = 84;
const FACET: usize = 50;

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let counted = bytes.get(80..HEADER).and_then(|word| Some(u32::from_le_bytes(word.try_into().ok()?) as usize));
    let fits = counted.and_then(|count| count.checked_mul(FACET)?.checked_add(HEADER)) == Some(bytes.len());
    let file = File { cells: Cells::of_corners(), known: HashMap::new() };
    if fits {
        return file.binary(&bytes[HEADER..]);
    }
    let text = text(bytes);
    if text.trim_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case("solid")) {
        return file.solids(&text);
    }
    match counted {
        Some(count) => Err(format!(
            "is not an STL file, or is damaged: it says {count} facets, and {} bytes are not 84 and 50 for each",
            bytes.len()
        )),
        None => Err("is not an STL file: it has neither \"solid\" at its start nor a header of 84 bytes".to_owned()),
    }
}

struct File {
    cells: Cells,
    /// points by their coordinates
    known: HashMap<[u64; 3], u64>,
}

impl File {
    fn corner(&mut self, point: [f64; 3]) -> u64 {
        // Adding zero turns -0 into 0, which is the same place.
        let point = point.map(|x| x + 0.0);
        *self.known.entry(point.map(f64::to_bits)).or_insert_with(|| {
            self.cells.points.push(point);
            self.cells.points.len() as u64 - 1
        })
    }

    fn binary(mut self, facets: &[u8]) -> Result<Cells, String> {
        for facet in facets.as_chunks::<FACET>().0 {
            let number = |at: usize| f64::from(f32::from_le_bytes([0, 1, 2, 3].map(|i| facet[at + i])));
            // A normal comes first, and is not used.
            let corners = [12, 24, 36].map(|at| self.corner([number(at), number(at + 4), number(at + 8)]));
            self.cells.add_face(&corners);
        }
        Ok(self.cells)
    }

    fn solids(mut self, text: &str) -> Result<Cells, String> {
        let (mut solids, mut names, mut corners) = (0, Vec::new(), Vec::new());
        for (number, line) in (1..).zip(text.lines()) {
            let line = line.trim();
            let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
            match word.to_ascii_lowercase().as_str() {
                "solid" => {
                    solids += 1;
                    let name = rest.trim();
                    names = vec![if name.is_empty() { format!("solid {solids}") } else { name.to_owned() }];
                }
                "vertex" => {
                    let at =
                        point(&mut rest.split_ascii_whitespace()).map_err(|why| format!("line {number}: {why}"))?;
                    corners.push(self.corner(at));
                }
                "endfacet" => {
                    if corners.len() != 3 {
                        return Err(format!("line {number}: a facet has three corners, not {}", corners.len()));
                    }
                    self.cells.add_face(&corners);
                    self.cells.name_cells(&names);
                    corners.clear();
                }
                "facet" | "outer" | "endloop" | "endsolid" | "" => {}
                other => return Err(format!("line {number}: \"{other}\" is not a word of STL")),
            }
        }
        if !corners.is_empty() {
            return Err("ends within a facet".to_owned());
        }
        Ok(self.cells)
    }
}
