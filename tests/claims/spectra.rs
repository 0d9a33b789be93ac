//! Spectral radius, period error and numerical damping of the Newmark family over w h from 0.01 to 100, from one real
//! step of the program at unit position, velocity and carried acceleration, against the formulas of the literature.
//!
//! A1, A2 and A3 are those of Hughes 1987, chapter 9 (Newmark), of Hilber, Hughes & Taylor 1977 (HHT) and of the
//! characteristic polynomial in [`crate::linear_theory`] (generalised alpha, Chung & Hulbert 1993). Leading terms at
//! small W = w h: with the logarithm of that polynomial, whose factors are generating functions of distributions on 0,
//! 1 and 2, a method of order 2 has
//! ```text
//! (T_num - T)/T = -c2 W^2/2,  xi = c3 W^3/2
//! c2 = 1/12 + [am (1 - am) - af (1 - af)]/2 - [2 beta + 1/4 - gamma^2]/2
//! c3 = [kappa(am) - kappa(af) - kappa_N]/6,  kappa(q) = q (1 - q)(2 q - 1)
//! ```
//! with kappa_N the third cumulant of the weights beta, 1/2 - 2 beta + gamma, 1/2 + beta - gamma at 2, 1, 0.

use crate::claim::Claim;
use crate::linear_theory::{Character, Invariants, Member, Named, eigenvalues, generalized_alpha, hht, newmark};
use crate::one_mass::{START, case, frequency};
use canopy_fem::integrate::stepper::Attempt;
use canopy_fem::integrate::{CarriedState, Counters};
use canopy_fem::model::point::Point;
use canopy_fem::simulation::{bind, build_scene};

/// Rounding of the matrix, and of its eigenvalues, of which two nearly meet at both ends of the range.
const ROUNDING: f64 = 3e-14;
const EIGENVALUE: f64 = 2e-12;
/// The angle of a step, 0.01 at the least, has lost two digits more.
const ANGLE: f64 = 3e-11;

pub fn claims() -> Vec<Claim> {
    let newmarks = [(0.25, 0.5), (0.3, 0.5), (0.5, 0.5), (1.0 / 6.0, 0.5), (0.3025, 0.6), (0.5, 1.0)];
    let alphas = [0.0, -0.05, -0.1, -0.2, -0.3, -1.0 / 3.0];
    let radii = [0.0, 0.2, 0.5, 0.8, 0.9, 1.0];
    let mut claims = Vec::new();
    for (beta, gamma) in newmarks {
        let named = newmark(beta, gamma);
        over_the_range(&named, Some(hughes(named.member)), &mut claims);
        near_zero(&named, &mut claims);
    }
    for alpha in alphas {
        let named = hht(alpha);
        over_the_range(&named, Some(hilber(alpha)), &mut claims);
        near_zero(&named, &mut claims);
        // Two roots meet at -(1 + alpha)/(1 - alpha), some 1/W of the way apart across the real axis.
        at_infinity(&named, [1.0, 1.0].map(|s| -s * (1.0 + alpha) / (1.0 - alpha)), alpha / (1.0 + alpha), &mut claims);
    }
    for r in radii {
        let named = generalized_alpha(r);
        over_the_range(&named, None, &mut claims);
        near_zero(&named, &mut claims);
        at_infinity(&named, [-r, -r], -r, &mut claims);
    }
    claims
}

