//! Lines on the axes of a chart: their pieces inside the frame, and which lines cover others.

use super::axis::AxisScale;
use super::canvas::{Field, PixelPoint};
use super::chart::{Chart, Line, Marker, Scale, Stroke};
use super::decimate::{Node, UnitPoint, cut, thin};
use crate::model::state::State;
use crate::output::hermite::interpolate;
use std::collections::BTreeMap;

/// Straight pieces for a cubic that cannot be drawn as one.
const STRAIGHTS: u32 = 16;
/// [px] Lines nearer than this cannot be told apart …
const NEAR: f64 = 1.0;
/// … and one hides the other if this share of its points is as near.
const HIDDEN: f64 = 0.95;
/// Points of a line that are looked at for it, and lines of a chart.
const LOOKED_AT: usize = 200;
const LINES: usize = 32;

/// Both axes of a chart.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisScales {
    pub x: AxisScale,
    pub y: AxisScale,
}

/// The area and axes for lines.
pub(super) struct PlotArea {
    pub scales: AxisScales,
    pub field: Field,
    /// most points of a line
    pub share: usize,
    /// whether equal differences have equal lengths on both axes, so that cubics remain cubics
    linear: bool,
}

impl PlotArea {
    pub(super) fn new(chart: &Chart, scales: AxisScales, field: Field, share: usize) -> Self {
        let linear = [&chart.x, &chart.y].iter().all(|axis| axis.scale == Scale::Linear);
        PlotArea { scales, field, share, linear }
    }

    pub(super) fn place(&self, (x, y): (f64, f64)) -> Option<UnitPoint> {
        Some((self.scales.x.place(x)?, self.scales.y.place(y)?))
    }

    pub(super) fn spot(&self, (across, up): UnitPoint) -> PixelPoint {
        let Field { from, to } = self.field;
        PixelPoint { x: from.x + across * (to.x - from.x), y: to.y - up * (to.y - from.y) }
    }

    /// The parts of a line inside the frame, with as many points as can be told apart.
    pub(super) fn pieces(&self, line: &Line) -> Vec<Vec<Node>> {
        let pieces = cut(self.nodes(line));
        let all: usize = pieces.iter().map(Vec::len).sum();
        let few = |piece: Vec<Node>| {
            let share = (self.share * piece.len()).div_ceil(all.max(1)).max(8);
            if piece.len() <= share {
                return piece;
            }
            // So many points lie within a pixel of each other, and straight lines between them will do.
            let places: Vec<UnitPoint> = piece.iter().map(|node| node.at).collect();
            thin(&places, share).into_iter().map(Node::from).collect()
        };
        pieces.into_iter().map(few).collect()
    }

    fn nodes(&self, line: &Line) -> Vec<Option<Node>> {
        let mut nodes = Vec::with_capacity(line.points.len());
        for (i, &to) in line.points.iter().enumerate() {
            let end = self.place(to);
            let cubic = i.checked_sub(1).and_then(|i| Cubic::of(line, i));
            let Some(cubic) = cubic else {
                nodes.push(end.map(Node::from));
                continue;
            };
            let inside = |place: &UnitPoint| super::decimate::inside(*place);
            let controls = cubic.controls().map(|at| self.place(at).filter(inside));
            match (controls, end.filter(inside)) {
                // A cubic is within the hull of its control points.
                ([Some(first), Some(second)], Some(at)) if self.linear && self.place(cubic.ends[0]).is_some() => {
                    nodes.push(Some(Node { at, via: Some([first, second]) }));
                }
                _ => {
                    nodes.extend(cubic.inner(STRAIGHTS).map(|at| self.place(at).map(Node::from)));
                    nodes.push(end.map(Node::from));
                }
            }
        }
        nodes
    }

    /// [px] A line as a polygonal line, its pieces one after the other.
    fn polygon(&self, line: &Line) -> Vec<PixelPoint> {
        let mut points = Vec::new();
        for node in self.pieces(line).into_iter().flatten() {
            let end = self.spot(node.at);
            if let (Some([first, second]), Some(&from)) = (node.via, points.last()) {
                let [first, second] = [first, second].map(|at| self.spot(at));
                let tangent = |a: PixelPoint, b: PixelPoint| (3.0 * (b.x - a.x), 3.0 * (b.y - a.y));
                let ends = [from, end].map(|p: PixelPoint| (p.x, p.y));
                let cubic = Cubic { ends, tangents: [tangent(from, first), tangent(second, end)] };
                points.extend(cubic.inner(STRAIGHTS / 2).map(|(x, y)| PixelPoint { x, y }));
            }
            points.push(end);
        }
        points
    }
}

