//! Which method and which step to take for a wanted accuracy.

use super::coarse_reference::CoarseReference;
use super::cost::TangentCost;
use super::estimate::Estimate;
use super::nominal::NominalCosts;
use super::search::{CAREFUL, FoundStep, FoundTolerance, KnownBy, Search, nice};
use super::step_doubling::by_step_doubling;
use super::trials::Trials;
use super::{Candidate, ForecastSpec, planned, tolerance_of};
use crate::drive::clock::Step;
use crate::integrate::registry::Family;

/// A method with its steps for an accuracy.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Choice {
    /// name in a case
    pub method: &'static str,
    /// [-] relative tolerance of adaptive steps
    pub tolerance: f64,
    /// [-] error that this tolerance delivered; null where no run was affordable
    pub tolerance_error: Option<f64>,
    /// [s] processor time of the run with these
    pub cpu_seconds: Option<f64>,
    /// [s] fixed step, two digits, stable
    pub step: f64,
    /// [-] its error; null where no run was affordable
    pub step_error: Option<f64>,
    /// how it is known
    pub known_by: KnownBy,
    /// [s] the run with that step without output: counted work times what its units cost
    pub integration_seconds: f64,
    /// the run with that step
    pub fixed: Option<Estimate>,
}

/// What to take.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Advice {
    /// [-] wanted accuracy, relative to the motion
    pub accuracy: f64,
    /// [-] part of the run that was compared with a reference; 0 where none was affordable
    pub compared: f64,
    /// the cheapest to integrate
    pub best: Choice,
    /// the cheapest of the other family: implicit against explicit
    pub runner_up: Option<Choice>,
    /// [-] how many times the runner-up's integration costs what the best's does, by counted work; below 1 where the
    /// best was measured and the runner-up, which was not, seems cheaper
    pub factor: Option<f64>,
    /// [-] how many times cheaper to integrate the case's own run is, by counted work, where it is clearly cheaper and
    /// its error is not known
    pub own_cheaper: Option<f64>,
}

/// [-] Costs within this factor count as equal. Of equally cheap methods the case's own is recommended, otherwise the
/// one with the smallest error, otherwise the first of the registry.
const TIE: f64 = 1.15;
/// Methods that are often the cheapest. They are tried first, so that more expensive ones can be skipped early. The
/// order affects only the time of the search.
const FIRST: [&str; 4] = ["velocity-verlet", "rk4", "dop853", "newmark"];
/// Methods tried where no reference is affordable.
const UNMEASURED: [&str; 2] = ["velocity-verlet", "newmark"];

/// [-] The case's own run, whose error is not known, is reported as cheaper from this factor on.
const CHEAPER: f64 = 2.0;
/// [-] A step concluded from local errors is preferred to a measured one only if it is this many times cheaper. Local
/// errors may be wrong by a factor of hundreds, and the steps and costs that follow from them by a factor of tens.
const FAR: f64 = 100.0;

/// [-] Recommended share of the mean step that local errors allow, if nothing was measured.
const UNKNOWN: f64 = 0.2;

/// A method and its step.
type Offer<'c> = (&'c Candidate, FoundStep);

/// Searches for the steps of all methods that may be the cheapest.
pub struct Adviser<'s, 'a> {
    spec: &'s ForecastSpec<'a>,
    costs: NominalCosts,
    search: Option<Search<'a>>,
}

impl<'s, 'a> Adviser<'s, 'a> {
    /// Makes the reference.
    pub fn new(spec: &'s ForecastSpec<'a>, tangent: Option<&TangentCost>) -> Self {
        let ForecastSpec { scene, accuracy, .. } = *spec;
        let costs = NominalCosts::new(scene, tangent);
        let reference = CoarseReference::of(spec);
        let search = reference.map(|reference| Search { reference, costs, accuracy });
        Adviser { spec, costs, search }
    }

    /// Whether runs were compared with the reference up to the end of the case.
    pub fn sees_all(&self) -> bool {
        self.search.as_ref().is_some_and(|search| search.reference.seen() >= 1.0)
    }

    /// Methods with their steps, in the order of the candidates. Methods that cost clearly more than another one of
    /// their family are left out.
    pub fn offers(&self, trials: &mut Trials<'_>) -> Vec<Offer<'a>> {
        let mut offers = Vec::new();
        for implicit in [false, true] {
            let found = self.search.as_ref().map_or_else(Vec::new, |search| self.measured(search, implicit));
            let found = if found.is_empty() && implicit { self.halved() } else { found };
            offers.extend(if found.is_empty() { self.unmeasured(trials, implicit) } else { found });
        }
        let place = |offer: &Offer<'_>| {
            self.spec.candidates.iter().position(|c| c.method.info.name == offer.0.method.info.name)
        };
        offers.sort_by_key(place);
        offers
    }

