//! What the column `numerical` says of a scheme that damps on its own, on the undamped oscillator with W = w h.
//!
//! The scheme by hand gives E_n/E_0, and the column must be 1 - E_n/E_0 in every step. Once the start has died out the
//! energy goes with the spectral radius of the amplification matrix (Hughes 1987, section 9.3): 1 - rho^(2n), but for
//! the swing of E_n about rho^(2n) in every turn, which comes of x and v being in no exact quadrature. Schemes that
//! multiply the energy by one factor a step have their rows in [`crate::energy_oscillator`]; of them only the order of
//! what they lose or make is here.

use crate::claim::Claim;
use crate::linear_theory::{Member, Named, generalized_alpha, hht, method_name, newmark};
use crate::one_mass::rows;
use serde_json::{Value, json};
use std::f64::consts::TAU;

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    for named in [newmark(0.3025, 0.6), hht(-0.1), hht(-0.3), generalized_alpha(0.8), generalized_alpha(0.0)] {
        for wh in [0.3, 1.5] {
            lost(&named, wh, &mut claims);
        }
    }
    orders(&mut claims);
    claims
}

/// E_n/E_0 of a step from x = 1, v = 0, a = -1 in units of the frequency.
fn energies(Member { beta, gamma, am, af }: Member, wh: f64, steps: usize) -> Vec<f64> {
    let [mut x, mut v, mut a] = [1.0, 0.0, -1.0_f64];
    let mut energies = vec![1.0];
    for _ in 0..steps {
        let [x0, a0] = [x, a];
        let predicted = x0 + wh * v + wh * wh * (0.5 - beta) * a0;
        // (1 - am) a + am a0 = -(1 - af) x - af x0 with x = predicted + beta W^2 a
        a = -((1.0 - af) * predicted + af * x0 + am * a0) / (1.0 - am + (1.0 - af) * beta * wh * wh);
        x = predicted + beta * wh * wh * a;
        v += wh * ((1.0 - gamma) * a0 + gamma * a);
        energies.push(x * x + v * v);
    }
    energies
}

fn lost(named: &Named, wh: f64, claims: &mut Vec<Claim>) {
    let radius = named.member.character(wh).radius;
    // until half the energy is gone
    let steps = (0.5_f64.ln() / (2.0 * radius.ln())).clamp(8.0, 4000.0) as usize;
    let rows = rows(&named.method, wh, steps);
    let by_hand = energies(named.member, wh, steps);
    let first = rows[0].energy();
    let off = rows.iter().zip(&by_hand).map(|(row, e)| (row.ledger.numerical / first - (1.0 - e)).abs());
    // Both round the coefficients of their step once for all steps: growth or decay of some eps a step.
    let rounding = 1e-14 + 1e-15 * steps as f64;
    let name = named.name();
    claims.push(Claim::below(
        format!("{name}: w h {wh}: numerical, off 1 - E_n/E_0, worst of {steps} steps"),
        off.fold(0.0, f64::max),
        rounding,
    ));
    let left = |n: usize| radius.powi(2 * n as i32);
    let swing = (steps / 2..=steps).map(|n| (by_hand[n] / left(n) - 1.0).abs()).fold(0.0, f64::max);
    claims.push(Claim::absolute(
        format!("{name}: w h {wh}: numerical after {steps} steps against 1 - rho^2n"),
        rows[steps].ledger.numerical / first,
        1.0 - left(steps),
        swing * left(steps) + rounding,
    ));
}

/// Energy lost or made in ten periods falls with the order of the scheme's damping: 2 xi w t with xi ~ W or W^3.
fn orders(claims: &mut Vec<Claim>) {
    let methods = [
        (json!("explicit-euler"), 1.0),
        (json!("backward-euler"), 1.0),
        (newmark(0.3025, 0.6).method, 1.0),
        (hht(-0.1).method, 3.0),
        (hht(-0.3).method, 3.0),
        (generalized_alpha(0.8).method, 3.0),
        (generalized_alpha(0.0).method, 3.0),
    ];
    for (method, order) in methods {
        // First order takes finer steps, for the square of the loss not to bend the slope.
        let (periods, steps) = if order == 1.0 { (1, 4000) } else { (10, 200) };
        let of = |steps: usize| numerical(&method, TAU / steps as f64, periods * steps);
        let slope = (of(steps) / of(2 * steps)).abs().log2();
        let what = format!(
            "{}: numerical at t = {periods} T, {steps} and twice as many steps a period, order in h",
            method_name(&method)
        );
        claims.push(Claim::absolute(what, slope, order, 0.02));
    }
}

fn numerical(method: &Value, wh: f64, steps: usize) -> f64 {
    rows(method, wh, steps)[steps].ledger.numerical
}
