//! Mass scaling: how much is added and where, that only inertia is, what is said of it, and its error in a study.

use crate::bench::{Bench, Ended};
use crate::study::table::study;
use canopy_fem::study::models::Model;
use serde_json::{Value, json};

/// [N/m] and [kg] of [`pair`].
const STIFFNESS: f64 = 1e4;
const MASSES: [f64; 2] = [1.0, 0.01];

/// Two free masses on a spring, stretched by 0.1 m and moving at 3 m/s. By the bound each needs k h^2/2.
fn pair(scaling: f64, step: f64) -> Value {
    json!({
        "name": "pair",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0]], "springs": [[0, 1]]}},
            "mass": {"nodal": MASSES},
            "springs": [{"on": "all", "stiffness": STIFFNESS}],
            "initial": {"displacement": [[0, 0, 0], [0.1, 0, 0]], "velocity": [3, 0, 0]}
        }},
        "time": {"end": 0.1, "method": "velocity-verlet", "step": step, "mass_scaling": {"step": scaling}},
        "output": {"frames": {"every": 0.005}, "probes": [{"name": "a", "on": {"ids": [0]}}, {"name": "b", "on": {"ids": [1]}}]},
        "acknowledge": ["loose-nodes"]
    })
}

/// A mass of 0.01 kg under a damped spring of 100 N/m, until it is at rest.
fn weight(loads: Value) -> Value {
    let mut network = json!({
        "mesh": {"explicit": {"nodes": [[0, 0, 0], [0, 0, -1]], "springs": [[0, 1]]}},
        "mass": {"nodal": 0.01},
        "springs": [{"on": "all", "stiffness": 100.0, "dashpot": {"axial": {"coefficient": 2.0}}}],
        "supports": [{"on": {"ids": [0]}, "fix": "xyz"}]
    });
    network.as_object_mut().expect("an object").extend(loads.as_object().expect("an object").clone());
    json!({
        "name": "weight", "system": {"network": network},
        "time": {"end": 100.0, "method": "central-difference", "step": 0.02, "mass_scaling": {"step": 0.1},
                 "until_rest": {"speed": 1e-9}},
        "output": {"probes": [{"name": "weight", "on": {"ids": [1]}}]}
    })
}

fn run(bench: &Bench, case: &Value, command: &[&str]) -> Ended {
    std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
    bench.run(&[&command[..1], &["case.json"], &command[1..]].concat())
}

