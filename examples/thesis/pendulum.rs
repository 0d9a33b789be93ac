//! Section 2.5.1: the simple pendulum, Figures 4 to 6 and Table 1.

use super::page::{Caption, Section, cell, curve, exact_curve};
use super::runs::{COST_HEADS, Failed, Trace, asset, changed, cost_rows, run_to_the_end};
use canopy_fem::analysis::limit::critical_step;
use canopy_fem::analysis::spectrum::Spectrum;
use canopy_fem::case::Case;
use canopy_fem::plot::chart::{Axis, Chart};
use canopy_fem::simulation::build_scene;
use std::path::Path;

/// Methods of Table 1 with the thesis' seconds.
const TABLE_1: [(&str, &str, f64); 6] = [
    ("Explicit Euler", "explicit-euler", 0.0029),
    ("4th Runge-Kutta", "rk4", 0.0069),
    ("Velocity Verlet", "velocity-verlet", 0.0045),
    ("Euler Cromer", "euler-cromer", 0.0025),
    ("Improved Explicit Euler", "improved-euler", 0.0059),
    ("the same, one pass (PEC)", "improved-euler-pec", f64::NAN),
];

pub fn section(out: &Path) -> Result<Section, Failed> {
    let mut s = Section::new("Simple pendulum");
    s.text(
        "m = 1 kg, L = 1 m, c = 0.1; the thesis gives neither the first angle (here 0.5 rad) nor the steps \
            of its figures. Eq. 61 prints g/(m L) where the Lagrangian gives g/L; with m = 1 kg the numbers \
            are the same.",
    );
    figures(out, &mut s)?;
    limits(&mut s)?;
    table_1(&mut s)?;
    Ok(s)
}

/// The angle over time.
fn angle(case: &Case) -> Result<Trace, Failed> {
    let mut trace = Trace::default();
    run_to_the_end(case, |seen| {
        let ([x, _, z], [vx, _, vz]) = (seen.positions[0], seen.velocities[0]);
        // Unwound: a bob carried over the top goes on counting.
        let raw = x.atan2(-z);
        let before = trace.values.last().copied().unwrap_or(raw);
        let turns = ((before - raw) / std::f64::consts::TAU).round();
        trace.push(seen.t, raw + turns * std::f64::consts::TAU, (-vx * z + vz * x) / (x * x + z * z));
    })?;
    Ok(trace)
}

fn figures(out: &Path, s: &mut Section) -> Result<(), Failed> {
    let base = asset("pendulum", &[])?;
    let exact = angle(&changed(&base, &[("time.method", "rk4"), ("time.step", "1e-3")])?)?;
    let rows = [
        (
            "figure-04",
            "Figure 4: angle at a step of 0.1 s",
            "0.1",
            "Explicit Euler has gone over the top; RK4 lies on the exact curve. The thesis saw RK4 diverge as \
            explicit Euler does; at a step where Heun holds RK4 cannot (table below), so its RK4 was not the \
            scheme of Eq. 42-51.",
        ),
        (
            "figure-05",
            "Figure 5: angle at a step of 0.01 s",
            "0.01",
            "Explicit Euler still makes energy, (w h)^2 = 0.001 a step, as much as the damping takes; the \
            others cannot be told from the exact curve.",
        ),
        (
            "figure-06",
            "Figure 6: angle at a step of 0.001 s",
            "0.001",
            "As in the thesis, at 1e-3 s and below every scheme is close to the damped decay.",
        ),
    ];
    for (stem, caption, step, note) in rows {
        let mut lines = Vec::new();
        // [rad] farthest from the exact curve: explicit Euler, RK4, all but explicit Euler
        let (mut euler, mut rk4, mut others) = (0.0, f64::NAN, 0.0_f64);
        for (name, method, _) in TABLE_1.into_iter().take(5) {
            let case = changed(&base, &[("time.method", method), ("time.step", step)])?;
            let trace = angle(&case)?;
            let off = distance(&trace, &exact);
            match method {
                "explicit-euler" => euler = off,
                _ => others = others.max(off),
            }
            if method == "rk4" {
                rk4 = off;
            }
            lines.push(curve(method, name, trace.over_time()));
        }
        let holds = match step {
            "0.1" => euler > 2.0 && rk4 < 0.01,
            "0.01" => euler > 0.1 && others < 0.05,
            _ => euler < 0.05 && others < 0.05,
        };
        let note = &s.claim(holds, note);
        lines.push(exact_curve("exact (RK4 at 1e-3 s)", exact.over_time()));
        let y = Axis { label: "angle theta [rad]".into(), range: Some((-1.0, 1.0)), ..Axis::default() };
        let chart =
            Chart { title: format!("step {step} s"), x: Axis::linear("time t [s]"), y, lines, ..Chart::default() };
        s.figure(out, Caption { stem, caption, note }, chart)?;
    }
    Ok(())
}

