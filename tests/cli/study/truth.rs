//! Errors of a study against closed forms, and references against what they say of themselves.

use std::sync::atomic::AtomicBool;

use canopy_fem::case::Case;
use canopy_fem::simulation::{FollowSpec, follow};
use canopy_fem::study::StudyError;
use canopy_fem::study::prepared_case::PreparedCase;
use canopy_fem::study::reference::{ReferenceBuilder, ReferenceFailure};
use canopy_fem::study::row::{RowStatus, StepSetting};
use serde_json::json;

use super::table::study;
use crate::bench::Bench;
use crate::common::run::{asset, case_of, changed};

/// A soft oscillator that swings along x, w = 2 pi, and a stiff one at rest, w = 1e5: explicit steps are thirty
/// thousand a period.
fn two_oscillators() -> Case {
    let soft = (2.0 * std::f64::consts::PI).powi(2);
    let case = json!({
        "name": "two",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0,0,0],[10,0,0],[0,5,0],[10,5,0]], "springs": [[0,1],[2,3]], "triangles": []}},
            "mass": {"nodal": 1.0},
            "springs": [{"on": {"ids": [0]}, "stiffness": soft}, {"on": {"ids": [1]}, "stiffness": 1e10}],
            "supports": [{"on": {"ids": [0, 2]}, "fix": "xyz"}],
            "initial": {"displacement": [[0,0,0],[1,0,0],[0,0,0],[0,0,0]]}
        }},
        "time": {"end": 1.0, "method": "newmark", "step": 0.01}
    });
    case_of(&case, &[])
}

