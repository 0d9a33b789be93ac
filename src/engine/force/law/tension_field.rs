//! Stress of a membrane that is taut, wrinkled or slack: the tension field (Wagner 1929; Reissner 1938), as the relaxed
//! energy of Pipkin (1986).
//!
//! ```text
//! W(E) = max over stresses S without compression of  S : E - 1/2 S : C : S                 S = dW/dE
//! taut      S = C^-1 E has no compression: this is the plane stress of the sheet
//! slack     E has no tension: S = 0
//! wrinkled  S = (e/c) T,  T = t t^T,  e = t.E t,  c = T : C : T,  W = e^2/(2 c),  t along the wrinkles: W is largest
//! ```
//! W is convex, S is continuous, and for an isotropic sheet t is the direction of the largest strain: the sheet is
//! slack where E1 <= 0 and wrinkled where E2 <= -nu E1.
//!
//! Axes are those of the material, scaled so that both of its moduli are 1: a strain is times x_i x_j and a stress
//! divided by it, with x_i^4 the membrane stiffness E_i t [N/m] along axis i. What is left of an orthotropic sheet is
//! nu = sqrt(nu12 nu21) and g = sqrt(E1 E2)/G12, and
//! ```text
//! C = [[1, -nu, 0], [-nu, 1, 0], [0, 0, g]]  for  (S11, S22, S12) -> (E11, E22, 2 E12)
//! t = (cos(phi/2), sin(phi/2)),   e = m + d cos(phi) + g' sin(phi),   c = A + B cos^2(phi)
//! ```
//! B is 0 for an isotropic sheet. Otherwise phi is found with Newton's method between bounds: mirrored to positive d
//! and g', it lies between 0 and 90 degrees.

use crate::model::quad::Real;

/// Steps of Newton's method, or halvings of the bounds, for the direction of the wrinkles.
const ITERATIONS: usize = 10;
/// The same where g is below the second number: woven cloth (some 1e-16 of the direction is left).
const FEWER: (usize, f64) = (6, 60.0);
/// [-] |B| below which a sheet is isotropic.
const ISOTROPIC: f64 = 1e-12;

/// Strain or stress in scaled axes: 11, 22, and 2 E12 or S12.
pub type Voigt<R = f64> = [R; 3];

/// The sheet of a rule, in scaled axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheet {
    /// [-] nu
    pub poisson: f64,
    /// [-] g
    pub compliance: f64,
    /// whether it wrinkles in place of carrying compression
    pub wrinkles: bool,
}

/// Whether a membrane is taut, wrinkled or slack, as a number: 0, 1 or 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrinkling {
    /// it carries tension in all directions, or it does not wrinkle
    Taut,
    /// it carries tension in one direction
    Wrinkled,
    /// it carries nothing
    Slack,
}

/// The direction of wrinkles: cos(phi) and sin(phi), and e and c there.
#[derive(Clone, Copy)]
struct Uniaxial<R> {
    cos: R,
    sin: R,
    e: R,
    c: R,
}

/// e and c over the direction: m + d cos(phi) + g sin(phi) and a + b cos^2(phi).
#[derive(Clone, Copy)]
struct Wave<R> {
    m: R,
    d: R,
    g: R,
    a: R,
    b: R,
}

impl<R: Real> Wave<R> {
    /// At w = tan(phi/2).
    #[inline(always)]
    fn at(&self, w: R) -> Uniaxial<R> {
        let (one, square) = (w.all(1.0), w * w);
        let size = one / (one + square);
        let (cos, sin) = ((one - square) * size, (w + w) * size);
        Uniaxial { cos, sin, e: self.m + self.d * cos + self.g * sin, c: self.a + self.b * cos * cos }
    }
}

/// 1 with the sign of x; 1 for 0.
#[inline(always)]
fn sign<R: Real>(x: R) -> R {
    x.all(1.0).where_not_negative(x) - x.all(1.0).where_positive(x.all(0.0) - x)
}

impl Sheet {
    fn a(&self) -> f64 {
        0.5 * (1.0 - self.poisson) + 0.25 * self.compliance
    }

    fn b(&self) -> f64 {
        let b = 0.5 * (1.0 + self.poisson) - 0.25 * self.compliance;
        if b.abs() < ISOTROPIC { 0.0 } else { b }
    }

    /// C^-1 E.
    #[inline(always)]
    fn full<R: Real>(&self, e: Voigt<R>) -> Voigt<R> {
        let (nu, factor) = (e[0].all(self.poisson), e[0].all(1.0 / (1.0 - self.poisson * self.poisson)));
        [factor * (e[0] + nu * e[1]), factor * (e[1] + nu * e[0]), e[2] * e[0].all(1.0 / self.compliance)]
    }

    /// Stress [N/m] at a strain.
    #[inline(always)]
    pub fn stress<R: Real>(&self, e: Voigt<R>) -> Voigt<R> {
        let full = self.full(e);
        if !self.wrinkles {
            return full;
        }
        let taut = smallest_principal(full);
        let wrinkles = e[0].all(0.0) - taut;
        if !wrinkles.any_positive() {
            return full;
        }
        let slack = largest(e);
        let u = self.uniaxial(e);
        let (one, half) = (e[0].all(1.0), e[0].all(0.5));
        let sigma = (u.e / u.c).where_positive(slack);
        let wrinkled = [half * sigma * (one + u.cos), half * sigma * (one - u.cos), half * sigma * u.sin];
        [
            full[0].where_not_negative(taut) + wrinkled[0].where_positive(wrinkles),
            full[1].where_not_negative(taut) + wrinkled[1].where_positive(wrinkles),
            full[2].where_not_negative(taut) + wrinkled[2].where_positive(wrinkles),
        ]
    }

