//! Divergence is found from physics within a few steps, said with numbers, and the advice that comes with it works.

use crate::common::run::{asset, case_of, changed, follow};
use canopy_fem::case::Case;
use canopy_fem::drive::{Failure, Outcome, Status};
use canopy_fem::integrate::registry::methods;
use canopy_fem::simulation::{FollowSpec, follow as follow_with};
use serde_json::{Value, json};

/// Methods that make energy in undamped oscillations whatever the step.
const GROWING: [&str; 4] = ["explicit-euler", "euler-richardson", "improved-euler", "improved-euler-pec"];
const IMPLICIT: [&str; 6] = ["newmark", "hht", "generalized-alpha", "backward-euler", "esdirk4", "energy-momentum"];

fn of(network: Value) -> Case {
    case_of(
        &json!({"name": "x", "system": {"network": network}, "time": {"end": 1.0, "method": "newmark", "step": 0.01}}),
        &[],
    )
}

fn rectangle() -> Value {
    json!({"rectangle": {"width": 1.0, "height": 1.0, "columns": 4, "rows": 4, "pattern": "regular"}})
}

/// A hanging net, stiffest oscillation 182 rad/s.
fn net() -> Case {
    of(json!({
        "mesh": rectangle(), "mass": {"areal_density": 0.5}, "springs": [{"on": "all", "stiffness": 100.0}],
        "supports": [{"on": {"box": [[-9, 0.99, -9], [9, 9, 9]]}, "fix": "xyz"}], "gravity": [0, 0, -9.81]
    }))
}

/// The net held around, in wind, with dashpots.
fn sail() -> Case {
    of(json!({
        "mesh": rectangle(), "mass": {"areal_density": 0.5},
        "springs": [{"on": "all", "stiffness": 100.0, "dashpot": {"axial": {"time": 0.001}}}],
        "supports": [{"on": "boundary", "fix": "xyz"}],
        "aero": {"wind": [0, 0, 10.0], "law": {"pressure_coefficient": {"cp": 1.2, "air_density": 1.225}}}
    }))
}

/// A loose square that is thrown while it is stretched: nothing comes in from outside.
fn thrown() -> Case {
    of(json!({
        "mesh": {"explicit": {
            "nodes": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "triangles": [[0, 1, 2], [0, 2, 3]]
        }},
        "mass": {"nodal": [0.1, 0.2, 0.1, 0.2]},
        "springs": [{"on": "all", "stiffness": 300.0, "rest_scale": 0.98}],
        "initial": {"velocity": [[0, 0, 1], [0.1, 0, 1], [0, 0, 1], [0, 0.2, 1]]}
    }))
}

