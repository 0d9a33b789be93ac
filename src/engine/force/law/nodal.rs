//! Forces that do not depend on the state: nodal forces, dead pressure and snow lumped to their nodes, and what a
//! program sets.
//!
//! f = factor(t) F, tangents zero, power = f . v.

use crate::force::kernel::batch::{BlockForces, BufferReads, PARTS, Records};
use crate::force::kernel::element_block::ElementBlock;
use crate::force::kernel::nodes::{self, NodeLaw, padded};
use crate::force::law::series::LoadFactor;
use crate::force::law::triangle::AreaVector;
use crate::force::{Copies, ForceTerm, NodeState, TangentForm, TangentSink};
use crate::model::forces::{Role, Tally};
use crate::model::quad::VectorUnit;
use crate::model::system::{TermInfo, Weights};
use nalgebra::Vector3;
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard};

/// Forces that are given node by node.
pub const FORCES: TermInfo = TermInfo::of("forces", Role::External);

/// Forces of a pressure on the nodes of its triangles.
const DEAD_PRESSURE: TermInfo = TermInfo { name: "dead pressure", on_triangles: true, ..FORCES };

/// The same of a load on the plan.
const PLAN_LOAD: TermInfo = TermInfo { name: "snow", ..DEAD_PRESSURE };

/// Given forces on some nodes.
#[derive(Clone, Debug)]
pub struct NodalForces {
    /// [`FORCES`], or those of a dead pressure
    pub info: TermInfo,
    /// the nodes, ascending
    pub nodes: Arc<[u32]>,
    /// [N] force on each of them at factor 1
    pub force: Arc<[Vector3<f64>]>,
    /// factor over time
    pub factor: LoadFactor,
}

/// A pressure on the initial areas.
#[derive(Clone, Debug)]
pub struct DeadPressure<'a> {
    /// the triangles
    pub triangles: &'a [[u32; 3]],
    /// [Pa] pressure
    pub pressure: f64,
    /// unit direction; `None` = every triangle's own normal at the start
    pub direction: Option<Vector3<f64>>,
    /// factor over time
    pub factor: LoadFactor,
}

impl DeadPressure<'_> {
    /// Lumps p A0 (direction) to the vertices, a third each, at the node positions `x` [m] `[n_nodes]`.
    pub fn lump(self, x: &[Vector3<f64>]) -> NodalForces {
        let (nodes, force) =
            lumped(self.triangles, x, |s| self.pressure / 3.0 * self.direction.map_or(s, |d| s.norm() * d));
        NodalForces { info: DEAD_PRESSURE, nodes, force, factor: self.factor }
    }
}

/// A load per area of the plan, such as snow: on the initial areas as seen along its direction d.
///
/// ```text
/// f_i = s |S . d| d/3
/// ```
/// Codes give snow by the plan of the structure as built: where the cloth sags, as much snow lies on it as before.
#[derive(Clone, Debug)]
pub struct PlanLoad<'a> {
    /// the triangles
    pub triangles: &'a [[u32; 3]],
    /// \[N/m^2\] s
    pub load: f64,
    /// unit vector d, downwards
    pub direction: Vector3<f64>,
    /// factor over time
    pub factor: LoadFactor,
}

impl PlanLoad<'_> {
    /// Lumps the load to the vertices, a third each, at the node positions `x` [m] `[n_nodes]`.
    pub fn lump(self, x: &[Vector3<f64>]) -> NodalForces {
        let (nodes, force) =
            lumped(self.triangles, x, |s| self.load / 3.0 * s.dot(&self.direction).abs() * self.direction);
        NodalForces { info: PLAN_LOAD, nodes, force, factor: self.factor }
    }
}

/// The nodes with a force and their forces [N], `share` being what each vertex gets by the area vector of a triangle.
fn lumped(
    triangles: &[[u32; 3]],
    x: &[Vector3<f64>],
    share: impl Fn(Vector3<f64>) -> Vector3<f64>,
) -> (Arc<[u32]>, Arc<[Vector3<f64>]>) {
    let mut sum = vec![Vector3::zeros(); x.len()];
    for &nodes in triangles {
        let force = share(AreaVector::new(x, nodes).s);
        for i in nodes {
            sum[i as usize] += force;
        }
    }
    let nodes: Arc<[u32]> = (0..x.len() as u32).filter(|&i| sum[i as usize] != Vector3::zeros()).collect();
    let force = nodes.iter().map(|&i| sum[i as usize]).collect();
    (nodes, force)
}

