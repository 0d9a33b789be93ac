//! Why a run went wrong, from evidence: the limits of the scheme for the tangent, the effect of the loads in one step,
//! and the supports.

use crate::analysis::critical::{Confidence, CostLimits, CriticalStep, has_limit, implicit_for, remedy};
use crate::analysis::limit::{critical_step, growth};
use crate::analysis::rates::Rates;
use crate::analysis::spectrum::Spectrum;
use crate::analysis::taut::AllTaut;
use crate::format_number::figures;
use crate::integrate::registry::{Family, MethodChoice};
use crate::mesh::with_groups;
use crate::model::abilities::SpringDamping;
use crate::model::forces::Role;
use crate::model::state::State;
use crate::model::stop::Stop;
use crate::model::system::TermInfo;
use crate::scene::{Scene, fastest_spring};

mod held;
mod units;
mod unsolved;

/// Recommended share of the limit of forces outside Kang's filter.
const SAFE: f64 = 0.5;
/// [rad] w h of a step that resolves an oscillation well
const RESOLVED: f64 = 0.3;
/// A step above this share of the critical one is near enough to be the cause.
const NEAR: f64 = 0.9;

/// The run to diagnose.
#[derive(Clone, Copy)]
pub(super) struct DiagnosisInput<'a> {
    pub scene: &'a dyn Scene,
    pub method: &'a MethodChoice,
    /// last good state
    pub last: &'a State,
    /// [s] step size
    pub h: f64,
    /// [s] end of the run
    pub end: f64,
    /// whether the search is to end early
    pub stop: Stop<'a>,
}

/// The cause that was found, and advice.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Diagnosis {
    /// the cause in words; empty if none was found
    pub why: String,
    pub advice: String,
    /// [s] critical step, where one was found
    pub critical: Option<f64>,
    /// degree of freedom that sets it
    pub dof: Option<usize>,
}

impl Diagnosis {
    /// The diagnosis of a search that was interrupted; `h` [s] is the step.
    fn cut_short(h: f64) -> Self {
        Diagnosis {
            why: "the search for the cause was cut short by a signal".to_owned(),
            advice: format!(
                "take a step of {} s or smaller, or run it again and let the search end",
                figures(0.1 * h, 2)
            ),
            ..Diagnosis::default()
        }
    }
}

/// The limit of a method at a state.
#[derive(Clone, Copy)]
struct Limit {
    critical: CriticalStep,
    when: &'static str,
}

