//! What a terminal shows: text wrapped to its width, and colour. `NO_COLOR` turns colour off, `CLICOLOR_FORCE` turns it
//! on where there is no terminal, and `COLUMNS` gives a width there.

use std::io::{self, IsTerminal, Write};

use anstyle::{AnsiColor, Style};

/// Narrowest width that text is wrapped to.
const NARROWEST: usize = 40;

/// Writes a report to standard output.
pub(super) fn print(text: &str) -> io::Result<()> {
    let columns = terminal_size::terminal_size_of(io::stdout());
    let mut out = anstream::stdout().lock();
    out.write_all(dress(text, width(columns)).as_bytes())?;
    out.flush()
}

/// Writes data to standard output, byte for byte.
pub(super) fn print_data(text: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.flush()
}

/// Writes a message to standard error, if it is open: `eprintln!` would panic on a closed one.
pub(super) fn complain(text: &str) {
    let columns = terminal_size::terminal_size_of(io::stderr());
    let _ = writeln!(anstream::stderr(), "{}", dress(text.trim_end(), width(columns)));
}

/// The same while a progress line may be drawn, whose rest is overwritten.
pub(super) fn interject(text: &str) {
    if io::stderr().is_terminal() {
        let _ = io::stderr().write_all(b"\r\x1b[K");
    }
    complain(text);
}

/// A word in a colour.
pub(super) fn coloured(word: &str, colour: AnsiColor) -> String {
    let style = Style::new().bold().fg_color(Some(colour.into()));
    format!("{style}{word}{style:#}")
}

/// [characters] The width to wrap at, if any.
fn width(terminal: Option<(terminal_size::Width, terminal_size::Height)>) -> Option<usize> {
    let asked = || std::env::var("COLUMNS").ok()?.parse::<usize>().ok();
    terminal.map(|(width, _)| usize::from(width.0)).or_else(asked).filter(|width| *width >= NARROWEST)
}

/// Labels in colour, lines wrapped.
fn dress(text: &str, width: Option<usize>) -> String {
    let mut dressed = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        let (line, end) = line.strip_suffix('\n').map_or((line, ""), |line| (line, "\n"));
        let line = width.map_or_else(|| line.to_owned(), |width| wrap(line, width));
        dressed.push_str(&label(line));
        dressed.push_str(end);
    }
    dressed
}

/// The line with its label in colour, if it begins with one.
fn label(line: String) -> String {
    let labels = [
        ("error:", AnsiColor::Red),
        ("warning:", AnsiColor::Yellow),
        ("note:", AnsiColor::Cyan),
        ("acknowledged:", AnsiColor::Cyan),
        ("  hint:", AnsiColor::Cyan),
    ];
    let found = labels.iter().find_map(|(label, colour)| Some((label, line.strip_prefix(label)?, colour)));
    found.map(|(label, rest, colour)| coloured(label, *colour) + rest).unwrap_or(line)
}

/// A line broken at spaces. What follows is indented to the text behind the line's label.
fn wrap(line: &str, width: usize) -> String {
    // Quoted text with a mark below it stays as it is.
    if shown(line) <= width || line.contains(" | ") {
        return line.to_owned();
    }
    let hang = " ".repeat(hanging(line).min(width / 3));
    let (mut wrapped, mut column) = (String::with_capacity(line.len() + 32), 0);
    for word in line.split_inclusive(' ') {
        let length = shown(word.trim_end());
        if column > hang.len() && column + length > width {
            wrapped.truncate(wrapped.trim_end_matches(' ').len());
            wrapped.push('\n');
            wrapped.push_str(&hang);
            column = hang.len();
        }
        wrapped.push_str(word);
        column += shown(word);
    }
    wrapped
}

/// [characters] Where the text begins behind a label and at least two spaces; without a label, just behind the line's
/// own indent.
fn hanging(line: &str) -> usize {
    let indent = line.len() - line.trim_start().len();
    let text = line.trim_start();
    let behind = text.find("  ").map(|gap| indent + gap + text[gap..].len() - text[gap..].trim_start().len());
    behind.unwrap_or(if indent > 4 { indent } else { indent + 2 })
}

/// [characters] Length as shown, without sequences for colour.
fn shown(text: &str) -> usize {
    let mut length = 0;
    let mut hidden = false;
    for c in text.chars() {
        match c {
            '\x1b' => hidden = true,
            'm' if hidden => hidden = false,
            _ => length += usize::from(!hidden),
        }
    }
    length
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No line is longer than the width unless one word is, nothing but spaces is lost, and what follows stands below
    /// the text.
    #[test]
    fn long_lines_are_broken_at_spaces() {
        let line =
            "  advice          take a step of 3.1e-4 s or smaller, or time.method=backward-euler, or another case";
        for width in [40, 60, 80] {
            let wrapped = wrap(line, width);
            let lines: Vec<&str> = wrapped.lines().collect();
            assert!(lines.len() > 1 && lines.iter().all(|line| line.len() <= width), "{wrapped}");
            let indent = 18.min(width / 3);
            assert!(lines[1..].iter().all(|line| line.len() - line.trim_start().len() == indent), "{wrapped}");
            let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
            assert_eq!(words(&wrapped), words(line));
        }
        assert_eq!(wrap(line, 120), line);
        let word = "x".repeat(90);
        assert_eq!(wrap(&word, 80), word);
    }

    /// Colour has no width.
    #[test]
    fn colour_has_no_width() {
        let word = coloured("good", AnsiColor::Green);
        assert_eq!((shown(&word), shown("good")), (4, 4));
        let line = format!("{} {word}", "a".repeat(35));
        assert_eq!(wrap(&line, 40), line);
    }
}
