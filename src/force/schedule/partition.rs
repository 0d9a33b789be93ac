//! Cuts a scene into tiles, so that a force pass works in the first caches.
//!
//! A strip is a run of nodes and the elements whose smallest node lies in it. What they touch beyond the strip's end is
//! summed apart and added to those nodes when all strips that reach them are done: no two strips write to one place. A
//! strip is one tile, and more where its elements reach too many nodes for the windows of one.

use crate::force::kernel::batch::Summand;
use crate::force::kernel::local_buffer::{Padded, RECORD, add_rows};
use crate::model::workers::Workers;
use bytemuck::cast_slice_mut;
use glam::DVec3;
use std::ops::Range;

/// Records in a window at most: as many as 16 bits can tell apart.
const RECORDS: usize = (u16::MAX as usize + 1) / RECORD;

/// Nodes of a strip, before their number is rounded, at least and at most: with them the windows of a pass fit into a
/// second-level cache of 1 MB, and what lies beyond a strip's end is less than what lies in it.
const LEAST: usize = 2048;
const MOST: usize = 2560;

/// Strips at least, where these bounds allow: work for many threads.
const STRIPS: usize = 64;

/// The tiles of a scene.
#[derive(Debug)]
pub(in crate::force) struct Tiling {
    /// nodes of the scene and of a strip
    nodes: usize,
    strip: usize,
    tiles: Vec<Plan>,
    /// every strip's first tile, and the number of tiles
    first_tile: Vec<usize>,
    /// nodes beyond the ends of strips, tile after tile
    beyond: Vec<u32>,
    /// where the nodes end that some strips from the first on reach, by their number: of none, of one, ... of all
    reach: Vec<usize>,
}

/// What one tile owns.
#[derive(Debug)]
pub(in crate::force) struct Plan {
    pub own: Range<usize>,
    /// whether it is its strip's first, whose nodes it stores
    pub opens_strip: bool,
    /// its part of the list of nodes beyond
    pub beyond: Range<usize>,
    /// records of all tiles before
    pub records_before: usize,
    /// the first of them, where they follow each other
    pub run: Option<usize>,
    /// from the first of them to the last; where there is none, from the strip's end to there
    pub reach: Range<usize>,
}

impl Plan {
    /// Records in the tile's windows.
    pub(in crate::force) fn records(&self) -> usize {
        self.own.len() + self.beyond.len()
    }
}

/// What some tiles give to the nodes beyond their strips.
#[derive(Clone, Copy)]
pub(in crate::force) struct Beyond<'a> {
    /// where they begin among those of all tiles
    pub first: usize,
    pub sums: &'a [Padded],
}

/// Nodes of a strip in a scene of so many: two strips, or four times some number (up to some 500, where one more or
/// less matters little), give several threads equally much to do.
fn strip_of(nodes: usize) -> usize {
    let strips = nodes.div_ceil(nodes.div_ceil(STRIPS).clamp(LEAST, MOST));
    match strips {
        0..=1 => LEAST,
        _ => nodes.div_ceil(strips.next_multiple_of(strips.min(4).next_multiple_of(2))).next_multiple_of(8),
    }
}

/// How large tiles may be.
#[derive(Clone, Copy, Debug)]
pub(in crate::force) struct Limits {
    pub strip: usize,
    pub records: usize,
}

impl Tiling {
    /// Cuts `nodes` nodes into tiles and tells every summand its elements.
    pub(in crate::force) fn new(nodes: usize, summands: &mut [&mut dyn Summand]) -> Self {
        let strip = strip_of(nodes);
        Tiling::within(Limits { strip, records: RECORDS }, nodes, summands)
    }

