//! Comments in a case file: `// to the end of the line` and `/* block */`, as editors know them from "JSON with
//! comments". They are replaced by spaces of the same length in bytes, so that every line, column and byte offset of
//! a later message is the one in the file.

/// A block comment without end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OpenComment {
    /// byte offset of its `/*`
    pub offset: usize,
}

/// What the scanner is inside of.
#[derive(Clone, Copy, PartialEq)]
enum Inside {
    Json,
    Text,
    Line,
    Block { start: usize },
}

/// Blanks the comments outside strings.
///
/// # Errors
/// A block comment that is never closed.
pub fn blank(text: &str) -> Result<String, OpenComment> {
    if !text.contains("//") && !text.contains("/*") {
        return Ok(text.to_owned());
    }
    let bytes = text.as_bytes();
    let mut out = bytes.to_vec();
    let mut inside = Inside::Json;
    let mut i = 0;
    while i < bytes.len() {
        let pair = (bytes[i], bytes.get(i + 1).copied());
        let (next, used, hidden) = step(inside, pair, i);
        if hidden {
            // Line ends stay, so that line numbers do; a multi-byte character becomes as many spaces.
            for byte in out.iter_mut().skip(i).take(used).filter(|byte| !matches!(**byte, b'\n' | b'\r')) {
                *byte = b' ';
            }
        }
        inside = next;
        i += used;
    }
    match inside {
        Inside::Block { start } => Err(OpenComment { offset: start }),
        // Whole comments were replaced by ASCII, so what is left is still UTF-8.
        _ => Ok(String::from_utf8_lossy(&out).into_owned()),
    }
}

/// The next state, how many bytes were used, and whether they belong to a comment.
fn step(inside: Inside, pair: (u8, Option<u8>), at: usize) -> (Inside, usize, bool) {
    match (inside, pair) {
        (Inside::Json, (b'"', _)) => (Inside::Text, 1, false),
        (Inside::Json, (b'/', Some(b'/'))) => (Inside::Line, 2, true),
        (Inside::Json, (b'/', Some(b'*'))) => (Inside::Block { start: at }, 2, true),
        (Inside::Text, (b'\\', Some(_))) => (Inside::Text, 2, false),
        (Inside::Text, (b'"', _)) => (Inside::Json, 1, false),
        (Inside::Line, (b'\n' | b'\r', _)) => (Inside::Json, 1, false),
        (Inside::Line, _) => (Inside::Line, 1, true),
        (Inside::Block { .. }, (b'*', Some(b'/'))) => (Inside::Json, 2, true),
        (Inside::Block { .. }, _) => (inside, 1, true),
        _ => (inside, 1, false),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nothing moves: same length, same line ends, and slashes in strings stay.
    #[test]
    fn keeps_every_offset() {
        let text = "{ // größe\r\n \"a\": \"http://x /* no */ \\\" // \", /* 1\n2 */ \"b\": 1 }";
        let clean = blank(text).expect("closed");
        assert_eq!(clean.len(), text.len());
        assert_eq!(clean.find("\"b\""), text.find("\"b\""));
        let value: serde_json::Value = serde_json::from_str(&clean).expect("JSON");
        assert_eq!(value, serde_json::json!({"a": "http://x /* no */ \" // ", "b": 1}));
    }

    /// The start of the comment is what a reader of the message needs.
    #[test]
    fn reports_where_an_open_comment_starts() {
        assert_eq!(blank("{} /* to the end"), Err(OpenComment { offset: 3 }));
        // "/*/" opens a comment and does not close it.
        assert_eq!(blank("/*/"), Err(OpenComment { offset: 0 }));
    }
}
