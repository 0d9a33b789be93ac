//! The study as a list of independent runs.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::error::StudyError;
use super::models::{Model, ModelReport, Solved, compared, problem_of};
use super::options::StudyOptions;
use super::prepared_case::{PreparedCase, choice, fingerprint_of};
use super::ranking::ReferenceQuantity;
use super::reference::{Reference, ReferenceBuilder, ReferenceReport};
use super::row::{Job, StepSetting, label, labelled};
use super::step_grid::StepScales;
use crate::analysis::critical::CostLimits;
use crate::analysis::spectrum::Spectrum;
use crate::analysis::taut::AllTaut;
use crate::case::Case;
use crate::case::fingerprint::Fingerprint;
use crate::case::schema::Method;
use crate::drive::clock::Step;
use crate::integrate::registry::{Family, MethodChoice, methods};
use crate::model::stop::Stop;
use crate::output::sanitize::file_stem;

/// Number of the layout of a plan and of the files of its runs.
pub const FORMAT: u32 = 8;
/// The program that made it; another one may compute other bits.
pub const PROGRAM: &str = env!("CARGO_PKG_VERSION");
/// Longest part of a run's identifier that comes from its method.
const LONGEST: usize = 40;

/// A study: its options and the runs that follow from them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// layout of the file
    pub format: u32,
    /// version of the program
    pub program: String,
    /// name of the case
    pub name: String,
    /// the command that planned it
    #[serde(default)]
    pub command: String,
    /// case file, as it was typed; paths in the case count from its folder
    pub case_file: String,
    /// the case, `--set` included
    pub case: Value,
    /// what was asked for
    pub asked: StudyOptions,
    /// the case and its stiffer or softer variants
    pub variants: Vec<Variant>,
    /// all runs, in the order in which one machine makes them
    pub jobs: Vec<Job>,
}

/// The case with the stiffness of its springs multiplied.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Variant {
    /// [-] factor on the stiffness of all springs
    pub stiffness_factor: f64,
    /// what is replaced in the case for it
    pub overrides: Vec<(String, String)>,
    /// what the case is, the mesh included
    pub fingerprint: Fingerprint,
    /// [s] interval of the frames that are compared
    pub every: f64,
    /// [s] end of the runs
    pub end: f64,
    /// [s] critical step at the start, method by method; only those with a limit
    pub critical_steps: BTreeMap<String, f64>,
    /// the reference; where models are compared, that of the membranes, or that with real masses
    pub reference: ReferenceReport,
    /// models that are compared; empty: the case as it is
    #[serde(default)]
    pub models: Vec<ModelReport>,
    /// why a model of the study is missing here
    #[serde(default)]
    pub missing: Option<String>,
}

impl Plan {
    /// The quantities that are measured beside the motion, in their order, as the first variant has them.
    pub fn quantities(&self) -> &[ReferenceQuantity] {
        self.variants.first().map_or(&[], |variant| &variant.reference.quantities)
    }
}

impl Variant {
    /// What the case is as a run of this variant takes it.
    pub fn fingerprint_of(&self, model: Option<Model>) -> &Fingerprint {
        let of_model = self.models.iter().find(|report| Some(report.model) == model);
        of_model.map_or(&self.fingerprint, |report| &report.fingerprint)
    }
}

/// What a plan is made from.
pub struct Planner<'a> {
    /// the case
    pub case: &'a Case,
    /// its file, as typed
    pub case_file: &'a Path,
    /// what is asked for
    pub options: StudyOptions,
    /// the command, for reports
    pub command: String,
    /// threads of the force passes
    pub threads: usize,
    /// [s] what a reference may cost, by nominal figures
    pub allowance: f64,
    /// set when the user interrupts
    pub stop: &'a AtomicBool,
    /// called with what is being done
    pub tell: &'a dyn Fn(&str),
}

