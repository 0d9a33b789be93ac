//! Weight: f = m g on every node (thesis Eq. 5), energy -m g . (x - x_start).
//!
//! The energy is counted from the displacement, so that an origin far away costs no digits. Fixed nodes have no
//! weight here: their support carries it and nothing moves.

use super::batch::{LANES, Lanes, Threads};
use super::{ForceTerm, NodeState, TangentSink};
use crate::model::forces::{Role, Tally};
use crate::model::system::{TermInfo, Weights};
use glam::DVec3;
use multiversion::multiversion;
use std::sync::Arc;

/// Uniform gravity.
#[derive(Clone, Debug)]
pub struct Gravity {
    /// [N] m g at every node, 0 where it is held in all directions
    weight: Vec<DVec3>,
    /// [m] node positions from which the energy counts
    origin: Arc<[DVec3]>,
}

impl Gravity {
    /// Masses [kg] in the acceleration of free fall `g` [m/s^2]; `origin` are the node positions [m] from which the energy counts.
    pub fn new(g: DVec3, mass: impl Iterator<Item = f64>, origin: Arc<[DVec3]>) -> Self {
        Gravity { weight: mass.map(|m| m * g).collect(), origin }
    }
}

/// Degrees of freedom whose energies are summed before they are added to the others: sums of sums lose fewer digits.
const BLOCK: usize = 24 * LANES;

/// f += w; returns -w . (x - origin).
#[multiversion(targets("x86_64+avx+avx2"))]
fn add_weight(w: &[f64], x: &[f64], origin: &[f64], f: &mut [f64]) -> f64 {
    let mut energy = 0.0;
    for (((f, w), x), origin) in f.chunks_mut(BLOCK).zip(w.chunks(BLOCK)).zip(x.chunks(BLOCK)).zip(origin.chunks(BLOCK))
    {
        let mut sum = Lanes::default();
        let (rows, last) = w.as_chunks::<LANES>();
        let (f, f_last) = f.as_chunks_mut::<LANES>();
        let ((x, x_last), (o, o_last)) = (x.as_chunks::<LANES>(), origin.as_chunks::<LANES>());
        for (((f, w), x), o) in f.iter_mut().zip(rows).zip(x).zip(o) {
            sum.add(&add_row(*w, *x, *o, f));
        }
        for (((f, w), x), o) in f_last.iter_mut().zip(last).zip(x_last).zip(o_last) {
            sum.add(&add_row([*w], [*x], [*o], std::array::from_mut(f)));
        }
        energy += sum.total();
    }
    energy
}

#[inline(always)]
fn add_row<const B: usize>(w: [f64; B], x: [f64; B], origin: [f64; B], f: &mut [f64; B]) -> [f64; B] {
    let mut energy = [0.0; B];
    for i in 0..B {
        f[i] += w[i];
        energy[i] = -w[i] * (x[i] - origin[i]);
    }
    energy
}

impl ForceTerm for Gravity {
    fn info(&self) -> TermInfo {
        TermInfo { name: "gravity", role: Role::Gravity }
    }

    fn elements(&self) -> usize {
        self.weight.len()
    }

    fn velocity_dependent(&self) -> bool {
        false
    }

    fn symmetric(&self) -> bool {
        true
    }

    fn add(&self, at: NodeState<'_>, threads: &Threads, f: &mut [DVec3]) -> Tally {
        let flat = bytemuck::cast_slice::<DVec3, f64>;
        let (w, x, origin) = (flat(&self.weight), flat(at.x), flat(&self.origin));
        let f = bytemuck::cast_slice_mut(f);
        let energy = threads.workers().each(f, |r, f| add_weight(&w[r.clone()], &x[r.clone()], &origin[r], f));
        Tally { energy, power: 0.0 }
    }

    fn tangent(&self, _at: NodeState<'_>, _w: Weights, _sink: &mut dyn TangentSink) {}
}
