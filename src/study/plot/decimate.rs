//! Lines for a picture: cut at its frame and decimated to what can be seen.
//!
//! Coordinates are shares of the frame, which is the unit square.

/// A point in the frame, horizontal and vertical.
pub(crate) type UnitPoint = (f64, f64);

/// A point of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node {
    /// its place
    pub at: UnitPoint,
    /// inner control points of the cubic that leads to it, which is inside the frame; `None` if it is a straight line
    pub via: Option<[UnitPoint; 2]>,
}

impl From<UnitPoint> for Node {
    fn from(at: UnitPoint) -> Self {
        Node { at, via: None }
    }
}

/// The parts of a line inside the frame. A missing point interrupts the line.
pub(super) fn cut(nodes: impl IntoIterator<Item = Option<Node>>) -> Vec<Vec<Node>> {
    let mut pieces: Vec<Vec<Node>> = Vec::new();
    let mut open = false;
    let mut last: Option<Node> = None;
    for node in nodes {
        if let (Some(Node { at: from, .. }), Some(Node { at: to, via })) = (last, node) {
            match segment(from, to) {
                Some((enters, leaves)) => {
                    let end = Node { at: leaves, via };
                    match pieces.last_mut().filter(|_| open && enters == from) {
                        Some(piece) => piece.push(end),
                        None => pieces.push(vec![enters.into(), end]),
                    }
                    open = leaves == to;
                }
                None => open = false,
            }
        } else {
            open = false;
        }
        last = node;
    }
    pieces
}

/// Whether a point is inside the frame.
pub(super) fn inside(place: UnitPoint) -> bool {
    (0.0..=1.0).contains(&place.0) && (0.0..=1.0).contains(&place.1)
}

/// The part of a straight line inside the frame (Liang & Barsky 1984). Ends inside the frame keep their bits. Ends on
/// an edge are on it exactly, also if the line comes from so far away that its crossings of two edges differ by
/// rounding only.
fn segment(from: UnitPoint, to: UnitPoint) -> Option<(UnitPoint, UnitPoint)> {
    let (start, end) = ([from.0, from.1], [to.0, to.1]);
    let (mut enters, mut leaves) = ((0.0, None), (1.0, None));
    for (axis, (&start, &end)) in start.iter().zip(&end).enumerate() {
        let step = end - start;
        if step == 0.0 {
            if !(0.0..=1.0).contains(&start) {
                return None;
            }
            continue;
        }
        let edges = if step > 0.0 { [0.0, 1.0] } else { [1.0, 0.0] };
        let [first, last] = edges.map(|edge| ((edge - start) / step, Some((axis, edge))));
        enters = if first.0 > enters.0 { first } else { enters };
        leaves = if last.0 < leaves.0 { last } else { leaves };
    }
    let at = |(share, edge): (f64, Option<(usize, f64)>), whole: UnitPoint| {
        let Some((axis, edge)) = edge else { return whole };
        let along = |start: f64, end: f64| (start + share * (end - start)).clamp(0.0, 1.0);
        if axis == 0 { (edge, along(from.1, to.1)) } else { (along(from.0, to.0), edge) }
    };
    (enters.0 <= leaves.0).then(|| (at(enters, from), at(leaves, to)))
}

