//! The force of the air on a canopy across its axis, spread over the cloth by its area.
//!
//! ```text
//! u = sum b_i v_i - wind,   b_i = share of a node in the area of the cloth,   u_n = u - (a . u) a
//! F = -m |u| u_n,   m = rho A/2,   f_i = b_i F,   power = f . v = F . (u + wind)
//! ```
//! A is the drag area: that which is given while a canopy fills, else that of its opening O = sum dCp S as a whole, |O|;
//! of a `cavity` (1 - Cp) |O|. Wind and density are those at the skirt, a is the axis (`axial_flow`). So drag and side
//! force together are a force against the motion, without lift: at a small angle of attack alpha the side force is alpha
//! times the drag, and the slope of the normal-force coefficient on S0 is CD0, 0.5 to 0.9 per radian. Measured slopes of
//! canopies that are stable are some tenths to 1. Canopies of tight cloth have none or less near alpha = 0, and so swing
//! up to the angle where it begins; that swinging is left out.
//!
//! It takes energy in every state: F . u = -m |u| |u_n|^2. All of its tangent is three parts of rank one, by the
//! components of F:
//! ```text
//! dF = -m [(u . du) u_n/|u| + |u| (I - a a^T) du - |u| ((a . u) da + a (u . da))] - |u| u_n dm
//! ```

use crate::force::kernel::batch::{BlockForces, BufferReads, PARTS, Records, SceneNumbers};
use crate::force::kernel::element_block::{ElementBlock, NodeVectors, SceneValues};
use crate::force::kernel::nodes::{self, NodeLaw};
use crate::force::law::axial_flow::AxialFlow;
use crate::force::law::canopy::CanopyData;
use crate::force::{ForceTerm, NodeState, RankOne, TangentForm, TangentSink};
use crate::model::forces::{Role, Tally};
use crate::model::quad::VectorUnit;
use crate::model::system::{TermInfo, Weights};
use nalgebra::Vector3;

/// The force of the air across the axis of a canopy.
#[derive(Clone, Debug)]
pub struct SideForce {
    /// nodes of the cloth, ascending
    pub nodes: Vec<u32>,
    /// [-] share of each in its area; they sum to 1
    pub share: Vec<f64>,
    /// the canopy
    pub canopy: CanopyData,
}

/// The air across the axis.
struct CrossFlow {
    flow: AxialFlow,
    /// [m/s] u
    velocity: Vector3<f64>,
    /// [m/s] |u|
    speed: f64,
    /// [m/s] u_n
    across: Vector3<f64>,
    /// [m^2] O
    opening: Vector3<f64>,
    /// [m^2] A
    area: f64,
    /// [-] dA/d|O|
    by_opening: f64,
}

impl SideForce {
    fn cross_flow(&self, t: f64, x: NodeVectors<'_>, v: NodeVectors<'_>) -> CrossFlow {
        let SideForce { nodes, share, canopy } = self;
        let flow = canopy.axis.flow(t, x, v);
        let mean: Vector3<f64> = nodes.iter().zip(share).map(|(&node, share)| *share * v.at(node)).sum();
        let velocity = mean - flow.air.wind[0];
        let across = velocity - flow.axis.dot(&velocity) * flow.axis;
        let (opening, area, by_opening) = match canopy.drag_area(t) {
            Some(area) => (Vector3::zeros(), area, 0.0),
            None => {
                let factor = canopy.cavity.as_ref().map_or(1.0, |cavity| 1.0 - cavity.spec.outer_pressure_coefficient);
                let opening = canopy.opening(x);
                (opening, factor * opening.norm(), factor)
            }
        };
        CrossFlow { flow, velocity, speed: velocity.norm(), across, opening, area, by_opening }
    }
}

impl CrossFlow {
    /// [N] F
    fn force(&self) -> Vector3<f64> {
        self.across * (-0.5 * self.flow.air.density[0] * self.area * self.speed)
    }
}

