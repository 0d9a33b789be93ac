//! A piece of cloth as its outline is drawn, and its sides.

use super::fill::{Plane, Sheet};
use nalgebra::{Vector2, Vector3};

/// [deg] Turn of an outline from which there is a corner.
pub(super) const CORNER: f64 = 45.0;
/// [deg] Turn from which a point stays when sides are divided.
const KINK: f64 = 2.0;
/// [-] Share of the size of an outline within which a line is on it.
const ON_IT: f64 = 1e-3;
/// [-] Difference of the lengths of two sides of a gore.
const ALIKE: f64 = 0.05;
/// [-] The same of sides that cannot be told from others.
const SAME: f64 = 1e-3;

/// A part of an outline, from one of its points to another one, counter-clockwise.
#[derive(Clone, Debug)]
pub(super) struct Span {
    pub name: String,
    pub from: usize,
    pub to: usize,
    /// [m] width outside of it that is cut off
    pub allowance: f64,
    /// [-] parts of its length that get points; empty where it is divided by itself
    pub parts: Vec<f64>,
}

/// An outline, counter-clockwise seen from above.
#[derive(Clone)]
pub(super) struct Piece {
    pub layers: Vec<String>,
    pub number: i64,
    pub plane: Plane,
    pub points: Vec<Vector2<f64>>,
    pub spans: Vec<Span>,
}

impl Piece {
    pub(super) fn of(sheet: &Sheet, layers: Vec<String>, places: impl Iterator<Item = Vector3<f64>>) -> Self {
        let mut points: Vec<Vector2<f64>> = places.map(|place| sheet.plane.flat(place)).collect();
        let next = points.iter().cycle().skip(1);
        if points.iter().zip(next).map(|(a, b)| a.perp(b)).sum::<f64>() < 0.0 {
            // The first point stays the first one.
            points[1..].reverse();
        }
        Piece { layers, number: sheet.number, plane: sheet.plane, points, spans: Vec::new() }
    }

    /// [m^2] Area inside the outline.
    pub(super) fn area(&self) -> f64 {
        let next = self.points.iter().cycle().skip(1);
        0.5 * self.points.iter().zip(next).map(|(a, b)| a.perp(b)).sum::<f64>().abs()
    }

    /// [m] Arc length at each point, and of the whole outline.
    fn arcs(&self) -> Vec<f64> {
        let next = self.points.iter().cycle().skip(1);
        let steps = self.points.iter().zip(next).map(|(a, b)| (b - a).norm());
        std::iter::once(0.0)
            .chain(steps.scan(0.0, |at, step| {
                *at += step;
                Some(*at)
            }))
            .collect()
    }

    /// [m]
    fn size(&self) -> f64 {
        let bound = |pick: fn(f64, f64) -> f64| self.points.iter().copied().reduce(|a, b| a.zip_map(&b, pick));
        bound(f64::max).zip(bound(f64::min)).map_or(0.0, |(high, low)| (high - low).norm())
    }

