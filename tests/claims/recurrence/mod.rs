//! Every method on a damped oscillator against its own amplification recurrence, and what it carries from step to step.

mod bench;
mod by_hand;
mod carried;

use crate::claim::Claim;
use bench::{Case, Damper, Oscillator, REST, Walk, cases};
use by_hand::Motion;
use canopy_fem::model::system::System;
use canopy_fem::scene::Network;

/// Degree of freedom of the mass along the spring, whatever the inner numbering is.
fn moving(scene: &Network) -> usize {
    (0..scene.n_dof()).find(|&i| scene.inverse_mass()[i] > 0.0).expect("one free degree of freedom")
}

fn follow(case: &Case, o: Oscillator, wh: f64, damper: Damper) -> f64 {
    let h = wh / o.frequency;
    let start = Motion { x: 0.0625, v: -0.03125, a: 0.0 };
    let scene = o.scene([start.x, start.v], damper);
    let mut walk = Walk::start(case, &scene);
    let dof = moving(&scene);
    let (mut size, mut worst, mut followed) = (start.x.abs(), 0.0_f64, 0);
    for expected in case.expected(o, h, damper, start, 40) {
        walk.step(h);
        let (x, v) = (walk.from.state.x[dof], walk.from.state.v[dof]);
        // An unstable step throws the mass through its anchor, where the spring is no longer linear; the predicted
        // states of a step go farther than its result.
        if expected.x.abs() > 0.25 * REST {
            break;
        }
        size = size.max(expected.x.abs()).max(expected.v.abs() / o.frequency);
        let error = (x - expected.x).abs().max((v - expected.v).abs() / o.frequency) / size;
        worst = if error.is_nan() { f64::NAN } else { worst.max(error) };
        followed += 1;
    }
    assert!(followed >= 2, "{}: w h {wh}, {o:?}: nothing was followed", case.name());
    worst
}

pub fn claims() -> Vec<Claim> {
    let mut claims: Vec<Claim> = cases().iter().map(recurrence).collect();
    claims.extend(cases().iter().filter(|c| c.is_implicit()).map(static_answer));
    claims.extend(carried::claims());
    claims
}

/// Each method is exactly the method of the literature on x'' = -w^2 x - 2 zeta w x' + g, whichever term damps.
fn recurrence(case: &Case) -> Claim {
    let dampers = [Damper::Axial, Damper::Relative, Damper::FromStep, Damper::RayleighMass, Damper::RayleighStiffness];
    let mut worst = 0.0_f64;
    for (wh, ratio) in [0.1, 0.7, 1.5].into_iter().flat_map(|wh| [0.0, 0.1, 1.0].map(|ratio| (wh, ratio))) {
        for (damper, push) in dampers.into_iter().zip([0.0, 0.15, 0.0, 0.15, 0.0]) {
            let error = follow(case, Oscillator { frequency: 1.7, ratio, push }, wh, damper);
            worst = if error.is_nan() { f64::NAN } else { worst.max(error) };
        }
    }
    // Rounding of 40 steps, in units of the largest motion; the stages of dop853 have weights up to 43, which cancel.
    let rounding = if case.method == "dop853" { 1e-12 } else { 1e-13 };
    Claim::below(format!("{}: recurrence, worst of 3 steps, 3 damping ratios, 5 dampers", case.name()), worst, rounding)
}

/// Under a constant load with damping every implicit method comes to rest at x = F/K: its force weights sum to one.
/// (The thesis' Eq. 41 would end at F/((1 - 2 alpha) K).)
fn static_answer(case: &Case) -> Claim {
    let o = Oscillator { frequency: 1.7, ratio: 0.5, push: 0.6 };
    let exact = o.push / o.frequency.powi(2);
    let off = [Damper::Axial, Damper::RayleighMass].map(|damper| {
        let scene = o.scene([0.0, 0.0], damper);
        let mut walk = Walk::start(case, &scene);
        (0..400).for_each(|_| walk.step(0.6));
        (walk.from.state.x[moving(&scene)] - exact).abs()
    });
    Claim::below(format!("{}: rest point, off F/K = {exact:.6} m", case.name()), off[0].max(off[1]), 1e-14)
}
