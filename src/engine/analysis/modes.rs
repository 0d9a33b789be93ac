//! The outer modes of a damped or non-symmetric scene: converged eigenvalues of L = [0 I; -M^-1 K, -M^-1 C] by
//! Arnoldi's iteration, treated as oscillators. Also whether a mode that a scheme makes grow grows in the scene too.

use super::arnoldi::{Krylov, most_moving_dof};
use super::lanczos::Ritz;
use super::limit::{critical_step, stable};
use super::operators::{DAMPING, Linearised, MOST_ASSEMBLED, Matrices, STIFFNESS};
use super::rates::Rates;
use super::vectors::{MIN_ARNOLDI, SHAPES, affordable, dot};
use crate::integrate::registry::MethodChoice;
use faer::c64;

/// [-] Eigenvalues of L with a larger residual, over the fastest rate, are dropped.
const CONVERGED: f64 = 1e-3;
/// Products with L for its eigenvalues: the second number if after the first an outermost one has not converged, and so
/// on.
const PRODUCTS: [usize; 3] = [32, 56, 80];

/// Vectors after which the largest eigenvalue of a net has usually converged.
const SETTLED_AFTER: usize = 24;
/// A mode is resolved by every scheme if it changes by less than this share in a step.
const RESOLVED: f64 = 0.1;
/// Numbers that are stored of a spring for products with K, and with C.
const STORED_OF_SPRING: usize = 7;
/// Share of the growth that must come from the scene; a scheme changes it a little.
const OWN: f64 = 0.5;

/// A mode that may set a limit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mode {
    /// [rad/s] undamped frequency
    pub frequency: f64,
    /// [1/s] damping rate: twice the decay rate of its amplitude if it oscillates
    pub damping: f64,
    /// degree of freedom that moves most
    pub dof: usize,
    /// whether the mode itself grows; a scheme that grows with it at every step is not unstable
    pub grows: bool,
}

impl Mode {
    /// [s] Largest stable step of a method on this mode.
    pub(super) fn limit(&self, method: &MethodChoice) -> f64 {
        critical_step(method, self.rates())
    }

    pub(super) fn rates(&self) -> Rates {
        let Mode { frequency, damping, dof, .. } = *self;
        Rates { frequency, frequency_dof: dof, damping, damping_dof: dof, ..Rates::default() }
    }
}

/// The modes found of a scene.
pub(super) struct Modes {
    list: Vec<Mode>,
}

/// The limit that a mode sets to a method.
#[derive(Clone, Copy)]
pub(super) struct ModeLimit {
    /// [s] the largest stable step
    pub step: f64,
    pub mode: Mode,
}

impl Modes {
    /// Finds outer modes: the stiffest and the most damped one from their Rayleigh quotients, others from eigenvalues
    /// of L. `unit` [1/s] is the scale of rates.
    pub(super) fn find(linear: &Linearised<'_>, shapes: [&Ritz; 2], unit: f64) -> Self {
        let mut list = Vec::new();
        for shape in shapes.map(|ritz| &ritz.vector).into_iter().filter(|shape| !shape.is_empty()) {
            if let Some(Rates { frequency, damping, .. }) = linear.quotients(shape) {
                list.push(Mode { frequency, damping, dof: linear.most_moving_dof(shape), grows: false });
            }
        }
        let mut modes = Modes { list };
        if let Some(krylov) = krylov(linear, unit) {
            modes.take(&krylov, &linear.root, unit);
        }
        modes
    }

    fn take(&mut self, krylov: &Krylov, root: &[f64], unit: f64) {
        for value in &krylov.values {
            let ritz = krylov.ritz(*value);
            if ritz.residual > CONVERGED * unit {
                continue;
            }
            let dof = most_moving_dof(&krylov.vector(&ritz), root);
            if value.im > 0.0 {
                let (frequency, damping) = (value.re.hypot(value.im), (-2.0 * value.re).max(0.0));
                self.list.push(Mode { frequency, damping, dof, grows: value.re > 0.0 });
            } else if value.re < 0.0 {
                self.list.push(Mode { frequency: 0.0, damping: -value.re, dof, grows: false });
            }
        }
    }

    /// Rates of all modes that do not grow by themselves.
    pub(super) fn rates(&self) -> Vec<Rates> {
        self.list.iter().filter(|mode| !mode.grows).map(Mode::rates).collect()
    }

    /// The smallest limit of a method.
    pub(super) fn limit(&self, method: &MethodChoice) -> Option<ModeLimit> {
        let mut found: Option<ModeLimit> = None;
        for mode in &self.list {
            // A mode that is stable at the smallest limit so far sets none. This check is forty times cheaper than
            // computing its limit.
            let matters = |least: ModeLimit| least.step > 0.0 && !stable(method, mode.rates(), least.step);
            if found.is_none_or(matters) {
                let step = mode.limit(method);
                if !(mode.grows && step == 0.0) && found.is_none_or(|least| step < least.step) {
                    found = Some(ModeLimit { step, mode: *mode });
                }
            }
        }
        found
    }
}