    /// [m] Arc length at a place, if it is on the outline.
    fn arc_at(&self, place: Vector3<f64>, arcs: &[f64]) -> Option<f64> {
        let near = ON_IT * self.size();
        let p = self.plane.flat(place);
        if (self.plane.space(p) - place).norm() > near {
            return None;
        }
        let next = self.points.iter().cycle().skip(1);
        let sides = self.points.iter().zip(next).zip(arcs);
        let nearest = sides.map(|((a, b), arc)| {
            let (d, length) = (b - a, (b - a).norm());
            let t = ((p - a).dot(&d) / (length * length)).clamp(0.0, 1.0);
            ((a + t * d - p).norm(), arc + t * length)
        });
        nearest.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(away, _)| *away <= near).map(|(_, arc)| arc)
    }

    /// [m] From where to where a line runs along the outline, counter-clockwise; `None` if it is not on it.
    pub(super) fn along(&self, [a, b]: [Vector3<f64>; 2]) -> Option<[f64; 2]> {
        let arcs = self.arcs();
        let whole = arcs[arcs.len() - 1];
        let at = |place| self.arc_at(place, &arcs);
        let (from, to) = (at(a)?, at(b)?);
        at(0.5 * (a + b))?;
        let forward = (to - from).rem_euclid(whole);
        Some(if forward <= 0.5 * whole { [from, from + forward] } else { [to, to + whole - forward] })
    }

    /// One span of lines that run along the outline, or how many there are.
    pub(super) fn chain(&self, mut lines: Vec<[f64; 2]>) -> Result<[f64; 2], usize> {
        let near = 2.0 * ON_IT * self.size();
        let whole = self.arcs().last().copied().unwrap_or_default();
        lines.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
        let mut chains: Vec<[f64; 2]> = Vec::new();
        for [from, to] in lines {
            match chains.last_mut() {
                Some(last) if from - last[1] <= near => last[1] = last[1].max(to),
                _ => chains.push([from, to]),
            }
        }
        // The last one may go on at the first point.
        if let [first, .., last] = chains[..]
            && first[0] + whole - last[1] <= near
        {
            chains.remove(0);
            let end = chains.len() - 1;
            chains[end][1] = first[1] + whole;
        }
        match chains[..] {
            [one] if one[1] - one[0] < whole - near => Ok(one),
            _ => Err(chains.len()),
        }
    }

    /// The number of the point at each of some arc lengths [m]; those that are missing are added.
    pub(super) fn mark(&mut self, marks: &[f64]) -> Vec<usize> {
        let near = 2.0 * ON_IT * self.size();
        let arcs = self.arcs();
        let whole = arcs[arcs.len() - 1];
        let apart = |a: f64, b: f64| (a - b).rem_euclid(whole).min((b - a).rem_euclid(whole));
        let mut all: Vec<(f64, Vector2<f64>)> = arcs.iter().copied().zip(self.points.iter().copied()).collect();
        for mark in marks.iter().map(|mark| mark.rem_euclid(whole)) {
            if all.iter().all(|(arc, _)| apart(*arc, mark) > near) {
                let side = arcs.partition_point(|arc| *arc <= mark).clamp(1, self.points.len()) - 1;
                let (a, b) = (self.points[side], self.points[(side + 1) % self.points.len()]);
                all.push((mark, a + (mark - arcs[side]) / (arcs[side + 1] - arcs[side]) * (b - a)));
            }
        }
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let index = |mark: &f64| {
            let nearest = all.iter().map(|(arc, _)| apart(*arc, *mark)).enumerate();
            nearest.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(i, _)| i)
        };
        let found = marks.iter().map(index).collect();
        // Spans that are known already keep their points.
        let place: Vec<usize> = arcs
            .iter()
            .take(self.points.len())
            .map(|arc| all.iter().position(|(other, _)| other == arc).unwrap_or(0))
            .collect();
        for span in &mut self.spans {
            (span.from, span.to) = (place[span.from], place[span.to]);
        }
        self.points = all.into_iter().map(|(_, point)| point).collect();
        found
    }

    /// [deg] Turn of the outline at a point.
    fn turn(&self, i: usize) -> f64 {
        let n = self.points.len();
        let [a, b, c] = [i + n - 1, i, i + 1].map(|i| self.points[i % n]);
        let (d, e) = (b - a, c - b);
        d.perp(&e).atan2(d.dot(&e)).to_degrees().abs()
    }

    /// Points at which there is a corner.
    pub(super) fn corners(&self) -> Vec<usize> {
        (0..self.points.len()).filter(|i| self.turn(*i) > CORNER).collect()
    }

    /// Its sides from corner to corner.
    pub(super) fn sides(&self) -> Vec<[usize; 2]> {
        let corners = self.corners();
        let next = corners.iter().cycle().skip(1);
        corners.iter().zip(next).map(|(from, to)| [*from, *to]).collect()
    }

    /// The points of a span.
    pub(super) fn run(&self, [from, to]: [usize; 2]) -> Vec<Vector2<f64>> {
        let n = self.points.len();
        let count = (to + n - from - 1) % n + 1;
        (0..=count).map(|k| self.points[(from + k) % n]).collect()
    }

    /// Numbers of the segments of a span; segment i leads from point i to the next one.
    pub(super) fn segments(&self, [from, to]: [usize; 2]) -> impl Iterator<Item = usize> {
        let n = self.points.len();
        (0..(to + n - from - 1) % n + 1).map(move |k| (from + k) % n)
    }

    /// [-] Parts of the length of a span at which a point stays: its ends and kinks.
    pub(super) fn stops(&self, ends: [usize; 2]) -> Vec<f64> {
        let run = Run::of(self.run(ends));
        let kinks = self.segments(ends).zip(&run.parts).skip(1).filter(|(i, _)| self.turn(*i) > KINK);
        std::iter::once(0.0).chain(kinks.map(|(_, part)| *part)).chain([1.0]).collect()
    }

    /// The sides of a gore.
    pub(super) fn gore_sides(&self) -> Option<GoreSides> {
        let sides = self.sides();
        let lengths: Vec<f64> = sides.iter().map(|side| Run::of(self.run(*side)).length).collect();
        let n = sides.len();
        let differ = |i: usize, j: usize| (lengths[i] - lengths[j % n]).abs() / lengths[i].max(lengths[j % n]);
        let least = |step: usize, count: usize| {
            (0..count).map(|i| (differ(i, i + step), i)).min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(d, _)| *d < ALIKE)
        };
        match n {
            3 => {
                let (_, up) = least(1, 3)?;
                Some(GoreSides { seams: [sides[up], sides[(up + 1) % 3]], others: vec![sides[(up + 2) % 3]] })
            }
            4 => {
                let (_, first) = least(2, 2)?;
                // All sides of a rectangle are like another one.
                if differ(1 - first, 3 - first) < SAME {
                    return None;
                }
                // The upper end is the shorter one of the others.
                let upper_is_next = lengths[first + 1] < lengths[(first + 3) % 4];
                let up = if upper_is_next { first } else { first + 2 };
                Some(GoreSides {
                    seams: [sides[up], sides[(up + 2) % 4]],
                    others: vec![sides[(up + 1) % 4], sides[(up + 3) % 4]],
                })
            }
            _ => None,
        }
    }

    /// Whether another outline lies inside.
    pub(super) fn holds(&self, other: &Piece) -> bool {
        let inside = |p: Vector2<f64>| {
            let next = self.points.iter().cycle().skip(1);
            let crossed = |(a, b): &(&Vector2<f64>, &Vector2<f64>)| {
                (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
            };
            self.points.iter().zip(next).filter(crossed).count() % 2 == 1
        };
        let near = ON_IT * self.size();
        other.points.iter().map(|p| other.plane.space(*p)).all(|place| {
            let p = self.plane.flat(place);
            (self.plane.space(p) - place).norm() <= near && inside(p)
        })
    }
}

