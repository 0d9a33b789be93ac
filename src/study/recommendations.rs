//! From rows to answers: which method and step for an accuracy, and where implicit steps begin to win.

use minijinja::{Value, context};
use serde::Serialize;

use super::error::StudyError;
use super::models::{Model, ModelError};
use super::pareto::{TIE, cheapest};
use super::plan::{Plan, Variant};
use super::ranking::Ranking;
use super::row::{Row, RowStatus, StepSetting};
use super::template::render;
use crate::integrate::registry::Family;

/// Accuracies asked about: powers of ten from here down to the reference's error.
const LARGEST_TARGET: i32 = -1;
/// Runs of two models are compared within this multiple of the error of the cheaper one.
const WITHIN: f64 = 2.0;
/// The smallest power of ten that is asked about.
const SMALLEST_TARGET: i32 = -12;

/// A run in an answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pick {
    /// identifier of the run
    pub id: String,
    /// its method in a word
    pub method: String,
    /// its steps
    #[serde(flatten)]
    pub setting: StepSetting,
    /// [-] its error
    pub error: f64,
    /// [s] its processor time
    pub cpu_seconds: f64,
}

/// What to use for an accuracy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Recommendation {
    /// [-] number of the variant
    pub variant: usize,
    /// quantities whose worst error is meant; none: the error of the motion
    pub quantities: Vec<String>,
    /// [-] wanted error
    pub wanted: f64,
    /// [-] what the reference is worth: no run is ranked below it
    pub reference_error: f64,
    /// the cheapest run that is good enough
    pub best: Pick,
    /// the cheapest run of another method that is good enough
    pub next: Option<Pick>,
    /// the cheapest one without a matrix
    pub explicit: Option<Pick>,
    /// the cheapest one with a matrix
    pub implicit: Option<Pick>,
    /// the answer as a sentence
    pub sentence: String,
}

/// Where one family begins to win.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Crossover {
    /// [-] number of the variant
    pub variant: usize,
    /// [-] errors at which the cheaper family changes, descending
    pub errors: Vec<f64>,
    /// in words
    pub sentence: String,
}

/// The cheapest of either family for an accuracy at one stiffness.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StiffnessPoint {
    /// [-] factor on the stiffness
    pub stiffness_factor: f64,
    /// [-] wanted error
    pub wanted: f64,
    /// the cheapest without a matrix
    pub explicit: Option<Pick>,
    /// the cheapest with one
    pub implicit: Option<Pick>,
}

/// Where implicit steps begin to win as springs get stiffer, for one accuracy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StiffnessCrossover {
    /// [-] wanted error
    pub wanted: f64,
    /// [-] factor on the stiffness at which both cost the same, by interpolation; `None` where they do not cross
    pub stiffness_factor: Option<f64>,
    /// in words
    pub sentence: String,
}

/// What a model costs in accuracy and in time, beside the one it is compared with.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModelAnswer {
    /// [-] number of the variant
    pub variant: usize,
    /// the model
    pub model: Model,
    /// [-] how far the two solutions are apart
    pub error: f64,
    /// [-] largest distance over the largest motion
    pub error_max: f64,
    /// [-] what the two solutions themselves are worth, together
    pub known_to: f64,
    /// [-] error within which the costs are compared; `None` where the model is too far off
    pub within: Option<f64>,
    /// the cheapest run of the model within it
    pub own: Option<Pick>,
    /// the cheapest run within it of the model that errors are measured against
    pub reference: Option<Pick>,
    /// the answer as a sentence
    pub sentence: String,
}

/// All answers of a study.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Recommendations {
    /// one an accuracy and variant
    pub targets: Vec<Recommendation>,
    /// one a variant
    pub crossovers: Vec<Crossover>,
    /// one a model and variant, of a study that compares models
    pub models: Vec<ModelAnswer>,
    /// a table over accuracies and stiffnesses, of a study that sweeps them
    pub stiffness: Vec<StiffnessPoint>,
    /// one an accuracy, of a study that sweeps stiffnesses
    pub stiffness_crossovers: Vec<StiffnessCrossover>,
}

