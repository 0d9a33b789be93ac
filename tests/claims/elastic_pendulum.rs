//! elastic pendulum
use crate::claim::Claim;
use crate::common::run::{case_of, changed, follow};
use serde_json::{Value, json};

const MASS: f64 = 10.0;
const LENGTH: f64 = 3.0443;
const SPEED: f64 = 7.72;

fn pendulum(rigidity: f64, rest: f64) -> Value {
    json!({
        "name": "elastic",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [LENGTH, 0, 0]], "springs": [[0, 1]]}},
            "mass": {"nodal": [0.0, MASS]},
            "springs": [{"on": "all", "stiffness": rigidity / LENGTH, "rest_length": rest}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
            "initial": {"velocity": [[0, 0, 0], [0, SPEED, 0]]}
        }},
        "time": {"end": 1.0, "method": "newmark", "step": 0.01}
    })
}

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    for ea in [1e4, 1e10] {
        for eq in [true, false] {
            let k = ea / LENGTH;
            let rest = if eq { LENGTH - MASS * SPEED * SPEED / LENGTH / k } else { LENGTH };
            let base = case_of(&pendulum(ea, rest), &[]);
            for m in [
                "newmark",
                "hht",
                "generalized-alpha",
                "velocity-verlet",
                "rk4",
                "backward-euler",
                "{\"hht\":{\"alpha\":-0.3}}",
                "{\"generalized-alpha\":{\"rho_inf\":0.0}}",
            ] {
                for h in [0.02, 0.01, 0.005, 1e-4] {
                    let explicit = m == "rk4" || m == "velocity-verlet";
                    if (ea > 1e9) && explicit != (h < 2e-4) {
                        continue;
                    }
                    if ea < 1e9 && h < 2e-4 {
                        continue;
                    }
                    let end = if h < 2e-4 { 24.8 } else { 248.0 };
                    let case = changed(
                        &base,
                        &[("time.method", m), ("time.step", &h.to_string()), ("time.end", &end.to_string())],
                    );
                    let (mut l, mut e, mut r, mut ang, mut turns, mut lt) =
                        (vec![], vec![], vec![], 0.0_f64, 0.0, vec![]);
                    let out = follow(&case, |s| {
                        let (x, v) = (s.positions[1], s.velocities[1]);
                        let d = x[0].hypot(x[1]);
                        l.push((x[0] * v[1] - x[1] * v[0]) / LENGTH / SPEED - 1.0);
                        let a = -k * (d - rest) / MASS / d;
                        lt.push(
                            (x[0] * v[1] - x[1] * v[0] + h * h / 4.0 * a * (v[0] * x[1] - v[1] * x[0]))
                                / LENGTH
                                / SPEED
                                - 1.0,
                        );
                        e.push((s.ledger.kinetic + s.ledger.elastic) / (0.5 * MASS * SPEED * SPEED));
                        r.push(d / LENGTH);
                        let now = x[1].atan2(x[0]);
                        if now - ang < -3.0 {
                            turns += 1.0;
                        }
                        ang = now;
                    });
                    let mx = |v: &[f64]| v.iter().fold(f64::NEG_INFINITY, |m: f64, x| m.max(*x));
                    let mn = |v: &[f64]| v.iter().fold(f64::INFINITY, |m: f64, x| m.min(*x));
                    let n = l.len();
                    let t_end = out.t_end;
                    println!(
                        "{ea:e} eq {eq} {m} h {h}: {:?} t {} it {} L {:.3e} [{:.2e} {:.2e}] lt spread {:.2e} E end {:.6} max {:.6} E-E0 end {:.3e} r [{:.6} {:.6}] ang err {:.4e} {}",
                        out.status,
                        t_end,
                        out.counters.newton_iterations / out.steps.max(1),
                        l[n - 1],
                        mn(&l),
                        mx(&l),
                        mx(&lt) - mn(&lt),
                        e[n - 1],
                        mx(&e),
                        e[n - 1] - e[0],
                        mn(&r),
                        mx(&r),
                        turns * std::f64::consts::TAU + ang - SPEED / LENGTH * t_end,
                        out.failure.map_or(String::new(), |f| f.cause)
                    );
                }
            }
        }
    }
    claims.push(Claim::below("", 0.0, 1.0));
    claims
}
