//! The vector updates of explicit schemes. Slices are `[n_dof]`.

use super::StageWork;
use crate::model::forces::{Forces, Role, Tally};
use crate::model::system::System;
use multiversion::multiversion;
use std::ops::Range;

/// out = a + h b
#[multiversion(targets("x86_64+avx+avx2"))]
pub(super) fn add_scaled(out: &mut [f64], a: &[f64], h: f64, b: &[f64]) {
    for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
        *out = a + h * b;
    }
}

/// out += h b
#[multiversion(targets("x86_64+avx+avx2"))]
pub(super) fn accumulate(out: &mut [f64], h: f64, b: &[f64]) {
    for (out, b) in out.iter_mut().zip(b) {
        *out += h * b;
    }
}

/// Time derivative of the state in a stage: dx/dt = u, dv/dt = M^-1 f.
#[derive(Clone, Copy)]
pub(super) struct Slopes<'a> {
    pub u: &'a [f64],
    pub f: &'a [f64],
}

/// x = x_n + h u, v = v_n + h M^-1 f
pub(super) fn follow<S: System + ?Sized>(
    system: &S,
    [x, v]: [&mut [f64]; 2],
    [x_n, v_n]: [&[f64]; 2],
    h: f64,
    Slopes { u, f }: Slopes<'_>,
) {
    let product = Product { inverse_mass: system.inverse_mass(), f };
    system.workers().both(x, v, |r, x, v| {
        add_scaled(x, &x_n[r.clone()], h, &u[r.clone()]);
        add_product(v, &v_n[r.clone()], h, product.of(r));
    });
}

/// The same with u = v before the update.
pub(super) fn follow_on<S: System + ?Sized>(
    system: &S,
    [x, v]: [&mut [f64]; 2],
    [x_n, v_n]: [&[f64]; 2],
    h: f64,
    f: &[f64],
) {
    let product = Product { inverse_mass: system.inverse_mass(), f };
    system.workers().both(x, v, |r, x, v| next_stage([x, v], [&x_n[r.clone()], &v_n[r.clone()]], h, product.of(r)));
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn next_stage([x, v]: [&mut [f64]; 2], [x_n, v_n]: [&[f64]; 2], h: f64, p: Product<'_>) {
    let from = x_n.iter().zip(v_n).zip(p.f.iter().zip(p.inverse_mass));
    for ((x, v), ((x_n, v_n), (f, inverse_mass))) in x.iter_mut().zip(v.iter_mut()).zip(from) {
        *x = x_n + h * *v;
        *v = v_n + h * (inverse_mass * f);
    }
}

/// x += h u, v += h M^-1 f
pub(super) fn accumulate_slopes<S: System + ?Sized>(
    system: &S,
    [x, v]: [&mut [f64]; 2],
    h: f64,
    Slopes { u, f }: Slopes<'_>,
) {
    let product = Product { inverse_mass: system.inverse_mass(), f };
    system.workers().both(x, v, |r, x, v| {
        accumulate(x, h, &u[r.clone()]);
        accumulate_product(v, h, product.of(r));
    });
}

/// M^-1 f, before it is multiplied.
#[derive(Clone, Copy)]
pub(super) struct Product<'a> {
    pub inverse_mass: &'a [f64],
    pub f: &'a [f64],
}

impl Product<'_> {
    /// Some degrees of freedom of it.
    pub(super) fn of(&self, r: Range<usize>) -> Product<'_> {
        Product { inverse_mass: &self.inverse_mass[r.clone()], f: &self.f[r] }
    }
}

/// out = v + h M^-1 f
#[multiversion(targets("x86_64+avx+avx2"))]
pub(super) fn add_product(out: &mut [f64], v: &[f64], h: f64, p: Product<'_>) {
    for (((out, v), f), inverse_mass) in out.iter_mut().zip(v).zip(p.f).zip(p.inverse_mass) {
        *out = v + h * (inverse_mass * f);
    }
}

/// out = M^-1 f
pub(super) fn acceleration<S: System + ?Sized>(system: &S, out: &mut [f64], f: &[f64]) {
    let inverse_mass = system.inverse_mass();
    system.workers().set(out, |r, out| {
        for ((out, f), inverse_mass) in out.iter_mut().zip(&f[r.clone()]).zip(&inverse_mass[r]) {
            *out = inverse_mass * f;
        }
    });
}

/// out += h M^-1 f
#[multiversion(targets("x86_64+avx+avx2"))]
pub(super) fn accumulate_product(out: &mut [f64], h: f64, p: Product<'_>) {
    for ((out, f), inverse_mass) in out.iter_mut().zip(p.f).zip(p.inverse_mass) {
        *out += h * (inverse_mass * f);
    }
}

/// [W] external and dissipated power of a force pass in a step between two times [s].
pub(super) fn power<S: System + ?Sized>(system: &S, times: [f64; 2], forces: &Forces) -> StageWork {
    let mut sum = power_of_forces(system, forces);
    sum.external += system.reeling_power(times, &forces.tallies);
    sum
}

/// [W] The same without changes of rest lengths, which belong to a step.
pub(super) fn power_of_forces<S: System + ?Sized>(system: &S, forces: &Forces) -> StageWork {
    let mut sum = StageWork::default();
    for (term, tally) in system.terms().iter().zip(&forces.tallies) {
        match term.role {
            Role::External => sum.external += tally.power,
            Role::Dissipative => sum.dissipated -= tally.power,
            Role::Elastic | Role::Gravity => {}
        }
    }
    sum
}

/// sum of weight * power over stages
pub(super) fn weigh<const N: usize>(stages: [(f64, StageWork); N]) -> StageWork {
    let mut sum = StageWork::default();
    for (w, p) in stages {
        sum.add(w, p);
    }
    sum
}

/// [J] Work of changes of rest lengths over a step between two times [s], from the tallies at its ends.
pub(crate) fn reeling_work(system: &dyn System, times: [f64; 2], tallies: [&[Tally]; 2]) -> f64 {
    let [start, end] = tallies.map(|tallies| system.reeling_power(times, tallies));
    0.5 * (times[1] - times[0]) * (start + end)
}

impl StageWork {
    /// The works of a step by its ends: 1/2 (f_n + f_{n+1}) . (x_{n+1} - x_n), and what changes of rest lengths do.
    pub(crate) fn by_ends(system: &dyn System, forces: [&Forces; 2], way: [&[f64]; 2], times: [f64; 2]) -> Self {
        let work = |of: fn(&Forces) -> &[f64]| system.work(forces.map(of), way);
        StageWork {
            external: work(|f| &f.external) + reeling_work(system, times, forces.map(|f| &f.tallies[..])),
            dissipated: -work(|f| &f.dissipative),
        }
    }

    /// += weight * power
    pub(super) fn add(&mut self, weight: f64, power: StageWork) {
        self.external += weight * power.external;
        self.dissipated += weight * power.dissipated;
    }
}
