//! Faults for the terminal: location, the line with a mark below, what is allowed.

use std::ops::Range;

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};

use super::diagnostics::Fault;
use super::location::Location;

/// [characters] Largest width of a quoted line.
const WIDTH: usize = 100;

/// [byte] Length to keep of a line on either side of the mark: a mesh on one line can be megabytes long.
const AROUND: usize = 400;

/// Renders faults for a terminal: one paragraph each.
pub(super) fn render(path: &str, text: &str, faults: &[Fault]) -> String {
    faults.iter().map(|fault| paragraph(path, text, fault)).collect::<Vec<_>>().join("\n\n")
}

fn paragraph(path: &str, text: &str, fault: &Fault) -> String {
    let place = match &fault.place {
        None => String::new(),
        Some(place @ Location::Assignment { .. }) => format!("  --> {place}\n"),
        Some(place @ Location::Text { range, line, .. }) => {
            format!("  --> {path}:{place}\n{}", picture(text, range, *line))
        }
    };
    format!("{}\n{place}{}", fault.heading(), fault.advice())
}

/// The first line of the range, shortened, with a mark below the range.
fn picture(text: &str, range: &Range<usize>, number: usize) -> String {
    let before = text.get(..range.start).unwrap_or_default();
    let after = text.get(range.start..).unwrap_or_default();
    let head = before.rsplit('\n').next().unwrap_or_default();
    let tail = after.split(['\n', '\r']).next().unwrap_or_default();
    // Cut at both ends; the renderer shortens further, to the width.
    let from = head.char_indices().rev().nth(AROUND).map_or(0, |(i, _)| i);
    let to = tail.char_indices().nth(AROUND).map_or(tail.len(), |(i, _)| i);
    let head = head.get(from..).unwrap_or_default();
    let tail = tail.get(..to).unwrap_or_default().trim_end();
    let marked = range.len().min(tail.len());
    let line = format!("{head}{tail}");
    let snippet = Snippet::source(&line)
        .line_start(number)
        .annotation(AnnotationKind::Primary.span(head.len()..head.len() + marked));
    let drawn = Renderer::plain().term_width(WIDTH).render(&[Group::with_level(Level::ERROR).element(snippet)]);
    drawn.trim_end().to_owned() + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(text: &str, range: Range<usize>) -> String {
        let place = Some(Location::in_text(text, range));
        let fault = Fault {
            pointer: "/a".to_owned(),
            value: "1".to_owned(),
            allowed: "2".to_owned(),
            place,
            ..Fault::default()
        };
        render("case.json", text, &[fault])
    }

    /// The first line of a longer value is marked; an empty range and one at the end are marked too.
    #[test]
    fn marks_what_is_on_the_line() {
        assert!(drawn("{\"a\": {\n}}", 6..9).contains("1 | {\"a\": {\n  |       ^"));
        for text in ["", "\n", "{"] {
            assert!(drawn(text, text.len()..text.len()).contains('^'), "{text:?}");
        }
    }

    /// A line of megabytes is shortened around the mark.
    #[test]
    fn shortens_long_lines() {
        let text = format!("[{}-1{}]", "7, ".repeat(1_000_000), ", 8".repeat(1_000_000));
        let shown = drawn(&text, 3_000_001..3_000_003);
        assert!(shown.len() < 1000, "{} bytes", shown.len());
        let lines: Vec<&str> = shown.lines().collect();
        let line = lines.iter().find(|line| line.contains("-1")).expect("the line");
        let mark = lines.iter().find(|line| line.contains("^^")).expect("the mark");
        assert_eq!(line.chars().position(|c| c == '-'), mark.chars().position(|c| c == '^'), "{shown}");
    }
}
