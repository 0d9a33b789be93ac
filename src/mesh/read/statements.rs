//! What the readers of decks do with the statements of their formats: a closed list for each format.
//!
//! A statement that places, moves, joins, includes or makes nodes, elements or sets is read or refused. One that means
//! nothing for a mesh, such as a material, is passed over. A name that is not in the list is passed over with a note.

use std::collections::BTreeMap;

/// What becomes of a statement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// it is carried out
    Read,
    /// it has no meaning for a mesh
    Nothing,
    /// it is left out with a note
    LeftOut,
    /// the file is refused: what to do
    Refused(&'static str),
}

/// What to do about other files.
pub(super) const ONE_FILE: &str = "a file without others is read; write the mesh into one file";
/// What to do about statements that make nodes and elements of others.
pub(super) const WRITE_OUT: &str = "it makes or moves nodes or elements; write the mesh with all of them listed";
/// What to do about constraints.
pub(super) const JOINS: &str =
    "it ties nodes together, which is not carried out; join the nodes (`merge`) and remove it";

/// The statements of a format. Each name may begin or end with a `*` for any text; the longest one that fits counts.
pub(super) struct Statements {
    /// what a statement begins with in messages, such as `*`
    pub mark: &'static str,
    pub list: &'static [(Meaning, &'static [&'static str])],
}

impl Statements {
    /// The meaning of a statement; unknown ones are left out.
    pub(super) fn meaning(&self, name: &str) -> Meaning {
        let fits = |pattern: &str| match (pattern.strip_suffix('*'), pattern.strip_prefix('*')) {
            (Some(start), _) => name.starts_with(start),
            (_, Some(end)) => name.ends_with(end),
            _ => name == pattern,
        };
        let all = self.list.iter().flat_map(|(meaning, names)| names.iter().map(move |name| (*name, *meaning)));
        // An exact name counts before a pattern of the same length.
        let best =
            all.filter(|(pattern, _)| fits(pattern)).max_by_key(|(p, _)| (p.trim_matches('*').len(), *p == name));
        best.map_or(Meaning::LeftOut, |(_, meaning)| meaning)
    }

    /// Refuses or notes a statement that is not carried out; whether it is.
    pub(super) fn admit(&self, name: &str, line: usize, left: &mut LeftOut) -> Result<bool, String> {
        match self.meaning(name) {
            Meaning::Read => Ok(true),
            Meaning::Nothing => Ok(false),
            Meaning::LeftOut => {
                left.add(&format!("{}{name}", self.mark), line);
                Ok(false)
            }
            Meaning::Refused(what) => Err(format!("{}{name}: {what}", self.mark)),
        }
    }
}

/// Statements that were left out: how often each, and the line of the first.
#[derive(Clone, Debug, Default)]
pub(super) struct LeftOut(BTreeMap<String, (usize, usize)>);

/// Most names that a note lists.
const MOST_NAMES: usize = 10;
/// Most characters of a name that are shown.
const LONGEST: usize = 60;
/// Most different names that are counted.
const MOST_COUNTED: usize = 1000;

impl LeftOut {
    pub(super) fn add(&mut self, name: &str, line: usize) {
        let name: String = name.chars().take(LONGEST).collect();
        if let Some((count, _)) = self.0.get_mut(&name) {
            *count += 1;
        } else if self.0.len() < MOST_COUNTED {
            self.0.insert(name, (1, line));
        }
    }

    /// The names with their counts and lines, or nothing.
    pub(super) fn describe(&self) -> Option<String> {
        let one = |(name, (count, line)): (&String, &(usize, usize))| match count {
            1 => format!("{name} (line {line})"),
            _ => format!("{count} {name} (first in line {line})"),
        };
        let mut words: Vec<String> = self.0.iter().take(MOST_NAMES).map(one).collect();
        if self.0.len() > MOST_NAMES {
            words.push("others".to_owned());
        }
        (!words.is_empty()).then(|| words.join(", "))
    }

    /// The note about them.
    pub(super) fn note(&self) -> Option<String> {
        let listed = self.describe()?;
        Some(format!("left out, because they are not known or have no place in a mesh here: {listed}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The longest name that fits counts, and an exact one before a pattern.
    #[test]
    fn the_longest_name_counts() {
        let list = Statements {
            mark: "*",
            list: &[
                (Meaning::Read, &["NODE", "NODE_B*"]),
                (Meaning::Nothing, &["* SECTION", "N*"]),
                (Meaning::Refused("no"), &["NODE_*"]),
            ],
        };
        let expected = [
            ("NODE", Meaning::Read),
            ("NODE_BB", Meaning::Read),
            ("NODE_AB", Meaning::Refused("no")),
            ("NAME", Meaning::Nothing),
            ("SHELL SECTION", Meaning::Nothing),
            ("OTHER", Meaning::LeftOut),
        ];
        for (name, meaning) in expected {
            assert_eq!(list.meaning(name), meaning, "{name}");
        }
    }
}
