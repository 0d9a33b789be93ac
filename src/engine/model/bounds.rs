//! The bounding box of nodes.

use super::quad::{self, Quad, Real, VectorUnit};
use super::workers::Workers;

/// The bounding box of some nodes. A NaN coordinate is kept, whatever its position in the sum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// [m] lowest coordinates
    pub low: [f64; 3],
    /// [m] highest coordinates
    pub high: [f64; 3],
}

/// The value for no nodes.
impl Default for Bounds {
    fn default() -> Self {
        Bounds { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] }
    }
}

impl Bounds {
    /// The box of these and other nodes.
    #[must_use]
    pub fn and(self, next: Bounds) -> Self {
        let pick = |a: f64, b: f64, better: bool| if better || a.is_nan() { a } else { b };
        Bounds {
            low: std::array::from_fn(|i| pick(self.low[i], next.low[i], self.low[i] < next.low[i])),
            high: std::array::from_fn(|i| pick(self.high[i], next.high[i], self.high[i] > next.high[i])),
        }
    }

    /// [m] half the longest side; -inf without nodes
    pub fn extent(&self) -> f64 {
        (0..3)
            .map(|i| 0.5 * (self.high[i] - self.low[i]))
            .fold(f64::NEG_INFINITY, |most, half| if half > most || half.is_nan() { half } else { most })
    }
}

/// [m] Half the longest side of the bounding box of nodes.
pub fn extent(x: &[[f64; 3]], workers: &Workers) -> f64 {
    workers.fold(x.len(), Bounds::default(), |r| bounds(&x[r]), Bounds::and).extent()
}

/// NaN coordinates may be left out.
fn bounds(x: &[[f64; 3]]) -> Bounds {
    let (rows, rest) = x.as_chunks::<4>();
    let [low, high]: [[[f64; 3]; 4]; 2] = quad::run(Boxes(bytemuck::cast_slice(rows))).map(bytemuck::cast);
    let four = (0..4).map(|i| Bounds { low: low[i], high: high[i] });
    let last = rest.iter().map(|x| Bounds { low: *x, high: *x });
    four.chain(last).fold(Bounds::default(), Bounds::and)
}

/// Four nodes side by side, in three quads.
struct Boxes<'a>(&'a [[[f64; 4]; 3]]);

impl quad::Pass for Boxes<'_> {
    type Output = [[[f64; 4]; 3]; 2];

    #[inline(always)]
    fn run<U: VectorUnit>(self, unit: U) -> [[[f64; 4]; 3]; 2] {
        let mut low = [unit.splat(f64::INFINITY); 3];
        let mut high = [unit.splat(f64::NEG_INFINITY); 3];
        for row in self.0 {
            for i in 0..3 {
                let x = unit.quad(row[i]);
                (low[i], high[i]) = (x.smaller(low[i]), x.larger(high[i]));
            }
        }
        [low.map(Quad::numbers), high.map(Quad::numbers)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(p: [f64; 3]) -> Bounds {
        Bounds { low: p, high: p }
    }

    #[test]
    fn two_nodes_span_their_box() {
        let both = of([1.0, -2.0, 0.0]).and(of([4.0, 3.0, 0.5]));
        assert_eq!(both, Bounds { low: [1.0, -2.0, 0.0], high: [4.0, 3.0, 0.5] });
        assert_eq!(both, both.and(Bounds::default()));
        assert_eq!(both.extent(), 2.5);
        assert_eq!(Bounds::default().extent(), f64::NEG_INFINITY);
    }

    #[test]
    fn what_is_not_a_number_is_never_lost() {
        let lost = of([0.0, f64::NAN, 0.0]);
        for bounds in [lost.and(of([1.0; 3])), of([1.0; 3]).and(lost), lost.and(Bounds::default())] {
            assert!(bounds.low[1].is_nan() && bounds.extent().is_nan(), "{bounds:?}");
        }
    }
}
