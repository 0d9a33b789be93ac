//! LS-DYNA .k: *NODE, *ELEMENT_SHELL, _BEAM, _DISCRETE and _SEATBELT, *PART and sets of nodes and shells. Parts and
//! sets are groups, by their titles, else by their numbers.

use super::cells::{Cells, IGNORED};
use super::labels::{Labelled, not_read};
use super::text::{number, text};
use std::collections::BTreeMap;

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let text = text(bytes);
    let mut file = File::default();
    for (at, line) in (1..).zip(text.lines()) {
        file.read_line(line).map_err(|why| format!("line {at}: {why}"))?;
    }
    if file.all.cells.points.is_empty() {
        return Err("has no *NODE section".to_owned());
    }
    file.finish()
}

#[derive(Default)]
struct File {
    all: Labelled,
    section: String,
    /// number of the data line within its keyword
    card: usize,
    /// title that stands before its number
    title: String,
    set: String,
    parts: BTreeMap<u64, String>,
    elements: Vec<(u64, u64, Vec<u64>)>,
}

/// The fields of a line: between commas, else columns of these widths, else words.
fn fields<'a>(line: &'a str, widths: &[usize]) -> Vec<&'a str> {
    if line.contains(',') {
        return line.split(',').map(str::trim).collect();
    }
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    if !line.is_ascii() || words.len() >= widths.len() {
        return words;
    }
    // Numbers that fill their columns stand without a blank between them.
    let mut from = 0;
    let columns = widths.iter().map_while(|width| {
        let field = line.get(from..(from + width).min(line.len()))?;
        from += width;
        Some(field.trim())
    });
    columns.filter(|field| !field.is_empty()).collect()
}

impl File {
    fn read_line(&mut self, line: &str) -> Result<(), String> {
        if line.trim().is_empty() || line.starts_with('$') {
            return Ok(());
        }
        if let Some(keyword) = line.strip_prefix('*') {
            self.section = keyword.trim().trim_end_matches(['%', '+', '-']).trim().to_ascii_uppercase();
            self.card = 0;
            self.title.clear();
            return self.known();
        }
        self.card += 1;
        match self.section.as_str() {
            "NODE" => {
                let words = fields(line, &[8, 16, 16, 16]);
                let mut words = words.into_iter();
                let label = number(words.next())?;
                let mut coordinate =
                    || words.next().filter(|w| !w.is_empty()).map_or(Ok(0.0), |word| number(Some(word)));
                let point = [coordinate()?, coordinate()?, coordinate()?];
                self.all.add_node(label, point)
            }
            "ELEMENT_SHELL" => self.element(line, 4),
            "ELEMENT_BEAM" | "ELEMENT_DISCRETE" | "ELEMENT_SEATBELT" => self.element(line, 2),
            "ELEMENT_MASS" => {
                self.all.cells.remark(IGNORED);
                Ok(())
            }
            "PART" => self.part(line),
            section if section.starts_with("SET_NODE_LIST") || section.starts_with("SET_SHELL_LIST") => self.set(line),
            _ => Ok(()),
        }
    }

    /// Refuses elements that would be left out without a word.
    fn known(&self) -> Result<(), String> {
        let kind = self.section.strip_prefix("ELEMENT_");
        match kind.filter(|kind| !["SHELL", "BEAM", "DISCRETE", "SEATBELT", "MASS"].contains(kind)) {
            Some(_) => Err(not_read(&format!("*{}", self.section))),
            None => Ok(()),
        }
    }

    fn element(&mut self, line: &str, corners: usize) -> Result<(), String> {
        let words = fields(line, &[8; 6][..corners + 2]);
        let numbers = words.iter().map(|word| number(Some(word))).take(corners + 2);
        let numbers: Vec<u64> = numbers.collect::<Result<_, String>>()?;
        let (Some([label, part]), true) = (numbers.first_chunk().copied(), numbers.len() >= 4) else {
            return Err("an element has too few numbers".to_owned());
        };
        // A triangle is a quad whose last corner is given again, or 0.
        let nodes = numbers[2..].iter().copied().filter(|node| *node != 0).collect();
        self.elements.push((label, part, nodes));
        Ok(())
    }

    /// A title, then a line that begins with the number.
    fn part(&mut self, line: &str) -> Result<(), String> {
        if self.card % 2 == 1 {
            line.trim().clone_into(&mut self.title);
        } else {
            let label = number(fields(line, &[10]).first().copied())?;
            self.parts.insert(label, std::mem::take(&mut self.title));
        }
        Ok(())
    }

    /// With _TITLE a title; then the number, then members.
    fn set(&mut self, line: &str) -> Result<(), String> {
        let titled = self.section.ends_with("_TITLE");
        let nodes = self.section.starts_with("SET_NODE");
        if titled && self.card == 1 {
            line.trim().clone_into(&mut self.title);
            return Ok(());
        }
        if self.card == 1 + usize::from(titled) {
            let label: u64 = number(fields(line, &[10]).first().copied())?;
            let kind = if nodes { "node" } else { "shell" };
            self.set = if self.title.is_empty() { format!("{kind} set {label}") } else { self.title.clone() };
            return Ok(());
        }
        let members = fields(line, &[10; 8]).into_iter().map(|word| number::<u64>(Some(word)));
        let members: Vec<u64> = members.collect::<Result<_, String>>()?;
        let sets = if nodes { &mut self.all.node_sets } else { &mut self.all.element_sets };
        sets.entry(self.set.clone()).or_default().extend(members.into_iter().filter(|label| *label != 0));
        Ok(())
    }

    fn finish(mut self) -> Result<Cells, String> {
        for (label, part, nodes) in std::mem::take(&mut self.elements) {
            let title = self.parts.get(&part).filter(|title| !title.is_empty());
            let name = title.cloned().unwrap_or_else(|| format!("part {part}"));
            self.all.add_element(label, nodes, &name);
        }
        self.all.finish()
    }
}