    /// The candidates of a family in the order of trial: the case's own method, those of [`FIRST`], the others.
    fn family(&self, implicit: bool) -> impl Iterator<Item = &'a Candidate> {
        let own = self.spec.problem.method.info.name;
        let rank = move |c: &&Candidate| match c.method.info.name {
            name if name == own => 0,
            name => 1 + FIRST.iter().position(|first| *first == name).unwrap_or(FIRST.len()),
        };
        let mut family: Vec<&'a Candidate> =
            self.spec.candidates.iter().filter(|c| (c.method.info.family == Family::Implicit) == implicit).collect();
        family.sort_by_key(rank);
        family.into_iter()
    }

    fn measured(&self, search: &Search<'a>, implicit: bool) -> Vec<Offer<'a>> {
        let mut offers: Vec<Offer<'a>> = Vec::new();
        for candidate in self.family(implicit).filter(|c| search.tries(c, self.spec.problem.method.info.name)) {
            if self.spec.budget.left() == 0.0 {
                break;
            }
            let cheapest = offers.iter().map(|(_, found)| found.seconds).fold(f64::INFINITY, f64::min);
            offers.extend(search.step(candidate, TIE * cheapest).map(|found| (candidate, found)));
        }
        offers
    }

    /// By step doubling, with the case's own method if it is implicit, otherwise with Newmark's.
    fn halved(&self) -> Vec<Offer<'a>> {
        let own = self.spec.problem.method.info.name;
        let tried = self.family(true).find(|c| own == c.method.info.name || UNMEASURED.contains(&c.method.info.name));
        tried.and_then(|c| by_step_doubling(self.spec, self.costs, c).map(|found| (c, found))).into_iter().collect()
    }

    /// From the adaptive steps that local errors allow.
    fn unmeasured(&self, trials: &mut Trials<'_>, implicit: bool) -> Vec<Offer<'a>> {
        let ForecastSpec { problem, accuracy, .. } = *self.spec;
        let own = problem.method.info.name;
        let tried =
            self.family(implicit).filter(|c| own == c.method.info.name || UNMEASURED.contains(&c.method.info.name));
        let offer = |candidate: &'a Candidate| {
            let limit = candidate.limit.filter(|limit| limit.step > 0.0)?;
            let made = trials.predict(candidate, Step::Adaptive(tolerance_of(accuracy))).ok()?;
            // How local errors add up is not known: with the mean adaptive step the error may be hundreds of times
            // larger.
            let careful = UNKNOWN * CAREFUL.powf(1.0 / f64::from(candidate.method.order()));
            let step = nice((careful * made.mean_step).min(limit.safe()), problem.time.end);
            // The work of adaptive steps does not apply: every change of the step changes W.
            let seconds = self.costs.untried(&candidate.method, problem.time.end / step);
            Some((candidate, FoundStep { step, error: None, known_by: KnownBy::LocalErrors, seconds, run: None }))
        };
        tried.filter_map(offer).collect()
    }

    /// The cheapest method and the cheapest of the other family. `complete` predicts runs that were not made, and adds
    /// the cost of output.
    pub fn advise(
        &self,
        offers: &[Offer<'a>],
        mut complete: impl FnMut(&Candidate, Step, Option<Estimate>) -> Option<Estimate>,
    ) -> Option<Advice> {
        let own = self.spec.problem.method.info.name;
        let of = |implicit: bool| {
            offers.iter().filter(|(c, _)| (c.method.info.family == Family::Implicit) == implicit).copied().collect()
        };
        let families: [Vec<Offer<'a>>; 2] = [of(false), of(true)];
        let cheapest: Vec<Offer<'a>> = families.iter().filter_map(|family| prefer(family, own)).collect();
        let best = best_of(&cheapest, own)?;
        let other = cheapest.iter().find(|(c, _)| c.method.info.name != best.0.method.info.name);
        let factor = other.map(|(_, found)| found.seconds / best.1.seconds);
        let mut choose = |(candidate, found): Offer<'a>| self.choice(candidate, found, &mut complete);
        Some(Advice {
            accuracy: self.spec.accuracy,
            compared: self.search.as_ref().map_or(0.0, |search| search.reference.seen()),
            best: choose(best),
            runner_up: other.map(|offer| choose(*offer)),
            factor,
            own_cheaper: self.own_cheaper(offers, best.1.seconds),
        })
    }

    /// [-] Factor by which the case's own run is cheaper than `seconds`, if it is clearly cheaper and was not measured.
    fn own_cheaper(&self, offers: &[Offer<'a>], seconds: f64) -> Option<f64> {
        let ForecastSpec { problem, candidates, .. } = *self.spec;
        let own = candidates.iter().find(|c| c.method.info.name == problem.method.info.name)?;
        let name = own.method.info.name;
        // A method that was measured and is not among the offers was too expensive at the wanted accuracy.
        let known = match offers.iter().find(|(c, _)| c.method.info.name == name) {
            Some((_, found)) => found.known_by != KnownBy::LocalErrors,
            None => self.search.as_ref().is_some_and(|search| search.tries(own, name)),
        };
        let step = planned(own, problem.time.step, problem.time.end).fixed()?;
        let times = seconds / self.costs.untried(&own.method, problem.time.end / step);
        (times > CHEAPER && !known).then_some(times)
    }

    fn choice(
        &self,
        candidate: &Candidate,
        found: FoundStep,
        complete: &mut impl FnMut(&Candidate, Step, Option<Estimate>) -> Option<Estimate>,
    ) -> Choice {
        let FoundTolerance { tolerance, error, run: adaptive } = match &self.search {
            Some(search) if self.spec.budget.left() > 0.0 => search.tolerance(candidate, &found),
            _ => FoundTolerance::untried(self.spec.accuracy),
        };
        let adaptive = complete(candidate, Step::Adaptive(tolerance_of(tolerance)), adaptive);
        Choice {
            method: candidate.method.info.name,
            tolerance,
            tolerance_error: error,
            cpu_seconds: adaptive.map(|estimate| estimate.cpu_seconds),
            step: found.step,
            step_error: found.error,
            known_by: found.known_by,
            integration_seconds: found.seconds,
            fixed: complete(candidate, Step::Fixed(found.step), found.run),
        }
    }
}

/// The cheapest measured offer, unless an offer concluded from local errors is [`FAR`] times cheaper.
fn best_of<'c>(offers: &[Offer<'c>], own: &str) -> Option<Offer<'c>> {
    let (concluded, measured): (Vec<Offer<'c>>, Vec<Offer<'c>>) =
        offers.iter().copied().partition(|(_, found)| found.known_by == KnownBy::LocalErrors);
    let concluded = prefer(&concluded, own);
    let Some(measured) = prefer(&measured, own) else { return concluded };
    Some(concluded.filter(|(_, found)| FAR * found.seconds < measured.1.seconds).unwrap_or(measured))
}

