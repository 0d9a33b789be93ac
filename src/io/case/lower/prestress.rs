//! Prestress: rest lengths from what the springs of an earlier run carried, `initial.keep`.

use super::geometry::Geometry;
use super::stiffness::Stiffness;
use crate::case::schema::Keep;
use crate::model::spec::{ElasticLaw, Slack};

/// What an earlier run says of the springs on every edge `[n_edges]`.
#[derive(Debug)]
pub(super) struct Prestress {
    /// what is kept of it
    pub keep: Keep,
    /// [m] lengths of the edges where this run begins
    pub length: Vec<f64>,
    /// [N] tensions; empty where they are not kept
    pub tension: Vec<f64>,
    /// [m] rest lengths, -1 without a spring
    pub rest_length: Vec<f64>,
    /// [N] axial rigidities of all springs of this case
    pub rigidity: Vec<f64>,
}

/// The law of a rule's springs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Law<'a> {
    pub stiffness: Stiffness,
    pub curve: &'a ElasticLaw,
    pub slack: Slack,
}

/// [-] A tension below this share of the largest is none.
const NO_TENSION: f64 = 1e-12;
/// [-] A rest length that is this little below 0, as a share of the length, is 0.
const ROUNDING: f64 = 1e-12;

impl Prestress {
    /// Adds the rigidity [N] of springs of which an edge has `strands` [-].
    pub(super) fn add(&mut self, law: Law<'_>, edges: &[u32], strands: Option<&[f64]>, geometry: &Geometry) {
        for (i, &edge) in edges.iter().enumerate() {
            let strands = strands.map_or(1.0, |strands| strands[i]);
            let one = self.rigidity_of(law.stiffness, edge, geometry);
            self.rigidity[edge as usize] += strands * one;
        }
    }

    /// [N] Stiffness times length of a spring.
    fn rigidity_of(&self, stiffness: Stiffness, edge: u32, geometry: &Geometry) -> f64 {
        match stiffness {
            Stiffness::Uniform(k) => k * self.length[edge as usize],
            Stiffness::Axial(ea) => ea,
            Stiffness::Membrane(et) => geometry.net_stiffness(et, edge as usize, |_| true) * self.length[edge as usize],
        }
    }

    /// [m] Rest lengths of the springs of a rule; or the edges whose tension its law does not have at any length.
    pub(super) fn rest_lengths(&self, law: Law<'_>, edges: &[u32], geometry: &Geometry) -> Result<Vec<f64>, Vec<u32>> {
        let before = |edge: u32| Some(self.rest_length[edge as usize]).filter(|rest| *rest >= 0.0);
        if self.keep == Keep::RestLengths {
            return Ok(edges.iter().map(|&edge| before(edge).unwrap_or(self.length[edge as usize])).collect());
        }
        let largest = self.tension.iter().fold(0.0, |most: f64, t| most.max(t.abs()));
        let rest = |&edge: &u32| {
            let (length, tension) = (self.length[edge as usize], self.tension[edge as usize]);
            if tension.abs() <= NO_TENSION * largest {
                return Ok(without_tension(law.slack, length, before(edge)));
            }
            let one = self.rigidity_of(law.stiffness, edge, geometry);
            law.rest_length(length, tension * one / self.rigidity[edge as usize], one).ok_or(edge)
        };
        let found: Vec<Result<f64, u32>> = edges.iter().map(rest).collect();
        let bad: Vec<u32> = found.iter().filter_map(|rest| rest.err()).collect();
        if bad.is_empty() { Ok(found.into_iter().flatten().collect()) } else { Err(bad) }
    }
}

/// [m] Rest length of a spring without tension: that of before where it is slack with it, else its length.
fn without_tension(slack: Slack, length: f64, before: Option<f64>) -> f64 {
    let stays = |rest: &f64| match slack {
        Slack::TensionOnly => length <= *rest,
        Slack::DeadZone { eps } => length - rest <= eps,
        Slack::CompressionOnly => length >= *rest,
        Slack::None | Slack::CompressionLimit { .. } => false,
    };
    before.filter(stays).unwrap_or(length)
}

impl Law<'_> {
    /// [m] The rest length at which a spring of this length [m] and stiffness times length [N] has a tension [N], which
    /// is not 0; `None` where there is none.
    fn rest_length(self, length: f64, tension: f64, rigidity: f64) -> Option<f64> {
        let taut = match self.slack {
            Slack::TensionOnly if tension < 0.0 => return None,
            Slack::CompressionOnly if tension > 0.0 => return None,
            Slack::DeadZone { eps } if tension > 0.0 && length > eps => length - eps,
            Slack::DeadZone { .. } => return None,
            _ => length,
        };
        // Of a bar the stretch l/l0 follows from its strain, of a spring with a k of its own the elongation T/k.
        let (strain, elongation) = (tension / rigidity, tension / rigidity * length);
        let rest = match (self.stiffness, self.curve) {
            (Stiffness::Axial(_), ElasticLaw::Linear) => taut / (1.0 + strain),
            (Stiffness::Axial(_), ElasticLaw::Green) => taut / green_stretch(strain)?,
            (_, ElasticLaw::Table(rows)) => taut / (1.0 + strain_of(rows, tension)?),
            (_, ElasticLaw::Linear) => taut - elongation,
            (_, ElasticLaw::Green) => taut / (1.0 + 2.0 * elongation / taut).sqrt(),
        };
        let rest = if rest.abs() <= ROUNDING * length { 0.0 } else { rest };
        let pushed_too_far = matches!(self.slack, Slack::CompressionLimit { eps } if length - rest < -eps);
        (rest >= 0.0 && rest.is_finite() && !pushed_too_far).then_some(rest)
    }
}

/// [-] The stretch s of a bar with s (s^2 - 1)/2 = force over rigidity, above that at which it carries the most
/// compression.
fn green_stretch(force: f64) -> Option<f64> {
    let least = 1.0 / 3.0_f64.sqrt();
    if force <= least * (least * least - 1.0) / 2.0 {
        return None;
    }
    // Convex there, so Newton's iteration comes down from any start above.
    let mut stretch = 1.0 + force.max(0.0);
    for _ in 0..100 {
        let change = (stretch * (stretch * stretch - 1.0) / 2.0 - force) / (1.5 * stretch * stretch - 0.5);
        stretch -= change;
        if change.abs() <= f64::EPSILON * stretch {
            break;
        }
    }
    Some(stretch)
}

/// [-] The strain at which a table of strain and force has a force [N]; it goes on beyond its ends.
fn strain_of(rows: &[[f64; 2]], force: f64) -> Option<f64> {
    let last = rows.len().checked_sub(2)?;
    let row = rows[1..].iter().position(|row| row[1] >= force).unwrap_or(last).min(last);
    let ([r0, f0], [r1, f1]) = (rows[row], rows[row + 1]);
    Some(r0 + (r1 - r0) * (force - f0) / (f1 - f0)).filter(|strain| strain.is_finite() && *strain > -1.0)
}