impl Planner<'_> {
    /// Makes the references and lists the runs. `keep` stores each reference under the number of its variant.
    ///
    /// # Errors
    /// A bad variant, no reference, an interrupt, or a reference that cannot be stored.
    pub fn make(&self, mut keep: impl FnMut(usize, &Reference) -> Result<(), StudyError>) -> Result<Plan, StudyError> {
        let sweep = !self.options.stiffness_sweep.is_empty();
        let factors = match self.options.stiffness_sweep.as_slice() {
            [] => vec![1.0],
            some => some.iter().rev().copied().collect(),
        };
        let nothing =
            || StudyError::Usage("there is nothing to run: neither steps nor tolerances are left to try".to_owned());
        if let StudyOptions { steps: Some(steps), tolerances: Some(tolerances), .. } = &self.options
            && steps.is_empty()
            && tolerances.is_empty()
        {
            return Err(nothing());
        }
        let (mut variants, mut jobs) = (Vec::new(), Vec::new());
        for (number, factor) in factors.into_iter().enumerate() {
            let overrides = stiffer(self.case, factor)?;
            let case = self.case.with(&overrides)?;
            let of = match factor {
                1.0 => "reference".to_owned(),
                _ => format!("reference, {factor} times as stiff"),
            };
            let models = compared(&case, &self.options.models)?;
            let base = models.first().map(|model| model.reference());
            let first = self.solve(&case, base, &of)?;
            keep(number, &first.reference)?;
            let mut listed = Listed::default();
            let (mut reports, mut missing) = (Vec::new(), None);
            if base.is_none_or(|base| models.contains(&base)) {
                self.list(&first, &mut listed)?;
                reports.extend(first.model.map(|model| first.report(model, None)));
            }
            for model in models.into_iter().filter(|model| Some(*model) != base) {
                let other = self.solve(&case, Some(model), &format!("{}: its own solution", model.words()));
                missing = other.as_ref().err().filter(|_| sweep).and_then(StudyError::nothing_to_scale);
                if missing.is_some() {
                    continue;
                }
                let other = other?;
                reports.push(other.report(model, Some(first.error_of(&other)?)));
                self.list(&other, &mut listed)?;
            }
            jobs.extend(by_cost(listed.runs, number));
            variants.push(Variant {
                stiffness_factor: factor,
                overrides,
                fingerprint: fingerprint_of(case.problem())?,
                every: first.prepared.every,
                end: first.prepared.end(),
                critical_steps: listed.critical_steps,
                reference: first.reference.account,
                models: reports,
                missing,
            });
        }
        if jobs.is_empty() {
            return Err(nothing());
        }
        let problem = self.case.problem();
        Ok(Plan {
            format: FORMAT,
            program: PROGRAM.to_owned(),
            name: problem.name.clone(),
            command: self.command.clone(),
            case_file: self.case_file.display().to_string(),
            case: problem.case_json.clone(),
            asked: self.options.clone(),
            variants,
            jobs,
        })
    }

    /// The case as a model, and its solution; `what` is told of it.
    fn solve(&self, case: &Case, model: Option<Model>, what: &str) -> Result<Solved, StudyError> {
        let of_model = |source: StudyError| match model {
            Some(model) if !matches!(source, StudyError::InterruptedReference | StudyError::ClothModel(_)) => {
                StudyError::OfModel { model, source: Box::new(source) }
            }
            _ => source,
        };
        let made = || {
            let prepared = PreparedCase::of(problem_of(case, model)?, self.threads)?;
            let tell = |how: &str| (self.tell)(&format!("{what}: {how}"));
            let builder =
                ReferenceBuilder { prepared: &prepared, allowance: self.allowance, stop: self.stop, tell: &tell };
            let reference = builder.make()?;
            Ok(Solved { model, prepared, reference })
        };
        made().map_err(of_model)
    }

    /// The methods that are tried.
    fn methods(&self) -> Result<Vec<(Method, MethodChoice)>, StudyError> {
        let own = &self.case.file().time.method;
        let asked = match &self.options.methods {
            Some(methods) => methods.clone(),
            None => {
                let plain = |name: &str| Method { name: name.to_owned(), parameters: BTreeMap::new() };
                let tuned = Some(own.clone()).filter(|own| !own.parameters.is_empty());
                methods().iter().map(|info| plain(info.name)).chain(tuned).collect()
            }
        };
        asked.into_iter().map(|method| Ok((method.clone(), choice(&method)?))).collect()
    }

    /// Adds the runs of a solved case, with their nominal costs, and the critical steps of its methods.
    fn list(&self, solved: &Solved, listed: &mut Listed) -> Result<(), StudyError> {
        let Solved { model, prepared, reference } = solved;
        let state = prepared.scene.initial_state();
        let effort = CostLimits { stop: Stop::on(self.stop), ..CostLimits::FULL };
        let _all_taut = AllTaut::of(&*prepared.scene);
        let mut spectrum = Spectrum::with(&*prepared.scene, state.as_ref(), effort);
        let scales = StepScales::of(&spectrum, prepared.every, prepared.end(), reference.account.motion.period());
        let mut settings: Vec<MethodSettings> = Vec::new();
        // The steps of other methods do not depend on the lightest nodes.
        let fits = |choice: &MethodChoice| *model != Some(Model::ScaledMass) || choice.info.family == Family::Explicit;
        for (method, choice) in self.methods()?.into_iter().filter(|(_, choice)| fits(choice)) {
            let limit = spectrum.critical_step(&choice).step;
            if limit.is_finite() {
                listed.critical_steps.insert(labelled(&method, *model), limit);
            }
            let steps = match &self.options.steps {
                Some(steps) => steps.clone(),
                None => scales.steps(&choice, &mut spectrum),
            };
            let tolerances = match &self.options.tolerances {
                Some(tolerances) => tolerances.clone(),
                // With a list of steps, no tolerances are tried.
                None if self.options.steps.is_some() || choice.order() < 2 => Vec::new(),
                None => scales.tolerances(choice.order(), limit),
            };
            let steps = steps.into_iter().map(StepSetting::Step);
            let list = steps.chain(tolerances.into_iter().map(StepSetting::Tolerance)).collect();
            settings.push(MethodSettings {
                step_seconds: prepared.nominal_step(&choice),
                order: choice.order(),
                limit,
                method,
                list,
            });
        }
        if spectrum.stopped() {
            return Err(StudyError::Interrupted);
        }
        self.add_own(prepared, &mut settings);
        for tried in &settings {
            let run = |setting: &StepSetting| PlannedRun {
                seconds: tried.seconds(*setting, &scales),
                model: *model,
                method: tried.method.clone(),
                setting: *setting,
            };
            listed.runs.extend(tried.list.iter().map(run));
        }
        Ok(())
    }

    /// Adds the step or tolerance of the case, unless the options list others.
    fn add_own(&self, prepared: &PreparedCase, settings: &mut [MethodSettings]) {
        let StudyOptions { steps, tolerances, .. } = &self.options;
        let own = match prepared.problem.time.step {
            Step::Fixed(h) if steps.is_none() => StepSetting::Step(h),
            Step::Adaptive(tolerance) if tolerances.is_none() => StepSetting::Tolerance(tolerance.relative),
            _ => return,
        };
        let method = &self.case.file().time.method;
        if let Some(tried) = settings.iter_mut().find(|tried| tried.method == *method)
            && !tried.list.contains(&own)
        {
            tried.list.push(own);
        }
    }
}

