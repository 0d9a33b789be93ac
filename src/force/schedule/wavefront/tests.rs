//! Fronts gone over without any forces.

use super::*;
use crate::force::kernel::coefficient::Coefficient;
use crate::force::kernel::edges::EdgeBatch;
use crate::force::kernel::lane_batches::tests::random;
use crate::force::law::relative_dashpot::RelativeData;
use crate::force::schedule::partition::Limits;
use crate::force::schedule::step_block::tests::NODES;

/// Elements between nodes up to so many apart: all of them so far, or as it happens, with a few that reach far.
fn tiling(limits: Limits, apart: u32, seed: Option<u64>) -> Tiling {
    let mut random = random(seed.unwrap_or_default());
    let mut at_most = |most: u32| ((random().abs() * f64::from(most)) as u32).min(most);
    let nodes = (0..NODES as u32 - 1).map(|i| {
        let left = NODES as u32 - 1 - i;
        let reach = match seed {
            None => apart,
            Some(_) if at_most(60) == 0 => 1 + at_most(99),
            Some(_) => 1 + at_most(apart - 1),
        };
        [i, i + reach.min(left)]
    });
    let data = RelativeData { nodes: nodes.collect(), coefficient: Coefficient::Uniform(2.0) };
    Tiling::within(limits, NODES, &mut [&mut EdgeBatch::new(data)])
}

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

    /// Goes over a front, and looks that everything is there when it is needed and is needed no more when it is
    /// replaced.
    fn go_over(&mut self, tiling: &Tiling, front: &mut Front, at_once: usize) {
        let strip_of: Vec<usize> =
            tiling.strips().flat_map(|strip| tiling.tiles_of(strip..strip + 1).map(move |_| strip)).collect();
        while let Some(ahead) = front.ahead(tiling, at_once) {
            Done::take(&mut self.moved, front.move_for(&ahead));
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
                let strip = strip_of[number];
                assert!(!reaches || tiles.contains(&number) && self.strips[ahead.level][strip], "tile {number}");
                let replaced = self.strips.get(ahead.level + 1).is_some_and(|next| next[strip]);
                assert!(!reaches || !replaced, "tile {number} gives what belongs to the next level");
            }
            Done::take(&mut self.nodes[ahead.level], nodes);
        }
    }
}

/// Whatever the strips, levels and threads: every strip and every node of every level has its turn once, after what it
/// needs and before what replaces that; fronts side by side go over strips of their own, and none has much less to do
/// than it should.
#[test]
fn fronts_go_over_everything_in_time() {
    let mut divided = Vec::new();
    let limits = [(NODES, 900), (250, 600), (64, 300), (32, 300), (16, 300), (16, 60), (8, 300), (5, 50)];
    let elements = [(31, None), (4, None), (31, Some(1)), (9, Some(2)), (2, Some(3))];
    for ((strip, records), (apart, seed)) in limits.into_iter().flat_map(|limit| elements.map(|of| (limit, of))) {
        let tiling = &tiling(Limits { strip, records }, apart, seed);
        for (levels, threads) in [(1, 2), (2, 1), (2, 2), (3, 2), (2, 3), (4, 2), (8, 2), (2, 6), (3, 5)] {
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
                divided.push((strip, levels, threads, seed.is_some()));
            }
        }
    }
    for cut in
        [(64, 2, 2, false), (32, 2, 3, false), (32, 8, 2, false), (16, 2, 6, false), (16, 4, 2, true), (16, 2, 3, true)]
    {
        assert!(divided.contains(&cut), "{divided:?}");
    }
}
