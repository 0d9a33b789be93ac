//! Abaqus and CalculiX .inp: nodes, elements, node and element sets of one part.

use super::cells::{Cells, IGNORED};
use super::labels::{Labelled, not_read};
use super::text::{number, text};

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let text = text(bytes);
    let mut file = File::default();
    for (at, line) in (1..).zip(text.lines()) {
        file.read_line(line.trim()).map_err(|why| format!("line {at}: {why}"))?;
    }
    if file.all.cells.points.is_empty() {
        return Err("has no *NODE section".to_owned());
    }
    file.all.finish()
}

#[derive(Default)]
struct File {
    all: Labelled,
    section: Section,
    parts: usize,
    /// members of sets that ranges and other sets brought
    copied: u64,
}

/// What the data lines belong to.
#[derive(Default)]
enum Section {
    #[default]
    Other,
    Nodes {
        set: String,
    },
    /// lines or faces of so many nodes, and the numbers of an element that goes on in the next line
    Elements {
        count: usize,
        set: String,
        begun: Vec<u64>,
    },
    /// elements such as point masses
    Ignored,
    Set {
        nodes: bool,
        name: String,
        generate: bool,
    },
}

/// Number of nodes of an element of a type; 1 for those that are no part of a mesh here, `None` if it is not read.
fn nodes_of(kind: &str) -> Option<usize> {
    let starts = |words: &[&str]| words.iter().any(|word| kind.starts_with(word));
    if starts(&["MASS", "ROTARYI", "SPRING1", "DASHPOT1"]) {
        return Some(1);
    }
    if starts(&[
        "T2D2", "T3D2", "B21", "B31", "B23", "B33", "SPRINGA", "DASHPOTA", "CONN3D2", "CONN2D2", "R2D2", "RB3D2",
    ]) {
        return Some(2);
    }
    let surfaces = ["SFM3D", "STRI", "M3D", "CPS", "CPE", "R3D", "DS", "S"];
    let rest = surfaces.iter().find_map(|word| kind.strip_prefix(word))?;
    let digits = rest.split(|c: char| !c.is_ascii_digit()).next()?;
    match digits {
        "3" => Some(3),
        "4" => Some(4),
        _ => None,
    }
}

/// Refuses more members of sets than a file of any size needs.
fn check_copied(count: u64) -> Result<(), String> {
    let most = super::MOST_LABELS;
    if count > most { Err(format!("the sets have {count} members, more than {most}")) } else { Ok(()) }
}

impl File {
    fn read_line(&mut self, line: &str) -> Result<(), String> {
        if line.is_empty() || line.starts_with("**") {
            return Ok(());
        }
        match line.strip_prefix('*') {
            Some(keyword) => self.keyword(keyword),
            None => self.data(line),
        }
    }

    fn keyword(&mut self, line: &str) -> Result<(), String> {
        let mut parts = line.split(',').map(str::trim);
        let word = parts.next().unwrap_or_default().to_ascii_uppercase();
        let options: Vec<(String, String)> = parts
            .map(|option| option.split_once('=').unwrap_or((option, "")))
            .map(|(key, value)| (key.trim().to_ascii_uppercase(), value.trim().trim_matches('"').to_owned()))
            .collect();
        let option = |key: &str| options.iter().find(|(name, _)| name == key).map(|(_, value)| value.clone());
        self.section = match word.as_str() {
            "NODE" => Section::Nodes { set: option("NSET").unwrap_or_default() },
            "ELEMENT" => {
                let kind = option("TYPE").unwrap_or_default().to_ascii_uppercase();
                match nodes_of(&kind).ok_or_else(|| not_read(&format!("of type {kind}")))? {
                    1 => Section::Ignored,
                    count => Section::Elements { count, set: option("ELSET").unwrap_or_default(), begun: Vec::new() },
                }
            }
            "NSET" | "ELSET" => {
                let name = option(&word).ok_or_else(|| format!("a set without {word}="))?;
                Section::Set { nodes: word == "NSET", name, generate: option("GENERATE").is_some() }
            }
            "PART" | "INSTANCE" | "INCLUDE" => {
                self.parts += usize::from(word == "PART");
                if word == "INCLUDE" || self.parts > 1 {
                    return Err(format!(
                        "*{word}: a file of one part without other files is read; write the mesh flat"
                    ));
                }
                Section::Other
            }
            _ => Section::Other,
        };
        Ok(())
    }

    fn data(&mut self, line: &str) -> Result<(), String> {
        let words = || line.split(',').map(str::trim).filter(|word| !word.is_empty());
        match &mut self.section {
            Section::Other => {}
            Section::Ignored => self.all.cells.remark(IGNORED),
            Section::Nodes { set } => {
                let mut words = words();
                let label = number(words.next())?;
                // Coordinates that are left out are 0.
                let mut coordinate = || words.next().map_or(Ok(0.0), |word| number(Some(word)));
                let point = [coordinate()?, coordinate()?, coordinate()?];
                self.all.add_node(label, point)?;
                if !set.is_empty() {
                    self.all.node_sets.entry(set.clone()).or_default().push(label);
                }
            }
            Section::Elements { count, set, begun } => {
                for word in words() {
                    begun.push(number(Some(word))?);
                    // A beam may name a further node for its direction.
                    if begun.len() == *count + 1 {
                        self.all.add_element(begun[0], begun[1..].to_vec(), set);
                        begun.clear();
                        break;
                    }
                }
            }
            Section::Set { nodes, name, generate } => {
                let sets = if *nodes { &mut self.all.node_sets } else { &mut self.all.element_sets };
                let numbers: Result<Vec<u64>, String> = words().map(|word| number(Some(word))).collect();
                let labels = match (numbers, *generate) {
                    (Ok(numbers), false) => numbers,
                    (Ok(numbers), true) => {
                        let &[first, last] = numbers.first_chunk().ok_or("GENERATE needs a first and a last number")?;
                        let step = numbers.get(2).copied().unwrap_or(1).max(1);
                        let count = last.saturating_sub(first) / step;
                        self.copied = self.copied.saturating_add(count);
                        check_copied(self.copied)?;
                        (0..=count).map(|i| first + i * step).collect()
                    }
                    // Sets of sets, which may hold themselves.
                    (Err(_), _) => {
                        let others: Vec<&Vec<u64>> = words().filter_map(|other| sets.get(other)).collect();
                        self.copied = others.iter().fold(self.copied, |sum, set| sum.saturating_add(set.len() as u64));
                        check_copied(self.copied)?;
                        others.into_iter().flatten().copied().collect()
                    }
                };
                sets.entry(name.clone()).or_default().extend(labels);
            }
        }
        Ok(())
    }
}
