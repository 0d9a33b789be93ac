//! The drawing of a picture: units, colours, letters, lines, marks. A picture is SVG text.
//!
//! Coordinates are whole numbers of tenths of a pixel: short, and finer than any screen.

use super::chart::{Marker, Size, Stroke};
use crate::vtk::xml_attribute;
use std::fmt::Write as _;

/// Drawing units per pixel.
const FINE: f64 = 10.0;
/// [px] letter size of titles, axis labels and other text
pub(super) const LETTERS: [f64; 3] = [16.0, 14.0, 13.0];

/// A colour in SVG.
pub(super) type Ink = &'static str;
/// Axes and their numbers.
pub(super) const INK: Ink = "#333333";
/// The grid.
pub(super) const GRID: Ink = "#E2E2E2";
/// The fine grid of logarithmic axes.
pub(super) const FINE_GRID: Ink = "#F1F1F1";

/// Colours that colour-blind people can distinguish (Okabe & Ito 2008), without the yellow, which is too pale for lines
/// on white.
/// After black, colours for pictures with more curves than these seven: of Tol's muted scheme (2021), and a grey.
const PALETTE: [Ink; 16] = [
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#882255", "#117733", "#332288",
    "#999933", "#AA4499", "#661100", "#44AA99", "#888888", "#CC6677",
];

/// Length of a dash and a gap of lines that coincide with others, in drawing units.
const COVERING: u32 = 220;

/// [px] Size of marks; corners are given in it.
const MARK: f64 = 9.0;
/// Looks as large as the disc, like all marks with corners.
const SQUARE: [(f64, f64); 4] = [(-0.36, -0.36), (0.36, -0.36), (0.36, 0.36), (-0.36, 0.36)];
/// Pointing up.
const TRIANGLE: [(f64, f64); 3] = [(0.0, -0.55), (0.48, 0.34), (-0.48, 0.34)];
const DIAMOND: [(f64, f64); 4] = [(0.0, -0.54), (0.46, 0.0), (0.0, 0.54), (-0.46, 0.0)];
/// A star: five points at multiples of 72 degrees, and the corners between them.
const STAR: [(f64, f64); 10] = [
    (0.0, -0.65),
    (0.16, -0.22),
    (0.618, -0.201),
    (0.26, 0.085),
    (0.382, 0.526),
    (0.0, 0.273),
    (-0.382, 0.526),
    (-0.26, 0.085),
    (-0.618, -0.201),
    (-0.16, -0.22),
];

/// The style of a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct LineStyle {
    /// number in the palette; after its end, the colours repeat with dashes
    pub color: usize,
    /// how points are joined
    pub stroke: Stroke,
    /// the mark at each point
    pub marker: Marker,
    /// [px] width of the usual line
    pub width: f64,
    /// number of earlier lines that this one coincides with: it is dashed, so that they are seen between its dashes
    pub covered: u32,
}

impl LineStyle {
    fn ink(&self) -> Ink {
        PALETTE[self.color % PALETTE.len()]
    }

    /// Whether both have the same colour, stroke and marks.
    pub(super) fn shows_as(&self, other: LineStyle) -> bool {
        (self.color, self.stroke, self.marker) == (other.color, other.stroke, other.marker)
    }

    /// Lengths of dashes and gaps. Where several lines coincide, each has half the dashes of the one below it, from the
    /// same points on.
    fn dashes(&self) -> String {
        let beyond_palette = self.stroke == Stroke::Normal && self.color / PALETTE.len() % 2 == 1;
        let (dash, gap) = match self.covered {
            0 if self.stroke != Stroke::Dashed && !beyond_palette => return String::new(),
            0 => (80, 50),
            n => (COVERING >> n.min(4), COVERING - (COVERING >> n.min(4))),
        };
        format!(" stroke-dasharray=\"{dash} {gap}\"")
    }
}

/// A point of the picture [px], from its upper left corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PixelPoint {
    /// to the right
    pub x: f64,
    /// downwards
    pub y: f64,
}

/// A rectangle of the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Field {
    /// upper left corner
    pub(super) from: PixelPoint,
    /// lower right corner
    pub(super) to: PixelPoint,
}

/// Position of a text relative to its point.
#[derive(Clone, Copy, Debug)]
pub(super) enum Anchor {
    /// starts there, vertically centred
    Start,
    /// ends there, vertically centred
    End,
    /// centred above it
    Above,
    /// centred below it
    Below,
    /// centred on it, rotated to be read upwards
    Upwards,
}

/// A picture that is being drawn.
pub(super) struct Canvas {
    svg: String,
    /// whether elements say to which series and run they belong
    tagged: bool,
}

