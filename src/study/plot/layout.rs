//! From charts to SVG text: the layout of a picture.

use super::PlotError;
use super::axis::AxisScale;
use super::canvas::{Anchor, Canvas, FINE_GRID, Field, GRID, LETTERS, LineStyle, PixelPoint, fitting};
use super::chart::{Align, Axis, Chart, Line, Marker, Note, Scale, Size, Stroke};
use super::decimate::{UnitPoint, inside, thin};
use super::legend::{Entry, Legend};
use super::margin_panel::PanelLayout;
use super::outline::{AxisScales, LineKey, PlotArea, covered, key, shown_points};
use std::collections::BTreeMap;

/// Largest number of points of a line, and of all lines of a chart together: more cannot be distinguished in a picture,
/// and make browsers slow.
const MOST_POINTS: usize = 2000;
const MOST_POINTS_OF_ALL: usize = 40_000;
/// [px] widest and narrowest usual line. Earlier lines are wider, so that they are visible below later ones that
/// coincide with them.
const WIDTHS: [f64; 2] = [2.8, 1.4];
/// Largest picture [px].
const LARGEST: u32 = 20_000;

/// The chart as an SVG picture. Lines with many points are decimated; all extremes are kept.
///
/// # Errors
/// Nothing to draw, or an invalid range.
pub fn svg(chart: &Chart) -> Result<String, PlotError> {
    svg_grid(std::slice::from_ref(chart), 1)
}

/// Several charts in one picture, filled row by row; the legend, to their right, has every label of them once.
///
/// # Errors
/// Nothing to draw, or a range that is none.
pub fn svg_grid(charts: &[Chart], columns: usize) -> Result<String, PlotError> {
    drawn(charts, columns, false)
}

/// The same for a page that has a legend of its own: without one, and elements say to which series and run they belong.
///
/// # Errors
/// As [`svg_grid`].
pub fn svg_page(charts: &[Chart], columns: usize) -> Result<String, PlotError> {
    drawn(charts, columns, true)
}

/// An entry of the legend of a page.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Sample {
    /// its text
    pub label: String,
    /// what it hides and shows; empty = nothing
    pub series: String,
    /// a sample of the line; empty = a heading
    pub svg: String,
}

/// The legend of some lines, for a page.
pub fn legend_samples(lines: &[Line]) -> Vec<Sample> {
    let (width, height) = (34, 16);
    let (from, to, y) = (1.5, f64::from(width) - 1.5, 0.5 * f64::from(height));
    let sample = |(line, look): (&Line, LineStyle)| {
        let mut canvas = Canvas::plain(Size { width, height });
        canvas.line(&[PixelPoint { x: from, y }, PixelPoint { x: to, y }], &[], look);
        canvas.mark(PixelPoint { x: f64::midpoint(from, to), y }, look);
        let heading = look.stroke == Stroke::None && look.marker == Marker::None;
        let svg = if heading { String::new() } else { canvas.finish() };
        Sample { label: line.label.clone(), series: line.series.clone(), svg }
    };
    lines.iter().zip(looks(lines, &BTreeMap::new())).filter(|(line, _)| !line.label.is_empty()).map(sample).collect()
}

fn drawn(charts: &[Chart], columns: usize, page: bool) -> Result<String, PlotError> {
    let Some(first) = charts.first() else { return Err(PlotError::NothingToDraw { title: String::new() }) };
    let columns = columns.clamp(1, charts.len());
    let rows = charts.len().div_ceil(columns);
    let grown = |length: u32, times: usize| length.saturating_mul(times as u32).clamp(100, LARGEST);
    let size = Size { width: grown(first.size.width, columns), height: grown(first.size.height, rows) };
    let (width, height) = (f64::from(size.width), f64::from(size.height));
    let entries = || charts.iter().filter(|_| !page).flat_map(|chart| &chart.lines).filter(|l| !l.label.is_empty());
    let room = Legend::new(entries().map(|line| Entry { label: &line.label, look: PLAIN }).collect(), size).width();
    let cell = PixelPoint { x: (width - room) / columns as f64, y: height / rows as f64 };
    let mut layouts = Vec::with_capacity(charts.len());
    for (i, chart) in charts.iter().enumerate() {
        let from = PixelPoint { x: (i % columns) as f64 * cell.x, y: (i / columns) as f64 * cell.y };
        let to = PixelPoint { x: from.x + cell.x, y: from.y + cell.y };
        layouts.push(ChartLayout::new(chart, Field { from, to })?);
    }
    // The lines of a page can be hidden and shown.
    let covered = covered(layouts.iter().filter(|_| !page).map(|layout| (layout.chart, layout.area())));
    let mut canvas = Canvas::new(size, page);
    let mut legend: Vec<Entry<'_>> = Vec::new();
    for layout in &layouts {
        let looks = looks(&layout.chart.lines, &covered);
        layout.draw(&mut canvas, &looks);
        for (line, look) in layout.chart.lines.iter().zip(looks).filter(|(line, _)| !page && !line.label.is_empty()) {
            let same = |entry: &Entry<'_>| entry.label == line.label && entry.look.shows_as(look);
            if !legend.iter().any(same) {
                legend.push(Entry { label: &line.label, look });
            }
        }
    }
    Legend::new(legend, size).draw(&mut canvas, PixelPoint { x: width - room, y: 40.0 });
    Ok(canvas.finish())
}

