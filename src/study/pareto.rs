//! The Pareto front: runs that no other beats in both cost and error.

use super::row::Row;

/// Two costs closer than this are the same: what a clock on a shared machine can resolve.
pub const TIE: f64 = 1.1;

/// Marks the runs of a variant that are on the front. Errors below that of the reference count as that, and of equally
/// accurate runs the cheapest is on the front. A run that is further off than the scene moves is not.
pub fn mark_front(rows: &mut [Row], variant: usize, reference_error: f64) {
    let ranked = |row: &Row| {
        let error = row.rank_error(reference_error).filter(|error| *error <= 1.0)?;
        Some((error, row.cpu_seconds?))
    };
    let all: Vec<(f64, f64)> = rows.iter().filter(|r| r.job.variant == variant).filter_map(ranked).collect();
    for row in rows.iter_mut().filter(|r| r.job.variant == variant) {
        row.pareto = ranked(row).is_some_and(|(error, cost)| {
            !all.iter().any(|(e, c)| *e <= error && *c <= cost && (*e < error || *c < cost))
        });
    }
}

/// The cheapest of some runs with an error of at most `wanted`.
pub fn cheapest<'a>(rows: impl Iterator<Item = &'a Row>, wanted: f64, reference_error: f64) -> Option<(&'a Row, f64)> {
    let good = rows.filter(|row| row.rank_error(reference_error).is_some_and(|error| error <= wanted));
    good.filter_map(|row| Some((row, row.cpu_seconds?))).min_by(|a, b| a.1.total_cmp(&b.1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::schema::Method;
    use crate::integrate::registry::Family;
    use crate::row::{Job, RowStatus, RunResult, StepSetting};

    fn row(id: &str, status: RowStatus, error: f64, cost: f64) -> Row {
        let method = Method { name: "rk4".to_owned(), parameters: Default::default() };
        Row {
            job: Job { id: id.to_owned(), variant: 0, model: None, method, setting: StepSetting::Step(1.0) },
            family: Family::Explicit,
            measured: RunResult { status, error: Some(error), ..RunResult::default() },
            cpu_seconds: Some(cost),
            pareto: false,
        }
    }

    /// A diverged run, a dominated one, and one that is better than the reference can resolve are not on the front.
    #[test]
    fn only_undominated_completed_runs() {
        use RowStatus::{Completed, Diverged};
        let mut rows = vec![
            row("coarse", Completed, 1e-2, 1.0),
            row("dominated", Completed, 2e-2, 1.5),
            row("fine", Completed, 1e-4, 3.0),
            row("diverged", Diverged, 1e-9, 0.1),
            row("worse than standing still", Completed, 3.0, 0.01),
            row("as good as the reference", Completed, 1e-6, 5.0),
            row("better than it can tell", Completed, 1e-9, 9.0),
        ];
        mark_front(&mut rows, 0, 1e-5);
        let front: Vec<&str> = rows.iter().filter(|r| r.pareto).map(|r| r.job.id.as_str()).collect();
        assert_eq!(front, ["coarse", "fine", "as good as the reference"]);
        let best = cheapest(rows.iter(), 1e-3, 1e-5).expect("one");
        assert_eq!((best.0.job.id.as_str(), best.1), ("fine", 3.0));
        assert!(cheapest(rows.iter(), 1e-6, 1e-5).is_none(), "nothing is ranked below the reference's error");
    }
}
