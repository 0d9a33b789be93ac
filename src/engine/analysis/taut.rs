//! Springs that are slack, and the critical step with all of them taut. That is the critical step of a scene: its nodes
//! may be anywhere when springs go taut, and a step must be stable then.

use super::critical::CriticalStep;
use crate::format_number::figures;
use crate::model::state::StateRef;
use crate::scene::Scene;

/// [-] strain that rounding of coordinates makes
const ROUNDING: f64 = 1e-9;
/// [-] A critical step above this many of the one with all springs taut is told beside it.
const LONGER: f64 = 1.01;

/// As long as it lives, tangents and bounds of a scene take slack springs as just taut. No step may be made meanwhile.
pub struct AllTaut<'a>(&'a dyn Scene);

impl<'a> AllTaut<'a> {
    /// Begins.
    pub fn of(scene: &'a dyn Scene) -> Self {
        let all_taut = AllTaut(scene);
        all_taut.set(true);
        all_taut
    }

    fn set(&self, taut: bool) {
        self.0.springs().into_iter().for_each(|springs| springs.take_slack_as_taut(taut));
    }
}

impl Drop for AllTaut<'_> {
    fn drop(&mut self) {
        self.set(false);
    }
}

/// Slack springs of a state, and its critical step as long as they stay slack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WhileSlack {
    /// how many are slack
    pub count: usize,
    /// of so many
    pub of: usize,
    /// the longer critical step
    pub limit: CriticalStep,
}

impl WhileSlack {
    /// `None` if no spring is slack, or if all are taut at almost the same critical step.
    pub fn find(
        scene: &dyn Scene,
        at: StateRef<'_>,
        taut: CriticalStep,
        limit: impl FnOnce() -> CriticalStep,
    ) -> Option<Self> {
        let (count, of) = slack(scene, at).filter(|_| taut.step.is_finite())?;
        let limit = limit();
        (limit.step > LONGER * taut.step).then_some(WhileSlack { count, of, limit })
    }

    /// How many are slack, in words.
    pub fn springs(&self) -> String {
        match self.count == self.of {
            true => format!("all {} springs", self.of),
            false => format!("{} of {} springs", self.count, self.of),
        }
    }

    /// Its critical step, in words.
    pub fn step(&self) -> String {
        match self.limit.step.is_finite() {
            true => format!("{} s", figures(self.limit.step, 3)),
            false => "none".to_owned(),
        }
    }
}

/// Springs that are shorter than at rest and carry no compression, and all springs. `None` if none is slack.
fn slack(scene: &dyn Scene, at: StateRef<'_>) -> Option<(usize, usize)> {
    let n = scene.edges().len();
    let (mut tension, mut strain) = (vec![0.0; n], vec![0.0; n]);
    scene.edge_tension(at, &mut tension, &mut strain);
    // An edge without a spring has no tension, not even 0.
    let of = tension.iter().filter(|tension| !tension.is_nan()).count();
    let slack = |(tension, strain): (&f64, &f64)| *tension == 0.0 && *strain < -ROUNDING;
    let count = tension.iter().zip(&strain).filter(|both| slack(*both)).count();
    (count > 0).then_some((count, of))
}
