//! Springs, slack or not ([`crate::force::law::spring`]), with their dashpots ([`crate::force::law::dashpot`]), in
//! one pass.
//!
//! ```text
//! force on a = T n + T_d n + c (vb - va),  on b the opposite          n = (xb - xa)/l
//! -df/dx = [[B, -B], [-B, B]],  -df/dv = [[D, -D], [-D, D]]          B and D: see the two laws
//! ```

mod mixed;

use crate::force::kernel::bar_batch::{BarBatch, Bars};
use crate::force::kernel::batch::{BlockForces, BufferReads, PARTS, Records};
use crate::force::kernel::differences::Differences;
use crate::force::kernel::element_block::ElementBlock;
use crate::force::kernel::star_batches::{AxialForce, AxialLaw, Measured};
use crate::force::law::curve::{Bar, CurveKind, Tension};
use crate::force::law::dashpot::{self, Damping};
use crate::force::law::mean_bar::MeanBar;
use crate::force::law::slack::{Clamp, TensionLaw, tension, with_law};
use crate::force::law::spring::{Coefficient, Cut, SpringData, SpringsAt, Stretch};
use crate::force::law::stretch::{InLocalBuffer, SpringLengths, largest};
use crate::force::{Copies, ForceTerm, MeanForce, MeanStep, NodeState, SpringTerm, TangentForm, TangentSink, outer};
use crate::model::forces::{Role, Tally};
use crate::model::quad::Real;
use crate::model::spec::DashpotKind;
use crate::model::system::{TermInfo, Weights};
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;
use std::sync::Arc;

const SPRINGS: TermInfo = TermInfo { linear_springs: true, ..BARS };
const BARS: TermInfo = TermInfo::of("springs", Role::Elastic);
const AXIAL: TermInfo = dashpots("axial dashpots");
const RELATIVE: TermInfo = TermInfo { constant_damping: true, ..dashpots("relative dashpots") };

const fn dashpots(name: &'static str) -> TermInfo {
    TermInfo { velocity_dependent: true, spring_dashpots: true, ..TermInfo::of(name, Role::Dissipative) }
}

/// Dashpots of a batch of springs.
#[derive(Clone, Debug)]
pub struct Dashpots {
    /// along the springs, or on the relative velocity
    pub kind: DashpotKind,
    /// [N s/m] c
    pub coefficient: Coefficient,
}

/// Springs with their dashpots as a force term of one or two parts: elastic, and damping.
#[derive(Clone, Debug)]
pub struct DampedSprings {
    springs: SpringData,
    dashpots: Option<Dashpots>,
    cut: Cut,
    batch: Arc<BarBatch>,
    /// of relative dashpots
    differences: Arc<Differences>,
}

impl DampedSprings {
    /// Node numbers must be below the number of nodes that the term will be used with, and springs in ascending order
    /// of their smaller node.
    pub fn new(springs: SpringData, dashpots: Option<Dashpots>) -> Self {
        DampedSprings { springs, dashpots, cut: Cut::default(), batch: Arc::default(), differences: Arc::default() }
    }

    /// The same springs, which carry nothing while they are cut or broken.
    #[must_use]
    pub fn cut_with(self, cut: Cut) -> Self {
        DampedSprings { cut, ..self }
    }

    fn kind(&self) -> Option<DashpotKind> {
        self.dashpots.as_ref().map(|dashpots| dashpots.kind)
    }

