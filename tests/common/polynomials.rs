//! What Runge-Kutta methods do to y' = z y in one step: R(z) as a polynomial, from the literature and not from the
//! program.

/// Coefficients of z^9 to z^12 of DOP853: b A^(k-1) 1 of the tableau as printed, in exact rational arithmetic.
const DOP853: [f64; 4] =
    [2.691_692_200_169_085_6e-6, 2.341_345_108_209_78e-7, 1.494_736_485_459_154_7e-8, 3.613_324_578_128_244e-10];

/// Coefficients of z^0, z^1, ...; nothing for a method that is none of Runge and Kutta's.
pub fn stability_polynomial(method: &str) -> Option<Vec<f64>> {
    let (order, beyond): (usize, &[f64]) = match method {
        "explicit-euler" => (1, &[]),
        "euler-richardson" | "improved-euler" => (2, &[]),
        "rk4" => (4, &[]),
        // Dormand & Prince 1980: z^6/600
        "dormand-prince" => (5, &[1.0 / 600.0]),
        "dop853" => (8, &DOP853),
        _ => return None,
    };
    let mut coefficients = vec![1.0];
    for k in 1..=order {
        coefficients.push(coefficients[k - 1] / k as f64);
    }
    coefficients.extend(beyond);
    Some(coefficients)
}

/// |R(i y)| of ESDIRK4: with five stages of gamma = 1/4, order 4 and R = 0 at infinity, R (1 - z/4)^5 is the part of
/// exp(z) (1 - z/4)^5 up to z^4 (Hairer & Wanner 1996, section IV.6).
pub fn esdirk4_size(y: f64) -> f64 {
    let numerator = [1.0, -1.0 / 4.0, -1.0 / 8.0, 1.0 / 96.0, 7.0 / 768.0];
    size(&numerator, (0.0, y)) / 1.0_f64.hypot(0.25 * y).powi(5)
}

/// |R(x + i y)|, by Horner.
pub fn size(coefficients: &[f64], (x, y): (f64, f64)) -> f64 {
    let (mut a, mut b) = (0.0, 0.0);
    for c in coefficients.iter().rev() {
        (a, b) = (c + a * x - b * y, a * y + b * x);
    }
    f64::hypot(a, b)
}