    pub(in crate::force) fn within(limits: Limits, nodes: usize, summands: &mut [&mut dyn Summand]) -> Self {
        let (strip, tiles, beyond) = (limits.strip, Vec::new(), Vec::new());
        let mut tiling = Tiling { nodes, strip, tiles, first_tile: vec![0], beyond, reach: vec![0] };
        let mut cutter = Cutter { next: vec![0; summands.len()], place: vec![None; nodes], records: limits.records };
        for start in (0..nodes).step_by(limits.strip) {
            let own = start..(start + limits.strip).min(nodes);
            let mut opens_strip = true;
            while cutter.cut(own.clone(), opens_strip, &mut tiling, summands) {
                opens_strip = false;
            }
            let (before, first) = (tiling.reach_of(tiling.strips().end), tiling.first_tile[tiling.strips().end]);
            tiling.reach.push(tiling.tiles[first..].iter().fold(before, |most, plan| most.max(plan.reach.end)));
            tiling.first_tile.push(tiling.tiles.len());
        }
        tiling
    }

    pub(in crate::force) fn strips(&self) -> Range<usize> {
        0..self.first_tile.len() - 1
    }

    /// The nodes of some strips.
    pub(in crate::force) fn nodes_of(&self, strips: Range<usize>) -> Range<usize> {
        (self.strip * strips.start).min(self.nodes)..(self.strip * strips.end).min(self.nodes)
    }

    /// Numbers of the tiles of some strips.
    pub(in crate::force) fn tiles_of(&self, strips: Range<usize>) -> Range<usize> {
        self.first_tile[strips.start]..self.first_tile[strips.end]
    }

    /// Where the nodes end that so many strips from the first on reach, their own among them.
    pub(in crate::force) fn reach_of(&self, strips: usize) -> usize {
        self.reach[strips]
    }

    /// The first strip that reaches beyond the beginning of another; how many there are, if none does.
    pub(in crate::force) fn first_beyond(&self, strip: usize) -> usize {
        let limit = self.nodes_of(strip..strip).start;
        self.reach[1..].partition_point(|&reach| reach <= limit)
    }

    /// The first strip that none before another reaches.
    pub(in crate::force) fn first_unreached(&self, strip: usize) -> usize {
        self.reach[strip].div_ceil(self.strip)
    }

    pub(in crate::force) fn tiles(&self) -> &[Plan] {
        &self.tiles
    }

    /// The nodes beyond of all tiles.
    pub(in crate::force) fn beyond(&self) -> &[u32] {
        &self.beyond
    }

    /// Adds what tiles give to nodes beyond their strips to those that begin with `first`, tile after tile.
    pub(in crate::force) fn add_beyond(
        &self,
        tiles: Range<usize>,
        beyond: Beyond<'_>,
        (first, out): (usize, &mut [DVec3]),
    ) {
        let end = first + out.len();
        for plan in self.tiles[tiles].iter().filter(|plan| plan.reach.start < end && first < plan.reach.end) {
            let nodes = &self.beyond[plan.beyond.clone()];
            let below = |limit: usize| nodes.partition_point(|&node| (node as usize) < limit);
            let [from, to] = [below(first), below(end)];
            let sums = &beyond.sums[plan.beyond.start - beyond.first..][from..to];
            match plan.run {
                Some(run) => add_rows(sums, &mut out[(run + from).saturating_sub(first)..][..sums.len()]),
                None => {
                    for (&node, sum) in nodes[from..to].iter().zip(sums) {
                        out[node as usize - first] += DVec3::new(sum[0], sum[1], sum[2]);
                    }
                }
            }
        }
    }

    /// The same on several threads.
    pub(in crate::force) fn add_beyond_by(
        &self,
        workers: &Workers,
        tiles: Range<usize>,
        beyond: Beyond<'_>,
        (first, out): (usize, &mut [DVec3]),
    ) {
        workers.each(cast_slice_mut(out), |dofs, out| {
            self.add_beyond(tiles.clone(), beyond, (first + dofs.start / 3, cast_slice_mut(out)));
            0.0
        });
    }

    /// The part of some tiles in the list of all tiles' records.
    pub(in crate::force) fn records_of(&self, tiles: Range<usize>) -> Range<usize> {
        let end = self.tiles.last().map_or(0, |plan| plan.records_before + plan.records());
        let start = |tile: usize| self.tiles.get(tile).map_or(end, |plan| plan.records_before);
        start(tiles.start)..start(tiles.end)
    }

