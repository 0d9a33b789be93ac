//! Waves on a chain of beads (Brillouin, Wave Propagation in Periodic Structures): w = 2 sqrt(k/m) sin(q a/2) along the
//! chain, the same with T/a for k across it; and what a scheme makes of a wave, which has a closed form too.

use crate::chain::{Start, Strung};
use crate::claim::Claim;
use crate::common::run::run;
use crate::linearised::{Linearised, worst_share};
use crate::signal::Signal;

/// k/m = 4/s^2 exactly, so that h = sqrt(m/k) is exact too.
const STRING: Strung = Strung { beads: 20, mass: 0.5, link: 0.25, stiffness: 2.0, tension: 0.125 };
const LINE: Strung = Strung { beads: 239, mass: 0.5, link: 0.25, stiffness: 2.0, tension: 0.0 };

/// A run in standing mode `j` along or across the string, projected on the mode.
fn standing(s: &Strung, axis: usize, j: usize, start: &Start<'_>) -> Signal {
    // Along the chain the links are linear at any size; across it the square of the slope bends them.
    let amplitude = s.link * if axis == 0 { 0.1 } else { 1e-7 };
    let shape: Vec<f64> = (0..s.beads + 2).map(|i| (s.phase(j) * i as f64).sin()).collect();
    let mut displacement = vec![[0.0; 3]; s.beads + 2];
    (1..=s.beads).for_each(|i| displacement[i][axis] = amplitude * shape[i]);
    let still = vec![[0.0; 3]; s.beads + 2];
    let case = s.case(&Start { displacement: &displacement, velocity: &still, ..*start });
    Signal::of(&case, |seen| {
        let rest = |i: usize| if axis == 0 { s.link * i as f64 } else { 0.0 };
        let project = |value: &dyn Fn(usize) -> f64| (1..=s.beads).map(|i| shape[i] * value(i)).sum::<f64>();
        (project(&|i| seen.positions[i][axis] - rest(i)), project(&|i| seen.velocities[i][axis]))
    })
}

pub fn dispersion() -> Vec<Claim> {
    let s = &STRING;
    let linear = Linearised::of(&s.at_rest());
    let mut claims = Vec::new();
    for (axis, name, k) in
        [("x", "k/m", s.stiffness), ("y", "T/(m a)", s.tension / s.link), ("z", "T/(m a)", s.tension / s.link)]
    {
        let expected = (1..=s.beads).map(|j| s.frequency(k, j).powi(2));
        let off = worst_share(&linear.modes(axis).squares, expected);
        // The largest eigenvalue is 180 times the smallest.
        let what = format!("tangent: all w along {axis} = 2 sqrt({name}) sin(q a/2), worst share of w^2");
        claims.push(Claim::below(what, off, 1e-13));
    }
    for (axis, name, k) in [(0, "along", s.stiffness), (1, "across", s.tension / s.link)] {
        for j in [1, 10, 20] {
            let w = s.frequency(k, j);
            // w h up to 1.2 for the fastest wave.
            let step = 0.3;
            let start = Start { displacement: &[], velocity: &[], method: "", step, steps: 600 };
            // Verlet turns a wave by 2 asin(w h/2) a step, Newmark by 2 atan(w h/2); Euler-Cromer's positions are
            // Verlet's. Rounding of positions is 1e-14 of the motion along the chain; across it the square of the
            // amplitude is.
            for (method, turn) in [
                ("velocity-verlet", 2.0 * (0.5 * w * step).asin()),
                ("euler-cromer", 2.0 * (0.5 * w * step).asin()),
                ("newmark", 2.0 * (0.5 * w * step).atan()),
            ] {
                let run = standing(s, axis, j, &Start { method, ..start });
                let what = format!("{method}, wave {j} of 20 {name}, w h = {:.2}: turn of a step", w * step);
                claims.push(Claim::relative(what, run.cosine().acos(), turn, 1e-12));
            }
            // Runge-Kutta of order 4 turns by w h (1 - (w h)^4/120 + (w h)^6/336 - ...), the last 5e-11 here.
            let step = 0.05 / w;
            let run = standing(s, axis, j, &Start { method: "rk4", step, ..start });
            let expected = w * (1.0 - 0.05_f64.powi(4) / 120.0);
            let what = format!("rk4, wave {j} of 20 {name}, w h = 0.05: w");
            claims.push(Claim::relative(what, run.frequency(), expected, 2e-10));
        }
    }
    claims
}

