//! Tiles: runs of elements that touch few nodes, so that a pass over them works in the first caches.
//!
//! A tile copies the positions and velocities of its nodes into a window of records of four numbers (one vector register each),
//! numbers its elements' nodes within the window, and sums forces there. What it found is then added to the nodes, tile after tile.

use super::NodeState;
pub use crate::model::quad::Padded;
use glam::DVec3;
use multiversion::multiversion;
use std::ops::Range;

/// Nodes a tile touches at most. Three windows of this size fit into the second-level cache.
pub(super) const WINDOW: usize = 2048;

/// The elements of a tile as a kernel sees them.
#[derive(Clone, Copy)]
pub struct Tile<'a, const N: usize> {
    /// the whole scene's state
    pub at: NodeState<'a>,
    /// [m] positions of the window's nodes, where the kernel wants them
    pub x: &'a [Padded],
    /// [m/s] their velocities, where the kernel wants them
    pub v: &'a [Padded],
    /// every element's nodes, by their place in the window
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
    pub fn each(&self, signs: [f64; N], f: &mut [Padded], mut element: impl FnMut(usize) -> (DVec3, f64)) -> f64 {
        let mut sum = 0.0;
        for (nodes, number) in self.nodes.iter().zip(self.range()) {
            let (force, amount) = element(number);
            sum += amount;
            for (&node, sign) in nodes.iter().zip(signs) {
                let f = &mut f[node as usize];
                *f = plus(*f, times(sign, Padded([force.x, force.y, force.z, 0.0])));
            }
        }
        sum
    }
}

/// a + b
#[inline(always)]
pub(crate) fn plus(Padded(a): Padded, Padded(b): Padded) -> Padded {
    Padded([a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]])
}

/// s a
#[inline(always)]
pub(crate) fn times(s: f64, Padded(a): Padded) -> Padded {
    Padded([s * a[0], s * a[1], s * a[2], s * a[3]])
}

/// The tiles of a batch of elements.
#[derive(Debug)]
pub(super) struct Tiles<const N: usize> {
    /// every element's nodes by their place in the tile's window
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
        for (at, &node) in (0u16..).zip(window.iter()) {
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

    /// Element nodes of a tile by their place in its window.
    pub fn local(&self, plan: &Plan) -> &[[u16; N]] {
        &self.local[plan.elements.clone()]
    }

    /// Copies a nodal vector into a tile's window.
    pub fn load(&self, plan: &Plan, from: &[DVec3], to: &mut Vec<Padded>) {
        let nodes = &self.window[plan.window.clone()];
        to.resize(nodes.len(), Padded::default());
        match nodes.first() {
            Some(&first) if plan.contiguous => {
                pad(bytemuck::cast_slice(&from[first as usize..first as usize + nodes.len()]), to);
            }
            _ => {
                for (to, &node) in to.iter_mut().zip(nodes) {
                    let from = from[node as usize];
                    *to = Padded([from.x, from.y, from.z, 0.0]);
                }
            }
        }
    }

    /// Adds a tile's sums to the nodes.
    pub fn add(&self, plan: &Plan, sums: &[Padded], f: &mut [DVec3]) {
        let nodes = &self.window[plan.window.clone()];
        match nodes.first() {
            Some(&first) if plan.contiguous => {
                for (f, Padded(sum)) in f[first as usize..].iter_mut().zip(sums) {
                    *f += DVec3::new(sum[0], sum[1], sum[2]);
                }
            }
            _ => {
                for (Padded(sum), &node) in sums.iter().zip(nodes) {
                    f[node as usize] += DVec3::new(sum[0], sum[1], sum[2]);
                }
            }
        }
    }
}

/// Reads four numbers at once and drops the last, which belongs to the next node.
#[multiversion(targets("x86_64+avx+avx2"))]
fn pad(from: &[f64], to: &mut [Padded]) {
    let Some((last, to)) = to.split_last_mut() else { return };
    for (i, to) in to.iter_mut().enumerate() {
        let from = &from[3 * i..3 * i + 4];
        *to = Padded([from[0], from[1], from[2], 0.0]);
    }
    let from = &from[3 * to.len()..];
    *last = Padded([from[0], from[1], from[2], 0.0]);
}

/// A thread's room for the windows of one tile.
#[derive(Debug, Default)]
pub(super) struct Windows {
    pub x: Vec<Padded>,
    pub v: Vec<Padded>,
    pub f: Vec<Padded>,
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
                assert_eq!(local.map(|i| nodes[i as usize]), *global);
            }
        }
        assert_eq!(next, chain.len());
    }
}
