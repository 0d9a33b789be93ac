//! The unit of length that a file names in a comment at its beginning.

/// [byte] Where a comment may name the unit.
const HEAD: usize = 8192;
/// How comments begin.
const COMMENTS: [&str; 6] = ["#", "$", "**", "//", "comment", ";"];
/// The keyword of LS-DYNA before the unit.
const KEYWORD: &str = "*control_units";

/// Names of a unit, its usual one first, and its length [m].
const UNITS: [(&[&str], f64); 6] = [
    (&["millimetres", "mm", "millimetre", "millimeter", "millimeters"], 0.001),
    (&["centimetres", "cm", "centimetre", "centimeter", "centimeters"], 0.01),
    (&["inches", "inch", "in"], 0.0254),
    (&["feet", "foot", "ft"], 0.3048),
    (&["metres", "m", "metre", "meter", "meters"], 1.0),
    (&["kilometres", "km", "kilometre", "kilometer", "kilometers"], 1000.0),
];

/// The unit of length after the word "unit" or "units" in a comment, with its length [m].
pub(super) fn of_comments(bytes: &[u8]) -> Option<(&'static str, f64)> {
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(HEAD)]).to_lowercase();
    let mut lines = head.lines().map(str::trim_start);
    while let Some(line) = lines.next() {
        if line.starts_with(KEYWORD) {
            return lines.find(|line| !line.starts_with('$')).and_then(unit_in);
        }
        let comment = COMMENTS.iter().any(|mark| line.starts_with(mark));
        let after = line.split_once("unit").map(|(_, after)| after.trim_start_matches('s'));
        if let Some(unit) = after.filter(|_| comment).and_then(unit_in) {
            return Some(unit);
        }
    }
    None
}

/// The first unit of length in a text; "in" is one at its end only, as the word for something else before it.
fn unit_in(text: &str) -> Option<(&'static str, f64)> {
    let words: Vec<&str> = text.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).collect();
    let known = words.iter().enumerate().filter(|(i, word)| **word != "in" || i + 1 == words.len());
    known.into_iter().find_map(|(_, word)| {
        let (names, length) = UNITS.iter().find(|(names, _)| names.contains(word))?;
        Some((*names.first()?, *length))
    })
}

#[cfg(test)]
mod tests {
    use super::of_comments;

    #[test]
    fn comments_name_units() {
        for (text, unit) in [
            ("# File units = inches\nv 0 0 0\n", Some(0.0254)),
            ("v 0 0 0\n# Units in mm\n", Some(0.001)),
            ("# units: in\n", Some(0.0254)),
            ("$ UNITS: t, cm, s\n", Some(0.01)),
            ("ply\nformat ascii 1.0\ncomment unit: feet\n", Some(0.3048)),
            ("*KEYWORD\n*CONTROL_UNITS\n$ length\n        mm       sec\n", Some(0.001)),
            ("** Units: m kg s\n", Some(1.0)),
            ("# units are given in the manual\n", None),
            ("# made by a program, m = 3\n", None),
            ("g unit mm\n", None),
            ("", None),
        ] {
            assert_eq!(of_comments(text.as_bytes()).map(|(_, length)| length), unit, "{text}");
        }
    }
}
