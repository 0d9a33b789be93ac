//! A run with its adjoint run after it.

use super::error::GradientError;
use super::making::{Along, Made, Making};
use crate::case::Problem;
use crate::drive::snapshot::Snapshot;
use crate::integrate::form::StepForm;
use crate::integrate::stepper::Stepper;
use crate::model::point::Point;
use crate::model::state::State;
use crate::model::stop::Stop;
use crate::output::gauges::GaugesSpec;
use crate::output::gauges::seeds::{GaugeSeeds, SeededQuantity, Share, Shares};
use crate::scene::{Adjoint, Scene};
use crate::sensitivity::{
    AdjointRun, ElementKinds, ElementSlopes, Plan, Recorder, RecorderState, Segment, StepEnds, StepRecord,
};

/// [bytes] Memory of the steps that are kept at once, where the caller says nothing.
const MEMORY: usize = 256 << 20;
/// Steps that are kept at least.
const LEAST: u64 = 20;

/// What an adjoint run finds of a quantity.
pub(super) struct Reversed {
    pub of: SeededQuantity,
    pub slopes: ElementSlopes,
    /// by positions and velocities at the start `[n_dof]`
    pub start: [Vec<f64>; 2],
}

/// What an adjoint run finds.
pub(super) struct ReversedRun {
    pub quantities: Vec<Reversed>,
    pub steps: u64,
    /// steps that were made again
    pub again: u64,
    pub run_factorizations: u64,
    pub factorizations: u64,
}

/// What is asked of an adjoint run.
#[derive(Clone, Copy)]
pub(super) struct Asked {
    pub kinds: ElementKinds,
    /// steps and snapshots that are kept at once
    pub states: Option<u64>,
}

/// Makes the run of a problem on its scene, and finds the derivatives of its quantities by single springs and nodes.
pub(super) fn reverse(
    problem: &Problem,
    (scene, adjoint): (&dyn Scene, &dyn Adjoint),
    Asked { kinds, states }: Asked,
    interrupt: Stop<'_>,
) -> Result<ReversedRun, GradientError> {
    let mut making = Making::start(problem, scene, interrupt)?;
    let gauges = GaugesSpec::of(&problem.output, problem.run_spec().end);
    let mut seeds = GaugeSeeds::new(scene, &gauges)?;
    seeds.measure(scene, 0, &making.state.from);
    let form = making.form(making.h)?;
    let affordable = (MEMORY / StepRecord::size(&form, scene).max(1)) as u64;
    let states = states.unwrap_or(affordable.max(LEAST));
    let start = making.snapshot();
    let recorder = Recorder::start(scene, &making.state.from, form.clone());
    let mut keeping = Keeping { recorder, keeps: true, most: states, seeds: Some(&mut seeds) };
    making.to(u64::MAX, &mut keeping)?;
    let (records, kept) = (std::mem::take(&mut keeping.recorder.records), keeping.keeps);
    let (steps, run_factorizations) = (making.state.steps, making.state.counters.factorizations);
    seeds.measure_last(scene, steps, &making.state.from);
    let (quantities, shares) = seeds.finish()?;
    let run = AdjointRun::new((scene, adjoint), (quantities.len(), kinds), making.state.passed())?;
    let later = making.state.from.state.clone();
    let mut back = Back { scene, adjoint, run, seeds, quantities, shares, later, interrupt };
    let mut again = 0;
    if kept {
        back.over(records)?;
    } else {
        drop(records);
        again = follow_plan(&mut making, &Plan::new(steps, states), (start, form), &mut back)?;
    }
    let Back { run, quantities, .. } = back;
    let found = |(number, of): (usize, SeededQuantity)| {
        let zero = || vec![0.0; scene.n_dof()];
        let (slopes, start) = run.found(number).map_or_else(
            || (ElementSlopes::default(), [zero(), zero()]),
            |(slopes, [x, v])| (slopes.clone(), [x.to_vec(), v.to_vec()]),
        );
        Reversed { of, slopes, start }
    };
    Ok(ReversedRun {
        quantities: quantities.into_iter().enumerate().map(found).collect(),
        steps,
        again,
        run_factorizations,
        factorizations: run.factorizations(),
    })
}

