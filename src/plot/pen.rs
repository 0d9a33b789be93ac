//! What everything in a picture is drawn with: units, colours, letters, lines, marks.
//!
//! plotters counts in whole pixels; a picture is therefore drawn [`FINE`] times larger, and the SVG's header says how large it is shown.

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

/// Colours that colour-blind people tell apart (Okabe & Ito 2008), without the yellow, which is too pale for lines on white.
const PALETTE: [RGBColor; 7] = [
    RGBColor(0x00, 0x72, 0xB2),
    RGBColor(0xD5, 0x5E, 0x00),
    RGBColor(0x00, 0x9E, 0x73),
    RGBColor(0xCC, 0x79, 0xA7),
    RGBColor(0xE6, 0x9F, 0x00),
    RGBColor(0x56, 0xB4, 0xE9),
    RGBColor(0x00, 0x00, 0x00),
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

/// A picture under the pen.
pub(super) struct Pen<'a> {
    area: DrawingArea<SVGBackend<'a>, Shift>,
}

impl<'a> Pen<'a> {
    /// A white picture whose text goes to `text`.
    pub(super) fn new(text: &'a mut String, size: Size) -> Result<Self, PlotError> {
        let area = SVGBackend::with_string(text, (fine_u(size.width), fine_u(size.height))).into_drawing_area();
        area.fill(&RGBColor(0xFF, 0xFF, 0xFF)).map_err(refused)?;
        Ok(Pen { area })
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