impl Canvas {
    /// A white picture; in a `tagged` one elements say to which series and run they belong.
    pub(super) fn new(Size { width, height }: Size, tagged: bool) -> Self {
        let mut canvas = Self::plain(Size { width, height });
        let [w, h] = [width, height].map(|length| fine(f64::from(length)));
        canvas.element("rect", format_args!("x=\"0\" y=\"0\" width=\"{w}\" height=\"{h}\" fill=\"#FFFFFF\""));
        canvas.tagged = tagged;
        canvas
    }

    /// A picture without a ground.
    pub(super) fn plain(Size { width, height }: Size) -> Self {
        let [w, h] = [width, height].map(|length| fine(f64::from(length)));
        let svg = format!(
            "<svg width=\"{width}\" height=\"{height}\" stroke-linejoin=\"round\" stroke-linecap=\"round\" \
             viewBox=\"0 0 {w} {h}\" xmlns=\"http://www.w3.org/2000/svg\">\n"
        );
        Canvas { svg, tagged: false }
    }

    /// The picture.
    pub(super) fn finish(self) -> String {
        self.svg + "</svg>\n"
    }

    /// Draws something that belongs to a series or a run: `kind` says which, `name` is empty for what belongs to none.
    pub(super) fn tag(&mut self, kind: &str, name: &str, draw: impl FnOnce(&mut Self)) {
        if !self.tagged || name.is_empty() {
            return draw(self);
        }
        let _ = writeln!(self.svg, "<g data-{kind}=\"{}\">", xml_attribute(name));
        draw(self);
        self.svg.push_str("</g>\n");
    }

    /// An element without content. Writing to a String cannot fail.
    fn element(&mut self, name: &str, attributes: std::fmt::Arguments<'_>) {
        let _ = writeln!(self.svg, "<{name} {attributes}/>");
    }

    fn polyline(&mut self, points: &[PixelPoint], ink: Ink, width: f64, more: &str) {
        let (stroke, points) = (stroke(ink, width), listed(points));
        self.element("polyline", format_args!("fill=\"none\" {stroke}{more} points=\"{points}\""));
    }

    fn polygon(&mut self, corners: &[PixelPoint], ink: Ink, more: &str) {
        let points = listed(corners);
        self.element("polygon", format_args!("fill=\"{ink}\"{more} points=\"{points}\""));
    }

    /// A thin straight line of the frame or the grid.
    pub(super) fn rule(&mut self, from: PixelPoint, to: PixelPoint, ink: Ink) {
        self.polyline(&[from, to], ink, 1.0, "");
    }

    /// The outline of a rectangle.
    pub(super) fn frame(&mut self, from: PixelPoint, to: PixelPoint) {
        let corners = [(from.x, from.y), (to.x, from.y), (to.x, to.y), (from.x, to.y), (from.x, from.y)];
        self.polyline(&corners.map(|(x, y)| PixelPoint { x, y }), INK, 1.0, "");
    }

    /// A piece of a line; `via` has the control points of the cubic that leads to each of its points but the first, or
    /// is empty.
    pub(super) fn line(&mut self, points: &[PixelPoint], via: &[Option<[PixelPoint; 2]>], look: LineStyle) {
        let width = match look.stroke {
            Stroke::None => return,
            Stroke::Thin => 0.7,
            Stroke::Fine => 1.0,
            Stroke::Dashed => 1.6,
            Stroke::Normal | Stroke::Filled => look.width,
        };
        let pale = if look.stroke == Stroke::Thin { " opacity=\"0.6\"" } else { "" };
        let more = format!("{pale}{}", look.dashes());
        if via.iter().all(Option::is_none) {
            return self.polyline(points, look.ink(), width, &more);
        }
        let mut path = String::new();
        for (i, point) in points.iter().enumerate() {
            let end = listed(&[*point]);
            let _ = match i.checked_sub(1).map(|before| via.get(before)) {
                None => write!(path, "M {end}"),
                Some(Some(Some(controls))) => write!(path, "C {}{end}", listed(controls)),
                Some(_) => write!(path, "L {end}"),
            };
        }
        let stroke = stroke(look.ink(), width);
        self.element("path", format_args!("fill=\"none\" {stroke}{more} d=\"{path}\""));
    }

    /// A pale area inside a closed line.
    pub(super) fn area(&mut self, corners: &[PixelPoint], look: LineStyle) {
        self.polygon(corners, look.ink(), " opacity=\"0.16\"");
    }

