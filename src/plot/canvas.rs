//! What everything in a picture is drawn with: units, colours, letters, lines, marks.
//!
//! plotters counts in whole pixels; a picture is therefore drawn [`FINE`] times larger, and the SVG's header says how
//! large it is shown.

use super::PlotError;
use super::chart::{Marker, Size, Stroke};
use plotters::coord::Shift;
use plotters::element::{Circle, Cross, DashedPathElement, PathElement, Polygon};
use plotters::prelude::{DrawingArea, IntoDrawingArea, IntoTextStyle, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontTransform, RGBColor, ShapeStyle, TextStyle};

/// Drawing units a pixel.
pub(super) const FINE: f64 = 10.0;
/// [px] letters of titles, axis labels and everything else
pub(super) const LETTERS: [f64; 3] = [16.0, 14.0, 13.0];
/// Axes and their numbers.
pub(super) const INK: RGBColor = RGBColor(0x33, 0x33, 0x33);
/// The grid.
pub(super) const GRID: RGBColor = RGBColor(0xE2, 0xE2, 0xE2);
/// The fine grid of logarithmic axes.
pub(super) const FINE_GRID: RGBColor = RGBColor(0xF1, 0xF1, 0xF1);

/// Colours that colour-blind people tell apart (Okabe & Ito 2008), without the yellow, which is too pale for lines on
/// white.
const PALETTE: [RGBColor; 7] = [
    RGBColor(0x00, 0x72, 0xB2),
    RGBColor(0xD5, 0x5E, 0x00),
    RGBColor(0x00, 0x9E, 0x73),
    RGBColor(0xCC, 0x79, 0xA7),
    RGBColor(0xE6, 0x9F, 0x00),
    RGBColor(0x56, 0xB4, 0xE9),
    RGBColor(0x00, 0x00, 0x00),
];

/// [px] Size of marks; corners are given in it.
const MARK: f64 = 9.0;
/// As large to the eye as the disc, like all marks with corners.
const SQUARE: [(f64, f64); 4] = [(-0.36, -0.36), (0.36, -0.36), (0.36, 0.36), (-0.36, 0.36)];
/// Pointing up.
const TRIANGLE: [(f64, f64); 3] = [(0.0, -0.55), (0.48, 0.34), (-0.48, 0.34)];
const DIAMOND: [(f64, f64); 4] = [(0.0, -0.54), (0.46, 0.0), (0.0, 0.54), (-0.46, 0.0)];
/// Five points at every 72 degrees, and the corners between them.
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

/// How a line looks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    /// number in the palette; where that ends, it begins again with dashes
    pub color: usize,
    /// how points are joined
    pub stroke: Stroke,
    /// what stands at each point
    pub marker: Marker,
    /// [px] width of the usual line
    pub width: f64,
}

impl Look {
    fn ink(&self) -> RGBColor {
        PALETTE[self.color % PALETTE.len()]
    }

    fn dashed(&self) -> bool {
        self.stroke == Stroke::Dashed || (self.stroke == Stroke::Normal && self.color / PALETTE.len() % 2 == 1)
    }
}

/// A place in the picture [px], from its upper left corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spot {
    /// to the right
    pub x: f64,
    /// downwards
    pub y: f64,
}

/// Where the letters stand from their spot.
#[derive(Clone, Copy, Debug)]
pub(super) enum Anchor {
    /// begin there, on a line through their middle
    Start,
    /// end there, on a line through their middle
    End,
    /// centred above it
    Above,
    /// centred below it
    Below,
    /// centred on it, read from below
    Upwards,
}

/// The SVG picture that is drawn on.
pub(super) struct Canvas<'a> {
    area: DrawingArea<SVGBackend<'a>, Shift>,
}

impl<'a> Canvas<'a> {
    /// A white picture whose text goes to `text`.
    pub(super) fn new(text: &'a mut String, size: Size) -> Result<Self, PlotError> {
        let area = SVGBackend::with_string(text, (fine_u(size.width), fine_u(size.height))).into_drawing_area();
        area.fill(&RGBColor(0xFF, 0xFF, 0xFF)).map_err(refused)?;
        Ok(Canvas { area })
    }

    /// Ends the picture.
    pub(super) fn finish(self) -> Result<(), PlotError> {
        self.area.present().map_err(refused)
    }

    /// A thin straight line of the frame or the grid.
    pub(super) fn rule(&self, from: Spot, to: Spot, ink: RGBColor) -> Result<(), PlotError> {
        self.area.draw(&PathElement::new(vec![fine(from), fine(to)], ink.stroke_width(10))).map_err(refused)
    }

    /// A rectangle without filling; as a line, because plotters' own SVG rectangles have no width of line.
    pub(super) fn frame(&self, from: Spot, to: Spot) -> Result<(), PlotError> {
        let corners = [(from.x, from.y), (to.x, from.y), (to.x, to.y), (from.x, to.y), (from.x, from.y)];
        let corners: Vec<_> = corners.map(|(x, y)| fine(Spot { x, y })).into();
        self.area.draw(&PathElement::new(corners, INK.stroke_width(10))).map_err(refused)
    }

