//! From rows to answers: which method and step for an accuracy, and where implicit steps begin to win.

use serde::Serialize;

use super::pareto::{TIE, cheapest};
use super::plan::Plan;
use super::row::{Row, RowStatus, StepSetting};
use crate::format_number::figures;
use crate::integrate::registry::Family;

/// Accuracies asked about: powers of ten from here down to the reference's error.
const LARGEST_TARGET: i32 = -1;
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
    /// [-] wanted error
    pub wanted: f64,
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

/// All answers of a study.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Recommendations {
    /// one an accuracy and variant
    pub targets: Vec<Recommendation>,
    /// one a variant
    pub crossovers: Vec<Crossover>,
    /// a table over accuracies and stiffnesses, of a study that sweeps them
    pub stiffness: Vec<StiffnessPoint>,
    /// one an accuracy, of a study that sweeps stiffnesses
    pub stiffness_crossovers: Vec<StiffnessCrossover>,
}

impl Recommendations {
    /// From the rows of a study.
    pub fn of(plan: &Plan, rows: &[Row]) -> Self {
        let mut answers = Recommendations::default();
        for variant in 0..plan.variants.len() {
            let view = View::of(plan, rows, variant);
            answers.targets.extend(targets(view.reference_error).filter_map(|wanted| view.answer(wanted)));
            answers.crossovers.push(view.crossover());
        }
        if plan.variants.len() > 1 {
            answers.sweep(plan, rows);
        }
        answers
    }

    fn sweep(&mut self, plan: &Plan, rows: &[Row]) {
        let worst = plan.variants.iter().map(|v| v.reference.error).fold(0.0, f64::max);
        for wanted in targets(worst) {
            let mut points: Vec<StiffnessPoint> = (0..plan.variants.len())
                .map(|variant| {
                    let view = View::of(plan, rows, variant);
                    let stiffness_factor = plan.variants.get(variant).map_or(1.0, |v| v.stiffness_factor);
                    let [explicit, implicit] = view.families(wanted).map(|found| found.map(|(row, _)| view.pick(row)));
                    StiffnessPoint { stiffness_factor, wanted, explicit, implicit }
                })
                .collect();
            points.sort_by(|a, b| a.stiffness_factor.total_cmp(&b.stiffness_factor));
            if points.iter().any(|p| p.explicit.is_some() || p.implicit.is_some()) {
                self.stiffness_crossovers.push(stiffness_crossover(wanted, &points));
                self.stiffness.extend(points);
            }
        }
    }
}

/// Powers of ten from the largest down to the reference's error.
fn targets(reference_error: f64) -> impl Iterator<Item = f64> {
    let powers = (SMALLEST_TARGET..=LARGEST_TARGET).rev();
    let power = |p: i32| format!("1e{p}").parse().unwrap_or(10f64.powi(p));
    powers.map(power).filter(move |wanted: &f64| *wanted >= reference_error)
}

/// The rows of one variant.
struct View<'a> {
    variant: usize,
    rows: Vec<&'a Row>,
    reference_error: f64,
}

impl<'a> View<'a> {
    fn of(plan: &Plan, rows: &'a [Row], variant: usize) -> Self {
        let reference_error = plan.variants.get(variant).map_or(0.0, |v| v.reference.error);
        View { variant, rows: rows.iter().filter(|r| r.job.variant == variant).collect(), reference_error }
    }

    fn cheapest(&self, wanted: f64, which: impl Fn(&Row) -> bool) -> Option<(&'a Row, f64)> {
        cheapest(self.rows.iter().copied().filter(|row| which(row)), wanted, self.reference_error)
    }

