//! The order of methods between contacts: what touches stays within its gap and off its closed part, so that all forces
//! are smooth. Friction of implicit steps is that of the pressures at their start, which costs them an order.
//! ```text
//! a mass on a plane:     z'' = g (-b'(z/g0) - cos a)                         kappa = m g/g0
//! it slides:             x'' = g (sin a + mu b'(z/g0))
//! two masses, pressed:   m u'' = -k (l - 1 + u) - kappa g0 b'(2 u/g0)         kappa = k/20, u half their gap
//! ```
//! References are solutions of these equations by a Runge-Kutta scheme of their own.

use super::{G, push, share_of_gap};
use crate::claim::Claim;
use crate::common::run::{case_of, run};
use canopy_fem::drive::Status;
use canopy_fem::integrate::registry::MethodChoice;
use serde_json::{Value, json};

/// [-] At these steps the next term of the error bends slopes by up to 0.03, as measured.
const TOLERANCE: f64 = 0.05;
/// [m]
const GAP: f64 = 1e-2;
/// [-] Share of the gap at the start: neither 0.4, from which on explicit contact is linear, nor 1 is reached.
const START: f64 = 0.66;
/// [s]
const END: f64 = 0.16;
/// [-], [m/s] friction, and speed along the slope at the start, with less energy than a fall through the gap
const MU: f64 = 0.3;
const SPEED: f64 = 0.3;
/// [N/m], [kg] springs and masses of a pair
const STIFFNESS: f64 = 100.0;
const MASS: f64 = 0.1;
/// [-] share of its gap at rest
const PRESSED: f64 = 0.6;

/// Positions and speeds after `END` of y'' = a(y), by steps that leave rounding only.
fn exact<const N: usize>(mut y: [f64; N], mut v: [f64; N], a: impl Fn([f64; N]) -> [f64; N]) -> [[f64; N]; 2] {
    let steps = 40_000;
    let h = END / f64::from(steps);
    let add = |y: [f64; N], by: f64, k: [f64; N]| std::array::from_fn(|i| y[i] + by * k[i]);
    for _ in 0..steps {
        let (v1, a1) = (v, a(y));
        let (v2, a2) = (add(v, 0.5 * h, a1), a(add(y, 0.5 * h, v1)));
        let (v3, a3) = (add(v, 0.5 * h, a2), a(add(y, 0.5 * h, v2)));
        let (v4, a4) = (add(v, h, a3), a(add(y, h, v3)));
        y = std::array::from_fn(|i| y[i] + h / 6.0 * (v1[i] + 2.0 * v2[i] + 2.0 * v3[i] + v4[i]));
        v = std::array::from_fn(|i| v[i] + h / 6.0 * (a1[i] + 2.0 * a2[i] + 2.0 * a3[i] + a4[i]));
    }
    [y, v]
}

/// A case, its free node, and where that is at the end, with its velocity: along x and z.
struct Motion {
    case: Value,
    node: usize,
    end: [[f64; 2]; 2],
    /// which of these count
    counts: [bool; 2],
    /// [1/s] rate by which speeds count
    rate: f64,
}

/// A mass that sways on a plane, inclined by the angle a; with friction it slides down.
fn on_plane(tangent: f64, mu: f64) -> Motion {
    let (sin, cos) = tangent.atan().sin_cos();
    let speed = if mu > 0.0 { SPEED } else { 0.0 };
    let case = json!({
        "name": "sways",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0.0, 0.0, START * GAP]]}},
            "mass": {"nodal": [2.0]},
            "gravity": [G * sin, 0.0, -G * cos],
            "contact": [{"between": ["all", super::ground()], "gap": GAP, "friction": mu}],
            "initial": {"velocity": [[speed, 0.0, 0.0]]}
        }}
    });
    let acceleration = |[_, z]: [f64; 2]| [G * (sin - mu * push(z / GAP)), G * (push(z / GAP) - cos)];
    let end = exact([0.0, START * GAP], [speed, 0.0], acceleration);
    Motion { case, node: 0, end, counts: [mu > 0.0, mu == 0.0], rate: (G / GAP).sqrt() }
}