    /// A piece of a line.
    pub(super) fn line(&self, points: &[Spot], look: Look) -> Result<(), PlotError> {
        let (width, alpha) = match look.stroke {
            Stroke::None => return Ok(()),
            Stroke::Thin => (7, 0.6),
            Stroke::Fine => (10, 1.0),
            Stroke::Dashed => (16, 1.0),
            Stroke::Normal | Stroke::Filled => ((look.width * FINE).round() as u32, 1.0),
        };
        let style: ShapeStyle = look.ink().mix(alpha).stroke_width(width);
        let points = points.iter().map(|p| fine(*p));
        if look.dashed() {
            self.area.draw(&DashedPathElement::new(points, 80, 50, style)).map_err(refused)
        } else {
            self.area.draw(&PathElement::new(points.collect::<Vec<_>>(), style)).map_err(refused)
        }
    }

    /// A pale area within a line that closes it.
    pub(super) fn area(&self, corners: &[Spot], look: Look) -> Result<(), PlotError> {
        let corners: Vec<_> = corners.iter().map(|p| fine(*p)).collect();
        self.area.draw(&Polygon::new(corners, look.ink().mix(0.16))).map_err(refused)
    }

    /// The mark of a line at a point.
    pub(super) fn mark(&self, spot: Spot, look: Look) -> Result<(), PlotError> {
        let (ink, at) = (look.ink(), fine(spot));
        match look.marker {
            Marker::None => Ok(()),
            Marker::Dot => self.area.draw(&Circle::new(at, 32, ink.filled())).map_err(refused),
            Marker::Ring => self.area.draw(&Circle::new(at, 50, ink.stroke_width(18))).map_err(refused),
            Marker::Cross => self.area.draw(&Cross::new(at, 48, ink.stroke_width(22))).map_err(refused),
            Marker::Plus => {
                self.stroke(spot, [(-0.55, 0.0), (0.55, 0.0)], ink)?;
                self.stroke(spot, [(0.0, -0.55), (0.0, 0.55)], ink)
            }
            Marker::Tick => self.stroke(spot, [(0.0, -0.45), (0.0, 0.45)], ink),
            Marker::Bar => self.stroke(spot, [(-0.4, 0.0), (0.4, 0.0)], ink),
            Marker::Square | Marker::OpenSquare => self.shape(spot, &SQUARE, look),
            Marker::Triangle | Marker::OpenTriangle => self.shape(spot, &TRIANGLE, look),
            Marker::TriangleDown | Marker::OpenTriangleDown => self.shape(spot, &TRIANGLE.map(|(x, y)| (x, -y)), look),
            Marker::Diamond | Marker::OpenDiamond => self.shape(spot, &DIAMOND, look),
            Marker::Star | Marker::OpenStar => self.shape(spot, &STAR, look),
        }
    }

    /// A short line of a mark, its ends in mark sizes from the middle.
    fn stroke(&self, spot: Spot, ends: [(f64, f64); 2], ink: RGBColor) -> Result<(), PlotError> {
        let ends = ends.map(|(x, y)| fine(Spot { x: spot.x + MARK * x, y: spot.y + MARK * y }));
        self.area.draw(&PathElement::new(ends.to_vec(), ink.stroke_width(20))).map_err(refused)
    }

    /// A mark with corners, filled or as an outline; corners in mark sizes from the middle.
    fn shape(&self, spot: Spot, corners: &[(f64, f64)], look: Look) -> Result<(), PlotError> {
        let open = matches!(
            look.marker,
            Marker::OpenSquare
                | Marker::OpenTriangle
                | Marker::OpenTriangleDown
                | Marker::OpenDiamond
                | Marker::OpenStar
        );
        let at = |(x, y): &(f64, f64)| fine(Spot { x: spot.x + MARK * x, y: spot.y + MARK * y });
        let points: Vec<_> = corners.iter().map(at).collect();
        if open {
            let closed: Vec<_> = points.iter().chain(points.first()).copied().collect();
            self.area.draw(&PathElement::new(closed, look.ink().stroke_width(16))).map_err(refused)
        } else {
            self.area.draw(&Polygon::new(points, look.ink().filled())).map_err(refused)
        }
    }

    /// Words of a size [px].
    pub(super) fn write(&self, text: &str, size: f64, spot: Spot, anchor: Anchor) -> Result<(), PlotError> {
        let (across, down) = match anchor {
            Anchor::Start => (HPos::Left, VPos::Center),
            Anchor::End => (HPos::Right, VPos::Center),
            Anchor::Above | Anchor::Upwards => (HPos::Center, VPos::Bottom),
            Anchor::Below => (HPos::Center, VPos::Top),
        };
        // plotters divides the size of letters by 1.24 on their way into the SVG.
        let style = ("sans-serif", size * FINE * 1.24).into_text_style(&self.area);
        let style = TextStyle { pos: Pos::new(across, down), color: INK.to_backend_color(), ..style };
        let style = match anchor {
            Anchor::Upwards => style.transform(FontTransform::Rotate270),
            _ => style,
        };
        self.area.draw_text(text, &style, fine(spot)).map_err(refused)
    }
}

/// [px] about how wide words are; SVG letters are the reader's, so nobody knows.
pub(super) fn width_of(text: &str, size: f64) -> f64 {
    0.54 * size * text.chars().count() as f64
}

fn fine(spot: Spot) -> (i32, i32) {
    ((spot.x * FINE).round() as i32, (spot.y * FINE).round() as i32)
}

fn fine_u(pixels: u32) -> u32 {
    pixels.saturating_mul(FINE as u32)
}

fn refused(error: impl std::fmt::Display) -> PlotError {
    PlotError::Drawing(error.to_string())
}
