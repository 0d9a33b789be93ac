//! Pressure along the current normal: p A N on a triangle, a third to each vertex.
//!
//! ```text
//! f_i = p S / 3,      -df_i/dx_j = -(p/6) [d_j]x      (not symmetric),      power = p S . mean(v)
//! ```

use crate::force::kernel::batch::{BufferReads, Records};
use crate::force::kernel::faces::{FaceBatch, FaceKernel, Faces};
use crate::force::kernel::triangle_pairs::{PressureForce, PressureLaw};
use crate::force::law::series::LoadFactor;
use crate::force::law::triangle::{AreaVector, THIRD};
use crate::force::{Copies, ForceTerm, NodeState, TangentForm, TangentSink};
use crate::model::forces::{Role, Tally};
use crate::model::quad::Real;
use crate::model::system::{TermInfo, Weights};
use std::sync::Arc;

/// A follower pressure on a batch of triangles.
pub type FollowerPressure = FaceBatch<FollowerData>;

/// Plain data of the batch.
#[derive(Clone, Debug)]
pub struct FollowerData {
    /// vertices, right-handed about the direction of the pressure
    pub triangles: Arc<[[u32; 3]]>,
    /// [Pa] p
    pub pressure: f64,
    /// factor over time
    pub factor: LoadFactor,
}

impl FaceKernel for FollowerData {
    const READS: BufferReads = BufferReads { x: true, v: true };

    fn elements(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    fn add(&self, block: Faces<'_>, f: &mut Records) -> Tally {
        let pressure = self.pressure * self.factor.at(block.t);
        Tally { energy: 0.0, power: block.add_pressure(&FollowerLaw { pressure }, f) }
    }

    fn for_run(&self, copies: &mut Copies) -> Self {
        FollowerData { factor: self.factor.for_run(copies), ..self.clone() }
    }
}

struct FollowerLaw {
    /// [Pa]
    pressure: f64,
}

impl PressureLaw for FollowerLaw {
    #[inline(always)]
    fn pressure_force<R: Real>(&self, s: [R; 3], v: [R; 3]) -> PressureForce<R> {
        let share = s[0].all(THIRD * self.pressure);
        PressureForce { share, amount: share * (s[0] * v[0] + s[1] * v[1] + s[2] * v[2]) }
    }
}

impl ForceTerm for FollowerPressure {
    fn parts(&self) -> &[TermInfo] {
        const INFO: TermInfo =
            TermInfo { follower: true, on_triangles: true, ..TermInfo::of("follower pressure", Role::External) };
        &[INFO]
    }

    fn symmetric(&self) -> bool {
        false
    }

    fn tangent(&self, at: NodeState<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink) {
        let data = self.kernel();
        let p = data.pressure * data.factor.at(at.t);
        for &nodes in data.triangles.iter() {
            let area = AreaVector::new(at.x, nodes);
            // There is no symmetric form: it would come from the edge of the surface only, with either sign.
            let k = if form.symmetric { 0.0 } else { w.k };
            let row = [0, 1, 2].map(|j| area.derivative(j) * (-k * p / 3.0));
            sink.triangle(nodes, &[row; 3]);
        }
    }

    fn for_run(&self, copies: &mut Copies) -> Box<dyn ForceTerm> {
        Box::new(FaceBatch::for_run(self, copies))
    }
}
