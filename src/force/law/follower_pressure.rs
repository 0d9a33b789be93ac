//! Pressure along the current normal: p A N on a triangle, a third to each vertex.
//!
//! ```text
//! f_i = p S / 3,      -df_i/dx_j = -(p/6) [d_j]x      (not symmetric),      power = p S . mean(v)
//! ```

use crate::force::kernel::batch::{Records, Wants};
use crate::force::kernel::faces::{FaceBatch, FaceKernel, Faces};
use crate::force::kernel::pressure_kernel::{PressureLaw, Push, push};
use crate::force::law::series::{Table, factor};
use crate::force::law::triangle::{AreaVector, THIRD};
use crate::force::{ForceTerm, NodeState, TangentSink};
use crate::model::forces::{Role, Tally};
use crate::model::quad::VectorUnit;
use crate::model::system::{TermInfo, Weights};
use nalgebra::Matrix3;
use std::sync::Arc;

/// A follower pressure on a batch of triangles.
pub type FollowerPressure = FaceBatch<FollowerData>;

/// Plain data of the batch.
#[derive(Clone, Debug)]
pub struct FollowerData {
    /// vertices, right-handed about the side the pressure pushes to
    pub triangles: Arc<[[u32; 3]]>,
    /// [Pa] p
    pub pressure: f64,
    /// optional factor over time
    pub factor: Option<Arc<Table<1>>>,
}

impl FaceKernel for FollowerData {
    const WANTS: Wants = Wants { x: true, v: true };

    fn elements(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    fn add(&self, block: Faces<'_>, f: &mut Records) -> Tally {
        let pressure = self.pressure * factor(self.factor.as_ref(), block.t);
        Tally { energy: 0.0, power: push(&FollowerLaw { pressure }, &block, f) }
    }
}

struct FollowerLaw {
    /// [Pa]
    pressure: f64,
}

impl PressureLaw for FollowerLaw {
    #[inline(always)]
    fn push<U: VectorUnit>(&self, unit: U, s: [U::Quad; 3], v: [U::Quad; 3]) -> Push<U::Quad> {
        let share = unit.splat(THIRD * self.pressure);
        Push { share, amount: share * (s[0] * v[0] + s[1] * v[1] + s[2] * v[2]) }
    }
}

impl ForceTerm for FollowerPressure {
    fn info(&self) -> TermInfo {
        TermInfo { follower: true, on_triangles: true, ..TermInfo::of("follower pressure", Role::External) }
    }

    fn symmetric(&self) -> bool {
        false
    }

    fn tangent(&self, at: NodeState<'_>, w: Weights, sink: &mut dyn TangentSink) {
        let data = self.kernel();
        let p = data.pressure * factor(data.factor.as_ref(), at.t);
        for &nodes in data.triangles.iter() {
            let area = AreaVector::new(at.x, nodes);
            let row = [0, 1, 2].map(|j| area.derivative(j) * (-w.k * p / 3.0));
            sink.triangle(nodes, &[row; 3]);
        }
    }

    /// None: over a closed or held surface the symmetric part is that of its edge alone, of either sign.
    fn symmetric_tangent(&self, _at: NodeState<'_>, _w: Weights, sink: &mut dyn TangentSink) {
        for &nodes in self.kernel().triangles.iter() {
            sink.triangle(nodes, &[[Matrix3::zeros(); 3]; 3]);
        }
    }
}
