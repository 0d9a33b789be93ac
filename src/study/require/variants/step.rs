//! Steps and tolerances.

use serde_json::json;

use super::Search;
use crate::drive::clock::{Step, Tolerance};
use crate::require::change::{Change, Variant};

impl Search<'_> {
    /// The step doubled and halved; tolerances times ten and a tenth.
    pub(super) fn step(&mut self) {
        match self.problem.time.step {
            Step::Fixed(from) => {
                for to in [2.0 * from, 0.5 * from] {
                    if to <= self.problem.time.end {
                        self.add(Variant::of(Change::Step { from, to }).set("/time/step", to));
                    }
                }
            }
            Step::Adaptive(Tolerance { relative: from, absolute }) => {
                for factor in [10.0, 0.1] {
                    let to = from * factor;
                    if to < 1.0 {
                        let tolerance = json!({"relative": to, "absolute": absolute * factor});
                        self.add(Variant::of(Change::Tolerance { from, to }).set("/time/tolerance", tolerance));
                    }
                }
            }
        }
    }
}