impl Recommendations {
    /// From the rows of a study.
    ///
    /// # Errors
    /// What the template engine refuses.
    pub fn of(plan: &Plan, rows: &[Row]) -> Result<Self, StudyError> {
        let mut answers = Recommendations::default();
        for variant in 0..plan.variants.len() {
            for ranking in Ranking::answered(plan, variant) {
                let rows = VariantRows::of(rows, variant, ranking);
                for wanted in targets(rows.ranking.bound()) {
                    answers.targets.extend(rows.answer(wanted)?);
                }
            }
            answers.crossovers.push(VariantRows::of(rows, variant, Ranking::of(plan, variant)).crossover()?);
            let rows = VariantRows::of(rows, variant, Ranking::motion(plan.variants.get(variant)));
            for report in plan.variants.get(variant).into_iter().flat_map(|variant| &variant.models) {
                if let Some(error) = &report.error {
                    answers.models.push(rows.model(report.model, error)?);
                }
            }
        }
        if plan.variants.len() > 1 {
            answers.sweep(plan, rows)?;
        }
        Ok(answers)
    }

    fn sweep(&mut self, plan: &Plan, rows: &[Row]) -> Result<(), StudyError> {
        let rankings: Vec<Ranking<'_>> = (0..plan.variants.len()).map(|number| Ranking::of(plan, number)).collect();
        let worst = rankings.iter().map(Ranking::bound).fold(0.0, f64::max);
        for wanted in targets(worst) {
            let point = |(number, (variant, ranking)): (usize, (&Variant, &Ranking<'_>))| {
                let [explicit, implicit] = VariantRows::of(rows, number, ranking.clone()).families(wanted);
                StiffnessPoint { stiffness_factor: variant.stiffness_factor, wanted, explicit, implicit }
            };
            let mut points: Vec<StiffnessPoint> = plan.variants.iter().zip(&rankings).enumerate().map(point).collect();
            points.sort_by(|a, b| a.stiffness_factor.total_cmp(&b.stiffness_factor));
            if points.iter().any(|p| p.explicit.is_some() || p.implicit.is_some()) {
                self.stiffness_crossovers.push(stiffness_crossover(wanted, &points)?);
                self.stiffness.extend(points);
            }
        }
        Ok(())
    }
}

/// Powers of ten from the largest down to the reference's error.
fn targets(reference_error: f64) -> impl Iterator<Item = f64> {
    let powers = (SMALLEST_TARGET..=LARGEST_TARGET).rev();
    let power = |p: i32| format!("1e{p}").parse().unwrap_or(10f64.powi(p));
    powers.map(power).filter(move |wanted: &f64| *wanted >= reference_error)
}

/// A sentence of the template.
fn sentence(context: Value) -> Result<String, StudyError> {
    let text = render("answers.txt", include_str!("templates/answers.txt"), &context)?;
    Ok(text.trim().to_owned())
}

/// The rows of one variant.
struct VariantRows<'a> {
    variant: usize,
    rows: Vec<&'a Row>,
    ranking: Ranking<'a>,
}

impl<'a> VariantRows<'a> {
    fn of(rows: &'a [Row], variant: usize, ranking: Ranking<'a>) -> Self {
        VariantRows { variant, rows: rows.iter().filter(|r| r.job.variant == variant).collect(), ranking }
    }

    fn cheapest(&self, wanted: f64, which: impl Fn(&Row) -> bool) -> Option<Pick> {
        let rows = self.rows.iter().copied().filter(|row| which(row));
        let (row, cpu_seconds) = cheapest(rows, wanted, &self.ranking)?;
        let error = self.ranking.measured(row).unwrap_or(f64::NAN);
        Some(Pick { id: row.job.id.clone(), method: row.label(), setting: row.job.setting, error, cpu_seconds })
    }

    /// The cheapest without and with a matrix.
    fn families(&self, wanted: f64) -> [Option<Pick>; 2] {
        [false, true].map(|implicit| self.cheapest(wanted, |row| (row.family == Family::Implicit) == implicit))
    }

    fn answer(&self, wanted: f64) -> Result<Option<Recommendation>, StudyError> {
        let Some(best) = self.cheapest(wanted, |_| true) else { return Ok(None) };
        let next = self.cheapest(wanted, |row| row.label() != best.method);
        let [explicit, implicit] = self.families(wanted);
        // All runs of a family, and those that are still to be made.
        let made = |implicit: bool| {
            let rows = || self.rows.iter().filter(|row| (row.family == Family::Implicit) == implicit);
            let open = rows().filter(|row| row.measured.status == RowStatus::NotRun).count();
            context! { all => rows().count(), open }
        };
        let made = context! { explicit => made(false), implicit => made(true) };
        let quantities = self.ranking.names();
        let sentence = sentence(
            context! { about => "target", tie => TIE, quantities, wanted, best, next, explicit, implicit, made },
        )?;
        let (variant, reference_error) = (self.variant, self.ranking.bound());
        Ok(Some(Recommendation {
            variant,
            quantities,
            wanted,
            reference_error,
            best,
            next,
            explicit,
            implicit,
            sentence,
        }))
    }

