//! The margin panel of a chart: marks along one axis that have no value on the other, such as runs without an error.

use super::axis::AxisScale;
use super::canvas::{Anchor, Canvas, Field, GRID, LETTERS, LineStyle, PixelPoint};
use super::chart::{MarginPanel, PanelSide, Stroke};

/// [px] least distance of two marks, so that they do not touch
const PITCH: f64 = 12.0;
/// [px] between the chart and the panel
const GAP: f64 = 8.0;
/// Fewest and most lanes of marks.
const LANES: [usize; 2] = [6, 16];
/// [-] largest share of the panel's length for marks without a place
const WITHOUT: f64 = 0.6;

/// Layout of a margin panel.
pub(super) struct PanelLayout<'a> {
    margin_panel: &'a MarginPanel,
    field: Field,
    rest: Field,
    lanes: usize,
}

impl<'a> PanelLayout<'a> {
    /// Takes the space of the panel from the picture.
    pub(super) fn of(margin_panel: &'a MarginPanel, whole: Field) -> Self {
        let length = match margin_panel.side {
            PanelSide::Right => whole.to.y - whole.from.y,
            PanelSide::Top => whole.to.x - whole.from.x,
        };
        let (mut field, mut rest) = (whole, whole);
        // Half empty, so that most marks are at their own value.
        let lanes = (2.0 * margin_panel.marks.len() as f64 * PITCH / length.max(PITCH)).ceil() as usize;
        let lanes = match margin_panel.side {
            PanelSide::Right => lanes.clamp(LANES[0], LANES[1]),
            PanelSide::Top => lanes.clamp(2, LANES[0]),
        };
        let width = lanes as f64 * PITCH;
        match margin_panel.side {
            PanelSide::Right => {
                field.from.x = whole.to.x - width;
                rest.to.x = field.from.x - GAP;
            }
            PanelSide::Top => {
                field.to.y = whole.from.y + width;
                rest.from.y = field.to.y + GAP;
            }
        }
        PanelLayout { margin_panel, field, rest, lanes }
    }

    /// The rest of the picture, for the chart.
    pub(super) fn rest(&self) -> Field {
        self.rest
    }

    /// Draws the panel; uses the scale of the axis along which it is.
    pub(super) fn draw(&self, canvas: &mut Canvas, [x, y]: [AxisScale; 2]) {
        let Field { from, to } = self.field;
        let right = self.margin_panel.side == PanelSide::Right;
        let (scale, length) = if right { (y, to.y - from.y) } else { (x, to.x - from.x) };
        let places: Vec<_> = self.margin_panel.marks.iter().map(|m| (m, m.at.and_then(|at| scale.place(at)))).collect();
        let without = places.iter().filter(|(_, place)| place.is_none()).count();
        let band = (without.div_ceil(self.lanes) as f64 * PITCH).min(WITHOUT * length);
        // From the panel's lower end on, in the direction of the axis.
        let spot = |along: f64, lane: usize| {
            let across = (lane as f64 + 0.5) * PITCH;
            if right {
                PixelPoint { x: from.x + across, y: to.y - along }
            } else {
                PixelPoint { x: from.x + along, y: to.y - across }
            }
        };
        if without > 0 {
            let [a, b] = if right {
                [PixelPoint { x: from.x, y: to.y - band }, PixelPoint { x: to.x, y: to.y - band }]
            } else {
                [PixelPoint { x: from.x + band, y: from.y }, PixelPoint { x: from.x + band, y: to.y }]
            };
            canvas.rule(a, b, GRID);
        }
        canvas.frame(from, to);
        let (label, anchor) = if right {
            (PixelPoint { x: f64::midpoint(from.x, to.x), y: to.y + 7.0 }, Anchor::Below)
        } else {
            (PixelPoint { x: from.x - 7.0, y: f64::midpoint(from.y, to.y) }, Anchor::End)
        };
        canvas.write(&self.margin_panel.label, LETTERS[2], label, anchor);
        let mut lower = Lanes::new(self.lanes, [0.0, band]);
        let mut upper = Lanes::new(self.lanes, [if without > 0 { band } else { 0.0 }, length]);
        for (mark, place) in places {
            let (along, lane) = match place {
                Some(share) => upper.free_place(share.clamp(0.0, 1.0) * length),
                None => lower.free_place(0.0),
            };
            let look =
                LineStyle { color: mark.color, stroke: Stroke::None, marker: mark.marker, width: 1.0, covered: 0 };
            canvas.tag("series", &mark.series, |canvas| {
                canvas.tag("run", &mark.run, |canvas| canvas.mark(spot(along, lane), look));
            });
        }
    }
}

/// Lanes side by side, with marks that do not cover each other as long as there is space.
struct Lanes {
    /// [px] occupied positions, lane by lane
    taken: Vec<Vec<f64>>,
    /// [px] first and last position
    ends: [f64; 2],
}

impl Lanes {
    fn new(count: usize, [low, high]: [f64; 2]) -> Self {
        let (low, high) = (low + 0.5 * PITCH, high - 0.5 * PITCH);
        Lanes { taken: vec![Vec::new(); count.max(1)], ends: [low, high.max(low)] }
    }

    /// The free position nearest to the wanted one, and its lane.
    fn free_place(&mut self, wanted: f64) -> (f64, usize) {
        let [low, high] = self.ends;
        let wanted = wanted.clamp(low, high);
        let shifts = (0..=((high - low) / PITCH).ceil() as i32 + 1).flat_map(|k| [f64::from(k), -f64::from(k)]);
        for along in shifts.map(|k| wanted + k * PITCH).filter(|a| (low - 1e-6..=high + 1e-6).contains(a)) {
            let free = |taken: &Vec<f64>| taken.iter().all(|t| (t - along).abs() >= PITCH - 1e-6);
            // From the middle outwards, so that few marks are away from the frame.
            let middle = self.taken.len().saturating_sub(1) as i64;
            let lanes = self.taken.iter_mut().enumerate().filter(|(_, taken)| free(taken));
            if let Some((lane, taken)) = lanes.min_by_key(|(lane, _)| (2 * *lane as i64 - middle).abs()) {
                taken.push(along);
                return (along, lane);
            }
        }
        // Full: further marks may cover others.
        (wanted, 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Marks at one position fill the lanes first, then the positions next to it; none covers another, and none leaves
    /// the panel.
    #[test]
    fn marks_are_moved_apart() {
        let mut lanes = Lanes::new(3, [0.0, 120.0]);
        let first: Vec<_> = (0..3).map(|_| lanes.free_place(60.0)).collect();
        assert_eq!(first, [(60.0, 1), (60.0, 0), (60.0, 2)]);
        let mut all = first;
        all.extend((0..21).map(|_| lanes.free_place(60.0)));
        for (i, a) in all.iter().enumerate() {
            assert!((6.0..=114.0).contains(&a.0), "{a:?}");
            for b in &all[..i] {
                assert!(a.1 != b.1 || (a.0 - b.0).abs() >= PITCH - 1e-6, "{a:?} covers {b:?}");
            }
        }
        assert_eq!(lanes.free_place(-5.0).0, 6.0, "beyond the end stands at the end");
    }
}
