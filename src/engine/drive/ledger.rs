//! The energy ledger.
//!
//! ```text
//! kinetic + elastic + gravity - external_work + dissipated + numerical = its value at t = 0
//! ```
//! Work of a force over a step is 1/2 (f_n + f_{n+1}) . (x_{n+1} - x_n), and that of a change of rest lengths by a
//! factor s -1/2 (G_n + G_{n+1}) (s_{n+1} - s_n) with G the sum of T l0, which is external; unless the scheme
//! integrates it itself (the Runge-Kutta and PEC schemes) and resolves its dashpots. Where a program changes rest
//! lengths or gravity, the energy that springs and weight gain at once is external work too, and so is that of held
//! masses whose support changes its velocity. The energy of springs that are cut is dissipated. `numerical` is the
//! remainder: the energy that the scheme itself lost (above 0) or made (below 0).

use super::observer::Energies;
use crate::integrate::{StageWork, StepReport, reeling_work};
use crate::model::forces::{Role, Tally};
use crate::model::point::Point;
use crate::model::step_block::StepSummary;
use crate::model::system::System;

/// [eps] Rounding error of the sums of one row, relative to the energies.
const ROUNDED: f64 = 8.0;
/// [eps] Rounding error that each step may add, relative to the energies: states are rounded, and the residuals of
/// implicit steps add up. Generalised alpha adds an eighth of this on a motion that it solves exactly.
const ROUNDED_A_STEP: f64 = 0.25;

/// [-] Share of the exchanged energy above which rounding could look like an error.
const VISIBLE: f64 = 1e-6;

/// What becomes of elastic energy that changes between two steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Elastic {
    /// it is work from outside: a program has changed rest lengths
    FromOutside,
    /// it is lost, as that of a line that is cut and recoils
    Dissipated,
}

/// Energy account of a run, up to the present step.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Ledger {
    first: Energies,
    work: StageWork,
    largest_numerical: f64,
    exchanged: f64,
}

/// An accepted step in the account.
#[derive(Clone, Copy, Debug)]
pub struct LedgerStep {
    /// the account after it
    pub row: Energies,
    /// whether the works are those that the scheme integrated itself
    pub by_stages: bool,
}

impl Ledger {
    /// Opens the account at the initial state.
    pub fn open(system: &dyn System, at: &Point) -> Self {
        let mut ledger = Ledger::default();
        ledger.first = ledger.row(system, system.kinetic_energy(&at.state.v), &at.forces.tallies);
        ledger.first.numerical = 0.0;
        ledger
    }

    /// The account at the initial state.
    pub fn first(&self) -> Energies {
        self.first
    }

    /// Adds an accepted step to the account `before`.
    ///
    /// In a step above the limit of a stiff dashpot, the stages have velocities that no state has, and weights of
    /// either sign. Their sum may then be wrong by any factor, although the step is good. So the works by the ends of
    /// the step are used where they are quite different and leave less energy unexplained. Where steps resolve the
    /// motion, stages leave by far the least.
    pub fn step(
        &mut self,
        system: &dyn System,
        from: &Point,
        to: &Point,
        report: &StepReport,
        before: &Energies,
    ) -> LedgerStep {
        let kinetic = system.kinetic_energy(&to.state.v);
        let way = [&from.state.x, &to.state.x].map(Vec::as_slice);
        let ends = || StageWork::by_ends(system, [&from.forces, &to.forces], way, [from.state.t, to.state.t]);
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
        LedgerStep { row: self.close(system, kinetic, &to.forces.tallies), by_stages }
    }

    /// The same for the summary of a step in a block, which began at time `t` [s] with these `tallies`.
    pub fn close_with(&mut self, system: &dyn System, t: f64, tallies: &[Tally], end: &StepSummary) -> Energies {
        let reeled = reeling_work(system, [t, end.t], [tallies, &end.tallies]);
        self.work.external += end.nodes.work.external + reeled;
        self.work.dissipated -= end.nodes.work.dissipative;
        self.close(system, end.nodes.kinetic, &end.tallies)
    }

