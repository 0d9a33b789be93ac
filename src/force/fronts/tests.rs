//! Fronts gone over without any forces.

use super::*;
use crate::force::around::tests::{NODES, terms_with};
use crate::force::tiling::Limits;

/// What was done so far, of all fronts.
struct Done {
    /// by level and strip
    strips: Vec<Vec<bool>>,
    /// by level and node
    nodes: Vec<Vec<bool>>,
    /// before the first level
    moved: Vec<bool>,
}

impl Done {
    fn take(what: &mut [bool], range: Range<usize>) {
        for done in &mut what[range] {
            assert!(!*done, "done twice");
            *done = true;
        }
    }

    /// Goes over a front, and looks that everything is there when it is needed and is needed no more when it is replaced.
    fn go_over(&mut self, tiling: &Tiling, front: &mut Front, at_once: usize) {
        while let Some(ahead) = front.ahead(tiling, at_once) {
            let until = ahead.reach.min(front.unmoved.end);
            if ahead.level == 0 && until > front.unmoved.start {
                Done::take(&mut self.moved, front.unmoved.start..until);
                front.unmoved.start = until;
            }
            let nodes = tiling.nodes_of(ahead.strips.clone()).start..ahead.reach;
            assert!(ahead.strips.start >= front.strips.start && ahead.strips.end <= front.strips.end);
            assert!(nodes.end <= tiling.nodes_of(front.strips.clone()).end);
            let ready = match ahead.level {
                0 => &self.moved,
                level => &self.nodes[level - 1],
            };
            assert!(ready[nodes.clone()].iter().all(|ready| *ready), "not there yet");
            assert!(self.nodes[ahead.level][nodes].iter().all(|complete| !complete), "moved on already");
            Done::take(&mut self.strips[ahead.level], ahead.strips.clone());
            let tiles = front.advance(tiling, &ahead);
            let nodes = tiling.nodes_of(ahead.completed.clone());
            for (number, plan) in tiling.tiles().iter().enumerate() {
                let reaches = nodes.clone().any(|node| plan.reach.contains(&node));
                let strip = plan.own.start / tiling.strip();
                assert!(!reaches || tiles.contains(&number) && self.strips[ahead.level][strip], "tile {number}");
                let replaced = self.strips.get(ahead.level + 1).is_some_and(|next| next[strip]);
                assert!(!reaches || !replaced, "tile {number} gives what belongs to the next level");
            }
            Done::take(&mut self.nodes[ahead.level], nodes);
        }
    }
}

/// Whatever the strips, levels and threads: every strip and every node of every level has its turn once, after what it needs and before what replaces
/// that; fronts side by side go over strips of their own, and none has much less to do than it should.
#[test]
fn fronts_go_over_everything_in_time() {
    let mut divided = Vec::new();
    for (strip, records) in [(NODES, 900), (250, 600), (64, 300), (32, 300), (16, 300), (16, 60), (8, 300), (5, 50)] {
        let (_, sweep) = terms_with(Limits { strip, records }, 0);
        let tiling = &sweep.tiling;
        for (levels, threads) in [(1, 2), (2, 1), (2, 2), (3, 2), (2, 3), (4, 2), (8, 2), (2, 6)] {
            let mut fronts = Fronts::default();
            fronts.plan(tiling, levels, threads);
            let strips = tiling.strips().len();
            let mut done = Done {
                strips: vec![vec![false; strips]; levels],
                nodes: vec![vec![false; NODES]; levels],
                moved: vec![false; NODES],
            };
            let [parts, seams] = fronts.all();
            for (number, part) in parts.iter_mut().enumerate() {
                assert_eq!(part.strips.start, number * strips / threads);
                done.go_over(tiling, part, 1);
            }
            let by_parts = done.strips.iter().flatten().filter(|done| **done).count();
            assert!(parts.is_empty() || SEAMS * by_parts >= (SEAMS - 1) * strips * levels);
            seams.iter_mut().for_each(|seam| done.go_over(tiling, seam, 2));
            let all = done.strips.iter().chain(&done.nodes).chain([&done.moved]).flatten();
            assert!(all.into_iter().all(|done| *done), "strips of {strip}, {levels} levels, {threads} threads");
            if !parts.is_empty() {
                divided.push((strip, levels, threads));
            }
        }
    }
    for cut in [(64, 2, 2), (32, 2, 3), (16, 4, 2), (32, 8, 2)] {
        assert!(divided.contains(&cut), "{divided:?}");
    }
}
