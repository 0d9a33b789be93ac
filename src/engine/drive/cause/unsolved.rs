//! The diagnosis of a step that Newton's iteration could not solve.

use super::DiagnosisInput;
use crate::analysis::buckling;
use crate::analysis::cloth::too_soft;
use crate::format_number::figures;

/// [-] Effect of rounded positions, as a share of the largest tension, and as a strain.
const ROUNDING: f64 = 1e-12;

impl DiagnosisInput<'_> {
    /// The cause in words, and a step [s] that might be solved; `worst` is the degree of freedom with the largest
    /// residual.
    pub(in crate::drive) fn unsolved(&self, worst: usize) -> (String, f64) {
        let mut step = 0.5 * self.h;
        let mut words: Vec<String> = too_soft(self.scene, self.last.as_ref()).into_iter().collect();
        if let Some(leaves) = buckling::fastest(self.scene, self.last.as_ref(), self.stop) {
            let turning = self.turning().join(", ");
            let what = match (self.compressed(), turning.is_empty()) {
                (true, _) => "compressed springs buckle in the last good state".to_owned(),
                (false, false) => {
                    format!("loads that turn with the cloth ({turning}) drive it away from the last good state")
                }
                (false, true) => "the scene moves away from the last good state by itself".to_owned(),
            };
            words.push(format!("{what}, at a rate of {} 1/s {}", figures(leaves.rate, 3), self.place(leaves.dof)));
            step = step.min(1.0 / leaves.rate);
        }
        if !self.method.info.linear.always_dissipates && !self.stop.asked() {
            words.extend(self.unresolved(&self.scene.initial_state()).map(|found| found.why));
        }
        if self.stop.asked() {
            words.push("the search for the cause was cut short by a signal".to_owned());
        }
        words.extend(self.unheld(worst));
        (words.join("; "), step)
    }

    /// Whether a spring is in compression in the last good state.
    fn compressed(&self) -> bool {
        let springs = self.scene.edges().len();
        let (mut tension, mut strain) = (vec![0.0; springs], vec![0.0; springs]);
        self.scene.edge_tension(self.last.as_ref(), &mut tension, &mut strain);
        let most = tension.iter().fold(0.0, |most: f64, t| most.max(t.abs()));
        tension.iter().zip(&strain).any(|(t, strain)| *t < -ROUNDING * most && *strain < -ROUNDING)
    }
}