impl SceneNumbers for SideForce {
    fn count(&self) -> usize {
        3
    }

    /// F [N]
    fn find(&self, t: f64, x: NodeVectors<'_>, v: NodeVectors<'_>) -> SceneValues {
        let [x, y, z] = self.cross_flow(t, x, v).force().into();
        [x, y, z, 0.0, 0.0, 0.0]
    }
}

/// A force that nodes share.
struct Shared<'a> {
    /// [N] and a number that means nothing
    force: [f64; 4],
    share: &'a [f64],
}

impl NodeLaw for Shared<'_> {
    #[inline(always)]
    fn force<U: VectorUnit>(&self, unit: U, i: usize, _: U::Quad, v: U::Quad) -> [U::Quad; 2] {
        let force = unit.splat(self.share[i]) * unit.quad(self.force);
        [force, force * v]
    }
}

impl BlockForces for SideForce {
    fn elements(&self) -> usize {
        self.nodes.len()
    }

    fn reads(&self, _: [bool; PARTS]) -> BufferReads {
        BufferReads { x: false, v: true }
    }

    fn add(&self, block: &ElementBlock<'_>, [sum, _]: [Option<&mut Records>; PARTS]) -> [Tally; PARTS] {
        let [x, y, z, ..] = block.scene_numbers;
        let law = Shared { force: [x, y, z, 0.0], share: &self.share };
        let power = sum.map_or(0.0, |f| nodes::add(&law, Some(&self.nodes), block, f));
        [Tally { energy: 0.0, power }, Tally::default()]
    }

    fn scene_numbers(&self) -> Option<&dyn SceneNumbers> {
        Some(self)
    }
}

impl ForceTerm for SideForce {
    fn parts(&self) -> &[TermInfo] {
        const INFO: TermInfo =
            TermInfo { velocity_dependent: true, follower: true, ..TermInfo::of("canopy side force", Role::External) };
        &[INFO]
    }

    fn symmetric(&self) -> bool {
        false
    }

    fn tangent(&self, _at: NodeState<'_>, _w: Weights, _: TangentForm, _sink: &mut dyn TangentSink) {}

    fn rank_one(&self, which: usize, at: NodeState<'_>, w: Weights, RankOne { u, g }: RankOne<'_>) {
        u.fill(Vector3::zeros());
        g.fill(Vector3::zeros());
        let SideForce { nodes, share, canopy } = self;
        let found = self.cross_flow(at.t, NodeVectors::Nodes(at.x), NodeVectors::Nodes(at.v));
        let CrossFlow { flow, velocity, speed, across, opening, area, by_opening } = found;
        if which >= 3 || speed == 0.0 {
            return;
        }
        let AxialFlow { axis, air, .. } = flow;
        let ([density, _], [_, shear]) = (air.density, air.wind);
        let m = 0.5 * density * area;
        let mut component = Vector3::zeros();
        component[which] = 1.0;
        let by_velocity = -m * (across[which] / speed * velocity + speed * (component - axis[which] * axis));
        for (&node, share) in nodes.iter().zip(share) {
            u[node as usize][which] = -share;
            g[node as usize] += w.c * *share * by_velocity;
        }
        let canopy_axis = &canopy.axis;
        canopy_axis.add_height_gradient(-w.k * by_velocity.dot(&shear), g);
        let along = axis.dot(&velocity);
        canopy_axis.add_turn(flow, w.k * m * speed * (along * component + axis[which] * velocity), g);
        let by_half_density = -speed * across[which];
        canopy_axis.add_density_gradient(flow, 0.5 * w.k * area * by_half_density, g);
        if by_opening != 0.0 && area > 0.0 {
            let by_area = 0.5 * w.k * density * by_half_density * by_opening;
            canopy.add_opening_gradient(at.x, by_area * opening.normalize(), g);
        }
    }
}