/// A chart in its part of the picture.
struct ChartLayout<'a> {
    chart: &'a Chart,
    margin_panel: Option<PanelLayout<'a>>,
    /// with the margin panel
    whole: Field,
    field: Field,
    scales: AxisScales,
}

impl<'a> ChartLayout<'a> {
    fn new(chart: &'a Chart, cell: Field) -> Result<Self, PlotError> {
        let top = if chart.title.is_empty() { 18.0 } else { 42.0 };
        let whole = Field {
            from: PixelPoint { x: cell.from.x + 86.0, y: cell.from.y + top },
            to: PixelPoint { x: cell.to.x - 22.0, y: cell.to.y - 58.0 },
        };
        let margin_panel = chart.margin_panel.as_ref().map(|margin_panel| PanelLayout::of(margin_panel, whole));
        let field = margin_panel.as_ref().map_or(whole, PanelLayout::rest);
        Ok(ChartLayout { chart, margin_panel, whole, field, scales: scales(chart, field)? })
    }

    fn area(&self) -> PlotArea {
        let share = MOST_POINTS.min(MOST_POINTS_OF_ALL / self.chart.lines.len().max(1));
        PlotArea::new(self.chart, self.scales, self.field, share)
    }

    fn draw(&self, canvas: &mut Canvas, looks: &[LineStyle]) {
        let (chart, whole, area) = (self.chart, self.whole, self.area());
        let middle = f64::midpoint(whole.from.x, whole.to.x);
        // A little into the margins of the chart, and not into its neighbours.
        let letters = fitting(&chart.title, LETTERS[0], whole.to.x - whole.from.x + 30.0);
        canvas.write(&chart.title, letters, PixelPoint { x: middle, y: whole.from.y - 10.0 }, Anchor::Above);
        draw_axes(canvas, chart, self.scales, self.field);
        for (line, look) in chart.lines.iter().zip(looks) {
            canvas.tag("series", &line.series, |canvas| draw_line(canvas, line, *look, &area));
        }
        for note in &chart.notes {
            draw_note(canvas, note, &area);
        }
        if let Some(margin_panel) = &self.margin_panel {
            margin_panel.draw(canvas, [self.scales.x, self.scales.y]);
        }
    }
}

fn draw_note(canvas: &mut Canvas, note: &Note, area: &PlotArea) {
    let Some(place) = area.place(note.at) else { return };
    let PixelPoint { x, y } = area.spot(place);
    let (x, y, anchor) = match note.align {
        Align::Right => (x + 5.0, y - 9.0, Anchor::Start),
        Align::Left => (x - 5.0, y - 9.0, Anchor::End),
        Align::RightBelow => (x + 5.0, y + 10.0, Anchor::Start),
        Align::LeftBelow => (x - 5.0, y + 10.0, Anchor::End),
        Align::Above => (x, y - 4.0, Anchor::Above),
    };
    canvas.write(&note.text, LETTERS[2], PixelPoint { x, y }, anchor);
}

fn scales(chart: &Chart, field: Field) -> Result<AxisScales, PlotError> {
    let nothing = || PlotError::NothingToDraw { title: chart.title.clone() };
    let points = || chart.lines.iter().flat_map(shown_points);
    let placed = |scale: Scale, v: f64| v.is_finite() && (scale == Scale::Linear || v > 0.0);
    // A point that cannot be shown on one axis does not count for the range of the other.
    let drawable = || points().filter(|p| placed(chart.x.scale, p.0) && placed(chart.y.scale, p.1));
    let scale = |axis: &Axis, values: &mut dyn Iterator<Item = f64>| match axis.range {
        Some((low, high)) => AxisScale::between(axis.scale, low, high).ok_or_else(|| PlotError::BadRange {
            title: chart.title.clone(),
            axis: axis.label.clone(),
            low,
            high,
        }),
        None => AxisScale::around(axis.scale, values).ok_or_else(nothing),
    };
    // A chart with only a note or a margin panel is drawn, too.
    let has_texts = !chart.notes.is_empty() || chart.margin_panel.is_some();
    if !has_texts {
        drawable().next().ok_or_else(nothing)?;
    }
    let x = scale(&chart.x, &mut drawable().map(|p| p.0))?;
    let y = scale(&chart.y, &mut drawable().map(|p| p.1))?;
    if !chart.equal_units {
        return Ok(AxisScales { x, y });
    }
    let (across, down) = (field.to.x - field.from.x, field.to.y - field.from.y);
    let unit = (x.span() / across).max(y.span() / down);
    Ok(AxisScales { x: x.widened(unit * across), y: y.widened(unit * down) })
}

