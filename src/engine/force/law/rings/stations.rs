//! The rings of a canopy and the bands of cloth between them: what the balance of the air needs of their shape and
//! motion.
//!
//! ```text
//! C_b = sum S . (v_0 + v_1 + v_2)/3 over the faces of a band,   F_j the same over a fan that closes ring j
//! dVol_j/dt = F_0 + sum_b<j C_b - F_j                            of the volume above the disc of ring j
//! A_j = size of the area vector of ring j, at least A_min
//! s_b = S_b (o_b + o_b+1)/2,      o_j = min(sqrt(A_j/A_cut), 1)
//! t_b = smooth step of (max A_0..b - max A_b+1..N)/(their mean), from -0.05 to 0.05
//! ```
//! S_b is the area of a band as it is cut, A_cut that of a ring. Cloth that hangs in folds does not leak: o_j. Minimum
//! and maximum have rounded corners.

use super::balance::{ByBand, ByRing, FlowGradient, MOST_BANDS, positive};
use crate::force::kernel::element_block::NodeVectors;
use crate::force::law::triangle::AreaVector;
use crate::model::system::Weights;
use nalgebra::Vector3;

/// [-] Least area of a ring over the nominal area: a radius of 0.004 D0.
const LEAST_AREA: f64 = 6.4e-5;
/// [-] Difference of two areas over their mean at which one is the wider.
const WIDER: f64 = 0.05;
/// [-] Half width of the corner of the share of cloth that is open.
const CORNER: f64 = 0.01;

/// Rings and bands, in internal numbers.
#[derive(Debug)]
pub(crate) struct Stations {
    /// nodes of each ring, right-handed about the outer normal of the canopy; the first may be an apex of one node
    rings: Vec<Vec<u32>>,
    /// faces of the bands, gaps included, one band after the other
    faces: Vec<[u32; 3]>,
    /// where the faces of each band begin, and their end
    starts: Vec<usize>,
    /// [m^2] by ring, as cut
    cut: Vec<f64>,
    /// [m^2] by band, as cut
    cloth: Vec<f64>,
    /// [m^2] A_min
    least: f64,
}

/// Their shape and motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measured {
    /// [m^3/s] dVol_j/dt
    pub rate: ByRing,
    /// [m^2] A_j, 0 at an apex
    pub area: ByRing,
    /// [m^2] s_b
    pub open: ByBand,
    /// [-] t_b
    pub below: ByBand,
}

impl Stations {
    /// From rings, the faces of each band and the positions [m] as cut, of a canopy with this nominal area [m^2].
    pub(crate) fn new(
        rings: Vec<Vec<u32>>,
        bands: Vec<Vec<[u32; 3]>>,
        cut: &[Vector3<f64>],
        nominal_area: f64,
    ) -> Self {
        let x = NodeVectors::Nodes(cut);
        let mut starts = vec![0];
        starts.extend(bands.iter().scan(0, |end, band| {
            *end += band.len();
            Some(*end)
        }));
        let area = |band: &Vec<[u32; 3]>| band.iter().map(|nodes| AreaVector::new(cut, *nodes).s.norm()).sum();
        Stations {
            cut: rings.iter().map(|ring| opening(ring, x).norm()).collect(),
            cloth: bands.iter().map(area).collect(),
            faces: bands.into_iter().flatten().collect(),
            least: LEAST_AREA * nominal_area,
            rings,
            starts,
        }
    }

    /// Number of bands.
    pub(super) fn bands(&self) -> usize {
        self.cloth.len()
    }

    fn has_apex(&self) -> bool {
        self.rings.first().is_some_and(|ring| ring.len() == 1)
    }

    /// A_j and its slope by the size of the area vector.
    fn area(&self, ring: usize, size: f64) -> [f64; 2] {
        if ring == 0 && self.has_apex() {
            return [0.0; 2];
        }
        let more = positive(size - self.least, 0.5 * self.least);
        [self.least + more.value, more.by]
    }

    /// o_j and its slope by A_j.
    fn share(&self, ring: usize, area: f64) -> [f64; 2] {
        if area == 0.0 || self.cut[ring] == 0.0 {
            return [1.0, 0.0];
        }
        let ratio = (area / self.cut[ring]).sqrt();
        let folded = positive(1.0 - ratio, CORNER);
        [1.0 - folded.value, 0.5 * folded.by * ratio / area]
    }

    pub(super) fn measure(&self, x: NodeVectors<'_>, v: NodeVectors<'_>) -> Measured {
        let n = self.bands();
        let (mut rate, mut area): (ByRing, ByRing) = ([0.0; MOST_BANDS + 1], [0.0; MOST_BANDS + 1]);
        let (mut open, mut below): (ByBand, ByBand) = ([0.0; MOST_BANDS], [0.0; MOST_BANDS]);
        for (j, ring) in self.rings.iter().enumerate() {
            [area[j], _] = self.area(j, opening(ring, x).norm());
        }
        let mut flux = fan_flux(&self.rings[0], x, v);
        for b in 0..n {
            let faces = &self.faces[self.starts[b]..self.starts[b + 1]];
            flux += faces.iter().map(|&nodes| face_flux(nodes.map(|i| x.at(i)), nodes.map(|i| v.at(i)))).sum::<f64>();
            rate[b + 1] = flux - fan_flux(&self.rings[b + 1], x, v);
            let [[above, _], [beneath, _]] = [b, b + 1].map(|j| self.share(j, area[j]));
            open[b] = 0.5 * self.cloth[b] * (above + beneath);
            below[b] = self.wider(b, &area).0;
        }
        Measured { rate, area, open, below }
    }