/// The sides of a gore, each from one point to another one.
pub(super) struct GoreSides {
    /// the one that leads to its upper end, and the one that leads down
    pub seams: [[usize; 2]; 2],
    /// skirt and vent
    pub others: Vec<[usize; 2]>,
}

/// A line through points.
pub(super) struct Run {
    points: Vec<Vector2<f64>>,
    /// [-] part of its length at each point
    pub parts: Vec<f64>,
    /// [m]
    pub length: f64,
}

impl Run {
    pub(super) fn of(points: Vec<Vector2<f64>>) -> Self {
        let steps = points.windows(2).scan(0.0, |at, pair| {
            *at += (pair[1] - pair[0]).norm();
            Some(*at)
        });
        let mut parts: Vec<f64> = std::iter::once(0.0).chain(steps).collect();
        let length = parts.last().copied().unwrap_or_default();
        parts.iter_mut().for_each(|part| *part /= length);
        Run { points, parts, length }
    }

    /// The place at a part of its length.
    pub(super) fn at(&self, part: f64) -> Vector2<f64> {
        let i = self.parts.partition_point(|other| *other <= part).clamp(1, self.parts.len() - 1);
        let [a, b] = [i - 1, i].map(|i| self.points[i]);
        // A point of the line is met to the last digit.
        if part == self.parts[i] {
            return b;
        }
        a + (part - self.parts[i - 1]) / (self.parts[i] - self.parts[i - 1]) * (b - a)
    }
}
