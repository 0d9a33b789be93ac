//! .stl, text or binary. Every solid of a text file is a group. Corners at one place become one node.
//!
//! Read by hand, because `stl_io` reads the first solid only, and takes a binary file for text if its header begins
//! with "solid".

use super::cells::Cells;
use super::merge::Table;
use super::text::{point, text};

/// [byte] header with the number of facets, and a facet
const HEADER: usize = 84;
const FACET: usize = 50;

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let counted = bytes.get(80..HEADER).and_then(|word| Some(u32::from_le_bytes(word.try_into().ok()?) as usize));
    let size = counted.and_then(|count| count.checked_mul(FACET)?.checked_add(HEADER));
    // Some programs end the file with a line of their own.
    let beyond =
        size.and_then(|size| bytes.get(size..)).filter(|beyond| beyond.trim_ascii().is_empty() && beyond.len() < FACET);
    let file = File { cells: Cells::of_corners(), known: Table::for_items(bytes.len() / FACET) };
    if let (Some(size), Some(_)) = (size, beyond) {
        return file.binary(&bytes[HEADER..size]);
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
    known: Table,
}

impl File {
    fn corner(&mut self, point: [f64; 3]) -> u64 {
        // Adding zero turns -0 into 0, which is the same place.
        let point = point.map(|x| x + 0.0);
        let key = point.map(f64::to_bits);
        let points = &mut self.cells.points;
        let known = self.known.items(key).find(|number| points[*number as usize].map(f64::to_bits) == key);
        let number = known.unwrap_or_else(|| {
            points.push(point);
            self.known.insert(key, points.len() as u32 - 1);
            points.len() as u32 - 1
        });
        u64::from(number)
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

    /// Words, whatever lines they stand in; the name of a solid ends with its line, or where a facet begins.
    fn solids(mut self, text: &str) -> Result<Cells, String> {
        let (mut solids, mut names, mut corners) = (0, Vec::new(), Vec::new());
        for (number, line) in (1..).zip(text.lines()) {
            let fault = |why: String| format!("line {number}: {why}");
            let mut words = line.split_ascii_whitespace().peekable();
            while let Some(word) = words.next() {
                match word.to_ascii_lowercase().as_str() {
                    begin @ ("solid" | "endsolid") => {
                        let mut name = Vec::new();
                        let next = if begin == "solid" { "facet" } else { "solid" };
                        while let Some(word) = words.next_if(|word| !word.eq_ignore_ascii_case(next)) {
                            name.push(word);
                        }
                        if begin == "solid" {
                            solids += 1;
                            names = vec![if name.is_empty() { format!("solid {solids}") } else { name.join(" ") }];
                        }
                    }
                    "vertex" => {
                        let at = point(&mut words).map_err(fault)?;
                        corners.push(self.corner(at));
                    }
                    "endfacet" => {
                        if corners.len() != 3 {
                            return Err(fault(format!("a facet has three corners, not {}", corners.len())));
                        }
                        self.cells.add_face(&corners);
                        self.cells.name_cells(&names);
                        corners.clear();
                    }
                    // Its normal is not used.
                    "facet" => while words.next_if(|word| !word.eq_ignore_ascii_case("outer")).is_some() {},
                    "outer" => drop(words.next_if(|word| word.eq_ignore_ascii_case("loop"))),
                    "endloop" => {}
                    other => return Err(fault(format!("\"{other}\" is not a word of STL"))),
                }
            }
        }
        if !corners.is_empty() {
            return Err("ends within a facet".to_owned());
        }
        Ok(self.cells)
    }
}
