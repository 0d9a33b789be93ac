//! Two-node bars with an elastic law that a program supplies.
//!
//! ```text
//! f_a = T(l) n,   f_b = -T(l) n,   n = (x_b - x_a)/l
//! B   = T' n n^T + T/l (I - n n^T)          K = [[B, -B], [-B, B]]
//! ```

use crate::force::kernel::batch::{Batch, BufferReads, Elements, Kernel, Records};
use crate::force::kernel::element_block::vector;
use crate::force::law::curve::{MeanTension, Tension};
use crate::force::law::mean_bar::MeanBar;
use crate::force::{Copies, ForceTerm, MeanForce, MeanStep, NodeState, TangentForm, TangentSink, outer};
use crate::mesh::unit_vector::unit_vector;
use crate::model::forces::{Role, Tally};
use crate::model::system::{TermInfo, Weights};
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// Values of a law for a bar at one length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BarForce {
    /// [N] tension T, positive in tension
    pub tension: f64,
    /// [N/m] dT/dl, for implicit methods
    pub stiffness: f64,
    /// [J] energy stored, whose derivative by the length is the tension
    pub energy: f64,
}

/// An elastic law of two-node bars: a pure function of length and rest length. The tension may have a kink, where the
/// stiffness is that of either side; adaptive steps do not end there, as they do where springs go slack. Kang's filter
/// leaves such bars out: they are explicit in it.
pub trait BarLaw: Send + Sync {
    /// Tension, its derivative and the energy of a bar of this length [m] with this rest length [m]. The account closes
    /// only if the energy is the integral of the tension, and Newton converges only if the stiffness is its derivative.
    fn at(&self, length: f64, rest_length: f64) -> BarForce;
}

/// Bars that share a law, in the numbering of the mesh. They are no edges: frames and
/// [`Simulation::tensions`](crate::simulation::Simulation::tensions) have springs only, so a program that wants their
/// tension calls the law.
#[derive(Clone)]
pub struct Bars {
    /// end nodes, `[n_bars]`
    pub pairs: Vec<[u32; 2]>,
    /// [m] rest lengths, `[n_bars]`
    pub rest_length: Vec<f64>,
    /// the law
    pub law: Arc<dyn BarLaw>,
}

/// The term of such bars.
pub type LawBars = Batch<BarData, 2>;

/// Plain arrays of the bars, in internal numbering.
#[derive(Clone)]
pub struct BarData {
    /// end nodes of every bar, in ascending order of the smaller
    pub nodes: Vec<[u32; 2]>,
    /// [m] rest length of every bar
    pub rest_length: Vec<f64>,
    /// the law
    pub law: Arc<dyn BarLaw>,
}

impl BarData {
    /// The force [N] and its direction at bar `i` with this vector [m] from its first to its second end.
    fn bar(&self, i: usize, d: Vector3<f64>) -> (BarForce, Vector3<f64>, f64) {
        let length = d.norm();
        (self.law.at(length, self.rest_length[i]), unit_vector(d).unwrap_or_default(), length)
    }

    fn emit(&self, at: NodeState<'_>, k: f64, sink: &mut dyn TangentSink, change: impl Fn(f64) -> f64) {
        for (i, &nodes) in self.nodes.iter().enumerate() {
            let [a, b] = nodes.map(|node| at.x[node as usize]);
            let (force, n, length) = self.bar(i, b - a);
            let along = outer(n, n);
            let across = if length > 0.0 { change(force.tension / length) } else { 0.0 };
            sink.edge(nodes, (along * change(force.stiffness) + (Matrix3::identity() - along) * across) * k);
        }
    }
}

/// [-] Changes of length over the rest length below which the tension at the mean length is the mean tension to
/// rounding. The quotient of the energies would be less exact.
const SHORT: f64 = 1e-5;

impl BarData {
    /// Bar `i` over a step; its law is any function.
    fn mean_bar(&self, step: MeanStep<'_>, i: usize) -> MeanBar {
        let rest = self.rest_length[i];
        MeanBar::new(step.sides(self.nodes[i]), |lengths @ [l0, l1]| {
            let [start, end] = lengths.map(|l| self.law.at(l, rest));
            let way = l1 - l0;
            let mean = if way.abs() > SHORT * rest.max(l0) {
                let force = (end.energy - start.energy) / way;
                MeanTension { force, slope: (end.tension - force) / way }
            } else {
                let middle = self.law.at(0.5 * (l0 + l1), rest);
                MeanTension { force: middle.tension, slope: 0.5 * middle.stiffness }
            };
            let tension = |at: BarForce| Tension { force: at.tension, slope: at.stiffness, energy: at.energy };
            mean.dissipating(lengths, [start, end].map(tension), step.mean.dissipation)
        })
    }
}

impl Kernel<2> for BarData {
    const READS: BufferReads = BufferReads { x: true, v: false };

    fn elements(&self) -> &[[u32; 2]] {
        &self.nodes
    }

