//! Tiles: runs of elements that touch few nodes, so that a pass over them works in the first caches.
//!
//! A tile copies the positions and velocities of its nodes into windows of records of four numbers (`window`),
//! numbers its elements' nodes within the window, and sums forces there. What it found is then added to the nodes, tile after tile.

use super::NodeState;
use super::window::{Padded, RECORD, Records, add_rows, copy_rows, record, set_record};
use glam::DVec3;
use std::ops::Range;

/// Nodes a tile touches at most. Three windows of this size fit into the second-level cache.
pub(super) const WINDOW: usize = 2048;

/// The elements of a tile as a kernel sees them.
#[derive(Clone, Copy)]
pub struct Tile<'a, const N: usize> {
    /// the whole scene's state
    pub at: NodeState<'a>,
    /// [m] positions of the window's nodes, where the kernel wants them
    pub x: &'a Records,
    /// [m/s] their velocities, where the kernel wants them
    pub v: &'a Records,
    /// every element's nodes, by where their records begin in the window
    pub nodes: &'a [[u16; N]],
    /// number of the first element
    pub first: usize,
}

impl<const N: usize> Tile<'_, N> {
    /// Numbers of the elements.
    pub fn range(&self) -> Range<usize> {
        self.first..self.first + self.nodes.len()
    }

    /// Adds elements one by one: `element` tells force [N] and energy or power of each, `signs` how it acts on its nodes.
    pub fn each(&self, signs: [f64; N], f: &mut Records, mut element: impl FnMut(usize) -> (DVec3, f64)) -> f64 {
        let mut sum = 0.0;
        for (nodes, number) in self.nodes.iter().zip(self.range()) {
            let (force, amount) = element(number);
            sum += amount;
            for (&node, sign) in nodes.iter().zip(signs) {
                let [x, y, z, _] = record(f, node);
                set_record(f, node, [x + sign * force.x, y + sign * force.y, z + sign * force.z, 0.0]);
            }
        }
        sum
    }
}

/// The tiles of a batch of elements.
#[derive(Debug)]
pub(super) struct Tiles<const N: usize> {
    /// every element's nodes by where their records begin in the tile's window
    local: Vec<[u16; N]>,
    /// the nodes of all windows, one tile after the other
    window: Vec<u32>,
    plan: Vec<Plan>,
}

/// What one tile owns of the lists.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub elements: Range<usize>,
    /// its part of the list of windows
    pub window: Range<usize>,
    /// whether its nodes follow each other
    contiguous: bool,
}

impl<const N: usize> Tiles<N> {
    /// Cuts elements, in their order, where a window would become too large.
    pub fn new(elements: &[[u32; N]]) -> Self {
        let n_nodes = elements.as_flattened().iter().max().map_or(0, |&i| i as usize + 1);
        let mut place = vec![u16::MAX; n_nodes];
        let mut tiles = Tiles { local: vec![[0; N]; elements.len()], window: Vec::new(), plan: Vec::new() };
        let (mut first, mut start) = (0, 0);
        for (i, nodes) in elements.iter().enumerate() {
            let new = nodes.iter().filter(|&&n| place[n as usize] == u16::MAX).count();
            if tiles.window.len() - start + new > WINDOW {
                tiles.close(elements, first..i, start, &mut place);
                (first, start) = (i, tiles.window.len());
            }
            for &node in nodes {
                if std::mem::replace(&mut place[node as usize], 0) == u16::MAX {
                    tiles.window.push(node);
                }
            }
        }
        if first < elements.len() {
            tiles.close(elements, first..elements.len(), start, &mut place);
        }
        tiles
    }

    fn close(&mut self, elements: &[[u32; N]], range: Range<usize>, start: usize, place: &mut [u16]) {
        let window = &mut self.window[start..];
        window.sort_unstable();
        for (at, &node) in (0u16..).step_by(RECORD).zip(window.iter()) {
            place[node as usize] = at;
        }
        for (local, nodes) in self.local[range.clone()].iter_mut().zip(&elements[range.clone()]) {
            *local = nodes.map(|n| place[n as usize]);
        }
        for &node in window.iter() {
            place[node as usize] = u16::MAX;
        }
        let contiguous = window.windows(2).all(|w| w[1] == w[0] + 1);
        self.plan.push(Plan { elements: range, window: start..self.window.len(), contiguous });
    }

    pub fn plan(&self) -> &[Plan] {
        &self.plan
    }

    /// Nodes of a tile's window.
    pub fn nodes(&self, plan: &Plan) -> impl Iterator<Item = u32> {
        self.window[plan.window.clone()].iter().copied()
    }

    /// Element nodes of a tile by where their records begin in its window.
    pub fn local(&self, plan: &Plan) -> &[[u16; N]] {
        &self.local[plan.elements.clone()]
    }

    /// Copies a nodal vector into a tile's window.
    pub fn load(&self, plan: &Plan, from: &[DVec3], to: &mut [Padded]) {
        let nodes = &self.window[plan.window.clone()];
        match nodes.first() {
            Some(&first) if plan.contiguous => copy_rows(&from[first as usize..first as usize + nodes.len()], to),
            _ => {
                for (to, &node) in to.iter_mut().zip(nodes) {
                    let from = from[node as usize];
                    *to = [from.x, from.y, from.z, 0.0];
                }
            }
        }
    }

    /// Adds a tile's sums to the nodes.
    pub fn add(&self, plan: &Plan, sums: &[Padded], f: &mut [DVec3]) {
        let nodes = &self.window[plan.window.clone()];
        match nodes.first() {
            Some(&first) if plan.contiguous => add_rows(sums, &mut f[first as usize..first as usize + nodes.len()]),
            _ => {
                for (sum, &node) in sums.iter().zip(nodes) {
                    f[node as usize] += DVec3::new(sum[0], sum[1], sum[2]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_all_elements_in_order_and_windows_name_their_nodes() {
        let chain: Vec<[u32; 2]> = (0..10_000).map(|i| [i, i + 1]).collect();
        let tiles = Tiles::new(&chain);
        assert!(tiles.plan().len() > 4, "{} tiles", tiles.plan().len());
        let mut next = 0;
        for plan in tiles.plan() {
            assert_eq!(plan.elements.start, next);
            next = plan.elements.end;
            let nodes: Vec<u32> = tiles.nodes(plan).collect();
            assert!(nodes.len() <= WINDOW && plan.contiguous);
            for (local, global) in tiles.local(plan).iter().zip(&chain[plan.elements.clone()]) {
                assert_eq!(local.map(|i| nodes[i as usize / RECORD]), *global);
            }
        }
        assert_eq!(next, chain.len());
    }
}
