//! A frame in a few bytes: 16 bits for each coordinate, 8 for each value.
//!
//! A coordinate is `low + step code`, with the box of the frame divided into 65535 steps along each axis. So it is
//! off by half a step at most. Of a value the cube root is divided, into 254 steps from the least to the largest of
//! the frame: a riser has a hundred times the tension of cloth, which would be left with two or three even steps. So a
//! value is off by 0.8 % of that range at most, and by far less if it is small.

use super::scene::{Field, Place, Scene};
use crate::vtk::read::{DataSet, named_array};
use serde::Serialize;

/// Steps of a box along an axis.
const STEPS: f64 = 65535.0;
/// Code of the largest value, and of a value that is not finite.
const LARGEST: f64 = 254.0;
const NONE: u8 = 255;

/// What the bytes of a frame mean.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct FrameHead {
    /// [s] time
    pub t: f64,
    /// [m] least coordinates
    pub low: [f64; 3],
    /// [m] steps of the coordinates
    pub step: [f64; 3],
    /// least and largest value of every field, in its unit; null for a field without a finite value
    pub ranges: Vec<Option<[f64; 2]>>,
}

/// A frame: its codes are those of the coordinates, little-endian, then those of every field, to an even number.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PackedFrame {
    /// what the codes mean
    pub head: FrameHead,
    /// the codes
    pub codes: Vec<u8>,
}

impl PackedFrame {
    /// [m] The longest side of its box.
    pub(super) fn extent(&self) -> f64 {
        self.head.step.iter().fold(0.0, |most: f64, step| most.max(step * STEPS))
    }

    /// Packs a frame of a scene, with the arrays of its fields; `None` if it has a position that is not finite.
    ///
    /// # Errors
    /// The fault of the frame, as the end of a sentence that begins with its name.
    pub(super) fn new(scene: &Scene, t: f64, frame: DataSet) -> Result<Option<Self>, String> {
        let piece = frame.pieces.into_iter().next().ok_or("has no points")?;
        let same = piece.points.len() == scene.nodes && piece.cells.types.len() == scene.cells();
        if !same {
            return Err("has other cells or points than the first frame of its list".to_owned());
        }
        if piece.points.iter().flatten().any(|x| !x.is_finite()) {
            return Ok(None);
        }
        let mut codes = Vec::with_capacity(scene.frame_bytes());
        let (low, step) = add_points(&piece.points, &mut codes);
        let mut ranges = Vec::new();
        for field in &scene.fields {
            let columns = if field.on == Place::Nodes { &piece.point_data } else { &piece.cell_data };
            let values = named_array(columns, field.array).ok_or(format!("has no array \"{}\"", field.array))?;
            ranges.push(add_values(&shown(scene, field, &values)?, &mut codes));
        }
        codes.resize(scene.frame_bytes(), 0);
        let head = FrameHead { t, low, step, ranges };
        Ok(Some(PackedFrame { head, codes }))
    }
}

/// The values of a field that are shown: the size of a vector; of cells perhaps the first, which are the triangles.
fn shown(scene: &Scene, field: &Field, values: &[f64]) -> Result<Vec<f64>, String> {
    let (count, vectors) = (scene.values(field), field.on == Place::Nodes);
    let length = if vectors { 3 * count } else { scene.cells() };
    if values.len() != length {
        return Err(format!("is damaged: its array \"{}\" has not one row per cell or point", field.array));
    }
    Ok(match vectors {
        true => values.as_chunks().0.iter().map(|[x, y, z]: &[f64; 3]| x.hypot(*y).hypot(*z)).collect(),
        false => values[..count].to_vec(),
    })
}

/// Adds the codes of coordinates; their least values and steps [m].
fn add_points(points: &[[f64; 3]], codes: &mut Vec<u8>) -> ([f64; 3], [f64; 3]) {
    let extreme = |start: f64, choose: fn(f64, f64) -> f64| {
        points.iter().fold([start; 3], |seen, x| [0, 1, 2].map(|axis| choose(seen[axis], x[axis])))
    };
    let (low, high) = (extreme(f64::INFINITY, f64::min), extreme(f64::NEG_INFINITY, f64::max));
    if points.is_empty() {
        return ([0.0; 3], [0.0; 3]);
    }
    let step = [0, 1, 2].map(|axis| (high[axis] - low[axis]) / STEPS);
    for x in points {
        for axis in 0..3 {
            let code = if step[axis] > 0.0 { ((x[axis] - low[axis]) / step[axis]).round() } else { 0.0 };
            codes.extend((code as u16).to_le_bytes());
        }
    }
    (low, step)
}

/// Adds the codes of values; the least and the largest of them, if one is finite.
fn add_values(values: &[f64], codes: &mut Vec<u8>) -> Option<[f64; 2]> {
    let finite = || values.iter().copied().filter(|value| value.is_finite());
    let (low, high) = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
    let (first, last) = (low.cbrt(), high.cbrt());
    let code = |value: &f64| match value.is_finite() {
        true if last > first => ((value.cbrt() - first) / (last - first) * LARGEST).round() as u8,
        true => 0,
        false => NONE,
    };
    codes.extend(values.iter().map(code));
    (low <= high).then_some([low, high])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Coordinates come back to half a step, those of a flat scene exactly.
    #[test]
    fn coordinates_come_back() {
        let points: Vec<[f64; 3]> = (0..1000).map(|i| [f64::from(i).sin() * 7.0, 300.0 - f64::from(i), 2.5]).collect();
        let mut codes = Vec::new();
        let (low, step) = add_points(&points, &mut codes);
        assert_eq!((codes.len(), low[2], step[2]), (6000, 2.5, 0.0));
        for (i, code) in codes.as_chunks().0.iter().map(|pair| u16::from_le_bytes(*pair)).enumerate() {
            let error = low[i % 3] + f64::from(code) * step[i % 3] - points[i / 3][i % 3];
            assert!(error.abs() <= 0.5 * step[i % 3] * (1.0 + 1e-9), "{i}: {error}");
        }
    }

    /// Values come back to 0.8 % of their range, and small ones to far less; what is not finite is told apart; equal
    /// values are exact.
    #[test]
    fn values_come_back() {
        let mut codes = Vec::new();
        assert_eq!(add_values(&[-1.0, f64::NAN, 0.0, 8.0, f64::INFINITY], &mut codes), Some([-1.0, 8.0]));
        assert_eq!(codes, [0, NONE, 85, 254, NONE]);
        for [low, high] in [[-700.0, 7000.0], [-5.0, 5.0], [0.0, 1e4], [1e5, 1.01e5], [-3.0, 0.0]] {
            let values: Vec<f64> = (0..=10_000).map(|i| low + (high - low) * f64::from(i) * 1e-4).collect();
            codes.clear();
            add_values(&values, &mut codes);
            for (value, code) in values.iter().zip(&codes) {
                let root = low.cbrt() + (high.cbrt() - low.cbrt()) * f64::from(*code) / LARGEST;
                let error = (root.powi(3) - value).abs();
                assert!(error <= 0.008 * (high - low), "{value} of {low} to {high}: {error}");
                assert!(value.abs() > 1e-3 * high.abs() || error < 1e-3 * (high - low), "{value}: {error}");
            }
        }
        codes.clear();
        assert_eq!((add_values(&[5.0, 5.0], &mut codes), codes.as_slice()), (Some([5.0, 5.0]), &[0, 0][..]));
        assert_eq!(add_values(&[f64::NAN], &mut codes), None);
    }
}