    /// The part of some tiles in the list of nodes beyond.
    pub(in crate::force) fn beyond_of(&self, tiles: Range<usize>) -> Range<usize> {
        let start = |tile: usize| self.tiles.get(tile).map_or(self.beyond.len(), |plan| plan.beyond.start);
        start(tiles.start)..start(tiles.end)
    }
}

/// The way through all elements.
struct Cutter {
    /// next element of every summand
    next: Vec<usize>,
    /// where a node beyond has its record in the tile that is being cut
    place: Vec<Option<u16>>,
    records: usize,
}

impl Cutter {
    /// Adds a tile; tells whether the strip needs another.
    fn cut(
        &mut self,
        own: Range<usize>,
        opens_strip: bool,
        tiling: &mut Tiling,
        summands: &mut [&mut dyn Summand],
    ) -> bool {
        let begin = tiling.beyond.len();
        let mut ends = self.next.clone();
        let mut full = false;
        for (summand, end) in summands.iter().zip(&mut ends) {
            while let Some(nodes) = summand.element(*end).filter(|nodes| begins_in(nodes, &own)) {
                let new = |node: &&u32| **node as usize >= own.end && self.place[**node as usize].is_none();
                if own.len() + tiling.beyond.len() - begin + nodes.iter().filter(new).count() > self.records {
                    full = true;
                    break;
                }
                for &node in nodes.iter().filter(|&&node| node as usize >= own.end) {
                    if self.place[node as usize].replace(0).is_none() {
                        tiling.beyond.push(node);
                    }
                }
                *end += 1;
            }
        }
        let beyond = &mut tiling.beyond[begin..];
        beyond.sort_unstable();
        for (record, &node) in (own.len()..).zip(beyond.iter()) {
            self.place[node as usize] = Some(crate::force::kernel::element_block::place(record));
        }
        let place = |node: u32| {
            let of_own = || crate::force::kernel::element_block::place((node as usize).saturating_sub(own.start));
            self.place[node as usize].unwrap_or_else(of_own)
        };
        for (summand, (next, end)) in summands.iter_mut().zip(self.next.iter_mut().zip(&ends)) {
            summand.take(tiling.tiles.len(), *next..*end, &place);
            *next = *end;
        }
        beyond.iter().for_each(|&node| self.place[node as usize] = None);
        let follow = beyond.windows(2).all(|pair| pair[1] == pair[0] + 1);
        let run = beyond.first().filter(|_| follow).map(|&node| node as usize);
        let reach = match (beyond.first(), beyond.last()) {
            (Some(&first), Some(&last)) => first as usize..last as usize + 1,
            _ => own.end..own.end,
        };
        let records_before = tiling.records_of(0..tiling.tiles.len()).end;
        let beyond = begin..tiling.beyond.len();
        tiling.tiles.push(Plan { own, opens_strip, beyond, records_before, run, reach });
        full
    }
}

