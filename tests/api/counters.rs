//! The work of one short run of every method, counted: the same on every machine and for every number of threads,
//! unlike seconds. A change here is a change of cost that somebody meant to make.

use crate::common::run::{asset, changed, run, run_with};
use canopy_fem::case::Case;
use canopy_fem::drive::Status;
use canopy_fem::integrate::Counters;
use canopy_fem::integrate::registry::{Family, MethodInfo, methods};

/// Steps of the runs.
const STEPS: u64 = 20;

/// A method, its force passes, and its Newton iterations (each with one assembly, one factorisation and one solve).
type Work = (&'static str, u64, u64);

/// 20 steps of 0.5 ms of cloth-k1000, which has velocity-dependent forces and a tangent that is not symmetric.
const FINE: [Work; 21] = [
    ("explicit-euler", 21, 0),
    ("euler-cromer", 21, 0),
    ("euler-richardson", 41, 0),
    ("improved-euler", 41, 0),
    ("improved-euler-pec", 21, 0),
    ("velocity-verlet", 41, 0),
    ("beeman", 21, 0),
    ("rk4", 81, 0),
    ("dormand-prince", 121, 0),
    ("dop853", 241, 0),
    ("newmark", 41, 20),
    ("hht", 41, 20),
    ("kang", 21, 0),
    ("backward-euler", 42, 21),
    ("generalized-alpha", 41, 20),
    ("esdirk4", 201, 100),
    ("central-difference", 21, 0),
    // All springs of an even cloth are stiff, half of the elements beside triangles and weights.
    ("multirate", 101, 0),
    ("energy-momentum", 42, 21),
    // ten short steps, with the air in each
    ("xpbd", 201, 0),
    ("vbd", 21, 0),
];

/// The same cloth in 20 steps of 10 ms, where Newton has work to do.
const COARSE: [Work; 6] = [
    ("newmark", 63, 42),
    ("hht", 63, 42),
    ("backward-euler", 64, 43),
    ("generalized-alpha", 63, 42),
    ("esdirk4", 301, 200),
    ("energy-momentum", 61, 40),
];

fn counters(force_evaluations: u64, newton: u64) -> Counters {
    Counters {
        force_evaluations,
        tangent_assemblies: newton,
        factorizations: newton,
        // The cloth's air makes every matrix unsymmetric.
        lu_factorizations: newton,
        linear_solves: newton,
        newton_iterations: newton,
        cg_iterations: 0,
        sweeps: 0,
    }
}

fn check(base: &Case, expected: &[Work], methods: impl Iterator<Item = &'static MethodInfo>) {
    let mut seen = Vec::new();
    for method in methods {
        let case = changed(base, &[("time.method", method.name)]);
        let outcome = run(&case).outcome;
        assert_eq!((outcome.status, outcome.steps), (Status::Completed, STEPS), "{}", method.name);
        assert_eq!(run(&case).outcome.counters, outcome.counters, "{} does not repeat", method.name);
        assert_eq!(run_with(&case, 2).outcome.counters, outcome.counters, "{} on two threads", method.name);
        let newton = outcome.counters.newton_iterations;
        let sweeps = STEPS * case.problem().method.sweeps() as u64;
        let expected = Counters { sweeps, ..counters(outcome.counters.force_evaluations, newton) };
        assert_eq!(outcome.counters, expected, "{}", method.name);
        seen.push((method.name, outcome.counters.force_evaluations, newton));
    }
    assert_eq!(seen, expected);
}

/// The counters are those of the tables, again when repeated, and again on two threads.
#[test]
fn work_repeats_exactly() {
    let fine = asset("cloth-k1000", &[("time.end", "0.01"), ("time.step", "5e-4"), ("solver.newton.strategy", "full")]);
    check(&fine, &FINE, methods().iter());
    let coarse = changed(&fine, &[("time.end", "0.2"), ("time.step", "1e-2")]);
    check(&coarse, &COARSE, methods().iter().filter(|m| m.family == Family::Implicit));
}

/// What the registry promises of explicit methods is what they do: so many force passes a step, and one at the start.
#[test]
fn explicit_methods_evaluate_as_often_as_they_say() {
    let rows = [(0, "oscillator"), (1, "oscillator-damped")];
    for (velocity_dependent, stem) in rows {
        let base = asset(stem, &[("time.end", "0.2")]);
        for method in methods().iter().filter(|m| m.family != Family::Implicit) {
            let counters = run(&changed(&base, &[("time.method", method.name)])).outcome.counters;
            // The only spring is stiff: six short steps, where the registry has one for a few stiff springs, and a pass
            // more with a dashpot.
            // `xpbd` has the works of a dashpot from a pass in each of ten short steps.
            let more = match method.name {
                "multirate" => 5 + velocity_dependent as u64,
                "xpbd" => 9 * velocity_dependent as u64,
                _ => 0,
            };
            let expected = 1 + STEPS * (u64::from(method.evaluations[velocity_dependent]) + more);
            assert_eq!(counters.force_evaluations, expected, "{} on {stem}", method.name);
            assert_eq!(counters.factorizations, 0, "{} on {stem}", method.name);
        }
    }
}

/// A name, a shipped case, and what is changed in it.
type ShippedCase = (&'static str, &'static str, &'static [(&'static str, &'static str)]);

/// Six shipped cases, cut short, each with other work.
const SHIPPED: [ShippedCase; 6] = [
    ("explicit, blocks of steps", "cloth-k1000", &[("time.end", "0.1")]),
    (
        "implicit, a factor that is kept",
        "cloth-k100000",
        &[("time.method", "newmark"), ("time.step", "1e-3"), ("time.end", "0.05")],
    ),
    ("implicit, every matrix exact", "parachute-50ms", &[("solver.newton.strategy", "full"), ("time.end", "0.02")]),
    ("a canopy that falls", "parachute/c9-drop", &[("time.end", "0.2")]),
    (
        "steps by a tolerance",
        "spring-pendulum",
        &[("time", r#"{"end": 2, "method": "dormand-prince", "tolerance": {"relative": 1e-6, "absolute": 1e-9}}"#)],
    ),
    ("conjugate gradients", "big/annulus-10k", &[("solver.linear", "cg"), ("time.end", "0.003")]),
];

/// Where the work of these is written down, one row a case.
const SHIPPED_WORK: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/counted-work.txt");

/// The numbers in the rows of such a table.
fn numbers(table: &str) -> Vec<Vec<u64>> {
    table.lines().map(|row| row.split_whitespace().filter_map(|word| word.parse().ok()).collect()).collect()
}

/// The work of shipped cases is that of the file, but for 2 %, since the last digits of a factorisation differ from
/// processor to processor. After a change that was meant, `COUNTED_WORK_WRITE=1 cargo test --release --test api
/// counted` writes it anew, and the commit shows what the change costs or saves.
#[test]
fn counted_work_of_shipped_cases_is_as_written_down() {
    let mut table = format!(
        "{:34}{:>8}{:>8}{:>12}{:>9}{:>8}{:>8}{:>8}\n",
        "case", "steps", "passes", "assemblies", "factors", "solves", "newton", "cg"
    );
    for (name, stem, sets) in SHIPPED {
        let outcome = run(&asset(stem, sets)).outcome;
        assert_eq!(outcome.status, Status::Completed, "{name}");
        let Counters { force_evaluations, tangent_assemblies, factorizations, .. } = outcome.counters;
        let Counters { linear_solves, newton_iterations, cg_iterations, .. } = outcome.counters;
        table += &format!("{name:34}{:>8}{force_evaluations:>8}{tangent_assemblies:>12}", outcome.steps);
        table += &format!("{factorizations:>9}{linear_solves:>8}{newton_iterations:>8}{cg_iterations:>8}\n");
    }
    if std::env::var_os("COUNTED_WORK_WRITE").is_some() {
        std::fs::write(SHIPPED_WORK, &table).expect("the folder takes files");
    }
    let written = std::fs::read_to_string(SHIPPED_WORK).expect("tests/data/counted-work.txt");
    let (now, then) = (numbers(&table), numbers(&written));
    let close = now.len() == then.len()
        && now.iter().zip(&then).all(|(now, then)| {
            now.len() == then.len() && now.iter().zip(then).all(|(now, then)| now.abs_diff(*then) <= then / 50)
        });
    assert!(close && now.len() == SHIPPED.len() + 1, "the work was\n{written}\nand is\n{table}");
}