/// At most about `most` points that look the same: the extremes of every section of the line in both directions, and
/// both ends. For a curve over time these are the first, last, smallest and largest (M4: Jugel, Jerzak, Hackenbroich &
/// Markl 2014). Its sections are equally wide in the picture, also where the axis is logarithmic; those of a line that
/// turns back have equal numbers of points.
pub(crate) fn thin(points: &[UnitPoint], most: usize) -> Vec<UnitPoint> {
    if points.len() <= most {
        return points.to_vec();
    }
    let sections = (most / 4).max(1);
    let begin = points.first().map_or(0.0, |p| p.0);
    let width = points.last().map_or(0.0, |p| p.0) - begin;
    let rises = width > 0.0 && points.is_sorted_by(|a, b| a.0 <= b.0);
    let section = |i: usize| match rises {
        true => ((points[i].0 - begin) / width * sections as f64) as usize,
        false => i * sections / points.len(),
    };
    let mut kept = Vec::with_capacity(most + 2);
    kept.extend(points.first());
    let mut next = 0;
    while next < points.len() {
        let start = next;
        next += (start..points.len()).take_while(|i| section(*i) == section(start)).count();
        let part = &points[start..next];
        let mut extremes = [0; 4];
        for (i, p) in part.iter().enumerate() {
            let [left, right, lowest, highest] = extremes.map(|best: usize| part[best]);
            let wins = [p.0 < left.0, p.0 > right.0, p.1 < lowest.1, p.1 > highest.1];
            for (best, _) in extremes.iter_mut().zip(wins).filter(|(_, wins)| *wins) {
                *best = i;
            }
        }
        extremes.sort_unstable();
        kept.extend(extremes.map(|i| part[i]));
    }
    kept.extend(points.last());
    kept.dedup();
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Decimation keeps both ends and every extreme: a single outlier among a hundred thousand points is kept.
    #[test]
    fn thinning_keeps_extremes() {
        let mut points: Vec<UnitPoint> =
            (0..100_000).map(|i| (f64::from(i) / 1e5, (f64::from(i) * 0.37).sin())).collect();
        points[54_321].1 = 7.0;
        points[54_322].1 = -9.0;
        let thin = thin(&points, 2000);
        assert!((500..=2002).contains(&thin.len()), "{}", thin.len());
        assert!(thin.contains(&points[54_321]) && thin.contains(&points[54_322]));
        assert_eq!((thin.first(), thin.last()), (points.first(), points.last()));
        assert!(thin.windows(2).all(|w| w[0].0 < w[1].0), "the order of time is kept");
    }

    /// On a logarithmic axis, the few points of the first decades stay, and thousands at the end are decimated.
    #[test]
    fn sections_are_equally_wide() {
        let points: Vec<UnitPoint> = (1..10_000_u16).map(|i| (f64::from(i).log10() / 4.0, f64::from(i % 2))).collect();
        let thin = thin(&points, 400);
        assert_eq!(thin[..5], points[..5]);
        assert!(thin.len() <= 406, "{}", thin.len());
    }

    /// Decimation does not change short lines.
    #[test]
    fn short_lines_stay() {
        let points = [(0.0, 0.0), (0.5, 1.0), (1.0, 0.0)];
        assert_eq!(thin(&points, 3), points);
    }

    /// A line that leaves the frame and returns becomes two parts that end at the frame; a missing point divides it
    /// too.
    #[test]
    fn lines_are_cut_at_the_frame() {
        let places = |pieces: Vec<Vec<Node>>| -> Vec<Vec<UnitPoint>> {
            pieces.into_iter().map(|piece| piece.into_iter().map(|node| node.at).collect()).collect()
        };
        let cut = |line: &[Option<UnitPoint>]| places(cut(line.iter().map(|place| place.map(Node::from))));
        let line = [(0.0, 0.5), (0.25, 0.5), (0.5, 1.5), (0.75, 0.5), (1.0, 0.5)].map(Some);
        let pieces = cut(&line);
        assert_eq!(pieces, [[(0.0, 0.5), (0.25, 0.5), (0.375, 1.0)], [(0.625, 1.0), (0.75, 0.5), (1.0, 0.5)]]);
        let parted = cut(&[Some((0.1, 0.1)), Some((0.2, 0.2)), None, Some((0.3, 0.3)), Some((0.4, 0.4))]);
        assert_eq!(parted, [[(0.1, 0.1), (0.2, 0.2)], [(0.3, 0.3), (0.4, 0.4)]]);
        let outside = cut(&[Some((2.0, 0.0)), Some((3.0, 1.0))]);
        assert!(outside.is_empty());
        let far = cut(&[Some((0.25, -1e18)), Some((0.75, 1e18)), Some((1.0, -1e18))]);
        assert_eq!(far, [[(0.5, 0.0), (0.5, 1.0)], [(0.875, 1.0), (0.875, 0.0)]]);
        let across = cut(&[Some((-1.0, 0.5)), Some((2.0, 0.5))]);
        assert_eq!(across.len(), 1);
        assert!(across[0].iter().all(|p| inside(*p)));
    }
}
