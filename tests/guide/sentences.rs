//! Short sentences: none of the guide has more than thirty words.

use crate::pages::pages;

const LONGEST: usize = 30;

/// The sentences of a text: paragraphs, list items and table cells, cut after full stops.
fn sentences(lines: &[(usize, &str)]) -> Vec<(usize, String)> {
    let mut parts: Vec<(usize, String)> = Vec::new();
    let mut open = false;
    for (number, line) in lines {
        let text = line.trim();
        let number_first = text.split_once(". ").is_some_and(|(first, _)| first.parse::<u32>().is_ok());
        let starts = ["#", "|", "* ", "- ", "> ", "!["].iter().any(|mark| text.starts_with(mark)) || number_first;
        if text.starts_with('|') {
            parts.extend(text.split('|').map(|cell| (*number, cell.to_owned())));
        } else if open && !starts && !text.is_empty() {
            parts.last_mut().expect("an open part").1 += &format!(" {text}");
            continue;
        } else {
            parts.push((*number, text.to_owned()));
        }
        open = !text.is_empty() && !text.starts_with(['|', '#']);
    }
    let cut = |(number, text): (usize, String)| {
        let ends = text.replace(".)", ".").replace("? ", ". ");
        ends.split(". ").map(|sentence| (number, sentence.to_owned())).collect::<Vec<_>>()
    };
    parts.into_iter().flat_map(cut).collect()
}

/// What counts as a word holds a letter or a digit; code in backticks is one word.
fn words(sentence: &str) -> usize {
    let prose: String =
        sentence.split('`').enumerate().map(|(i, part)| if i % 2 == 0 { part } else { "code" }).collect();
    prose.split_whitespace().filter(|word| word.contains(char::is_alphanumeric)).count()
}

#[test]
fn no_sentence_is_longer_than_thirty_words() {
    let mut long = Vec::new();
    let mut count = 0;
    // The case reference quotes the schema, whose texts have their own form.
    for page in pages().iter().filter(|page| page.name != "case-reference.md") {
        for (line, sentence) in sentences(&page.prose()) {
            count += 1;
            let words = words(&sentence);
            if words > LONGEST {
                long.push(format!("{}:{line}: {words} words: {sentence}", page.name));
            }
        }
    }
    assert!(count > 300, "only {count} sentences were found");
    assert!(long.is_empty(), "{} sentences are too long:\n{}", long.len(), long.join("\n"));
}

#[test]
fn sentences_are_cut_and_counted() {
    let text = [(1, "One two"), (2, "three. Four `five six`."), (3, ""), (4, "* seven"), (5, "| a b | c |")];
    let counts: Vec<usize> = sentences(&text).iter().map(|(_, s)| words(s)).filter(|n| *n > 0).collect();
    assert_eq!(counts, [3, 2, 1, 2, 1]);
}