/// The matrix of one step of the program on (x, v/w, a/w^2) at w h = `wh`, row by row.
fn amplification(named: &Named, wh: f64) -> [[f64; 3]; 3] {
    let w = frequency();
    let h = wh / w;
    let case = case(&named.method, h, 1);
    let mut problem = case.problem().clone();
    let scene = build_scene(problem.take_system(), 1).expect("the case is good");
    let mut start = Point { state: scene.initial_state(), forces: scene.new_forces() };
    let dof = (0..scene.n_dof()).find(|&i| scene.inverse_mass()[i] > 0.0).expect("the mass moves");
    let mut matrix = [[0.0; 3]; 3];
    // In a long step a velocity or acceleration of the size of START would carry the mass through its anchor.
    let scales = [1.0, w / wh.max(1.0), (w / wh.max(1.0)).powi(2)];
    for (column, scale) in scales.into_iter().enumerate() {
        let unit = |i: usize| if i == column { START * scale } else { 0.0 };
        (start.state.x[dof], start.state.v[dof]) = (unit(0), unit(1));
        scene.evaluate(start.state.as_ref(), &mut start.forces);
        let mut stepper = bind(&problem, &*scene).expect("the method fits the scene");
        stepper.start(&start).expect("a small scene");
        let mut carried = vec![0.0; scene.n_dof()];
        carried[dof] = unit(2);
        stepper
            .restore(&CarriedState { vectors: vec![carried], made_with: 0.0, ..CarriedState::default() })
            .expect("an acceleration is what the family carries");
        let mut to = start.clone();
        let step = Attempt { from: &start, h, t_next: h };
        stepper.attempt(step, &mut to, &mut Counters::default()).expect("an easy step");
        stepper.accept();
        let a = stepper.save().vectors[0][dof];
        let of_unit = w.powi(column as i32) / (START * scale);
        for (row, value) in [to.state.x[dof], to.state.v[dof] / w, a / (w * w)].into_iter().enumerate() {
            matrix[row][column] = value * of_unit;
        }
    }
    matrix
}

fn invariants(m: [[f64; 3]; 3]) -> Invariants {
    let minor = |i: usize, j: usize| m[i][i] * m[j][j] - m[i][j] * m[j][i];
    let cofactor = |j: usize, k: usize| m[1][j] * m[2][k] - m[1][k] * m[2][j];
    Invariants {
        trace: m[0][0] + m[1][1] + m[2][2],
        minors: minor(0, 1) + minor(0, 2) + minor(1, 2),
        determinant: m[0][0] * cofactor(1, 2) - m[0][1] * cofactor(0, 2) + m[0][2] * cofactor(0, 1),
    }
}

type Formula = Box<dyn Fn(f64) -> Invariants>;

/// 2 A1 and A2 of Newmark without damping; the third root is 0.
fn hughes(Member { beta, gamma, .. }: Member) -> Formula {
    Box::new(move |wh| {
        let share = wh * wh / (1.0 + beta * wh * wh);
        Invariants { trace: 2.0 - share * (gamma + 0.5), minors: 1.0 - share * (gamma - 0.5), determinant: 0.0 }
    })
}

/// 2 A1, A2 and A3 of HHT without damping.
fn hilber(alpha: f64) -> Formula {
    let Member { beta, gamma, .. } = hht(alpha).member;
    Box::new(move |wh| {
        let share = wh * wh / (1.0 + (1.0 + alpha) * beta * wh * wh);
        Invariants {
            trace: 2.0 - share * ((1.0 + alpha) * (gamma + 0.5) - alpha * beta),
            minors: 1.0 - share * (gamma - 0.5 + 2.0 * alpha * (gamma - beta)),
            determinant: alpha * share * (beta - gamma + 0.5),
        }
    })
}

fn worst(of: impl Iterator<Item = f64>) -> f64 {
    of.fold(0.0, |m, x| if x.is_nan() { f64::NAN } else { m.max(x.abs()) })
}

