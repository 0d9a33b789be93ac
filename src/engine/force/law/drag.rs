//! The drag of lines and of bodies at nodes, in the air around them.
//!
//! ```text
//! line:  d = x_b - x_a, L = |d|, e = d/L,  u = wind - (v_a + v_b)/2,  V_n = u - (u . e) e
//!        f = rho Cd D L |V_n| V_n/2, half to each end
//! node:  u = wind - v,  f = rho CdS |u| u/2,  CdS by stages over time where the node is a canopy; with the lift of a
//!        `glide` this is multiplied by a matrix
//! ```
//! Wind and density are those at the height of the segment's middle, or of the node. With h = rho Cd D/2,
//! P = I - e e^T and G = |V_n| I + V_n V_n^T/|V_n|, the exact tangents of the whole force are
//! ```text
//! df/du = h L G P,    df/dd = f e^T/L - h ((e . u) G P + |V_n| e V_n^T),    df/dz = f rho'/rho + (df/du) dw/dz
//! ```

use crate::force::kernel::batch::{Batch, BufferReads, Elements, Kernel, Records};
use crate::force::kernel::element_block::vector;
use crate::force::law::glide::Glide;
use crate::force::law::stages::Stages;
use crate::force::law::stream::{AirState, Stream};
use crate::force::{Copies, ForceTerm, NodeState, TangentForm, TangentSink, outer};
use crate::model::forces::{Role, Tally};
use crate::model::system::{TermInfo, Weights};
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// The drag of lines.
pub type LineDrag = Batch<LineDragData, 2>;

/// Plain data of the lines.
#[derive(Clone, Debug)]
pub struct LineDragData {
    /// ends of the segments
    pub segments: Arc<[[u32; 2]]>,
    /// [m] Cd times diameter
    pub width: f64,
    /// the air around them
    pub stream: Arc<Stream>,
}

/// The drag of nodes.
pub type NodeDrag = Batch<NodeDragData, 1>;

/// Plain data of the nodes.
#[derive(Clone, Debug)]
pub struct NodeDragData {
    /// the nodes
    pub nodes: Arc<[[u32; 1]]>,
    /// [m^2] drag area of each
    pub drag_area: f64,
    /// stages of what is added to it; none but for canopies that are points
    pub stages: Stages,
    /// lift, if they glide
    pub glide: Option<Glide>,
    /// the air around them
    pub stream: Arc<Stream>,
}

/// The drag of nodes.
const NODES: TermInfo = TermInfo { velocity_dependent: true, ..TermInfo::of("drag", Role::External) };

/// The drag of lines.
const LINES: TermInfo = TermInfo { name: "line drag", follower: true, ..NODES };

/// A force and what it depends on.
struct Drag {
    /// [N]
    force: Vector3<f64>,
    /// [N s/m] by the wind relative to the body
    by_wind: Matrix3<f64>,
    /// [N/m] by the vector between the ends of a line
    by_side: Matrix3<f64>,
    /// [N/m] by the height
    by_height: Vector3<f64>,
}

/// |V| I + V V^T/|V|, 0 in calm air.
fn gradient(v: Vector3<f64>) -> Matrix3<f64> {
    let speed = v.norm();
    if speed > 0.0 { Matrix3::from_diagonal_element(speed) + outer(v, v) / speed } else { Matrix3::zeros() }
}

/// The unit vector and the length of a segment; 0 for one of no length.
fn direction(d: Vector3<f64>) -> (Vector3<f64>, f64) {
    let length = d.norm();
    (if length > 0.0 { d / length } else { Vector3::zeros() }, length)
}

impl LineDragData {
    /// [N] The force of a segment by its vector `d` [m], the sum of the velocities of its ends [m/s], and the air.
    fn force(&self, d: Vector3<f64>, v: Vector3<f64>, air: &AirState) -> Vector3<f64> {
        let (e, length) = direction(d);
        let u = air.wind[0] - 0.5 * v;
        let normal = u - e.dot(&u) * e;
        normal * (0.5 * air.density[0] * self.width * length * normal.norm())
    }

    fn drag(&self, d: Vector3<f64>, v: Vector3<f64>, air: &AirState) -> Drag {
        let force = self.force(d, v, air);
        let ((e, length), u) = (direction(d), air.wind[0] - 0.5 * v);
        let along = e.dot(&u);
        let normal = u - along * e;
        let half = 0.5 * air.density[0] * self.width;
        let across = gradient(normal) * (Matrix3::identity() - outer(e, e));
        let by_wind = across * (half * length);
        let stretched = if length > 0.0 { outer(force, e) / length } else { Matrix3::zeros() };
        let by_side = stretched - (across * along + outer(e, normal) * normal.norm()) * half;
        let by_height = force * (air.density[1] / air.density[0]) + by_wind * air.wind[1];
        Drag { force, by_wind, by_side, by_height }
    }
}

impl Kernel<2> for LineDragData {
    const READS: BufferReads = BufferReads { x: true, v: true };

    fn elements(&self) -> &[[u32; 2]] {
        &self.segments
    }

