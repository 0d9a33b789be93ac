//! Eigenvalues of a small real upper Hessenberg matrix by Francis' double-shift QR iteration, and single eigenvectors
//! by inverse iteration.
//!
//! The iteration is EISPACK's `hqr` (Martin, Peters & Wilkinson 1970) with its exceptional shifts, the bound of counted
//! iterations among them: the general eigenvalue solver of faer 0.24.4 does not return from some of the matrices met
//! here.

use faer::{Mat, c64};

/// QR iterations for one eigenvalue at most; 2 to 4 are usual.
const ITERATIONS: usize = 60;
/// Every so many iterations an exceptional shift leads out of a cycle.
const EXCEPTIONAL: usize = 10;
/// Solves of an inverse iteration at most; one is mostly enough.
const SOLVES: usize = 3;

/// All eigenvalues of H [m x m], in conjugate pairs with the positive imaginary part first; `None` where an entry is
/// not finite or the bound of iterations is reached.
pub(super) fn eigenvalues(h: &Mat<f64>) -> Option<Vec<c64>> {
    let size = size(h);
    if size == 0.0 {
        return Some(vec![c64::new(0.0, 0.0); h.nrows()]);
    }
    if !size.is_finite() {
        return None;
    }
    let mut iteration = Francis { h: scaled(h, size), shifted: 0.0 };
    let mut values = Vec::with_capacity(h.nrows());
    let mut active = h.nrows();
    while active > 0 {
        let found = iteration.deflate(active)?;
        active -= found.len();
        values.extend(found.into_iter().map(|value| size * value));
    }
    Some(values)
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

/// Matrix of the iteration, of size 1, and the sum of exceptional shifts that were taken from its diagonal.
struct Francis {
    h: Mat<f64>,
    shifted: f64,
}

/// The two shifts of a step, as the last 2 x 2 block: its diagonal x and y, the product w of the other two.
#[derive(Clone, Copy)]
struct Shifts {
    x: f64,
    y: f64,
    w: f64,
}

impl Francis {
    /// Iterates on the leading block of size `active` until one or two of its last eigenvalues are found.
    fn deflate(&mut self, active: usize) -> Option<Vec<c64>> {
        let last = active - 1;
        for iteration in 0..=ITERATIONS {
            let first = self.split(last);
            let x = self.h[(last, last)];
            if first == last {
                return Some(vec![c64::new(x + self.shifted, 0.0)]);
            }
            let (y, w) = (self.h[(last - 1, last - 1)], self.h[(last, last - 1)] * self.h[(last - 1, last)]);
            let mut shifts = Shifts { x, y, w };
            if first + 1 == last {
                return Some(self.pair(shifts));
            }
            if iteration > 0 && iteration % EXCEPTIONAL == 0 {
                shifts = self.exceptional(last);
            }
            self.step(first, last, shifts);
        }
        None
    }

    /// First row of the block that ends at `last`: what lies left of it is rounding of the whole matrix and becomes 0.
    /// Rounding of its neighbours on the diagonal would be a sharper measure, by which some quadruple zeros never part.
    fn split(&mut self, last: usize) -> usize {
        for i in (1..=last).rev() {
            if self.h[(i, i - 1)].abs() <= f64::EPSILON {
                self.h[(i, i - 1)] = 0.0;
                return i;
            }
        }
        0
    }

    /// The eigenvalues of a 2 x 2 block.
    fn pair(&self, Shifts { x, y, w }: Shifts) -> Vec<c64> {
        let p = 0.5 * (y - x);
        let q = p * p + w;
        let (root, x) = (q.abs().sqrt(), x + self.shifted);
        if q < 0.0 {
            return vec![c64::new(x + p, root), c64::new(x + p, -root)];
        }
        let z = p + root.copysign(p);
        let other = if z == 0.0 { x } else { x - w / z };
        vec![c64::new(x + z, 0.0), c64::new(other, 0.0)]
    }

    fn exceptional(&mut self, last: usize) -> Shifts {
        let x = self.h[(last, last)];
        self.shifted += x;
        (0..=last).for_each(|i| self.h[(i, i)] -= x);
        let s = self.h[(last, last - 1)].abs() + self.h[(last - 1, last - 2)].abs();
        Shifts { x: 0.75 * s, y: 0.75 * s, w: -0.4375 * s * s }
    }

    /// First column of (H - x)(H - y) - w below row m, scaled.
    fn column(&self, m: usize, Shifts { x, y, w }: Shifts) -> [f64; 3] {
        let h = &self.h;
        let (r, s) = (x - h[(m, m)], y - h[(m, m)]);
        let p = (r * s - w) / h[(m + 1, m)] + h[(m, m + 1)];
        let q = h[(m + 1, m + 1)] - h[(m, m)] - r - s;
        let v = [p, q, h[(m + 2, m + 1)]];
        let size = v.iter().map(|v| v.abs()).sum::<f64>();
        v.map(|v| if size > 0.0 { v / size } else { 0.0 })
    }

    /// A double-shift QR step on rows and columns `first` to `last`.
    fn step(&mut self, first: usize, last: usize, shifts: Shifts) {
        let mut m = last - 2;
        let mut start = self.column(m, shifts);
        // Two small entries below the diagonal in a row let the step begin there.
        while m > first {
            let [p, q, r] = start;
            let h = &self.h;
            let around = h[(m - 1, m - 1)].abs() + h[(m, m)].abs() + h[(m + 1, m + 1)].abs();
            if h[(m, m - 1)].abs() * (q.abs() + r.abs()) <= f64::EPSILON * p.abs() * around {
                break;
            }
            m -= 1;
            start = self.column(m, shifts);
        }
        for i in m + 2..=last {
            self.h[(i, i - 2)] = 0.0;
            if i > m + 2 {
                self.h[(i, i - 3)] = 0.0;
            }
        }
        for k in m..last {
            let three = k + 1 < last;
            let mut scale = 1.0;
            let mut v = start;
            if k > m {
                v = [self.h[(k, k - 1)], self.h[(k + 1, k - 1)], if three { self.h[(k + 2, k - 1)] } else { 0.0 }];
                scale = v.iter().map(|v| v.abs()).sum::<f64>();
                if scale == 0.0 {
                    continue;
                }
                v = v.map(|v| v / scale);
            }
            let s = v.iter().map(|v| v * v).sum::<f64>().sqrt().copysign(v[0]);
            if s == 0.0 {
                continue;
            }
            if k > m {
                self.h[(k, k - 1)] = -s * scale;
            } else if first < m {
                self.h[(k, k - 1)] = -self.h[(k, k - 1)];
            }
            self.reflect([first, last, k], v, s);
        }
    }

    /// Householder's reflection of rows and columns k to k + 2, at most to `last`.
    fn reflect(&mut self, [first, last, k]: [usize; 3], v: [f64; 3], s: f64) {
        let h = &mut self.h;
        let p = v[0] + s;
        let (left, right) = ([p / s, v[1] / s, v[2] / s], [1.0, v[1] / p, v[2] / p]);
        let rows = if k + 1 < last { 3 } else { 2 };
        for j in k..=last {
            let sum: f64 = (0..rows).map(|i| right[i] * h[(k + i, j)]).sum();
            (0..rows).for_each(|i| h[(k + i, j)] -= sum * left[i]);
        }
        for i in first..=last.min(k + 3) {
            let sum: f64 = (0..rows).map(|j| left[j] * h[(i, k + j)]).sum();
            (0..rows).for_each(|j| h[(i, k + j)] -= sum * right[j]);
        }
    }
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
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    /// Set where a child process is to call the library.
    const CHILD: &str = "CANOPY_FEM_CALLS_FAER";
    /// Its name, for the child.
    const TEST: &str = "analysis::hessenberg::tests::the_library_does_not_return_from_this_matrix";
    /// What an 80 x 80 matrix, which takes a hundredth of a second, is given.
    const LIMIT: Duration = Duration::from_secs(5);

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

    /// Documents the fault of faer 0.24.4. It fails once a version returns: then this file may give way to the library.
    #[test]
    #[ignore = "long"]
    fn the_library_does_not_return_from_this_matrix() {
        if std::env::var_os(CHILD).is_some() {
            let values = endless().eigen().map(|eigen| eigen.S().column_vector().nrows());
            println!("returned: {values:?}");
            return;
        }
        let program = std::env::current_exe().expect("this test");
        let mut child = Command::new(program)
            .args(["--include-ignored", "--exact", TEST])
            .env(CHILD, "1")
            .stdout(Stdio::null())
            .spawn()
            .expect("it starts");
        let begun = Instant::now();
        let returned = loop {
            match child.try_wait().expect("waited for") {
                Some(status) => break Some(status),
                None if begun.elapsed() > LIMIT => {
                    child.kill().and_then(|()| child.wait()).expect("killed");
                    break None;
                }
                None => std::thread::sleep(Duration::from_millis(10)),
            }
        };
        assert_eq!(returned, None, "faer's eigen() has returned after {:?}", begun.elapsed());
    }

    /// A cyclic shift is its own QR step: without exceptional shifts it stays as it is for ever.
    #[test]
    fn exceptional_shifts_lead_out_of_a_cycle() {
        for m in [3_usize, 4, 7, 16] {
            let shift = Mat::from_fn(m, m, |i, j| f64::from(u8::from(i == j + 1 || (i == 0 && j == m - 1))));
            assert_right(&shift, &format!("cycle of {m}"));
            let values = eigenvalues(&shift).expect("an answer");
            assert!(values.iter().all(|z| (z.norm() - 1.0).abs() < 1e-12), "{values:?}");
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
        assert_eq!(real, [1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(eigenvalues(&Mat::zeros(4, 4)).map(|values| values.len()), Some(4));
        for bad in [f64::NAN, f64::INFINITY] {
            assert!(eigenvalues(&Mat::from_fn(3, 3, |_, _| bad)).is_none());
        }
    }
}
