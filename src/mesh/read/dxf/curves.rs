//! Points on curves.

use super::entity::Entity;
use nalgebra::Vector3;

/// [rad] Largest angle of a chord of an arc.
const CHORD: f64 = std::f64::consts::PI / 36.0;
/// Most chords of a curve.
const MOST_CHORDS: f64 = 1e4;
/// Chords of a span of a spline, at least.
const PER_SPAN: usize = 12;
/// Highest degree of a spline.
const MOST_DEGREE: usize = 25;

/// Number of chords for an angle [rad] of an arc.
pub(super) fn chords(angle: f64, radius: f64, chord: f64) -> usize {
    let by_angle = (angle / CHORD).ceil();
    // A chord that is as long as an edge but for rounding is one.
    let by_length = (angle * radius / chord - 1e-6).ceil();
    by_angle.max(by_length).clamp(0.0, MOST_CHORDS) as usize
}

/// Places between two ends of an arc in the x-y plane; `bulge` is the tangent of a quarter of its angle, above 0 if it
/// turns to the left.
pub(super) fn arc([[ax, ay, z], [bx, by, _]]: [[f64; 3]; 2], bulge: f64, chord: f64) -> Vec<[f64; 3]> {
    let quarter = bulge.atan();
    let [dx, dy] = [bx - ax, by - ay];
    let radius = 0.5 * dx.hypot(dy) / (2.0 * quarter).sin().abs();
    let chords = chords(4.0 * quarter.abs(), radius, chord);
    let place = |i: usize| {
        // A point that sees the chord under the angle pi - 2 quarter, at this share of the arc.
        let turn = 4.0 * quarter * i as f64 / chords as f64;
        let share = (0.5 * turn).sin() / (2.0 * quarter).sin();
        let (sin, cos) = (0.5 * turn - 2.0 * quarter).sin_cos();
        [ax + share * (cos * dx - sin * dy), ay + share * (sin * dx + cos * dy), z]
    };
    (1..chords).map(place).collect()
}

/// An ellipse or a part of one, and whether it is closed.
pub(super) fn ellipse(entity: &Entity<'_>, chord: f64) -> Result<(Vec<[f64; 3]>, bool), String> {
    let [centre, major] = [entity.point(10)?, entity.point(11)?].map(Vector3::from);
    let minor = entity.real(40)? * entity.normal()?.cross(&major);
    let from = entity.real(41)?;
    let turn = 2.0 * std::f64::consts::PI;
    let to = if entity.has(42) { entity.real(42)? } else { turn };
    let angle = if (to - from).abs() >= turn * (1.0 - 1e-9) { turn } else { (to - from).rem_euclid(turn) };
    let count = chords(angle, major.norm().max(minor.norm()), chord).max(1);
    let closed = angle == turn;
    let place = |i: usize| {
        let (sin, cos) = (from + angle * i as f64 / count as f64).sin_cos();
        (centre + cos * major + sin * minor).into()
    };
    Ok(((0..if closed { count } else { count + 1 }).map(place).collect(), closed))
}

/// A spline by its control points, else through its fit points; and whether it is closed.
pub(super) fn spline(entity: &Entity<'_>, chord: f64) -> Result<(Vec<[f64; 3]>, bool), String> {
    let closed = entity.whole(70)? & 1 != 0;
    let (control, fit) = (entity.points(10)?, entity.points(11)?);
    if control.is_empty() {
        return Ok((fit, closed));
    }
    let degree = usize::try_from(entity.whole(71)?).unwrap_or(0);
    let knots: Vec<f64> = entity.numbers(40)?;
    let weights: Vec<f64> = entity.numbers(41)?;
    let sound = (1..=MOST_DEGREE).contains(&degree)
        && knots.len() == control.len() + degree + 1
        && knots.windows(2).all(|pair| pair[0] <= pair[1])
        && (weights.is_empty() || weights.len() == control.len());
    if !sound {
        return Err(format!("a spline of degree {degree} with {} knots and {} points", knots.len(), control.len()));
    }
    let homogeneous: Vec<[f64; 4]> = control
        .iter()
        .zip(weights.iter().copied().chain(std::iter::repeat(1.0)))
        .map(|([x, y, z], w)| [x * w, y * w, z * w, w])
        .collect();
    let mut places = Vec::new();
    for span in degree..control.len() {
        let [from, to] = [knots[span], knots[span + 1]];
        if from == to {
            continue;
        }
        let corners = control[span - degree..=span].windows(2);
        let length: f64 = corners.map(|pair| (Vector3::from(pair[1]) - Vector3::from(pair[0])).norm()).sum();
        let pieces = if degree == 1 { 1 } else { PER_SPAN.max((length / chord).ceil().min(MOST_CHORDS) as usize) };
        if places.is_empty() {
            places.push(de_boor(&homogeneous, &knots, degree, span, from));
        }
        let at = |i: usize| from + (to - from) * i as f64 / pieces as f64;
        places.extend((1..=pieces).map(|i| de_boor(&homogeneous, &knots, degree, span, at(i))));
    }
    Ok((places, closed))
}

/// A place on a rational spline (de Boor 1972).
fn de_boor(control: &[[f64; 4]], knots: &[f64], degree: usize, span: usize, at: f64) -> [f64; 3] {
    let mut d: Vec<[f64; 4]> = control[span - degree..=span].to_vec();
    for r in 1..=degree {
        for j in (r..=degree).rev() {
            let low = knots[j + span - degree];
            let high = knots[j + 1 + span - r];
            let share = if high > low { (at - low) / (high - low) } else { 0.0 };
            d[j] = std::array::from_fn(|k| (1.0 - share) * d[j - 1][k] + share * d[j][k]);
        }
    }
    let [x, y, z, w] = d[degree];
    [x / w, y / w, z / w]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter of a circle as a rational spline: every place has the radius.
    #[test]
    fn rational_splines_make_circles() {
        let values: Vec<(i32, String)> = [(71, 2.0), (70, 4.0)]
            .into_iter()
            .chain([0.0, 0.0, 0.0, 1.0, 1.0, 1.0].map(|knot| (40, knot)))
            .chain([1.0, 0.5_f64.sqrt(), 1.0].map(|weight| (41, weight)))
            .chain([(10, 1.0), (20, 0.0), (10, 1.0), (20, 1.0), (10, 0.0), (20, 1.0)])
            .map(|(code, value)| (code, value.to_string()))
            .collect();
        let values = values.iter().map(|(code, value)| (*code, value.as_str())).collect();
        let (places, closed) = spline(&Entity { kind: "SPLINE", line: 1, values }, f64::INFINITY).expect("a spline");
        assert!(!closed && places.len() == PER_SPAN + 1);
        assert!(places.iter().all(|[x, y, _]| (x.hypot(*y) - 1.0).abs() < 1e-12), "{places:?}");
    }
}
