//! The index page: sections of text, tables and figures, rendered with minijinja; figures are SVG files beside it.

use canopy_fem::plot::chart::{Chart, svg_grid};
use serde::Serialize;
use std::path::Path;

use super::runs::Failed;

/// What the page shows, in order.
#[derive(Debug, Default, Serialize)]
pub struct Page {
    pub sections: Vec<Section>,
    /// how long the whole took
    pub seconds: f64,
    pub version: &'static str,
}

/// One system of the thesis.
#[derive(Debug, Default, Serialize)]
pub struct Section {
    pub title: String,
    pub items: Vec<Item>,
    /// sentences that the numbers do not bear out
    #[serde(skip)]
    pub untrue: Vec<String>,
}

#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Item {
    Text { text: String },
    Table(Table),
    Figure { file: String, caption: String, note: String },
}

/// A table with one sentence on what differs from the thesis.
#[derive(Debug, Default, Serialize)]
pub struct Table {
    pub caption: String,
    pub head: Vec<String>,
    pub rows: Vec<Vec<String>>,
    pub note: String,
}

/// A figure's place in the thesis, and what is said of it.
pub struct Caption<'a> {
    /// file stem, e.g. "figure-04"
    pub stem: &'a str,
    /// "Figure 4: ..."
    pub caption: &'a str,
    /// the sentence on the difference
    pub note: &'a str,
}

impl Section {
    pub fn new(title: &str) -> Self {
        Section { title: title.to_owned(), ..Section::default() }
    }

    pub fn text(&mut self, text: impl Into<String>) {
        self.items.push(Item::Text { text: text.into() });
    }

    pub fn table(&mut self, caption: &str, head: &[&str], rows: Vec<Vec<String>>, note: impl Into<String>) {
        let head = head.iter().map(|h| (*h).to_owned()).collect();
        self.items.push(Item::Table(Table { caption: caption.to_owned(), head, rows, note: note.into() }));
    }

    /// Draws charts side by side into one file of the page's folder.
    pub fn figure(&mut self, out: &Path, caption: Caption<'_>, charts: &[Chart]) -> Result<(), Failed> {
        let file = format!("{}.svg", caption.stem);
        std::fs::write(out.join(&file), svg_grid(charts, charts.len())?)?;
        let (text, note) = (caption.caption.to_owned(), caption.note.to_owned());
        self.items.push(Item::Figure { file, caption: text, note });
        Ok(())
    }
}

impl Page {
    /// Writes `index.html`.
    pub fn write(&self, out: &Path) -> Result<(), Failed> {
        let mut templates = minijinja::Environment::new();
        templates.add_template("index.html", include_str!("index.html"))?;
        std::fs::write(out.join("index.html"), templates.get_template("index.html")?.render(self)?)?;
        Ok(())
    }
}

/// A table's cell for a number: three digits.
pub fn cell(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e4).contains(&size) { format!("{value:.2e}") } else { format!("{value:.3}") }
}
