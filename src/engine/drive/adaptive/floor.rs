//! The diagnosis of a run that ends because even the smallest step does not meet the tolerance.

use super::estimate::Deviation;
use super::progress::STEPS;
use crate::drive::failure::{Failure, FailureContext};

impl FailureContext<'_> {
    /// The error of a step stays above the tolerance down to the smallest step, `floor` [s].
    pub(in crate::drive) fn at_the_floor(&self, worst: Deviation, floor: f64) -> Failure {
        let suspect = self.scene.suspect(self.from.state.as_ref(), worst.dof);
        let size = self.from.state.x.get(worst.dof).map_or(0.0, |x| x.abs());
        let rounding = 4.0 * f64::EPSILON * size;
        let (cause, advice) = if worst.ratio.is_finite() {
            (
                format!(
                    "the time tolerance needs a step below {floor:.1e} s, the smallest allowed: the error of a step of {:.1e} s is still {:.1e} of what the whole run may make. Either forces jump there, or the tolerance, spread over {:.1e} s, is finer than rounding ({rounding:.1e} m in positions of {size:.1e} m)",
                    self.h, worst.ratio, self.end
                ),
                "raise time.tolerance, shorten the run, or smooth the jump (a load table with steep rows, a slack rule with a dashpot)",
            )
        } else {
            (
                format!("forces or states are not finite even in a step of {:.1e} s, the smallest allowed", self.h),
                "check loads, wind, masses, speeds and damping for a wrong unit: a force has left the range of a double",
            )
        };
        self.report(suspect, cause, advice.to_owned())
    }

    /// The last [`STEPS`] steps advanced the run by `gone` [s].
    pub(in crate::drive) fn without_progress(&self, gone: f64) -> Failure {
        let cause = format!(
            "the run makes no progress: from t = {:.9e} s, its last {STEPS} steps advanced it by {gone:.1e} s, of {:.1e} s in all. The time tolerance needs steps of {:.1e} s",
            self.from.state.t, self.end, self.h
        );
        let advice = "raise time.tolerance (first its absolute part) or use a fixed step; look for a load, a wind or a spring that changes within so short a time";
        self.report(self.scene.suspect(self.from.state.as_ref(), 0), cause, advice.to_owned())
    }
}
