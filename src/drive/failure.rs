//! Why a run was stopped, in words a person can act on.

use crate::analysis::rates::{Rates, rates};
use crate::integrate::StepError;
use crate::integrate::registry::{Family, MethodInfo};
use crate::model::point::Point;
use crate::scene::{Scene, Suspect};

/// What `summary.json` shows under `failure`.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Failure {
    /// [s] when the trouble was found
    pub time: f64,
    /// step in which it was found, counted from 1
    pub step: u64,
    /// node, in the user's numbering
    pub node: Option<u32>,
    /// most strained spring at that node
    pub spring: Option<u32>,
    /// force term with the largest force on that node
    pub term: Option<String>,
    /// what happened
    pub cause: String,
    /// what to do
    pub advice: String,
    /// [s] when a value stopped being finite or left 1e4 times the scene's size
    pub blow_up_time: Option<f64>,
}

/// Where a run stood when a step failed.
pub(super) struct Scenery<'a> {
    pub scene: &'a dyn Scene,
    pub method: &'static MethodInfo,
    /// last good point
    pub from: &'a Point,
    pub step: u64,
    /// [s] size of the failed step
    pub h: f64,
    /// [s] time the failed step ends at
    pub t: f64,
}

impl Scenery<'_> {
    /// A state that is not finite, or has left the scene.
    pub(super) fn diverged(&self, to: &Point, how: &str) -> Failure {
        let suspect = self.scene.suspect(self.from.state.as_ref(), self.worst_dof(to));
        // At the start the rates are the user's scene; shortly before the end they may only be the wreck's.
        let start = self.scene.initial_state();
        let unstable = self
            .instability(rates(self.scene, start.as_ref()), "at the start")
            .or_else(|| self.instability(rates(self.scene, self.from.state.as_ref()), "shortly before"));
        let (cause, advice) = match unstable {
            Some((why, advice)) => (format!("{how}; {why}"), advice),
            None => (format!("{how}; no instability of the step is seen in the tangent"), self.general_advice()),
        };
        self.report(suspect, cause, advice)
    }

    /// An implicit step that could not be solved. `worst` is the degree of freedom with the largest residual.
    pub(super) fn not_converged(&self, error: &StepError, worst: usize) -> Failure {
        let suspect = self.scene.suspect(self.from.state.as_ref(), worst);
        let advice = format!(
            "use a smaller step, {:.1e} s or less, or more solver.newton.max_iterations; a net that buckles or goes slack in \
             large steps may need \"slack\": \"tension-only\" springs or some damping",
            0.5 * self.h
        );
        self.report(suspect, error.to_string(), advice)
    }

    fn report(&self, suspect: Suspect, cause: String, advice: String) -> Failure {
        let Suspect { node, spring, term } = suspect;
        let term = term.map(str::to_owned);
        Failure { time: self.t, step: self.step, node, spring, term, cause, advice, blow_up_time: None }
    }

    /// The step against the fastest rates of the tangent, for schemes with a limit.
    fn instability(&self, rates: Rates, when: &str) -> Option<(String, String)> {
        let h = self.h;
        let unstable = |rate: f64| (h * rate > 1.0).then_some(h * rate);
        let advise = |step: f64, implicit: bool| {
            let or = if implicit { ", or an implicit method such as newmark" } else { "" };
            format!("use a step of {step:.1e} s or smaller{or}")
        };
        let implicit_helps = self.method.family != Family::Implicit;
        if let Some(c) = unstable(rates.damping).filter(|_| rates.damping >= rates.frequency) {
            let why = format!(
                "{when} velocity-dependent forces act within {:.1e} s (m/(dF/dv)) around node {} and the step is {c:.2} times that",
                1.0 / rates.damping,
                self.scene.name_of(rates.damping_dof).0
            );
            return Some((why, advise(0.5 / rates.damping, implicit_helps)));
        }
        unstable(rates.frequency).map(|w| {
            let why = format!(
                "{when} the stiffest oscillation has w = {:.3e} rad/s around node {}, so w h = {w:.2} where explicit schemes \
                 allow 1 to 3, less with damping",
                rates.frequency,
                self.scene.name_of(rates.frequency_dof).0
            );
            (why, advise(1.0 / rates.frequency, implicit_helps))
        })
    }

    fn general_advice(&self) -> String {
        format!("use a smaller step than {:.1e} s, or check the loads: the motion itself may be this fast", self.h)
    }

    /// The degree of freedom that is not finite (the fastest of them), else the one that moved farthest.
    fn worst_dof(&self, to: &Point) -> usize {
        let (x0, v0, x, v) = (&self.from.state.x, &self.from.state.v, &to.state.x, &to.state.v);
        let size = |i: usize| {
            let finite = x[i].is_finite() && v[i].is_finite();
            (!finite, if finite { (x[i] - x0[i]).abs() } else { v0[i].abs() })
        };
        let larger = |a: &usize, b: &usize| {
            let (a, b) = (size(*a), size(*b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        };
        (0..x.len()).max_by(larger).unwrap_or(0)
    }
}