/// What is to be run of a variant.
#[derive(Default)]
struct Listed {
    runs: Vec<PlannedRun>,
    /// [s] by the method's label
    critical_steps: BTreeMap<String, f64>,
}

/// A run before it has a number.
struct PlannedRun {
    /// [s] nominal cost
    seconds: f64,
    model: Option<Model>,
    method: Method,
    setting: StepSetting,
}

/// A method and what it is tried with.
struct MethodSettings {
    method: Method,
    list: Vec<StepSetting>,
    /// [s] nominal cost of a step
    step_seconds: f64,
    order: u32,
    /// [s] critical step
    limit: f64,
}

impl MethodSettings {
    /// [s] Nominal cost of a run.
    fn seconds(&self, setting: StepSetting, scales: &StepScales) -> f64 {
        let h = match setting {
            StepSetting::Step(h) => h,
            StepSetting::Tolerance(t) => {
                scales.rough_step(t, self.order).min(if self.limit > 0.0 { self.limit } else { f64::INFINITY })
            }
        };
        self.step_seconds * (scales.end / h).max(1.0)
    }
}

/// The runs in the order of their costs, so that as many as possible fit into a budget; runs of equal cost stay in the
/// order of the methods. A run's identifier holds its number, model, method and step.
fn by_cost(mut runs: Vec<PlannedRun>, variant: usize) -> Vec<Job> {
    runs.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    let job = |(number, run): (usize, PlannedRun)| {
        let PlannedRun { model, method, setting, .. } = run;
        let what = match setting {
            StepSetting::Step(h) => format!("h{h:.4e}"),
            StepSetting::Tolerance(t) => format!("tol{t:.2e}"),
        };
        let method_stem: String = file_stem(&label(&method)).chars().take(LONGEST).collect();
        let model_stem = model.map_or_else(String::new, |model| format!("{}-", file_stem(model.words())));
        let id = format!("v{variant}-{number:04}-{model_stem}{method_stem}-{what}");
        Job { id, variant, model, method, setting }
    };
    runs.into_iter().enumerate().map(job).collect()
}

/// What is replaced in a case to make its springs `factor` times as stiff.
///
/// # Errors
/// A case without springs.
pub fn stiffer(case: &Case, factor: f64) -> Result<Vec<(String, String)>, StudyError> {
    if factor == 1.0 {
        return Ok(Vec::new());
    }
    let none = || StudyError::Usage("--stiffness-sweep: this case has no springs".to_owned());
    let springs = case.problem().case_json.pointer("/system/network/springs").and_then(Value::as_array);
    let listed = springs.map_or(0, Vec::len);
    let named = springs.into_iter().flatten().any(|rule| rule.get("material").is_some());
    if case.problem().expanded.as_ref().is_some_and(|network| named || network.springs.len() != listed) {
        let why = "--stiffness-sweep: materials have the stiffness of their names; `canopy-fem check --expand` prints \
                   the case with numbers in their place";
        return Err(StudyError::Usage(why.to_owned()));
    }
    let mut overrides = Vec::new();
    for (i, rule) in springs.ok_or_else(none)?.iter().enumerate() {
        for (key, dotted) in [
            ("/stiffness", "stiffness"),
            ("/axial_rigidity", "axial_rigidity"),
            ("/membrane/modulus", "membrane.modulus"),
        ] {
            if let Some(value) = rule.pointer(key).and_then(Value::as_f64) {
                overrides.push((format!("system.network.springs.{i}.{dotted}"), format!("{:e}", value * factor)));
            }
        }
    }
    if overrides.is_empty() { Err(none()) } else { Ok(overrides) }
}