fn solved(case: &Value) -> (Bench, Ended) {
    let bench = Bench::new();
    let ended = run(&bench, case, &["solve", "--out", "out"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    (bench, ended)
}

fn near(found: &Value, expected: f64, within: f64) -> bool {
    found.as_f64().is_some_and(|found| (found / expected - 1.0).abs() < within)
}

/// [m] Places of both masses at time `t` [s]: the closed form with these masses, whose period is that of the reduced
/// mass, and whose centre moves at 3 m/s.
fn places(t: f64, [a, b]: [f64; 2]) -> [f64; 2] {
    let (share, omega) = (b / (a + b), (STIFFNESS * (a + b) / (a * b)).sqrt());
    let (centre, stretch) = (3.0 * t + share * 1.1, 1.0 + 0.1 * (omega * t).cos());
    [centre - share * stretch, centre + (1.0 - share) * stretch]
}

/// The light mass gets what a step of 0.01 s needs, 0.5 kg, and no more. So the pair swings as these masses do, keeps
/// its momentum, and the account of its energy adds up.
#[test]
fn two_masses_swing_with_the_period_of_the_scaled_one() {
    let (bench, ended) = solved(&pair(0.01, 1e-5));
    let results = bench.results();
    let (summary, probes) = (results.summary(), results.table("probes.csv"));
    let added = &summary["mass_scaling"];
    for (what, expected) in [("step", 0.01), ("added", 0.49), ("share", 0.49 / 1.01), ("share_of_nodes", 49.0)] {
        assert!(near(&added[what], expected, 1e-6), "{what}: {added}");
    }
    assert_eq!([&added["nodes"], &added["largest_at"]], [&json!(1), &json!(1)]);
    assert!(near(&added["largest_factor"], 50.0, 1e-6) && summary["energy_error"].as_f64() < Some(1e-6), "{summary}");
    let said = "mass scaling    0.49 kg added for steps of 0.01 s: 49 % of all that moves";
    assert!(ended.stdout.contains(said), "{}", ended.stdout);
    assert!(ended.stderr.contains("[mass-scaling]"), "{}", ended.stderr);
    let (t, x, node) = (probes.column("t"), probes.column("x"), probes.column("node"));
    assert_eq!(t.len(), 42);
    for ((t, x), node) in t.iter().zip(x).zip(node) {
        let expected = places(*t, [1.0, 0.5])[node as usize];
        assert!((x - expected).abs() < 1e-6, "node {node} at {t} s: {x} for {expected}");
    }
}

/// The step that was asked for is stable, as the bound proves; without scaling it is far from that.
#[test]
fn the_step_that_is_asked_for_is_stable() {
    let (bench, _) = solved(&pair(0.01, 0.01));
    assert!(bench.results().summary()["critical_step"].as_f64() >= Some(0.01));
    let mut without = pair(0.01, 0.01);
    without["time"].as_object_mut().expect("an object").remove("mass_scaling");
    assert_eq!(run(&bench, &without, &["solve", "--out", "without"]).code, Some(3));
}

/// A weight hangs as low as its own mass pulls, although it has 35 times the inertia: k h^2/4 + c h/2. In an
/// accelerated frame all inertia pulls.
#[test]
fn weight_stays_and_inertia_grows() {
    let inertia = 100.0 * 0.01 / 4.0 + 2.0 * 0.1 / 2.0;
    let shaken = json!({"base_acceleration": {"table": [[0, 0, 0, 0.5], [1000, 0, 0, 0.5]]}});
    for (loads, force) in [(json!({"gravity": [0, 0, -9.81]}), 0.01 * 9.81), (shaken, inertia * 0.5)] {
        let (bench, ended) = solved(&weight(loads));
        assert!(ended.stdout.contains("at rest         yes"), "{}", ended.stdout);
        let summary = bench.results().summary();
        assert!(near(&summary["mass_scaling"]["largest_factor"], inertia / 0.01, 1e-6), "{summary}");
        let sag = -1.0 - bench.results().table("probes.csv").column("z").last().expect("a row");
        assert!((sag * 100.0 / force - 1.0).abs() < 1e-6, "{sag} m under {force} N");
    }
}

/// An equilibrium and its modes are those of the real masses.
#[test]
fn statics_know_no_scaling() {
    let bench = Bench::new();
    let case = weight(json!({"gravity": [0, 0, -9.81]}));
    let ended = run(&bench, &case, &["static", "--modes", "1", "--out", "out"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let summary = bench.results().summary();
    assert!(summary["mass_scaling"].is_null());
    // The pendulum of a spring that is stretched by 0.01 * 9.81/100 m.
    let hertz = (9.81 / (1.0 + 9.81e-4_f64)).sqrt() / std::f64::consts::TAU;
    assert!(near(&summary["equilibrium"]["frequencies"][0], hertz, 1e-6), "{summary}");
}

/// A spring that is slack at the start, its rest length 1.25 times its edge, counts as one that is taut.
#[test]
fn slack_springs_count_as_taut() {
    let mut slack = pair(0.01, 1e-3);
    slack["system"]["network"]["springs"][0] =
        json!({"on": "all", "stiffness": STIFFNESS, "slack": "tension-only", "rest_scale": 1.25});
    let (bench, _) = solved(&slack);
    let added = &bench.results().summary()["mass_scaling"];
    assert!(near(&added["largest_factor"], 50.0, 1e-6), "{added}");
}

/// Four masses with a spring of finite strain between any two, and dashpots that end their swinging. With a `tether`, a
/// loose line of 20 times its edge hangs from one to a weight beside it.
fn braced(tether: Option<&Value>) -> Value {
    let mut springs = vec![json!([0, 1]), json!([1, 2]), json!([2, 3]), json!([3, 0]), json!([0, 2]), json!([1, 3])];
    let dashpot = json!({"axial": {"time": 1e-3}});
    let own = json!({"on": {"ids": [0, 1, 2, 3, 4, 5]}, "stiffness": STIFFNESS, "dashpot": dashpot, "law": "green"});
    let mut rules = vec![own];
    if let Some(slack) = tether {
        let mut line = json!({"on": {"ids": [6]}, "stiffness": STIFFNESS, "dashpot": dashpot, "rest_scale": 20});
        let object = slack.as_object().expect("an object").clone();
        line.as_object_mut().expect("an object").extend(object);
        springs.push(json!([2, 4]));
        rules.push(line);
    }
    json!({
        "name": "braced",
        "system": {"network": {
            "mesh": {"explicit": {
                "nodes": [[0, 0, 0], [1, 0, 0], [1.6, 0.7, 0], [0, 1.2, 0], [3, 1, 0]], "springs": springs
            }},
            "mass": {"nodal": [0.01, 0.01, 0.01, 0.01, 10.0]},
            "springs": rules,
            "initial": {"velocity": [[0.3, 0, 0], [0, 0.2, 0], [0.3, 0.1, 0], [0, -0.2, 0], [0, 0, 0]]}
        }},
        "time": {"end": 5.0, "method": "central-difference", "step": 0.005, "mass_scaling": {"step": 0.005}},
        "acknowledge": ["loose-nodes"]
    })
}

/// A loose line counts as taut, and so do dashpots of one that gets shorter, without a stretch of the other springs:
/// these would be many times stiffer by their finite strain. The step that is asked for is stable.
#[test]
fn one_loose_line_does_not_scale_the_others() {
    let added = |case: &Value| {
        let (bench, ended) = solved(case);
        let summary = bench.results().summary();
        // [J] Of 0.05 J at the start.
        assert!(summary["final_ledger"]["elastic"].as_f64() < Some(1e-6), "{summary}");
        assert!(!ended.stderr.contains("slack-springs"), "{}", ended.stderr);
        summary["mass_scaling"]["added"].as_f64().expect("a number")
    };
    let without = added(&braced(None));
    // [kg] What the line needs along it, if its other end is heavy enough for half of it.
    let line = STIFFNESS * 0.005_f64.powi(2) / 2.0 + STIFFNESS * 1e-3 * 0.005;
    for slack in [
        json!({"slack": "tension-only"}),
        json!({"slack": "tension-only", "law": "green"}),
        json!({"slack": {"dead_zone": 0.5}, "law": "green"}),
        json!({"slack": {"compression_limit": 1e-12}}),
    ] {
        let with = added(&braced(Some(&slack)));
        assert!(with > without + 0.1 * line && with < without + line, "{slack}: {with} kg and {without} kg");
    }
}

/// Where it has no meaning it is refused, with the place.
#[test]
fn what_cannot_be_scaled_is_refused() {
    let bench = Bench::new();
    for (method, said) in [("newmark", "mass scaling with newmark"), ("kang", "mass scaling with kang")] {
        let mut case = pair(0.01, 0.01);
        case["time"]["method"] = json!(method);
        let ended = run(&bench, &case, &["solve", "--out", "out"]);
        assert_eq!(ended.code, Some(2), "{}", ended.stderr);
        assert!(ended.stderr.contains("/time/mass_scaling") && ended.stderr.contains(said), "{}", ended.stderr);
    }
    let pendulum = json!({"name": "p", "system": {"pendulum": {"angle": 0.5, "length": 1, "mass": 1, "gravity": 9.81}},
        "time": {"end": 1, "method": "rk4", "step": 0.01, "mass_scaling": {"step": 0.1}}});
    let ended = run(&bench, &pendulum, &["solve", "--out", "out"]);
    assert!(ended.code == Some(2) && ended.stderr.contains("only with a network"), "{}", ended.stderr);
    let ended = run(&bench, &pair(1e-4, 1e-5), &["solve", "--out", "out"]);
    let said = "adds nothing: no node needs more than 0.005 of its mass";
    assert!(ended.code == Some(2) && ended.stderr.contains(said), "{}", ended.stderr);
}

/// Implicit methods refuse scaled masses, so where a step is too long they are advised without these: before the run,
/// and where it fails, with and without dashpots.
#[test]
fn advice_knows_that_implicit_methods_take_real_masses() {
    let bench = Bench::new();
    let dashpot = json!({"axial": {"coefficient": 1e-3}});
    for damped in [false, true] {
        let mut case = pair(0.01, 0.05);
        case["time"]["end"] = json!(10.0);
        if damped {
            case["system"]["network"]["springs"][0]["dashpot"] = dashpot.clone();
        }
        let ended = run(&bench, &case, &["solve", "--force", "--out", "out"]);
        let advice = " s or smaller, or time.method=backward-euler without time.mass_scaling";
        assert!(ended.code == Some(3) && ended.stderr.matches(advice).count() >= 2, "{}", ended.stderr);
        assert_eq!(
            ended.stderr.matches("time.method=").count(),
            ended.stderr.matches(advice).count(),
            "{}",
            ended.stderr
        );
    }
    let mut slack = pair(0.01, 0.02);
    slack["system"]["network"]["springs"][0]["slack"] = json!("tension-only");
    slack["system"]["network"]["springs"][0]["rest_scale"] = json!(1.25);
    let ended = run(&bench, &slack, &["check"]);
    let said = "or time.method=backward-euler without time.mass_scaling [slack-springs]";
    assert!(ended.stdout.contains(said), "{}", ended.stdout);
    let refused = run(&bench, &slack, &["solve", "--method", "backward-euler", "--force", "--out", "out"]);
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    slack["time"].as_object_mut().expect("an object").remove("mass_scaling");
    let taken = run(&bench, &slack, &["solve", "--method", "backward-euler", "--force", "--out", "out"]);
    assert_eq!(taken.code, Some(0), "{}", taken.stderr);
}

/// A little mass raises no doubt: 2.4 % here.
#[test]
fn little_mass_is_no_warning() {
    let (bench, ended) = solved(&pair(0.0026, 1e-4));
    assert!(near(&bench.results().summary()["mass_scaling"]["share"], (0.0338 - 0.01) / 1.01, 1e-5));
    assert!(!ended.stderr.contains("mass-scaling"), "{}", ended.stderr);
}

/// `check` tells what is added, in words and for programs.
#[test]
fn check_tells_what_is_added() {
    let bench = Bench::new();
    let case = pair(0.01, 1e-3);
    let ended = run(&bench, &case, &["check"]);
    assert!(
        ended.stdout.contains("mass scaling    0.49 kg added") && ended.stdout.contains("[mass-scaling]"),
        "{}",
        ended.stdout
    );
    assert!(
        ended.stdout.contains("canopy-fem tradeoff case.json measures what the added mass costs"),
        "{}",
        ended.stdout
    );
    // The forecast compares runs with these masses.
    let apart = "%, that of the scaled masses apart\n";
    assert!(ended.stdout.contains(apart), "{}", ended.stdout);
    let mut real = case.clone();
    real["time"].as_object_mut().expect("an object").remove("mass_scaling");
    let real = run(&bench, &real, &["check"]).stdout;
    assert!(real.contains("motion ± ") && !real.contains("scaled masses"), "{real}");
    let told: Value = serde_json::from_str(&run(&bench, &case, &["check", "--json"]).stdout).expect("JSON");
    assert!(near(&told["mass_scaling"]["added"], 0.49, 1e-6), "{told}");
    // What it recommends has these masses, so it is explicit.
    let methods: Vec<&Value> =
        told["critical_steps"].as_array().expect("a list").iter().map(|m| &m["method"]).collect();
    assert!(methods.contains(&&json!("rk4")) && !methods.contains(&&json!("newmark")), "{methods:?}");
}

/// A checkpoint of other masses is refused.
#[test]
fn a_run_goes_on_with_the_same_masses_only() {
    let mut case = pair(0.01, 1e-4);
    case["output"]["checkpoint"] = json!({"every": 0.05});
    let (bench, _) = solved(&case);
    std::fs::remove_file(bench.path("out/summary.json")).expect("removed");
    case["time"]["mass_scaling"]["step"] = json!(0.02);
    let ended = run(&bench, &case, &["solve", "--resume", "--out", "out"]);
    assert!(ended.code == Some(2) && ended.stderr.contains("time.mass_scaling.step"), "{}", ended.stderr);
}

/// A study runs explicit methods with both masses, implicit ones with the real masses, and measures all against these:
/// the error of scaled masses is the distance of two closed forms.
#[test]
fn a_study_measures_the_error_of_scaled_masses() {
    let bench = Bench::new();
    let methods = ["--methods", "velocity-verlet,newmark", "--steps", "1e-5", "--repeat", "1"];
    let mut case = pair(0.0026, 1e-4);
    case["system"]["network"]["initial"]["velocity"] = json!([0.01, 0, 0]);
    case["time"]["end"] = json!(0.01);
    case["output"]["frames"]["every"] = json!(0.001);
    let ended = run(&bench, &case, &[&["tradeoff", "--out", "out"], &methods[..]].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let found = study(&bench.path("out"));
    let of = |method: &str, model| {
        let rows = found.rows.iter().filter(|row| row.job.method.name == method && row.job.model == Some(model));
        rows.filter_map(|row| row.measured.error).collect::<Vec<f64>>()
    };
    let slower = |places: [f64; 2], t: f64| places.map(|x| x - 2.99 * t);
    let (mut apart, mut moved) = (0.0, 0.0);
    for frame in 1..=10 {
        let t = 0.001 * f64::from(frame);
        let [real, scaled] = [MASSES, [1.0, 0.0338]].map(|masses| slower(places(t, masses), t));
        for (i, start) in [0.0, 1.1].into_iter().enumerate() {
            apart += (real[i] - scaled[i]).powi(2);
            moved += (real[i] - start).powi(2);
        }
    }
    let expected = f64::sqrt(apart / moved);
    let reports = &found.plan.variants[0].models;
    let error = reports.iter().find_map(|report| report.error.as_ref()).expect("of scaled masses").error;
    assert!((error / expected - 1.0).abs() < 1e-5, "{error} for {expected}");
    assert!((of("velocity-verlet", Model::ScaledMass)[0] / expected - 1.0).abs() < 1e-3);
    assert!(of("velocity-verlet", Model::RealMass)[0] < 1e-3 && of("newmark", Model::RealMass)[0] < 1e-3);
    assert!(of("newmark", Model::ScaledMass).is_empty());
    let said = format!(
        "ith scaled masses the solution differs from that with real masses by {} of the motion",
        canopy_fem::format_number::figures(error, 2)
    );
    let page = std::fs::read_to_string(bench.path("out/tradeoff.html")).expect("a page");
    assert!(ended.stdout.contains(&said) && page.contains(&said), "{}", ended.stdout);
    assert!(page.contains("Explicit methods run with scaled masses too, for steps of 0.0026 s"));
    let table = std::fs::read_to_string(bench.path("out/tradeoff.csv")).expect("a table");
    assert!(table.contains("\nscaled-mass,velocity-verlet") && !table.contains("scaled-mass,newmark"), "{table}");
    // `check` looks where a study of this name is.
    std::fs::create_dir_all(bench.path("out/pair")).expect("made");
    let ended = run(&bench, &case, &[&["tradeoff", "--out", "out/pair"], &methods[..]].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let checked = run(&bench, &case, &["check"]);
    assert!(checked.stdout.contains(&said), "{}", checked.stdout);
    // Models of cloth are another comparison.
    let ended = run(&bench, &case, &["tradeoff", "--models", "net,membrane", "--out", "models"]);
    assert!(ended.code == Some(2) && ended.stderr.contains("leave time.mass_scaling out"), "{}", ended.stderr);
}

/// Springs that are 100 times as soft need no added mass: a sweep of the stiffness goes on with the real masses there,
/// and says so. A study of such a case alone is refused, as a run is.
#[test]
fn a_sweep_of_the_stiffness_goes_on_where_no_mass_is_needed() {
    let bench = Bench::new();
    let mut case = pair(0.01, 1e-3);
    case["time"]["end"] = json!(0.01);
    case["output"]["frames"]["every"] = json!(0.001);
    let study_of = ["tradeoff", "--methods", "velocity-verlet", "--steps", "1e-4", "--repeat", "1"];
    let sweep = [&study_of[..], &["--stiffness-sweep", "0.01,1", "--out", "out"]].concat();
    let ended = run(&bench, &case, &sweep);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let found = study(&bench.path("out"));
    for variant in &found.plan.variants {
        let models: Vec<Model> = variant.models.iter().map(|report| report.model).collect();
        let expected = match variant.stiffness_factor {
            1.0 => &[Model::RealMass, Model::ScaledMass][..],
            _ => &[Model::RealMass],
        };
        assert_eq!(models, expected);
    }
    assert_eq!(found.rows.len(), 3, "with both masses where some are added");
    let said = "no node needs more than 0.5 of its mass for steps of 0.01 s, so that all runs have the real masses";
    let page = std::fs::read_to_string(bench.path("out/tradeoff.html")).expect("a page");
    assert!(ended.stdout.contains(said) && page.contains(&said[1..]), "{}", ended.stdout);
    assert!(page.contains("Explicit methods run with scaled masses too"));
    case["system"]["network"]["springs"][0]["stiffness"] = json!(0.01 * STIFFNESS);
    let refused = run(&bench, &case, &[&study_of[..], &["--out", "one"]].concat());
    assert!(refused.code == Some(2) && refused.stderr.contains("adds nothing: no node needs"), "{}", refused.stderr);
}

/// A sweep tells the mass that was added to each run; without mass scaling it has no such columns.
#[test]
fn a_sweep_tells_the_added_mass_of_each_run() {
    let bench = Bench::new();
    let case = pair(0.01, 1e-4);
    let ended = run(&bench, &case, &["sweep", "--vary", "time.mass_scaling.step=0.01,0.02", "--out", "out"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let table = std::fs::read_to_string(bench.path("out/sweep.csv")).expect("a table");
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    let column = |name: &str| -> Vec<f64> {
        let place = rows[0].iter().position(|other| *other == name).expect(name);
        rows[1..].iter().map(|row| row[place].parse().expect("a number")).collect()
    };
    for (name, expected) in [("added_mass", [0.49, 2.99]), ("added_mass_share", [0.49 / 1.01, 2.99 / 1.01])] {
        for (found, expected) in column(name).into_iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 1e-6, "{name}: {found} for {expected}");
        }
    }
    let mut real = case;
    real["time"].as_object_mut().expect("an object").remove("mass_scaling");
    let ended = run(&bench, &real, &["sweep", "--vary", "time.step=1e-4,2e-4", "--out", "real"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let table = std::fs::read_to_string(bench.path("real/sweep.csv")).expect("a table");
    assert!(!table.contains("added_mass"), "{table}");
}
