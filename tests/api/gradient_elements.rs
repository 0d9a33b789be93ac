//! Derivatives by what each spring and each node has (the adjoint run): against those by numbers of the case (the
//! tangent-linear run), for a run of which few steps are kept, and what is refused.

use crate::common::run::{case_of, changed};
use crate::gradient::{net, of};
use canopy_fem::case::Case;
use canopy_fem::integrate::registry::methods;
use canopy_fem::model::stop::Stop;
use canopy_fem::study::gradient::{GradientError, GradientReport, GradientSpec, gradient};
use serde_json::json;

fn found(case: &Case, by: &[&str], states: Option<u64>) -> Result<GradientReport, GradientError> {
    let by: Vec<String> = by.iter().map(|key| (*key).to_owned()).collect();
    gradient(&GradientSpec { case, by: &by, states, threads: 1, verify: false, interrupt: Stop::NEVER })
}

/// The derivatives of a quantity by what each edge or node has; 0 where there is none.
fn each(report: &GradientReport, quantity: &str, by: &str) -> Vec<f64> {
    let quantity = report.quantities.iter().find(|of| of.name == quantity).expect("the quantity");
    let each = quantity.each.iter().find(|of| of.by == by).expect("each");
    each.values.iter().map(|value| value.unwrap_or(0.0)).collect()
}

/// The net with a dashpot that does not depend on the stiffness.
fn net_of(method: &str) -> Case {
    changed(&net(&json!(method)), &[("system.network.springs.0.dashpot", r#"{"axial": {"coefficient": 0.6}}"#)])
}

/// The nodes of the net that are free: the four in its middle.
fn free(report: &GradientReport, quantity: &str, by: &str, axis: usize) -> f64 {
    [5, 6, 9, 10].into_iter().map(|node| each(report, quantity, by)[3 * node + axis]).sum()
}

/// Of every method, the derivatives by all springs and nodes together are those by the numbers of the case that they
/// have in common, to 1e-7 of the largest relative change: stiffness and rest length of all springs, mass and force at
/// a node, velocity at the start.
#[test]
fn all_springs_and_nodes_together_are_the_numbers_of_the_case() {
    let keys = ["springs.0.stiffness", "rest_length", "points.0.total", "loads.1.force.0", "initial.velocity.2"];
    let elements = ["each.stiffness", "each.rest_length", "each.mass", "each.force", "each.velocity"];
    let mut made = 0;
    for info in methods() {
        let quantities = r#"["middle.z.last", "middle.vz.last", "all.tension_sum.last", "all.tension_max.peak",
            "rim.reaction_z.mean", "rim.reaction_max.last", "middle.z@0.0253", "all.tension_sum.min", "middle.vx.steady",
            "felt.acceleration_z.last", "felt.acceleration_max.peak"]"#;
        let gauges = r#"[{"name": "all", "on": "all", "of": "tension"}, {"name": "rim", "on": "boundary", "of": "reaction"},
            {"name": "felt", "on": {"ids": [5]}, "of": "acceleration"}]"#;
        let case = changed(&net_of(info.name), &[("study.quantities", quantities), ("output.gauges", gauges)]);
        let asked = [&keys[..], &elements[..]].concat();
        let report = match found(&case, &asked, None) {
            Ok(report) => report,
            Err(error) => {
                assert!(error.to_string().contains("derivative of a step by"), "{}: {error}", info.name);
                continue;
            }
        };
        made += 1;
        for quantity in report.quantities.iter().map(|of| of.name.as_str()) {
            let sum = |by| each(&report, quantity, by).iter().sum::<f64>();
            let together = [
                sum("each.stiffness"),
                sum("each.rest_length"),
                each(&report, quantity, "each.mass")[5],
                each(&report, quantity, "each.force")[18],
                free(&report, quantity, "each.velocity", 2),
            ];
            let derivatives = &report.quantities.iter().find(|of| of.name == quantity).expect("it").derivatives;
            let largest = derivatives.iter().map(|of| (of.value * of.at).abs()).fold(0.0, f64::max);
            for (key, together) in keys.iter().zip(together) {
                let one = derivatives.iter().find(|of| of.by.ends_with(key)).expect("the key");
                let differs = ((together - one.value) * one.at).abs() / largest;
                assert!(differs < 1e-7, "{}: {quantity} by {key}: {together} for {}", info.name, one.value);
            }
        }
    }
    assert_eq!(made, methods().len() - 5);
}

/// Each spring of a chain has its own rule, so that each derivative is one by a number of the case; the positions at
/// the start are those of an explicit mesh.
#[test]
fn each_spring_is_the_number_of_its_rule() {
    let springs: Vec<_> = (0..3)
        .map(|i| json!({"on": {"ids": [i]}, "stiffness": 80.0 + 20.0 * f64::from(i), "rest_length": 0.9}))
        .collect();
    let case = case_of(
        &json!({
            "name": "chain",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0.1, 0], [2, 0, 0.2], [3.1, 0, 0]],
                                      "springs": [[0, 1], [1, 2], [2, 3]], "triangles": []}},
                "mass": {"nodal": 0.4},
                "springs": springs,
                "gravity": [0, 0, -9.81],
                "supports": [{"on": {"ids": [0]}, "fix": "xyz"}]
            }},
            "time": {"end": 0.6, "method": "newmark", "step": 0.01},
            "solver": {"newton": {"relative": 1e-12}},
            "output": {"probes": [{"name": "tip", "on": {"ids": [3]}}]},
            "study": {"quantities": ["tip.z.last", "tip.x.min"]}
        }),
        &[],
    );
    let keys: Vec<String> =
        (0..3).flat_map(|i| [format!("springs.{i}.stiffness"), format!("springs.{i}.rest_length")]).collect();
    let mut asked: Vec<&str> = keys.iter().map(String::as_str).collect();
    asked.extend(["each.stiffness", "each.rest_length"]);
    let report = found(&case, &asked, None).expect("derivatives");
    for quantity in ["tip.z.last", "tip.x.min"] {
        for (spring, by) in (0..3).flat_map(|spring| [(spring, "stiffness"), (spring, "rest_length")]) {
            let expected = of(&report, quantity, &format!("springs.{spring}.{by}"));
            let value = each(&report, quantity, &format!("each.{by}"))[spring];
            assert!((value / expected - 1.0).abs() < 1e-8, "{quantity} by {by} of {spring}: {value} for {expected}");
        }
    }
}