    /// Emits the elastic block of every spring, and those of dashpots at a state.
    fn emit(
        &self,
        law: impl TensionLaw,
        (at, w, form): (NodeState<'_>, Weights, TangentForm),
        sink: &mut dyn TangentSink,
        elastic_block: impl Fn(usize, (Stretch, Tension)) -> Matrix3<f64>,
    ) {
        let springs = &self.springs;
        let (as_taut, clamp) = (self.cut.slack_is_taut(), Clamp::or_none(springs.slack));
        let springs_at = springs.at(at.t, at.x);
        for (i, &nodes) in springs.nodes.iter().enumerate() {
            if self.cut.is_cut(i) {
                // The pattern of the matrix stays.
                sink.edge(nodes, Matrix3::zeros());
                continue;
            }
            let mut stretch = springs.stretch(springs_at, i);
            let taut = if as_taut { clamp.taut(stretch.elongation) } else { stretch.elongation };
            let went_taut = taut != stretch.elongation;
            stretch.elongation = taut;
            let elastic = (stretch, law.at(springs.bar(springs_at, i), taut));
            let mut block = elastic_block(i, elastic) * w.k;
            if let Some(Dashpots { kind, coefficient }) = &self.dashpots {
                let c = coefficient.at(i);
                let axial = || axial_state(springs, elastic, at.v, (i, c));
                block += match kind {
                    DashpotKind::Relative => Matrix3::from_diagonal_element(w.c * c),
                    // Whatever its ends do now.
                    DashpotKind::Axial if went_taut => outer(stretch.n, stretch.n) * (w.c * c),
                    DashpotKind::Axial if form.symmetric => axial().velocity_tangent(w),
                    DashpotKind::Axial => axial().tangent(w),
                };
            }
            sink.edge(nodes, block);
        }
    }

    /// Adds the forces of the parts, one after the other, where rest lengths are times a factor. Returns also dE/ds,
    /// negative [J].
    fn reeled_force<L: TensionLaw>(
        &self,
        (law, s): (L, f64),
        block: &ElementBlock<'_>,
        [elastic, damping]: [Option<&mut Records>; 2],
    ) -> [f64; 3] {
        let Some(bars) = self.batch.bars(block.number, &self.cut) else { return [0.0; 3] };
        let power = match (damping, self.kind()) {
            (Some(f), Some(DashpotKind::Relative)) => self.relative_force(bars, block, f),
            (damping @ Some(_), Some(DashpotKind::Axial)) => {
                bars.axial_force(&Reeled::<L, false, true>(law, s), block, [None, damping])[1]
            }
            _ => 0.0,
        };
        let [energy, pull] = match elastic {
            Some(_) => bars.axial_force(&Reeled::<L, true, false>(law, s), block, [elastic, None]),
            None => [0.0; 2],
        };
        [energy, power, pull]
    }

    /// Adds the forces of relative dashpots; returns their power [W].
    fn relative_force(&self, bars: Bars<'_>, block: &ElementBlock<'_>, f: &mut Records) -> f64 {
        match bars.some_broken() {
            true => bars.differences(block.v, f),
            false => self.differences.add(block.number, block.v, f),
        }
    }

    /// Adds the forces of both parts, or of one of them.
    fn axial_force<L: TensionLaw>(
        &self,
        law: L,
        block: &ElementBlock<'_>,
        [elastic, damping]: [Option<&mut Records>; 2],
    ) -> [f64; 2] {
        let Some(bars) = self.batch.bars(block.number, &self.cut) else { return [0.0; 2] };
        match (elastic.is_some(), damping, self.kind()) {
            (true, damping @ Some(_), Some(DashpotKind::Axial)) => {
                bars.axial_force(&BarLaw::<L, true, true>(law), block, [elastic, damping])
            }
            (false, damping @ Some(_), Some(DashpotKind::Axial)) => {
                bars.axial_force(&BarLaw::<L, false, true>(law), block, [None, damping])
            }
            (_, damping, kind) => {
                let damping = damping.filter(|_| kind == Some(DashpotKind::Relative));
                let power = damping.map_or(0.0, |f| self.relative_force(bars, block, f));
                let energy = match elastic {
                    Some(_) => bars.axial_force(&BarLaw::<L, true, false>(law), block, [elastic, None])[0],
                    None => 0.0,
                };
                [energy, power]
            }
        }
    }
}

/// Spring law and axial dashpot for the kernels.
struct BarLaw<L, const ELASTIC: bool, const DAMPED: bool>(L);

impl<L: TensionLaw, const ELASTIC: bool, const DAMPED: bool> AxialLaw for BarLaw<L, ELASTIC, DAMPED> {
    const ELASTIC: bool = ELASTIC;
    const DAMPED: bool = DAMPED;

