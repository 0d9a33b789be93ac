//! The rows of a canopy of gores as rings of nodes, with fewer nodes towards the apex if that is asked for.
//!
//! ```text
//! radius of a row with fewer corners than gores:   r^2 sum(sin(angle of a side)) = r0^2 n sin(2 pi/n)
//! height above the next row:                       so that the triangles between them have the area of the pattern
//! ```
//! r0 is the radius of the pattern. So each row encloses the plan area of the pattern, and each band has its area; flat
//! parts stay flat. What is approximate: the lengths along the radials and around the rows, by a few percent of the
//! radius where the rows have few corners.
//!
//! From the skirt inwards two neighbouring sides of a row may become one: columns of a gore first, then gores. They do
//! where it makes the least angle of this band and of the next ones larger. The tape of a radial that ends goes on in
//! its neighbours: each edge of a radial has a number of strands, whose sum around a row is that of the gores.

use super::ParachuteParameters;
use super::profile::{Profile, Row};
use crate::quality::angles;
use nalgebra::Vector3;
use std::cmp::{Ordering, Reverse};
use std::f64::consts::{PI, TAU};

/// [-] least number of corners of a row
const LEAST: usize = 4;
/// [-] bands over which a merge is weighed
const AHEAD: usize = 3;
/// [-] width over height of cells above which no merge is tried: it would make them wider
const WIDE: f64 = 1.5;

/// A row of nodes, or the apex.
#[derive(Clone, Debug)]
pub(super) struct Ring {
    /// columns of its nodes, counted from the first radial, ascending from 0
    pub columns: Vec<usize>,
    /// [m] distance of its corners from the axis; of its sides in a canopy that is not round
    pub radius: f64,
    /// [m] height above the skirt
    pub height: f64,
}

/// A node of a band: whether it is of the outer row, and its number in the row.
pub(super) type End = (bool, usize);

/// A part of the tape along a radial.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tape {
    /// numbers of its nodes in the inner and the outer row
    pub ends: [usize; 2],
    /// [-] how many tapes it stands for
    pub strands: f64,
}

/// The gores of a canopy.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gores<'a> {
    profile: &'a Profile,
    rows: &'a [Row],
    gores: usize,
    /// columns of a gore at the skirt
    across: usize,
    /// equal parts of a row in which it is coarsened in the same way
    sectors: usize,
    /// least number of corners
    least: usize,
    coarsen: bool,
}

impl<'a> Gores<'a> {
    pub(super) fn of(p: &ParachuteParameters, profile: &'a Profile) -> Self {
        Self {
            profile,
            rows: &profile.rows,
            gores: p.gores,
            across: p.gore_segments,
            // Vent lines join opposite corners.
            sectors: if p.has_vent_lines() { 2 } else { 1 },
            // Each inner line needs its corner.
            least: if p.inner_lines.is_some() { p.gores } else { LEAST },
            coarsen: p.coarsen,
        }
    }

    fn columns(&self) -> usize {
        self.gores * self.across
    }

    /// The rings, from the vent or the apex to the skirt.
    pub(super) fn rings(&self) -> Vec<Ring> {
        let mut sides = vec![1; self.columns()];
        let mut rings: Vec<Ring> = Vec::with_capacity(self.rows.len());
        for i in (0..self.rows.len()).rev() {
            if let Some(outer) = rings.last() {
                if self.coarsen {
                    sides = self.next_sides(i, sides, AHEAD).1;
                }
                let ring = self.ring(i, &sides);
                let height = self.height(i, &ring, outer);
                rings.push(Ring { height, ..ring });
            } else {
                rings.push(self.ring(i, &sides));
            }
        }
        rings.reverse();
        rings
    }

    /// Row `i` with these sides, at the height of the pattern.
    fn ring(&self, i: usize, sides: &[usize]) -> Ring {
        let Row { apothem, height, .. } = self.rows[i];
        if apothem == 0.0 {
            return Ring { columns: vec![0], radius: 0.0, height };
        }
        let n = self.gores as f64;
        let sine = |side: usize| (TAU * side as f64 / self.columns() as f64).sin();
        let wider = if sides.len() < self.gores {
            (n * (TAU / n).sin() / sides.iter().map(|side| sine(*side)).sum::<f64>()).sqrt()
        } else {
            1.0
        };
        let starts = sides.iter().scan(0, |at, side| {
            *at += side;
            Some(*at - side)
        });
        Ring { columns: starts.collect(), radius: apothem * self.profile.to_corner() * wider, height }
    }

    /// [m] Place of a column in a ring.
    pub(super) fn place(&self, ring: &Ring, column: usize) -> Vector3<f64> {
        let corner = |gore: usize| self.profile.corner(ring.radius, ring.height, gore);
        let part = (column % self.across) as f64 / self.across as f64;
        (1.0 - part) * corner(column / self.across) + part * corner(column / self.across + 1)
    }

