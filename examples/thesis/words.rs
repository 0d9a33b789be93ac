//! Sentences that state results: put together from the numbers, or kept only while the numbers bear them out.

use super::page::Section;

/// "a", "a and b", "a, b and c".
pub fn names<S: AsRef<str>>(list: &[S]) -> String {
    let list: Vec<&str> = list.iter().map(AsRef::as_ref).collect();
    match list.split_last() {
        None => "none".to_owned(),
        Some((last, [])) => (*last).to_owned(),
        Some((last, rest)) => format!("{} and {last}", rest.join(", ")),
    }
}

impl Section {
    /// A sentence that is true as long as `holds`; else the page goes without it and the example fails.
    pub fn claim(&mut self, holds: bool, sentence: impl Into<String>) -> String {
        let sentence = sentence.into();
        if holds {
            return sentence;
        }
        self.untrue.push(sentence);
        String::new()
    }
}