/// The forces at one time.
struct ScaledForces<'a> {
    forces: &'a [Vector3<f64>],
    factor: f64,
}

impl NodeLaw for ScaledForces<'_> {
    #[inline(always)]
    fn force<U: VectorUnit>(&self, unit: U, i: usize, _: U::Quad, v: U::Quad) -> [U::Quad; 2] {
        let force = unit.splat(self.factor) * unit.quad(padded(self.forces, i));
        [force, force * v]
    }
}

impl BlockForces for NodalForces {
    fn elements(&self) -> usize {
        self.nodes.len()
    }

    fn reads(&self, _: [bool; PARTS]) -> BufferReads {
        BufferReads { x: false, v: true }
    }

    fn add(&self, block: &ElementBlock<'_>, [sum, _]: [Option<&mut Records>; PARTS]) -> [Tally; PARTS] {
        let law = ScaledForces { forces: &self.force, factor: self.factor.at(block.t) };
        let power = sum.map_or(0.0, |f| nodes::add(&law, Some(&self.nodes), block, f));
        [Tally { energy: 0.0, power }, Tally::default()]
    }
}

impl ForceTerm for NodalForces {
    fn parts(&self) -> &[TermInfo] {
        std::slice::from_ref(&self.info)
    }

    fn symmetric(&self) -> bool {
        true
    }

    fn tangent(&self, _at: NodeState<'_>, _w: Weights, _: TangentForm, _sink: &mut dyn TangentSink) {}

    fn for_run(&self, copies: &mut Copies) -> Box<dyn ForceTerm> {
        Box::new(NodalForces { factor: self.factor.for_run(copies), ..self.clone() })
    }
}

/// Forces on all nodes that a program sets while a simulation runs; the program's copy shares them with the term.
#[derive(Clone, Debug)]
pub struct SetForces(Arc<Values>);

/// [N] `[n_nodes]`
#[derive(Debug)]
struct Values(RwLock<Vec<Vector3<f64>>>);

impl Clone for Values {
    fn clone(&self) -> Self {
        Values(RwLock::new(self.0.read().unwrap_or_else(PoisonError::into_inner).clone()))
    }
}

impl SetForces {
    /// No force on any of so many nodes.
    pub fn zero(nodes: usize) -> Self {
        SetForces(Arc::new(Values(RwLock::new(vec![Vector3::zeros(); nodes]))))
    }

    /// Sets the force [N] on every node, between two steps.
    pub fn set(&self, forces: impl Iterator<Item = Vector3<f64>>) {
        let mut to = self.0.0.write().unwrap_or_else(PoisonError::into_inner);
        to.iter_mut().zip(forces).for_each(|(to, force)| *to = force);
    }

    fn forces(&self) -> RwLockReadGuard<'_, Vec<Vector3<f64>>> {
        self.0.0.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// Those of another run, at first the same.
    #[must_use]
    pub(crate) fn for_run(&self, copies: &mut Copies) -> Self {
        SetForces(copies.of(&self.0))
    }
}

impl BlockForces for SetForces {
    fn elements(&self) -> usize {
        self.forces().len()
    }

    fn reads(&self, _: [bool; PARTS]) -> BufferReads {
        BufferReads { x: false, v: true }
    }

    fn add(&self, block: &ElementBlock<'_>, [sum, _]: [Option<&mut Records>; PARTS]) -> [Tally; PARTS] {
        let law = ScaledForces { forces: &self.forces(), factor: 1.0 };
        let power = sum.map_or(0.0, |f| nodes::add(&law, None, block, f));
        [Tally { energy: 0.0, power }, Tally::default()]
    }
}

impl ForceTerm for SetForces {
    fn parts(&self) -> &[TermInfo] {
        const INFO: TermInfo = TermInfo::of("external forces", Role::External);
        &[INFO]
    }

    fn symmetric(&self) -> bool {
        true
    }

    fn tangent(&self, _at: NodeState<'_>, _w: Weights, _: TangentForm, _sink: &mut dyn TangentSink) {}

    fn for_run(&self, copies: &mut Copies) -> Box<dyn ForceTerm> {
        Box::new(SetForces::for_run(self, copies))
    }
}
