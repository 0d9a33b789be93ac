//! The Pareto front: runs that no other beats in both cost and error.

use super::ranking::Ranking;
use super::row::Row;

/// Two costs closer than this are the same: what a clock on a shared machine can resolve.
pub const TIE: f64 = 1.1;

/// Marks the runs of a variant that are on the front. Errors below that of the reference count as that, and of equally
/// accurate runs the cheapest is on the front. A run that is further off than the scene moves, or than the whole value
/// of a quantity, is not.
pub fn mark_front(rows: &mut [Row], variant: usize, ranking: &Ranking<'_>) {
    let own: Vec<&Row> = rows.iter().filter(|row| row.job.variant == variant).collect();
    let front = on_front(&own, ranking);
    for (row, on) in rows.iter_mut().filter(|row| row.job.variant == variant).zip(front) {
        row.pareto = on;
    }
}

/// Which runs of a variant are on the front.
pub fn on_front(rows: &[&Row], ranking: &Ranking<'_>) -> Vec<bool> {
    let ranked = |row: &&Row| {
        let error = ranking.error(row).filter(|error| *error <= 1.0)?;
        Some((error, row.cpu_seconds?))
    };
    let all: Vec<Option<(f64, f64)>> = rows.iter().map(ranked).collect();
    let beaten = |(error, cost): (f64, f64)| {
        all.iter().flatten().any(|(e, c)| *e <= error && *c <= cost && (*e < error || *c < cost))
    };
    all.iter().map(|place| place.is_some_and(|place| !beaten(place))).collect()
}

/// The cheapest of some runs with an error of at most `wanted`.
pub fn cheapest<'a>(rows: impl Iterator<Item = &'a Row>, wanted: f64, ranking: &Ranking<'_>) -> Option<(&'a Row, f64)> {
    let good = rows.filter(|row| ranking.error(row).is_some_and(|error| error <= wanted));
    good.filter_map(|row| Some((row, row.cpu_seconds?))).min_by(|a, b| a.1.total_cmp(&b.1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::schema::Method;
    use crate::integrate::registry::Family;
    use crate::plan::Variant;
    use crate::ranking::{QuantityResult, ReferenceQuantity};
    use crate::reference::ReferenceReport;
    use crate::row::{Job, RowStatus, RunResult, StepSetting};

    fn variant(error: f64) -> Variant {
        Variant { reference: ReferenceReport { error, ..ReferenceReport::default() }, ..Variant::default() }
    }

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
        let variant = variant(1e-5);
        let ranking = Ranking::motion(Some(&variant));
        mark_front(&mut rows, 0, &ranking);
        let front: Vec<&str> = rows.iter().filter(|r| r.pareto).map(|r| r.job.id.as_str()).collect();
        assert_eq!(front, ["coarse", "fine", "as good as the reference"]);
        let best = cheapest(rows.iter(), 1e-3, &ranking).expect("one");
        assert_eq!((best.0.job.id.as_str(), best.1), ("fine", 3.0));
        assert!(cheapest(rows.iter(), 1e-6, &ranking).is_none(), "nothing is ranked below the reference's error");
    }

    /// The error of a run is the worst of the set, and of no quantity below what the reference is worth in it.
    #[test]
    fn quantities_rank_by_the_worst() {
        let known = |name: &str, error: Option<f64>| ReferenceQuantity {
            name: name.to_owned(),
            value: Some(2.0),
            scale: Some(2.0),
            error,
            ..ReferenceQuantity::default()
        };
        let of = |id: &str, cost: f64, [a, b]: [f64; 2]| {
            let mut row = row(id, RowStatus::Completed, 0.5, cost);
            for (name, error) in [("a", a), ("b", b), ("c", 0.9)] {
                let result = QuantityResult { value: Some(2.0 * (1.0 + error)), error: Some(error) };
                row.measured.quantities.insert(name.to_owned(), result);
            }
            row
        };
        let mut rows =
            vec![of("cheap", 1.0, [1e-2, 1e-5]), of("worse in b", 2.0, [1e-5, 2e-2]), of("best", 3.0, [1e-9; 2])];
        let all = [known("a", Some(1e-6)), known("b", Some(1e-4)), known("c", None)];
        let ranking = Ranking::worst(all.iter());
        let errors: Vec<Option<f64>> = rows.iter().map(|row| ranking.error(row)).collect();
        assert_eq!(errors, [Some(1e-2), Some(2e-2), Some(1e-4)]);
        assert_eq!((ranking.measured(&rows[2]), ranking.bound()), (Some(1e-9), 1e-4));
        assert_eq!((ranking.names(), ranking.unknown().len()), (vec!["a".to_owned(), "b".to_owned()], 1));
        mark_front(&mut rows, 0, &ranking);
        assert_eq!(rows.iter().map(|row| row.pareto).collect::<Vec<_>>(), [true, false, true]);
        assert_eq!(all[0].error_of(2.5), Some(0.25));
        assert_eq!(Ranking::worst(all[2..].iter()).error(&rows[0]), None, "nothing is known");
    }
}
