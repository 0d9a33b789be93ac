//! Exact derivatives of a run (`study::gradient`): against the derivatives of the recurrences of schemes, against
//! differences of whole runs, and what has none.

use crate::common::run::{case_of, changed};
use canopy_fem::case::Case;
use canopy_fem::integrate::registry::methods;
use canopy_fem::model::stop::Stop;
use canopy_fem::study::gradient::{GradientError, GradientReport, GradientSpec, gradient};
use serde_json::{Value, json};

/// A number and its derivative.
#[derive(Clone, Copy, Debug)]
struct Dual(f64, f64);

impl std::ops::Add for Dual {
    type Output = Dual;
    fn add(self, o: Dual) -> Dual {
        Dual(self.0 + o.0, self.1 + o.1)
    }
}

impl std::ops::Sub for Dual {
    type Output = Dual;
    fn sub(self, o: Dual) -> Dual {
        Dual(self.0 - o.0, self.1 - o.1)
    }
}

impl std::ops::Mul for Dual {
    type Output = Dual;
    fn mul(self, o: Dual) -> Dual {
        Dual(self.0 * o.0, self.0 * o.1 + self.1 * o.0)
    }
}

impl std::ops::Div for Dual {
    type Output = Dual;
    fn div(self, o: Dual) -> Dual {
        Dual(self.0 / o.0, (self.1 * o.0 - self.0 * o.1) / (o.0 * o.0))
    }
}

fn number(value: f64) -> Dual {
    Dual(value, 0.0)
}

fn found(case: &Case, by: &[&str], threads: usize, verify: bool) -> Result<GradientReport, GradientError> {
    let by: Vec<String> = by.iter().map(|key| (*key).to_owned()).collect();
    gradient(&GradientSpec { case, by: &by, states: None, threads, verify, interrupt: Stop::NEVER })
}

/// The derivative of a quantity by a key.
pub(crate) fn of(report: &GradientReport, quantity: &str, key: &str) -> f64 {
    let quantity = report.quantities.iter().find(|of| of.name == quantity).expect("the quantity");
    quantity.derivatives.iter().find(|of| of.by.ends_with(key)).expect("the key").value
}

const STIFFNESS: f64 = 50.0;
const MASS: f64 = 0.7;
const REST: f64 = 1.1;
const START: f64 = 1.3;

fn oscillator(method: &str, step: f64, steps: u32) -> Case {
    case_of(
        &json!({
            "name": "gradient",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": [[0, 0, 0], [START, 0, 0]], "springs": [[0, 1]], "triangles": []}},
                "mass": {"nodal": MASS},
                "springs": [{"on": "all", "stiffness": STIFFNESS, "rest_length": REST}],
                "supports": [{"on": {"ids": [0]}, "fix": "xyz"}]
            }},
            "time": {"end": step * f64::from(steps), "method": method, "step": step},
            "solver": {"newton": {"relative": 1e-12}},
            "output": {"probes": [{"name": "tip", "on": {"ids": [1]}}]},
            "study": {"quantities": ["tip.x.last", "tip.vx.last"]}
        }),
        &[],
    )
}

/// x and v after steps of a scheme on an oscillator, by its recurrence.
fn recurrence(method: &str, h: f64, steps: u32, [k, m, rest]: [Dual; 3]) -> [Dual; 2] {
    let (h, half) = (number(h), number(0.5));
    let acceleration = |x: Dual| number(0.0) - k / m * (x - rest);
    let (mut x, mut v) = (number(START), number(0.0));
    let mut a = acceleration(x);
    for _ in 0..steps {
        match method {
            "explicit-euler" => (x, v) = (x + h * v, v + h * acceleration(x)),
            "euler-cromer" => {
                v = v + h * acceleration(x);
                x = x + h * v;
            }
            "velocity-verlet" => {
                let middle = v + half * h * acceleration(x);
                x = x + h * middle;
                v = middle + half * h * acceleration(x);
            }
            "backward-euler" => {
                v = (v + h * acceleration(x)) / (number(1.0) + h * h * k / m);
                x = x + h * v;
            }
            "newmark" => {
                let quarter = half * half * h * h;
                let predicted = x + h * v + quarter * a;
                let next = acceleration(predicted) / (number(1.0) + quarter * k / m);
                x = predicted + quarter * next;
                v = v + half * h * (a + next);
                a = next;
            }
            _ => {
                let slope = |x: Dual, v: Dual| [v, acceleration(x)];
                let [u1, a1] = slope(x, v);
                let [u2, a2] = slope(x + half * h * u1, v + half * h * a1);
                let [u3, a3] = slope(x + half * h * u2, v + half * h * a2);
                let [u4, a4] = slope(x + h * u3, v + h * a3);
                let (two, sixth) = (number(2.0), h / number(6.0));
                x = x + sixth * (u1 + two * u2 + two * u3 + u4);
                v = v + sixth * (a1 + two * a2 + two * a3 + a4);
            }
        }
    }
    [x, v]
}

