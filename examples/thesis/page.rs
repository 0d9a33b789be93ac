//! The index page: sections of text, tables and figures, in the frame of the pages of studies. Figures are in the page
//! and SVG files beside it, tables are CSV files too.

use canopy_fem::plot::chart::{Chart, Line, Size, Stroke};
use canopy_fem::plot::layout::{Sample, legend_samples, svg_grid};
use canopy_fem::study::template::{PageFigure, render};
use canopy_fem::study::{method_color, method_mark};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

use super::runs::Failed;

/// [px] Charts on wide and on narrow screens, and those of many lines, which are there once.
const SIZES: [Size; 3] =
    [Size { width: 760, height: 480 }, Size { width: 460, height: 400 }, Size { width: 620, height: 460 }];
/// [bytes] A picture above this is there once.
const LARGE: usize = 60_000;
/// Number of black in the palette: for what is no method.
const BLACK: usize = 6;
/// Drawing units of a dash for each curve of a figure.
const DASH: usize = 90;

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
    Figure(Box<Figure>),
}

/// A table with one sentence on what differs from the thesis.
#[derive(Debug, Default, Serialize)]
pub struct Table {
    /// its file without the ending
    pub stem: String,
    pub caption: String,
    pub head: Vec<String>,
    pub rows: Vec<Vec<String>>,
    pub note: String,
}

/// A figure of the thesis, drawn again.
#[derive(Debug, Default, Serialize)]
pub struct Figure {
    /// its file without the ending, and its name on the page
    pub stem: String,
    /// the sentence on the difference
    pub note: String,
    /// the picture; the narrow one is empty where the other one is for all screens
    pub picture: PageFigure,
    /// its curves, with names that are those of no other figure
    pub legend: Vec<Sample>,
    /// dashes and gaps of the curves [drawing units], which tell apart those that coincide
    pub dashes: Vec<[usize; 2]>,
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

/// Marks along a curve.
const MARKS: usize = 7;

/// A curve in the colour and with the mark that its method has on all pages.
pub fn curve(method: &str, label: impl Into<String>, points: Vec<(f64, f64)>) -> Line {
    let (color, marker) = (Some(method_color(method)), method_mark(method));
    Line { color, marker, marks: MARKS, ..Line::new(label, points) }
}

/// A curve that is no method's.
pub fn exact_curve(label: &str, points: Vec<(f64, f64)>) -> Line {
    Line { color: Some(BLACK), stroke: Stroke::Dashed, ..Line::new(label, points) }
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
        let words = caption.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
        let stem = words.take(6).collect::<Vec<_>>().join("-").to_lowercase();
        self.items.push(Item::Table(Table { stem, caption: caption.to_owned(), head, rows, note: note.into() }));
    }

    /// Draws a chart into a file of the page's folder and for the page.
    pub fn figure(&mut self, out: &Path, caption: Caption<'_>, mut chart: Chart) -> Result<(), Failed> {
        std::fs::write(out.join(format!("{}.svg", caption.stem)), svg_grid(std::slice::from_ref(&chart), 1)?)?;
        for line in chart.lines.iter_mut().filter(|line| !line.label.is_empty()) {
            line.series = format!("{} {}", caption.stem, line.label);
        }
        let [wide, narrow, single] = SIZES;
        let mut picture = PageFigure::of(&chart, caption.caption, [wide, narrow])?;
        if picture.wide.len() > LARGE {
            picture =
                PageFigure { narrow: String::new(), ..PageFigure::of(&chart, caption.caption, [single, single])? };
        }
        self.items.push(Item::Figure(Box::new(Figure {
            stem: caption.stem.to_owned(),
            note: caption.note.to_owned(),
            picture,
            legend: legend_samples(&chart.lines),
            dashes: dashes(&chart.lines),
        })));
        Ok(())
    }
}

/// Of curves that coincide, each later one, which is drawn over the earlier ones, leaves a longer part of them visible.
fn dashes(lines: &[Line]) -> Vec<[usize; 2]> {
    let named = lines.iter().filter(|line| !line.label.is_empty() && line.stroke != Stroke::Dashed).count();
    (0..named).map(|number| [DASH * (named - number), DASH * number]).collect()
}

impl Page {
    /// Writes `index.html`, `thesis.json` and a CSV file a table.
    pub fn write(&self, out: &Path) -> Result<(), Failed> {
        let items = || self.sections.iter().flat_map(|section| &section.items);
        for item in items() {
            if let Item::Table(table) = item {
                let mut file = csv::Writer::from_path(out.join(format!("{}.csv", table.stem)))?;
                file.write_record(&table.head)?;
                table.rows.iter().try_for_each(|row| file.write_record(row))?;
                file.flush()?;
            }
        }
        let figures = items().filter_map(|item| if let Item::Figure(figure) = item { Some(figure) } else { None });
        let told: BTreeMap<&str, [[&str; 2]; 1]> = figures
            .flat_map(|figure| &figure.legend)
            .map(|entry| (entry.series.as_str(), [["curve", entry.label.as_str()]]))
            .collect();
        let Page { sections, seconds, version } = self;
        let page = minijinja::context! { sections, seconds, version, told };
        std::fs::write(out.join("index.html"), render("index.html", include_str!("index.html"), &page)?)?;
        let tables: Vec<&Table> =
            items().filter_map(|item| if let Item::Table(table) = item { Some(table) } else { None }).collect();
        std::fs::write(out.join("thesis.json"), serde_json::to_string_pretty(&tables)? + "\n")?;
        Ok(())
    }
}

/// A table's cell for a number: three digits.
pub fn cell(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e4).contains(&size) { format!("{value:.2e}") } else { format!("{value:.3}") }
}