    #[inline(always)]
    fn axial_force<R: Real>(&self, [k, l0, c]: [R; 3], Measured { square, rate }: Measured<R>) -> AxialForce<R> {
        let zero = k.all(0.0);
        let l = square.sqrt();
        let e = l - l0;
        let elastic = self.0.at(Bar { k, l0 }, e);
        let over_l = |force: R| (force / l).where_positive(l);
        let axial_force =
            AxialForce { elastic: over_l(elastic.force), energy: elastic.energy, damping: zero, power: zero };
        if !DAMPED {
            return axial_force;
        }
        let rate = over_l(rate);
        let Damping { force, .. } = dashpot::axial(&self.0, elastic, (Bar { k, l0 }, c), [e, rate]);
        AxialForce { damping: over_l(force), power: zero - force * rate, ..axial_force }
    }
}

/// The same with rest lengths times a factor s. The elastic part sums -dE/ds [J] in place of a power.
struct Reeled<L, const ELASTIC: bool, const DAMPED: bool>(L, f64);

impl<L: TensionLaw, const ELASTIC: bool, const DAMPED: bool> AxialLaw for Reeled<L, ELASTIC, DAMPED> {
    const ELASTIC: bool = ELASTIC;
    const DAMPED: bool = DAMPED;
    const POWER: bool = true;

    #[inline(always)]
    fn axial_force<R: Real>(&self, [k, given, c]: [R; 3], measured: Measured<R>) -> AxialForce<R> {
        let &Reeled(law, s) = self;
        let l0 = given * k.all(s);
        let axial_force = BarLaw::<L, ELASTIC, DAMPED>(law).axial_force([k, l0, c], measured);
        if DAMPED {
            return axial_force;
        }
        let pull = law.pull(Bar { k, l0 }, measured.square.sqrt() - l0);
        AxialForce { power: pull * given, ..axial_force }
    }
}

impl BlockForces for DampedSprings {
    fn elements(&self) -> usize {
        self.springs.nodes.len()
    }

    fn reads(&self, [elastic, damping]: [bool; PARTS]) -> BufferReads {
        BufferReads { x: elastic || self.kind() == Some(DashpotKind::Axial), v: damping }
    }

    fn element(&self, number: usize) -> Option<&[u32]> {
        self.springs.nodes.get(number).map(|nodes| nodes.as_slice())
    }

    fn assign_block(&mut self, block: usize, elements: Range<usize>, place: &dyn Fn(u32) -> u16) {
        let SpringData { nodes, rest_length, stiffness, .. } = &self.springs;
        let c = self.dashpots.as_ref().map_or(Coefficient::Uniform(0.0), |dashpots| dashpots.coefficient.clone());
        // One rest length per spring, even if all are equal: the loop for the largest stretch reads them.
        let numbers = [stiffness.clone(), Coefficient::Each(rest_length.clone()), c];
        let ends: Vec<[u16; 2]> = nodes[elements.clone()].iter().map(|nodes| nodes.map(place)).collect();
        if self.kind() == Some(DashpotKind::Relative) {
            Arc::make_mut(&mut self.differences).assign_block(block, &ends, (elements.start, &numbers[2]));
        }
        Arc::make_mut(&mut self.batch).assign_block(block, ends, (elements.start, &numbers));
    }

    fn add(&self, block: &ElementBlock<'_>, sums: [Option<&mut Records>; 2]) -> [Tally; 2] {
        if let Some(table) = &self.springs.rest_scale {
            let s = table.at(block.t)[0];
            let [energy, power, pull] =
                with_law!(&self.springs.curve, self.springs.slack, law => self.reeled_force((law, s), block, sums));
            return [Tally { energy, power: pull }, Tally { energy: 0.0, power }];
        }
        let [energy, power] =
            with_law!(&self.springs.curve, self.springs.slack, law => self.axial_force(law, block, sums));
        [Tally { energy, power: 0.0 }, Tally { energy: 0.0, power }]
    }

