//! Eigenvalues of a small real upper Hessenberg matrix by the QR iteration of nalgebra, and single eigenvectors by
//! inverse iteration.
//!
//! The iteration has a bound, which that of faer 0.24.4 has not: it does not return from some of the matrices met here.

use faer::{Mat, c64};
use nalgebra::{DMatrix, Schur};

/// QR iterations for one eigenvalue at most; 2 to 4 are usual.
const ITERATIONS: usize = 60;
/// Solves of an inverse iteration at most; one is mostly enough.
const SOLVES: usize = 3;

/// All eigenvalues of H [m x m], those of a conjugate pair one after the other; `None` where an entry is not finite or
/// the bound of iterations is reached.
pub(super) fn eigenvalues(h: &Mat<f64>) -> Option<Vec<c64>> {
    let (m, size) = (h.nrows(), size(h));
    if size == 0.0 {
        return Some(vec![c64::new(0.0, 0.0); m]);
    }
    if !size.is_finite() {
        return None;
    }
    let scaled = DMatrix::from_fn(m, m, |i, j| h[(i, j)] / size);
    let values = Schur::try_new(scaled, f64::EPSILON, ITERATIONS * m)?.complex_eigenvalues();
    // Where two real eigenvalues are nearly one, rounding makes the library take the root of a negative number.
    let imaginary = |value: &c64| if value.im.is_nan() { 0.0 } else { value.im };
    Some(values.iter().map(|value| size * c64::new(value.re, imaginary(value))).collect())
}

/// A unit vector u with H u = value u but for a residual of the given size.
pub(super) struct Eigenvector {
    pub u: Vec<c64>,
    /// size of H u - value u
    pub residual: f64,
}

/// The eigenvector of an eigenvalue; that with the least residual of at most three solves, the first of which is the
/// best where eigenvectors are nearly parallel (Wilkinson 1979).
pub(super) fn eigenvector(h: &Mat<f64>, value: c64) -> Eigenvector {
    let size = size(h).max(f64::MIN_POSITIVE);
    let lu = Shifted::of(&scaled(h, size), value / size);
    let start = 1.0 / (h.nrows() as f64).sqrt();
    let mut best = Eigenvector { u: vec![c64::new(start, 0.0); h.nrows()], residual: f64::INFINITY };
    for _ in 0..SOLVES {
        let mut u = best.u.clone();
        lu.solve(&mut u);
        let grown = u.iter().map(|u| u.norm_sqr()).sum::<f64>().sqrt();
        if !(grown.is_finite() && 1.0 / grown < best.residual) {
            break;
        }
        u.iter_mut().for_each(|u| *u /= grown);
        best = Eigenvector { u, residual: 1.0 / grown };
    }
    Eigenvector { residual: size * best.residual, ..best }
}

fn scaled(h: &Mat<f64>, size: f64) -> Mat<f64> {
    Mat::from_fn(h.nrows(), h.ncols(), |i, j| h[(i, j)] / size)
}

/// Largest sum of a row and what lies below its diagonal.
fn size(h: &Mat<f64>) -> f64 {
    let row = |i: usize| (i.saturating_sub(1)..h.ncols()).map(|j| h[(i, j)].abs()).sum::<f64>();
    // Unlike `f64::max` this keeps what is no number.
    (0..h.nrows()).map(row).fold(0.0, |a, b| if b.is_nan() || b > a { b } else { a })
}

/// H - value I, for H of size 1, factorised with row exchanges; pivots of the size of rounding stand for 0.
struct Shifted {
    rows: Vec<Vec<c64>>,
    /// multiplier of each row in the one below it, and whether the two were exchanged
    steps: Vec<(c64, bool)>,
}

impl Shifted {
    fn of(h: &Mat<f64>, value: c64) -> Self {
        let m = h.nrows();
        let entry = |i: usize, j: usize| c64::new(h[(i, j)], 0.0) - if i == j { value } else { c64::new(0.0, 0.0) };
        let mut rows: Vec<Vec<c64>> = (0..m).map(|i| (0..m).map(|j| entry(i, j)).collect()).collect();
        let least = f64::EPSILON;
        let mut steps = Vec::with_capacity(m.saturating_sub(1));
        for k in 0..m {
            let exchanged = k + 1 < m && rows[k + 1][k].norm_sqr() > rows[k][k].norm_sqr();
            if exchanged {
                rows.swap(k, k + 1);
            }
            if rows[k][k].norm_sqr() < least * least {
                rows[k][k] = c64::new(least, 0.0);
            }
            let (above, below) = rows.split_at_mut(k + 1);
            if let (Some(row), Some(next)) = (above.last(), below.first_mut()) {
                let factor = next[k] / row[k];
                next.iter_mut().zip(row).skip(k).for_each(|(next, row)| *next -= factor * row);
                steps.push((factor, exchanged));
            }
        }
        Shifted { rows, steps }
    }