/// [rad] Largest distance from the exact curve, whose steps are of 1e-3 s, at the times of a trace.
fn distance(trace: &Trace, exact: &Trace) -> f64 {
    let off = trace.times.iter().zip(&trace.values).map(|(t, angle)| {
        let at = exact.values.get((t * 1e3).round() as usize).copied().unwrap_or(f64::NAN);
        (angle - at).abs()
    });
    off.filter(|off| off.is_finite()).fold(0.0, f64::max)
}

/// Predicted limits of the schemes on this pendulum: RK4's is the largest.
fn limits(s: &mut Section) -> Result<(), Failed> {
    let base = asset("pendulum", &[("system.pendulum.angle", "0.01")])?;
    let scene = build_scene(base.problem().system.clone(), 1)?;
    let fastest = Spectrum::of(&*scene, scene.initial_state().as_ref()).rates();
    let (mut rows, mut right, mut steps) = (Vec::new(), true, Vec::new());
    for (name, method, _) in TABLE_1 {
        let case = changed(&base, &[("time.method", method)])?;
        let h = critical_step(&case.problem().method, fastest);
        let mut row = vec![name.to_owned(), cell(h)];
        steps.push((method, h));
        // Swings of 0.01 rad below and above the limit: amplitude of the second half over the first.
        for share in [0.98, 1.02] {
            let step = format!("{:e}", share * h);
            let end = format!("{:e}", 2000.0 * h);
            let trace = angle(&changed(&case, &[("time.step", &step), ("time.end", &end)])?)?;
            // Halves of some periods each, so that a peak of each is among the states.
            let most = |values: &[f64]| values.iter().fold(0.0_f64, |m, v| v.abs().max(m));
            let (early, late) = trace.values.split_at(trace.values.len() / 2);
            // Swings that have grown tenfold may stay there: large ones are slower.
            let grows = most(late) > most(early) || most(late) > 0.1;
            right &= grows == (share > 1.0);
            row.push(if grows { "grows".to_owned() } else { "decays".to_owned() });
        }
        rows.push(row);
    }
    let largest = steps.iter().max_by(|a, b| a.1.total_cmp(&b.1)).is_some_and(|(method, _)| *method == "rk4");
    let note = [
        s.claim(
            largest,
            "Four stages stretch RK4's stability region to w h = 2.83 on the undamped axis, where Heun's \
                touches it at 0 only and needs the damping to hold at all: RK4 cannot diverge before Heun on the pendulum.",
        ),
        s.claim(
            right,
            "Each limit was computed from one real step and checked by 2000 steps just below and just above it.",
        ),
    ]
    .join(" ");
    let heads = ["scheme", "largest stable step [s]", "2 % below it", "2 % above it"];
    s.table("Largest stable steps on the pendulum (not in the thesis)", &heads, rows, note);
    Ok(())
}

fn table_1(s: &mut Section) -> Result<(), Failed> {
    let base = asset("pendulum", &[])?;
    let rows = cost_rows(&TABLE_1, &base)?;
    s.table(
        "Table 1: mean of 10 runs, step 0.005 s, 20 s",
        &COST_HEADS,
        rows,
        "The thesis' Improved Euler costs twice explicit Euler here: two force passes a step, which is \
            Heun's scheme as Eq. 23-24 print it. Our ratios are flatter because a pendulum's force is one \
            sine, and the energy account of every step costs more than it; the force passes show the schemes' \
            own cost.",
    );
    Ok(())
}
