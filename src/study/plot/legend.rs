//! The legend: a column to the right of the charts, so that it covers no line.

use super::canvas::{Anchor, Canvas, LETTERS, LineStyle, PixelPoint, width_of};
use super::chart::{Marker, Size, Stroke};

/// [px] from one entry to the next
const ROW: f64 = 22.0;
/// [px] of the sample line
const SAMPLE: f64 = 26.0;
/// Largest width of the legend as a share of the picture.
const WIDEST: f64 = 0.45;

/// Name and style of a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry<'a> {
    /// its name
    pub label: &'a str,
    /// its style
    pub look: LineStyle,
}

/// The entries that fit.
pub(super) struct Legend<'a> {
    entries: Vec<Entry<'a>>,
    /// [px]
    width: f64,
    /// number of entries that fit
    rows: usize,
}

impl<'a> Legend<'a> {
    pub(super) fn new(entries: Vec<Entry<'a>>, size: Size) -> Self {
        let widest = entries.iter().map(|e| width_of(e.label, LETTERS[2])).fold(0.0, f64::max);
        let width = if entries.is_empty() { 0.0 } else { SAMPLE + 24.0 + widest };
        let rows = ((f64::from(size.height) - 60.0) / ROW).max(1.0) as usize;
        Legend { entries, width: width.min(WIDEST * f64::from(size.width)), rows }
    }

    /// [px] of the column; 0 without entries
    pub(super) fn width(&self) -> f64 {
        self.width
    }

    /// Draws the column from its upper left corner on.
    pub(super) fn draw(&self, canvas: &mut Canvas, from: PixelPoint) {
        let shown = if self.entries.len() > self.rows { self.rows - 1 } else { self.entries.len() };
        let at = |row: usize| from.y + (row as f64 + 0.5) * ROW;
        for (row, Entry { label, look }) in self.entries.iter().take(shown).enumerate() {
            let y = at(row);
            if look.stroke == Stroke::None && look.marker == Marker::None {
                // A heading.
                canvas.write(&self.fitted(label), LETTERS[2], PixelPoint { x: from.x, y: y + 2.0 }, Anchor::Start);
                continue;
            }
            // A hair line shows no colour; its sample is drawn as a usual line.
            let stroke = if look.stroke == Stroke::Thin { Stroke::Normal } else { look.stroke };
            let sample = LineStyle { stroke, ..*look };
            if look.stroke == Stroke::Filled {
                let (left, right, half) = (from.x, from.x + SAMPLE, 0.3 * ROW);
                let corners = [(left, y - half), (right, y - half), (right, y + half), (left, y + half)];
                canvas.area(&corners.map(|(x, y)| PixelPoint { x, y }), *look);
            }
            canvas.line(&[PixelPoint { x: from.x, y }, PixelPoint { x: from.x + SAMPLE, y }], &[], sample);
            if look.marker != Marker::None {
                canvas.mark(PixelPoint { x: from.x + 0.5 * SAMPLE, y }, sample);
            }
            let words = self.fitted(label);
            canvas.write(&words, LETTERS[2], PixelPoint { x: from.x + SAMPLE + 8.0, y }, Anchor::Start);
        }
        let more = self.entries.len() - shown;
        if more > 0 {
            let at = PixelPoint { x: from.x + SAMPLE + 8.0, y: at(shown) };
            canvas.write(&format!("… and {more} more"), LETTERS[2], at, Anchor::Start);
        }
    }

    /// A label shortened to the available width.
    fn fitted(&self, label: &str) -> String {
        let room = self.width - SAMPLE - 20.0;
        if width_of(label, LETTERS[2]) <= room {
            return label.to_owned();
        }
        let letters = (room / width_of("x", LETTERS[2])).max(2.0) as usize;
        label.chars().take(letters - 1).chain(['…']).collect()
    }
}
