//! Divides the sides of pieces into edges, both sides of a seam alike.

use super::piece::{Piece, Run};
use crate::sew::{Seam, Sewing};

/// [-] Part of the edge length up to which two points on a seam are one.
const CLOSE: f64 = 0.25;
/// [-] Most edges of a side; more are refused when the outlines are filled.
const MOST_EDGES: f64 = 1e6;

/// Gives both sides of every seam points at the same parts of their lengths.
pub(super) fn divide_alike(pieces: &mut [Piece], seams: &[Seam], sewing: &Sewing, edge: f64) {
    for ([first, second], rule) in &sewing.sides {
        let all = |name: &String| -> Vec<(usize, usize)> {
            let spans = pieces.iter().enumerate();
            spans
                .flat_map(|(p, piece)| piece.spans.iter().enumerate().map(move |(s, span)| (p, s, span)))
                .filter(|(.., span)| span.name == *name)
                .map(|(p, s, _)| (p, s))
                .collect()
        };
        let mut sides = all(first);
        if first != second {
            sides.extend(all(second));
        }
        // What is wrong with other numbers is told when the seams are sewn.
        let [one, other] = sides[..] else { continue };
        let ends = |(p, s): (usize, usize)| [pieces[p].spans[s].from, pieces[p].spans[s].to];
        let [a, b] = [one, other].map(|side| (pieces[side.0].stops(ends(side)), pieces[side.0].run(ends(side))));
        // The second side runs against the first one.
        let turned = |parts: &[f64]| -> Vec<f64> {
            if seams[*rule].reverse { parts.to_vec() } else { parts.iter().rev().map(|part| 1.0 - part).collect() }
        };
        let length = Run::of(a.1).length.max(Run::of(b.1).length);
        let mut stops: Vec<f64> = [a.0, turned(&b.0)].concat();
        stops.sort_unstable_by(f64::total_cmp);
        let parts = divide(&merged(&stops, CLOSE * edge / length), length, edge);
        pieces[other.0].spans[other.1].parts = turned(&parts);
        pieces[one.0].spans[one.1].parts = parts;
    }
}

/// Ascending stops from 0 to 1, of which those close together become one.
fn merged(stops: &[f64], close: f64) -> Vec<f64> {
    let mut kept: Vec<f64> = vec![0.0];
    for &stop in stops {
        if stop - kept[kept.len() - 1] > close && 1.0 - stop > close {
            kept.push(stop);
        }
    }
    kept.push(1.0);
    kept
}

/// Parts of a length with the stops, evenly divided between them into edges no longer than wanted.
pub(super) fn divide(stops: &[f64], length: f64, edge: f64) -> Vec<f64> {
    let mut parts = vec![0.0];
    for pair in stops.windows(2) {
        // A side that is as long as the edge but for rounding is one.
        let count = ((pair[1] - pair[0]) * length / edge - 1e-6).ceil().clamp(1.0, MOST_EDGES) as usize;
        parts.extend(
            (1..=count)
                .map(|i| if i == count { pair[1] } else { pair[0] + (pair[1] - pair[0]) * i as f64 / count as f64 }),
        );
    }
    parts
}