    /// [m] Height of ring `i`, at which its band has the area of the pattern.
    fn height(&self, i: usize, inner: &Ring, outer: &Ring) -> f64 {
        let [from, to] = [self.rows[i], self.rows[i + 1]];
        let rise = from.height - to.height;
        let complete = |ring: &Ring| ring.columns.len() >= self.gores || ring.radius == 0.0;
        if complete(inner) && complete(outer) {
            return from.height;
        }
        if rise == 0.0 {
            return outer.height;
        }
        let wanted =
            self.gores as f64 * (PI / self.gores as f64).tan() * (from.apothem + to.apothem) * band_length(from, to);
        let triangles = self.triangles(i, inner, outer);
        let area = |part: f64| -> f64 {
            let inner = Ring { height: outer.height + part * rise, ..inner.clone() };
            let corners = self.corners_of(&triangles, &inner, outer);
            corners.map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm()).sum()
        };
        // The area grows with the rise, from the plan area, which is at most the wanted one.
        let [mut low, mut high] = [0.0, 2.0];
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if area(middle) < wanted {
                low = middle;
            } else {
                high = middle;
            }
        }
        outer.height + high * rise
    }

    /// Triangles between ring `i` and the next one, all turned the same way.
    pub(super) fn triangles(&self, i: usize, inner: &Ring, outer: &Ring) -> Vec<[End; 3]> {
        let (within, beyond) = (inner.columns.len(), outer.columns.len());
        let below = |at: usize| (true, at % beyond);
        if inner.radius == 0.0 {
            return (0..beyond).map(|at| [(false, 0), below(at), below(at + 1)]).collect();
        }
        let mut triangles = Vec::with_capacity(within + beyond);
        let mut at = 0;
        for k in 0..within {
            let (a, d) = ((false, k), (false, (k + 1) % within));
            let next = self.end_of_side(inner, k);
            let first = at;
            while outer.columns.get(at).is_some_and(|column| *column < next) {
                at += 1;
            }
            if at == first + 1 {
                let [b, c] = [below(first), below(at)];
                triangles.extend(match self.towards_centre(i, inner.columns[k], next) {
                    true => [[a, b, d], [b, c, d]],
                    false => [[a, b, c], [a, c, d]],
                });
                continue;
            }
            // Those before the middle lean on one end of the side, those after it on the other.
            let middle = first + (at - first).div_ceil(2);
            triangles.extend((first..middle).map(|j| [a, below(j), below(j + 1)]));
            triangles.push([a, below(middle), d]);
            triangles.extend((middle..at).map(|j| [below(j), below(j + 1), d]));
        }
        triangles
    }

    /// Column at which side `k` of a ring ends.
    fn end_of_side(&self, ring: &Ring, k: usize) -> usize {
        ring.columns.get(k + 1).copied().unwrap_or(self.columns())
    }

    /// Whether the diagonal of a cell is that towards the centre of the gore. Diagonals mirror each other about it;
    /// those on it take turns from row to row.
    fn towards_centre(&self, i: usize, from: usize, to: usize) -> bool {
        let twice = if to - from > self.across { self.across } else { 2 * (from % self.across) + to - from };
        match twice.cmp(&self.across) {
            Ordering::Less => true,
            Ordering::Equal => i.is_multiple_of(2),
            Ordering::Greater => false,
        }
    }

    /// The tapes of every band, and the strands that end in each node of the first ring.
    pub(super) fn tapes(&self, rings: &[Ring]) -> (Vec<Vec<Tape>>, Vec<f64>) {
        let seams = |ring: &Ring| ring.columns.iter().map(|c| f64::from(c % self.across == 0)).collect();
        let mut strands: Vec<f64> = rings.last().map(seams).unwrap_or_default();
        let mut bands = Vec::new();
        for pair in rings.windows(2).rev() {
            let band = self.tapes_of(&pair[0], &pair[1], &strands);
            strands = vec![0.0; pair[0].columns.len()];
            band.iter().for_each(|tape| strands[tape.ends[0]] += tape.strands);
            bands.push(band);
        }
        bands.reverse();
        (bands, strands)
    }

    /// The tapes from an outer ring with these strands. That of a radial which ends goes to the ends of the side before
    /// it, shared by the distances.
    fn tapes_of(&self, inner: &Ring, outer: &Ring, strands: &[f64]) -> Vec<Tape> {
        let within = inner.columns.len();
        let mut tapes = Vec::new();
        let mut at = 0;
        for (k, &from) in inner.columns.iter().enumerate() {
            let to = self.end_of_side(inner, k);
            let first = at;
            while outer.columns.get(at).is_some_and(|column| *column < to) {
                at += 1;
            }
            for j in first..at {
                let part = match at - first {
                    _ if inner.radius == 0.0 => 0.0,
                    // One between: it has an edge to each end. Of two each has one to the nearer end.
                    1 | 2 => (outer.columns[j] - from) as f64 / (to - from) as f64,
                    _ => f64::from(j > first + 1),
                };
                let shares = [(k, (1.0 - part) * strands[j]), ((k + 1) % within, part * strands[j])];
                let shares = shares.into_iter().filter(|(_, strands)| *strands > 0.0);
                tapes.extend(shares.map(|(k, strands)| Tape { ends: [k, j], strands }));
            }
        }
        tapes
    }

    fn corners_of<'b>(
        &'b self,
        triangles: &'b [[End; 3]],
        inner: &Ring,
        outer: &Ring,
    ) -> impl Iterator<Item = [Vector3<f64>; 3]> + 'b {
        let places = [inner, outer].map(|ring| {
            let places = ring.columns.iter().map(|column| self.place(ring, *column));
            places.collect::<Vec<_>>()
        });
        triangles.iter().map(move |corners| corners.map(|(outer, at)| places[usize::from(outer)][at]))
    }

    /// The sides of row `i` by those of the next row, with the least angle [deg] of as many bands and the sum of their
    /// least angles, which both shall be large.
    fn next_sides(&self, i: usize, outer: Vec<usize>, ahead: usize) -> ([f64; 2], Vec<usize>) {
        let [from, to] = [self.rows[i], self.rows[i + 1]];
        if ahead == 0 || from.apothem == 0.0 {
            return ([f64::INFINITY, 0.0], outer);
        }
        let width = TAU * to.apothem / outer.len() as f64;
        let tried = !to.after_gap && from.apothem < to.apothem && width < WIDE * band_length(from, to);
        let mut candidates = vec![outer.clone()];
        if tried {
            let sectors = if outer.len() > self.gores { self.gores } else { self.sectors };
            let of_sector = outer.len() / sectors;
            let joined = |three: bool| outer.chunks(of_sector).flat_map(move |sides| joined(sides, three)).collect();
            let odd = !of_sector.is_multiple_of(2);
            candidates.extend([true, false].into_iter().filter(|three| odd || !three).map(joined));
            candidates.retain(|sides: &Vec<usize>| sides.len() >= self.least || sides.len() == outer.len());
        }
        if candidates.len() == 1 && ahead == AHEAD {
            return ([f64::INFINITY, 0.0], outer);
        }
        let mut best: ([f64; 2], Vec<usize>) = ([f64::NEG_INFINITY; 2], outer.clone());
        for sides in candidates {
            let angle = if to.after_gap { f64::INFINITY } else { self.least_angle(i, &sides, &outer) };
            let [next, sum] = match i {
                0 => [f64::INFINITY, 0.0],
                _ => self.next_sides(i - 1, sides.clone(), ahead - 1).0,
            };
            let merit = [angle.min(next), if angle.is_finite() { angle + sum } else { sum }];
            // Of equals the one with fewer sides.
            if merit >= best.0 {
                best = (merit, sides);
            }
        }
        best
    }

    /// [deg] Least angle of the triangles between row `i` and the next one, and of cells inside row `i` that are as
    /// high.
    fn least_angle(&self, i: usize, sides: &[usize], outer: &[usize]) -> f64 {
        let [inner, outer] = [self.ring(i, sides), self.ring(i + 1, outer)];
        let high = band_length(self.rows[i], self.rows[i + 1]);
        let cells = (0..sides.len()).map(|k| {
            let ends = [inner.columns[k], self.end_of_side(&inner, k)].map(|column| self.place(&inner, column));
            let wide = (ends[1] - ends[0]).norm();
            (wide / high).min(high / wide).atan().to_degrees()
        });
        let triangles = self.triangles(i, &inner, &outer);
        let of_band = self.corners_of(&triangles, &inner, &outer).flat_map(angles);
        cells.chain(of_band).fold(f64::INFINITY, f64::min)
    }
}

/// [m] Distance of two rows along the centre line of a gore.
fn band_length(from: Row, to: Row) -> f64 {
    (to.apothem - from.apothem).hypot(to.height - from.height)
}

/// Sides joined two and two. Of an odd number one is left, the widest it can be, or three are joined, the narrowest.
fn joined(sides: &[usize], three: bool) -> Vec<usize> {
    let odd = !sides.len().is_multiple_of(2);
    let starts = (0..sides.len()).step_by(2);
    let other = match three {
        _ if !odd => None,
        true => starts.filter(|at| at + 3 <= sides.len()).min_by_key(|at| sides[*at..at + 3].iter().sum::<usize>()),
        false => starts.min_by_key(|at| Reverse(sides[*at])),
    };
    let mut all = Vec::new();
    let mut at = 0;
    while at < sides.len() {
        let count = if other != Some(at) {
            2
        } else if three {
            3
        } else {
            1
        };
        let end = sides.len().min(at + count);
        all.push(sides[at..end].iter().sum());
        at = end;
    }
    all
}
