//! Tension and strain of springs for output, four at a time, each written to its own index.

use crate::force::kernel::coefficient::Coefficient;
use crate::force::law::curve::Bar;
use crate::force::law::slack::{TensionLaw, with_law};
use crate::force::law::spring::{SpringData, SpringsAt};
use crate::force::law::stretch::{Positions, WholeScene, strain_base};
use crate::model::quad::{self, Pass, Quad, Real, VectorUnit};

/// The output arrays for the values of springs.
#[derive(Debug)]
pub struct SpringOutput<'a> {
    /// index of every spring in the two arrays
    pub places: &'a [u32],
    /// [N] elastic tension T(l - l0)
    pub tension: &'a mut [f64],
    /// [-] strain (l - l0)/l0; 0 without a rest length
    pub strain: &'a mut [f64],
}

impl SpringData {
    /// Writes elastic tension and strain of every spring to its index in `to.places` `[n_springs]`; other entries keep
    /// their values.
    ///
    /// # Panics
    /// When an index is beyond the end of `to.tension` or `to.strain`.
    pub fn carried(&self, at: SpringsAt<'_>, to: SpringOutput<'_>) {
        let data = self;
        with_law!(&self.curve, self.slack, law => quad::run(TensionPass { data, law, at, to }))
    }
}

/// Springs with their law, at positions of nodes.
pub(in crate::force) struct TensionPass<'a, L> {
    pub data: &'a SpringData,
    pub law: L,
    pub at: SpringsAt<'a>,
    pub to: SpringOutput<'a>,
}

/// Four springs; in the last group of a batch, some are repeated.
struct FourSprings {
    ends: [[u32; 2]; 4],
    /// [m]
    rest_length: [f64; 4],
    /// [N/m]
    stiffness: [f64; 4],
}

impl<L: TensionLaw> Pass for TensionPass<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run<U: VectorUnit>(mut self, unit: U) {
        let data = self.data;
        let (ends, ends_last) = data.nodes.as_chunks::<4>();
        let (l0, l0_last) = data.rest_length.as_chunks::<4>();
        let (places, places_last) = self.to.places.as_chunks::<4>();
        let (same, each) = match &data.stiffness {
            Coefficient::Uniform(k) => ([*k; 4], &[][..]),
            Coefficient::Each(k) => ([0.0; 4], &k[..]),
        };
        let (k, k_last) = each.as_chunks::<4>();
        for (i, ((ends, l0), places)) in ends.iter().zip(l0).zip(places).enumerate() {
            let four = FourSprings { ends: *ends, rest_length: *l0, stiffness: k.get(i).copied().unwrap_or(same) };
            self.four(unit, &four, places);
        }
        if let Some(&end) = ends_last.first() {
            let mut four = FourSprings { ends: [end; 4], rest_length: [l0_last[0]; 4], stiffness: same };
            four.ends[..ends_last.len()].copy_from_slice(ends_last);
            four.rest_length[..l0_last.len()].copy_from_slice(l0_last);
            four.stiffness[..k_last.len()].copy_from_slice(k_last);
            self.four(unit, &four, places_last);
        }
    }
}

impl<L: TensionLaw> TensionPass<'_, L> {
    /// Writes the values of springs that have an index.
    #[inline(always)]
    fn four<U: VectorUnit>(&mut self, unit: U, springs: &FourSprings, places: &[u32]) {
        let at = WholeScene(bytemuck::cast_slice(self.at.x));
        let mut d = [unit.splat(0.0); 4];
        for (d, &[a, b]) in d.iter_mut().zip(&springs.ends) {
            *d = unit.quad(at.of(b)) - unit.quad(at.of(a));
        }
        let (d, scale) = (U::Quad::columns(d), unit.splat(self.at.rest_scale));
        let l0 = unit.quad(springs.rest_length) * scale;
        let e = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt() - l0;
        let tension = self.law.at(Bar { k: unit.quad(springs.stiffness), l0 }, e).force;
        let base = unit.quad(springs.rest_length.map(strain_base)) * scale;
        let (tension, strain) = (tension.numbers(), (e / base).numbers());
        for ((&place, tension), strain) in places.iter().zip(tension).zip(strain) {
            self.to.tension[place as usize] = tension;
            self.to.strain[place as usize] = strain;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force::law::curve::CurveKind;
    use crate::force::law::slack::tension;
    use crate::model::spec::Slack;
    use nalgebra::Vector3;

    /// Each spring's values are k-law and strain of its own length, at its own place; of batches that fill no four too.
    #[test]
    fn springs_carry_their_own() {
        let x: Vec<Vector3<f64>> = (0..9).map(|i| Vector3::new(f64::from(i * i), 0.5 * f64::from(i), -0.25)).collect();
        let slacks =
            [Slack::None, Slack::TensionOnly, Slack::DeadZone { eps: 0.5 }, Slack::CompressionLimit { eps: 1.0 }];
        for (n, slack) in (0..=9usize).flat_map(|n| slacks.map(|slack| (n, slack))) {
            for uniform in [false, true] {
                let stiffness: Vec<f64> = (0..n).map(|i| if uniform { 3.0 } else { 1.0 + i as f64 }).collect();
                let data = SpringData {
                    nodes: (0..n).map(|i| [(i * 5 % 9) as u32, ((i * 7 + 1) % 9) as u32]).collect(),
                    rest_length: (0..n).map(|i| 4.0 + 3.0 * i as f64).collect(),
                    stiffness: Coefficient::from_values(&stiffness),
                    curve: CurveKind::Linear,
                    slack,
                    rest_scale: None,
                };
                let places: Vec<u32> = (0..n as u32).map(|i| 11 - i).collect();
                let (mut tensions, mut strains) = ([7.0; 12], [8.0; 12]);
                data.carried(
                    data.at(0.0, &x),
                    SpringOutput { places: &places, tension: &mut tensions, strain: &mut strains },
                );
                for place in 0..12 {
                    let spring = 11 - place;
                    let expected = if spring < n {
                        let [a, b] = data.nodes[spring].map(|node| x[node as usize]);
                        let e = (b - a).norm() - data.rest_length[spring];
                        (
                            tension(&data.curve, slack, data.bar(data.at(0.0, &x), spring), e).force,
                            e / data.rest_length[spring],
                        )
                    } else {
                        (7.0, 8.0)
                    };
                    assert_eq!((tensions[place], strains[place]), expected, "{n} {slack:?} {place}");
                }
            }
        }
    }
}
