//! Supports that move and a base that accelerates, against closed forms. A mass m on a spring k along x, w^2 = k/m:
//! ```text
//! support at V t:             y(t) = V t - V/w sin(w t)
//! base with a(t) = s t:       y(t) = -s/w^2 (t - sin(w t)/w)         (Duhamel's integral; y relative to the base)
//! ```

use crate::claim::Claim;
use crate::common::run::{Run, case_of, run, run_with};
use canopy_fem::integrate::registry::{Family, methods};
use canopy_fem::simulation::build_scene;
use serde_json::{Value, json};

/// [N/m], [kg], [s] stiffness, mass and end
const K: f64 = 50.0;
const M: f64 = 2.0;
const END: f64 = 1.0;
/// [m/s], [s] speed of the support, and when it stops: within a step
const V: f64 = 0.4;
const STOP: f64 = 0.4373;
/// [m/s^2], [s] peak of the base's acceleration, its time and its end: at ends of steps
const PEAK: f64 = 3.0;
const PULSE: [f64; 2] = [0.25, 0.625];

fn w() -> f64 {
    (K / M).sqrt()
}

pub fn timed(method: &str, step: f64) -> Value {
    json!({"end": END, "method": method, "step": step})
}

pub fn adaptive(method: &str, tolerance: f64) -> Value {
    json!({"end": END, "method": method, "tolerance": {"relative": tolerance, "absolute": 0.1 * tolerance}})
}

/// A mass on a spring from an anchor of the mass `held` [kg].
fn oscillator(support: Value, held: f64, time: Value) -> Value {
    json!({
        "name": "oscillator",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0]], "springs": [[0, 1]]}},
            "mass": {"nodal": [held, M]},
            "springs": [{"on": "all", "stiffness": K}],
            "supports": [support]
        }},
        "time": time
    })
}

fn moved(table: Value, held: f64, time: Value) -> Value {
    oscillator(json!({"on": {"ids": [0]}, "fix": "xyz", "motion": {"table": table}}), held, time)
}

/// A support that moves with V until it stops.
fn ramp(stop: f64, held: f64, time: Value) -> Value {
    moved(json!([[0, 0, 0, 0], [stop, V * stop, 0, 0]]), held, time)
}

/// [m], [m/s] the mass at the end, from its start; and [J] its energy with the spring's.
fn after_ramp(stop: f64) -> [f64; 3] {
    let (w, u) = (w(), V * stop);
    let (d, v) = (V * stop - V / w * (w * stop).sin() - u, V * (1.0 - (w * stop).cos()));
    let angle = w * (END - stop);
    let y = u + d * angle.cos() + v / w * angle.sin();
    [y, v * angle.cos() - d * w * angle.sin(), 0.5 * M * v * v + 0.5 * K * d * d]
}

fn shaken(table: Value, time: Value) -> Value {
    let mut case = oscillator(json!({"on": {"ids": [0]}, "fix": "xyz"}), M, time);
    case["system"]["network"]["base_acceleration"] = json!({"table": table});
    case
}

fn pulse() -> Value {
    json!([[0, 0, 0, 0], [PULSE[0], PEAK, 0, 0], [PULSE[1], 0, 0, 0]])
}

/// [m] of the mass at the end of the pulse, relative to the base.
fn after_pulse() -> f64 {
    let (up, down) = (PEAK / PULSE[0], -PEAK / (PULSE[1] - PULSE[0]));
    let ramp = |slope: f64, t: f64| -slope / (w() * w()) * (t - (w() * t).sin() / w());
    ramp(up, END) + ramp(down - up, END - PULSE[0]) + ramp(-down, END - PULSE[1])
}

fn x(ran: &Run) -> f64 {
    ran.positions[1][0] - 1.0
}

/// Errors of a case in steps h, h/2: the order between them.
pub fn order_of(case: &dyn Fn(f64) -> Value, step: f64, error: &dyn Fn(&Run) -> f64) -> f64 {
    let [coarse, fine] = [step, 0.5 * step].map(|h| error(&run(&case_of(&case(h), &[]))).abs());
    (coarse / fine).log2()
}

