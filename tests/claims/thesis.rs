//! What the thesis' parachute and its remarks come to (`examples/thesis` shows the same with figures).

use crate::claim::Claim;
use crate::common::run::{asset, changed, follow, follow_on};
use canopy_fem::analysis::limit::critical_step;
use canopy_fem::analysis::spectrum::Spectrum;
use canopy_fem::case::Case;
use canopy_fem::drive::{Outcome, Status};
use canopy_fem::simulation::build_scene;

/// Table 4: step 1e-12 s, V = 1e12 m/s. A time of divergence is known to the step.
pub fn table_4() -> Vec<Claim> {
    let base = asset("parachute-original", &[]);
    let solved = |method: &str, step: &str, strategy: &str| -> Outcome {
        let sets = [("time.method", method), ("time.step", step), ("solver.newton.strategy", strategy)];
        follow_on(&changed(&base, &sets), |_| {})
    };
    let end = |method: &str, step: &str| solved(method, step, "auto");
    let mut claims = Vec::new();
    let printed =
        [("velocity-verlet", 3.4e-11), ("rk4", 3.4e-11), ("euler-cromer", 3.4e-11), ("euler-richardson", 3.2e-11)];
    for (method, printed) in printed {
        let failure = end(method, "1e-12").failure.unwrap_or_default();
        // The thesis gives no mass and no porosity; other meshes, masses and porosities near ours scatter by a tenth.
        claims.push(Claim::relative(
            format!("{method}: diverges [s]"),
            failure.blow_up_time.unwrap_or(f64::NAN),
            printed,
            0.1,
        ));
        let air = failure.term.as_deref() == Some("air");
        claims.push(Claim::is(format!("{method}: the report names the air"), air));
    }
    let kang = end("kang", "1e-12").failure.unwrap_or_default();
    claims.push(Claim::between(
        "kang (not in Table 4): diverges with the others [s]",
        kang.blow_up_time.unwrap_or(f64::NAN),
        3.0e-11,
        3.9e-11,
    ));
    // Where a thesis' number is missed, the row says by how much.
    let euler = end("explicit-euler", "1e-12").failure.unwrap_or_default();
    claims.push(Claim::between(
        "explicit-euler: NOT reproduced, time over the thesis' 3.3e-11 s",
        euler.blow_up_time.unwrap_or(f64::NAN) / 3.3e-11,
        1.2,
        1.6,
    ));
    for method in ["improved-euler", "improved-euler-pec"] {
        let time = end(method, "1e-12").failure.and_then(|f| f.blow_up_time).unwrap_or(f64::NAN);
        claims.push(Claim::between(format!("{method}: diverges with the others [s]"), time, 3.0e-11, 3.9e-11));
        claims.push(Claim::between(
            format!("{method}: NOT reproduced, time over the thesis' 1.16e-10 s"),
            time / 1.16e-10,
            0.2,
            0.4,
        ));
    }
    for method in ["newmark", "hht", "generalized-alpha"] {
        let kept = end(method, "1e-12");
        claims.push(Claim::relative(
            format!("{method} with a kept factor: completes the run at the thesis' step to [s]"),
            kept.t_end,
            1.5e-10,
            1e-12,
        ));
        claims.push(Claim::below(format!("{method} with a kept factor: energy error"), kept.energy_error, 1e-3));
        let outcome = solved(method, "1e-12", "full");
        claims.push(Claim::between(
            format!("{method} with the exact tangent: goes on past the thesis' 3.5e-11 to [s]"),
            outcome.t_end,
            1.0e-10,
            1.5e-10,
        ));
        let refused = outcome.status == Status::NotConverged;
        claims.push(Claim::is(format!("{method}: ends in a step that is refused, not in a wrong one"), refused));
        claims.push(Claim::below(format!("{method}: energy error up to there"), outcome.energy_error, 1e-3));
    }
    let half = end("newmark", "5e-13");
    claims.push(Claim::relative("newmark at half the step: completes the run to [s]", half.t_end, 1.5e-10, 1e-12));
    let finer = end("improved-euler", "1.25e-13").failure.unwrap_or_default();
    claims.push(Claim::relative(
        "for information: Heun's time moves with the step; at an eighth of it, over 1.16e-10 s",
        finer.blow_up_time.unwrap_or(f64::NAN) / 1.16e-10,
        1.0,
        0.1,
    ));
    claims
}

