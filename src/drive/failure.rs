//! Why a run was stopped, in words a person can act on.

use crate::analysis::limit::critical_step;
use crate::analysis::rates::{Rates, rates};
use crate::integrate::StepError;
use crate::integrate::registry::{Family, MethodChoice};
use crate::model::point::Point;
use crate::scene::{Scene, Suspect};
use crate::solve::newton::NewtonFailure;

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
    pub method: &'a MethodChoice,
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
        let (start, last) = (self.scene.initial_state(), self.from.state.as_ref());
        let unstable = self.instability(rates(self.scene, start.as_ref()), "at the start").or_else(|| {
            // These rates are already the wreck's: they tell what grew, not which step would have been small enough.
            let (why, _) = self.instability(rates(self.scene, last), "in the last good state")?;
            Some((why, format!("use a step of {:.1e} s or smaller{}", 0.1 * self.h, self.or_implicit())))
        });
        let (cause, advice) = match unstable {
            Some((why, advice)) => (format!("{how}; {why}"), advice),
            None => (format!("{how}; no instability of the step is seen in the tangent"), self.general_advice()),
        };
        self.report(suspect, cause, advice)
    }

    /// An implicit step that could not be solved. `worst` is the degree of freedom with the largest residual.
    pub(super) fn not_converged(&self, error: &StepError, worst: usize) -> Failure {
        let suspect = self.scene.suspect(self.from.state.as_ref(), worst);
        if let StepError::Newton(NewtonFailure::NotFinite { .. }) = error {
            let advice = "check loads, wind, masses, speeds and damping for a wrong unit: a force, or the square of one, has left the \
                          range of a double, which a smaller step seldom mends";
            return self.report(suspect, error.to_string(), advice.to_owned());
        }
        let advice = format!(
            "use a smaller step, {:.1e} s or less, or more solver.newton.max_iterations; a net that buckles or goes slack in \
             large steps may need \"slack\": \"tension-only\" springs or some damping",
            0.5 * self.h
        );
        self.report(suspect, error.to_string(), advice)
    }

    pub(super) fn report(&self, suspect: Suspect, cause: String, advice: String) -> Failure {
        let Suspect { node, spring, term } = suspect;
        let term = term.map(str::to_owned);
        Failure { time: self.t, step: self.step, node, spring, term, cause, advice, blow_up_time: None }
    }

    /// The step against the fastest rates of the tangent, for schemes with a limit: what is wrong and what to do.
    fn instability(&self, rates: Rates, when: &str) -> Option<(String, String)> {
        let node = |dof: usize| self.scene.name_of(dof).0;
        let (c, w) = (self.h * rates.damping, self.h * rates.frequency);
        let advise = || self.advice_for(rates);
        if c > 1.0 && c >= w {
            let why = format!(
                "{when} velocity-dependent forces act within {:.1e} s (m/(dF/dv)) around node {}, and the step is {:.1e} s",
                1.0 / rates.damping,
                node(rates.damping_dof),
                self.h
            );
            return Some((why, advise()));
        }
        (w > 1.0).then(|| {
            let why = format!(
                "{when} the stiffest oscillation has w = {:.3e} rad/s around node {}, so w h = {w:.3e} where explicit schemes \
                 allow 1 to 3, less with damping",
                rates.frequency,
                node(rates.frequency_dof)
            );
            (why, advise())
        })
    }

    /// Nine tenths of the method's own limit on an oscillator with these rates.
    fn advice_for(&self, rates: Rates) -> String {
        let limit = critical_step(self.method, rates);
        if limit == 0.0 {
            return format!(
                "{} grows at every step on undamped oscillations: use velocity-verlet, rk4 or an implicit method such as \
                 newmark",
                self.method.info.name
            );
        }
        if limit.is_infinite() {
            return self.general_advice();
        }
        format!("use a step of {:.1e} s or smaller{}", 0.9 * limit, self.or_implicit())
    }

    fn or_implicit(&self) -> &'static str {
        if self.method.info.family == Family::Implicit { "" } else { ", or an implicit method such as newmark" }
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
