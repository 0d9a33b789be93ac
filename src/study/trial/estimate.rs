//! The cost of a whole run, estimated from a few real steps sampled along it.

use super::sample::Sample;
use super::yardstick::Delivered;

/// What a figure rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Basis {
    /// real steps of this method on this scene
    Steps,
    /// the cost of one tangent, and iterations as another method needs them
    Counts,
}

/// A run that has not been made.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Estimate {
    /// what it rests on
    pub basis: Basis,
    /// accepted steps to the end
    pub steps: f64,
    /// [s] mean step
    pub mean_step: f64,
    /// [s] processor time a step, without output
    pub step_seconds: f64,
    /// [s] processor time of the whole run, output included
    pub cpu_seconds: f64,
    /// force passes
    pub force_evaluations: f64,
    /// assemblies of W
    pub tangent_assemblies: f64,
    /// factorisations of W
    pub factorizations: f64,
    /// solves with a factorised W
    pub linear_solves: f64,
    /// Newton iterations
    pub newton_iterations: f64,
}

impl Estimate {
    /// A run to `end` [s] in `steps` steps of one size, or else in as many as the samples need; each sample stands for an equal part of the
    /// run. `None` without samples.
    pub fn of(samples: &[Sample], end: f64, steps: Option<u64>) -> Option<Estimate> {
        if samples.is_empty() {
            return None;
        }
        let share = 1.0 / samples.len() as f64;
        let total = |of: &dyn Fn(&Sample) -> f64| -> f64 {
            let part = |s: &Sample| match steps {
                Some(steps) => of(s) / s.steps * steps as f64,
                None => of(s) / s.simulated * end,
            };
            samples.iter().map(|s| share * part(s)).sum()
        };
        let made = steps.map_or_else(|| total(&|s| s.steps), |steps| steps as f64).max(1.0);
        let seconds = total(&|s| s.seconds);
        let work: [f64; 5] = std::array::from_fn(|i| total(&|s| s.work[i]));
        let [force_evaluations, tangent_assemblies, factorizations, linear_solves, newton_iterations] = work;
        Some(Estimate {
            basis: Basis::Steps,
            steps: made,
            mean_step: end / made,
            step_seconds: seconds / made,
            cpu_seconds: seconds,
            force_evaluations,
            tangent_assemblies,
            factorizations,
            linear_solves,
            newton_iterations,
        })
    }

    /// A run to `end` [s] in `steps` steps like those of a sample.
    pub fn from_one(sample: &Sample, end: f64, steps: f64) -> Estimate {
        let share = steps / sample.steps;
        let [force_evaluations, tangent_assemblies, factorizations, linear_solves, newton_iterations] =
            sample.work.map(|n| n * share);
        Estimate {
            basis: Basis::Steps,
            steps,
            mean_step: end / steps,
            step_seconds: sample.seconds / sample.steps,
            cpu_seconds: sample.seconds * share,
            force_evaluations,
            tangent_assemblies,
            factorizations,
            linear_solves,
            newton_iterations,
        }
    }

    /// The same with the processor time [s] of results written.
    #[must_use]
    pub fn with_output(self, seconds: f64) -> Estimate {
        Estimate { cpu_seconds: self.cpu_seconds + seconds, ..self }
    }
}

impl Delivered {
    /// A run to `whole` [s] in so many steps, from the work and the time of those that were made to `span` [s].
    pub fn run(&self, span: f64, whole: f64, steps: f64) -> Estimate {
        let [force_evaluations, tangent_assemblies, factorizations, linear_solves] = self.work;
        let work = [force_evaluations, tangent_assemblies, factorizations, linear_solves, self.newton_iterations];
        let sample = Sample { steps: self.steps.max(1.0), simulated: span, seconds: self.seconds, work };
        Estimate::from_one(&sample, whole, steps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run that is dear in one half and cheap in the other costs the mean of fixed steps, but of adaptive ones the mean a second simulated.
    #[test]
    fn parts_of_a_run_count_by_the_time_they_stand_for() {
        let dear = Sample { steps: 2.0, simulated: 1.0, seconds: 4.0, work: [6.0; 5] };
        let cheap = Sample { steps: 1.0, simulated: 2.0, seconds: 1.0, work: [2.0; 5] };
        let fixed = Estimate::of(&[dear, cheap], 10.0, Some(10)).expect("samples");
        assert_eq!((fixed.steps, fixed.cpu_seconds, fixed.force_evaluations), (10.0, 15.0, 25.0));
        let adaptive = Estimate::of(&[dear, cheap], 10.0, None).expect("samples");
        assert_eq!((adaptive.steps, adaptive.cpu_seconds, adaptive.mean_step), (12.5, 22.5, 0.8));
        assert!(Estimate::of(&[], 1.0, None).is_none());
    }
}