/// Of all offers that cost about as little as the cheapest: the case's own method, otherwise the most accurate.
fn prefer<'c>(offers: &[Offer<'c>], own: &str) -> Option<Offer<'c>> {
    let least = offers.iter().map(|(_, found)| found.seconds).fold(f64::INFINITY, f64::min);
    let mut equal = offers.iter().filter(|(_, found)| found.seconds <= TIE * least);
    let error = |(_, found): &&Offer<'c>| found.error.unwrap_or(f64::INFINITY);
    let exact = equal.clone().min_by(|a, b| error(a).total_cmp(&error(b)))?;
    Some(*equal.find(|(c, _)| c.method.info.name == own).unwrap_or(exact))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(seconds: f64, known_by: KnownBy) -> FoundStep {
        FoundStep { step: 1e-3, error: None, known_by, seconds, run: None }
    }

    /// A measured step is preferred to a cheaper one that was not measured, unless it costs hundreds of times as much.
    #[test]
    fn what_was_measured_goes_first_unless_the_other_is_far_cheaper() {
        let candidates = ["velocity-verlet", "newmark"].map(|name| Candidate {
            method: crate::integrate::registry::MethodChoice::with_defaults(name).expect("in the registry"),
            limit: None,
        });
        let best = |explicit: FoundStep, implicit: FoundStep| {
            let offers = [(&candidates[0], explicit), (&candidates[1], implicit)];
            best_of(&offers, "rk4").expect("there are two").0.method.info.name
        };
        for (ratio, expected) in [(0.5, "velocity-verlet"), (50.0, "velocity-verlet"), (150.0, "newmark")] {
            assert_eq!(best(found(ratio, KnownBy::Part), found(1.0, KnownBy::LocalErrors)), expected, "{ratio}");
        }
        assert_eq!(best(found(2.0, KnownBy::Part), found(1.0, KnownBy::Run)), "newmark");
        assert_eq!(best(found(2.0, KnownBy::LocalErrors), found(1.0, KnownBy::LocalErrors)), "newmark");
    }
}
