//! Outlines of lines and arcs that are drawn one by one, end to end.

use super::{File, Open};
use crate::read::cells::RESOLUTION;
use crate::read::{extent, joined};
use std::collections::BTreeMap;

impl File<'_> {
    /// Makes outlines of the open lines of a layer that form a loop, in which each end meets one other.
    pub(super) fn close_chains(&mut self) {
        let open = std::mem::take(&mut self.open);
        let ends: Vec<[f64; 3]> = open
            .iter()
            .flat_map(|line| [line.points.first(), line.points.last()])
            .map(|point| point.map_or([0.0; 3], |point| self.cells.points[*point as usize]))
            .collect();
        let same = joined(&ends, RESOLUTION * extent(&self.cells.points));
        let mut at_node: BTreeMap<(&[String], u32), Vec<usize>> = BTreeMap::new();
        for (end, node) in same.iter().enumerate() {
            at_node.entry((&open[end / 2].layer, *node)).or_default().push(end);
        }
        // The end that an end meets, if it is the only other one there.
        let mut meets = vec![None; same.len()];
        for ends in at_node.values() {
            if let [a, b] = ends[..] {
                (meets[a], meets[b]) = (Some(b), Some(a));
            }
        }
        let (mut used, mut seen) = (vec![false; open.len()], vec![false; open.len()]);
        for first in 0..open.len() {
            let Some(order) = circuit(first, &meets, &mut seen) else { continue };
            let mut points = Vec::new();
            for &(line, reversed) in &order {
                used[line] = true;
                let mut part = open[line].points.clone();
                if reversed {
                    part.reverse();
                }
                // Its end is the begin of the next one.
                part.pop();
                points.append(&mut part);
            }
            self.cells.add_outline(points, &open[first].layer);
        }
        self.open = open.into_iter().zip(used).filter(|(_, used)| !used).map(|(line, _): (Open, bool)| line).collect();
    }
}

/// The lines of the loop that a line is part of, each with whether it runs backwards; `seen` are lines that an earlier
/// search went along.
fn circuit(first: usize, meets: &[Option<usize>], seen: &mut [bool]) -> Option<Vec<(usize, bool)>> {
    let mut order = Vec::new();
    let mut end = 2 * first;
    loop {
        let line = end / 2;
        if std::mem::replace(&mut seen[line], true) {
            return None;
        }
        order.push((line, end % 2 == 1));
        end = meets[end ^ 1]?;
        if end == 2 * first {
            return (order.len() > 1).then_some(order);
        }
    }
}