    fn add(&self, block: Elements<'_, 2>, f: &mut Records) -> Tally {
        let energy = block.each([1.0, -1.0], f, |i, [a, b]| {
            let (force, n, _) = self.bar(i, vector(block.x, b) - vector(block.x, a));
            (force.tension * n, force.energy)
        });
        Tally { energy, power: 0.0 }
    }
}

impl ForceTerm for LawBars {
    fn parts(&self) -> &[TermInfo] {
        const INFO: TermInfo = TermInfo::of("bars", Role::Elastic);
        &[INFO]
    }

    fn symmetric(&self) -> bool {
        true
    }

    fn tangent(&self, at: NodeState<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink) {
        self.kernel().emit(at, w.k, sink, |k| if form.convex { k.max(0.0) } else { k });
    }

    fn mean(&self) -> Option<&dyn MeanForce> {
        Some(self)
    }

    fn add_stiffness(&self, nodes: &mut [f64]) {
        let data = self.kernel();
        for (ends, &rest) in data.nodes.iter().zip(&data.rest_length) {
            let k = data.law.at(rest, rest).stiffness.abs();
            ends.iter().for_each(|&node| nodes[node as usize] += k);
        }
    }

    fn for_run(&self, copies: &mut Copies) -> Box<dyn ForceTerm> {
        Box::new(Batch::for_run(self, copies))
    }
}

impl MeanForce for LawBars {
    fn add_mean(&self, step: MeanStep<'_>, f: &mut [Vector3<f64>]) -> Tally {
        let data = self.kernel();
        (0..).zip(&data.nodes).for_each(|(i, &nodes)| data.mean_bar(step, i).add(nodes, f));
        Tally::default()
    }

    fn mean_tangent(&self, step: MeanStep<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink) {
        let data = self.kernel();
        (0..).zip(&data.nodes).for_each(|(i, &nodes)| sink.edge(nodes, data.mean_bar(step, i).block(form) * w.k));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::system::StepMean;

    /// T = k e + q e^3.
    struct Cubic;

    impl BarLaw for Cubic {
        fn at(&self, length: f64, rest_length: f64) -> BarForce {
            let e = length - rest_length;
            BarForce {
                tension: 70.0 * e + 900.0 * e.powi(3),
                stiffness: 70.0 + 2700.0 * e * e,
                energy: 35.0 * e * e + 225.0 * e.powi(4),
            }
        }
    }

    fn data() -> BarData {
        BarData { nodes: vec![[0, 1]], rest_length: vec![1.1], law: Arc::new(Cubic) }
    }

    /// The force on the first end over a step with these vectors between the ends.
    fn force(middle: Vector3<f64>, change: Vector3<f64>, dissipation: f64) -> (Vector3<f64>, MeanBar) {
        let (x, v) = ([Vector3::zeros(), middle], [Vector3::zeros(), change]);
        let at = NodeState { t: 0.0, x: &x, v: &v };
        let bar = data().mean_bar(MeanStep { at, mean: StepMean { half: 1.0, dissipation } }, 0);
        let mut f = [Vector3::zeros(); 2];
        bar.add([0, 1], &mut f);
        assert_eq!(f[0], -f[1]);
        (f[0], bar)
    }

    /// The work of a step is the change of the energy, whether the bar changes much or hardly; dissipation takes some.
    #[test]
    fn the_mean_force_of_any_law_does_the_work_of_its_energy() {
        let (middle, way) = (Vector3::new(1.0, 0.3, -0.2), Vector3::new(0.2, -0.1, 0.15));
        for size in [1.0, 1e-2, 1e-4, 1e-5, 1e-6, 1e-9] {
            let change = way * size;
            let energy = |d: Vector3<f64>| Cubic.at(d.norm(), 1.1).energy;
            let gain = energy(middle + change) - energy(middle - change);
            let work = |chi: f64| 2.0 * force(middle, change, chi).0.dot(&change);
            assert!((work(0.0) - gain).abs() < 3e-15, "{size}: {} and not {gain}", work(0.0));
            assert!(work(1.0) > work(0.0), "{size}");
        }
    }

    /// The middle moves, and the start stays.
    #[test]
    fn its_tangent_equals_differences() {
        let (middle, change) = (Vector3::new(1.0, 0.3, -0.2), Vector3::new(0.2, -0.1, 0.15));
        for (size, chi) in [(1.0, 0.0), (1.0, 0.6), (1e-7, 0.0)] {
            let block = force(middle, change * size, chi).1.block(TangentForm::EXACT);
            for axis in 0..3 {
                let d = 1e-5;
                let moved = |by: f64| {
                    let mut step = Vector3::zeros();
                    step[axis] = by;
                    force(middle + step, change * size + step, chi).0
                };
                let difference = (moved(d) - moved(-d)) / (2.0 * d);
                let off = (block.column(axis) - difference).norm();
                assert!(off < 1e-6 * block.norm(), "{size}, {axis}: {off}");
            }
        }
    }
}
