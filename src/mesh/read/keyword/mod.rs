//! LS-DYNA .k: *NODE, *ELEMENT_SHELL, _BEAM, _DISCRETE and _SEATBELT, *PART and sets of nodes, elements and parts.
//! Parts and sets are groups, by their titles, else by their numbers.

mod cards;
mod statements;

use super::cells::{Cells, IGNORED};
use super::labels::{KIND, Labelled, Labels, not_read, set_of};
use super::statements::LeftOut;
use super::text::{label, real, text};
use cards::{BEAMS, Element, Members, Of, SEATBELTS, SHELLS, Section, section};
use statements::{KEYWORDS, OF_SETS};
use std::collections::BTreeMap;

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let text = text(bytes);
    let mut file = File::default();
    for (at, line) in (1..).zip(text.lines()) {
        if line.starts_with('$') {
            continue;
        }
        let Some(keyword) = line.strip_prefix('*') else {
            file.card(line).map_err(|why| format!("line {at}: {why}"))?;
            continue;
        };
        // Nothing counts after the end.
        if keyword.trim().eq_ignore_ascii_case("END") {
            break;
        }
        file.keyword(keyword, at).map_err(|why| format!("line {at}: {why}"))?;
    }
    if file.all.cells.points.is_empty() {
        return Err("has no *NODE section".to_owned());
    }
    file.finish()
}

#[derive(Default)]
struct File {
    all: Labelled,
    section: Section,
    widths: Widths,
    /// those of the keyword, which may differ
    keyword_widths: Widths,
    /// number of the card within its keyword
    card: usize,
    /// title that stands before its number
    title: String,
    parts: BTreeMap<u64, String>,
    /// sets of parts by name
    part_sets: BTreeMap<String, Labels>,
    elements: Vec<(u64, u64, Vec<u64>)>,
    left: LeftOut,
}

/// Widths of fields in columns.
#[derive(Clone, Copy, Default)]
enum Widths {
    #[default]
    Standard,
    /// whole numbers of ten columns
    Ten,
    /// twenty columns for all
    Long,
}

impl Widths {
    fn whole(self, standard: usize) -> usize {
        match self {
            Widths::Standard => standard,
            Widths::Ten => 10,
            Widths::Long => 20,
        }
    }

    fn real(self) -> usize {
        if matches!(self, Widths::Long) { 20 } else { 16 }
    }
}

/// The fields of a card: between commas, else in columns; if a column holds two words, words.
fn fields<'a>(line: &'a str, widths: &[usize]) -> Vec<&'a str> {
    if line.contains(',') {
        return line.split(',').map(str::trim).collect();
    }
    let mut from = 0;
    let columns = widths.iter().map_while(|width| {
        let field = line.get(from..(from + width).min(line.len()))?;
        from += width;
        Some(field.trim())
    });
    let columns: Vec<&str> = columns.collect();
    let two = |field: &&str| field.contains(char::is_whitespace);
    if !line.is_ascii() || columns.iter().any(two) { line.split_whitespace().collect() } else { columns }
}

/// A whole number; an empty field is 0.
fn whole(word: Option<&&str>) -> Result<u64, String> {
    let word = word.copied().unwrap_or_default();
    let number = if word.is_empty() { 0 } else { label(word)? };
    if number < KIND { Ok(number) } else { Err(format!("{number} is too large for a number of a node or an element")) }
}

impl File {
    fn keyword(&mut self, line: &str, at: usize) -> Result<(), String> {
        let line = line.trim().to_ascii_uppercase();
        let (word, options) = line.split_at(line.find(char::is_whitespace).unwrap_or(line.len()));
        let name = word.trim_end_matches(['%', '+', '-']);
        let marks = [&word[name.len()..], options.trim()].concat();
        (self.card, self.section) = (0, Section::Other);
        self.title.clear();
        if !KEYWORDS.admit(name, at, &mut self.left)? {
            return Ok(());
        }
        if name.starts_with("KEYWORD") {
            let options: String = options.chars().filter(|c| !c.is_whitespace()).collect();
            if options.contains("LONG=Y") || options.contains("LONG=K") {
                self.widths = Widths::Long;
            } else if options.contains("I10=Y") {
                self.widths = Widths::Ten;
            }
            self.section = Section::Keyword;
        }
        self.keyword_widths = match marks.chars().next() {
            Some('+') => Widths::Long,
            Some('%') => Widths::Ten,
            Some('-') => Widths::Standard,
            _ => self.widths,
        };
        self.section = section(name).ok_or_else(|| match name.starts_with("SET_") {
            true => format!("*{name}: {OF_SETS}"),
            false => not_read(&format!("*{name}")),
        })?;
        Ok(())
    }

    fn card(&mut self, line: &str) -> Result<(), String> {
        self.card += 1;
        let blank = line.trim().is_empty();
        let widths = self.keyword_widths;
        match &self.section {
            Section::Other | Section::Keyword => {}
            Section::Mass if !blank => self.all.cells.remark(IGNORED),
            Section::Node if !blank => {
                let words = fields(line, &[widths.whole(8), widths.real(), widths.real(), widths.real()]);
                let node = whole(words.first())?;
                let coordinate = |at: usize| match words.get(at) {
                    Some(word) if !word.is_empty() => real(word),
                    _ => Ok(0.0),
                };
                let point = [coordinate(1)?, coordinate(2)?, coordinate(3)?];
                self.all.add_node(node, point)?;
            }
            Section::Element(kind) if (self.card - 1).is_multiple_of(kind.cards) && !blank => {
                let kind = kind.clone();
                self.element(line, &kind)?;
            }
            Section::Part(cards) => {
                let at = if *cards > 0 { (self.card - 1) % cards } else { self.card - 1 };
                self.part(line, at)?;
            }
            Section::Set { .. } if !blank => self.set(line)?,
            _ => {}
        }
        Ok(())
    }

