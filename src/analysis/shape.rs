//! Whether a motion that the step map of a scheme makes grow is one that the scene makes grow.
//!
//! A shape y of the linearised scene moves as exp(s t) with s^2 + c s + k = 0, where k = y*Ky and c = y*Cy. Where both
//! roots are real the speed that a motion has with its shape tells which root it follows: a slow one that compression
//! turns into growth, or a fast one that a dashpot damps, which a long step may turn into growth too.

use super::linearised::dot;
use super::matrices::Matrices;
use faer::c64;

/// A motion of which a step is less than this is followed by every scheme.
const RESOLVED: f64 = 0.1;
/// Share of a growth that must be the scene's own; a scheme makes it a little larger or smaller.
const OWN: f64 = 0.5;

/// What a shape is worth in the linearised scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    /// [1/s^2]
    pub k: c64,
    /// [1/s]
    pub c: c64,
    /// [1/s] speed over position
    pub rate: c64,
}

impl Shape {
    /// Of the real and imaginary parts of (M^1/2 x `unit`, M^1/2 v), `unit` in 1/s; `root` is the diagonal of M^-1/2.
    pub fn of([re, im]: &[Vec<f64>; 2], matrices: &Matrices, root: &[f64], unit: f64) -> Self {
        let n = root.len();
        let ((x, v), (ix, iv)) = (re.split_at(n), im.split_at(n));
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
        Shape { k: quotient([1.0, 0.0]), c: quotient([0.0, 1.0]), rate: along(v, iv) * unit / square }
    }

    /// Whether a factor z in a step of h [s], beyond 1 in size, is the motion's own growth.
    pub fn grows_by_itself(&self, [re, im]: [f64; 2], h: f64) -> bool {
        let z = c64::new(re, im);
        let between = (self.c * self.c - self.k * 4.0).sqrt();
        let follows_slow = z.re > 0.0 && self.rate.re > -0.5 * self.c.re;
        let slow = (between - self.c) * 0.5;
        let s = if between.im.abs() > between.re || follows_slow { slow } else { slow - between };
        let resolved = (z - 1.0).norm() < RESOLVED && s.norm() * h < RESOLVED;
        resolved || s.re * h >= OWN * z.norm().ln()
    }
}