fn begins_in(nodes: &[u32], own: &Range<usize>) -> bool {
    let least = nodes.iter().min().map(|&least| least as usize);
    debug_assert!(
        least.is_none_or(|least| own.start <= least),
        "elements come in ascending order of their smallest node"
    );
    least.is_some_and(|least| least < own.end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force::kernel::batch::Wants;
    use crate::force::kernel::element_block::Tile;
    use crate::force::kernel::local_buffer::Records;
    use crate::model::forces::Tally;

    /// Elements, and what was told of each: its tile and the places of its nodes.
    #[derive(Default)]
    struct Told {
        elements: Vec<Vec<u32>>,
        tile: Vec<usize>,
        places: Vec<Vec<u16>>,
        tiles: usize,
    }

    impl Summand for Told {
        fn elements(&self) -> usize {
            self.elements.len()
        }

        fn wants(&self) -> Wants {
            Wants::default()
        }

        fn element(&self, number: usize) -> Option<&[u32]> {
            self.elements.get(number).map(Vec::as_slice)
        }

        fn take(&mut self, tile: usize, elements: Range<usize>, place: &dyn Fn(u32) -> u16) {
            assert_eq!(tile, self.tiles);
            assert_eq!(elements.start, self.tile.len(), "one after the other");
            for nodes in &self.elements[elements] {
                self.tile.push(self.tiles);
                self.places.push(nodes.iter().map(|&n| place(n)).collect());
            }
            self.tiles += 1;
        }

        fn add(&self, _: &Tile<'_>, _: &mut Records) -> Tally {
            Tally::default()
        }
    }

    /// Every element has a tile, and its nodes are where the tile's windows have them.
    fn check(tiling: &Tiling, told: &Told) {
        assert_eq!(told.tile.len(), told.elements.len());
        assert_eq!(told.tiles, tiling.tiles.len());
        for ((nodes, &tile), places) in told.elements.iter().zip(&told.tile).zip(&told.places) {
            let plan = &tiling.tiles[tile];
            let window: Vec<u32> = (plan.own.start as u32..plan.own.end as u32)
                .chain(tiling.beyond[plan.beyond.clone()].iter().copied())
                .collect();
            let found: Vec<u32> = places.iter().map(|&p| window[p as usize / RECORD]).collect();
            assert_eq!(found, *nodes);
            if let Some(first) = plan.run {
                assert!(tiling.beyond[plan.beyond.clone()].iter().zip(first..).all(|(&node, i)| node as usize == i));
            }
        }
        let owned: Vec<usize> = tiling.tiles.iter().filter(|t| t.opens_strip).flat_map(|t| t.own.clone()).collect();
        assert_eq!(owned, (0..tiling.nodes).collect::<Vec<_>>());
    }

    fn limits(strip: usize, records: usize) -> Limits {
        Limits { strip, records }
    }

    #[test]
    fn a_chain_reaches_one_node_beyond_each_strip() {
        let mut told = Told { elements: (0..99).map(|i| vec![i, i + 1]).collect(), ..Told::default() };
        let mut none = Told::default();
        let tiling = Tiling::within(limits(8, 100), 100, &mut [&mut told, &mut none]);
        check(&tiling, &told);
        assert_eq!((tiling.tiles.len(), tiling.beyond.len(), none.tiles), (13, 12, 13));
        assert_eq!((tiling.nodes_of(1..3), tiling.nodes_of(12..13), tiling.tiles_of(3..5)), (8..24, 96..100, 3..5));
        assert_eq!((tiling.beyond_of(2..4), tiling.beyond_of(12..13)), (2..4, 12..12));
    }

    #[test]
    fn strips_of_a_scene_are_even() {
        let strips = |nodes: usize| nodes.div_ceil(strip_of(nodes));
        assert_eq!([1, 2048, 2049, 4096, 4097, 10_000, 65_537].map(strips), [1, 1, 2, 2, 4, 8, 36]);
        assert_eq!([131_072, 131_073, 1_000_000].map(strips), [64, 64, 392]);
        assert!((2049..300_000).step_by(7).all(|nodes| strips(nodes) % 2 == 0 && strip_of(nodes) <= MOST));
    }

    #[test]
    fn a_node_with_more_neighbours_than_a_window_has_records_takes_several_tiles() {
        let mut star = Told { elements: (1..200).map(|i| vec![i, 0]).collect(), ..Told::default() };
        let mut chain = Told { elements: (0..199).map(|i| vec![i + 1, i]).collect(), ..Told::default() };
        let tiling = Tiling::within(limits(10, 30), 200, &mut [&mut star, &mut chain]);
        check(&tiling, &star);
        check(&tiling, &chain);
        assert!(tiling.tiles_of(0..1).len() >= 10, "{:?}", tiling.tiles_of(0..1));
        assert_eq!(tiling.tiles_of(1..2).len(), 1);
    }

    #[test]
    fn triangles_and_springs_share_their_windows() {
        let triangles = (0..50).map(|i| vec![i + 10, i, i + 1]).collect();
        let mut triangles = Told { elements: triangles, ..Told::default() };
        let mut springs = Told { elements: (0..50).map(|i| vec![i, i + 10]).collect(), ..Told::default() };
        let tiling = Tiling::within(limits(16, 64), 61, &mut [&mut triangles, &mut springs]);
        check(&tiling, &triangles);
        check(&tiling, &springs);
        assert_eq!(tiling.beyond_of(0..1).len(), 10);
        assert_eq!(tiling.tiles[0].run, Some(16));
    }
}
