//! Why a run was stopped, with advice for the user.

use super::cause::{Diagnosis, DiagnosisInput};
use super::observer::Energies;
use super::run_spec::Explain;
use super::watch::{DOUBTFUL, DivergenceKind, EnergyGain};
use crate::format_number::figures;
use crate::integrate::StepError;
use crate::integrate::registry::MethodChoice;
use crate::mesh::NamedParts;
use crate::model::forces::Role;
use crate::model::point::Point;
use crate::model::stop::Stop;
use crate::scene::{Scene, Suspect};
use crate::solve::LinearError;
use crate::solve::newton::NewtonFailure;
use std::collections::BTreeMap;

/// What `summary.json` shows under `failure`.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Failure {
    /// [s] when the failure was found
    pub time: f64,
    /// step in which it was found, counted from 1
    pub step: u64,
    /// node, in the user's numbering
    pub node: Option<u32>,
    /// most strained spring at that node
    pub spring: Option<u32>,
    /// fastest triangle at that node, where something acts on triangles
    pub triangle: Option<u32>,
    /// force term with the largest force on that node
    pub term: Option<String>,
    /// the pair of contact that presses most on that node, in words
    #[serde(default)]
    pub pair: Option<String>,
    /// what changed most in energy in that step: `inertia` or a force term
    pub grew: Option<String>,
    /// [-] growth per step of the energy that the scheme has made, over the last steps
    pub growth: Option<f64>,
    /// [s] critical step of the method, where one was found; 0 for a method without stable step
    pub critical_step: Option<f64>,
    /// what happened
    pub cause: String,
    /// what to do
    pub advice: String,
    /// [s] when a value was not finite, or beyond 1e4 times the scene's size
    pub blow_up_time: Option<f64>,
}

impl Failure {
    /// The groups of its `node`, `spring` and `triangle`; `parts` are those of the scene.
    pub fn groups(&self, parts: NamedParts<'_>) -> BTreeMap<String, Vec<String>> {
        let of = |what: &str, names: Option<Vec<&str>>| {
            let names: Vec<String> = names?.into_iter().map(str::to_owned).collect();
            (!names.is_empty()).then(|| (what.to_owned(), names))
        };
        let node = of("node", self.node.map(|node| parts.of_node(node)));
        let spring = of("spring", self.spring.map(|spring| parts.of_edge(spring)));
        let triangle = of("triangle", self.triangle.map(|triangle| parts.of_triangle(triangle)));
        [node, spring, triangle].into_iter().flatten().collect()
    }
}

/// The state of a run when a step failed.
pub(super) struct FailureContext<'a> {
    pub scene: &'a dyn Scene,
    pub method: &'a MethodChoice,
    /// last good point
    pub from: &'a Point,
    pub step: u64,
    /// [s] size of the failed step
    pub h: f64,
    /// [s] time the failed step ends at
    pub t: f64,
    /// [s] end of the run
    pub end: f64,
    /// energy that the scheme has made until then
    pub gain: EnergyGain,
    /// failures for which the cause is searched
    pub explain: Explain,
    /// whether the search is to end early
    pub stop: Stop<'a>,
}

/// The diverged state and its energy account.
pub(super) struct DivergedState<'a> {
    pub trouble: DivergenceKind,
    pub to: &'a Point,
    pub before: Energies,
    pub after: Energies,
    pub gain: EnergyGain,
}

/// What a scheme has made beside what there was.
fn made(gain: EnergyGain) -> String {
    let [made, supplied] = [gain.made, gain.supplied].map(|energy| figures(energy, 3));
    format!("made {made} J of energy, but only {supplied} J were present or supplied")
}

