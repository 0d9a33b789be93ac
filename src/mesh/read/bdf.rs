//! Nastran .bdf, .dat and .nas: GRID, CTRIA3, CTRIAR, CQUAD4, CQUADR, CROD, CBAR, CBEAM, CTUBE, CONROD and PLOTEL, in
//! small, large and free fields. Properties are groups.

use super::cells::Cells;
use super::labels::{Labelled, not_read};
use super::text::text;

pub(super) fn read(bytes: &[u8]) -> Result<Cells, String> {
    let text = text(bytes);
    let mut all = Labelled::default();
    let mut card: Vec<String> = Vec::new();
    let mut begun = 0;
    for (at, line) in text.lines().enumerate() {
        let line = line.split('$').next().unwrap_or_default().trim_end();
        if line.is_empty() {
            continue;
        }
        let (continues, fields) = fields(line);
        if continues {
            card.extend(fields);
        } else {
            add(&card, &mut all).map_err(|why| format!("line {}: {why}", begun + 1))?;
            (card, begun) = (fields, at);
        }
    }
    add(&card, &mut all).map_err(|why| format!("line {}: {why}", begun + 1))?;
    if all.cells.points.is_empty() {
        return Err("has no GRID entry".to_owned());
    }
    all.finish()
}

/// Whether a line continues the entry before it, and its fields, without that of the continuation.
fn fields(line: &str) -> (bool, Vec<String>) {
    let owned = |word: &str| word.trim().to_ascii_uppercase();
    if line.contains(',') {
        let mut words: Vec<String> = line.split(',').map(owned).collect();
        // The tenth field only leads to the next line.
        words.truncate(9);
        let continues = words[0].is_empty() || words[0].starts_with('+') || words[0].starts_with('*');
        return (continues, words.split_off(usize::from(continues)));
    }
    let line: String = line.replace('\t', "        ");
    let characters: Vec<char> = line.chars().collect();
    let first: String = characters.iter().take(8).collect();
    let large = first.contains('*');
    let continues = first.trim().is_empty() || first.starts_with('+') || first.starts_with('*');
    let (width, count) = if large { (16, 4) } else { (8, 8) };
    let columns = characters.get(8..).unwrap_or_default().chunks(width).take(count);
    let mut words: Vec<String> = columns.map(|column| owned(&column.iter().collect::<String>())).collect();
    if !continues {
        words.insert(0, owned(&first).trim_end_matches('*').to_owned());
    }
    words.resize(count + usize::from(!continues), String::new());
    (continues, words)
}

/// A number of Nastran: `1.5-3` is 1.5e-3, and `1.D2` is 100.
fn real(word: &str) -> Result<f64, String> {
    let plain = word.replace('D', "E");
    let sign = plain.char_indices().skip(1).find(|(at, c)| "+-".contains(*c) && !plain[..*at].ends_with('E'));
    let text = sign.map_or(plain.clone(), |(at, _)| format!("{}E{}", &plain[..at], &plain[at..]));
    text.parse().map_err(|_| format!("\"{word}\" is not a number"))
}

fn add(card: &[String], all: &mut Labelled) -> Result<(), String> {
    let Some(name) = card.first().map(|name| name.trim_end_matches('*')) else { return Ok(()) };
    let field = |at: usize| card.get(at).map_or("", String::as_str);
    let label = |at: usize| {
        let word = field(at);
        word.parse::<u64>().map_err(|_| format!("{name}: \"{word}\" in field {} is not a number", at + 1))
    };
    let coordinate = |at: usize| if field(at).is_empty() { Ok(0.0) } else { real(field(at)) };
    match name {
        "GRID" => {
            if !["", "0"].contains(&field(2)) {
                let why = "only nodes in the basic coordinate system are read";
                return Err(format!("GRID {}: {why}, not in system {}", field(1), field(2)));
            }
            all.add_node(label(1)?, [coordinate(3)?, coordinate(4)?, coordinate(5)?])
        }
        "CTRIA3" | "CTRIAR" | "CQUAD4" | "CQUADR" | "CROD" | "CBAR" | "CBEAM" | "CTUBE" | "CONROD" | "PLOTEL" => {
            let (corners, from) = match name {
                "CTRIA3" | "CTRIAR" => (3, 3),
                "CQUAD4" | "CQUADR" => (4, 3),
                "CONROD" | "PLOTEL" => (2, 2),
                _ => (2, 3),
            };
            let nodes = (from..from + corners).map(label).collect::<Result<Vec<u64>, String>>()?;
            // Without a property its number is that of the element.
            let property = if field(2).is_empty() { field(1) } else { field(2) };
            let set = if from == 2 { String::new() } else { format!("property {property}") };
            all.add_element(label(1)?, nodes, &set);
            Ok(())
        }
        other if is_element(other) => Err(not_read(other)),
        _ => Ok(()),
    }
}

/// Elements that would be left out without a word: solids, and shells of second order.
fn is_element(name: &str) -> bool {
    ["CTRIA6", "CQUAD8", "CQUAD", "CTETRA", "CHEXA", "CPENTA", "CPYRAM", "CTRIAX", "CTRIAX6", "CSHEAR"].contains(&name)
}