    fn largest_stretch(&self, block: &ElementBlock<'_>) -> f64 {
        let Some(bars) = self.batch.bars(block.number, &self.cut) else { return f64::NEG_INFINITY };
        let rest_length = self.batch.each_number(block.number, 1);
        let (rest_scale, at) = (self.springs.rest_scale_at(block.t), InLocalBuffer(block.x));
        let of = |places: Range<usize>| {
            let (ends, rest_length) = (&bars.ends[places.clone()], &rest_length[places]);
            largest(SpringLengths { ends, rest_length, rest_scale, at })
        };
        if !bars.some_broken() {
            return of(0..bars.ends.len());
        }
        let whole = (0..bars.ends.len()).filter(|&place| !bars.is_broken(place));
        whole.fold(f64::NEG_INFINITY, |most, place| most.max(of(place..place + 1)))
    }
}

/// An axial dashpot at a state.
struct AxialState {
    stretch: Stretch,
    /// [m/s] vb - va
    dv: Vector3<f64>,
    /// [m/s] n . dv
    rate: f64,
    damping: Damping,
}

/// The dashpot along spring `i` with this stretch and elastic tension; `c` [N s/m] is its coefficient.
fn axial_state(
    springs: &SpringData,
    (stretch, elastic): (Stretch, Tension),
    v: &[Vector3<f64>],
    (i, c): (usize, f64),
) -> AxialState {
    let [a, b] = springs.nodes[i].map(|node| node as usize);
    let dv = v[b] - v[a];
    let (e, rate) = (stretch.elongation, stretch.n.dot(&dv));
    let bar = Bar { k: springs.stiffness.at(i), l0: stretch.length - e };
    let damping = with_law!(&springs.curve, springs.slack, law => dashpot::axial(&law, elastic, (bar, c), [e, rate]));
    AxialState { stretch, dv, rate, damping }
}

/// [N] Force that the dashpot along spring `i` adds to its elastic tension; `c` [N s/m] is its coefficient.
pub fn axial_force(springs: &SpringData, at: NodeState<'_>, i: usize, c: f64) -> f64 {
    axial_state(springs, elastic_state(springs, springs.at(at.t, at.x), i), at.v, (i, c)).damping.force
}

/// [N] Tension of spring `i` with its dashpot along it, of coefficient `axial` [N s/m] if it has one, where its
/// stiffness and its rest length are these factors times its own.
pub fn scaled_tension(
    springs: &SpringData,
    at: NodeState<'_>,
    (i, axial): (usize, Option<f64>),
    [stiffness, rest_length]: [f64; 2],
) -> f64 {
    let springs_at = springs.at(at.t, at.x);
    let (stretch, own) = (springs.stretch(springs_at, i), springs.bar(springs_at, i));
    let bar = Bar { k: stiffness * own.k, l0: rest_length * own.l0 };
    let e = stretch.length - bar.l0;
    let elastic = tension(&springs.curve, springs.slack, bar, e);
    let Some(c) = axial else { return elastic.force };
    let [a, b] = springs.nodes[i].map(|node| node as usize);
    let rate = stretch.n.dot(&(at.v[b] - at.v[a]));
    let damping = with_law!(&springs.curve, springs.slack, law => dashpot::axial(&law, elastic, (bar, c), [e, rate]));
    elastic.force + damping.force
}

/// Stretch and elastic tension of spring `i`.
fn elastic_state(springs: &SpringData, at: SpringsAt<'_>, i: usize) -> (Stretch, Tension) {
    let stretch = springs.stretch(at, i);
    (stretch, tension(&springs.curve, springs.slack, springs.bar(at, i), stretch.elongation))
}

impl AxialState {
    fn tangent(&self, w: Weights) -> Matrix3<f64> {
        let (n, d) = (self.stretch.n, self.damping);
        let block = self.stretch.block(d.force, d.slope) * w.k + self.velocity_tangent(w);
        if self.stretch.length > 0.0 {
            block + outer(n, self.dv - self.rate * n) * (w.k * d.c / self.stretch.length)
        } else {
            block
        }
    }

