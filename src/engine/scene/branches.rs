//! Springs that go slack or taut within a step.
//!
//! Along a step, g = l - s l0 - threshold (plus c/k dl/dt with an axial dashpot) is interpolated by the cubic through
//! its values and rates at both ends, in Bernstein form. A spring whose four coefficients have one sign keeps its law.
//! The others' tension is k max(g, 0): k times the area above zero is the impulse added by a spring that is slack at
//! the start, and k times the area below zero is the impulse missing from a taut one.

use super::acting::SpringBatch;
use super::network::{Network, node_state};
use crate::force::NodeState;
use crate::force::law::slack::Clamp;
use crate::mesh::unit_vector::unit_vector;
use crate::model::state::StateRef;

/// Number of intervals of a step for the areas.
const PARTS: u32 = 16;
/// [-] Share of the smaller area: a change of sign after less than this is the change the step began with.
const BEGUN: f64 = 0.01;
/// Bisections of an interval in which the sign changes.
const HALVINGS: u32 = 30;

/// g along a step as a cubic of s in [0, 1], by its Bernstein coefficients [m].
#[derive(Clone, Copy)]
struct ElongationCubic([f64; 4]);

/// A spring with a one-sided law.
#[derive(Clone, Copy)]
struct OneSidedSpring {
    nodes: [u32; 2],
    /// [m] length at which it goes slack, at both ends of the step
    limit: [f64; 2],
    /// [s] c/k of its dashpot
    lag: f64,
}

impl OneSidedSpring {
    /// l - limit [m] and dl/dt [m/s].
    fn gap_at(&self, end: NodeState<'_>, limit: f64) -> [f64; 2] {
        let [a, b] = self.nodes.map(|node| node as usize);
        let (d, v) = (end.x[b] - end.x[a], end.v[b] - end.v[a]);
        let length = d.norm();
        [length - limit, if length > 0.0 { d.dot(&v) / length } else { 0.0 }]
    }

    fn gap(&self, h: f64, ends: [NodeState<'_>; 2]) -> ElongationCubic {
        let [[g0, r0], [g1, r1]] = [0, 1].map(|end| self.gap_at(ends[end], self.limit[end]));
        // The limit changes linearly through the step; a dashpot is moved by the length alone.
        let reeled = self.limit[1] - self.limit[0];
        let b = [g0, g0 + (h * r0 - reeled) / 3.0, g1 - (h * r1 - reeled) / 3.0, g1];
        // The rate is the quadratic 3 (b_{i+1} - b_i)/h, raised to a cubic.
        let q = [0, 1, 2].map(|i| (3.0 * (b[i + 1] - b[i]) + reeled) * self.lag / h);
        ElongationCubic([b[0] + q[0], b[1] + (q[0] + 2.0 * q[1]) / 3.0, b[2] + (2.0 * q[1] + q[2]) / 3.0, b[3] + q[2]])
    }
}

impl ElongationCubic {
    /// Whether the sign is proved constant.
    fn keeps_its_sign(&self) -> bool {
        self.0.iter().all(|b| *b >= 0.0) || self.0.iter().all(|b| *b <= 0.0)
    }

    fn at(&self, s: f64) -> f64 {
        let [b0, b1, b2, b3] = self.0;
        let r = 1.0 - s;
        r * r * (r * b0 + 3.0 * s * b1) + s * s * (3.0 * r * b2 + s * b3)
    }

    fn ends(&self) -> impl Iterator<Item = [f64; 2]> {
        (0..PARTS).map(|part| [part, part + 1].map(|i| f64::from(i) / f64::from(PARTS)))
    }

    /// [m] areas above and below zero, by trapezoids.
    fn areas(&self) -> [f64; 2] {
        let mut areas = [0.0; 2];
        for [s0, s1] in self.ends() {
            let (g0, g1) = (self.at(s0), self.at(s1));
            let whole = 0.5 * (s1 - s0) * (g0 + g1);
            // Two triangles if the sign changes.
            let above = match (g0 > 0.0, g1 > 0.0) {
                (true, true) => whole,
                (false, false) => 0.0,
                (true, false) => 0.5 * (s1 - s0) * g0 * g0 / (g0 - g1),
                (false, true) => 0.5 * (s1 - s0) * g1 * g1 / (g1 - g0),
            };
            areas[0] += above;
            areas[1] += above - whole;
        }
        areas
    }

    /// Where the sign changes first, except for a change right at the start.
    fn first_change(&self, smaller: f64) -> f64 {
        let (mut before, mut found) = (0.0, 1.0);
        for [s0, s1] in self.ends() {
            let (g0, g1) = (self.at(s0), self.at(s1));
            if (g0 > 0.0) != (g1 > 0.0) {
                found = self.root([s0, s1]);
                before += 0.5 * (found - s0) * g0.abs();
                if before >= BEGUN * smaller {
                    return found;
                }
                before = 0.5 * (s1 - found) * g1.abs();
            } else {
                before += 0.5 * (s1 - s0) * (g0 + g1).abs();
            }
        }
        found
    }

