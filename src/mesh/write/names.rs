//! Names of groups as a format can hold them.

use crate::Mesh;
use std::collections::BTreeSet;

/// What a format holds as a name.
pub(super) struct NameRule {
    /// whether a name may have this character; others become `_`
    pub allowed: fn(char) -> bool,
    /// whether a name may begin with this character; `group_` goes before others
    pub first: fn(char) -> bool,
    /// names that mean something else in the format; `group_` goes before them
    pub taken: fn(&str) -> bool,
    /// whether upper and lower case are the same
    pub caseless: bool,
}

/// The characters that every format of decks and tables holds.
pub(super) fn plain(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_' || c == '-'
}

/// The groups' names in a file, in the order of the groups, and a sentence for each that differs from its own.
pub(super) struct Names {
    pub written: Vec<String>,
    pub changed: Vec<String>,
}

impl Names {
    /// No two groups get the same name: a number follows the second.
    pub(super) fn new(mesh: &Mesh, rule: &NameRule) -> Self {
        let mut names = Names { written: Vec::new(), changed: Vec::new() };
        let mut used = BTreeSet::new();
        let key = |name: &str| if rule.caseless { name.to_uppercase() } else { name.to_owned() };
        // Names that can stay are not taken by those that are changed.
        let kept: BTreeSet<String> =
            mesh.groups.keys().filter(|name| rule.held(name) == **name).map(|name| key(name)).collect();
        for own in mesh.groups.keys() {
            let held = rule.held(own);
            let free = |name: &String| !used.contains(&key(name)) && (name == own || !kept.contains(&key(name)));
            let numbered = (2..).map(|number| format!("{held}_{number}"));
            let name = std::iter::once(held.clone()).chain(numbered).find(free).unwrap_or_default();
            used.insert(key(&name));
            if name != *own {
                names.changed.push(format!("group \"{own}\" is written as \"{name}\""));
            }
            names.written.push(name);
        }
        names
    }
}

impl NameRule {
    /// A name with what the format does not hold replaced.
    fn held(&self, name: &str) -> String {
        let held: String = name.chars().map(|c| if (self.allowed)(c) { c } else { '_' }).collect();
        let stands = held.chars().next().is_some_and(self.first) && !(self.taken)(&held);
        if stands { held } else { format!("group_{held}") }
    }
}
