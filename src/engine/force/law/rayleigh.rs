//! Rayleigh damping (Rayleigh 1877; any structural dynamics text): f = -(alpha M + beta K0) v.
//!
//! K0 = sum of k n n^T on the mesh as given: slack ignored, no geometric part, constant.
//! Power = -v^T (alpha M + beta K0) v, -df/dv = alpha M + beta K0, -df/dx = 0.

use crate::force::kernel::batch::{Batch, BlockForces, BufferReads, Elements, Kernel, PARTS, Records};
use crate::force::kernel::element_block::{ElementBlock, vector};
use crate::force::kernel::nodes::{self, NodeLaw};
use crate::force::law::spring::{Coefficient, Cut};
use crate::force::{Copies, ForceTerm, NodeState, TangentForm, TangentSink, outer};
use crate::model::forces::{Role, Tally};
use crate::model::quad::VectorUnit;
use crate::model::system::{TermInfo, Weights};
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

const fn constant_damping(name: &'static str) -> TermInfo {
    TermInfo { velocity_dependent: true, constant_damping: true, ..TermInfo::of(name, Role::Dissipative) }
}

/// The mass-proportional part.
#[derive(Clone, Debug)]
pub struct RayleighMass {
    /// [1/s] alpha
    pub factor: f64,
    /// [kg] lumped mass of every node
    pub mass: Arc<[f64]>,
}

impl BlockForces for RayleighMass {
    fn elements(&self) -> usize {
        self.mass.len()
    }

    fn reads(&self, _: [bool; PARTS]) -> BufferReads {
        BufferReads { x: false, v: true }
    }

    fn add(&self, block: &ElementBlock<'_>, [sum, _]: [Option<&mut Records>; PARTS]) -> [Tally; PARTS] {
        let power = sum.map_or(0.0, |f| nodes::add(self, None, block, f));
        [Tally { energy: 0.0, power }, Tally::default()]
    }
}

impl NodeLaw for RayleighMass {
    #[inline(always)]
    fn force<U: VectorUnit>(&self, unit: U, i: usize, _: U::Quad, v: U::Quad) -> [U::Quad; 2] {
        let force = unit.splat(-(self.factor * self.mass[i])) * v;
        [force, force * v]
    }
}

impl ForceTerm for RayleighMass {
    fn parts(&self) -> &[TermInfo] {
        const INFO: TermInfo = constant_damping("rayleigh mass damping");
        &[INFO]
    }

    fn by_mass(&self) -> bool {
        true
    }

    fn symmetric(&self) -> bool {
        true
    }

    fn tangent(&self, _at: NodeState<'_>, w: Weights, _: TangentForm, sink: &mut dyn TangentSink) {
        for (i, m) in self.mass.iter().enumerate() {
            sink.node(i as u32, Matrix3::from_diagonal_element(w.c * self.factor * m));
        }
    }

    fn for_run(&self, _: &mut Copies) -> Box<dyn ForceTerm> {
        Box::new(self.clone())
    }
}

/// The stiffness-proportional part.
pub type RayleighStiffness = Batch<RayleighData, 2>;

/// Plain arrays of the stiffness-proportional part.
#[derive(Clone, Debug)]
pub struct RayleighData {
    /// end nodes of every spring
    pub nodes: Arc<[[u32; 2]]>,
    /// [N s/m] beta k
    pub coefficient: Coefficient,
    /// unit vector of every spring on the mesh as given
    pub direction: Arc<[Vector3<f64>]>,
    /// which springs are cut or broken
    pub cut: Cut,
}

impl Kernel<2> for RayleighData {
    const READS: BufferReads = BufferReads { x: false, v: true };

    fn elements(&self) -> &[[u32; 2]] {
        &self.nodes
    }

    fn add(&self, block: Elements<'_, 2>, f: &mut Records) -> Tally {
        let power = block.each([1.0, -1.0], f, |i, [a, b]| {
            if self.cut.is_cut(i) {
                return (Vector3::zeros(), 0.0);
            }
            let n = self.direction[i];
            let rate = n.dot(&(vector(block.v, b) - vector(block.v, a)));
            let c = self.coefficient.at(i);
            (c * rate * n, -c * rate * rate)
        });
        Tally { energy: 0.0, power }
    }

    fn for_run(&self, copies: &mut Copies) -> Option<Self> {
        Some(RayleighData { cut: self.cut.for_run(copies), ..self.clone() })
    }
}

impl ForceTerm for RayleighStiffness {
    fn parts(&self) -> &[TermInfo] {
        const INFO: TermInfo = constant_damping("rayleigh stiffness damping");
        &[INFO]
    }

    fn symmetric(&self) -> bool {
        true
    }

    fn tangent(&self, _at: NodeState<'_>, w: Weights, _: TangentForm, sink: &mut dyn TangentSink) {
        let data = self.kernel();
        for (i, (&nodes, &n)) in data.nodes.iter().zip(data.direction.iter()).enumerate() {
            let c = if data.cut.is_cut(i) { 0.0 } else { w.c * data.coefficient.at(i) };
            sink.edge(nodes, outer(n, n) * c);
        }
    }

    fn for_run(&self, copies: &mut Copies) -> Box<dyn ForceTerm> {
        Box::new(Batch::for_run(self, copies))
    }
}