    fn root(&self, [mut low, mut high]: [f64; 2]) -> f64 {
        let sign = self.at(low) > 0.0;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if (self.at(middle) > 0.0) == sign { low = middle } else { high = middle }
        }
        high
    }
}

/// Springs of a batch that carry force and can go slack, with their stiffnesses [N/m], in a step between two times [s].
fn lines(batch: &SpringBatch, times: [f64; 2]) -> impl Iterator<Item = (OneSidedSpring, f64)> {
    let law = Clamp::of(batch.data.slack);
    let nodes = law.map_or(&[][..], |_| &batch.data.nodes[..]);
    let threshold = law.map_or(0.0, |law| law.threshold());
    let scales = times.map(|t| batch.data.rest_scale_at(t));
    nodes.iter().enumerate().filter(|(i, _)| !batch.cut.is_cut(*i)).map(move |(i, &nodes)| {
        let k = batch.data.stiffness.at(i);
        let lag = if batch.axial && k > 0.0 { batch.dashpot.at(i) / k } else { 0.0 };
        (OneSidedSpring { nodes, limit: scales.map(|s| s * batch.data.rest_length[i] + threshold), lag }, k)
    })
}

impl Network {
    /// Whether springs can go slack.
    pub(super) fn goes_slack(&self) -> bool {
        self.acting.springs.iter().any(|batch| Clamp::of(batch.data.slack).is_some())
    }

    /// See [`super::Scene::branch_changes`].
    pub(super) fn branch_changes_of(&self, step: [StateRef<'_>; 2], impulse: &mut [f64]) -> Option<f64> {
        let h = step[1].t - step[0].t;
        let ends = step.map(node_state);
        let mut largest: Option<(f64, ElongationCubic, f64)> = None;
        for (line, k) in self.acting.springs.iter().flat_map(|batch| lines(batch, step.map(|at| at.t))) {
            let gap = line.gap(h, ends);
            if gap.keeps_its_sign() {
                continue;
            }
            if largest.is_none() {
                impulse.fill(0.0);
            }
            let [above, below] = gap.areas();
            let smaller = above.min(below);
            let made = h * k * smaller;
            let [a, b] = line.nodes.map(|node| 3 * node as usize);
            let along =
                unit_vector(ends[1].x[line.nodes[1] as usize] - ends[1].x[line.nodes[0] as usize]).unwrap_or_default();
            let pull = (if above <= below { made } else { -made }) * along;
            for (i, pull) in pull.iter().enumerate() {
                impulse[a + i] += pull;
                impulse[b + i] -= pull;
            }
            if largest.is_none_or(|(most, ..)| made > most) {
                largest = Some((made, gap, smaller));
            }
        }
        largest.map(|(_, gap, smaller)| gap.first_change(smaller))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From -1 to 1 in a straight line: half the step on either side of zero.
    #[test]
    fn a_straight_line_has_two_triangles() {
        let gap = ElongationCubic([-1.0, -1.0 / 3.0, 1.0 / 3.0, 1.0]);
        assert!(!gap.keeps_its_sign());
        for area in gap.areas() {
            assert!((area - 0.25).abs() < 1e-12, "{area}");
        }
        assert!((gap.first_change(0.25) - 0.5).abs() < 1e-9);
    }

    /// Slack at both ends, thrown back in between: -0.1 + 4 s (1 - s) lies above zero within s = 1/2 -+ sqrt(0.225).
    #[test]
    fn a_catch_within_a_step_is_found() {
        let line = |s: f64| -0.1 + 4.0 * s * (1.0 - s);
        let gap = ElongationCubic([-0.1, -0.1 + 4.0 / 3.0, -0.1 + 4.0 / 3.0, -0.1]);
        assert!((gap.at(0.3) - line(0.3)).abs() < 1e-14);
        let half = 0.225f64.sqrt();
        let [above, below] = gap.areas();
        // Integral of 4 (half^2 - r^2) over r from -half to half.
        assert!((above - 16.0 / 3.0 * half.powi(3)).abs() < 1e-2 * above, "{above}");
        // The ends are small triangles, which few trapezoids cover.
        let exact = 16.0 / 3.0 * half.powi(3) - (2.0 / 3.0 - 0.1);
        assert!((below - exact).abs() < 0.06 * exact, "{below}");
        assert!((gap.first_change(below) - (0.5 - half)).abs() < 1e-9);
    }

    /// What changes right at the beginning is where the step before ended.
    #[test]
    fn a_change_at_the_beginning_is_not_the_one() {
        // Zero at s = 1e-5 and 0.6, and a minimum or maximum between.
        let gap = |s: f64| (s - 1e-5) * (0.6 - s);
        // Bernstein coefficients of a quadratic q0, q1, q2 raised by one degree.
        let (q0, q2) = (gap(0.0), gap(1.0));
        let q1 = 2.0 * gap(0.5) - 0.5 * (q0 + q2);
        let gap = ElongationCubic([q0, (q0 + 2.0 * q1) / 3.0, (2.0 * q1 + q2) / 3.0, q2]);
        let [above, below] = gap.areas();
        assert!((gap.first_change(above.min(below)) - 0.6).abs() < 1e-9);
    }
}