/// A cubic by its ends and the derivatives there.
#[derive(Clone, Copy, Debug)]
struct Cubic {
    ends: [(f64, f64); 2],
    tangents: [(f64, f64); 2],
}

impl Cubic {
    /// The piece of a line after a point, if it is one.
    fn of(line: &Line, i: usize) -> Option<Self> {
        let ends = [*line.points.get(i)?, *line.points.get(i + 1)?];
        let tangents = *line.tangents.get(i)?;
        let finite = ends.iter().chain(&tangents).all(|(x, y)| x.is_finite() && y.is_finite());
        finite.then_some(Cubic { ends, tangents })
    }

    /// Its inner control points in the form of Bézier.
    fn controls(&self) -> [(f64, f64); 2] {
        let ([(x0, y0), (x1, y1)], [(u0, v0), (u1, v1)]) = (self.ends, self.tangents);
        [(x0 + u0 / 3.0, y0 + v0 / 3.0), (x1 - u1 / 3.0, y1 - v1 / 3.0)]
    }

    /// Points between its ends, for so many straight pieces.
    fn inner(self, straights: u32) -> impl Iterator<Item = (f64, f64)> {
        let state = |t, (x, y), (u, v)| State { t, x: vec![x, y], v: vec![u, v] };
        let from = state(0.0, self.ends[0], self.tangents[0]);
        let to = state(1.0, self.ends[1], self.tangents[1]);
        let mut at = from.clone();
        (1..straights).map(move |i| {
            interpolate(from.as_ref(), to.as_ref(), f64::from(i) / f64::from(straights), &mut at);
            (at.x[0], at.x[1])
        })
    }
}

/// All points that the range of an axis should include: those of a line, and points on its cubics.
pub(super) fn shown_points(line: &Line) -> impl Iterator<Item = (f64, f64)> {
    let cubics = (0..line.tangents.len()).filter_map(|i| Cubic::of(line, i));
    line.points.iter().copied().chain(cubics.flat_map(|cubic| cubic.inner(STRAIGHTS / 2)))
}

/// What tells lines apart in all charts of a picture: label and colour.
pub(super) type LineKey<'a> = (&'a str, Option<usize>);

pub(super) fn key(line: &Line) -> LineKey<'_> {
    (&line.label, line.color)
}

/// For lines that coincide with earlier ones in some chart, the number of these.
pub(super) fn covered<'a>(charts: impl Iterator<Item = (&'a Chart, PlotArea)>) -> BTreeMap<LineKey<'a>, u32> {
    let mut found: BTreeMap<LineKey<'_>, u32> = BTreeMap::new();
    for (chart, area) in charts {
        let bare = |line: &Line| line.marker == Marker::None || line.marks > 0;
        let usual = |line: &&Line| line.stroke == Stroke::Normal && bare(line) && !line.label.is_empty();
        let lines: Vec<_> = chart.lines.iter().filter(usual).take(LINES).map(|l| (l, area.polygon(l))).collect();
        for (i, (line, points)) in lines.iter().enumerate() {
            let count = lines.iter().take(i).filter(|(_, below)| hides(points, below)).count() as u32;
            if count > 0 {
                let most = found.entry(key(line)).or_default();
                *most = count.max(*most);
            }
        }
    }
    found
}

/// Whether a line hides another one: whether nearly all its points are as near to it as a pixel.
fn hides(line: &[PixelPoint], below: &[PixelPoint]) -> bool {
    let stride = line.len().div_ceil(LOOKED_AT).max(1);
    let all = line.len().div_ceil(stride);
    let most_apart = ((1.0 - HIDDEN) * all as f64) as usize;
    let apart = |p: &&PixelPoint| !below.windows(2).any(|ends| matches!(ends, [a, b] if distance(**p, *a, *b) < NEAR));
    line.len() > 1 && line.iter().step_by(stride).filter(apart).take(most_apart + 1).count() <= most_apart
}

/// [px] from a point to a straight line between two others.
fn distance(p: PixelPoint, a: PixelPoint, b: PixelPoint) -> f64 {
    let (ux, uy) = (b.x - a.x, b.y - a.y);
    let square = ux * ux + uy * uy;
    let s = if square > 0.0 { (((p.x - a.x) * ux + (p.y - a.y) * uy) / square).clamp(0.0, 1.0) } else { 0.0 };
    (a.x + s * ux - p.x).hypot(a.y + s * uy - p.y)
}