/// Acts on (unit q, q'), so that both halves have one scale.
fn krylov(linear: &Linearised<'_>, unit: f64) -> Option<Krylov> {
    let n = linear.root.len();
    let (mut p, mut stiff) = (vec![0.0; n], vec![0.0; n]);
    let start = [linear.start(), linear.start().into_iter().rev().collect()].concat();
    let held = linear.root.iter().cycle().map(|root| f64::from(u8::from(*root > 0.0)));
    let start: Vec<f64> = start.iter().zip(held).map(|(start, free)| start * free).collect();
    let mut times = |from: &[f64], to: &mut [f64]| {
        let (q, rate) = from.split_at(n);
        let (to_q, to_rate) = to.split_at_mut(n);
        linear.times(STIFFNESS, q, &mut p, &mut stiff);
        linear.times(DAMPING, rate, &mut p, to_rate);
        for ((to, to_rate), (rate, stiff)) in to_q.iter_mut().zip(to_rate).zip(rate.iter().zip(&stiff)) {
            *to = unit * rate;
            *to_rate = -*to_rate - stiff / unit;
        }
    };
    let mut krylov = Krylov::from(start);
    for products in PRODUCTS {
        krylov.extend(products, linear.stop, &mut times)?;
        if outermost_converged(&krylov, unit) {
            break;
        }
    }
    Some(krylov)
}

/// Whether the fastest eigenvalue and that of the fastest oscillation have converged.
fn outermost_converged(krylov: &Krylov, unit: f64) -> bool {
    let outermost = |size: fn(&c64) -> f64| krylov.values.iter().max_by(|a, b| size(a).total_cmp(&size(b)));
    let mut values = [outermost(|z| z.norm()), outermost(|z| z.im)].into_iter().flatten();
    values.all(|value| krylov.ritz(*value).residual <= CONVERGED * unit)
}

/// Numbers a search for a critical step usually stores, for a scene with `n` degrees of freedom.
pub fn search_numbers(n: usize, damped: bool) -> usize {
    let shapes = n * affordable(n, SHAPES).min(SETTLED_AFTER);
    // Eigenvectors of L have a position and a velocity part.
    let modes = 2 * n * affordable(2 * n, [MIN_ARNOLDI, PRODUCTS[2]]);
    // A net has about as many springs as degrees of freedom.
    let stored = STORED_OF_SPRING * n;
    match damped {
        false => shapes + stored,
        true if n <= MOST_ASSEMBLED => shapes.max(modes),
        true => shapes.max(modes) + 2 * stored,
    }
}

/// Quotients of a vector of the step map in the linearised scene. A vector y moves as exp(s t) with s^2 + c s + k = 0,
/// where k = y*Ky and c = y*Cy. If both roots are real, the ratio of speed to position shows which one it follows: a
/// slow one, which compression may make grow, or a fast one damped by a dashpot, which a long step may make grow too.
#[derive(Clone, Copy, Debug)]
pub(super) struct ModeShape {
    /// [1/s^2]
    pub k: c64,
    /// [1/s]
    pub c: c64,
    /// [1/s] speed over position
    pub rate: c64,
}

impl ModeShape {
    /// From the real and imaginary parts of (M^1/2 x `unit`, M^1/2 v), each `[2 n_dof]`, with more behind them where a
    /// scheme carries more; `unit` in 1/s, `root` is the diagonal of M^-1/2 `[n_dof]`.
    pub(super) fn of([re, im]: &[Vec<f64>; 2], matrices: &Matrices, root: &[f64], unit: f64) -> Self {
        let n = root.len();
        let ((x, v), (ix, iv)) = ((&re[..n], &re[n..2 * n]), (&im[..n], &im[n..2 * n]));
        let along = |a: &[f64], b: &[f64]| c64::new(dot(x, a) + dot(ix, b), dot(x, b) - dot(ix, a));
        let square = dot(x, x) + dot(ix, ix);
        let times = |of: [f64; 2], part: &[f64]| {
            let p: Vec<f64> = part.iter().zip(root).map(|(part, root)| part * root).collect();
            let mut y = vec![0.0; n];
            matrices.times(of, [&p, &p], &mut y);
            y.iter_mut().zip(root).for_each(|(y, root)| *y *= root);
            y
        };
        let quotient = |of: [f64; 2]| along(&times(of, x), &times(of, ix)) / square;
        ModeShape { k: quotient([1.0, 0.0]), c: quotient([0.0, 1.0]), rate: along(v, iv) * unit / square }
    }

    /// Whether an eigenvalue z of a step of h [s], beyond the unit circle, is growth of the scene itself.
    pub(super) fn grows_by_itself(&self, [re, im]: [f64; 2], h: f64) -> bool {
        let z = c64::new(re, im);
        let between = (self.c * self.c - self.k * 4.0).sqrt();
        let follows_slow = z.re > 0.0 && self.rate.re > -0.5 * self.c.re;
        let slow = (between - self.c) * 0.5;
        let s = if between.im.abs() > between.re || follows_slow { slow } else { slow - between };
        let resolved = (z - 1.0).norm() < RESOLVED && s.norm() * h < RESOLVED;
        resolved || s.re * h >= OWN * z.norm().ln()
    }
}
