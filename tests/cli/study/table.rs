//! What a study leaves, without what a clock decides.

use std::path::Path;

use canopy_fem::study::row::{Row, RunResult};
use canopy_fem::study::store::Store;
use canopy_fem::study::{Study, rows_of};

/// The study in a folder.
pub fn study(out: &Path) -> Study {
    let store = Store::in_folder(out);
    let plan = store.plan().expect("readable").expect("a plan");
    let rows = rows_of(&plan, &store, &Default::default()).expect("readable");
    Study { plan, rows }
}

/// Rows without seconds and what follows from them, in the bits of their numbers.
pub fn counted(rows: &[Row]) -> Vec<String> {
    let bits = |x: Option<f64>| x.map(f64::to_bits);
    let line = |row: &Row| {
        let RunResult {
            status,
            error,
            error_max,
            quantities,
            energy_error,
            steps,
            rejected_steps,
            counters,
            note,
            repeats,
            ..
        } = &row.measured;
        let errors = [*error, *error_max, *energy_error].map(bits);
        let repeats = repeats.len();
        let quantities: Vec<_> = quantities.iter().map(|(name, of)| (name, [of.value, of.error].map(bits))).collect();
        format!(
            "{} {status:?} {errors:?} {quantities:?} {steps} {rejected_steps} {counters:?} {note} {repeats}",
            row.job.id
        )
    };
    rows.iter().map(line).collect()
}