pub fn claims() -> Vec<Claim> {
    let mut claims = every_method();
    claims.extend(orders());
    claims.extend(accounts());
    claims.extend(directions());
    claims.extend(dense());
    claims.extend(threads());
    claims
}

fn every_method() -> Vec<Claim> {
    let mut claims = Vec::new();
    for method in methods() {
        let name = method.name;
        let low = case_of(&ramp(STOP, M, timed(name, 5e-4)), &[]).problem().method.order() == 1;
        let tolerance = if low || method.family == Family::MatrixFree { 2e-3 } else { 2e-6 };
        let ran = run(&case_of(&ramp(STOP, M, timed(name, 5e-4)), &[]));
        claims.push(Claim::absolute(
            format!("{name}: a support drags a mass [m]"),
            x(&ran),
            after_ramp(STOP)[0],
            tolerance,
        ));
        let held = ran.positions[0];
        claims.push(Claim::absolute(
            format!("{name}: the support is where its table says [m]"),
            held[0],
            V * STOP,
            1e-15,
        ));
        claims.push(Claim::is(format!("{name}: and stands still"), ran.velocities[0] == [0.0; 3]));
        let ran = run(&case_of(&shaken(pulse(), timed(name, 5e-4)), &[]));
        claims.push(Claim::absolute(format!("{name}: a base shakes a mass [m]"), x(&ran), after_pulse(), tolerance));
    }
    for (name, tolerance) in [
        ("velocity-verlet", 1e-6),
        ("newmark", 1e-6),
        ("energy-momentum", 1e-6),
        ("generalized-alpha", 1e-6),
        ("dormand-prince", 1e-9),
        ("kang", 1e-4),
    ] {
        let ran = run(&case_of(&ramp(STOP, M, adaptive(name, tolerance)), &[]));
        let off = x(&ran) - after_ramp(STOP)[0];
        claims.push(Claim::below(format!("{name}, adaptive: a support drags a mass [m]"), off, 10.0 * tolerance));
        let ran = run(&case_of(&shaken(pulse(), adaptive(name, tolerance)), &[]));
        claims.push(Claim::below(
            format!("{name}, adaptive: a base shakes a mass [m]"),
            x(&ran) - after_pulse(),
            10.0 * tolerance,
        ));
    }
    claims
}

fn orders() -> Vec<Claim> {
    let mut claims = Vec::new();
    let list = [
        ("explicit-euler", 1.0, 1e-3),
        ("improved-euler-pec", 2.0, 2e-3),
        ("velocity-verlet", 2.0, 0.01),
        ("beeman", 3.0, 0.01),
        ("central-difference", 2.0, 0.01),
        ("multirate", 2.0, 0.01),
        ("newmark", 2.0, 0.01),
        ("energy-momentum", 2.0, 0.01),
        ("hht", 2.0, 5e-3),
        ("generalized-alpha", 2.0, 5e-3),
        ("rk4", 4.0, 0.015625),
        ("esdirk4", 4.0, 0.015625),
    ];
    for (name, order, step) in list {
        // Steps beside an event within a step are shorter, and differently so for h and h/2.
        for (stop, where_, tolerance) in [(0.5, "at the end of a step", 0.15), (STOP, "within a step", 0.6)] {
            let found = order_of(&|h| ramp(stop, M, timed(name, h)), step, &|ran| x(ran) - after_ramp(stop)[0]);
            claims.push(Claim::absolute(
                format!("{name}: order where a support stops {where_}"),
                found,
                order,
                tolerance,
            ));
        }
        if order < 2.0 {
            // Its leading error vanishes close to the end.
            continue;
        }
        // Rows at the ends of steps.
        let step = 0.125 / (0.125 / step.min(5e-3).max(if order > 3.0 { 0.015625 } else { 0.0 })).round();
        let found = order_of(&|h| shaken(pulse(), timed(name, h)), step, &|ran| x(ran) - after_pulse());
        claims.push(Claim::absolute(format!("{name}: order of the answer to a base"), found, order, 0.2));
    }
    claims
}