    /// What a model costs.
    fn model(&self, model: Model, found: &ModelError) -> Result<ModelAnswer, StudyError> {
        let ModelError { error, error_max, ref solution } = *found;
        let known_to = self.ranking.bound() + solution.error;
        let within = Some(WITHIN * error.max(known_to)).filter(|within| *within < 1.0);
        let cheapest = |of: Model| self.cheapest(within?, |row| row.job.model == Some(of));
        let (own, reference) = (cheapest(model), cheapest(model.reference()));
        let sentence = sentence(
            context! { about => "model", tie => TIE, model, error, error_max, known_to, within, own, reference },
        )?;
        let variant = self.variant;
        Ok(ModelAnswer { variant, model, error, error_max, known_to, within, own, reference, sentence })
    }

    /// Goes through all errors that were reached, in descending order, and compares the families at each.
    fn crossover(&self) -> Result<Crossover, StudyError> {
        let mut errors: Vec<f64> = self.rows.iter().filter_map(|row| self.ranking.error(row)).collect();
        errors.sort_by(|a, b| b.total_cmp(a));
        errors.dedup();
        // Error, and cost of the best implicit over that of the best explicit run.
        let compare = |error| match self.families(error) {
            [Some(explicit), Some(implicit)] => Some((error, implicit.cpu_seconds / explicit.cpu_seconds)),
            _ => None,
        };
        let compared: Vec<(f64, f64)> = errors.into_iter().filter_map(compare).collect();
        let changes: Vec<f64> = compared
            .windows(2)
            .filter_map(|pair| match pair {
                [(a, before), (b, after)] if (*before > 1.0) != (*after > 1.0) => Some((a * b).sqrt()),
                _ => None,
            })
            .collect();
        let explicit_first = compared.first().is_some_and(|first| first.1 > 1.0);
        let factors = compared.iter().map(|(_, f)| if explicit_first { *f } else { 1.0 / f });
        let cost_factors = factors.fold([f64::INFINITY, 0.0_f64], |[low, high], f| [low.min(f), high.max(f)]);
        let span = compared.first().zip(compared.last()).map(|(first, last)| [first.0, last.0]);
        let sentence = sentence(context! { about => "crossover", span, explicit_first, cost_factors, changes })?;
        Ok(Crossover { variant: self.variant, errors: changes, sentence })
    }
}

/// `points` by ascending stiffness.
fn stiffness_crossover(wanted: f64, points: &[StiffnessPoint]) -> Result<StiffnessCrossover, StudyError> {
    let ratio = |p: &StiffnessPoint| match (&p.explicit, &p.implicit) {
        (Some(e), Some(i)) => Some((p.stiffness_factor, (i.cpu_seconds / e.cpu_seconds).ln())),
        _ => None,
    };
    let both: Vec<(f64, f64)> = points.iter().filter_map(ratio).collect();
    let crossing = both.windows(2).find_map(|pair| match pair {
        [(a, before), (b, after)] if *before > 0.0 && *after <= 0.0 => {
            let share = before / (before - after);
            Some((a.ln() + share * (b.ln() - a.ln())).exp())
        }
        _ => None,
    });
    let alone = |has: fn(&StiffnessPoint) -> bool| {
        points.iter().filter(|p| has(p)).map(|p| p.stiffness_factor).collect::<Vec<_>>()
    };
    let only = context! {
        explicit => alone(|p| p.explicit.is_some() && p.implicit.is_none()),
        implicit => alone(|p| p.explicit.is_none() && p.implicit.is_some())
    };
    let sentence = sentence(context! { about => "stiffness", wanted, both, crossing, only })?;
    Ok(StiffnessCrossover { wanted, stiffness_factor: crossing, sentence })
}

/// Rows that gave no answer, counted by how they ended.
pub fn unfinished(rows: &[Row]) -> String {
    let count = |status: RowStatus| rows.iter().filter(|r| r.measured.status == status).count();
    let kinds = [RowStatus::Diverged, RowStatus::NotConverged, RowStatus::Refused, RowStatus::NotRun];
    let words =
        kinds.into_iter().map(|s| (count(s), s)).filter(|(n, _)| *n > 0).map(|(n, s)| format!("{n} {}", s.word()));
    words.collect::<Vec<_>>().join(", ")
}
