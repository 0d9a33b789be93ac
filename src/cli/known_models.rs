//! What `check` says of the models of cloth: the error of the cheaper one where a study has measured it, else how to
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

/// What is known of the models that a case's cloth can have.
pub(super) struct KnownModels {
    /// whether the cloth can be both a net and membranes
    comparable: bool,
    /// the folder where results of the case are looked for
    pub folder: PathBuf,
    /// what a study there has found
    pub answers: Vec<ModelAnswer>,
}

impl KnownModels {
    /// Also splits the case into the data of a run and its source.
    pub(super) fn of(case: Case) -> (Self, Problem, Source) {
        let comparable = case.has_sheets();
        let folder = PathBuf::from("out").join(file_stem(&case.problem().name));
        let answers = if comparable { measured(&case, &folder).unwrap_or_default() } else { Vec::new() };
        let (problem, source) = case.split();
        (KnownModels { comparable, folder, answers }, problem, source)
    }

    /// A line for each model.
    pub(super) fn describe(&self, case: &Path) -> String {
        if self.comparable && self.answers.is_empty() {
            let command = format!("canopy-fem tradeoff {} --models net,membrane", case.display());
            return format!("  models          {command} measures what a net of springs costs in accuracy\n");
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