impl FailureContext<'_> {
    /// The report of a diverged state.
    pub(super) fn diverged(&self, diverged: &DivergedState<'_>) -> Failure {
        let mut worst = self.worst_dof(diverged.to);
        let fullest = self.fullest_spring(diverged);
        if let Some((_, dof)) = fullest {
            worst = dof;
        }
        let mut suspect = self.scene.suspect(self.from.state.as_ref(), worst);
        if let Some((spring, _)) = fullest {
            suspect.spring = Some(spring);
        }
        let how = self.how(diverged, worst, &suspect);
        let looked_for = self.explain != Explain::Nothing;
        let answer = match diverged.trouble {
            _ if !looked_for => Diagnosis::default(),
            // The scheme made less energy than was supplied: the motion is real.
            DivergenceKind::Spread { share, error, .. } if share < 1.0 => self.question().flight(error),
            _ => self.question().gain(),
        };
        let cause = match &*answer.why {
            "" if !looked_for => how,
            "" => format!("{how}; the tangent shows no limit of the step"),
            why => format!("{how}; {why}"),
        };
        let triangle = self.fastest_triangle(diverged.to, &suspect);
        let failure = self.report(suspect, cause, answer.advice);
        let (grew, growth) = (Some(self.grew(diverged)), diverged.gain.growth);
        Failure { triangle, grew, growth, critical_step: answer.critical, ..failure }
    }

    /// A warning about energy that the scheme has made.
    pub(super) fn doubt(&self, gain: EnergyGain) -> String {
        let made = format!(
            "the scheme itself has made energy: by t = {} s (step {}) {} has made {} J, but only {} J were present or supplied",
            figures(self.t, 4),
            self.step,
            self.method.info.name,
            figures(gain.made, 3),
            figures(gain.supplied, 3),
        );
        if self.explain != Explain::All {
            return made;
        }
        let Diagnosis { why, advice, .. } = self.question().gain();
        let joint = if why.is_empty() { "" } else { ": " };
        format!("{made}{joint}{why}; {advice}")
    }

    /// An implicit step that could not be solved. `worst` is the degree of freedom with the largest residual, if it was
    /// tried.
    pub(super) fn not_converged(&self, error: &StepError, worst: Option<usize>) -> Failure {
        let touches = self.scene.touches().filter(|_| matches!(error, StepError::Newton(_)));
        let pair = touches.zip(worst).and_then(|(touches, dof)| touches.pressed_most(self.from.state.as_ref(), dof));
        Failure { pair, ..self.unsolved(error, worst) }
    }

    fn unsolved(&self, error: &StepError, worst: Option<usize>) -> Failure {
        let Some(worst) = worst else {
            let advice = "no step was tried: the matrix or its solver could not be set up; choose another solver.linear, or a method without matrix";
            return self.report(Suspect::default(), error.to_string(), advice.to_owned());
        };
        let suspect = self.scene.suspect(self.from.state.as_ref(), worst);
        if let StepError::Passed(_) = error {
            let advice = format!(
                "what meets within a step is too fast, or is pressed too hard, for this gap: take a step of {} s or smaller, a wider gap, or \
                 an implicit method, as time.method=newmark, whose contacts no load closes",
                figures(0.5 * self.h, 2)
            );
            return self.report(suspect, error.to_string(), advice);
        }
        if let StepError::Newton(NewtonFailure::NotFinite { .. }) = error {
            let advice = "check loads, wind, masses, speeds and damping for a wrong unit: a force, or the square of one, has left the \
                          range of a double, which a smaller step seldom cures";
            return self.report(suspect, error.to_string(), advice.to_owned());
        }
        if let StepError::Newton(NewtonFailure::Hidden { .. }) = error {
            let advice = "make the stiffest springs softer, or put the origin nearer to the scene: stiffness times coordinates, times 1e-15, \
                          must stay far below the forces that move the scene";
            return self.report(suspect, error.to_string(), advice.to_owned());
        }
        if let StepError::Newton(NewtonFailure::Linear { error: LinearError::Stalled { .. }, .. }) = error {
            let advice =
                "take \"linear\": \"cholesky\" where the tangent is symmetric, else \"auto\"; or a smaller step";
            return self.report(suspect, error.to_string(), advice.to_owned());
        }
        if self.gain.made > DOUBTFUL * self.gain.supplied {
            return self.not_converged_after_gain(error, suspect);
        }
        let (why, step) = match self.explain {
            Explain::Nothing => (String::new(), 0.5 * self.h),
            Explain::Failures | Explain::All => self.question().unsolved(worst),
        };
        let cause = if why.is_empty() { error.to_string() } else { format!("{error}; {why}") };
        let advice = format!(
            "take a step of {} s or smaller, or more solver.newton.max_iterations; a net that buckles or goes slack in \
             large steps may need some damping{}",
            figures(step, 2),
            if self.method.info.linear.always_dissipates { "" } else { ", or time.method=backward-euler" }
        );
        self.report(suspect, cause, advice)
    }

    /// A step that could not be solved because its start has more energy than any motion of the scene.
    fn not_converged_after_gain(&self, error: &StepError, suspect: Suspect) -> Failure {
        let Diagnosis { why, advice, .. } = match self.explain {
            Explain::Nothing => Diagnosis::default(),
            Explain::Failures | Explain::All => self.question().gain(),
        };
        let cause = format!(
            "{} itself had {}: no motion leads to the state that this step begins with{}{why}; {error}",
            self.method.info.name,
            made(self.gain),
            if why.is_empty() { "" } else { "; " },
        );
        self.report(suspect, cause, advice)
    }

    fn question(&self) -> DiagnosisInput<'_> {
        DiagnosisInput {
            scene: self.scene,
            method: self.method,
            last: &self.from.state,
            h: self.h,
            end: self.end,
            stop: self.stop,
        }
    }

    pub(super) fn report(&self, suspect: Suspect, cause: String, advice: String) -> Failure {
        let Suspect { node, spring, term } = suspect;
        let term = term.map(|term| term.name.to_owned());
        Failure { time: self.t, step: self.step, node, spring, term, cause, advice, ..Failure::default() }
    }

    fn how(&self, diverged: &DivergedState<'_>, worst: usize, suspect: &Suspect) -> String {
        let grows = |gain: EnergyGain| match gain.growth {
            Some(growth) if growth > 1.0 => {
                format!("; the energy made by the scheme grew {}-fold in this step", figures(growth, 3))
            }
            _ => String::new(),
        };
        match diverged.trouble {
            DivergenceKind::NotFinite => "a value is not finite".to_owned(),
            DivergenceKind::Spread { times, .. } => {
                format!("the nodes have spread beyond {times:.0e} times the scene's size")
            }
            DivergenceKind::Energy(gain) => format!(
                "{} itself has {}{}{}",
                self.method.info.name,
                made(gain),
                self.speed(diverged, worst, gain),
                grows(gain)
            ),
            DivergenceKind::Strain { elastic, gain } => format!(
                "the {} hold {} J, but only {} J were present or supplied{}{}",
                self.elastic_parts(),
                figures(elastic, 3),
                figures(gain.supplied, 3),
                self.strain(diverged, suspect),
                grows(gain)
            ),
        }
    }

    /// What can hold elastic energy.
    fn elastic_parts(&self) -> String {
        let mut names: Vec<&str> = Vec::new();
        for term in self.scene.terms().iter().filter(|term| term.role == Role::Elastic) {
            if !names.contains(&term.name) {
                names.push(term.name);
            }
        }
        match (&names[..], self.scene.terms().iter().any(|term| term.role == Role::Elastic && term.on_triangles)) {
            ([name], false) => (*name).to_owned(),
            _ => format!("elastic forces ({})", names.join(", ")),
        }
    }

    /// A speed that would need more than all the energy.
    fn speed(&self, diverged: &DivergedState<'_>, worst: usize, gain: EnergyGain) -> String {
        let inverse = self.scene.inverse_mass().get(worst).copied().unwrap_or(0.0);
        let speed = diverged.to.state.v.get(worst).map_or(0.0, |v| v.abs());
        let possible = (2.0 * gain.supplied * inverse).sqrt();
        if !(possible > 0.0 && speed > possible && speed.is_finite()) {
            return String::new();
        }
        let (node, axis) = self.scene.name_of(worst);
        let unit = if axis == "angle" { "rad/s" } else { "m/s" };
        format!(
            "; all of it would give {} alone a speed of {} {unit}, and its {axis} changes at {} {unit}",
            self.scene.node_in_words(node),
            figures(possible, 3),
            figures(speed, 3)
        )
    }

    /// The spring with the most energy, if the springs are the cause, and a degree of freedom at its end.
    fn fullest_spring(&self, diverged: &DivergedState<'_>) -> Option<(u32, usize)> {
        let DivergenceKind::Strain { .. } = diverged.trouble else { return None };
        let (scene, reference) = (self.scene, self.scene.reference());
        let (mut tension, mut strain) = (vec![0.0; scene.edges().len()], vec![0.0; scene.edges().len()]);
        scene.edge_tension(diverged.to.state.as_ref(), &mut tension, &mut strain);
        let length = |[a, b]: [u32; 2]| -> Option<f64> {
            let (a, b) = (reference.get(a as usize)?, reference.get(b as usize)?);
            Some(a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt())
        };
        let energy = |((tension, strain), edge): ((&f64, &f64), &[u32; 2])| {
            let energy = tension * strain * length(*edge).unwrap_or(0.0);
            if energy.is_nan() { 0.0 } else { energy }
        };
        let energies = tension.iter().zip(&strain).zip(scene.edges()).map(energy);
        let (spring, _) = energies.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let ends = scene.edges().get(spring)?;
        let free = |dof: &usize| {
            ends.contains(&scene.name_of(*dof).0) && scene.inverse_mass().get(*dof).is_some_and(|m| *m > 0.0)
        };
        Some((spring as u32, (0..scene.n_dof()).find(free)?))
    }

    /// The strain of the suspected spring in the state that is wrong.
    fn strain(&self, diverged: &DivergedState<'_>, suspect: &Suspect) -> String {
        let n = self.scene.edges().len();
        let (mut tension, mut strain) = (vec![0.0; n], vec![0.0; n]);
        self.scene.edge_tension(diverged.to.state.as_ref(), &mut tension, &mut strain);
        let of = |spring: u32| strain.get(spring as usize).map(|strain| (spring, *strain));
        let strained = suspect.spring.and_then(of).filter(|(_, strain)| strain.is_finite());
        strained.map_or(String::new(), |(spring, strain)| {
            format!("; {} is strained by {} %", self.scene.spring_in_words(spring), figures(100.0 * strain, 3))
        })
    }

    /// What changed most in energy in the step; the first that is not finite.
    fn grew(&self, diverged: &DivergedState<'_>) -> String {
        let changes = self.scene.terms().iter().zip(&self.from.forces.tallies).zip(&diverged.to.forces.tallies);
        let changes = changes.map(|((term, from), to)| match term.role {
            Role::Elastic | Role::Gravity => (term.name, (to.energy - from.energy).abs()),
            Role::External | Role::Dissipative => (term.name, (to.power * self.h).abs()),
        });
        let inertia = ("inertia", (diverged.after.kinetic - diverged.before.kinetic).abs());
        let size = |change: f64| if change.is_finite() { change } else { f64::INFINITY };
        let largest = changes.fold(inertia, |most, next| if size(next.1) > size(most.1) { next } else { most });
        largest.0.to_owned()
    }

    /// The triangle at the suspected node whose nodes move fastest, if a force on triangles is suspected.
    fn fastest_triangle(&self, to: &Point, suspect: &Suspect) -> Option<u32> {
        let node = suspect.node?;
        suspect.term.filter(|term| term.on_triangles)?;
        let n = self.scene.reference().len();
        let (mut x, mut v) = (vec![[0.0; 3]; n], vec![[0.0; 3]; n]);
        self.scene.trace(to.state.as_ref(), &mut x, &mut v);
        let speed = |t: &[u32; 3]| -> f64 {
            t.iter().filter_map(|&i| v.get(i as usize)).flatten().map(|v| v.abs()).fold(0.0, f64::max)
        };
        let here = (0u32..).zip(self.scene.triangles()).filter(|(_, t)| t.contains(&node));
        here.max_by(|a, b| speed(a.1).total_cmp(&speed(b.1))).map(|(i, _)| i)
    }

    /// A degree of freedom that is not finite (the fastest of them); else the one whose kinetic energy grew most; else
    /// the one that moved farthest.
    fn worst_dof(&self, to: &Point) -> usize {
        let (x0, v0, x, v) = (&self.from.state.x, &self.from.state.v, &to.state.x, &to.state.v);
        let inverse = self.scene.inverse_mass();
        let size = |i: usize| {
            let finite = x[i].is_finite() && v[i].is_finite();
            let gained = if finite && inverse[i] > 0.0 { (v[i] * v[i] - v0[i] * v0[i]) / inverse[i] } else { 0.0 };
            // A held degree of freedom is not finite because of the forces of its neighbours.
            (!finite && inverse[i] > 0.0, gained.max(0.0), if finite { (x[i] - x0[i]).abs() } else { v0[i].abs() })
        };
        let larger = |a: &usize, b: &usize| {
            let (a, b) = (size(*a), size(*b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.total_cmp(&b.2))
        };
        (0..x.len()).max_by(larger).unwrap_or(0)
    }
}