/// Makes parts of a run again, and goes back over all of its steps. Returns the number of steps that were made again.
fn follow_plan(
    making: &mut Making<'_>,
    plan: &Plan,
    (start, form): (Snapshot, StepForm),
    back: &mut Back<'_>,
) -> Result<u64, GradientError> {
    let scene = making.scene;
    let mut again = 0;
    let mut snapshots: Vec<(Snapshot, Option<RecorderState>)> = vec![(start, None)];
    for part in &plan.parts {
        let (until, keep_until) = match *part {
            Segment::Drop => {
                snapshots.pop();
                continue;
            }
            Segment::Snapshot(until) => (until, None),
            Segment::Reverse([until, keep_until]) => (until, Some(keep_until)),
        };
        let Some((snapshot, state)) = snapshots.last().cloned() else { break };
        let before = snapshot.step;
        making.resume(snapshot)?;
        let from = &making.state.from;
        let recorder = match state {
            Some(state) => Recorder::resume(scene, from, state),
            None => Recorder::start(scene, from, form.clone()),
        };
        let mut keeping = Keeping { recorder, keeps: false, most: u64::MAX, seeds: None };
        if until > before {
            keeping.recorder.records.clear();
        }
        making.to(until, &mut keeping)?;
        match keep_until {
            None => snapshots.push((making.snapshot(), Some(keeping.recorder.state()))),
            Some(keep_until) => {
                keeping.keeps = true;
                making.to(keep_until, &mut keeping)?;
                back.over(keeping.recorder.records)?;
            }
        }
        again += keep_until.unwrap_or(until) - before;
    }
    Ok(again)
}

/// Keeps the steps of a run, as long as they are not too many.
struct Keeping<'a> {
    recorder: Recorder<'a>,
    keeps: bool,
    most: u64,
    seeds: Option<&'a mut GaugeSeeds>,
}

impl Keeping<'_> {
    fn forget(&mut self) {
        if self.recorder.records.len() as u64 > self.most {
            self.keeps = false;
        }
        if !self.keeps {
            self.recorder.records.clear();
        }
    }
}

impl Along for Keeping<'_> {
    fn step(&mut self, stepper: &Stepper<'_>, ends: StepEnds<'_>, made: Made) -> Result<(), GradientError> {
        if self.keeps || !ends.form.start.is_empty() {
            self.recorder.step(stepper, ends, (made.passed, made.step))?;
            self.forget();
        } else {
            self.recorder.jump(ends.to);
        }
        if let Some(seeds) = &mut self.seeds
            && seeds.wants(made.step, [ends.from.state.t, ends.to.state.t])
        {
            seeds.measure(self.recorder.scene(), made.step, ends.to);
        }
        Ok(())
    }

    fn event(&mut self, from: &Point, form: StepForm, made: Made) -> Result<(), GradientError> {
        self.recorder.begin((made.passed, made.step), from, form);
        self.forget();
        Ok(())
    }
}

/// The adjoint run, with the quantities that it begins with.
struct Back<'a> {
    scene: &'a dyn Scene,
    adjoint: &'a dyn Adjoint,
    run: AdjointRun<'a>,
    seeds: GaugeSeeds,
    quantities: Vec<SeededQuantity>,
    shares: Shares,
    /// where the step ends that comes next
    later: State,
    interrupt: Stop<'a>,
}

impl Back<'_> {
    /// Goes back over steps.
    fn over(&mut self, records: Vec<StepRecord>) -> Result<(), GradientError> {
        for record in records.into_iter().rev() {
            if self.interrupt.asked() {
                return Err(GradientError::Interrupted);
            }
            self.run.enter(&record)?;
            let [x, v] = record.start();
            let start = State { t: f64::NAN, x: x.to_vec(), v: v.to_vec() };
            if record.is_step || record.step == 0 {
                self.add_shares(&record)?;
            }
            self.run.back(&record)?;
            self.later = start;
        }
        Ok(())
    }

    /// Adds the derivatives of the quantities that have a share in the end of a step, or in the start.
    fn add_shares(&mut self, record: &StepRecord) -> Result<(), GradientError> {
        let Some(shares) = self.shares.get(&record.step) else { return Ok(()) };
        self.later.t = record.t;
        let force_v = record.force_v().unwrap_or_else(|| self.later.v.clone());
        let mut at = Point { state: self.later.clone(), forces: self.scene.new_forces() };
        let forces_at = crate::model::state::StateRef { v: &force_v, ..at.state.as_ref() };
        self.scene.evaluate(forces_at, &mut at.forces);
        for Share { quantity, weight } in shares {
            let Some(of) = self.quantities.get(*quantity) else { continue };
            let seed = self.seeds.seed(of, (self.scene, self.adjoint), &at)?;
            self.run.add(*quantity, *weight, &seed, (at.state.as_ref(), &force_v));
        }
        Ok(())
    }
}
