//! Dashpots along a spring, clamped together with it (thesis Eq. 4, whose c is divided by l0: rule `per_strain`).
//!
//! Spring and dashpot act as one element of tension `T = max(k e + c ldot, floor)`, so that a spring going slack does
//! not make the force jump and an implicit step has a solution. This term is the part beyond the elastic one:
//! ```text
//! T_d = max(k (e - offset) + c ldot, floor) - T_elastic(e)      force on a = T_d n, on b = -T_d n
//! power = -T_d ldot,     ldot = n . (vb - va)
//! dT_d/dldot = c on the taut branch, else 0;      dT_d/dl = (slope of the sum) - (slope of the elastic part)
//! -df/dx = (T_d/l)(I - n n^T) + (dT_d/dl) n n^T + (c/l) n [(I - n n^T)(vb - va)]^T      (not symmetric)
//! -df/dv = c n n^T
//! ```

use crate::force::kernel::batch::{Batch, Elements, Kernel, Records, Wants};
use crate::force::kernel::element_block::vector;
use crate::force::law::slack::{clamped, tension};
use crate::force::law::spring::{Coefficient, SpringData, Stretch};
use crate::force::{ForceTerm, NodeState, TangentSink, outer};
use crate::model::forces::{Role, Tally};
use crate::model::system::{TermInfo, Weights};
use nalgebra::Vector3;

/// Axial dashpots parallel to a batch of springs.
pub type AxialDashpots = Batch<AxialData, 2>;

/// Plain arrays of the batch.
#[derive(Clone, Debug)]
pub struct AxialData {
    /// the springs they belong to (arrays are shared, not copied)
    pub springs: SpringData,
    /// [N s/m] c
    pub coefficient: Coefficient,
}

struct Damping {
    stretch: Stretch,
    /// vb - va
    dv: Vector3<f64>,
    ldot: f64,
    force: f64,
    /// dT_d/dl
    slope: f64,
    /// dT_d/dldot
    c: f64,
}

impl AxialData {
    /// [N] what dashpot `i` adds to the elastic tension of its spring.
    pub fn force(&self, at: NodeState<'_>, i: usize) -> f64 {
        self.damping_at(at, i).force
    }

    fn damping_at(&self, at: NodeState<'_>, i: usize) -> Damping {
        let [a, b] = self.springs.nodes[i].map(|node| node as usize);
        self.damping(i, at.x[b] - at.x[a], at.v[b] - at.v[a])
    }

    /// Of dashpot `i` between nodes whose positions and velocities differ by `dx` [m] and `dv` [m/s].
    #[inline]
    fn damping(&self, i: usize, dx: Vector3<f64>, dv: Vector3<f64>) -> Damping {
        let springs = &self.springs;
        let stretch = springs.stretch_of(dx, i);
        let ldot = stretch.n.dot(&dv);
        let c = self.coefficient.at(i);
        let Some(law) = clamped(springs.slack) else {
            return Damping { stretch, dv, ldot, force: c * ldot, slope: 0.0, c };
        };
        let k = springs.stiffness.at(i);
        let elastic = tension(springs.slack, k, stretch.elongation);
        let floor = k * (law.threshold - law.offset);
        let sum = k * (stretch.elongation - law.offset) + c * ldot;
        if sum >= floor {
            Damping { stretch, dv, ldot, force: sum - elastic.force, slope: k - elastic.slope, c }
        } else {
            Damping { stretch, dv, ldot, force: floor - elastic.force, slope: -elastic.slope, c: 0.0 }
        }
    }
}

impl Kernel<2> for AxialData {
    const WANTS: Wants = Wants { x: true, v: true };

    fn elements(&self) -> &[[u32; 2]] {
        &self.springs.nodes
    }

    fn add(&self, block: Elements<'_, 2>, f: &mut Records) -> Tally {
        let power = block.each([1.0, -1.0], f, |i, [a, b]| {
            let difference = |of: &Records| vector(of, b) - vector(of, a);
            let d = self.damping(i, difference(block.x), difference(block.v));
            (d.force * d.stretch.n, -d.force * d.ldot)
        });
        Tally { energy: 0.0, power }
    }
}

impl ForceTerm for AxialDashpots {
    fn info(&self) -> TermInfo {
        TermInfo { velocity_dependent: true, ..TermInfo::of("axial dashpots", Role::Dissipative) }
    }

    fn symmetric(&self) -> bool {
        false
    }

    fn tangent(&self, at: NodeState<'_>, w: Weights, sink: &mut dyn TangentSink) {
        let data = self.kernel();
        for (i, &nodes) in data.springs.nodes.iter().enumerate() {
            let d = data.damping_at(at, i);
            let n = d.stretch.n;
            let mut block = d.stretch.block(d.force, d.slope) * w.k + outer(n, n) * (w.c * d.c);
            if d.stretch.length > 0.0 {
                block += outer(n, d.dv - d.ldot * n) * (w.k * d.c / d.stretch.length);
            }
            sink.edge(nodes, block);
        }
    }

    /// c n n^T, the part in the velocities.
    fn symmetric_tangent(&self, at: NodeState<'_>, w: Weights, sink: &mut dyn TangentSink) {
        let data = self.kernel();
        for (i, &nodes) in data.springs.nodes.iter().enumerate() {
            let d = data.damping_at(at, i);
            sink.edge(nodes, outer(d.stretch.n, d.stretch.n) * (w.c * d.c));
        }
    }
}