impl DiagnosisInput<'_> {
    /// Why the scheme has made energy.
    pub(super) fn gain(&self) -> Diagnosis {
        let start = self.scene.initial_state();
        let found = self.explicit(&start).or_else(|| self.unresolved(&start));
        if self.stop.asked() {
            return Diagnosis::cut_short(self.h);
        }
        let mut answer = found.unwrap_or_default();
        if answer.advice.is_empty() {
            answer.advice = format!(
                "take a step of {} s or smaller, some damping, or a method that damps: time.method=backward-euler",
                figures(0.1 * self.h, 2)
            );
        }
        self.with_units(answer)
    }

    fn with_units(&self, mut answer: Diagnosis) -> Diagnosis {
        let start = self.scene.initial_state();
        let steps = answer.critical.map_or(0.0, |critical| self.end / critical);
        if let Some((why, check)) = self.units(&start, steps) {
            let joint = if answer.why.is_empty() { "" } else { "; " };
            answer.why = format!("{}{joint}{why}", answer.why);
            answer.advice = format!("check {check} for a wrong unit; with these numbers {}", answer.advice);
        }
        answer
    }

    /// Why nodes have left the scene although the scheme made no energy: `error` is that of the energy account.
    pub(super) fn flight(&self, error: f64) -> Diagnosis {
        let found = self.explicit(&self.scene.initial_state());
        if self.stop.asked() {
            return Diagnosis::cut_short(self.h);
        }
        if let Some(answer) = found {
            return self.with_units(answer);
        }
        if error > 0.1 {
            return self.gain();
        }
        let unheld = self.unheld(0).map_or(String::new(), |words| format!("; {words}"));
        Diagnosis {
            why: format!(
                "the energy account is right to {} %, so loads or speeds carry the nodes away, and no equilibrium is near{unheld}",
                figures(100.0 * error, 2)
            ),
            advice: format!(
                "check loads, wind, speeds and supports; or end the run before t = {} s (time.end), or let it keep going",
                figures(self.last.t, 3)
            ),
            ..Diagnosis::default()
        }
    }

    /// Compares the step with the critical step at the start, else in the last good state.
    fn explicit(&self, start: &State) -> Option<Diagnosis> {
        let method = self.method;
        if self.method.info.family == Family::MatrixFree {
            return self.outside_filter(start).or_else(|| self.outside_filter(self.last));
        }
        if !has_limit(method) {
            return None;
        }
        let all_taut = AllTaut::of(self.scene);
        let first = self.limit(method, start, "at the start");
        drop(all_taut);
        let over = |limit: &Limit| self.h > NEAR * limit.critical.step;
        // The start first: its state is credible, and the warning before the run was about it.
        let found =
            first.filter(over).or_else(|| self.limit(method, self.last, "in the last good state").filter(over))?;
        Some(if found.critical.step > 0.0 { self.too_long(&found) } else { self.always_grows(method, &found) })
    }

    fn limit(&self, method: &MethodChoice, at: &State, when: &'static str) -> Option<Limit> {
        let mut spectrum = self.spectrum(at);
        let mut critical = spectrum.critical_step(method);
        let Rates { frequency, damping, .. } = spectrum.rates();
        if !(critical.step.is_finite() && (frequency > 0.0 || damping > 0.0)) {
            critical = self.row_sums(method)?;
        }
        Some(Limit { critical, when })
    }

    fn spectrum<'a>(&'a self, at: &'a State) -> Spectrum<'a> {
        Spectrum::with(self.scene, at.as_ref(), CostLimits { stop: self.stop, ..CostLimits::FULL })
    }

    /// A limit from row sums of the springs' stiffness (Gershgorin), where products with the tangent overflow.
    fn row_sums(&self, method: &MethodChoice) -> Option<CriticalStep> {
        let (dof, square) = self.stiffest_row()?;
        let rates = Rates { frequency: square.sqrt(), frequency_dof: dof, ..Rates::default() };
        let step = critical_step(method, rates);
        let found = rates.frequency > 0.0 && rates.frequency.is_finite() && step.is_finite();
        found.then_some(CriticalStep { step, confidence: Confidence::Estimate, dof, rates })
    }

    fn too_long(&self, found: &Limit) -> Diagnosis {
        let &Limit { critical: CriticalStep { step, confidence, dof, rates }, when, .. } = found;
        let about = if matches!(confidence, Confidence::Certified { .. }) { "" } else { "about " };
        let motion = self.motion(dof, rates);
        let why = format!(
            "the step of {} s is {about}{} the critical step of {} {when}, {} s, set by {motion}",
            figures(self.h, 4),
            times(self.h / step),
            self.method.info.name,
            figures(step, 3),
        );
        Diagnosis { why, advice: remedy(&found.critical, self.h), critical: Some(step), dof: Some(dof) }
    }

    /// The oscillation, or the velocity-dependent force, that sets the limit.
    fn motion(&self, dof: usize, rates: Rates) -> String {
        let place = self.place(dof);
        if rates.damping > 2.0 * rates.frequency {
            let mut viscous = Vec::new();
            for term in self.scene.terms().iter().filter(|t| t.velocity_dependent) {
                // There is one term per spring rule, with the same name.
                if !viscous.contains(&term.name) {
                    viscous.push(term.name);
                }
            }
            return format!(
                "forces that depend on velocity ({}), which act within m/(dF/dv) = {} s {place}",
                viscous.join(", "),
                figures(1.0 / rates.damping, 3)
            );
        }
        let turning = self.turning();
        let why = match self.springs_alone() {
            Some(springs) if rates.frequency > springs && !turning.is_empty() => {
                format!(
                    ", more than springs alone can have; the cause is loads that turn with the cloth ({})",
                    turning.join(", ")
                )
            }
            _ => String::new(),
        };
        // The limit of a scheme that makes energy may be set by a slow oscillation with little damping.
        format!("the oscillation of {} rad/s {place}{why}", figures(rates.frequency, 4))
    }

    /// Names of loads that turn with the cloth.
    fn turning(&self) -> Vec<&'static str> {
        self.scene.terms().iter().filter(|t| t.follower).map(|t| t.name).collect()
    }

    /// [rad/s] Upper bound of the frequencies of the springs, by row sums of their stiffness (Gershgorin).
    fn springs_alone(&self) -> Option<f64> {
        self.stiffest_row().map(|(_, square)| square.sqrt()).filter(|w| *w > 0.0 && w.is_finite())
    }

    fn stiffest_row(&self) -> Option<(usize, f64)> {
        let stiffness = self.scene.nodal_stiffness();
        let squares = stiffness.iter().zip(self.scene.inverse_mass()).map(|(k, m)| 2.0 * k * m);
        squares.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn always_grows(&self, method: &MethodChoice, found: &Limit) -> Diagnosis {
        let CriticalStep { dof, rates, .. } = found.critical;
        let factor = growth(method, rates, self.h).map_or(1.0, |r| r * r);
        let swells = if !factor.is_finite() {
            "more than a number can hold".to_owned()
        } else if factor > 2.0 {
            format!("{} times a step", figures(factor, 3))
        } else {
            format!("{} % a step", figures(100.0 * (factor - 1.0), 3))
        };
        let why = format!(
            "{} has no stable step without damping: its spectrum predicts that the energy of {} grows by {swells}",
            self.method.info.name,
            self.motion(dof, rates)
        );
        Diagnosis { why, advice: remedy(&found.critical, self.h), critical: Some(0.0), dof: Some(dof) }
    }

    /// Forces outside Kang's filter are explicit. Loads are outside; dashpots may be inside, which their tangent does
    /// not show.
    fn outside_filter(&self, at: &State) -> Option<Diagnosis> {
        let outside = |t: &TermInfo| t.velocity_dependent && t.role == Role::External;
        let loaded = self.scene.terms().iter().any(outside);
        let rates = self.spectrum(at).rates();
        // The limit of explicit Euler. A relaxation without overshoot needs half of it, and the filter needs a step
        // that resolves the motion.
        let critical = 2.0 / rates.damping;
        if !loaded || self.h <= NEAR * critical {
            return None;
        }
        let dof = rates.damping_dof;
        let why = format!(
            "the step of {} s is about {} what {} allows forces beside its springs: they act within m/(dF/dv) = {} s {}",
            figures(self.h, 4),
            times(self.h / critical),
            self.method.info.name,
            figures(1.0 / rates.damping, 3),
            self.place(dof)
        );
        let step = (SAFE * critical).min(RESOLVED / rates.frequency);
        let advice = format!("take a step of {} s or smaller, or {}", figures(step, 2), implicit_for(rates, self.h));
        Some(Diagnosis { why, advice, critical: Some(critical), dof: Some(dof) })
    }

    /// A step too long to resolve oscillations, with a method that is stable on linear scenes for any step.
    fn unresolved(&self, start: &State) -> Option<Diagnosis> {
        let rates = |at: &State| self.spectrum(at).rates();
        let (first, last) = (rates(start), rates(self.last));
        let found = if last.frequency > first.frequency { last } else { first };
        let wh = self.h * found.frequency;
        if wh.is_nan() || wh <= RESOLVED {
            return None;
        }
        let (does, weak) = match self.method.info.family {
            Family::MatrixFree => ("jumps over", "its sweeps are then a poor approximation of an implicit step"),
            Family::Implicit if self.turns_dashpots() => {
                ("jumps over", "an axial dashpot takes a spring that turns within a step for one that stretches")
            }
            Family::Implicit => ("jumps over", "this method is stable on linear scenes only"),
            Family::Explicit => ("is coarse for", "the energy oscillates with it, although the scheme may be stable"),
        };
        let why = format!(
            "the step of {} s {does} motions of this scene (w h = {} for the fastest, {} rad/s {}): {weak}",
            figures(self.h, 4),
            figures(wh, 3),
            figures(found.frequency, 4),
            self.place(found.frequency_dof),
        );
        let step = format!("a step of {} s or smaller", figures(RESOLVED / found.frequency, 2));
        let advice = match (self.method.info.family, self.method.info.linear.always_dissipates) {
            (Family::Explicit, _) => format!("take {step}, or time.method=rk4"),
            (_, true) if self.turns_dashpots() => {
                format!("take a step of {} s or smaller, or dashpots of a shorter time", figures(0.1 * self.h, 2))
            }
            (_, true) => format!("take {step}"),
            _ => format!("take time.method=backward-euler, {}or {step}", self.dashpots()),
        };
        Some(Diagnosis { why, advice, critical: None, dof: Some(found.frequency_dof) })
    }

    /// Whether a method that makes no energy by itself has axial dashpots: their rate n . (vb - va) is not 0 for a
    /// spring that only turns, if v is a difference over the step.
    fn turns_dashpots(&self) -> bool {
        let damping = self.scene.springs().map(|springs| springs.damping());
        self.method.info.linear.always_dissipates && damping == Some(SpringDamping::Axial)
    }

    /// What to add where air damps the cloth across its springs, and nothing along them.
    fn dashpots(&self) -> String {
        let in_air = |term: &TermInfo| term.velocity_dependent && term.on_triangles && term.role == Role::External;
        let undamped = self.scene.springs().is_some_and(|springs| springs.damping() == SpringDamping::None);
        if !undamped || !self.scene.terms().iter().any(in_air) {
            return String::new();
        }
        format!("\"dashpot\": {{\"axial\": {{\"time\": {}}}}} in the rules of springs, ", figures(self.h, 2))
    }

    fn place(&self, dof: usize) -> String {
        let node = self.scene.name_of(dof).0;
        let spring = fastest_spring(self.scene, dof).map(|spring| format!("spring {spring}"));
        let groups = self.scene.parts().of_node(node).into_iter().map(str::to_owned);
        let place: Vec<String> = spring.into_iter().chain(groups).collect();
        format!("around {}", with_groups("node", node, &place))
    }
}

/// "2.5 times", or nothing for a factor of one.
fn times(ratio: f64) -> String {
    match figures(ratio, 3).as_str() {
        "1" => "just".to_owned(),
        ratio => format!("{ratio} times"),
    }
}
