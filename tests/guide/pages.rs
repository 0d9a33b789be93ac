//! The pages of the guide and the blocks in them.

use std::path::{Path, PathBuf};

/// The repository.
pub const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// A page of the guide.
pub struct Page {
    /// its file
    pub path: PathBuf,
    /// its name in messages
    pub name: String,
    /// its text
    pub text: String,
}

/// A fenced block of a page.
pub struct Block {
    /// line of its opening fence, counted from 1
    pub line: usize,
    /// the language it names
    pub language: String,
    /// the words of a comment `<!-- ci: ... -->` directly above it
    pub comment: Vec<String>,
    /// its lines
    pub body: String,
}

/// The folder of the pages.
pub fn folder() -> PathBuf {
    Path::new(ROOT).join("docs/guide/src")
}

/// All pages, in the order of their names.
pub fn pages() -> Vec<Page> {
    let entries = std::fs::read_dir(folder()).expect("docs/guide/src");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|ext| ext == "md"));
    paths.sort();
    let page = |path: PathBuf| Page {
        name: path.file_name().expect("a name").to_string_lossy().into_owned(),
        text: std::fs::read_to_string(&path).expect("a page"),
        path,
    };
    let pages: Vec<Page> = paths.into_iter().map(page).collect();
    assert!(pages.len() > 10, "only {} pages", pages.len());
    pages
}

impl Page {
    /// The fenced blocks.
    pub fn blocks(&self) -> Vec<Block> {
        let mut blocks = Vec::new();
        let mut open: Option<Block> = None;
        let mut above = "";
        for (line, text) in self.text.lines().enumerate() {
            match (text.strip_prefix("```"), &mut open) {
                (Some(_), Some(_)) => blocks.extend(open.take()),
                (Some(language), None) => {
                    let comment = above.strip_prefix("<!-- ci: ").and_then(|rest| rest.strip_suffix(" -->"));
                    let comment = comment.unwrap_or("").split_whitespace().map(str::to_owned).collect();
                    open = Some(Block { line: line + 1, language: language.to_owned(), comment, body: String::new() });
                }
                (None, Some(block)) => block.body += &format!("{text}\n"),
                (None, None) => (),
            }
            above = text;
        }
        assert!(open.is_none(), "{}: a block is not closed", self.name);
        blocks
    }

    /// The lines outside of fenced blocks and comments, with their numbers, counted from 1.
    pub fn prose(&self) -> Vec<(usize, &str)> {
        let (mut fenced, mut comment) = (false, false);
        let mut lines = Vec::new();
        for (line, text) in self.text.lines().enumerate() {
            let fence = text.starts_with("```");
            comment |= text.starts_with("<!--");
            if !fence && !fenced && !comment {
                lines.push((line + 1, text));
            }
            fenced ^= fence;
            comment &= !text.ends_with("-->");
        }
        lines
    }
}
