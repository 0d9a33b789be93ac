//! What `check` says of models, cloth as a net or scaled masses: their error where a study has measured it, else how to
//! measure it.

use crate::case::{Case, Problem, Source};
use crate::output::sanitize::file_stem;
use crate::study::plan::Plan;
use crate::study::prepared_case::fingerprint_of;
use crate::study::recommendations::{ModelAnswer, Recommendations};
use crate::study::rows_of;
use crate::study::store::Store;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What is known of the models that a case can have.
pub(super) struct KnownModels {
    /// flags of a study that compares them, and what it measures; `None` where there is one model only
    comparison: Option<[&'static str; 2]>,
    /// the folder where results of the case are looked for
    pub folder: PathBuf,
    /// what a study there has found
    pub answers: Vec<ModelAnswer>,
}

impl KnownModels {
    /// Also splits the case into the data of a run and its source.
    pub(super) fn of(case: Case) -> (Self, Problem, Source) {
        let comparison = if case.has_scaled_masses() {
            Some(["", "what the added mass costs in accuracy"])
        } else {
            case.has_sheets().then_some([" --models net,membrane", "what a net of springs costs in accuracy"])
        };
        let folder = PathBuf::from("out").join(file_stem(&case.problem().name));
        let answers = if comparison.is_some() { measured(&case, &folder).unwrap_or_default() } else { Vec::new() };
        let (problem, source) = case.split();
        (KnownModels { comparison, folder, answers }, problem, source)
    }

    /// A line for each model.
    pub(super) fn describe(&self, case: &Path) -> String {
        if let Some([flags, what]) = self.comparison.filter(|_| self.answers.is_empty()) {
            return format!("  models          canopy-fem tradeoff {}{flags} measures {what}\n", case.display());
        }
        let line = |answer: &ModelAnswer| {
            format!("  models          {} (measured in {})\n", answer.sentence, self.folder.display())
        };
        self.answers.iter().map(line).collect()
    }
}

/// What a study in a folder has found, if it is one of the same scene. One that cannot be read is none.
fn measured(case: &Case, folder: &Path) -> Option<Vec<ModelAnswer>> {
    let store = Store::<Plan>::in_folder(folder);
    let plan = store.plan().ok()??;
    let now = fingerprint_of(case.problem()).ok()?;
    plan.variants.first().filter(|variant| variant.fingerprint.same_scene(&now))?;
    let rows = rows_of(&plan, &store, &BTreeMap::new()).ok()?;
    Some(Recommendations::of(&plan, &rows).ok()?.models)
}