    /// The mark of a line at a point.
    pub(super) fn mark(&mut self, at: PixelPoint, look: LineStyle) {
        let ink = look.ink();
        let (x, y) = (fine(at.x), fine(at.y));
        match look.marker {
            Marker::None => {}
            Marker::Dot => self.element("circle", format_args!("cx=\"{x}\" cy=\"{y}\" r=\"32\" fill=\"{ink}\"")),
            Marker::Ring => {
                let stroke = stroke(ink, 1.8);
                self.element("circle", format_args!("cx=\"{x}\" cy=\"{y}\" r=\"50\" fill=\"none\" {stroke}"));
            }
            Marker::Cross => {
                let (stroke, left, right) = (stroke(ink, 2.2), x - 48, x + 48);
                for (y1, y2) in [(y - 48, y + 48), (y + 48, y - 48)] {
                    self.element("line", format_args!("{stroke} x1=\"{left}\" y1=\"{y1}\" x2=\"{right}\" y2=\"{y2}\""));
                }
            }
            Marker::Plus => {
                self.polyline(&around(at, &[(-0.55, 0.0), (0.55, 0.0)]), ink, 2.0, "");
                self.polyline(&around(at, &[(0.0, -0.55), (0.0, 0.55)]), ink, 2.0, "");
            }
            Marker::Tick => self.polyline(&around(at, &[(0.0, -0.45), (0.0, 0.45)]), ink, 2.0, ""),
            Marker::Bar => self.polyline(&around(at, &[(-0.4, 0.0), (0.4, 0.0)]), ink, 2.0, ""),
            Marker::Square | Marker::OpenSquare => self.shape(at, &SQUARE, look),
            Marker::Triangle | Marker::OpenTriangle => self.shape(at, &TRIANGLE, look),
            Marker::TriangleDown | Marker::OpenTriangleDown => self.shape(at, &TRIANGLE.map(|(x, y)| (x, -y)), look),
            Marker::Diamond | Marker::OpenDiamond => self.shape(at, &DIAMOND, look),
            Marker::Star | Marker::OpenStar => self.shape(at, &STAR, look),
        }
    }

    /// A mark with corners: filled, or an outline.
    fn shape(&mut self, at: PixelPoint, corners: &[(f64, f64)], look: LineStyle) {
        use Marker::{OpenDiamond, OpenSquare, OpenStar, OpenTriangle, OpenTriangleDown};
        let (ink, mut corners) = (look.ink(), around(at, corners));
        if matches!(look.marker, OpenSquare | OpenTriangle | OpenTriangleDown | OpenDiamond | OpenStar) {
            corners.extend(corners.first().copied());
            self.polyline(&corners, ink, 1.6, "");
        } else {
            self.polygon(&corners, ink, "");
        }
    }

    /// A text of a size [px].
    pub(super) fn write(&mut self, text: &str, size: f64, spot: PixelPoint, anchor: Anchor) {
        let (anchored, down) = match anchor {
            Anchor::Start => ("start", "0.5ex"),
            Anchor::End => ("end", "0.5ex"),
            Anchor::Above | Anchor::Upwards => ("middle", "-0.5ex"),
            Anchor::Below => ("middle", "0.76em"),
        };
        let (x, y, size, text) = (fine(spot.x), fine(spot.y), fine(size), xml_attribute(text));
        let turn = if matches!(anchor, Anchor::Upwards) { 270 } else { 0 };
        let _ = writeln!(
            self.svg,
            "<text x=\"{x}\" y=\"{y}\" dy=\"{down}\" text-anchor=\"{anchored}\" font-family=\"sans-serif\" font-size=\"{size}\" \
             fill=\"{INK}\" transform=\"rotate({turn}, {x}, {y})\">{text}</text>"
        );
    }
}

/// The corners of a mark, given in mark sizes from its middle.
fn around(at: PixelPoint, corners: &[(f64, f64)]) -> Vec<PixelPoint> {
    corners.iter().map(|(x, y)| PixelPoint { x: at.x + MARK * x, y: at.y + MARK * y }).collect()
}

fn stroke(ink: Ink, width: f64) -> String {
    format!("stroke=\"{ink}\" stroke-width=\"{}\"", fine(width))
}

fn listed(points: &[PixelPoint]) -> String {
    points.iter().map(|p| format!("{},{} ", fine(p.x), fine(p.y))).collect()
}

/// [px] Approximate width of a text; the font is that of the viewer.
pub(super) fn width_of(text: &str, size: f64) -> f64 {
    0.54 * size * text.chars().count() as f64
}

/// [px] The size of letters, at most `size`, with which a text fits into `room` [px], if they remain readable.
pub(super) fn fitting(text: &str, size: f64, room: f64) -> f64 {
    size * (room / width_of(text, size).max(1.0)).clamp(0.6, 1.0)
}

/// Pixels in drawing units.
fn fine(pixels: f64) -> i64 {
    (pixels * FINE).round() as i64
}