/// The derivatives of an oscillator by its stiffness, mass and rest length are those of the scheme's recurrence, of
/// which the steps are no small part: w h is 0.34.
#[test]
fn derivatives_are_those_of_the_recurrence() {
    let h = 0.04;
    for method in ["explicit-euler", "euler-cromer", "velocity-verlet", "rk4", "newmark", "backward-euler"] {
        let keys = ["stiffness", "mass.nodal", "rest_length"];
        // Explicit Euler makes energy.
        let steps = if method == "explicit-euler" { 15 } else { 57 };
        let report = found(&oscillator(method, h, steps), &keys, 1, false).expect("derivatives");
        for (place, key) in keys.iter().enumerate() {
            let mut parameters = [STIFFNESS, MASS, REST].map(number);
            parameters[place].1 = 1.0;
            let expected = recurrence(method, h, steps, parameters);
            for (name, expected) in ["tip.x.last", "tip.vx.last"].iter().zip(expected) {
                let got = of(&report, name, key);
                let differs = (got - expected.1).abs() / expected.1.abs();
                assert!(differs < 2e-9, "{method}, {name} by {key}: {got} for {}, {differs:.1e}", expected.1);
            }
        }
    }
}

/// A mass that falls through the air by Euler-Cromer: v <- v + h (g - rho CdS v^2/(2 m)).
#[test]
fn a_falling_mass_has_the_derivatives_of_its_recurrence() {
    let (drag_area, mass, gravity, density, h, steps) = (0.7, 100.0, 9.81, 1.225, 0.05, 200);
    let case = case_of(
        &json!({
            "name": "gradient",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": [[0, 0, 0]], "springs": [], "triangles": []}},
                "mass": {"nodal": mass},
                "gravity": [0, 0, -gravity],
                "aero": {"drag": [{"on": "all", "drag_area": drag_area}]}
            }},
            "time": {"end": h * f64::from(steps), "method": "euler-cromer", "step": h},
            "output": {"probes": [{"name": "body", "on": "all"}]},
            "study": {"quantities": ["body.vz.last", "body.vz.mean", "body.z@3.21"]}
        }),
        &[],
    );
    let report = found(&case, &["drag_area", "gravity.2", "mass.nodal"], 1, false).expect("derivatives");
    for (place, key) in ["drag_area", "gravity.2", "mass.nodal"].iter().enumerate() {
        let mut parameters = [drag_area, -gravity, mass].map(number);
        parameters[place].1 = 1.0;
        let [area, g, m] = parameters;
        let (mut z, mut v) = (number(0.0), number(0.0));
        let (mut sum, mut seen) = (number(0.0), number(0.0));
        for step in 1..=steps {
            let before = (z, v);
            v = v + number(h) * (g + number(0.5 * density) * area / m * v * v);
            z = z + number(h) * v;
            sum = sum + number(0.5) * (before.1 + v);
            let share = 3.21 / h - f64::from(step - 1);
            if (0.0..1.0).contains(&share) {
                seen = before.0 + number(share) * (z - before.0);
            }
        }
        let expected = [v, sum / number(f64::from(steps)), seen];
        for (quantity, expected) in report.quantities.iter().zip(expected) {
            let got = of(&report, &quantity.name, key);
            let value = quantity.value.expect("a value");
            assert!((value / expected.0 - 1.0).abs() < 1e-12, "{}: {value} for {}", quantity.name, expected.0);
            assert!((got / expected.1 - 1.0).abs() < 1e-9, "{} by {key}: {got} for {}", quantity.name, expected.1);
        }
    }
}