/// Two masses between held ends, pressed on each other by springs.
fn pressed() -> Motion {
    let kappa = STIFFNESS / 20.0;
    let half = 0.5 * START * GAP;
    // The rest length with which they rest at a share of the gap, and the force of a spring.
    let rest = 1.0 - 0.5 * PRESSED * GAP + kappa * GAP * push(PRESSED) / STIFFNESS;
    let case = json!({
        "name": "pressed",
        "system": {"network": {
            "mesh": {"explicit": {
                "nodes": [[-1.0, 0.0, 0.0], [-half, 0.0, 0.0], [half, 0.0, 0.0], [1.0, 0.0, 0.0]],
                "springs": [[0, 1], [2, 3]],
                "groups": {"left": {"nodes": [1]}, "right": {"nodes": [2]}}
            }},
            "mass": {"nodal": MASS},
            "springs": [{"on": "all", "stiffness": STIFFNESS, "rest_scale": rest / (1.0 - half)}],
            "supports": [{"on": {"ids": [0, 3]}, "fix": "xyz"}],
            "contact": [{"between": ["left", "right"], "gap": GAP}]
        }}
    });
    let acceleration =
        |[x, _]: [f64; 2]| [(STIFFNESS * (rest - 1.0 - x) - kappa * GAP * push(-2.0 * x / GAP)) / MASS, 0.0];
    let end = exact([-half, 0.0], [0.0; 2], acceleration);
    Motion { case, node: 1, end, counts: [true, false], rate: (STIFFNESS / MASS).sqrt() }
}

impl Motion {
    /// [-] How far a run ends from the solution, over the gap.
    fn error(&self, method: &Value, step: f64) -> f64 {
        let mut case = self.case.clone();
        case["time"] = json!({"end": END, "method": method, "step": step});
        // Means over a step are quotients of differences, and lose digits.
        let relative = if method == "energy-momentum" { 1e-9 } else { 1e-11 };
        case["solver"] = json!({"newton": {"relative": relative}});
        let run = run(&case_of(&case, &[]));
        assert_eq!(run.outcome.status, Status::Completed, "{method} at {step}: {:?}", run.outcome.failure);
        let (x, v, [y, w]) = (run.positions[self.node], run.velocities[self.node], self.end);
        let apart = |i: usize, axis: usize| (x[axis] - y[i]).hypot((v[axis] - w[i]) / self.rate);
        let all = [(0, 0), (1, 2)].map(|(i, axis)| if self.counts[i] { apart(i, axis) } else { 0.0 });
        all[0].hypot(all[1]) / GAP
    }

    /// [-] The order, from a step and its half and quarter, with these errors.
    fn order(&self, method: &Value, step: f64) -> (f64, [f64; 3]) {
        let errors = [step, 0.5 * step, 0.25 * step].map(|step| self.error(method, step));
        (0.5 * (errors[0] / errors[2]).log2(), errors)
    }
}

/// [s] The longest step of a measurement: short enough for the tolerance, long enough for rounding.
fn longest(order: u32) -> f64 {
    match order {
        1 => 2e-5,
        2 => 5e-4,
        4 => 1e-3,
        _ => 2e-3,
    }
}

fn claim(what: &str, motion: &Motion, method: &Value, order: u32) -> Claim {
    let name = crate::linear_theory::method_name(method);
    let (measured, errors) = motion.order(method, longest(order));
    let step = longest(order);
    let what = format!("{name}: {what}, h = {step:.0e} s and less, error {:.1e} of the gap: order", errors[0]);
    Claim::absolute(what, measured, f64::from(order), TOLERANCE)
}

fn methods() -> Vec<(Value, u32)> {
    let named = [
        "newmark",
        "hht",
        "backward-euler",
        "generalized-alpha",
        "esdirk4",
        "energy-momentum",
        "velocity-verlet",
        "explicit-euler",
        "euler-cromer",
        "improved-euler",
        "euler-richardson",
        "rk4",
        "dormand-prince",
    ];
    let declared = |name: &str| MethodChoice::with_defaults(name).map_or(0, |method| method.info.order);
    let without_damping = (json!({"hht": {"alpha": 0.0}}), 2);
    named.map(|name| (json!(name), declared(name))).into_iter().chain([without_damping]).collect()
}

pub fn smooth() -> Vec<Claim> {
    let (mass, pair) = (on_plane(0.0, 0.0), pressed());
    let claims = methods().into_iter().flat_map(|(method, order)| {
        [
            claim("a mass sways on a plane", &mass, &method, order),
            claim("two masses are pressed", &pair, &method, order),
        ]
    });
    let rests = share_of_gap(1.0);
    claims.chain([Claim::between("share of the gap at which the mass rests [-]", rests, 0.4, START)]).collect()
}

pub fn with_friction() -> Vec<Claim> {
    let slides = on_plane(0.5, MU);
    let of = |name: &str, order: u32| claim("a mass sways and slides, mu = 0.3", &slides, &json!(name), order);
    let implicit = ["newmark", "hht", "backward-euler", "generalized-alpha", "energy-momentum"];
    let explicit = [("velocity-verlet", 2), ("improved-euler", 2), ("rk4", 4)];
    implicit.map(|name| of(name, 1)).into_iter().chain(explicit.map(|(name, order)| of(name, order))).collect()
}
