//! A fault of a case: where it is, what stands there, what may stand there.
//!
//! A fault keeps the pointer only. Line, column and a picture of the source are made from the pointer and the
//! source text that [`crate::case::CaseError::Faults`] keeps, so that the checks know nothing of text.

use std::fmt;

use serde_json::Value;

use super::pointer::Pointer;

/// More than this many faults help nobody; the rest is counted.
const SHOWN: usize = 50;

/// Longest excerpt of a value in a message, in characters.
const EXCERPT: usize = 80;

/// One thing that is wrong with a case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// JSON pointer of the value, e.g. `/time/step`
    pub pointer: String,
    /// what stands there, shortened
    pub value: String,
    /// what may stand there, as a sentence part: "a number above 0"
    pub allowed: String,
    /// what to do about it, if there is more to say
    pub hint: Option<String>,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let pointer = if self.pointer.is_empty() { "/" } else { &self.pointer };
        writeln!(f, "{pointer}: {}", self.value)?;
        write!(f, "  allowed: {}", self.allowed)?;
        match &self.hint {
            Some(hint) => write!(f, "\n  hint: {hint}"),
            None => Ok(()),
        }
    }
}

/// Renders faults for a terminal: one paragraph each, in the order they were found.
pub fn render(faults: &[Fault]) -> String {
    faults.iter().map(Fault::to_string).collect::<Vec<_>>().join("\n\n")
}

/// A value as a message shows it: compact JSON, cut after 80 characters.
pub fn excerpt(value: &Value) -> String {
    // A mesh written into the case can be megabytes long: print no more of it than is shown.
    match value {
        Value::Array(list) if list.len() > EXCERPT => format!("a list of {} entries", list.len()),
        Value::Object(map) if map.len() > EXCERPT => format!("an object with {} keys", map.len()),
        other => shorten(&other.to_string()),
    }
}

fn shorten(text: &str) -> String {
    if text.chars().count() <= EXCERPT {
        return text.to_owned();
    }
    let head: String = text.chars().take(EXCERPT - 1).collect();
    format!("{head}…")
}

/// Collects the faults and warnings of one pass over a case.
#[derive(Debug)]
pub(crate) struct Faults<'a> {
    json: &'a Value,
    list: Vec<Fault>,
    dropped: usize,
    warnings: Vec<String>,
}

impl<'a> Faults<'a> {
    /// Starts an empty collection for the case whose values messages quote.
    pub fn new(json: &'a Value) -> Self {
        Self { json, list: Vec::new(), dropped: 0, warnings: Vec::new() }
    }

    /// Notes that the value at `at` is not what is allowed there.
    pub fn add(&mut self, at: &Pointer, allowed: impl Into<String>) {
        self.add_value(at, self.shown(at), allowed, None);
    }

    /// The same with advice.
    pub fn add_hint(&mut self, at: &Pointer, allowed: impl Into<String>, hint: impl Into<String>) {
        self.add_value(at, self.shown(at), allowed, Some(hint.into()));
    }

    /// The same where the wrong value is not the one written at `at`, but follows from it.
    pub fn add_value(
        &mut self,
        at: &Pointer,
        value: impl Into<String>,
        allowed: impl Into<String>,
        hint: Option<String>,
    ) {
        if self.list.len() >= SHOWN {
            self.dropped = self.dropped.saturating_add(1);
            return;
        }
        let hint = hint.filter(|text| !text.is_empty());
        self.list.push(Fault { pointer: at.as_str().to_owned(), value: value.into(), allowed: allowed.into(), hint });
    }

    /// Notes something doubtful that does not stop a run.
    pub fn warn(&mut self, text: impl Into<String>) {
        self.warnings.push(text.into());
    }

    /// Number of faults so far, the ones not shown included.
    pub fn count(&self) -> usize {
        self.list.len().saturating_add(self.dropped)
    }

    /// Ends the collection: the warnings if there was no fault, else the faults.
    pub fn finish(mut self) -> Result<Vec<String>, Vec<Fault>> {
        if self.list.is_empty() {
            return Ok(self.warnings);
        }
        if self.dropped > 0 {
            self.list.push(Fault {
                pointer: String::new(),
                value: format!("{} more faults", self.dropped),
                allowed: "none".to_owned(),
                hint: Some("mend the ones above and check again".to_owned()),
            });
        }
        Err(self.list)
    }

    fn shown(&self, at: &Pointer) -> String {
        self.json.pointer(at.as_str()).map_or_else(|| "(missing)".to_owned(), excerpt)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fault a paragraph, with the hint only where there is one.
    #[test]
    fn renders_one_paragraph_a_fault() {
        let json = serde_json::json!({"time": {"step": -1}});
        let mut faults = Faults::new(&json);
        faults.add(&Pointer::root().key("time").key("step"), "a number above 0");
        faults.add_hint(&Pointer::root().key("name"), "a text", "give it a name");
        let list = faults.finish().expect_err("two faults");
        assert_eq!(
            render(&list),
            "/time/step: -1\n  allowed: a number above 0\n\n/name: (missing)\n  allowed: a text\n  hint: give it a name"
        );
    }

    /// A case with a fault in every entry of a long list gives a message of bounded length that says what it left out.
    #[test]
    fn bounds_the_number_of_faults() {
        let json = serde_json::json!({});
        let mut faults = Faults::new(&json);
        for i in 0..1000 {
            faults.add(&Pointer::root().index(i), "x");
        }
        assert_eq!(faults.count(), 1000);
        let list = faults.finish().expect_err("faults");
        assert_eq!(list.len(), SHOWN + 1);
        assert_eq!(list[SHOWN].value, "950 more faults");
    }
}