/// The net with a heavy damping that is stiffer than its springs.
fn viscous() -> Case {
    changed(&net(), &[("system.network.damping", r#"{"rayleigh": {"mass": 400.0, "stiffness": 0.0}}"#)])
}

/// Scenes and what velocity Verlet's step may be at most [s].
fn scenes() -> [(&'static str, Case, f64); 4] {
    [("net", net(), 1.1e-2), ("sail", sail(), 9.0e-3), ("thrown", thrown(), 2.1e-2), ("viscous", viscous(), 4.3e-3)]
}

fn with(case: &Case, method: &str, h: f64, end: f64) -> Case {
    let [h, end] = [h, end].map(|t| format!("{t:e}"));
    changed(case, &[("time.method", method), ("time.step", &h), ("time.end", &end)])
}

/// Positions at the start and after every step.
fn trace(case: &Case) -> (Vec<Vec<[f64; 3]>>, Outcome) {
    let mut trace = Vec::new();
    let outcome = follow(case, |seen| trace.push(seen.positions.to_vec()));
    (trace, outcome)
}

fn apart(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// A report has all that a person needs to look further.
fn is_complete(failure: &Failure, what: &str) {
    assert!(failure.time > 0.0 && failure.step > 0, "{what}: {failure:?}");
    assert!(failure.node.is_some() && failure.spring.is_some(), "{what}: {failure:?}");
    assert!(failure.term.is_some() && failure.grew.is_some(), "{what}: {failure:?}");
    for words in [&failure.cause, &failure.advice] {
        assert!(words.contains(|c: char| c.is_ascii_digit()), "{what}: no number in {words}");
        assert!(!words.contains("NaN") && !words.contains("inf "), "{what}: {words}");
    }
}

/// What an advice offers: a method, a step, or both together.
fn offers(advice: &str) -> Vec<(Option<&str>, Option<f64>)> {
    fn after<'a>(part: &'a str, text: &str) -> Option<&'a str> {
        part.split_once(text).and_then(|(_, rest)| rest.split(' ').next())
    }
    let part = |part| {
        (
            after(part, "time.method=").map(|method| method.trim_end_matches(',')),
            after(part, "step of ").map(|h| h.parse().expect("a number")),
        )
    };
    let offers: Vec<_> = advice.split(", or ").map(part).filter(|o| *o != (None, None)).collect();
    assert!(!offers.is_empty(), "{advice} offers nothing");
    offers
}

/// Does what the advice says, one after the other, and sees the run through.
fn follow_advice(case: &Case, failure: &Failure) -> Result<(), String> {
    let time = &case.problem().time;
    for (method, step) in offers(&failure.advice) {
        let method = method.unwrap_or(case.problem().method.info.name);
        let h = step.unwrap_or(time.step.fixed().expect("fixed steps"));
        let outcome = follow(&with(case, method, h, time.end), |_| {});
        if outcome.status != Status::Completed || outcome.energy_made > 1.0 {
            let Outcome { status, energy_made, failure: again, .. } = outcome;
            return Err(format!("{}: {method}, {h} s: {status:?}, made {energy_made}, {again:?}", failure.advice));
        }
    }
    Ok(())
}

/// Steps beyond the limit, from a hair to a lot: found at most six steps after the picture is wrong by all its motion,
/// with no node ten sizes away, and mended by following the advice. A run that gets through is right, or says that it
/// is not.
#[test]
fn explicit_steps_beyond_the_limit_are_found_and_the_advice_works() {
    let (mut found, mut wrong) = (0, Vec::new());
    for (name, case, limit) in scenes() {
        for method in GROWING.into_iter().chain(["euler-cromer", "velocity-verlet", "rk4"]) {
            for over in [1.01, 1.1, 2.0, 10.0] {
                let what = format!("{name}, {method}, {over} x");
                let h = over * limit;
                let run = with(&case, method, h, 80.0 * h);
                let (shown, outcome) = trace(&run);
                let fine = 40 * (1 + over as usize);
                let (good, _) = trace(&with(&case, "rk4", h / fine as f64, shown.len() as f64 * h));
                let off = shown.iter().zip(good.iter().step_by(fine)).scan(0.0_f64, |moved, (x, good)| {
                    *moved = moved.max(apart(good, &shown[0]));
                    Some(apart(x, good) > *moved && apart(x, good) > 1e-9)
                });
                let first_wrong = off.skip(2).position(|off| off).map(|i| i as u64 + 2);
                if let Some(failure) = &outcome.failure {
                    found += 1;
                    assert_eq!(outcome.status, Status::Diverged, "{what}: {failure:?}");
                    is_complete(failure, &what);
                    let first_wrong = first_wrong.unwrap_or(failure.step);
                    if failure.step > first_wrong + 6 {
                        wrong.push(format!("{what}: wrong at {first_wrong}, found at {}", failure.step));
                    }
                    if shown.iter().any(|x| apart(x, &shown[0]) > 10.0) {
                        wrong.push(format!("{what}: a node ten sizes away was shown as good"));
                    }
                    wrong.extend(follow_advice(&run, failure).err().map(|why| format!("{what}: {why}")));
                } else if outcome.doubt.is_none() && outcome.energy_made <= 0.1 && first_wrong.is_some() {
                    wrong.push(format!("{what}: silently wrong at step {first_wrong:?}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(found > 70, "{found} of 112 were found");
}

/// Explicit Euler's slow spiral: a warning with the growth that its spectrum predicts, long before the stop.
#[test]
fn predicted_growth_warns_before_it_stops() {
    // x'' = -w^2 x with w = 10 rad/s.
    let case = of(json!({
        "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0]], "springs": [[0, 1]]}},
        "mass": {"nodal": 1.0}, "springs": [{"on": "all", "stiffness": 100.0}],
        "supports": [{"on": {"ids": [0]}, "fix": "xyz"}, {"on": {"ids": [1]}, "fix": "yz"}],
        "initial": {"displacement": [[0, 0, 0], [0.1, 0, 0]]}
    }));
    let wh: f64 = 0.1;
    let (_, ended) = trace(&with(&case, "explicit-euler", wh / 10.0, 100.0));
    let failure = ended.failure.expect("it must grow");
    // Energy grows by 1 + (wh)^2 a step: tenfold of the start's is made after ln(11)/ln(1.01) = 241 steps.
    assert!((236..246).contains(&failure.step), "{failure:?}");
    let growth = failure.growth.expect("a number");
    assert!((growth - 1.0 - wh * wh).abs() < 0.02, "{growth}");
    let doubt = ended.doubt.expect("a warning first");
    assert!(doubt.contains("(step 10)"), "ten percent after ln(1.1)/ln(1.01) = 9.6 steps: {doubt}");
    assert!(doubt.contains("grows by 1 % a step"), "{doubt}");
    follow_advice(&with(&case, "explicit-euler", wh / 10.0, 10.0), &failure).expect("it works");
    let short = follow(&with(&case, "explicit-euler", wh / 10.0, 1.0), |_| {});
    assert_eq!(short.status, Status::Completed);
    assert!((1.6..1.8).contains(&short.energy_made), "1.01^100 - 1 = 1.70: {}", short.energy_made);
}

/// Steps far beyond a period with methods that no step makes unstable on a linear scene.
#[test]
fn energy_made_in_long_steps_is_found_or_doubted() {
    let (mut found, mut wrong) = (0, Vec::new());
    for (name, case, limit) in scenes() {
        for method in IMPLICIT.into_iter().chain(["kang"]) {
            for over in [2.0, 10.0, 1e3, 1e5] {
                let what = format!("{name}, {method}, {over} x");
                let h = over * limit;
                let run = with(&case, method, h, 100.0 * h);
                let (shown, outcome) = trace(&run);
                if name != "thrown" && shown.iter().any(|x| apart(x, &shown[0]) > 10.0) {
                    wrong.push(format!("{what}: a node ten sizes away was shown as good"));
                }
                match &outcome.failure {
                    Some(failure) if outcome.status == Status::Diverged => {
                        found += 1;
                        is_complete(failure, &what);
                        if over < 100.0 {
                            wrong.extend(follow_advice(&run, failure).err().map(|why| format!("{what}: {why}")));
                        }
                    }
                    Some(failure) => assert!(failure.cause.contains("Newton"), "{what}: {failure:?}"),
                    None => {}
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(found >= 8, "{found} were found");
}

/// Runs that resolve their motion are left alone: from rest under weight and wind, thrown, viscous; steps of all sizes.
#[test]
fn good_runs_are_left_alone() {
    for (name, case, limit) in scenes() {
        for method in methods() {
            for share in [1e-12, 1e-6, 1e-2] {
                let h = share * limit;
                let outcome = follow(&with(&case, method.name, h, 200.0 * h), |_| {});
                assert_eq!(outcome.status, Status::Completed, "{name}, {}, {h} s: {:?}", method.name, outcome.failure);
                assert_eq!(outcome.doubt, None, "{name}, {}, {h} s", method.name);
            }
        }
        let h = 0.8 * limit;
        for method in ["euler-cromer", "velocity-verlet", "rk4"] {
            // Euler-Cromer's limit is lower with damping.
            let h = if method == "euler-cromer" { 0.6 * h } else { h };
            let outcome = follow(&with(&case, method, h, 300.0 * h), |_| {});
            assert_eq!(outcome.status, Status::Completed, "{name}, {method}, {h} s: {:?}", outcome.failure);
        }
    }
}

/// A load that comes on in the middle of a rest gives masses speed before they move: that alone is no divergence.
#[test]
fn late_loads_are_no_divergence() {
    for table in
        ["[[0, 0], [1.0, 0], [1.0000001, 1]]", "[[0, 0], [1.0, 0], [2, 1]]", "[[0, 1e-6], [1.0, 1e-6], [1.001, 1]]"]
    {
        let case = of(json!({
            "mesh": rectangle(), "mass": {"areal_density": 0.5}, "springs": [{"on": "all", "stiffness": 100.0}],
            "supports": [{"on": "boundary", "fix": "xyz"}],
            "loads": [{"on": "all", "pressure": 20.0, "kind": "dead", "direction": [0, 0, 1], "table": serde_json::from_str::<Value>(table).expect("JSON")}]
        }));
        for method in methods() {
            let outcome = follow(&with(&case, method.name, 1e-3, 1.2), |_| {});
            assert_eq!(outcome.status, Status::Completed, "{}, {table}: {:?}", method.name, outcome.failure);
        }
    }
}

/// The air: what acts, where, within which time.
#[test]
fn air_that_is_too_stiff_is_named() {
    // dp = e a v: 1.6e4 Pa for 1 m/s through the cloth, so that it follows the air within some 1e-5 s.
    let law = r#"{"permeable": {"a": 1.6e8, "b": 0.0, "thickness": 1e-4}}"#;
    let dense = changed(&sail(), &[("system.network.aero.wind", "[0, 0, 0.5]"), ("system.network.aero.law", law)]);
    for method in ["explicit-euler", "euler-cromer", "velocity-verlet", "rk4", "improved-euler", "kang"] {
        let run = with(&dense, method, 5e-4, 0.02);
        let (shown, outcome) = trace(&run);
        let failure = outcome.failure.unwrap_or_else(|| panic!("{method} must fail"));
        is_complete(&failure, method);
        assert!(failure.cause.contains("m/(dF/dv)"), "{method}: {}", failure.cause);
        assert!(failure.triangle.is_some() && failure.term.as_deref() == Some("air"), "{method}: {failure:?}");
        assert!(shown.iter().all(|x| apart(x, &shown[0]) < 10.0), "{method}");
        follow_advice(&run, &failure).unwrap_or_else(|why| panic!("{method}: {why}"));
    }
    // A gale stiffens the cloth far beyond its springs.
    let gale = changed(&sail(), &[("system.network.aero.wind", "[0, 0, 3e4]")]);
    let failure = follow(&with(&gale, "explicit-euler", 2e-4, 0.02), |_| {}).failure.expect("it must fail");
    assert!(failure.cause.contains("loads that turn with the cloth (air)"), "{}", failure.cause);
}

/// The thesis' parachute in a wind of 1e12 m/s: what is shown as good is no faster than a few winds.
#[test]
fn the_original_parachute_is_stopped_before_it_is_a_wreck() {
    for method in ["explicit-euler", "euler-cromer", "velocity-verlet", "rk4", "improved-euler", "kang"] {
        let mut fastest = 0.0_f64;
        let case = asset("parachute-original", &[("time.method", method)]);
        let outcome =
            follow(&case, |seen| fastest = seen.velocities.iter().flatten().fold(fastest, |m, v| m.max(v.abs())));
        let failure = outcome.failure.unwrap_or_else(|| panic!("{method} must fail"));
        assert!(fastest < 1e13, "{method}: {fastest} m/s were shown as good");
        assert!(
            ["(air)", "m/(dF/dv)"].iter().any(|w| failure.cause.contains(w))
                && failure.cause.contains("speed of light"),
            "{failure:?}"
        );
        assert_eq!(failure.term.as_deref(), Some("air"), "{method}");
    }
}

/// Numbers that no scene has are said to be wrong, and the cause is still true.
#[test]
fn absurd_numbers_are_called_so() {
    let stiff = changed(&net(), &[("system.network.springs.0.stiffness", "1e300")]);
    let failure = follow(&with(&stiff, "velocity-verlet", 1e-3, 0.02), |_| {}).failure.expect("it must fail");
    for words in ["critical step", "such steps"] {
        assert!(failure.cause.contains(words), "{}", failure.cause);
    }
    assert!(failure.advice.contains("wrong unit"), "{}", failure.advice);
    let heavy = changed(&net(), &[("system.network.gravity", "[0, 0, -1e13]")]);
    let failure = follow(&with(&heavy, "velocity-verlet", 0.02, 0.4), |_| {}).failure.expect("it must fail");
    assert!(failure.cause.contains("speed of light") && failure.advice.contains("wrong unit"), "{failure:?}");
}

/// Past a divergence, to the blow-up: both times are told, and the first is the one of the run that stops.
#[test]
fn keep_going_tells_both_times() {
    let run = with(&net(), "velocity-verlet", 0.0144, 10.0);
    let stopped = follow(&run, |_| {}).failure.expect("it must fail");
    let spec = FollowSpec { keep_going: true, ..FollowSpec::default() };
    let on = follow_with(run.problem(), spec, |_| {}).expect("it starts").failure.expect("it must fail");
    assert_eq!((stopped.time, &stopped.cause, stopped.blow_up_time), (on.time, &on.cause, None));
    assert!(on.blow_up_time.is_some_and(|t| t > on.time), "{on:?}");
}

/// An implicit step that could not be solved says what is known of the state: that it buckles, that nothing holds it.
#[test]
fn unsolved_steps_tell_of_buckling_and_missing_supports() {
    let squeezed = changed(
        &net(),
        &[
            ("system.network.springs.0.rest_scale", "1.3"),
            ("system.network.supports.0.on", r#""boundary""#),
            ("solver.newton.max_iterations", "1"),
        ],
    );
    let failure = follow(&with(&squeezed, "newmark", 0.1, 1.0), |_| {}).failure.expect("it must fail");
    assert!(failure.cause.contains("buckle") && failure.cause.contains("1/s around node"), "{}", failure.cause);
    let pushed = changed(
        &squeezed,
        &[
            ("system.network.springs.0.rest_scale", "1"),
            ("system.network.loads", r#"[{"on": "all", "pressure": 200}]"#),
            ("solver.newton.strategy", r#""full""#),
        ],
    );
    let failure = follow(&with(&pushed, "newmark", 0.1, 1.0), |_| {}).failure.expect("it must fail");
    let turns = "loads that turn with the cloth (follower pressure) drive it away";
    assert!(failure.cause.contains(turns) && !failure.cause.contains("compressed"), "{}", failure.cause);
    let loose = changed(&squeezed, &[("system.network.supports", "[]")]);
    let failure = follow(&with(&loose, "newmark", 0.1, 1.0), |_| {}).failure.expect("it must fail");
    assert!(failure.cause.contains("nothing holds the 25 nodes connected to node"), "{}", failure.cause);
}