    /// Accounts for forces, and velocities of supports, that were changed between two steps: what weight and held
    /// masses gained or lost at once is work done from outside, and of elastic energy `elastic` says what became. `at`
    /// is the state as it is now, `before` the account until then.
    pub fn changed(&mut self, system: &dyn System, at: &Point, before: &Energies, elastic: Elastic) -> Energies {
        let kinetic = if system.moved().is_empty() { before.kinetic } else { system.kinetic_energy(&at.state.v) };
        let now = self.row(system, kinetic, &at.forces.tallies);
        self.work.external += (now.kinetic - before.kinetic) + (now.gravity - before.gravity);
        match elastic {
            Elastic::FromOutside => self.work.external += now.elastic - before.elastic,
            Elastic::Dissipated => self.work.dissipated += before.elastic - now.elastic,
        }
        self.close(system, kinetic, &at.forces.tallies)
    }

    fn close(&mut self, system: &dyn System, kinetic: f64, tallies: &[Tally]) -> Energies {
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

    /// [-] Largest |numerical| over the largest energy exchanged in this number of steps; 0 if nothing was exchanged.
    ///
    /// Rounding is no error of the scheme. Where so little energy is exchanged that rounding matters, `numerical` is
    /// compared with the energies that were rounded. An example is a pendulum that turns without gravity: it exchanges
    /// no energy except by rounding.
    pub fn energy_error(&self, steps: u64) -> f64 {
        let rounded = self.exchanged
            + [self.first.kinetic, self.first.elastic, self.first.gravity].map(f64::abs).iter().sum::<f64>();
        let rounding = f64::EPSILON * rounded * (ROUNDED + ROUNDED_A_STEP * steps as f64);
        let explained = self.largest_numerical <= rounding && rounding > VISIBLE * self.exchanged;
        let whole = if explained { rounded } else { self.exchanged };
        if self.exchanged > 0.0 { self.largest_numerical / whole } else { 0.0 }
    }

    fn row(&self, system: &dyn System, kinetic: f64, tallies: &[Tally]) -> Energies {
        let mut row = Energies {
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
        // Differences first, so that a large constant energy does not hide a small remainder.
        row.numerical =
            (f.kinetic - row.kinetic) + (f.elastic - row.elastic) + (f.gravity - row.gravity) + row.external_work
                - row.dissipated;
        row
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where only rounding was exchanged, the unexplained part is compared with the energies that were rounded.
    /// Examples are a pendulum that turns without gravity, and a taut string that moves by 1e-8 of its length.
    #[test]
    fn rounding_is_no_energy_error() {
        let turning = Energies { kinetic: 4.5, ..Energies::default() };
        let taut = Energies { elastic: 0.5, ..Energies::default() };
        for (first, largest_numerical, exchanged, steps) in
            [(turning, 3.0e-13, 3.0e-13, 20_000), (turning, 2.4e-12, 2.4e-12, 20_000), (taut, 5.6e-16, 2.6e-15, 100)]
        {
            let ledger = Ledger { first, largest_numerical, exchanged, ..Ledger::default() };
            let error = ledger.energy_error(steps);
            assert!(error > 0.0 && error < 1e-12, "{error:e}");
        }
    }

    /// What rounding does not explain is compared with what was exchanged, bit by bit; so is rounding where all energy
    /// was exchanged.
    #[test]
    fn an_energy_error_is_over_the_energy_exchanged() {
        let taut = Energies { elastic: 0.5, ..Energies::default() };
        for (first, largest_numerical, exchanged) in [
            (taut, 2.1e-9, 2.4e-7),
            (taut, 1.1e-15, 2.4e-7),
            (Energies::default(), 1e-16, 3.0),
            (taut, 1e-3, 0.1),
            (Energies::default(), 0.3, 0.1),
        ] {
            let ledger = Ledger { first, largest_numerical, exchanged, ..Ledger::default() };
            assert_eq!(ledger.energy_error(2000), largest_numerical / exchanged);
        }
        assert_eq!(Ledger::default().energy_error(10), 0.0);
        let lost = Ledger { largest_numerical: f64::NAN, exchanged: 1.0, ..Ledger::default() };
        assert!(lost.energy_error(1).is_nan());
    }
}
