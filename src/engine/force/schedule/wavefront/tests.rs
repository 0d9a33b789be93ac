//! Wavefronts gone over without any forces.

use super::*;
use crate::force::kernel::fixtures::random;
use crate::force::schedule::partition::Limits;
use crate::force::schedule::step_block::tests::{NODES, links};

/// Elements between nodes up to so many apart: all of them so far, or as it happens, with a few that reach far.
fn partition(limits: Limits, apart: u32, seed: Option<u64>) -> Partition {
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
    Partition::within(limits, NODES, &mut [&mut links(nodes.collect())])
}

/// What was done so far, of all wavefronts.
struct Done {
    /// by level and node block
    node_blocks: Vec<Vec<bool>>,
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

    /// Goes over a wavefront, and looks that everything is there when it is needed and is needed no more when it is
    /// replaced.
    fn go_over(&mut self, partition: &Partition, wavefront: &mut Wavefront, at_once: usize) {
        let node_block_size: Vec<usize> = partition
            .node_blocks()
            .flat_map(|node_block| partition.blocks_of(node_block..node_block + 1).map(move |_| node_block))
            .collect();
        while let Some(ahead) = wavefront.ahead(partition, at_once) {
            Done::take(&mut self.moved, wavefront.move_for(&ahead));
            let nodes = partition.nodes_of(ahead.node_blocks.clone()).start..ahead.reach;
            assert!(
                ahead.node_blocks.start >= wavefront.node_blocks.start
                    && ahead.node_blocks.end <= wavefront.node_blocks.end
            );
            assert!(nodes.end <= partition.nodes_of(wavefront.node_blocks.clone()).end);
            let ready = match ahead.level {
                0 => &self.moved,
                level => &self.nodes[level - 1],
            };
            assert!(ready[nodes.clone()].iter().all(|ready| *ready), "not there yet");
            assert!(self.nodes[ahead.level][nodes].iter().all(|complete| !complete), "moved on already");
            Done::take(&mut self.node_blocks[ahead.level], ahead.node_blocks.clone());
            let blocks = wavefront.advance(partition, &ahead);
            let nodes = partition.nodes_of(ahead.completed.clone());
            for (number, plan) in partition.blocks().iter().enumerate() {
                let reaches = nodes.clone().any(|node| plan.reach.contains(&node));
                let node_block = node_block_size[number];
                assert!(
                    !reaches || blocks.contains(&number) && self.node_blocks[ahead.level][node_block],
                    "block {number}"
                );
                let replaced = self.node_blocks.get(ahead.level + 1).is_some_and(|next| next[node_block]);
                assert!(!reaches || !replaced, "block {number} gives what belongs to the next level");
            }
            Done::take(&mut self.nodes[ahead.level], nodes);
        }
    }
}

/// Whatever the node blocks, levels and threads: every node block and every node of every level has its turn once,
/// after what it needs and before what replaces that; wavefronts side by side go over node blocks of their own, and
/// none has much less to do than it should.
#[test]
fn fronts_go_over_everything_in_time() {
    let mut divided = Vec::new();
    let limits = [(NODES, 900), (250, 600), (64, 300), (32, 300), (16, 300), (16, 60), (8, 300), (5, 50)];
    let elements = [(31, None), (4, None), (31, Some(1)), (9, Some(2)), (2, Some(3))];
    for ((node_block, records), (apart, seed)) in limits.into_iter().flat_map(|limit| elements.map(|of| (limit, of))) {
        let partition = &partition(Limits { node_block, records }, apart, seed);
        for (levels, threads) in [(1, 2), (2, 1), (2, 2), (3, 2), (2, 3), (4, 2), (8, 2), (2, 6), (3, 5)] {
            let mut wavefronts = Wavefronts::default();
            wavefronts.plan(partition, levels, threads);
            let node_blocks = partition.node_blocks().len();
            let mut done = Done {
                node_blocks: vec![vec![false; node_blocks]; levels],
                nodes: vec![vec![false; NODES]; levels],
                moved: vec![false; NODES],
            };
            let [parts, seams] = wavefronts.all();
            for (number, part) in parts.iter_mut().enumerate() {
                assert_eq!(part.node_blocks.start, number * node_blocks / threads);
                done.go_over(partition, part, 1);
            }
            let by_parts = done.node_blocks.iter().flatten().filter(|done| **done).count();
            assert!(parts.is_empty() || SEAMS * by_parts >= (SEAMS - 1) * node_blocks * levels);
            seams.iter_mut().for_each(|seam| done.go_over(partition, seam, 2));
            let all = done.node_blocks.iter().chain(&done.nodes).chain([&done.moved]).flatten();
            assert!(
                all.into_iter().all(|done| *done),
                "node blocks of {node_block}, {levels} levels, {threads} threads"
            );
            if !parts.is_empty() {
                divided.push((node_block, levels, threads, seed.is_some()));
            }
        }
    }
    for cut in
        [(64, 2, 2, false), (32, 2, 3, false), (32, 8, 2, false), (16, 2, 6, false), (16, 4, 2, true), (16, 2, 3, true)]
    {
        assert!(divided.contains(&cut), "{divided:?}");
    }
}
