//! Outlines of canopies that are not round: squares and triangles with cut corners.
//!
//! ```text
//! k sides of the length a; each corner is cut off from the part c of a side to the part c of the other
//! square:     S = a^2 (1 - 2 c^2)              triangle:   S = sqrt(3)/4 a^2 (1 - 3 c^2)
//! ```

use super::ParachuteParameters;
use super::kind::CanopyType;
use std::f64::consts::{PI, TAU};

/// Number of sides; `None` for round canopies.
pub(super) fn sides(kind: CanopyType) -> Option<usize> {
    match kind {
        CanopyType::Square => Some(4),
        CanopyType::Triangular => Some(3),
        _ => None,
    }
}

/// The places of the lines around a canopy whose sides are at the distance 1 from its centre, counter-clockwise from a
/// corner; with cut corners from the end of a cut. They are evenly spaced along each side, and one gore is at a cut.
/// `None` for round canopies.
pub(super) fn of(p: &ParachuteParameters) -> Option<Vec<[f64; 2]>> {
    let k = sides(p.kind)?;
    let cut = p.corner_cut.unwrap_or(0.0);
    let radius = 1.0 / (PI / k as f64).cos();
    let corner = |i: usize| {
        let (sin, cos) = (TAU * i as f64 / k as f64).sin_cos();
        [radius * cos, radius * sin]
    };
    let along = p.gores / k;
    // Without a cut the last place of a side is the corner where the next one begins.
    let steps = if cut > 0.0 { along.saturating_sub(1).max(1) } else { along };
    let places = (0..k).flat_map(|side| {
        let [from, to] = [corner(side), corner(side + 1)];
        (0..along).map(move |i| {
            let part = cut + (1.0 - 2.0 * cut) * i as f64 / steps as f64;
            [0, 1].map(|c| (1.0 - part) * from[c] + part * to[c])
        })
    });
    Some(places.collect())
}

/// [-] Area inside an outline.
pub(super) fn area(outline: &[[f64; 2]]) -> f64 {
    let next = outline.iter().cycle().skip(1);
    outline.iter().zip(next).map(|(a, b)| 0.5 * (a[0] * b[1] - a[1] * b[0])).sum()
}

/// [-] Distance of the sides from the centre over that of the farthest corner.
pub(super) fn apothem(outline: &[[f64; 2]]) -> f64 {
    1.0 / outline.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max)
}
