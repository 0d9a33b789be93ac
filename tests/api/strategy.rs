//! A factor that is kept gives the trajectory of the exact tangent, to the tolerance of a step, for less work.

use crate::common::run::{Run, apart, asset, case_of, changed, run, run_with};
use canopy_fem::case::Case;
use canopy_fem::drive::Status;
use canopy_fem::integrate::registry::{Family, methods};

const DEAD: &str = r#"[{"on": "all", "pressure": 60.0, "kind": "dead", "direction": [0, 0, 1]}]"#;
const FOLLOWER: &str = r#"[{"on": "all", "pressure": 60.0, "kind": "follower"}]"#;

/// The 703-node cloth with air; symmetric and slack; under a pressure that follows, with dashpots along the springs.
fn scenes() -> [(&'static str, Case); 3] {
    let base = asset("cloth-k1000", &[("time.end", "0.1"), ("output", "{}")]);
    let slack = [
        ("system.network.aero", "null"),
        ("system.network.loads", DEAD),
        ("system.network.springs.0.slack", "tension-only"),
    ];
    let follower = [
        ("system.network.aero", "null"),
        ("system.network.loads", FOLLOWER),
        ("system.network.springs.0.stiffness", "1e5"),
        ("system.network.springs.0.dashpot", r#"{"axial": {"coefficient": 0.5}}"#),
    ];
    [("air", base.clone()), ("slack", changed(&base, &slack)), ("follower", changed(&base, &follower))]
}

fn with(case: &Case, method: &str, step: &str, strategy: &str) -> Run {
    let found =
        run(&changed(case, &[("time.method", method), ("time.step", step), ("solver.newton.strategy", strategy)]));
    let outcome = &found.outcome;
    assert_eq!(outcome.status, Status::Completed, "{method} at {step}, {strategy}: {:?}", outcome.failure);
    found
}

/// The tolerance on a step's residual is 1e-8 of the forces; what is left of a hundred steps stays below 1e-6 of the
/// motion.
#[test]
#[ignore = "long"]
fn every_strategy_gives_the_same_trajectory() {
    for (scene, case) in scenes() {
        for method in methods().iter().filter(|m| m.family == Family::Implicit) {
            for step in ["1e-3", "1e-2"] {
                let full = with(&case, method.name, step, "full");
                for strategy in ["modified", "quasi", "auto"] {
                    let found = with(&case, method.name, step, strategy);
                    let off = apart(&full, &found);
                    assert!(off < 1e-6, "{} at {step} on {scene}, {strategy}: {off:e} apart", method.name);
                    let [few, many] = [&found, &full].map(|run| run.outcome.counters.factorizations);
                    assert!(
                        2 * few < many,
                        "{} at {step} on {scene}, {strategy}: {few} factorisations, {many} in full",
                        method.name
                    );
                }
            }
        }
    }
}

/// A sheet of 16 nodes keeps a factor in many of its steps, with dashpots along the springs, which need an LU else,
/// too.
#[test]
fn small_nets_keep_a_factor() {
    let sheet = |dashpot: &str| {
        let case = serde_json::json!({
            "name": "sheet",
            "system": {"network": {
                "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": 3, "rows": 3}},
                "mass": {"areal_density": 0.2},
                "springs": [{"on": "all", "stiffness": 1e3, "dashpot": {dashpot: {"coefficient": 0.01}}}],
                "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
                "gravity": [0, 0, -9.81]
            }},
            "time": {"end": 0.1, "method": "newmark", "step": 1e-3}
        });
        case_of(&case, &[])
    };
    for dashpot in ["relative", "axial"] {
        let [auto, full] = ["auto", "full"].map(|strategy| with(&sheet(dashpot), "newmark", "1e-3", strategy));
        let [few, many] = [&auto, &full].map(|run| run.outcome.counters.factorizations);
        assert!(3 * few < many, "{dashpot}: {few} factorisations, {many} in full");
        let off = apart(&full, &auto);
        assert!(off < 1e-6, "{dashpot}: {off:e} apart");
    }
}

/// What `auto` does is decided by counted work: a pendulum and a net of two or three nodes are solved in full, to the
/// bit.
#[test]
fn small_scenes_keep_no_factor() {
    for stem in ["pendulum", "spring-pendulum", "oscillator-damped"] {
        let case = asset(stem, &[("time.end", "1"), ("output", "{}")]);
        let [auto, full] = ["auto", "full"].map(|strategy| with(&case, "newmark", "1e-2", strategy));
        assert_eq!(auto.outcome.counters, full.outcome.counters, "{stem}");
        assert!(auto.state == full.state, "{stem}");
        assert_eq!(auto.outcome.linear, full.outcome.linear, "{stem}: the solver that is told");
    }
}

/// A step that no kept factor leads through is made with the exact tangent: here a canopy is thrown far beyond its
/// shape in one step.
#[test]
fn where_a_kept_factor_fails_the_exact_one_takes_over() {
    let case =
        asset("cloth-k100", &[("time.end", "1"), ("output", "{}"), ("system.network.springs.0.slack", "tension-only")]);
    for strategy in ["modified", "quasi", "auto"] {
        let found = with(&case, "backward-euler", "0.5", strategy);
        let full = with(&case, "backward-euler", "0.5", "full");
        let off = apart(&full, &found);
        assert!(off < 1e-5, "{strategy}: {off:e} apart");
    }
}

/// Work repeats exactly, on any machine and with any number of threads; this cloth is so stiff that factors are made
/// and conjugate gradients take their turn only where a matrix does not serve for long.
#[test]
fn the_work_of_a_kept_factor() {
    let case = asset("cloth-k1000", &[("time.end", "0.1"), ("output", "{}")]);
    let stiff = ("system.network.springs.0.stiffness", "1e5");
    let case = changed(&case, &[("time.method", "newmark"), ("time.step", "1e-3"), stiff]);
    let [one, two] = [1, 2].map(|threads| run_with(&case, threads));
    assert!(one.state == two.state && one.outcome.counters == two.outcome.counters);
    let counters = one.outcome.counters;
    assert_eq!(
        [counters.force_evaluations, counters.factorizations, counters.linear_solves, counters.newton_iterations],
        [364, 6, 240, 240],
        "{counters:?}"
    );
}