    /// The direction in which e^2/c is largest.
    #[inline(always)]
    fn uniaxial<R: Real>(&self, strain: Voigt<R>) -> Uniaxial<R> {
        let (half, zero, one) = (strain[0].all(0.5), strain[0].all(0.0), strain[0].all(1.0));
        let [m, d, g] = [half * (strain[0] + strain[1]), half * (strain[0] - strain[1]), half * strain[2]];
        let r = (d * d + g * g).sqrt();
        let (a, b) = (half.all(self.a()), self.b());
        let isotropic = Uniaxial { cos: (d / r).where_positive(r), sin: (g / r).where_positive(r), e: m + r, c: a };
        if b == 0.0 {
            return isotropic;
        }
        // Mirrored, with w = tan(phi/2).
        let (b, d0, g0) = (half.all(b), d.abs(), g.abs());
        let mut w = (g0 / (r + d0)).where_positive(r);
        let [mut low, mut high] = [zero, one];
        let wave = Wave { m, d: d0, g: g0, a, b };
        let iterations = if self.compliance < FEWER.1 { FEWER.0 } else { ITERATIONS };
        for _ in 0..iterations {
            let Uniaxial { cos, sin, e, c } = wave.at(w);
            let (rate, bend) = (g0 * cos - d0 * sin, zero - (d0 * cos + g0 * sin));
            // Where e < 0 the way is to larger e.
            let e = e.larger(zero);
            let f = rate * c + e * b * cos * sin;
            let slope = bend * c - rate * b * cos * sin + e * b * (cos * cos - sin * sin);
            // f falls through 0 at the maximum.
            low = w.where_positive(f) + low.where_not_negative(zero - f);
            high = w.where_positive(zero - f) + high.where_not_negative(f);
            let step = (half * f * (one + w * w) / (zero - slope)).where_positive(zero - slope);
            let next = w + step;
            let inside = (next - low).smaller(high - next).where_positive(zero - slope);
            let middle = half * (low + high);
            w = next.where_not_negative(inside).where_positive(zero - slope)
                + middle.where_positive(zero - inside)
                + middle.where_not_negative(slope).where_not_negative(inside);
        }
        let found = wave.at(w);
        Uniaxial { cos: found.cos * sign(d), sin: found.sin * sign(g), ..found }
    }

    /// C^-1 E, with compression.
    pub fn taut_stress(&self, strain: Voigt) -> Voigt {
        self.full(strain)
    }

    /// What it is at a strain.
    pub fn wrinkling(&self, e: Voigt) -> Wrinkling {
        if !self.wrinkles || smallest_principal(self.full(e)) >= 0.0 {
            Wrinkling::Taut
        } else if largest(e) <= 0.0 {
            Wrinkling::Slack
        } else {
            Wrinkling::Wrinkled
        }
    }

    /// dS/dE, symmetric and positive semidefinite; at the limits between states that of the tauter one.
    pub fn tangent(&self, strain: Voigt) -> [Voigt; 3] {
        match self.wrinkling(strain) {
            Wrinkling::Slack => [[0.0; 3]; 3],
            Wrinkling::Taut => {
                let (nu, factor) = (self.poisson, 1.0 / (1.0 - self.poisson * self.poisson));
                [[factor, factor * nu, 0.0], [factor * nu, factor, 0.0], [0.0, 0.0, 1.0 / self.compliance]]
            }
            Wrinkling::Wrinkled => {
                let Uniaxial { cos, sin, e, c } = self.uniaxial(strain);
                let [m, b] = [0.5 * (strain[0] + strain[1]), self.b()];
                let rate = 0.5 * strain[2] * cos - 0.5 * (strain[0] - strain[1]) * sin;
                let t = [0.5 * (1.0 + cos), 0.5 * (1.0 - cos), 0.5 * sin];
                let turned = [-0.5 * sin, 0.5 * sin, 0.5 * cos];
                let mixed = [0, 1, 2].map(|i| (e * turned[i] - rate * t[i]) / c);
                let bend = 2.0 * b * (sin * sin - cos * cos);
                let curvature = (rate * rate - e * (e - m)) / c - e * e * bend / (2.0 * c * c);
                [0, 1, 2].map(|i| [0, 1, 2].map(|j| t[i] * t[j] / c - mixed[i] * mixed[j] / curvature))
            }
        }
    }
}

/// The larger principal value of a strain.
#[inline(always)]
fn largest<R: Real>(e: Voigt<R>) -> R {
    let half = e[0].all(0.5);
    let (d, g) = (half * (e[0] - e[1]), half * e[2]);
    half * (e[0] + e[1]) + (d * d + g * g).sqrt()
}

/// The smaller principal value of a stress.
#[inline(always)]
fn smallest_principal<R: Real>(s: Voigt<R>) -> R {
    let half = s[0].all(0.5);
    let d = half * (s[0] - s[1]);
    half * (s[0] + s[1]) - (d * d + s[2] * s[2]).sqrt()
}

#[cfg(test)]
mod tests;