/// A taut net in the wind, with all kinds of numbers: smooth, nonlinear, damped, and not symmetric.
pub(crate) fn net(method: &Value) -> Case {
    case_of(
        &json!({
            "name": "gradient",
            "system": {"network": {
                "mesh": {"rectangle": {"width": 1.0, "height": 0.8, "columns": 3, "rows": 3, "pattern": "regular"}},
                "mass": {"areal_density": 0.3, "points": [{"on": {"ids": [5]}, "total": 0.05}]},
                "springs": [{"on": "all", "stiffness": 300.0, "rest_length": 0.2,
                             "dashpot": {"axial": {"time": 0.002}}}],
                "supports": [{"on": "boundary", "fix": "xyz"}],
                "gravity": [0, 0, -9.81],
                "initial": {"velocity": [0.1, 0, 0.3]},
                "loads": [{"on": "all", "pressure": 20.0, "table": [[0, 0.5], [1, 1]]},
                          {"on": {"ids": [6]}, "force": [0.3, 0.2, -0.4]}],
                "aero": {"wind": [6.0, 1.0, 2.0], "law": {"pressure_coefficient": {"cp": 1.0}},
                         "drag": [{"on": {"ids": [9]}, "drag_area": 0.02}]}
            }},
            "time": {"end": 0.05, "method": method, "step": 0.001},
            "solver": {"newton": {"relative": 1e-12}},
            "output": {
                "probes": [{"name": "middle", "on": {"ids": [5]}}],
                "gauges": [{"name": "all", "on": "all", "of": "tension"},
                           {"name": "rim", "on": "boundary", "of": "reaction"}]
            },
            "study": {"quantities": ["middle.z.last", "middle.vz.last", "all.tension_sum.last", "rim.reaction_z.mean",
                                     "middle.z@0.0253"]}
        }),
        &[],
    )
}

/// Of every method that has derivatives, by numbers of every kind, all are those of whole runs to 1e-7 of the largest
/// relative change that any of the numbers makes.
#[test]
fn derivatives_are_those_of_whole_runs() {
    let keys = [
        "springs.0.stiffness",
        "rest_length",
        "dashpot.axial.time",
        "areal_density",
        "points.0.total",
        "gravity.2",
        "velocity.2",
        "loads.0.pressure",
        "loads.1.force.0",
        "wind.0",
        "wind.2",
        "cp",
        "drag_area",
    ];
    let mut made = Vec::new();
    for info in methods() {
        let report = match found(&net(&json!(info.name)), &keys, 1, true) {
            Ok(report) => report,
            Err(error) => {
                assert!(error.to_string().contains("derivative of a step by"), "{}: {error}", info.name);
                continue;
            }
        };
        made.push(info.name);
        assert_eq!(report.steps, 50);
        for quantity in &report.quantities {
            let relative = |value: f64, at: f64| (value * at).abs();
            let largest = quantity.derivatives.iter().map(|of| relative(of.value, of.at)).fold(0.0, f64::max);
            for one in &quantity.derivatives {
                let by_runs = one.by_runs.expect("whole runs");
                let differs = relative(one.value - by_runs, one.at) / largest;
                let words = format!("{}: {} by {}: {} for {by_runs}", info.name, quantity.name, one.by, one.value);
                assert!(differs < 1e-7, "{words}, differs by {differs:.1e}");
                assert!(!one.one_sided && one.switching == 0.0, "{words}: {one:?}");
            }
        }
    }
    let without = ["kang", "multirate", "energy-momentum", "xpbd", "vbd"];
    let expected: Vec<&str> = methods().iter().map(|info| info.name).filter(|name| !without.contains(name)).collect();
    assert_eq!(made, expected);
}