/// [m] A bump about node `centre`, `width` links wide (standard deviation).
fn bump(centre: f64, width: f64) -> impl Fn(f64) -> f64 {
    move |i| 0.2 * LINE.link * (-0.5 * ((i - centre) / width).powi(2)).exp()
}

fn along(value: impl Fn(f64) -> f64) -> Vec<[f64; 3]> {
    let mut u: Vec<[f64; 3]> = (0..LINE.beads + 2).map(|i| [value(i as f64), 0.0, 0.0]).collect();
    (u[0], u[LINE.beads + 1]) = ([0.0; 3], [0.0; 3]);
    u
}

pub fn speed() -> Vec<Claim> {
    let mut claims: Vec<Claim> = [6.0, 10.0].map(arrival).to_vec();
    claims.push(shifted());
    claims
}

/// The crest of a smooth bump comes later than c = a sqrt(k/m) says. Of its wavelengths, q is slowed by (q a)^2/24; the
/// crest, by expansion of the wave equation with that term, by a^2/(8 s^2) for a bump of standard deviation s.
fn arrival(width: f64) -> Claim {
    let (from, to) = (70usize, 170usize);
    // [1/s] links a second
    let c = (LINE.stiffness / LINE.mass).sqrt();
    let f = bump(from as f64, width);
    let slope = |i: f64| -(i - from as f64) / (width * width) * f(i);
    let (displacement, velocity) = (along(&f), along(|i| -c * slope(i)));
    let start = Start { displacement: &displacement, velocity: &velocity, method: "rk4", step: 0.05 / c, steps: 2400 };
    // The crest is at a node when its neighbours stand equally high.
    let difference = Signal::of(&LINE.case(&start), |seen| {
        let [a, b] = [to - 1, to + 1];
        let rest = 2.0 * LINE.link;
        (seen.positions[b][0] - seen.positions[a][0] - rest, seen.velocities[b][0] - seen.velocities[a][0])
    });
    let straight = (to - from) as f64 / c;
    let crossings = difference.crossings();
    let crest = crossings.iter().find(|t| (0.9..1.1).contains(&(*t / straight))).expect("the crest passes");
    // Next come a^4/s^4 and the square of the shift over s: (100/24/s^3)^2 beside it.
    Claim::relative(
        format!("front: delay of a crest, {width} links wide, over 100 links, share of the time"),
        crest / straight - 1.0,
        1.0 / (8.0 * width * width),
        1.0 / (width * width),
    )
}

/// With h = sqrt(m/k) Verlet's error and the chain's cancel for every wavelength: cos(w h) = cos(q a), and any bump
/// moves one node a step without changing its form (Courant, Friedrichs, Lewy 1928).
fn shifted() -> Claim {
    let (from, steps) = (70.0, 100);
    // A spike two links wide, which every other step would scatter.
    let f = bump(from, 2.0);
    let h = (LINE.mass / LINE.stiffness).sqrt();
    let displacement = along(&f);
    let velocity = along(|i| (f(i - 1.0) - f(i + 1.0)) / (2.0 * h));
    let start = Start { displacement: &displacement, velocity: &velocity, method: "velocity-verlet", step: h, steps };
    let last = run(&LINE.case(&start));
    let off = (0..LINE.beads + 2).map(|i| {
        let expected = LINE.link * i as f64 + f(i as f64 - f64::from(steps));
        (last.positions[i][0] - expected).abs()
    });
    // Rounding of a position of 60 m is 7e-15 m; 100 steps add some of them up.
    Claim::below(
        "velocity-verlet, h = sqrt(m/k): a spike after 100 steps, off its own place by [m]",
        off.fold(0.0, f64::max),
        1e-13,
    )
}
