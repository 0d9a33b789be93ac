//! Names of users made safe for file systems and csv.

/// Longest stem made of a name; leaves room for `_000000.vtu` within the 255 bytes common file systems allow.
const LONGEST_STEM: usize = 100;

/// Names that Windows reserves for devices, with or without an extension.
const DEVICES: [&str; 4] = ["con", "prn", "aux", "nul"];

/// The file stem of a case's name.
///
/// ASCII letters, digits, `-`, `_` and `.` stay; every other character becomes one `_`; dots and spaces at either end
/// are removed; a name of more than 100 characters is cut; an empty one becomes `case`; a device name of Windows
/// (`con`, `nul`, `com1` …) gets a leading `_`. The same name always gives the same stem.
pub fn file_stem(name: &str) -> String {
    let keep = |c: char| if c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.') { c } else { '_' };
    let ends = |c: char| c == '.' || c.is_whitespace();
    let mut stem: String = name.trim_matches(ends).chars().map(keep).take(LONGEST_STEM).collect();
    stem.truncate(stem.trim_end_matches('.').len());
    if stem.is_empty() {
        return "case".to_owned();
    }
    if is_device(&stem) {
        stem.insert(0, '_');
    }
    stem
}

fn is_device(stem: &str) -> bool {
    let first = stem.split('.').next().unwrap_or(stem).to_ascii_lowercase();
    let port = first.strip_prefix("com").or_else(|| first.strip_prefix("lpt"));
    DEVICES.contains(&first.as_str()) || port.is_some_and(|n| matches!(n.as_bytes(), [b'1'..=b'9']))
}

/// Text for a csv field, quoted by RFC 4180 (section 2, rules 5 to 7) where necessary.
pub fn csv_field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) || text.trim() != text {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No stem leaves its folder, hides itself, or is empty.
    #[test]
    fn stems_are_safe() {
        let cases = [
            ("", "case"),
            ("cloth-k1000", "cloth-k1000"),
            ("../gust 50 m/s", "_gust_50_m_s"),
            ("...", "case"),
            ("a/b\\c", "a_b_c"),
            ("../../etc/passwd", "_.._etc_passwd"),
            (".hidden", "hidden"),
            ("größe <50>", "gr__e__50_"),
            ("NUL", "_NUL"),
            ("com1.x", "_com1.x"),
            ("com10", "com10"),
            ("a\0b\nc", "a_b_c"),
        ];
        for (name, stem) in cases {
            assert_eq!(file_stem(name), stem, "{name:?}");
        }
        let long = format!("{}.", "x".repeat(99)) + "tail";
        assert_eq!(file_stem(&long), "x".repeat(99));
    }

    /// Characters with a meaning in csv are quoted.
    #[test]
    fn specials_are_quoted() {
        assert_eq!(csv_field("inner"), "inner");
        assert_eq!(csv_field("a,\"b\""), "\"a,\"\"b\"\"\"");
    }
}