    /// c n n^T.
    fn velocity_tangent(&self, w: Weights) -> Matrix3<f64> {
        outer(self.stretch.n, self.stretch.n) * (w.c * self.damping.c)
    }
}

impl ForceTerm for DampedSprings {
    fn parts(&self) -> &[TermInfo] {
        match (self.kind(), self.springs.curve == CurveKind::Linear) {
            (None, true) => &[SPRINGS],
            (None, false) => &[BARS],
            (Some(DashpotKind::Axial), true) => &[SPRINGS, AXIAL],
            (Some(DashpotKind::Axial), false) => &[BARS, AXIAL],
            (Some(DashpotKind::Relative), true) => &[SPRINGS, RELATIVE],
            (Some(DashpotKind::Relative), false) => &[BARS, RELATIVE],
        }
    }

    fn symmetric(&self) -> bool {
        self.kind() != Some(DashpotKind::Axial)
    }

    /// For a spring B = (T/l)(I - n n^T) + (dT/dl) n n^T; the convex form has max(T, 0) in place of T. For an axial
    /// dashpot the symmetric form is c n n^T, the velocity part.
    fn tangent(&self, at: NodeState<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink) {
        let kept = |number: f64| if form.convex { number.max(0.0) } else { number };
        with_law!(&self.springs.curve, self.springs.slack, law => {
            self.emit(law, (at, w, form), sink, |_, (stretch, t)| stretch.block(kept(t.force), kept(t.slope)));
        });
    }

    fn mean(&self) -> Option<&dyn MeanForce> {
        Some(self)
    }

    fn springs(&self) -> Option<&dyn SpringTerm> {
        Some(self)
    }

    fn for_run(&self, copies: &mut Copies) -> Box<dyn ForceTerm> {
        let (springs, cut) = (self.springs.for_run(copies), self.cut.for_run(copies));
        Box::new(DampedSprings { springs, cut, ..self.clone() })
    }

    fn set_rest_lengths(&mut self, rest_length: &Arc<[f64]>) {
        self.springs.rest_length = rest_length.clone();
        Arc::make_mut(&mut self.batch).set_number(1, rest_length);
    }

    fn add_stiffness(&self, nodes: &mut [f64]) {
        for (i, pair) in self.springs.nodes.iter().enumerate().filter(|(i, _)| !self.cut.is_cut(*i)) {
            for &node in pair {
                nodes[node as usize] += self.springs.stiffness.at(i);
            }
        }
    }
}

impl DampedSprings {
    /// Spring `i` over a step, with the factor of the rest lengths in its middle.
    fn mean_bar(&self, law: &impl TensionLaw, (step, at): (MeanStep<'_>, SpringsAt<'_>), i: usize) -> MeanBar {
        let bar = self.springs.bar(at, i);
        MeanBar::new(step.sides(self.springs.nodes[i]), |lengths| {
            law.mean_with(bar, lengths.map(|l| l - bar.l0), step.mean.dissipation)
        })
    }

    /// Adds their mean forces. Returns dE/ds, negative [J], where rest lengths are times a factor.
    fn add_means(&self, law: &impl TensionLaw, step: MeanStep<'_>, f: &mut [Vector3<f64>]) -> f64 {
        let (springs, at, mut reeled) = (&self.springs, self.springs.at(step.at.t, step.at.x), 0.0);
        for (i, &nodes) in springs.nodes.iter().enumerate().filter(|(i, _)| !self.cut.is_cut(*i)) {
            let mean = self.mean_bar(law, (step, at), i);
            mean.add(nodes, f);
            if springs.rest_scale.is_some() {
                let bar = springs.bar(at, i);
                let [start, end] = mean.lengths.map(|l| law.pull(bar, l - bar.l0));
                reeled += 0.5 * (start + end) * springs.rest_length[i];
            }
        }
        reeled
    }
}

impl MeanForce for DampedSprings {
    fn add_mean(&self, step: MeanStep<'_>, f: &mut [Vector3<f64>]) -> Tally {
        let power = with_law!(&self.springs.curve, self.springs.slack, law => self.add_means(&law, step, f));
        Tally { energy: 0.0, power }
    }

    fn mean_tangent(&self, step: MeanStep<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink) {
        let at = self.springs.at(step.at.t, step.at.x);
        with_law!(&self.springs.curve, self.springs.slack, law => {
            self.emit(law, (step.at, w, form), sink, |i, _| self.mean_bar(&law, (step, at), i).block(form));
        });
    }
}
