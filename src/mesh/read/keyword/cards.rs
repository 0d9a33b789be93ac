//! What the cards of LS-DYNA's keywords hold.

use crate::read::labels::KIND;

/// What the cards belong to.
#[derive(Default, Clone)]
pub(super) enum Section {
    #[default]
    Other,
    Keyword,
    Node,
    Element(Element),
    /// masses of nodes
    Mass,
    /// cards a part; 0 for one part alone, whose number of cards is not known
    Part(usize),
    Set {
        of: Of,
        members: Members,
        titled: bool,
        name: String,
    },
}

#[derive(Clone)]
pub(super) struct Element {
    /// columns of the first card that name nodes, after those of the element and the part
    pub nodes: usize,
    /// how many of them may be nodes here; the others must be empty
    pub most: usize,
    /// cards an element
    pub cards: usize,
    /// added to its label: elements of another kind count for themselves
    pub kind: u64,
}

/// What a set holds.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Of {
    Nodes,
    /// elements of a kind
    Elements(u64),
    Parts,
}

/// How the members of a set are given.
#[derive(Clone, Copy)]
pub(super) enum Members {
    List,
    /// first and last numbers
    Ranges,
    /// first, last, and what is between two
    Steps,
    /// one a card, with numbers of its own after it
    Column,
    /// a word that says what follows
    General,
}

pub(super) const SHELLS: u64 = 0;
pub(super) const BEAMS: u64 = KIND;
pub(super) const DISCRETE: u64 = 2 * KIND;
pub(super) const SEATBELTS: u64 = 3 * KIND;

/// What the cards of a keyword are; `None` if one of its options is not known.
pub(super) fn section(name: &str) -> Option<Section> {
    let after = |start: &str| name.strip_prefix(start).filter(|rest| rest.is_empty() || rest.starts_with('_'));
    // Each option brings a card.
    let cards = |text: &str, known: &[&str]| {
        let words = text.split('_').filter(|word| !word.is_empty());
        words.into_iter().try_fold(1, |cards, word| known.contains(&word).then_some(cards + 1))
    };
    let element = |nodes, most, cards, kind| Some(Section::Element(Element { nodes, most, cards, kind }));
    match name {
        "NODE" => return Some(Section::Node),
        "PART" => return Some(Section::Part(2)),
        "PART_CONTACT" | "PART_PRINT" => return Some(Section::Part(3)),
        _ => {}
    }
    if name.starts_with("PART_") {
        return Some(Section::Part(0));
    }
    if name.starts_with("ELEMENT_MASS") || name.starts_with("ELEMENT_INERTIA") {
        return Some(Section::Mass);
    }
    if name.starts_with("KEYWORD") {
        return Some(Section::Keyword);
    }
    if let Some(rest) = after("ELEMENT_SHELL") {
        // Thickness, angle and material system stand in one card.
        let in_one = ["THICKNESS", "BETA", "MCID"];
        let others: String =
            rest.split('_').filter(|word| !in_one.contains(word)).map(|word| format!("_{word}")).collect();
        let first = usize::from(in_one.iter().any(|word| rest.contains(word)));
        return element(8, 4, first + cards(&others, &["OFFSET", "DOF"])?, SHELLS);
    }
    if let Some(rest) = after("ELEMENT_BEAM") {
        let known = ["THICKNESS", "SECTION", "PID", "OFFSET", "ORIENTATION", "SCALAR", "SCALR", "WARPAGE"];
        return element(2, 2, cards(rest, &known)?, BEAMS);
    }
    if let Some(rest) = after("ELEMENT_DISCRETE") {
        return element(2, 2, 1 + usize::from(!rest.is_empty()), DISCRETE);
    }
    if name == "ELEMENT_SEATBELT" {
        return element(2, 2, 1, SEATBELTS);
    }
    let (of, rest) = [
        ("SET_NODE", Of::Nodes),
        ("SET_SHELL", Of::Elements(SHELLS)),
        ("SET_BEAM", Of::Elements(BEAMS)),
        ("SET_DISCRETE", Of::Elements(DISCRETE)),
        ("SET_PART", Of::Parts),
    ]
    .into_iter()
    .find_map(|(start, of)| Some((of, after(start)?)))?;
    let words: Vec<&str> = rest.split('_').filter(|word| !matches!(*word, "" | "TITLE" | "COLLECT" | "LIST")).collect();
    let members = match words[..] {
        [] => Members::List,
        ["GENERATE"] => Members::Ranges,
        ["GENERATE", "INCREMENT"] => Members::Steps,
        ["COLUMN"] => Members::Column,
        ["GENERAL"] => Members::General,
        _ => return None,
    };
    Some(Section::Set { of, members, titled: rest.ends_with("_TITLE"), name: String::new() })
}
