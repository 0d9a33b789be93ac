//! L-BFGS: a frozen factor, corrected by the last steps.

use crate::model::workers::Workers;
use crate::solve::LinearError;

/// Secant pairs kept.
const PAIRS: usize = 8;
/// A pair is dropped if y . s is below this share of |y||s|: it shows rounding or a tangent that is not positive
/// definite.
const CURVED: f64 = 1e-8;

/// Secant pairs of L-BFGS: steps s and the changes y of the residual.
#[derive(Clone, Debug, Default)]
pub(in crate::solve) struct SecantPairs {
    s: Vec<Vec<f64>>,
    y: Vec<Vec<f64>>,
    rho: Vec<f64>,
    share: Vec<f64>,
    /// number of the next pair
    next: usize,
    /// valid pairs
    held: usize,
    /// residual before a step `[n]`
    pub(super) before: Vec<f64>,
    workers: Workers,
}

impl SecantPairs {
    pub(in crate::solve) fn new(n: usize, pairs: usize, workers: &Workers) -> Self {
        // Each from the system as it is: vectors that a run never fills take no memory.
        let vectors = |count: usize| (0..count).map(|_| vec![0.0; n]).collect();
        SecantPairs {
            s: vectors(pairs),
            y: vectors(pairs),
            rho: vec![0.0; pairs],
            share: vec![0.0; pairs],
            next: 0,
            held: 0,
            before: vec![0.0; n],
            workers: workers.clone(),
        }
    }

    /// For `n` unknowns.
    pub(in crate::solve) fn for_unknowns(n: usize, workers: &Workers) -> Self {
        Self::new(n, PAIRS, workers)
    }

    pub(super) fn clear(&mut self) {
        (self.next, self.held) = (0, 0);
    }

    /// Adds the step `lambda dz` from the residual `self.before` to `after`; all `[n]`.
    pub(super) fn push(&mut self, lambda: f64, dz: &[f64], after: &[f64]) {
        let room = self.s.len();
        if room == 0 {
            return;
        }
        let i = self.next % room;
        let (s, y) = (&mut self.s[i], &mut self.y[i]);
        self.workers.both(s, y, |range, s, y| {
            let from = dz[range.clone()].iter().zip(&after[range.clone()]).zip(&self.before[range]);
            for ((s, y), ((dz, after), before)) in s.iter_mut().zip(y).zip(from) {
                (*s, *y) = (lambda * dz, after - before);
            }
        });
        let curvature = self.workers.dot(s, y);
        if curvature > CURVED * self.workers.norm(s) * self.workers.norm(y) {
            self.rho[i] = 1.0 / curvature;
            self.next += 1;
            self.held = (self.held + 1).min(room);
        } else {
            // The rejected pair has overwritten the oldest one.
            self.held = self.held.min(room - 1);
        }
    }

    /// Indices of the pairs, newest first.
    fn newest_first(&self) -> impl DoubleEndedIterator<Item = usize> + use<> {
        let (next, room) = (self.next, self.s.len().max(1));
        (1..=self.held).map(move |back| (next - back) % room)
    }

    /// Replaces g `[n]` by H g; `solve` applies H_0.
    pub(super) fn apply(
        &mut self,
        g: &mut [f64],
        solve: impl FnOnce(&mut [f64]) -> Result<(), LinearError>,
    ) -> Result<(), LinearError> {
        for i in self.newest_first() {
            let share = self.rho[i] * self.workers.dot(&self.s[i], g);
            self.share[i] = share;
            self.workers.add(g, -share, &self.y[i]);
        }
        solve(g)?;
        for i in self.newest_first().rev() {
            let share = self.share[i] - self.rho[i] * self.workers.dot(&self.y[i], g);
            self.workers.add(g, share, &self.s[i]);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::workers::ALONE;

    /// A pair with y . s <= 0 is not used, and neither is the pair that it has overwritten: H y = s holds for every
    /// pair in use.
    #[test]
    fn a_pair_that_bends_the_wrong_way_is_not_used() {
        let mut pairs = SecantPairs::new(3, 2, &ALONE);
        let steps = [
            ([1.0, 0.0, 0.0], [2.0, 0.0, 0.0]),
            ([0.0, 1.0, 0.0], [0.0, 4.0, 0.0]),
            ([0.0, 0.0, 1.0], [0.0, 0.0, -2.0]),
        ];
        for (s, y) in steps {
            pairs.before.fill(0.0);
            pairs.push(1.0, &s, &y);
        }
        assert_eq!(pairs.held, 1);
        let mut g = [1.0, 4.0, 1.0];
        pairs.apply(&mut g, |_| Ok(())).expect("nothing is solved");
        assert_eq!(g, [1.0, 1.0, 1.0], "the second pair alone");
        pairs.push(1.0, &[0.0, 0.0, 1.0], &[0.0, 0.0, 8.0]);
        let mut g = [1.0, 4.0, 8.0];
        pairs.apply(&mut g, |_| Ok(())).expect("nothing is solved");
        assert_eq!(g, [1.0, 1.0, 1.0], "the second and the fourth");
    }
}
