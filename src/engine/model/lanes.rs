//! Sums in fixed lanes: they vectorise, and have the same bits everywhere.

/// Lanes of a sum, and elements that vectorised loops take at once.
pub const LANES: usize = 8;

/// A sum in lanes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lanes([f64; LANES]);

impl Lanes {
    /// Adds one value to each of the first lanes.
    #[inline(always)]
    pub fn add<const B: usize>(&mut self, values: &[f64; B]) {
        for (lane, value) in self.0.iter_mut().zip(values) {
            *lane += value;
        }
    }

    /// The sum. Not inlined: its order of summation would otherwise determine the lanes in the loop before it, which
    /// costs a quarter of the loop's speed.
    #[inline(never)]
    pub fn total(&self) -> f64 {
        let l = &self.0;
        ((l[0] + l[4]) + (l[2] + l[6])) + ((l[1] + l[5]) + (l[3] + l[7]))
    }
}