fn accounts() -> Vec<Claim> {
    let mut claims = Vec::new();
    let energy = after_ramp(STOP)[2];
    for (held, what) in [(0.0, "without mass"), (3.0, "of 3 kg")] {
        let ran = run(&case_of(&ramp(STOP, held, timed("rk4", 0.002)), &[]));
        // What stops a moving mass takes its energy back.
        let work = energy - 0.5 * held * V * V;
        claims.push(Claim::relative(
            format!("work of a support {what} [J]"),
            ran.outcome.ledger.external_work,
            work,
            1e-8,
        ));
        claims.push(Claim::below(
            format!("rk4: the ledger closes over its motion {what} [J]"),
            ran.outcome.ledger.numerical,
            1e-10,
        ));
    }
    for (name, bound) in [("newmark", 1e-12), ("velocity-verlet", 2e-5), ("dop853", 1e-13)] {
        let ran = run(&case_of(&ramp(STOP, M, timed(name, 0.002)), &[]));
        claims.push(Claim::below(
            format!("{name}: the ledger closes over a motion [J]"),
            ran.outcome.ledger.numerical,
            bound,
        ));
        let ran = run(&case_of(&shaken(pulse(), timed(name, 1.0 / 512.0)), &[]));
        claims.push(Claim::below(
            format!("{name}: the ledger closes on a base [J]"),
            ran.outcome.ledger.numerical,
            bound,
        ));
    }
    let mut damped = ramp(STOP, M, timed("rk4", 0.002));
    damped["system"]["network"]["springs"][0]["dashpot"] = json!({"relative": {"coefficient": 3.0}});
    damped["system"]["network"]["gravity"] = json!([1.0, 0.0, 0.0]);
    let ran = run(&case_of(&damped, &[]));
    claims.push(Claim::below(
        "rk4: the ledger closes with a dashpot and weight [J]",
        ran.outcome.ledger.numerical,
        1e-9,
    ));
    // What a support pulls with at the end: the spring's tension, without the mass of its own node.
    let case = case_of(&ramp(STOP, 3.0, timed("rk4", 0.002)), &[]);
    let ran = run(&case);
    let scene = build_scene(case.problem().system.clone(), 1).expect("the case is good");
    let (mut forces, mut reactions) = (scene.new_forces(), vec![[0.0; 3]; 2]);
    scene.evaluate(ran.state.as_ref(), &mut forces);
    scene.node_reactions(&forces, &mut reactions);
    let pull = -K * (after_ramp(STOP)[0] - V * STOP);
    claims.push(Claim::relative("rk4: reaction of a support that has moved [N]", reactions[0][0], pull, 1e-6));
    claims
}

/// Supports that move some directions, or until they let go.
fn directions() -> Vec<Claim> {
    let case = |method: &str| {
        json!({
            "name": "carried",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": [[0, 0, 0], [3, 1, 2], [5, 5, 5]]}},
                "mass": {"nodal": 1.5},
                "supports": [{"on": {"ids": [0]}, "fix": "x", "motion": {"table": [[0, 0, 0, 0], [2, 2, 0, 0]]}},
                             {"on": {"ids": [1]}, "fix": "xyz", "until": 0.3,
                              "motion": {"table": [[-1, 1, 0, -2], [1, -1, 0, 2]]}}],
                "gravity": [0, 0, -10],
                "initial": {"velocity": [[1, 0.5, 0], [-1, 0, 2], [0, 0, 0]]}
            }},
            "time": timed(method, 0.01)
        })
    };
    let mut claims = Vec::new();
    for name in ["velocity-verlet", "newmark", "rk4", "hht", "energy-momentum"] {
        let ran = run(&case_of(&case(name), &[]));
        let [x, y, z] = ran.positions[0];
        claims.push(Claim::absolute(format!("{name}: driven along x [m]"), x, 1.0, 1e-13));
        claims.push(Claim::absolute(format!("{name}: free along y [m]"), y, 0.5, 1e-12));
        claims.push(Claim::absolute(format!("{name}: falls along z meanwhile [m]"), z, -5.0, 1e-10));
        let (thrown, t) = (ran.positions[1], 0.7);
        claims.push(Claim::absolute(format!("{name}: thrown by its support, along x [m]"), thrown[0], 2.0, 1e-12));
        let height = 2.0 + 2.0 - 5.0 * t * t;
        claims.push(Claim::absolute(format!("{name}: thrown by its support, along z [m]"), thrown[2], height, 1e-10));
    }
    claims
}