    fn element(&mut self, line: &str, kind: &Element) -> Result<(), String> {
        let words = fields(line, &[self.keyword_widths.whole(8); 10][..kind.nodes + 2]);
        let [own, part] = [whole(words.first())?, whole(words.get(1))?];
        let nodes = (2..2 + kind.nodes).map(|at| whole(words.get(at))).collect::<Result<Vec<u64>, String>>()?;
        if let Some(further) = nodes.get(kind.most..).and_then(|rest| rest.iter().find(|node| **node != 0)) {
            return Err(not_read(&format!("with more than {} nodes (element {own} names node {further})", kind.most)));
        }
        if kind.kind == SEATBELTS {
            let [eight, real] = [self.keyword_widths.whole(8), self.keyword_widths.real()];
            let words = fields(line, &[eight, eight, eight, eight, eight, real, eight, eight]);
            if whole(words.get(6))? != 0 {
                return Err(not_read(&format!("of seat belts with four nodes (element {own})")));
            }
        }
        // A triangle is a quad whose last corner is given again, or 0; a spring to the ground has one node.
        let nodes: Vec<u64> = nodes.into_iter().filter(|node| *node != 0).collect();
        match nodes.len() {
            0 => return Err(format!("element {own} has no nodes")),
            1 => self.all.cells.remark(IGNORED),
            _ => self.elements.push((own + kind.kind, part, nodes)),
        }
        Ok(())
    }

    /// A title, then a card that begins with the number.
    fn part(&mut self, line: &str, card: usize) -> Result<(), String> {
        match card {
            0 => line.trim().clone_into(&mut self.title),
            1 => {
                let part = whole(fields(line, &[self.keyword_widths.whole(10)]).first())?;
                self.parts.insert(part, std::mem::take(&mut self.title));
            }
            _ => {}
        }
        Ok(())
    }

    /// With _TITLE a title; then the number, then members.
    fn set(&mut self, line: &str) -> Result<(), String> {
        let width = self.keyword_widths.whole(10);
        let Section::Set { of, members, titled, name } = &mut self.section else { return Ok(()) };
        if *titled {
            *titled = false;
            line.trim().clone_into(&mut self.title);
            self.card = 0;
            return Ok(());
        }
        let words = fields(line, &[width; 8]);
        if self.card == 1 {
            let own = whole(words.first())?;
            let kind = match of {
                Of::Nodes => "node",
                Of::Elements(SHELLS) => "shell",
                Of::Elements(BEAMS) => "beam",
                Of::Elements(_) => "discrete",
                Of::Parts => "part",
            };
            *name = if self.title.is_empty() { format!("{kind} set {own}") } else { self.title.clone() };
            return Ok(());
        }
        let (sets, shift) = match of {
            Of::Nodes => (&mut self.all.node_sets, 0),
            Of::Elements(kind) => (&mut self.all.element_sets, *kind),
            Of::Parts => (&mut self.part_sets, 0),
        };
        let set = set_of(sets, name);
        let (size, words) = match members {
            Members::List => (1, &words[..]),
            Members::Column => (1, words.get(..1).unwrap_or_default()),
            Members::Ranges => (2, &words[..]),
            Members::Steps => (3, &words[..]),
            Members::General => {
                let wanted = match of {
                    Of::Nodes => "NODE",
                    Of::Elements(_) => "ELEM",
                    Of::Parts => "PART",
                };
                let option = words.first().copied().unwrap_or_default().to_ascii_uppercase();
                match option.as_str() {
                    "ALL" => {
                        set.push_range([shift, shift + KIND - 1, 1]);
                        return Ok(());
                    }
                    other if other == wanted => (1, words.get(1..).unwrap_or_default()),
                    other => {
                        return Err(format!("a set by {other} is not read; write the set with its members listed"));
                    }
                }
            }
        };
        let numbers = words.iter().map(|word| whole(Some(word))).collect::<Result<Vec<u64>, String>>()?;
        for group in numbers.chunks(size).filter(|group| group[0] != 0) {
            match *group {
                [one] => set.push(one + shift),
                [first, last] => set.push_range([first + shift, last + shift, 1]),
                [first, last, step] => set.push_range([first + shift, last + shift, step]),
                _ => {}
            }
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Cells, String> {
        let mut numbers: Vec<(u64, u32)> = self.elements.iter().map(|(_, part, _)| (*part, 0)).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let (mut sets_of, mut visits) = (BTreeMap::<u64, Vec<&String>>::new(), 0);
        for (name, parts) in &self.part_sets {
            for (part, _) in parts.among(&numbers, &mut visits)? {
                sets_of.entry(*part).or_default().push(name);
            }
        }
        for (own, part, nodes) in std::mem::take(&mut self.elements) {
            let title = self.parts.get(&part).filter(|title| !title.is_empty());
            let name = title.cloned().unwrap_or_else(|| format!("part {part}"));
            self.all.add_element(own, nodes, &name);
            for set in sets_of.get(&part).into_iter().flatten() {
                set_of(&mut self.all.element_sets, set).push(own);
            }
        }
        self.all.finish(&self.left)
    }
}
