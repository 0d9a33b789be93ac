//! Nastran .bdf, .dat and .nas: GRID, and elements that are lines, triangles and quads, in small, large and free
//! fields. Properties are groups.

mod statements;

use super::cells::{Cells, IGNORED};
use super::labels::{Labelled, not_read};
use super::statements::LeftOut;
use super::text::{real, text};
use statements::ENTRIES;

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let text = text(bytes);
    let mut file = File::default();
    let (mut card, mut begun): (Vec<String>, usize) = (Vec::new(), 0);
    for (at, line) in bulk(&text)? {
        let line = line.split('$').next().unwrap_or_default().trim_end();
        if line.is_empty() {
            continue;
        }
        let (continues, fields) = fields(line);
        if continues {
            card.extend(fields);
            continue;
        }
        file.add(&card, begun).map_err(|why| format!("line {begun}: {why}"))?;
        (card, begun) = (fields, at);
        if card.first().is_some_and(|name| name == "ENDDATA") {
            card.clear();
            break;
        }
    }
    file.add(&card, begun).map_err(|why| format!("line {begun}: {why}"))?;
    if file.all.cells.points.is_empty() {
        return Err("has no GRID entry".to_owned());
    }
    file.all.finish(&file.left)
}

#[derive(Default)]
struct File {
    all: Labelled,
    left: LeftOut,
}

/// The lines of the bulk data with their numbers: what follows `BEGIN BULK`, or all lines without it.
fn bulk(text: &str) -> Result<impl Iterator<Item = (usize, &str)>, String> {
    let lines = (1..).zip(text.lines());
    let mut begin = 0;
    for (at, line) in lines.clone() {
        let mut words = line.split(|c: char| c.is_whitespace() || c == '=').filter(|word| !word.is_empty());
        let first = words.next().unwrap_or_default().to_ascii_uppercase();
        match first.as_str() {
            "BEGIN" if words.any(|word| word.to_ascii_uppercase().starts_with("SUPER")) => {
                return Err(format!("line {at}: superelements are not read; write the mesh as one residual structure"));
            }
            "BEGIN" if begin == 0 => begin = at,
            "INCLUDE" => {
                return Err(format!("line {at}: INCLUDE: {}", super::statements::ONE_FILE));
            }
            "ENDDATA" => break,
            _ => {}
        }
    }
    Ok(lines.skip(begin))
}

/// Whether a line continues the entry before it, and its fields, without that of the continuation.
fn fields(line: &str) -> (bool, Vec<String>) {
    let owned = |word: &str| word.trim().to_ascii_uppercase();
    if line.contains(',') {
        let mut words: Vec<String> = line.split(',').map(owned).collect();
        // The tenth field only leads to the next line.
        words.truncate(9);
        let continues = words[0].is_empty() || continued(&words[0]);
        return (continues, words.split_off(usize::from(continues)));
    }
    let characters: Vec<char> = without_tabs(line);
    let first: String = characters.iter().take(8).collect();
    let large = first.contains('*');
    let continues = first.trim().is_empty() || continued(&first);
    let (width, count) = if large { (16, 4) } else { (8, 8) };
    let columns = characters.get(8..).unwrap_or_default().chunks(width).take(count);
    let mut words: Vec<String> = columns.map(|column| owned(&column.iter().collect::<String>())).collect();
    if !continues {
        words.insert(0, owned(&first).trim_end_matches('*').to_owned());
    }
    words.resize(count + usize::from(!continues), String::new());
    (continues, words)
}

/// Whether a first field is that of a continuation; `*(` begins a replication.
fn continued(word: &str) -> bool {
    word.starts_with('+') || word.starts_with('*') && !word.starts_with("*(")
}

/// The characters of a line in which each tab leads to the next column of eight.
fn without_tabs(line: &str) -> Vec<char> {
    let mut all = Vec::with_capacity(line.len());
    for c in line.chars() {
        if c == '\t' { all.resize(all.len() / 8 * 8 + 8, ' ') } else { all.push(c) }
    }
    all
}

impl File {
    fn add(&mut self, card: &[String], line: usize) -> Result<(), String> {
        let Some(name) = card.first().map(|name| name.trim_end_matches('*')) else { return Ok(()) };
        let field = |at: usize| card.get(at).map_or("", String::as_str);
        if let Some(word) = card.iter().skip(1).find(|word| word.starts_with('=') || word.starts_with("*(")) {
            return Err(format!("{name}: \"{word}\" replicates an entry; write the mesh with all entries listed"));
        }
        let label = |at: usize| {
            let word = field(at);
            word.parse::<u64>().map_err(|_| format!("{name}: \"{word}\" in field {} is not a number", at + 1))
        };
        let coordinate = |at: usize| if field(at).is_empty() { Ok(0.0) } else { real(field(at)) };
        let basic = |at: usize| ["", "0"].contains(&field(at));
        if let Some((count, from)) = nodes_of(name) {
            // A spring or damper with one end at the ground.
            if count == 2 && from.into_iter().any(&basic) {
                self.all.cells.remark(IGNORED);
                return Ok(());
            }
            let nodes = match count {
                2 => from.into_iter().map(label).collect::<Result<Vec<u64>, String>>()?,
                _ => (from[0]..from[0] + count).map(label).collect::<Result<Vec<u64>, String>>()?,
            };
            // Without a property its number is that of the element.
            let property = match name {
                "CONROD" | "PLOTEL" | "CELAS2" | "CDAMP2" => "",
                _ if field(2).is_empty() => field(1),
                _ => field(2),
            };
            let set = if property.is_empty() { String::new() } else { format!("property {property}") };
            self.all.add_element(label(1)?, nodes, &set);
            return Ok(());
        }
        if !ENTRIES
            .admit(name, line, &mut self.left)
            .map_err(|why| if name.starts_with('C') && why.contains("first order") { not_read(name) } else { why })?
        {
            return Ok(());
        }
        match name {
            "GRID" if basic(2) => self.all.add_node(label(1)?, [coordinate(3)?, coordinate(4)?, coordinate(5)?]),
            "GRID" => {
                let why = "only nodes in the basic coordinate system are read";
                Err(format!("GRID {}: {why}, not in system {}", field(1), field(2)))
            }
            "GRDSET" if basic(2) => Ok(()),
            "GRDSET" => Err(format!(
                "GRDSET puts nodes into system {}; only nodes in the basic coordinate system are read",
                field(2)
            )),
            _ => {
                self.all.cells.remark(IGNORED);
                Ok(())
            }
        }
    }
}

/// Number of nodes of an element that is read, and the fields that name them: two of a line, or the first of a face.
fn nodes_of(name: &str) -> Option<(usize, [usize; 2])> {
    match name {
        "CTRIA3" | "CTRIAR" => Some((3, [3, 0])),
        "CQUAD4" | "CQUADR" => Some((4, [3, 0])),
        "CROD" | "CBAR" | "CBEAM" | "CTUBE" | "CBUSH" | "CBUSH1D" | "CVISC" | "CGAP" => Some((2, [3, 4])),
        "CELAS1" | "CDAMP1" | "CELAS2" | "CDAMP2" => Some((2, [3, 5])),
        "CONROD" | "PLOTEL" => Some((2, [2, 3])),
        _ => None,
    }
}
