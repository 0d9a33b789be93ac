//! Errors of quantities in a study, and what its runs are ranked by: the motion of all nodes, or the worst of some
//! quantities.

use serde::{Deserialize, Serialize};

use super::plan::{Plan, Variant};
use super::row::{Row, RowStatus};
use super::worth::KnownError;

/// The name of the motion of all nodes among quantities.
const MOTION: &str = "motion";

/// A quantity as the reference knows it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReferenceQuantity {
    /// its name
    pub name: String,
    /// its unit
    pub unit: String,
    /// its value; none where the reference does not have it
    pub value: Option<f64>,
    /// what errors are relative to, in its unit: the value, or a hundredth of the largest of its series where that is
    /// more; `None` where both are 0, and errors are in the unit
    pub scale: Option<f64>,
    /// the reference's own error, as those of the runs; `None` where it is not known
    pub error: Option<f64>,
    /// how it is known
    pub error_by: KnownError,
}

impl ReferenceQuantity {
    /// The error of a value, relative to [`ReferenceQuantity::scale`].
    pub fn error_of(&self, value: f64) -> Option<f64> {
        Some((value - self.value?).abs() / self.scale.unwrap_or(1.0)).filter(|error| error.is_finite())
    }
}

/// A quantity of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct QuantityResult {
    /// its value
    pub value: Option<f64>,
    /// its error, relative as [`ReferenceQuantity::scale`] says
    pub error: Option<f64>,
}

/// What the runs of a variant are ranked by: the worst of its parts.
#[derive(Clone, Debug, Default)]
pub struct Ranking<'a> {
    /// [-] error of the reference in the motion, if that is a part
    motion: Option<f64>,
    /// quantities with a known error
    quantities: Vec<&'a ReferenceQuantity>,
    /// quantities in which the reference does not know its error: nothing is ranked by them
    unknown: Vec<&'a ReferenceQuantity>,
}

impl<'a> Ranking<'a> {
    /// By the motion.
    pub fn motion(variant: Option<&Variant>) -> Self {
        let motion = Some(variant.map_or(0.0, |variant| variant.reference.error));
        Ranking { motion, ..Ranking::default() }
    }

    /// By the worst of these quantities.
    pub fn worst(quantities: impl Iterator<Item = &'a ReferenceQuantity>) -> Self {
        let (quantities, unknown) = quantities.partition(|quantity| quantity.error.is_some());
        Ranking { motion: None, quantities, unknown }
    }

    /// As a plan asks for it: by the quantities that are named, else by the motion.
    pub fn of(plan: &'a Plan, variant: usize) -> Self {
        let asked = &plan.asked.quantities;
        let variant = plan.variants.get(variant);
        let named = |name: &str| asked.iter().any(|asked| asked == name);
        if asked.is_empty() {
            return Self::motion(variant);
        }
        let motion = if named(MOTION) { Self::motion(variant).motion } else { None };
        let quantities = variant.into_iter().flat_map(|variant| &variant.reference.quantities);
        Ranking { motion, ..Self::worst(quantities.filter(|quantity| named(&quantity.name))) }
    }

    /// All that answers are given for: [`Ranking::of`], and where nothing is named, the numbers of the report too.
    pub fn answered(plan: &'a Plan, variant: usize) -> Vec<Self> {
        let report = || plan.variants.get(variant).into_iter().flat_map(|variant| &variant.reference.quantities);
        let more = (plan.asked.quantities.is_empty() && report().next().is_some()).then(|| Self::worst(report()));
        std::iter::once(Self::of(plan, variant)).chain(more).collect()
    }

    /// What the reference is worth: no run is ranked below it.
    pub fn bound(&self) -> f64 {
        let errors = self.quantities.iter().filter_map(|quantity| quantity.error);
        errors.chain(self.motion).fold(0.0, f64::max)
    }

    /// The names of its quantities; none for the motion alone.
    pub fn names(&self) -> Vec<String> {
        let names: Vec<String> = self.quantities.iter().map(|quantity| quantity.name.clone()).collect();
        let motion = self.motion.filter(|_| !names.is_empty());
        names.into_iter().chain(motion.map(|_| MOTION.to_owned())).collect()
    }

    /// Quantities that are asked for, and by which nothing is ranked as the reference does not know its error.
    pub fn unknown(&self) -> &[&'a ReferenceQuantity] {
        &self.unknown
    }

    /// The unit of the errors.
    pub fn unit(&self) -> &str {
        let absolute = self.quantities.iter().find(|quantity| quantity.scale.is_none());
        absolute.map_or("-", |quantity| &quantity.unit)
    }

    /// The error of a run that reached its end, in the worst part, as it was measured.
    pub fn measured(&self, row: &Row) -> Option<f64> {
        self.worst_of(row, |error, _| error)
    }

    /// The same, but of no part below what the reference is worth in it.
    pub fn error(&self, row: &Row) -> Option<f64> {
        self.worst_of(row, f64::max)
    }

    fn worst_of(&self, row: &Row, ranked: impl Fn(f64, f64) -> f64) -> Option<f64> {
        if row.measured.status != RowStatus::Completed {
            return None;
        }
        let motion = self.motion.map(|bound| Some(ranked(row.measured.error?, bound)));
        let of = |quantity: &&ReferenceQuantity| {
            let found = row.measured.quantities.get(&quantity.name)?;
            Some(ranked(found.error?, quantity.error?))
        };
        let mut parts = motion.into_iter().chain(self.quantities.iter().map(of));
        let first = parts.next()??;
        let worst = parts.try_fold(first, |worst, part| Some(f64::max(worst, part?)))?;
        worst.is_finite().then_some(worst)
    }
}
