//! How the schemes turn evenly: by their characteristic polynomials.

use super::{END, MASS, RADIUS, SPEED, Spring};
use faer::c64;

/// [rad] angle after 100 turns of the even rotation of a scheme that keeps an invariant: of `angle(p)` a step, with the
/// radius at which the invariant `r^2 momentum(p)` has the value of the start.
pub fn even(spring: Spring, h: f64, start: f64, momentum: fn(f64) -> f64, angle: fn(f64) -> f64) -> f64 {
    let p = |r: f64| h * h * spring.pull(r);
    let (mut low, mut high) = (0.999 * RADIUS, 1.001 * RADIUS);
    for _ in 0..60 {
        let r = 0.5 * (low + high);
        *(if r * r * momentum(p(r)) / h < start { &mut low } else { &mut high }) = r;
    }
    angle(p(high)) * (END / h).round()
}

/// A scheme that brakes.
#[derive(Clone, Copy)]
pub enum Braking {
    BackwardEuler,
    /// Newmark's relations with averaged inertia and forces
    Alpha {
        am: f64,
        af: f64,
    },
}

impl Braking {
    /// |lambda|^2 on x'' = -p/h^2 x. With x = lambda^n in Newmark's relations, beta = (1 - am + af)^2/4 and
    /// gamma = 1/2 - am + af:
    /// (l - 1)^2 ((1 - am) l + am) + p ((1 - af) l + af) (beta l^2 + (1/2 + gamma - 2 beta) l + 1/2 + beta - gamma) = 0
    fn shrinking(self, p: f64) -> f64 {
        let (am, af) = match self {
            Braking::BackwardEuler => return 1.0 / (1.0 + p),
            Braking::Alpha { am, af } => (am, af),
        };
        let (beta, gamma) = ((1.0 - am + af).powi(2) / 4.0, 0.5 - am + af);
        let value = |l: c64| {
            let inertia = (l - 1.0) * (l - 1.0) * (l * (1.0 - am) + am);
            inertia + (l * (1.0 - af) + af) * (l * l * beta + l * (0.5 + gamma - 2.0 * beta) + (0.5 + beta - gamma)) * p
        };
        // Secants from the exact solution: the root is simple.
        let (mut a, mut b) = (c64::from_polar(1.0, p.sqrt()), c64::from_polar(1.0 - p, p.sqrt()));
        for _ in 0..30 {
            let (fa, fb) = (value(a), value(b));
            if (fb - fa).norm() < 1e-300 || (b - a).norm() < 1e-16 {
                break;
            }
            (a, b) = (b, b - fb * (b - a) / (fb - fa));
        }
        b.norm_sqr()
    }

    /// L/L0 after 50 turns more.
    pub fn momentum(self, spring: Spring, h: f64, from: f64) -> f64 {
        let l0 = MASS * RADIUS * SPEED;
        let (mut r, mut l) = (RADIUS, from * l0);
        for _ in 0..(0.5 * END / h).round() as u64 {
            // T = L^2/(m r^3), by Newton from the radius of the step before
            for _ in 0..3 {
                let centrifugal = l * l / (MASS * r.powi(3));
                r -= (spring.k * (r - spring.rest) - centrifugal) / (spring.k + 3.0 * centrifugal / r);
            }
            l *= self.shrinking((h * l / (MASS * r * r)).powi(2));
        }
        l / l0
    }
}
