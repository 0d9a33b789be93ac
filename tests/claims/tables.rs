//! Orders under loads that are given as tables. Steps that end at the corners leave the load smooth within steps, and
//! every method has its own order, two-sided. Corners within steps leave order two to all of order two and more, and
//! order one to the others; errors depend on where in a step a corner lies, so they are root mean squares over
//! placements.

use crate::claim::Claim;
use crate::common::run::{case_of, run};
use canopy_fem::drive::Status;
use canopy_fem::integrate::registry::methods;
use serde_json::{Value, json};

/// Two masses in a row on springs, pushed across and along: large rotations, w from 6 to 16 rad/s.
fn case(table: &[[f64; 2]], method: &str, time: &Value) -> Value {
    let mut all = json!({
        "name": "tabled",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0], [2, 0, 0]], "springs": [[0, 1], [1, 2]]}},
            "mass": {"nodal": 1.0},
            "springs": [{"on": "all", "stiffness": 100.0, "rest_length": 0.8}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "loads": [{"on": {"ids": [2]}, "force": [6.0, 9.0, -3.0], "table": table}]
        }},
        "time": {"end": 1.0, "method": method}
    });
    for (key, value) in time.as_object().into_iter().flatten() {
        all["time"][key] = value.clone();
    }
    all
}

/// [m, m/s] Positions and velocities at the end.
fn end_state(table: &[[f64; 2]], method: &str, time: &Value) -> Vec<f64> {
    let run = run(&case_of(&case(table, method, time), &[]));
    assert_eq!(run.outcome.status, Status::Completed, "{method}: {:?}", run.outcome.failure);
    run.positions.iter().chain(&run.velocities).flatten().copied().collect()
}

fn fixed(refinement: i32) -> Value {
    json!({"step": (-f64::from(refinement)).exp2()})
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
}

/// Corners at eighths of a second.
const MET: [[f64; 2]; 5] = [[0.0, 0.0], [0.125, 1.0], [0.375, 1.0], [0.5, -0.5], [0.75, 0.0]];

fn met_corners(claims: &mut Vec<Claim>) {
    let (reference, other) = (end_state(&MET, "dop853", &fixed(9)), end_state(&MET, "dormand-prince", &fixed(11)));
    let own = distance(&reference, &other);
    claims.push(Claim::below("corners at the ends of steps: the reference's own error [m, m/s]", own, 1e-12));
    for method in methods() {
        // Nothing depends on velocity here, so central differences are velocity Verlet.
        let order = if ["central-difference", "multirate"].contains(&method.name) { 2 } else { method.order };
        // Deep enough for the next term of the error, coarse enough for the reference.
        let first = match order {
            1 => 13,
            2 => 10,
            3..=4 => 8,
            5..=7 => 8,
            _ => 4,
        };
        let errors = [0, 1].map(|k| distance(&end_state(&MET, method.name, &fixed(first + k)), &reference));
        assert!(errors[1] > 30.0 * own, "{}: {errors:?} against {own:e}", method.name);
        claims.push(Claim::absolute(
            format!("{}: order, corners at the ends of steps", method.name),
            (errors[0] / errors[1]).log2(),
            f64::from(order),
            // The fifth-order term of Dormand & Prince is small: the next one still bends its slope.
            if method.order == 5 { 0.3 } else { 0.15 },
        ));
    }
}

/// Ramps, and a load that comes on within 1 us, all `by` later [s].
fn unmet(by: f64) -> [Vec<[f64; 2]>; 2] {
    let ramps = [[0.0, 0.0], [0.03, 0.0], [0.15, 1.0], [0.37, 1.0], [0.51, -0.5], [0.77, 0.0]];
    let jump = [[0.0, 0.0], [0.3, 0.0], [0.300001, 1.0]];
    let later = |table: &[[f64; 2]]| table.iter().map(|[t, g]| [if *t > 0.0 { t + by } else { 0.0 }, *g]).collect();
    [later(&ramps), later(&jump)]
}

/// Placements over which errors are averaged.
const PLACEMENTS: u32 = 12;

fn unmet_corners(claims: &mut Vec<Claim>) {
    let placed: Vec<[Vec<[f64; 2]>; 2]> = (0..PLACEMENTS).map(|i| unmet(0.001_237 * f64::from(i))).collect();
    for (which, what) in ["ramps", "a jump"].into_iter().enumerate() {
        // Adaptive steps end at the corners.
        let tight = json!({"tolerance": {"relative": 1e-11, "absolute": 1e-13}});
        let references: Vec<Vec<f64>> = placed.iter().map(|t| end_state(&t[which], "dop853", &tight)).collect();
        for method in methods() {
            let error = |refinement: i32| {
                let squares = placed.iter().zip(&references).map(|(table, reference)| {
                    distance(&end_state(&table[which], method.name, &fixed(refinement)), reference).powi(2)
                });
                (squares.sum::<f64>() / f64::from(PLACEMENTS)).sqrt()
            };
            let (coarse, fine) = match method.order {
                1 => (10, 13),
                2 => (7, 10),
                _ => (6, 10),
            };
            let slope = (error(coarse) / error(fine)).log2() / f64::from(fine - coarse);
            let least = f64::from(method.order.min(2));
            let name = format!("{}: order, {what} with corners within steps", method.name);
            // Above: a method of high order meets a ramp's corners with the third-order error of their moments.
            claims.push(Claim::between(name, slope, least - 0.15, f64::from(method.order.max(3)) + 0.5));
        }
    }
}

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    met_corners(&mut claims);
    unmet_corners(&mut claims);
    claims
}
