//! The recurrences, written down by hand from the literature and not from the program: as matrix polynomials, two-step
//! formulas or one equation for the new acceleration.

use super::bench::{Case, Damper, Oscillator};
use crate::common::polynomials::stability_polynomial;

/// x, v, a of the recurrence; `a` is the acceleration that the method itself carries.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    pub x: f64,
    pub v: f64,
    pub a: f64,
}

type Matrix = [[f64; 2]; 2];

fn product(a: Matrix, b: Matrix) -> Matrix {
    [0, 1].map(|i| [0, 1].map(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
}

/// R(h A) y for x' = A y + (0, g) with the polynomial R of a Runge-Kutta method; the forcing enters through
/// (R(h A) - 1)/(h A).
fn polynomial(o: Oscillator, h: f64, coefficients: &[f64], m: Motion) -> Motion {
    let za = [[0.0, h], [-h * o.frequency.powi(2), -h * o.d()]];
    let mut power = [[1.0, 0.0], [0.0, 1.0]];
    let mut y = [m.x, m.v];
    for c in &coefficients[1..] {
        // h g (hA)^(k-1) before, (hA)^k after the power is raised.
        for (i, y) in y.iter_mut().enumerate() {
            *y += power[i][1] * h * o.push * c;
        }
        power = product(za, power);
        for (i, y) in y.iter_mut().enumerate() {
            *y += (power[i][0] * m.x + power[i][1] * m.v) * c;
        }
    }
    Motion { x: y[0], v: y[1], a: 0.0 }
}

/// Weights of M [(1 - am) a1 + am a0] = (1 - af) f1 + af f0 with Newmark's x1 and v1.
struct Weighted {
    beta: f64,
    gamma: f64,
    am: f64,
    af: f64,
}

/// One linear equation for a1 (the program solves for the displacement instead).
fn newmark_family(o: Oscillator, h: f64, w: &Weighted, m: Motion) -> Motion {
    let Weighted { beta, gamma, am, af } = *w;
    let x_predicted = m.x + h * m.v + h * h * (0.5 - beta) * m.a;
    let v_predicted = m.v + h * (1.0 - gamma) * m.a;
    let right = (1.0 - af) * o.a(x_predicted, v_predicted) + af * o.a(m.x, m.v) - am * m.a;
    let left = (1.0 - am) + (1.0 - af) * (gamma * h * o.d() + beta * h * h * o.frequency.powi(2));
    let a = right / left;
    Motion { x: x_predicted + beta * h * h * a, v: v_predicted + gamma * h * a, a }
}

/// The states that PEC *predicts* follow Adams-Bashforth 2 after one step of Euler; the corrected state is
/// y_n = p_n + h/2 (p'_n - p'_{n-1}).
fn adams_bashforth(o: Oscillator, h: f64, start: Motion, steps: usize) -> Vec<Motion> {
    let slope = |p: [f64; 2]| [p[1], o.a(p[0], p[1])];
    let mut p = [start.x, start.v];
    let mut before = slope(p);
    p = [0, 1].map(|i| p[i] + h * before[i]);
    let mut motions = Vec::new();
    for _ in 0..steps {
        let now = slope(p);
        let y = [0, 1].map(|i| p[i] + 0.5 * h * (now[i] - before[i]));
        motions.push(Motion { x: y[0], v: y[1], a: 0.0 });
        p = [0, 1].map(|i| p[i] + h * (1.5 * now[i] - 0.5 * before[i]));
        before = now;
    }
    motions
}

/// Beeman's step, from the accelerations of the two steps before; the first step has one of them.
fn beeman(o: Oscillator, h: f64, start: Motion, steps: usize) -> Vec<Motion> {
    let Motion { mut x, mut v, .. } = start;
    let mut a = o.a(x, v);
    let mut before = None;
    let mut step = || {
        let last = before.replace(a);
        let (far, seen) = match last {
            Some(last) => (x + h * v + h * h / 6.0 * (4.0 * a - last), v + h / 2.0 * (3.0 * a - last)),
            None => (x + h * v + h * h / 2.0 * a, v + h * a),
        };
        let next = o.a(far, seen);
        v += match last {
            Some(last) => h / 12.0 * (5.0 * next + 8.0 * a - last),
            None => h / 2.0 * (next + a),
        };
        (x, a) = (far, next);
        Motion { x, v, a }
    };
    (0..steps).map(|_| step()).collect()
}

/// Half a long kick by all but spring and dashpot, m steps of central differences with these, half a long kick.
fn multirate(o: Oscillator, (h, m): (f64, f64), damper: Damper, start: Motion, steps: usize) -> Vec<Motion> {
    let along_spring = [Damper::Axial, Damper::Relative, Damper::FromStep].contains(&damper);
    let d = if along_spring { o.d() } else { 0.0 };
    let spring = |x: f64, v: f64| -o.frequency.powi(2) * x - d * v;
    let others = |v: f64| o.push - (o.d() - d) * v;
    let Motion { mut x, mut v, .. } = start;
    let (mut s, mut g) = (spring(x, v), others(v));
    let mut step = || {
        v += 0.5 * h * g;
        for _ in 0..m as usize {
            v += 0.5 * h / m * s;
            x += h / m * v;
            s = spring(x, v);
            v += 0.5 * h / m * s;
        }
        g = others(v);
        v += 0.5 * h * g;
        Motion { x, v, a: 0.0 }
    };
    (0..steps).map(|_| step()).collect()
}

/// dv = F h/(m + h^2 k) with F = -k x + h k (0 - v); damping and load act outside the filter.
fn kang(o: Oscillator, h: f64, damper: Damper, m: Motion) -> Motion {
    let k = o.frequency.powi(2);
    let filtered = -k * m.x - h * k * m.v;
    // A "step" dashpot is the h k (0 - v) above and does not act again, whatever its coefficient is.
    let outside = o.push - if damper == Damper::FromStep { 0.0 } else { o.d() * m.v };
    let v = m.v + filtered * h / (1.0 + h * h * k) + h * outside;
    Motion { x: m.x + h * v, v, a: 0.0 }
}

/// n substeps of backward Euler with spring and dashpot; damping of other kinds and the load act from their start.
fn springs_alone(o: Oscillator, (h, n): (f64, f64), damper: Damper, m: Motion) -> Motion {
    let along_spring = [Damper::Axial, Damper::Relative, Damper::FromStep].contains(&damper);
    let (d, h) = (if along_spring { o.d() } else { 0.0 }, h / n);
    let mut m = m;
    for _ in 0..n as usize {
        let pushed = m.v + h * (o.push - (o.d() - d) * m.v);
        let v = (pushed - h * o.frequency.powi(2) * m.x) / (1.0 + h * d + (h * o.frequency).powi(2));
        m = Motion { x: m.x + h * v, v, a: 0.0 };
    }
    m
}

/// (I - h A) y1 = y0 + h (0, g), solved by Cramer's rule.
fn backward_euler(o: Oscillator, h: f64, m: Motion) -> Motion {
    let (w2, d) = (o.frequency.powi(2), o.d());
    let det = 1.0 + h * d + h * h * w2;
    let right = m.v + h * o.push;
    Motion { x: ((1.0 + h * d) * m.x + h * right) / det, v: (right - h * w2 * m.x) / det, a: 0.0 }
}

/// ARK4(3)6L[2]SA of Kennedy & Carpenter 2003, the implicit part: y_i = y_n + h sum_{j<i} a_ij k_j + (h/4) k_i, of
/// which the last is the result.
fn esdirk4(o: Oscillator, h: f64, m: Motion) -> Motion {
    let rows: [&[f64]; 5] = [
        &[1.0 / 4.0],
        &[8611.0 / 62500.0, -1743.0 / 31250.0],
        &[5012029.0 / 34652500.0, -654441.0 / 2922500.0, 174375.0 / 388108.0],
        &[15267082809.0 / 155376265600.0, -71443401.0 / 120774400.0, 730878875.0 / 902184768.0, 2285395.0 / 8070912.0],
        &[82889.0 / 524892.0, 0.0, 15625.0 / 83664.0, 69875.0 / 102672.0, -2260.0 / 8211.0],
    ];
    let mut slopes = vec![(m.v, o.a(m.x, m.v))];
    let mut stage = m;
    for row in rows {
        let (mut x, mut v) = (m.x, m.v);
        for (a, (slope_x, slope_v)) in row.iter().zip(&slopes) {
            x += h * a * slope_x;
            v += h * a * slope_v;
        }
        stage = backward_euler(o, h / 4.0, Motion { x, v, a: 0.0 });
        slopes.push((stage.v, o.a(stage.x, stage.v)));
    }
    stage
}

/// x1 - x0 = h u and v1 - v0 = 2 (u - v0) with u = (v0 + v1)/2; the spring acts at x0 + (1 + chi) h u/2.
fn energy_momentum(o: Oscillator, h: f64, chi: f64, m: Motion) -> Motion {
    let w2 = o.frequency.powi(2);
    let u = (2.0 * m.v - h * w2 * m.x + h * o.push) / (2.0 + 0.5 * (1.0 + chi) * h * h * w2 + h * o.d());
    Motion { x: m.x + h * u, v: 2.0 * u - m.v, a: 0.0 }
}

impl Case {
    /// The recurrence, `steps` steps from rest of everything but x and v.
    pub fn expected(&self, o: Oscillator, h: f64, damper: Damper, start: Motion, steps: usize) -> Vec<Motion> {
        let newmark = |beta, gamma| Weighted { beta, gamma, am: 0.0, af: 0.0 };
        let runge_kutta = stability_polynomial(self.method);
        let step: Box<dyn Fn(Motion) -> Motion> = match self.method {
            _ if runge_kutta.is_some() => {
                let coefficients = runge_kutta.unwrap_or_default();
                Box::new(move |m| polynomial(o, h, &coefficients, m))
            }
            "multirate" if self.value("substeps", 6.0) > 1.0 => {
                return multirate(o, (h, self.value("substeps", 6.0)), damper, start, steps);
            }
            "beeman" => return beeman(o, h, start, steps),
            "improved-euler-pec" => return adams_bashforth(o, h, start, steps),
            "euler-cromer" => Box::new(move |m| {
                // x_{n+1} from its own row of the matrix [[1 - w^2 h^2, h - d h^2], [-w^2 h, 1 - d h]].
                let (w2, d) = (o.frequency.powi(2), o.d());
                let x = (1.0 - w2 * h * h) * m.x + (h - d * h * h) * m.v + h * h * o.push;
                Motion { x, v: -w2 * h * m.x + (1.0 - d * h) * m.v + h * o.push, a: 0.0 }
            }),
            "velocity-verlet" => Box::new(move |m| {
                let a = o.a(m.x, m.v);
                let x = m.x + h * m.v + 0.5 * h * h * a;
                let star = o.a(x, m.v + h * a);
                Motion { x, v: m.v + 0.5 * h * (a + star), a: 0.0 }
            }),
            // The carried acceleration is the one at the velocity of the middle.
            "central-difference" | "multirate" => Box::new(move |m| {
                let middle = m.v + 0.5 * h * m.a;
                let x = m.x + h * middle;
                let a = o.a(x, middle);
                Motion { x, v: middle + 0.5 * h * a, a }
            }),
            "newmark" => {
                let w = newmark(self.value("beta", 0.25), self.value("gamma", 0.5));
                Box::new(move |m| newmark_family(o, h, &w, m))
            }
            "hht" => {
                let alpha = self.value("alpha", -0.1);
                let w = Weighted { beta: (1.0 - alpha).powi(2) / 4.0, gamma: 0.5 - alpha, am: 0.0, af: -alpha };
                Box::new(move |m| newmark_family(o, h, &w, m))
            }
            "generalized-alpha" => {
                let r = self.value("rho_inf", 0.8);
                let (am, af) = ((2.0 * r - 1.0) / (r + 1.0), r / (r + 1.0));
                let w = Weighted { beta: (1.0 - am + af).powi(2) / 4.0, gamma: 0.5 - am + af, am, af };
                Box::new(move |m| newmark_family(o, h, &w, m))
            }
            "backward-euler" => Box::new(move |m| backward_euler(o, h, m)),
            "esdirk4" => Box::new(move |m| esdirk4(o, h, m)),
            "energy-momentum" => {
                let chi = self.value("dissipation", 0.0);
                Box::new(move |m| energy_momentum(o, h, chi, m))
            }
            "xpbd" => Box::new(move |m| springs_alone(o, (h, self.value("substeps", 10.0)), damper, m)),
            "vbd" => Box::new(move |m| springs_alone(o, (h, 1.0), damper, m)),
            "kang" => Box::new(move |m| kang(o, h, damper, m)),
            other => panic!("write the recurrence of {other} here"),
        };
        let mut m = Motion { a: o.a(start.x, start.v), ..start };
        let mut advance = || {
            m = step(m);
            m
        };
        (0..steps).map(|_| advance()).collect()
    }
}
