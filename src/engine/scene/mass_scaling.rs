//! Mass scaling: nodes whose elements would not allow a wanted step get more inertia.
//!
//! Steps of central differences with velocities half a step behind are stable where M lies above (h/2) C + (h^2/4) K,
//! on an oscillator w h < 2 (sqrt(1 + zeta^2) - zeta). This matrix lies below a diagonal one ([`super::bound`]), whose
//! number at a node is the mass that the node needs. The elements are looked at where they are at the start, and where
//! they are on the mesh as given. Springs count as taut: a slack one has the tangent with which it becomes taut in its
//! direction, its whole stiffness along it and no tension.

use super::acting::SpringBatch;
use super::bound::{FORM, largest_by_node};
use super::build::Builder;
use super::check_values::BuildError;
use super::numbering::Numbering;
use crate::force::law::damped_springs::{DampedSprings, Dashpots};
use crate::force::law::slack::Clamp;
use crate::force::law::spring::SpringData;
use crate::force::{ForceTerm, NodeState};
use crate::model::added_mass::AddedMass;
use crate::model::spec::DashpotKind;
use crate::model::system::Weights;
use nalgebra::Vector3;

/// Masses with what scaling has added.
pub(super) struct ScaledMasses {
    /// [kg] inertia of every node
    pub inertia: Vec<f64>,
    pub added: AddedMass,
}

/// [-] Stretch of the mesh as given that makes sheets and bars taut which are at rest in it.
const TAUT: f64 = 1.0 + 1e-9;

impl Builder<'_> {
    /// The masses that are scaled; `None` if none are to be.
    ///
    /// # Errors
    /// When every node has the mass that it needs.
    pub(super) fn scale_masses(
        &mut self,
        [reference, start]: [&[Vector3<f64>]; 2],
        velocity: &[[f64; 3]],
        fixed: &[[bool; 3]],
        mass: &[f64],
    ) -> Result<Option<ScaledMasses>, BuildError> {
        let Some(step) = self.spec.mass_scaling else { return Ok(None) };
        let mut moving: Vec<Vector3<f64>> = velocity.iter().copied().map(Vector3::from).collect();
        moving.resize(mass.len(), Vector3::zeros());
        let (terms, springs, numbering) = (&self.acting.terms, &self.acting.springs, self.numbering);
        let unscaled = Unscaled { terms, springs, reference, start, velocity: &moving, fixed, mass, numbering };
        let scaled = unscaled.scale(step)?;
        // Inertia in an accelerated frame is a force on all of it.
        let more: Vec<f64> = scaled.inertia.iter().zip(mass).map(|(inertia, mass)| inertia - mass).collect();
        self.base(fixed, &more);
        Ok(Some(scaled))
    }
}

/// A network before it is put together, in internal numbering.
struct Unscaled<'a> {
    terms: &'a [Box<dyn ForceTerm>],
    springs: &'a [SpringBatch],
    /// [m] the mesh as given
    reference: &'a [Vector3<f64>],
    /// [m]
    start: &'a [Vector3<f64>],
    /// [m/s] at the start
    velocity: &'a [Vector3<f64>],
    /// what never becomes free
    fixed: &'a [[bool; 3]],
    /// [kg]
    mass: &'a [f64],
    numbering: &'a Numbering,
}

impl Unscaled<'_> {
    /// The masses with which central differences are stable in steps of `step` [s].
    ///
    /// # Errors
    /// When every node has as much.
    fn scale(&self, step: f64) -> Result<ScaledMasses, BuildError> {
        let given: Vec<Vector3<f64>> = self.reference.iter().map(|x| TAUT * x).collect();
        let looks =
            [(self.start, false), (self.start, true), (&given, true)].map(|(x, taut)| self.needed(x, taut, step));
        let needed = (0..self.mass.len()).map(|i| looks.iter().map(|look| look[i]).fold(0.0, f64::max));
        let mut found = AddedMass { step, ..AddedMass::default() };
        let (mut inertia, mut moving, mut own) = (self.mass.to_vec(), 0.0, 0.0);
        for (i, needed) in needed.enumerate().filter(|(i, _)| self.fixed[*i] != [true; 3]) {
            let mass = self.mass[i];
            moving += mass;
            if needed / mass > found.largest_factor {
                (found.largest_factor, found.largest_at) = (needed / mass, self.numbering.user[i]);
            }
            if needed > mass {
                inertia[i] = needed;
                own += mass;
                found.added += needed - mass;
                found.nodes += 1;
            }
        }
        if found.nodes == 0 {
            return Err(BuildError::NothingToScale { step, needed: found.largest_factor });
        }
        (found.share, found.share_of_nodes) = (found.added / moving, found.added / own);
        Ok(ScaledMasses { inertia, added: found })
    }

    /// [kg] What each node needs with the nodes at `x`, where springs are as they are or all `taut`.
    fn needed(&self, x: &[Vector3<f64>], taut: bool, step: f64) -> Vec<f64> {
        let (at, weights) =
            (NodeState { t: 0.0, x, v: self.velocity }, Weights { m: 0.0, c: 0.5 * step, k: 0.25 * step * step });
        // A dashpot of a spring that gets shorter would make it slack.
        let at_rest = NodeState { v: &vec![Vector3::zeros(); x.len()], ..at };
        // The first terms are those of the springs.
        let (springs, others) = self.terms.split_at(self.springs.len());
        largest_by_node(self.fixed, |sink| {
            others.iter().for_each(|term| term.tangent(at, weights, FORM, sink));
            match taut {
                true => self.springs.iter().for_each(|batch| when_taut(batch, x).tangent(at_rest, weights, FORM, sink)),
                false => springs.iter().for_each(|term| term.tangent(at, weights, FORM, sink)),
            }
        })
    }
}

/// The springs of a batch with the nodes at `x`, where those that are slack have the rest lengths with which they would
/// be as long as at zero tension.
fn when_taut(batch: &SpringBatch, x: &[Vector3<f64>]) -> DampedSprings {
    let (data, clamp) = (&batch.data, Clamp::or_none(batch.data.slack));
    let (at, Clamp { lower, upper, offset }) = (data.at(0.0, x), clamp);
    let rest_length = data.nodes.iter().enumerate().map(|(i, [a, b])| {
        let length = (x[*b as usize] - x[*a as usize]).norm();
        let rest = data.rest_length_at(at, i);
        match length - rest {
            // Rounding does not make it slack again.
            e if e < lower => (length - offset).next_down(),
            e if e > upper => length - offset,
            _ => rest,
        }
    });
    let springs = SpringData { rest_length: rest_length.collect(), rest_scale: None, ..data.clone() };
    let kind = if batch.axial { DashpotKind::Axial } else { DashpotKind::Relative };
    DampedSprings::new(springs, Some(Dashpots { kind, coefficient: batch.dashpot.clone() }))
}