    fn solve(&self, b: &mut [c64]) {
        for (k, &(factor, exchanged)) in self.steps.iter().enumerate() {
            if exchanged {
                b.swap(k, k + 1);
            }
            b[k + 1] -= factor * b[k];
        }
        for (k, row) in self.rows.iter().enumerate().rev() {
            let known: c64 = row.iter().zip(b.iter()).skip(k + 1).map(|(a, b)| a * b).sum();
            b[k] = (b[k] - known) / row[k];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::random::pseudo_random;

    /// The projection that Arnoldi's iteration made of a hanging rope of 15 segments with heavy dashpots
    /// (`tests/robustness/faults`), bit by bit: its size, then its rows.
    fn endless() -> Mat<f64> {
        let numbers = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/endless-eigenvalues.txt"));
        let mut numbers = numbers.split_whitespace();
        let m: usize = numbers.next().expect("a size").parse().expect("a number");
        let entries: Vec<f64> = numbers.map(|number| number.parse().expect("a number")).collect();
        assert_eq!(entries.len(), m * m);
        Mat::from_fn(m, m, |i, j| entries[i * m + j])
    }

    /// Every value has a vector with a small residual, conjugate pairs stand together, and the first two moments are
    /// those of the matrix.
    fn assert_right(h: &Mat<f64>, what: &str) {
        let (m, size) = (h.nrows(), size(h).max(f64::MIN_POSITIVE));
        let values = eigenvalues(h).unwrap_or_else(|| panic!("{what}: no answer"));
        assert_eq!(values.len(), m, "{what}");
        for value in &values {
            let residual = eigenvector(h, *value).residual;
            assert!(residual <= 1e-12 * size, "{what}: {value} has a residual of {residual:e}, size {size:e}");
        }
        let conjugate = |z: &c64| values.iter().any(|other| other.re == z.re && other.im == -z.im);
        assert!(values.iter().all(conjugate), "{what}: {values:?}");
        let (sum, squares) =
            values.iter().fold((c64::new(0.0, 0.0), c64::new(0.0, 0.0)), |(s, q), z| (s + z, q + z * z));
        let trace: f64 = (0..m).map(|i| h[(i, i)]).sum();
        let of_square: f64 = (0..m).flat_map(|i| (0..m).map(move |j| (i, j))).map(|(i, j)| h[(i, j)] * h[(j, i)]).sum();
        let few = 1e-12 * m as f64;
        assert!((sum.re - trace).abs() <= few * size, "{what}: sum {sum}, trace {trace}");
        assert!((squares.re - of_square).abs() <= few * size * size, "{what}: squares {squares}, {of_square}");
    }

    #[test]
    fn the_matrix_that_stops_the_library_has_its_eigenvalues() {
        let h = endless();
        assert_right(&h, "rope");
        // Motion across the rope without stiffness is a multiple zero that rounding spreads by its fourth root; nothing
        // else grows. The outermost value is that of the most damped motion.
        let values = eigenvalues(&h).expect("an answer");
        let real = |most: f64, z: &c64| most.max(z.re);
        assert!(values.iter().fold(f64::MIN, real) <= 1e-3 * size(&h), "{values:?}");
        let outermost = values.iter().copied().max_by(|a, b| a.norm().total_cmp(&b.norm())).expect("some");
        assert!((outermost.re + 1006.66421).abs() < 1e-4 && outermost.im == 0.0, "{outermost}");
    }

    /// A cyclic shift is its own QR step: the iteration ends at its bound, or by rounding with the roots of 1.
    #[test]
    fn a_cycle_ends() {
        for m in [3_usize, 4, 7, 16, 40] {
            let shift = Mat::from_fn(m, m, |i, j| f64::from(u8::from(i == j + 1 || (i == 0 && j == m - 1))));
            let values = eigenvalues(&shift);
            assert!(values.iter().flatten().all(|z| (z.norm() - 1.0).abs() < 1e-12), "{values:?}");
        }
    }

    #[test]
    fn random_matrices_of_all_sizes_and_scales_have_their_eigenvalues() {
        let mut number = 0;
        for m in (1..=30).chain([60, 120]) {
            for scale in [1e-140, 1.0, 1e140] {
                let h = Mat::from_fn(m, m, |i, j| {
                    number += 1;
                    if i <= j + 1 { scale * pseudo_random(number) } else { 0.0 }
                });
                assert_right(&h, &format!("{m} x {m} at {scale:e}"));
            }
        }
    }

    /// Eigenvalues of (z - 1)^2 (z + 2) and of a triangle; what is no number has none.
    #[test]
    fn double_and_given_eigenvalues_are_found() {
        let companion = Mat::from_fn(3, 3, |i, j| match (i, j) {
            (0, 1) => 3.0,
            (0, 2) => -2.0,
            (1, 0) | (2, 1) => 1.0,
            _ => 0.0,
        });
        let mut real: Vec<f64> = eigenvalues(&companion).expect("an answer").iter().map(|z| z.re).collect();
        real.sort_by(f64::total_cmp);
        let close = real.iter().zip([-2.0, 1.0, 1.0]).all(|(a, b)| (a - b).abs() < 1e-7);
        assert!(close, "{real:?}");
        let triangle = Mat::from_fn(5, 5, |i, j| if i <= j { (i + 1) as f64 } else { 0.0 });
        let mut real: Vec<f64> = eigenvalues(&triangle).expect("an answer").iter().map(|z| z.re).collect();
        real.sort_by(f64::total_cmp);
        assert!(real.iter().zip([1.0, 2.0, 3.0, 4.0, 5.0]).all(|(a, b)| (a - b).abs() < 1e-14), "{real:?}");
        assert_eq!(eigenvalues(&Mat::zeros(4, 4)).map(|values| values.len()), Some(4));
        for bad in [f64::NAN, f64::INFINITY] {
            assert!(eigenvalues(&Mat::from_fn(3, 3, |_, _| bad)).is_none());
        }
    }
}