/// [s] The method's limit on a case at its start.
fn limit(case: &Case) -> f64 {
    let scene = build_scene(case.problem().system.clone(), 1).expect("the case is good");
    critical_step(&case.problem().method, Spectrum::of(&*scene, scene.initial_state().as_ref()).rates())
}

/// Remarks of the thesis, in numbers.
pub fn remarks() -> Vec<Claim> {
    let mut claims = Vec::new();
    // Trace and determinant of explicit Euler's step with c = k dt, from x2 = T x1 - D x0 and x3 = T x2 - D x1.
    for wh in [0.1, 0.5, 0.9, 1.9] {
        let step = format!("{:e}", wh / 1.5_f64.sqrt());
        let mut x = Vec::new();
        let sets = [
            ("time.step", step.as_str()),
            ("time.end", "8"),
            ("time.method", "explicit-euler"),
            ("system.network.springs.0.dashpot", r#"{"relative": "step"}"#),
        ];
        follow_on(&asset("oscillator", &sets), |seen| x.push(seen.positions[1][0] - seen.reference[1][0]));
        let determinant = (x[2] * x[2] - x[1] * x[3]) / (x[1] * x[1] - x[0] * x[2]);
        let trace = (x[2] + determinant * x[0]) / x[1];
        claims.push(Claim::absolute(
            format!("Euler with c = k dt, w h {wh}: determinant of a step, as Euler-Cromer's"),
            determinant,
            1.0,
            1e-11,
        ));
        claims.push(Claim::absolute(
            format!("Euler with c = k dt, w h {wh}: trace of a step, as Euler-Cromer's"),
            trace,
            2.0 - wh * wh,
            1e-11,
        ));
    }
    let plain = [("time.method", "explicit-euler"), ("system.network.springs.0.dashpot", "null")];
    let bare = follow(&asset("cloth-k1000", &plain), |_| {});
    let diverged = bare.status == Status::Diverged;
    claims.push(Claim::is("explicit Euler on the cloth without that dashpot diverges", diverged));
    let swing = |sets: &[(&str, &str)]| {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let case = asset("cloth-k1000", sets);
        let node = case.problem().output.probes[0].nodes[0] as usize;
        follow(&case, |seen| {
            if seen.t >= 1.5 {
                (low, high) = (low.min(seen.positions[node][2]), high.max(seen.positions[node][2]));
            }
        });
        high - low
    };
    // The air damps what moves along a triangle's normal; what is left after 1.5 s swings through it.
    let ratio = swing(&[]) / swing(&[("system.network.springs.0.dashpot", "null")]);
    claims.push(Claim::below("cloth: swing left after 1.5 s with Eq. 68's dashpot over that without", ratio, 0.3));
    let pendulum =
        |method: &str| limit(&asset("pendulum", &[("time.method", method), ("system.pendulum.angle", "1e-3")]));
    // |R(i y - 0.016 y)| = 1 by hand: y = 2.86 for RK4, 0.52 for Heun, with w = 3.132 rad/s.
    claims.push(Claim::relative(
        "pendulum: largest stable step of rk4 over Heun's",
        pendulum("rk4") / pendulum("improved-euler"),
        5.48,
        0.02,
    ));
    let springs = limit(&asset("parachute-original", &[("system.network.aero", "null")]));
    // 2/w of a net of k = 3.06e4 N/l0, 1 kg/m^2 and edges of 5 to 12 cm.
    claims.push(Claim::between(
        "parachute-original: limit of Verlet by the springs alone over the thesis' step",
        springs / 1e-12,
        3e7,
        3e8,
    ));
    let wind = follow(&asset("parachute-50ms", &[("time.step", "1e-4"), ("time.end", "0.01")]), |_| {});
    let done = wind.status == Status::Completed;
    claims.push(Claim::is("the canopy at 50 m/s runs implicitly at 1e-4 s, 1e8 times the thesis' step", done));
    claims
}
