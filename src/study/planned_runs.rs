//! Makes the runs of a study whose runs are changes of one case: `sweep` and `require`.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use super::error::StudyError;
use super::prepared_case::fingerprint_of;
use super::runner::Shard;
use super::saved_run::{SavedEnd, SavedRun};
use super::store::{Store, StudyJob, StudyPlan};
use crate::case::Problem;

/// A run whose case is a change of another.
pub trait CaseJob: StudyJob {
    /// what to do where the budget was spent
    const AGAIN: &'static str;

    /// Number of the run, from 0.
    fn run(&self) -> usize;

    /// Its changes, for people.
    fn described(&self) -> String;

    /// Checksum of its case, with the files that it names.
    fn case_digest(&self) -> &str;
}

/// Makes runs.
pub struct PlannedRuns<'a, P: StudyPlan> {
    /// what is to be done
    pub plan: &'a P,
    /// where it goes
    pub store: &'a Store<P>,
    /// the share that is made; `None`: all
    pub shard: Option<Shard>,
    /// runs at the same time
    pub threads: usize,
    /// when the budget is spent
    pub deadline: Option<Instant>,
    /// set when the user interrupts
    pub interrupt: &'a AtomicBool,
    /// called with every run before it is made: its number, the number of all, and what it is
    pub on_run: &'a (dyn Fn(usize, usize, &str) + Sync),
}

impl<P: StudyPlan<Job: CaseJob + Sync> + Sync> PlannedRuns<'_, P> {
    /// The runs of the share.
    pub(super) fn share(&self) -> impl Iterator<Item = &P::Job> {
        self.plan.jobs().iter().filter(|job| self.shard.is_none_or(|shard| shard.has(job.run())))
    }

    /// Makes runs, several at the same time. Returns why some were left out, by identifier.
    ///
    /// # Errors
    /// The first failure.
    pub(super) fn each(
        &self,
        wanted: &[&P::Job],
        make: impl Fn(&P::Job) -> Result<Option<String>, StudyError> + Sync,
    ) -> Result<BTreeMap<String, String>, StudyError> {
        let left = Mutex::new(BTreeMap::new());
        each(wanted, self.threads, |job| {
            if let Some(why) = make(job)? {
                left.lock().unwrap_or_else(PoisonError::into_inner).insert(job.id().to_owned(), why);
            }
            Ok(())
        })?;
        Ok(left.into_inner().unwrap_or_else(PoisonError::into_inner))
    }

    /// Makes one run and stores what `result` makes of its end; returns why it was left out. A case that is refused
    /// comes as the result of its refusal.
    ///
    /// # Errors
    /// An interrupt, another case than the plan's, or files that cannot be read or written.
    pub(super) fn make(
        &self,
        job: &P::Job,
        case: impl FnOnce() -> Result<Result<Problem, P::Result>, StudyError>,
        result: impl FnOnce(Result<SavedEnd, StudyError>) -> Result<Result<P::Result, f64>, StudyError>,
    ) -> Result<Option<String>, StudyError> {
        let &PlannedRuns { plan, store, deadline, interrupt, on_run, .. } = self;
        let again = P::Job::AGAIN;
        if interrupt.load(Ordering::Relaxed) {
            return Err(StudyError::Interrupted);
        }
        if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
            return Ok(Some(format!("the budget was spent before it; {again}")));
        }
        on_run(job.run() + 1, plan.jobs().len(), &job.described());
        let made = match case()? {
            Err(refused) => Ok(refused),
            Ok(problem) => {
                if fingerprint_of(&problem)?.digest() != job.case_digest() {
                    let difference = format!("a file that its case names is not what it was, with {}", job.described());
                    return Err(StudyError::OtherStudy { folder: store.plan_path(), difference });
                }
                result(SavedRun { store, job, deadline, interrupt }.make(problem))?
            }
        };
        match made {
            Ok(made) => store.keep_measured(job, &made).map(|()| None),
            Err(t) => Ok(Some(format!("the budget was spent at t = {t:.3e} s of it; {again}"))),
        }
    }
}

/// Gives each item to one of so many threads, until all are done or one fails.
///
/// # Errors
/// The first failure.
pub(super) fn each<T: Sync>(
    items: &[T],
    threads: usize,
    work: impl Fn(&T) -> Result<(), StudyError> + Sync,
) -> Result<(), StudyError> {
    let (next, failed) = (AtomicUsize::new(0), Mutex::new(None));
    let take = || {
        while let Some(item) = items.get(next.fetch_add(1, Ordering::Relaxed)) {
            if let Err(error) = work(item) {
                // The others finish theirs and take no more.
                next.store(items.len(), Ordering::Relaxed);
                failed.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
            }
        }
    };
    std::thread::scope(|scope| {
        (1..threads.min(items.len())).for_each(|_| {
            scope.spawn(take);
        });
        take();
    });
    failed.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)
}