/// A peak has the derivative of the step that it falls on, by every kind of scheme.
#[test]
fn peaks_have_the_derivative_of_their_step() {
    for method in
        ["newmark", "rk4", "velocity-verlet", "euler-cromer", "central-difference", "beeman", "esdirk4", "hht"]
    {
        let case = changed(
            &oscillator(method, 0.01, 100),
            &[
                ("system.network.gravity", "[9.81, 0, 0]"),
                ("output.gauges", r#"[{"name": "line", "on": "all", "of": "tension"}]"#),
                ("study.quantities", r#"["line.tension.peak"]"#),
                ("system.network.springs.0.rest_length", "1.25"),
            ],
        );
        let report = found(&case, &["stiffness", "nodal", "gravity.0", "rest_length"], 1, true).expect("derivatives");
        let peak = report.quantities.first().expect("the peak");
        assert!(peak.peak_time.is_some_and(|t| t > 0.1), "{method}: {peak:?}");
        for one in &peak.derivatives {
            let by_runs = one.by_runs.expect("whole runs");
            let differs = (one.value - by_runs).abs() * one.at.abs() / peak.value.expect("a value");
            assert!(differs < 1e-7, "{method}: by {}: {} for {by_runs}", one.by, one.value);
        }
    }
}

/// Parameters of methods, and a last step that is shorter than the others.
#[test]
fn methods_with_parameters_and_a_shorter_last_step_have_derivatives() {
    let methods = [
        json!({"newmark": {"beta": 0.3, "gamma": 0.6}}),
        json!({"hht": {"alpha": -0.3}}),
        json!({"generalized-alpha": {"rho_inf": 0.2}}),
    ];
    for method in methods {
        let case = changed(&net(&method), &[("time.end", "0.0303")]);
        let report = found(&case, &["springs.0.stiffness", "wind.0"], 1, true).expect("derivatives");
        for quantity in report.quantities {
            for one in quantity.derivatives {
                let by_runs = one.by_runs.expect("whole runs");
                assert!((one.value / by_runs - 1.0).abs() < 1e-6, "{method}: {} by {}: {one:?}", quantity.name, one.by);
            }
        }
    }
}

/// Newmark's derivatives cost one factorisation a step, however many numbers there are.
#[test]
fn a_step_has_one_factorisation_for_all_numbers() {
    let case = net(&json!("newmark"));
    for keys in [&["wind.0"][..], &["wind", "gravity", "springs.0.stiffness", "cp"][..]] {
        assert_eq!(found(&case, keys, 1, false).expect("derivatives").factorizations, 50);
    }
    assert_eq!(found(&net(&json!("rk4")), &["wind.0"], 1, false).expect("derivatives").factorizations, 0);
    assert_eq!(found(&net(&json!("esdirk4")), &["wind.0"], 1, false).expect("derivatives").factorizations, 250);
}

/// The same bytes on one thread and on two, with the numbers in any order.
#[test]
fn threads_and_company_change_no_byte() {
    let base = net(&json!("newmark"));
    let large = r#"{"rectangle": {"width": 1.0, "height": 0.8, "columns": 50, "rows": 45, "pattern": "regular"}}"#;
    let case = changed(
        &base,
        &[
            ("system.network.mesh", large),
            ("system.network.springs.0.rest_length", "null"),
            ("output.probes.0.on", "{\"ids\": [1200]}"),
            ("time.end", "0.004"),
            ("study.quantities", r#"["middle.z.last", "all.tension_max.peak"]"#),
        ],
    );
    let [one, two] = [1, 2].map(|threads| found(&case, &["wind.0", "cp"], threads, false).expect("derivatives"));
    assert_eq!(one, two);
    let alone = found(&case, &["cp"], 1, false).expect("derivatives");
    assert_eq!(of(&alone, "middle.z.last", "cp").to_bits(), of(&one, "middle.z.last", "cp").to_bits());
}

/// A support that lets go at a given time is a corner of the run, over which derivatives go on.
#[test]
fn derivatives_go_on_over_a_release() {
    for method in ["newmark", "generalized-alpha", "rk4", "central-difference", "improved-euler-pec", "beeman"] {
        let case = changed(&net(&json!(method)), &[("system.network.supports.0.until", "0.02")]);
        let case = changed(&case, &[("study.quantities", r#"["middle.z.last", "middle.vz.last"]"#)]);
        let report = found(&case, &["springs.0.stiffness", "wind.2"], 1, true).expect("derivatives");
        for quantity in report.quantities {
            for one in quantity.derivatives {
                let by_runs = one.by_runs.expect("whole runs");
                assert!((one.value / by_runs - 1.0).abs() < 1e-6, "{method}: {} by {}: {one:?}", quantity.name, one.by);
            }
        }
    }
}

/// A spring that is slack at its start and has no stiffness there by symmetry: a law that switches is told.
#[test]
fn laws_that_switch_within_the_differences_are_told() {
    let case = changed(&oscillator("rk4", 0.01, 1), &[("system.network.springs.0.slack", "\"tension-only\"")]);
    let at_rest = changed(&case, &[("system.network.springs.0.rest_length", "1.3")]);
    let report = found(&at_rest, &["rest_length"], 1, false).expect("derivatives");
    assert!(report.quantities[0].derivatives[0].switching > 0.0, "{report:?}");
    let taut = found(&case, &["rest_length"], 1, false).expect("derivatives");
    assert_eq!(taut.quantities[0].derivatives[0].switching, 0.0);
}

/// A mass between two equal springs: a force on it makes one of them the tighter one, to either side, so that the
/// largest tension has two derivatives, of opposite sign.
#[test]
fn the_largest_of_two_has_two_derivatives() {
    let case = case_of(
        &json!({
            "name": "between",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0], [2, 0, 0]], "springs": [[0, 1], [1, 2]],
                                      "triangles": []}},
                "mass": {"nodal": 0.5},
                "springs": [{"on": "all", "stiffness": 40.0, "rest_length": 0.8}],
                "supports": [{"on": {"ids": [0, 2]}, "fix": "xyz"}],
                "loads": [{"on": {"ids": [1]}, "force": [0.0, 0.0, 0.0]}]
            }},
            "time": {"end": 0.1, "method": "newmark", "step": 0.01},
            "output": {"probes": [{"name": "mass", "on": {"ids": [1]}}],
                       "gauges": [{"name": "both", "on": "all", "of": "tension"}]},
            "study": {"quantities": ["both.tension_max.last", "mass.x.last"]}
        }),
        &[],
    );
    let report = found(&case, &["loads.0.force.0"], 1, false).expect("derivatives");
    let moved = of(&report, "mass.x.last", "force.0");
    let one = &report.quantities[0].derivatives[0];
    let [below, above] = one.sides.expect("two derivatives");
    assert!(one.one_sided && moved > 0.0, "{one:?}");
    assert!((above / (40.0 * moved) - 1.0).abs() < 1e-6 && (below + above).abs() < 1e-6 * above, "{one:?} {moved}");
}

