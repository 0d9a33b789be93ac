//! Hostile cases, every method: each ends correct, or with a documented status and a true sentence; never in a panic, a
//! hang, or a good status with nonsense.
//!
//! To add a case, write one line:
//! * a scene with numbers changed: `hostile("what it is", scene(), Must::…, &[("key.of.the.case", "value")])` in
//!   `table` (stiffness, mass, time, wind) or `states` (shapes, slack, loads, damping, denormals); every method runs
//!   it. A scene it needs is a function in `scenes`;
//! * a mesh file: a line of `files` in `meshes`; the fuzzers' oracle judges it too;
//! * a case whose answer is known: a test in `exact`;
//! * what only a program that uses the library can ask for: a test in `library`.
//!
//! What must hold for every end is in `verdict`. Every fifth line of the table also runs through the program
//! (`program`): exit status, words and summary must say the same. With EXTREMES_SHOW in the environment (and
//! `--nocapture`) every end is printed as a user would read it. Random cases are in `properties`, what fuzzers
//! found in `found`.

mod exact;
mod library;
mod membranes;
mod meshes;
mod program;
mod scenes;
mod states;
mod table;
pub mod verdict;

use canopy_fem::integrate::registry::methods;
use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use table::Hostile;
use verdict::{Kind, attempt, judge};

/// Runs every case with every method on two threads, and names all that do not hold.
fn all_hold(cases: &[Hostile]) -> BTreeMap<Kind, usize> {
    let jobs: Vec<_> = cases.iter().flat_map(|case| methods().iter().map(move |m| (case, m))).collect();
    let (next, found) = (AtomicUsize::new(0), Mutex::new((BTreeMap::new(), Vec::new())));
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some((case, method)) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let end = attempt(&case.json, &case.sets_for(method.name));
                    let judged = judge(&end).and_then(|kind| case.must.hold(kind, method, &end).map(|()| kind));
                    let mut found = found.lock().expect("no panic while it is held");
                    match judged {
                        Ok(kind) => {
                            if std::env::var_os("EXTREMES_SHOW").is_some() {
                                println!("{} | {} | {kind:?} | {}", case.name, method.name, end.words());
                            }
                            *found.0.entry(kind).or_default() += 1;
                        }
                        Err(_) if table::KNOWN.iter().any(|k| (k.0, k.1) == (&*case.name, method.name)) => {}
                        Err(why) => found.1.push(format!("{} with {}: {why}", case.name, method.name)),
                    }
                }
            });
        }
    });
    let (kinds, mut wrong) = found.into_inner().expect("no panic while it was held");
    wrong.sort();
    assert!(wrong.is_empty(), "{} of {} runs:\n{}", wrong.len(), jobs.len(), wrong.join("\n"));
    println!("{} runs: {kinds:?}", jobs.len());
    kinds
}

#[test]
fn every_hostile_case_ends_well_with_every_method() {
    let kinds = all_hold(&table::cases());
    // A table that ends in one way only would prove little.
    for kind in [Kind::Completed, Kind::Diverged, Kind::NotConverged, Kind::Refused] {
        assert!(kinds.get(&kind).is_some_and(|&n| n >= 10), "{kind:?}: {kinds:?}");
    }
}

#[test]
fn every_corner_of_stiffness_step_and_wind_ends_well_with_every_method() {
    all_hold(&table::corners());
}