fn draw_axes(canvas: &mut Canvas, chart: &Chart, scales: AxisScales, field: Field) {
    let Field { from, to } = field;
    let (across, down) = (to.x - from.x, to.y - from.y);
    let ticks_x = scales.x.ticks((across / 70.0) as usize);
    let ticks_y = scales.y.ticks((down / 55.0) as usize);
    let ink = |label: &str| if label.is_empty() { FINE_GRID } else { GRID };
    for tick in &ticks_x.ticks {
        let x = from.x + tick.at * across;
        canvas.rule(PixelPoint { x, y: from.y }, PixelPoint { x, y: to.y }, ink(&tick.label));
        canvas.write(&tick.label, LETTERS[2], PixelPoint { x, y: to.y + 7.0 }, Anchor::Below);
    }
    for tick in &ticks_y.ticks {
        let y = to.y - tick.at * down;
        canvas.rule(PixelPoint { x: from.x, y }, PixelPoint { x: to.x, y }, ink(&tick.label));
        canvas.write(&tick.label, LETTERS[2], PixelPoint { x: from.x - 7.0, y }, Anchor::End);
    }
    canvas.frame(from, to);
    let below = PixelPoint { x: f64::midpoint(from.x, to.x), y: to.y + 32.0 };
    let counted = |label: &str, origin: f64| match origin {
        0.0 => label.to_owned(),
        _ if origin < 0.0 => format!("{label} + {}", -origin),
        _ => format!("{label} − {origin}"),
    };
    canvas.write(&counted(&chart.x.label, ticks_x.origin), LETTERS[1], below, Anchor::Below);
    let beside = PixelPoint { x: from.x - 64.0, y: f64::midpoint(from.y, to.y) };
    let label = counted(&chart.y.label, ticks_y.origin);
    canvas.write(&label, fitting(&label, LETTERS[1], down + 70.0), beside, Anchor::Upwards);
}

fn draw_line(canvas: &mut Canvas, line: &Line, look: LineStyle, area: &PlotArea) {
    let places = || line.points.iter().map(|p| area.place(*p));
    if look.stroke != Stroke::None {
        if look.stroke == Stroke::Filled {
            canvas.area(&places().flatten().map(|p| area.spot(p)).collect::<Vec<_>>(), look);
        }
        for piece in area.pieces(line) {
            let spots: Vec<PixelPoint> = piece.iter().map(|node| area.spot(node.at)).collect();
            let via: Vec<_> = piece.iter().skip(1).map(|node| node.via.map(|p| p.map(|p| area.spot(p)))).collect();
            canvas.line(&spots, &via, look);
        }
    }
    if look.marker != Marker::None {
        let within: Vec<UnitPoint> = places().flatten().filter(|p| inside(*p)).collect();
        if line.marks > 0 {
            let apart = within.len().div_ceil(line.marks).max(1);
            let spread = within.iter().skip(apart / 2).step_by(apart);
            return spread.for_each(|place| canvas.mark(area.spot(*place), look));
        }
        if line.runs.is_empty() || within.len() > area.share {
            thin(&within, area.share).into_iter().for_each(|place| canvas.mark(area.spot(place), look));
            return;
        }
        for (place, run) in places().zip(&line.runs) {
            if let Some(place) = place.filter(|p| inside(*p)) {
                canvas.tag("run", run, |canvas| canvas.mark(area.spot(place), look));
            }
        }
    }
}

/// The style of a label whose line is not known yet.
const PLAIN: LineStyle =
    LineStyle { color: 0, stroke: Stroke::Normal, marker: Marker::None, width: WIDTHS[0], covered: 0 };

/// Styles of all lines, in their order; `covered` has those that coincide with others.
fn looks(lines: &[Line], covered: &BTreeMap<LineKey<'_>, u32>) -> Vec<LineStyle> {
    let usual = lines.iter().filter(|l| l.stroke == Stroke::Normal).count();
    let (mut next, mut last, mut drawn, mut below) = (0, 0, 0, 0);
    let look = |line: &Line| {
        last = match line.color {
            Some(color) => color,
            None if line.label.is_empty() => last,
            None => next,
        };
        next = next.max(last + 1);
        if !line.label.is_empty() {
            below = covered.get(&key(line)).copied().unwrap_or(0);
        }
        let covered = if line.stroke == Stroke::Normal { below } else { 0 };
        let [widest, narrowest] = if usual > 1 { WIDTHS } else { [1.8, 1.8] };
        let width = widest + (narrowest - widest) * f64::from(drawn) / usual.saturating_sub(1).max(1) as f64;
        drawn += u32::from(line.stroke == Stroke::Normal);
        LineStyle { color: last, stroke: line.stroke, marker: line.marker, width: width.max(narrowest), covered }
    };
    lines.iter().map(look).collect()
}