/// The study's `error` and `error_max` of every completed fixed-step run equal those computed here from the library's
/// own runs and x = 10 + 2 cos(w t).
#[test]
fn errors_are_distances_from_the_closed_form() {
    let folder = Bench::new();
    let path = format!("{}/assets/cases/oscillator.json", env!("CARGO_MANIFEST_DIR"));
    let methods = "velocity-verlet,newmark,rk4,backward-euler";
    let flags = [
        "--methods",
        methods,
        "--steps",
        "0.02,0.005",
        "--repeat",
        "1",
        "--out",
        "o",
        "--end",
        "10",
        "--set",
        "output.frames.every=0.5",
    ];
    let ended = folder.run(&[&["tradeoff", path.as_str()], &flags[..]].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let found = study(&folder.path("o"));
    assert_eq!(found.rows.len(), 8);
    let case = asset("oscillator", &[("time.end", "10"), ("output.frames.every", "0.5")]);
    for row in &found.rows {
        let StepSetting::Step(h) = row.job.setting else { panic!("only steps were asked for") };
        let case = changed(&case, &[("time.method", &row.job.method.name), ("time.step", &format!("{h:e}"))]);
        let [mut off, mut moved] = [[0.0_f64; 2]; 2];
        let mut start = None;
        follow(case.problem(), FollowSpec::default(), |seen| {
            let x = seen.positions[1][0];
            let x0 = *start.get_or_insert(x);
            let frame = (seen.t / 0.5).round();
            if frame > 0.0 && (seen.t - 0.5 * frame).abs() < 1e-9 {
                let exact = 10.0 + (x0 - 10.0) * (frequency() * seen.t).cos();
                for (sums, d) in [(&mut off, x - exact), (&mut moved, exact - x0)] {
                    *sums = [sums[0] + d * d, sums[1].max(d.abs())];
                }
            }
        })
        .expect("runs");
        let expected = [(off[0] / moved[0]).sqrt(), off[1] / moved[1]];
        let told = [row.measured.error, row.measured.error_max].map(|e| e.expect("completed"));
        for (told, expected) in told.into_iter().zip(expected) {
            let slack = 1e-6 * expected + 3.0 * found.plan.variants[0].reference.error;
            assert!((told - expected).abs() <= slack, "{}: {told:e}, by hand {expected:e}", row.job.id);
        }
    }
}

/// [rad/s] of assets/cases/oscillator.json
fn frequency() -> f64 {
    let case = asset("oscillator", &[]);
    let number = |pointer: &str| {
        let value = case.problem().case_json.pointer(pointer).unwrap_or_else(|| panic!("{pointer} is in the case"));
        value.as_f64().or_else(|| value.as_array().and_then(|list| list.last()?.as_f64())).expect("a number")
    };
    (number("/system/network/springs/0/stiffness") / number("/system/network/mass/nodal")).sqrt()
}

/// Explicit pairs where they are affordable, extrapolated Newmark where they are not: both are as close to the closed
/// form as they say.
#[test]
fn references_are_worth_what_they_say() {
    let case = two_oscillators();
    let stop = AtomicBool::new(false);
    let mut ways = Vec::new();
    for allowance in [300.0, 0.04] {
        let prepared = PreparedCase::of(case.problem().clone(), 1).expect("good");
        let builder = ReferenceBuilder { prepared: &prepared, allowance, stop: &stop, tell: &|_| {} };
        let made = builder.make().expect("a reference");
        let (nodes, motion) = (made.frames.nodes, made.account.motion);
        let squares: f64 = made
            .frames
            .positions
            .chunks(nodes)
            .enumerate()
            .map(|(k, frame)| {
                let t = (k + 1) as f64 * prepared.every;
                (frame[1][0] - 10.0 - (std::f64::consts::TAU * t).cos()).powi(2)
            })
            .sum();
        let off = (squares / motion.squares).sqrt();
        assert_eq!(motion.frames, 50);
        assert!(made.account.error < 1e-6, "{}", made.account.error);
        // The stated error is that of the coarser solution; the finer one is the reference.
        assert!(off <= 2.0 * made.account.error + 1e-12, "off by {off:e}, told {:e}", made.account.error);
        ways.push(made.account.how);
    }
    assert!(ways[0].starts_with("dop853") && ways[1].starts_with("newmark"), "{ways:?}");
}

/// Steps at the limit of stability would be affordable, but those that accuracy asks for are far shorter: the pairs are
/// given up while they are under way.
#[test]
fn a_reference_keeps_within_its_allowance() {
    let case = asset("oscillator", &[("system.network.springs.0.stiffness", "1e7")]);
    let stop = AtomicBool::new(false);
    let prepared = PreparedCase::of(case.problem().clone(), 1).expect("good");
    let told = std::cell::RefCell::new(Vec::new());
    let tell = |what: &str| told.borrow_mut().push(what.to_owned());
    match (ReferenceBuilder { prepared: &prepared, allowance: 0.05, stop: &stop, tell: &tell }).make() {
        Err(StudyError::NoReference { explicit: ReferenceFailure::TooLong { seconds, allowance }, .. }) => {
            assert!(seconds > 4.0 * allowance, "{seconds}");
        }
        Ok(made) => assert!(made.account.how.starts_with("newmark"), "{}", made.account.how),
        Err(other) => panic!("{other}"),
    }
    let of_pairs = told.borrow().iter().filter(|what| !what.starts_with("newmark")).count();
    assert_eq!(of_pairs, 1, "{told:?}");
}

/// A run above its limit diverges, a method that does not fit and a step beyond the end are refused: both are rows with
/// a reason, and none is on the front.
#[test]
fn failures_are_rows() {
    let folder = Bench::new();
    let path = format!("{}/assets/cases/pendulum.json", env!("CARGO_MANIFEST_DIR"));
    let flags = ["--methods", "kang,explicit-euler,rk4", "--steps", "100,2,0.001", "--repeat", "1", "--out", "p"];
    let ended = folder.run(&[&["tradeoff", path.as_str()], &flags[..]].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let found = study(&folder.path("p"));
    let status = |method: &str, h: f64| {
        let row = found
            .rows
            .iter()
            .find(|r| r.job.method.name == method && r.job.setting == StepSetting::Step(h))
            .expect("a row");
        assert!(
            row.measured.status == RowStatus::Completed || (!row.pareto && row.measured.note.len() > 20),
            "{row:?}"
        );
        row.measured.status
    };
    assert_eq!(found.rows.len(), 9);
    for method in ["kang", "explicit-euler", "rk4"] {
        assert_eq!(status(method, 100.0), RowStatus::Refused, "a step longer than the run, {method}");
    }
    assert_eq!((status("kang", 2.0), status("kang", 0.001)), (RowStatus::Refused, RowStatus::Refused));
    assert_eq!(
        (status("explicit-euler", 2.0), status("explicit-euler", 0.001)),
        (RowStatus::Diverged, RowStatus::Completed)
    );
    assert!(found.rows.iter().any(|row| row.pareto));
    assert!(ended.stdout.contains("1 diverged") || ended.stdout.contains("2 diverged"), "{}", ended.stdout);
}