    /// Without and with a matrix.
    fn families(&self, wanted: f64) -> [Option<(&'a Row, f64)>; 2] {
        [false, true].map(|implicit| self.cheapest(wanted, |row| (row.family == Family::Implicit) == implicit))
    }

    fn pick(&self, row: &Row) -> Pick {
        Pick {
            id: row.job.id.clone(),
            method: row.label(),
            setting: row.job.setting,
            error: row.measured.error.unwrap_or(f64::NAN),
            cpu_seconds: row.cpu_seconds.unwrap_or(f64::NAN),
        }
    }

    fn answer(&self, wanted: f64) -> Option<Recommendation> {
        let (best, cost) = self.cheapest(wanted, |_| true)?;
        let next = self.cheapest(wanted, |row| row.job.method != best.job.method);
        let [explicit, implicit] = self.families(wanted);
        let other = if best.family == Family::Implicit { explicit } else { implicit };
        let mut sentence = format!("for {wanted:e} use {}: {} s", used(best), figures(cost, 2));
        let mut compared = Vec::new();
        if let Some((row, c)) = next {
            compared.push(compare(c / cost, row));
        }
        match other {
            Some((row, c)) if next.is_none_or(|(next, _)| next.job.id != row.job.id) => {
                let kind =
                    if row.family == Family::Implicit { "the best implicit one" } else { "the best explicit one" };
                compared.push(format!("{}, {kind}", compare(c / cost, row)));
            }
            Some(_) => {}
            None => compared.extend(self.none_as_accurate(best.family != Family::Implicit)),
        }
        if !compared.is_empty() {
            sentence.push_str(&format!(", {}", compared.join("; ")));
        }
        let pick = |found: Option<(&Row, f64)>| found.map(|(row, _)| self.pick(row));
        let (variant, next, best) = (self.variant, pick(next), self.pick(best));
        Some(Recommendation {
            variant,
            wanted,
            best,
            next,
            explicit: pick(explicit),
            implicit: pick(implicit),
            sentence,
        })
    }

    /// Why the other family gave nothing; nothing if it was not asked for.
    fn none_as_accurate(&self, implicit: bool) -> Option<String> {
        let kind = if implicit { "implicit" } else { "explicit" };
        let others = self.rows.iter().filter(|row| (row.family == Family::Implicit) == implicit);
        let (all, open) = others
            .fold((0, 0), |(all, open), row| (all + 1, open + usize::from(row.measured.status == RowStatus::NotRun)));
        match (all, open) {
            (0, _) => None,
            (_, 0) => Some(format!("no {kind} run was as accurate")),
            (_, open) if open == all => Some(format!("no {kind} run was made yet")),
            (_, 1) => Some(format!("no {kind} run was as accurate so far, one is still to be made")),
            (_, open) => Some(format!("no {kind} run was as accurate so far, {open} are still to be made")),
        }
    }

    /// Walks down all errors that were reached and sees which family is cheaper.
    fn crossover(&self) -> Crossover {
        let mut errors: Vec<f64> = self.rows.iter().filter_map(|r| r.rank_error(self.reference_error)).collect();
        errors.sort_by(|a, b| b.total_cmp(a));
        errors.dedup();
        let mut compared: Vec<(f64, f64)> = Vec::new();
        for error in errors {
            if let [Some((_, explicit)), Some((_, implicit))] = self.families(error) {
                compared.push((error, implicit / explicit));
            }
        }
        let changes: Vec<f64> = compared
            .windows(2)
            .filter_map(|pair| match pair {
                [(a, before), (b, after)] if (*before > 1.0) != (*after > 1.0) => Some((a * b).sqrt()),
                _ => None,
            })
            .collect();
        let sentence = describe(&compared, &changes);
        Crossover { variant: self.variant, errors: changes, sentence }
    }
}

/// A method and its steps as one would type them.
pub fn used(row: &Row) -> String {
    row.job.setting.of(&row.label())
}

fn compare(factor: f64, row: &Row) -> String {
    if factor < TIE {
        format!("about as cheap as {}", used(row))
    } else {
        format!("{} times cheaper than {}", figures(factor, 2), used(row))
    }
}

/// `compared`: error and cost of the best implicit over that of the best explicit run, errors descending.
fn describe(compared: &[(f64, f64)], changes: &[f64]) -> String {
    let (Some(first), Some(last)) = (compared.first(), compared.last()) else {
        return "no accuracy was reached by both explicit and implicit methods".to_owned();
    };
    let range = |part: &[(f64, f64)], invert: bool| {
        let factors = part.iter().map(|(_, f)| if invert { 1.0 / f } else { *f });
        let (low, high) = factors.fold((f64::INFINITY, 0.0_f64), |(l, h), f| (l.min(f), h.max(f)));
        match [figures(low, 2), figures(high, 2)] {
            [low, high] if low == high => format!("by {low} times"),
            [low, high] => format!("by {low} to {high} times"),
        }
    };
    let [from, to] = [first.0, last.0].map(|e| figures(e, 2));
    match changes {
        [] => {
            let explicit = first.1 > 1.0;
            let kind = if explicit { "explicit" } else { "implicit" };
            let accuracies = if from == to {
                format!("the only accuracy both reached, {from}")
            } else {
                format!("every accuracy both reached, {from} to {to}")
            };
            format!("{kind} methods are cheaper at {accuracies}, {}", range(compared, !explicit))
        }
        [one] => {
            let [above, below] = if first.1 > 1.0 { ["explicit", "implicit"] } else { ["implicit", "explicit"] };
            format!(
                "{above} methods are cheaper down to an error of about {}, {below} ones below it (compared from {from} to {to})",
                figures(*one, 2)
            )
        }
        many => {
            let at = many.iter().map(|e| figures(*e, 2)).collect::<Vec<_>>().join(", ");
            let first = if first.1 > 1.0 { "explicit" } else { "implicit" };
            format!(
                "{first} methods are cheaper at first; the cheaper family changes at errors of about {at} (compared from {from} to {to}): close to a draw there"
            )
        }
    }
}

/// `points` by ascending stiffness.
fn stiffness_crossover(wanted: f64, points: &[StiffnessPoint]) -> StiffnessCrossover {
    let ratio = |p: &StiffnessPoint| match (&p.explicit, &p.implicit) {
        (Some(e), Some(i)) => Some((p.stiffness_factor, (i.cpu_seconds / e.cpu_seconds).ln())),
        _ => None,
    };
    let compared: Vec<(f64, f64)> = points.iter().filter_map(ratio).collect();
    let crossing = compared.windows(2).find_map(|pair| match pair {
        [(a, before), (b, after)] if *before > 0.0 && *after <= 0.0 => {
            let share = before / (before - after);
            Some((a.ln() + share * (b.ln() - a.ln())).exp())
        }
        _ => None,
    });
    let sentence = match (crossing, compared.first(), compared.last()) {
        (Some(factor), ..) => {
            format!("for {wanted:e} implicit methods begin to win at about {} times the stiffness", figures(factor, 2))
        }
        (None, Some((from, first)), Some((to, last))) if (*first > 0.0 && *last > 0.0) || *last <= 0.0 => {
            let kind = if *last > 0.0 { "explicit" } else { "implicit" };
            match [from, to].map(|factor| figures(*factor, 3)) {
                [from, to] if from == to => format!(
                    "for {wanted:e} {kind} methods win at {from} times the stiffness, the only one that both families reached"
                ),
                [from, to] => format!("for {wanted:e} {kind} methods win from {from} to {to} times the stiffness"),
            }
        }
        (None, Some(_), Some(_)) => format!("for {wanted:e} implicit methods win on the softer springs only"),
        _ => format!("for {wanted:e} there is no stiffness at which both families got there"),
    };
    let alone = |has: &dyn Fn(&StiffnessPoint) -> bool| {
        let factors: Vec<String> = points.iter().filter(|p| has(p)).map(|p| figures(p.stiffness_factor, 3)).collect();
        factors.join(", ")
    };
    let explicit = alone(&|p| p.explicit.is_some() && p.implicit.is_none());
    let implicit = alone(&|p| p.explicit.is_none() && p.implicit.is_some());
    let left = [("explicit", explicit), ("implicit", implicit)]
        .into_iter()
        .filter(|(_, at)| !at.is_empty())
        .map(|(kind, at)| format!("; at {at} times only {kind} ones got there"));
    let sentence = sentence + &left.collect::<String>();
    StiffnessCrossover { wanted, stiffness_factor: crossing, sentence }
}

/// Rows that gave no answer, counted by how they ended.
pub fn unfinished(rows: &[Row]) -> String {
    let count = |status: RowStatus| rows.iter().filter(|r| r.measured.status == status).count();
    let kinds = [RowStatus::Diverged, RowStatus::NotConverged, RowStatus::Refused, RowStatus::NotRun];
    let words =
        kinds.into_iter().map(|s| (count(s), s)).filter(|(n, _)| *n > 0).map(|(n, s)| format!("{n} {}", s.word()));
    words.collect::<Vec<_>>().join(", ")
}
