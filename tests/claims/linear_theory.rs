//! The Newmark family on x'' = -w^2 x, from the literature and not from the program.
//!
//! Newmark's displacements and accelerations obey (Hughes 1987, section 9.1; Wood 1990, chapter 3)
//! ```text
//! x_{n+2} - 2 x_{n+1} + x_n = h^2 [beta a_{n+2} + (1/2 - 2 beta + gamma) a_{n+1} + (1/2 + beta - gamma) a_n]
//! ```
//! and all members balance (1 - am) a_{n+1} + am a_n = -w^2 [(1 - af) x_{n+1} + af x_n]. With x_n ~ lambda^n and W = w
//! h the amplification matrix therefore has the characteristic polynomial
//! ```text
//! (z - 1)^2 [(1 - am) z + am] + W^2 [(1 - af) z + af] [beta z^2 + (1/2 - 2 beta + gamma) z + (1/2 + beta - gamma)]
//! ```

use faer::{Mat, c64};
use serde_json::{Value, json};

/// A member of the family.
#[derive(Clone, Copy, Debug)]
pub struct Member {
    pub beta: f64,
    pub gamma: f64,
    pub am: f64,
    pub af: f64,
}

/// A member under its name in a case file.
#[derive(Clone, Debug)]
pub struct Named {
    pub method: Value,
    pub member: Member,
}

impl Named {
    pub fn name(&self) -> String {
        method_name(&self.method)
    }
}

/// `hht alpha -0.1`
pub fn method_name(method: &Value) -> String {
    let text = method.to_string().replace([':', ','], " ");
    text.chars().filter(|c| !"{}\"".contains(*c)).collect()
}

pub fn newmark(beta: f64, gamma: f64) -> Named {
    let method = json!({"newmark": {"beta": beta, "gamma": gamma}});
    Named { method, member: Member { beta, gamma, am: 0.0, af: 0.0 } }
}

/// Hilber, Hughes & Taylor 1977.
pub fn hht(alpha: f64) -> Named {
    let member = Member { beta: 0.25 * (1.0 - alpha).powi(2), gamma: 0.5 - alpha, am: 0.0, af: -alpha };
    Named { method: json!({"hht": {"alpha": alpha}}), member }
}

/// Chung & Hulbert 1993.
pub fn generalized_alpha(r: f64) -> Named {
    let (am, af) = ((2.0 * r - 1.0) / (r + 1.0), r / (r + 1.0));
    let member = Member { beta: 0.25 * (1.0 - am + af).powi(2), gamma: 0.5 - am + af, am, af };
    Named { method: json!({"generalized-alpha": {"rho_inf": r}}), member }
}

/// What an amplification matrix is, whatever its basis: z^3 - trace z^2 + minors z - determinant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Invariants {
    /// Hilber's 2 A1
    pub trace: f64,
    /// Hilber's A2
    pub minors: f64,
    /// Hilber's A3
    pub determinant: f64,
}

impl Invariants {
    pub fn array(self) -> [f64; 3] {
        [self.trace, self.minors, self.determinant]
    }

    /// Eigenvalues of the companion matrix.
    pub fn roots(self) -> [c64; 3] {
        let companion = [[self.trace, -self.minors, self.determinant], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        eigenvalues(companion)
    }
}

pub fn eigenvalues(matrix: [[f64; 3]; 3]) -> [c64; 3] {
    let values = Mat::from_fn(3, 3, |i, j| matrix[i][j]).eigenvalues().expect("a finite matrix");
    [values[0], values[1], values[2]]
}

impl Member {
    pub fn invariants(self, wh: f64) -> Invariants {
        let Member { beta, gamma, am, af } = self;
        let w2 = wh * wh;
        let displacements = [0.5 + beta - gamma, 0.5 - 2.0 * beta + gamma, beta];
        let mut p = [0.0; 4];
        for (i, weight) in [(0, am), (1, 1.0 - am)] {
            for (j, c) in [1.0, -2.0, 1.0].into_iter().enumerate() {
                p[i + j] += weight * c;
            }
        }
        for (i, weight) in [(0, af), (1, 1.0 - af)] {
            for (j, c) in displacements.into_iter().enumerate() {
                p[i + j] += w2 * weight * c;
            }
        }
        Invariants { trace: -p[2] / p[3], minors: p[1] / p[3], determinant: -p[0] / p[3] }
    }

    pub fn character(self, wh: f64) -> Character {
        Character::of(self.invariants(wh).roots(), wh)
    }
}

/// What a scheme does to a free oscillation (Hughes 1987, section 9.3).
#[derive(Clone, Copy, Debug)]
pub struct Character {
    /// largest |eigenvalue|
    pub radius: f64,
    /// (T_num - T)/T of the principal pair exp(W_num (-xi +- i)); nothing when it is real
    pub period_error: Option<f64>,
    /// xi, numerical damping ratio of that pair
    pub damping: Option<f64>,
}

impl Character {
    pub fn of(roots: [c64; 3], wh: f64) -> Self {
        let size = |z: &c64| z.re.hypot(z.im);
        let radius = roots.iter().map(size).fold(0.0, f64::max);
        let principal = roots.iter().filter(|z| z.im > 1e-7).max_by(|a, b| size(a).total_cmp(&size(b)));
        let angle = principal.map(|z| z.im.atan2(z.re));
        Character {
            radius,
            period_error: angle.map(|a| wh / a - 1.0),
            damping: principal.zip(angle).map(|(z, a)| -size(z).ln() / a),
        }
    }
}
