//! Every link inside the repository leads to a file or a heading that is there, and every page is in the contents.

use crate::pages::{Page, folder, pages};

/// Targets of the links and pictures in a line: what stands in `](...)`.
fn targets(line: &str) -> impl Iterator<Item = &str> {
    line.split("](").skip(1).filter_map(|rest| rest.split(')').next())
}

/// The anchor of a heading, as mdBook and GitHub make it.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().to_lowercase();
    kept.chars().filter(|c| c.is_alphanumeric() || "-_ ".contains(*c)).map(|c| if c == ' ' { '-' } else { c }).collect()
}

fn has_anchor(text: &str, wanted: &str) -> bool {
    text.lines().filter_map(|line| line.strip_prefix('#')).any(|line| anchor(line.trim_start_matches('#')) == wanted)
}

fn fault(page: &Page, target: &str) -> Option<String> {
    if target.starts_with("http://") || target.starts_with("https://") {
        return None;
    }
    let (file, wanted) = target.split_once('#').map_or((target, None), |(file, wanted)| (file, Some(wanted)));
    let path = if file.is_empty() { page.path.clone() } else { folder().join(file) };
    if !path.is_file() {
        return Some(format!("{} is not there", path.display()));
    }
    // What mdBook publishes is the folder of the pages; a link that leaves it would be dead there.
    let inside = path.canonicalize().expect("a path").starts_with(folder().canonicalize().expect("a folder"));
    if !inside {
        return Some(format!("{file} is outside of the book"));
    }
    let text = wanted.map(|wanted| (wanted, std::fs::read_to_string(&path).expect("a page")));
    text.filter(|(wanted, text)| !has_anchor(text, wanted)).map(|(wanted, _)| format!("no heading #{wanted}"))
}

#[test]
fn links_lead_somewhere() {
    let (mut faults, mut count) = (Vec::new(), 0);
    for page in pages() {
        for (line, text) in page.prose() {
            for target in targets(text) {
                count += 1;
                faults.extend(fault(&page, target).map(|what| format!("{}:{line}: {target}: {what}", page.name)));
            }
        }
    }
    assert!(count > 60, "only {count} links were found");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn every_page_is_in_the_contents() {
    let contents = std::fs::read_to_string(folder().join("SUMMARY.md")).expect("SUMMARY.md");
    for page in pages().iter().filter(|page| page.name != "SUMMARY.md") {
        assert!(contents.contains(&format!("]({})", page.name)), "{} is missing in SUMMARY.md", page.name);
    }
}