    /// t_b, and its slopes by the areas of the widest rings above and below.
    fn wider(&self, b: usize, area: &ByRing) -> (f64, [(usize, f64); 2]) {
        let widest = |rings: std::ops::Range<usize>| {
            rings.fold((0, 0.0), |most, j| if area[j] > most.1 { (j, area[j]) } else { most })
        };
        let ((i, above), (j, beneath)) = (widest(0..b + 1), widest(b + 1..self.bands() + 1));
        let sum = above + beneath;
        let lead = 2.0 * (above - beneath) / (WIDER * sum);
        let part = (0.5 + 0.5 * lead).clamp(0.0, 1.0);
        let by_lead = 3.0 * part * (1.0 - part);
        let slope = |other: f64| by_lead * 4.0 * other / (WIDER * sum * sum);
        (part * part * (3.0 - 2.0 * part), [(i, slope(beneath)), (j, -slope(above))])
    }

    /// Adds c d/dv + k d/dx of a number that depends on them by `by`, where the rings have these areas [m^2].
    pub(super) fn add_gradient(
        &self,
        [x, v]: [&[Vector3<f64>]; 2],
        area: &ByRing,
        by: &FlowGradient,
        w: Weights,
        g: &mut [Vector3<f64>],
    ) {
        let n = self.bands();
        let mut by_area = by.area;
        for b in 0..n {
            for j in [b, b + 1] {
                by_area[j] += 0.5 * by.open[b] * self.cloth[b] * self.share(j, area[j])[1];
            }
            for (j, slope) in self.wider(b, area).1 {
                by_area[j] += by.below[b] * slope;
            }
        }
        for (j, ring) in self.rings.iter().enumerate() {
            let s = opening(ring, NodeVectors::Nodes(x));
            let size = s.norm();
            let along = w.k * by_area[j] * self.area(j, size)[1];
            if along != 0.0 {
                add_opening_gradient(ring, x, s * (along / size), g);
            }
            let by_flux = if j == 0 { by.rate[1..=n].iter().sum() } else { -by.rate[j] };
            add_fan_gradient(ring, [x, v], w, by_flux, g);
        }
        let mut by_flux = 0.0;
        for b in (0..n).rev() {
            by_flux += by.rate[b + 1];
            for &nodes in &self.faces[self.starts[b]..self.starts[b + 1]] {
                let parts = flux_gradient(nodes.map(|i| x[i as usize]), nodes.map(|i| v[i as usize]), w, by_flux);
                nodes.into_iter().zip(parts).for_each(|(node, part)| g[node as usize] += part);
            }
        }
    }
}

/// [m^3/s] What a triangle sweeps.
fn face_flux(x: [Vector3<f64>; 3], [a, b, c]: [Vector3<f64>; 3]) -> f64 {
    AreaVector::of(x).s.dot(&(a + b + c)) / 3.0
}

/// `by` times c d/dv + k d/dx of it.
fn flux_gradient(x: [Vector3<f64>; 3], [a, b, c]: [Vector3<f64>; 3], w: Weights, by: f64) -> [Vector3<f64>; 3] {
    let (area, sum) = (AreaVector::of(x), a + b + c);
    let along = w.c * by / 3.0 * area.s;
    [0, 1, 2].map(|j| along + w.k * by / 3.0 * (area.derivative(j).transpose() * sum))
}

/// The sides of a closed ring.
fn sides(ring: &[u32]) -> impl Iterator<Item = [u32; 2]> {
    ring.iter().zip(ring.iter().cycle().skip(1)).map(|(&a, &b)| [a, b])
}

/// [m^2] Area vector of a ring.
fn opening(ring: &[u32], x: NodeVectors<'_>) -> Vector3<f64> {
    let from = x.at(ring[0]);
    sides(ring).map(|[a, b]| 0.5 * (x.at(a) - from).cross(&(x.at(b) - from))).sum()
}

/// Adds the gradient of `along` . [`opening`].
fn add_opening_gradient(ring: &[u32], x: &[Vector3<f64>], along: Vector3<f64>, g: &mut [Vector3<f64>]) {
    for (i, &node) in ring.iter().enumerate() {
        let [next, last] = [i + 1, i + ring.len() - 1].map(|i| x[ring[i % ring.len()] as usize]);
        g[node as usize] += 0.5 * (next - last).cross(&along);
    }
}

/// [m^3/s] What a fan about the middle of a ring sweeps.
fn fan_flux(ring: &[u32], x: NodeVectors<'_>, v: NodeVectors<'_>) -> f64 {
    let (middle, speed) = (x.mean(ring), v.mean(ring));
    sides(ring).map(|[a, b]| face_flux([middle, x.at(a), x.at(b)], [speed, v.at(a), v.at(b)])).sum()
}

/// Adds `by` times c d/dv + k d/dx of it.
fn add_fan_gradient(ring: &[u32], [x, v]: [&[Vector3<f64>]; 2], w: Weights, by: f64, g: &mut [Vector3<f64>]) {
    let [positions, velocities] = [x, v].map(NodeVectors::Nodes);
    let (middle, speed) = (positions.mean(ring), velocities.mean(ring));
    let mut shared = Vector3::zeros();
    for [a, b] in sides(ring) {
        let corners = [middle, positions.at(a), positions.at(b)];
        let [of_middle, of_a, of_b] = flux_gradient(corners, [speed, velocities.at(a), velocities.at(b)], w, by);
        shared += of_middle;
        g[a as usize] += of_a;
        g[b as usize] += of_b;
    }
    shared /= ring.len() as f64;
    ring.iter().for_each(|&node| g[node as usize] += shared);
}

#[cfg(test)]
mod tests;