/// Forty-one values of w h from 0.01 to 100.
fn over_the_range(named: &Named, formula: Option<Formula>, claims: &mut Vec<Claim>) {
    let name = named.name();
    let (mut coefficients, mut radius, mut period, mut damping) = (vec![], vec![], vec![], vec![]);
    for wh in (0..=40).map(|i| 10f64.powf(-2.0 + 0.1 * f64::from(i))) {
        let matrix = amplification(named, wh);
        let expected = formula.as_ref().map_or(named.member.invariants(wh), |f| f(wh));
        let pairs = invariants(matrix).array().into_iter().zip(expected.array());
        coefficients.push(worst(pairs.map(|(a, b)| a - b)));
        let (found, known) = (Character::of(eigenvalues(matrix), wh), Character::of(expected.roots(), wh));
        radius.push(found.radius - known.radius);
        let differ = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => a - b,
            (None, None) => 0.0,
            // one sees a pair of complex roots where the other sees two real ones
            _ => f64::NAN,
        };
        period.push(differ(found.period_error, known.period_error) / (1.0 + wh));
        damping.push(differ(found.damping, known.damping));
    }
    let mut claim = |what: &str, off: Vec<f64>, bound| {
        claims.push(Claim::below(format!("{name}: {what}, w h 0.01 .. 100, worst"), worst(off.into_iter()), bound));
    };
    claim("A1, A2, A3 of the step", coefficients, ROUNDING);
    claim("spectral radius", radius, EIGENVALUE);
    claim("period error over 1 + w h", period, ANGLE);
    claim("numerical damping ratio", damping, EIGENVALUE);
}

/// Leading terms of period error and damping at w h = 0.02; the next terms are some W^2 of them.
fn near_zero(named: &Named, claims: &mut Vec<Claim>) {
    let (wh, Member { beta, gamma, am, af }) = (0.02_f64, named.member);
    let found = Character::of(eigenvalues(amplification(named, wh)), wh);
    let second_order = (0.5 - am + af - gamma).abs() < 1e-12;
    let c2 = 1.0 / 12.0 + (am * (1.0 - am) - af * (1.0 - af)) / 2.0 - (2.0 * beta + 0.25 - gamma * gamma) / 2.0;
    let kappa = |q: f64| q * (1.0 - q) * (2.0 * q - 1.0);
    let (m1, m2, m3) = (gamma + 0.5, 2.0 * beta + gamma + 0.5, 6.0 * beta + gamma + 0.5);
    let c3 = (kappa(am) - kappa(af) - (m3 - 3.0 * m1 * m2 + 2.0 * m1.powi(3))) / 6.0;
    let name = named.name();
    // Damping is the third power of W: rounding 1e-16 is some 1e-9 of it.
    let next = |c: f64| 2.5 * wh * wh * c.abs() + 2e-8;
    let period = found.period_error.unwrap_or(f64::NAN) / wh.powi(2);
    let damping = found.damping.unwrap_or(f64::NAN);
    if second_order {
        claims.push(Claim::absolute(format!("{name}: period error over W^2, w h 0.02"), period, -c2 / 2.0, next(c2)));
        let what = format!("{name}: numerical damping over W^3, w h 0.02");
        claims.push(Claim::absolute(what, damping / wh.powi(3), c3 / 2.0, next(c3)));
    } else {
        // gamma beyond 1/2 costs an order: xi = (gamma - 1/2) W/2.
        let what = format!("{name}: numerical damping over W, w h 0.02");
        claims.push(Claim::absolute(what, damping / wh, (gamma - 0.5) / 2.0, next(gamma - 0.5)));
    }
}

/// At w h = 1000 the polynomial of the step is that of its limit, but for some 1/W^2.
fn at_infinity(named: &Named, [p, q]: [f64; 2], s: f64, claims: &mut Vec<Claim>) {
    let wh = 1e3_f64;
    let matrix = amplification(named, wh);
    let limit = Invariants { trace: p + q + s, minors: p * q + p * s + q * s, determinant: p * q * s };
    let off = worst(invariants(matrix).array().into_iter().zip(limit.array()).map(|(a, b)| a - b));
    let name = named.name();
    claims.push(Claim::below(
        format!("{name}: A1, A2, A3 at w h 1000 against roots {p:.4}, {q:.4}, {s:.4}"),
        off,
        20.0 / (wh * wh),
    ));
    // Roots that meet move apart by the third root of 1/W^2 at most.
    let radius = Character::of(eigenvalues(matrix), wh).radius;
    claims.push(Claim::absolute(
        format!("{name}: spectral radius at w h 1000"),
        radius,
        p.abs(),
        2.0 * wh.powf(-2.0 / 3.0),
    ));
}
