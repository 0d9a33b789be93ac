//! Mass scaling: nodes whose elements would not allow a wanted step get more inertia.
//!
//! Steps of central differences with velocities half a step behind are stable where M lies above (h/2) C + (h^2/4) K,
//! on an oscillator w h < 2 (sqrt(1 + zeta^2) - zeta). This matrix lies below a diagonal one ([`super::bound`]), whose
//! number at a node is the mass that the node needs. Springs count as taut: the elements are looked at where they are
//! at the start, and on the mesh as given, stretched until none of its springs is slack.

use super::bound::{FORM, largest_by_node};
use super::build::Builder;
use super::check::BuildError;
use super::network::SpringBatch;
use super::numbering::Numbering;
use crate::force::law::slack::Clamp;
use crate::force::{ForceTerm, NodeState};
use crate::model::added_mass::AddedMass;
use crate::model::system::Weights;
use nalgebra::Vector3;

/// [-] Stretch of the mesh that makes springs taut which have the lengths of its edges.
const TAUT: f64 = 1.0 + 1e-9;

impl Builder<'_> {
    /// [kg] The inertia of every node, if masses are scaled, and what that adds.
    ///
    /// # Errors
    /// When every node has the mass that it needs.
    pub(super) fn scale_masses(
        &mut self,
        [reference, start]: [&[Vector3<f64>]; 2],
        velocity: &[[f64; 3]],
        (fixed, mass): (&[[bool; 3]], &[f64]),
    ) -> Result<Option<(Vec<f64>, AddedMass)>, BuildError> {
        let Some(step) = self.spec.mass_scaling else { return Ok(None) };
        let mut moving: Vec<Vector3<f64>> = velocity.iter().copied().map(Vector3::from).collect();
        moving.resize(mass.len(), Vector3::zeros());
        let (terms, springs, numbering) = (&self.terms, &self.springs, self.numbering);
        let unscaled = Unscaled { terms, springs, reference, start, velocity: &moving, fixed, mass, numbering };
        let (inertia, added) = unscaled.scale(step)?;
        // Inertia in an accelerated frame is a force on all of it.
        let more: Vec<f64> = inertia.iter().zip(mass).map(|(inertia, mass)| inertia - mass).collect();
        self.base(fixed, &more);
        Ok(Some((inertia, added)))
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
    /// [kg] The inertia of every node with which central differences are stable in steps of `step` [s], and what that
    /// adds.
    ///
    /// # Errors
    /// When every node has as much.
    fn scale(&self, step: f64) -> Result<(Vec<f64>, AddedMass), BuildError> {
        let stretch = self.stretch();
        let taut: Vec<Vector3<f64>> = self.reference.iter().map(|x| stretch * x).collect();
        let [at_start, when_taut] = [self.start, &taut].map(|x| self.needed(x, step));
        let needed = at_start.iter().zip(&when_taut).map(|(a, b)| a.max(*b));
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
        Ok((inertia, found))
    }

    /// [kg] What each node needs with the nodes at `x`.
    fn needed(&self, x: &[Vector3<f64>], step: f64) -> Vec<f64> {
        let (at, weights) =
            (NodeState { t: 0.0, x, v: self.velocity }, Weights { m: 0.0, c: 0.5 * step, k: 0.25 * step * step });
        largest_by_node(self.fixed, |sink| self.terms.iter().for_each(|term| term.tangent(at, weights, FORM, sink)))
    }

    /// [-] How far the mesh is stretched until no spring is slack.
    fn stretch(&self) -> f64 {
        let slack = self.springs.iter().filter_map(|batch| Some((batch, Clamp::of(batch.data.slack)?)));
        let pulls = slack.filter(|(_, clamp)| !clamp.pushes());
        let stretches = pulls.flat_map(|(batch, clamp)| {
            let scale = batch.data.rest_scale.as_ref().map_or(1.0, |table| table.at(0.0)[0]);
            batch.data.nodes.iter().zip(batch.data.rest_length.iter()).map(move |([a, b], rest)| {
                let length = (self.reference[*b as usize] - self.reference[*a as usize]).norm();
                if length > 0.0 { TAUT * (scale * rest + clamp.threshold()) / length } else { TAUT }
            })
        });
        stretches.fold(TAUT, f64::max)
    }
}