    fn add(&self, block: Elements<'_, 2>, f: &mut Records) -> Tally {
        let Elements { t, x, v, .. } = block;
        let power = block.each([0.5, 0.5], f, |_, nodes| {
            let ([xa, xb], [va, vb]) = (nodes.map(|i| vector(x, i)), nodes.map(|i| vector(v, i)));
            let air = self.stream.at(t, 0.5 * (xa.z + xb.z));
            let force = self.force(xb - xa, va + vb, &air);
            (force, 0.5 * force.dot(&(va + vb)))
        });
        Tally { energy: 0.0, power }
    }

    fn for_run(&self, copies: &mut Copies) -> Option<Self> {
        Some(LineDragData { stream: copies.of(&self.stream), ..self.clone() })
    }
}

impl ForceTerm for LineDrag {
    fn parts(&self) -> &[TermInfo] {
        &[LINES]
    }

    fn symmetric(&self) -> bool {
        false
    }

    /// The symmetric form is the velocity part.
    fn tangent(&self, at: NodeState<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink) {
        let data = self.kernel();
        for &nodes in data.segments.iter() {
            let ([xa, xb], [va, vb]) = (nodes.map(|i| at.x[i as usize]), nodes.map(|i| at.v[i as usize]));
            let air = data.stream.at(at.t, 0.5 * (xa.z + xb.z));
            let Drag { by_wind, by_side, by_height, .. } = data.drag(xb - xa, va + vb, &air);
            let damping = by_wind * (0.25 * w.c);
            let row = if form.symmetric {
                [damping; 2]
            } else {
                let height = outer(by_height, Vector3::z()) * 0.5;
                [(by_side - height) * (0.5 * w.k) + damping, (-by_side - height) * (0.5 * w.k) + damping]
            };
            sink.segment(nodes, &[row; 2]);
        }
    }

    fn for_run(&self, copies: &mut Copies) -> Box<dyn ForceTerm> {
        Box::new(Batch::for_run(self, copies))
    }
}

impl NodeDragData {
    /// [N] The force on a node at a place [m] with a velocity [m/s].
    pub fn force(&self, t: f64, x: Vector3<f64>, v: Vector3<f64>) -> Vector3<f64> {
        self.with_lift(t, self.drag(t, v, &self.stream.at(t, x.z))).force
    }

    /// A drag with its lift.
    fn with_lift(&self, t: f64, drag: Drag) -> Drag {
        let Some(glide) = &self.glide else { return drag };
        let Drag { force, by_wind, by_side, by_height } = drag;
        let m = glide.matrix(t);
        Drag { force: m * force, by_wind: m * by_wind, by_side, by_height: m * by_height }
    }

    fn drag(&self, t: f64, v: Vector3<f64>, air: &AirState) -> Drag {
        let u = air.wind[0] - v;
        let half = 0.5 * air.density[0] * (self.drag_area + self.stages.area_at(t));
        let (force, by_wind) = (u * (half * u.norm()), gradient(u) * half);
        let by_height = force * (air.density[1] / air.density[0]) + by_wind * air.wind[1];
        Drag { force, by_wind, by_side: Matrix3::zeros(), by_height }
    }
}

impl Kernel<1> for NodeDragData {
    const READS: BufferReads = BufferReads { x: true, v: true };

    fn elements(&self) -> &[[u32; 1]] {
        &self.nodes
    }

    fn add(&self, block: Elements<'_, 1>, f: &mut Records) -> Tally {
        let Elements { t, x, v, .. } = block;
        let power = block.each([1.0], f, |_, [node]| {
            let v = vector(v, node);
            let force = self.force(t, vector(x, node), v);
            (force, force.dot(&v))
        });
        Tally { energy: 0.0, power }
    }

    fn for_run(&self, copies: &mut Copies) -> Option<Self> {
        let (stages, glide) = (self.stages.for_run(copies), self.glide.as_ref().map(|glide| glide.for_run(copies)));
        Some(NodeDragData { stream: copies.of(&self.stream), stages, glide, ..self.clone() })
    }
}

impl ForceTerm for NodeDrag {
    fn parts(&self) -> &[TermInfo] {
        &[NODES]
    }

    fn symmetric(&self) -> bool {
        self.kernel().stream.is_uniform() && self.kernel().glide.is_none()
    }

    /// The symmetric form is the velocity part of the drag: that of the lift is not symmetric.
    fn tangent(&self, at: NodeState<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink) {
        let data = self.kernel();
        for &[node] in data.nodes.iter() {
            let (x, v) = (at.x[node as usize], at.v[node as usize]);
            let drag = data.drag(at.t, v, &data.stream.at(at.t, x.z));
            let (drag, k) = if form.symmetric { (drag, 0.0) } else { (data.with_lift(at.t, drag), w.k) };
            sink.node(node, drag.by_wind * w.c - outer(drag.by_height, Vector3::z()) * k);
        }
    }

    fn for_run(&self, copies: &mut Copies) -> Box<dyn ForceTerm> {
        Box::new(Batch::for_run(self, copies))
    }
}