/// With few steps kept, parts of the run are made again, to the same derivatives: also of schemes that carry more than
/// positions and velocities, and over a support that lets go.
#[test]
fn few_kept_steps_give_the_same_derivatives() {
    for method in ["newmark", "velocity-verlet", "rk4", "generalized-alpha", "central-difference", "hht"] {
        let case = changed(&net_of(method), &[("system.network.supports.0.until", "0.02")]);
        let case = changed(&case, &[("study.quantities", r#"["middle.z.last", "middle.vz.mean"]"#)]);
        let by = ["each.stiffness", "each.mass", "each.position"];
        let all = found(&case, &by, None).expect("derivatives");
        assert_eq!(all.again, 0);
        for states in [2, 5, 20] {
            let few = found(&case, &by, Some(states)).expect("derivatives");
            assert!(few.again >= 50, "{method}: {}", few.again);
            assert!(states < 20 || few.again <= 3 * 50, "{method}: {}", few.again);
            for (quantity, by) in ["middle.z.last", "middle.vz.mean"].iter().flat_map(|q| by.map(|by| (*q, by))) {
                let (few, all) = (each(&few, quantity, by), each(&all, quantity, by));
                let size = all.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
                let differs = few.iter().zip(&all).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
                assert!(differs < 1e-9 * size, "{method}, {states}: {quantity} by {by}: {differs:.1e} of {size:.1e}");
            }
        }
    }
}

/// A factor of an earlier step serves many.
#[test]
fn few_factorisations_serve_all_steps_back() {
    let report = found(&net_of("newmark"), &["each.stiffness"], None).expect("derivatives");
    assert!(report.steps == 50 && (1..=10).contains(&report.factorizations), "{}", report.factorizations);
}

/// What has no such derivative says so.
#[test]
fn what_has_no_derivative_by_elements_says_so() {
    let base = net_of("newmark");
    type Row = (&'static [(&'static str, &'static str)], &'static str, &'static str);
    let rows: [Row; 4] = [
        (&[], "each.stiffnes", "known are each.stiffness, each.rest_length"),
        (&[("study.quantities", "[\"max_strain\"]")], "each.mass", "name a gauge of tensions"),
        (&[("time.method", "kang")], "each.mass", "by kang is not known"),
        (&[("study.quantities", "[\"energy.kinetic.peak\"]")], "each.mass", "energy.kinetic.peak has no derivative"),
    ];
    for (sets, by, words) in rows {
        let error = found(&changed(&base, sets), &[by], None).expect_err(words).to_string();
        assert!(error.contains(words), "{words}: {error}");
    }
}
