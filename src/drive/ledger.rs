//! The energy ledger.
//!
//! ```text
//! kinetic + elastic + gravity - external_work + dissipated + numerical = its value at t = 0
//! ```
//! Work of a force over a step is 1/2 (f_n + f_{n+1}) . (x_{n+1} - x_n), unless the scheme integrates it itself (the
//! Runge-Kutta and PEC schemes) and resolves what its dashpots do. `numerical` is the remainder: what the scheme itself lost (above 0) or made (below 0).

use super::observer::LedgerRow;
use crate::integrate::{StageWork, StepReport};
use crate::model::forces::{Role, Tally};
use crate::model::lanes::{LANES, Lanes};
use crate::model::point::Point;
use crate::model::stride::Passed;
use crate::model::system::System;
use multiversion::multiversion;

/// Running account of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Ledger {
    first: LedgerRow,
    work: StageWork,
    largest_numerical: f64,
    exchanged: f64,
}

impl Ledger {
    /// Opens the account.
    pub fn open(system: &dyn System, at: &Point) -> (Self, LedgerRow) {
        let mut ledger = Ledger::default();
        ledger.first = ledger.row(system, system.kinetic_energy(&at.state.v), &at.forces.tallies);
        ledger.first.numerical = 0.0;
        (ledger, ledger.first)
    }

    /// Accounts for an accepted step after the account `before`; tells also whether by works that the scheme has integrated itself.
    ///
    /// Stages of a step above the limit of a stiff dashpot have velocities that no state has, and weights of either sign: their sum may be off by any
    /// factor, though the step is good. Where the ends of the step say something quite different and leave less of the energy unexplained, they count; where steps
    /// resolve what happens, stages leave by far the least.
    pub fn step(
        &mut self,
        system: &dyn System,
        (from, to): (&Point, &Point),
        report: &StepReport,
        before: &LedgerRow,
    ) -> (LedgerRow, bool) {
        let kinetic = system.kinetic_energy(&to.state.v);
        let ends = || StageWork {
            external: trapezoid(system, (&from.forces.external, &to.forces.external), from, to),
            dissipated: -trapezoid(system, (&from.forces.dissipative, &to.forces.dissipative), from, to),
        };
        let (work, by_stages) = match report.work {
            None => (ends(), false),
            Some(stages) if from.forces.dissipative.is_empty() => (stages, true),
            Some(stages) => {
                let ends = ends();
                let rest = self.row(system, kinetic, &to.forces.tallies).numerical - before.numerical;
                let unexplained = |work: StageWork| (rest + work.external - work.dissipated).abs();
                let apart = (stages.dissipated - ends.dissipated).abs();
                let differ = apart > 0.5 * stages.dissipated.abs().max(ends.dissipated.abs());
                match differ && unexplained(stages) > unexplained(ends) {
                    false => (stages, true),
                    true => (ends, false),
                }
            }
        };
        self.work.external += work.external;
        self.work.dissipated += work.dissipated;
        (self.close(system, kinetic, &to.forces.tallies), by_stages)
    }

    /// The same for a step of a stride, in which only forces that follow from positions work.
    pub fn passed(&mut self, system: &dyn System, end: &Passed) -> LedgerRow {
        self.close(system, end.nodes.kinetic, &end.tallies)
    }

    fn close(&mut self, system: &dyn System, kinetic: f64, tallies: &[Tally]) -> LedgerRow {
        let row = self.row(system, kinetic, tallies);
        let first = self.first;
        self.largest_numerical = self.largest_numerical.max(row.numerical.abs());
        let parts = [
            row.kinetic - first.kinetic,
            row.elastic - first.elastic,
            row.gravity - first.gravity,
            row.external_work,
            row.dissipated,
        ];
        self.exchanged = parts.iter().fold(self.exchanged, |m, p| m.max(p.abs()));
        row
    }

    /// Largest |numerical| over the largest energy exchanged so far; 0 when nothing was exchanged.
    pub fn energy_error(&self) -> f64 {
        if self.exchanged > 0.0 { self.largest_numerical / self.exchanged } else { 0.0 }
    }

    fn row(&self, system: &dyn System, kinetic: f64, tallies: &[Tally]) -> LedgerRow {
        let mut row = LedgerRow {
            kinetic,
            external_work: self.work.external,
            dissipated: self.work.dissipated,
            ..Default::default()
        };
        for (term, tally) in system.terms().iter().zip(tallies) {
            match term.role {
                Role::Elastic => row.elastic += tally.energy,
                Role::Gravity => row.gravity += tally.energy,
                Role::External | Role::Dissipative => {}
            }
        }
        let f = &self.first;
        // Differences first: a large constant energy does not swamp a small remainder.
        row.numerical =
            (f.kinetic - row.kinetic) + (f.elastic - row.elastic) + (f.gravity - row.gravity) + row.external_work
                - row.dissipated;
        row
    }
}

/// [J] Work of a force that changes from `f_n` to `f_n1` along the step.
fn trapezoid(system: &dyn System, f: (&[f64], &[f64]), from: &Point, to: &Point) -> f64 {
    let (f_n, f_n1) = f;
    system.workers().sum(f_n.len(), |r| {
        let (x, y) = (&from.state.x[r.clone()], &to.state.x[r.clone()]);
        half_sum_times_difference((&f_n[r.clone()], &f_n1[r]), (x, y))
    })
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn half_sum_times_difference((a, b): (&[f64], &[f64]), (x, y): (&[f64], &[f64])) -> f64 {
    let mut sum = Lanes::default();
    let ((a, a_last), (b, b_last)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let ((x, x_last), (y, y_last)) = (x.as_chunks::<LANES>(), y.as_chunks::<LANES>());
    let mut work = [0.0; LANES];
    for (((a, b), x), y) in a.iter().zip(b).zip(x).zip(y) {
        for i in 0..LANES {
            work[i] = 0.5 * (a[i] + b[i]) * (y[i] - x[i]);
        }
        sum.add(&work);
    }
    let mut work = [0.0; LANES];
    for ((((a, b), x), y), work) in a_last.iter().zip(b_last).zip(x_last).zip(y_last).zip(&mut work) {
        *work = 0.5 * (a + b) * (y - x);
    }
    sum.add(&work);
    sum.total()
}