/// What has no derivative says so.
#[test]
fn what_has_no_derivative_says_so() {
    let base = net(&json!("newmark"));
    const KICK: &str = r#"[{"on": "boundary", "fix": "xyz", "motion": {"table": [[0, 0, 0, 0], [0.02, 0, 0, 0.01]]}}]"#;
    type Row = (&'static [(&'static str, &'static str)], &'static [&'static str], &'static str);
    let cases: [Row; 11] = [
        (&[], &["stiffnes"], "the case has no number there"),
        (&[], &["time.step"], "time.step is no part of the scene"),
        (&[], &["velocity.3", "nodal"], "the case has no number there"),
        (&[], &["mesh.rectangle.columns"], "is refused"),
        (
            &[("time.step", "null"), ("time.tolerance", "{\"relative\": 1e-4, \"absolute\": 1e-6}")],
            &["cp"],
            "time.step",
        ),
        (
            &[("time.method", "kang")],
            &["cp"],
            "the derivative of a step by kang is not known; methods that have one: e",
        ),
        (&[("time.method", "multirate")], &["cp"], "by multirate is not known"),
        (&[("study.quantities", "[\"energy.kinetic.peak\"]")], &["cp"], "energy.kinetic.peak has no derivative"),
        (&[("study.quantities", "[\"middle.z.peak_time\"]")], &["cp"], "it is a time, and falls on steps"),
        (&[("system.network.supports", KICK)], &["cp"], "a support gets another velocity"),
        (&[("system.network.supports.0.until", "0.02")], &["until"], "changes the times of events"),
    ];
    for (sets, by, words) in cases {
        let error = found(&changed(&base, sets), by, 1, false).expect_err(words).to_string();
        assert!(error.contains(words), "{words}: {error}");
    }
}
