//! The cruciform canopy: two strips of length L and width W that cross, S0 = 2 L W - W^2.

use super::assembly::{Assembly, Square};
use super::{ParachuteParameters, ParachuteSizes};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Sizes and counts of a cross.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cross {
    /// [m] length of a strip
    length: f64,
    /// [m] width of a strip
    width: f64,
    /// [-] cells along an arm
    along: usize,
    /// [-] cells across a strip
    across: usize,
    /// [-] cells between two lines
    between: usize,
}

impl Cross {
    pub(super) fn of(p: &ParachuteParameters) -> Self {
        let ratio = p.arm_ratio();
        let area = 0.25 * PI * p.d0() * p.d0();
        let length = (area / (ratio * (2.0 - ratio))).sqrt();
        let lines_per_end = p.gores / 4;
        let across = lines_per_end.saturating_sub(1).max(1) * p.gore_segments;
        Self { length, width: ratio * length, along: p.radial_segments, across, between: p.gore_segments }
    }

    pub(super) fn sizes(&self) -> ParachuteSizes {
        let area = self.width * (2.0 * self.length - self.width);
        let Self { length, .. } = *self;
        ParachuteSizes { nominal_area: area, cloth_area: area, constructed_diameter: length, gore_length: length }
    }

    /// Number of lines at each of the four ends.
    fn lines_per_end(&self) -> usize {
        self.across / self.between + 1
    }

    /// Number of cells from end to end.
    fn cells(&self) -> usize {
        2 * self.along + self.across
    }

    /// [m] Coordinate of a line of the grid, counted from an end.
    fn coordinate(&self, line: usize) -> f64 {
        let (half, arm) = (0.5 * self.width, 0.5 * (self.length - self.width));
        let last = self.cells();
        if line < self.along {
            -half - arm * (self.along - line) as f64 / self.along as f64
        } else if line > last - self.along {
            -self.coordinate(last - line)
        } else {
            half * ((line - self.along) as f64 * 2.0 / self.across as f64 - 1.0)
        }
    }

    /// Adds the canopy.
    pub(super) fn add_to(&self, parts: &mut Assembly) {
        let (last, strip) = (self.cells(), self.along..=self.along + self.across);
        let in_strip = |line: usize| strip.contains(&line);
        let mut numbers: BTreeMap<[usize; 2], u32> = BTreeMap::new();
        for y in 0..=last {
            for x in (0..=last).filter(|&x| in_strip(x) || in_strip(y)) {
                let node = parts.add_node(Vector3::new(self.coordinate(x), self.coordinate(y), 0.0));
                numbers.insert([x, y], node);
            }
        }
        let node = |x: usize, y: usize| numbers.get(&[x, y]).copied().unwrap_or_default();
        let cell_in_strip = |cell: usize| in_strip(cell) && in_strip(cell + 1);
        for y in 0..last {
            for x in (0..last).filter(|&x| cell_in_strip(x) || cell_in_strip(y)) {
                let [a, b, c, d] = [node(x, y), node(x + 1, y), node(x + 1, y + 1), node(x, y + 1)];
                // Diagonals point to the centre, so that the canopy mirrors itself.
                let side = (2 * x + 1).cmp(&last) as i32 * (2 * y + 1).cmp(&last) as i32;
                if side > 0 || (side == 0 && (x + y).is_multiple_of(2)) {
                    parts.triangles.extend([[a, b, c], [a, c, d]]);
                } else {
                    parts.triangles.extend([[a, b, d], [b, c, d]]);
                }
            }
        }
        let ends: Vec<usize> = strip.clone().step_by(self.between).collect();
        for &at in &ends {
            for cell in 0..last {
                parts.edges.push(("radials", [node(cell, at), node(cell + 1, at)]));
                parts.edges.push(("radials", [node(at, cell), node(at, cell + 1)]));
            }
        }
        // Around the cross, counter-clockwise from the end at +x: the end, then the sides of the arms up to the next.
        let turned = |[x, y]: [usize; 2], quarter: usize| match quarter {
            0 => node(x, y),
            1 => node(last - y, x),
            2 => node(last - x, last - y),
            _ => node(y, last - x),
        };
        let (low, high) = (*strip.start(), *strip.end());
        let mut around = Vec::new();
        let mut skirt = Vec::new();
        for quarter in 0..4 {
            skirt.extend(strip.clone().map(|y| turned([last, y], quarter)));
            parts.corners.extend(ends.iter().map(|&y| turned([last, y], quarter)));
            let side = (high + 1..last).rev().map(|x| [x, high]);
            let next_arm = (high + 1..last).map(|y| [high, y]);
            let places = (low..=high).map(|y| [last, y]).chain(side).chain([[high, high]]).chain(next_arm);
            around.extend(places.map(|place| turned(place, quarter)));
        }
        let next = around.iter().skip(1).chain(around.first());
        parts.edges.extend(around.iter().zip(next).map(|(&a, &b)| ("skirt", [a, b])));
        parts.node_groups.insert("skirt", skirt);
        let middle = [last / 2, last.div_ceil(2)];
        let centre = middle.iter().flat_map(|&x| middle.iter().map(move |&y| [x, y]));
        parts.node_groups.insert("apex", centre.map(|[x, y]| node(x, y)).collect());
        parts.mouth = 4.0 * self.width;
        parts.squares = self.squares(&numbers);
    }

    /// The rings of nodes of the same distance from the centre along an arm, from there outwards. Around a tube the
    /// lines are evenly spaced at the ends of the arms, and the sides of the arms meet at their roots.
    fn squares(&self, numbers: &BTreeMap<[usize; 2], u32>) -> Vec<Square> {
        let (last, root) = (self.cells(), 0.5 * self.width);
        let arm = 0.5 * self.length - root;
        let apart = 1.0 / self.lines_per_end() as f64;
        let mut rings: BTreeMap<usize, Square> = BTreeMap::new();
        for (&[x, y], &node) in numbers {
            let [dx, dy] = [x, y].map(|line| (2 * line).abs_diff(last));
            let outer = dx.max(dy);
            let arc = self.coordinate((last + outer) / 2);
            let [x_at, y_at] = [self.coordinate(x), self.coordinate(y)];
            let (side, offset) = match (dx >= dy, 2 * x >= last, 2 * y >= last) {
                (true, true, _) => (0.0, y_at),
                (true, false, _) => (2.0, -y_at),
                (false, _, true) => (1.0, -x_at),
                (false, _, false) => (3.0, x_at),
            };
            let span = FRAC_PI_4 * (1.0 - apart * ((arc - root) / arm).max(0.0));
            let part = if outer == 0 { 0.0 } else { offset / arc.min(root) };
            // Along the square's sides a step towards its centre turns by pi/4 at most, beside the step itself.
            let own_radius = FRAC_PI_4 * arc;
            let ring = rings.entry(outer).or_insert(Square { arc, own_radius, nodes: Vec::new() });
            ring.nodes.push((node, side * FRAC_PI_2 + span * part));
        }
        rings.into_values().collect()
    }
}