/// A table with a row a step: a sine as displacement, and a base whose acceleration is constant as a motion.
fn dense() -> Vec<Claim> {
    let (drive, amplitude) = (3.0, 0.1);
    let rows = |h: f64, u: &dyn Fn(f64) -> f64| -> Value {
        let n = (END / h).round() as usize;
        (0..=n).map(|i| json!([i as f64 * h, u(i as f64 * h), 0, 0])).collect()
    };
    let sine = |t: f64| amplitude * (drive * t).sin();
    let ratio = drive / w();
    // y = A/(1 - r^2) (sin(W t) - r sin(w t)).
    let exact = amplitude / (1.0 - ratio * ratio) * ((drive * END).sin() - ratio * (w() * END).sin());
    let mut claims = Vec::new();
    for name in ["velocity-verlet", "newmark", "hht", "generalized-alpha", "improved-euler", "energy-momentum"] {
        let case = |h: f64| moved(rows(h, &sine), M, timed(name, h));
        let found = order_of(&case, 1.0 / 128.0, &|ran| x(ran) - exact);
        claims.push(Claim::absolute(format!("{name}: order with a row a step"), found, 2.0, 0.25));
    }
    let (g, h) = (2.0, 1.0 / 512.0);
    let carried = run(&case_of(&moved(rows(h, &|t| 0.5 * g * t * t), M, timed("newmark", h)), &[]));
    let shaken = run(&case_of(&shaken(json!([[0, g, 0, 0]]), timed("newmark", h)), &[]));
    let relative = carried.positions[1][0] - carried.positions[0][0] - 1.0;
    claims.push(Claim::absolute("a base that accelerates is a support that moves [m]", x(&shaken), relative, 2e-5));
    let exact = -g / (w() * w()) * (1.0 - (w() * END).cos());
    claims.push(Claim::absolute("newmark: a constant acceleration of the base [m]", x(&shaken), exact, 2e-5));
    claims
}

/// A cloth between two sides, one of which moves, on a base that shakes.
fn threads() -> Vec<Claim> {
    let case = |method: &str| {
        json!({
            "name": "pulled",
            "system": {"network": {
                "mesh": {"rectangle": {"width": 2.0, "height": 1.0, "columns": 60, "rows": 30, "pattern": "regular"}},
                "mass": {"areal_density": 0.3},
                "springs": [{"on": "all", "stiffness": 300.0, "dashpot": {"axial": {"time": 1e-3}}}],
                "supports": [{"on": {"box": [[-9, -9, -9], [0.01, 9, 9]]}, "fix": "xyz"},
                             {"on": {"box": [[1.99, -9, -9], [9, 9, 9]]}, "fix": "xyz",
                              "motion": {"table": [[0, 0, 0, 0], [0.0131, 0.02, 0, 0.01], [0.02, 0.01, 0, 0]]}}],
                "base_acceleration": {"table": [[0, 0, 0, 0], [0.01, 0, 0, 9], [0.02, 0, 0, -9]]},
                "gravity": [0, 0, -9.81]
            }},
            "time": {"end": 0.03, "method": method, "step": 0.001}
        })
    };
    let mut claims = Vec::new();
    for name in ["velocity-verlet", "newmark"] {
        let [one, two] = [1, 2].map(|threads| run_with(&case_of(&case(name), &[]), threads));
        claims.push(Claim::is(format!("{name}: on two threads to the bit"), one.state == two.state));
        claims.push(Claim::is(format!("{name}: and so is the ledger"), one.outcome.ledger == two.outcome.ledger));
    }
    claims
}
