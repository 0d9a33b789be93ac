//! Dashpots on the whole relative velocity of a spring's ends (thesis Eq. 53 and 68; Kang 2000).
//!
//! ```text
//! force on a = c (vb - va), on b = -c (vb - va)      power = -c |vb - va|^2      -df/dv = c [[I, -I], [-I, I]]
//! ```
//! They also damp rigid rotation, so they are not a material; the thesis uses them with c = k dt.

use super::batch::{Batch, Kernel, LANES, Lanes, Padded, Threads, Tile, Wants};
use super::spring::Coefficient;
use super::tile::{minus, plus, times};
use super::{ForceTerm, NodeState, TangentSink};
use crate::model::forces::{Role, Tally};
use crate::model::system::{TermInfo, Weights};
use glam::{DMat3, DVec3};
use multiversion::multiversion;
use std::sync::Arc;

/// A batch of relative dashpots.
#[derive(Debug)]
pub struct RelativeDashpots(Batch<RelativeData, 2>);

/// Plain arrays of the batch.
#[derive(Clone, Debug)]
pub struct RelativeData {
    /// end nodes
    pub nodes: Arc<[[u32; 2]]>,
    /// [N s/m] c
    pub coefficient: Coefficient,
}

impl RelativeDashpots {
    /// Makes the term.
    pub fn new(data: RelativeData) -> Self {
        RelativeDashpots(Batch::new(data))
    }
}

impl Kernel<2> for RelativeData {
    const WANTS: Wants = Wants { x: false, v: true };

    fn elements(&self) -> &[[u32; 2]] {
        &self.nodes
    }

    fn add(&self, tile: Tile<'_, 2>, f: &mut [Padded]) -> Tally {
        Tally { energy: 0.0, power: add_dashpots(self, tile, f) }
    }
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn add_dashpots(data: &RelativeData, tile: Tile<'_, 2>, f: &mut [Padded]) -> f64 {
    match &data.coefficient {
        Coefficient::Uniform(c) => add_blocks(tile, std::iter::repeat(&[*c; LANES]), std::iter::repeat(c), f),
        Coefficient::Each(c) => {
            let (c, last) = c[tile.range()].as_chunks();
            add_blocks(tile, c.iter(), last.iter(), f)
        }
    }
}

#[inline(always)]
fn add_blocks<'a>(
    tile: Tile<'_, 2>,
    blocks: impl Iterator<Item = &'a [f64; LANES]>,
    last: impl Iterator<Item = &'a f64>,
    f: &mut [Padded],
) -> f64 {
    let mut power = Lanes::default();
    let (nodes, rest) = tile.nodes.as_chunks::<LANES>();
    for (nodes, c) in nodes.iter().zip(blocks) {
        add_block(nodes, c, tile.v, f, &mut power);
    }
    for (nodes, c) in rest.iter().zip(last) {
        add_block(&[*nodes], &[*c], tile.v, f, &mut power);
    }
    power.total()
}

#[inline(always)]
fn add_block<const B: usize>(nodes: &[[u16; 2]; B], c: &[f64; B], v: &[Padded], f: &mut [Padded], power: &mut Lanes) {
    let mut dv = [[0.0; 4]; B];
    let mut given = [0.0; B];
    for j in 0..B {
        dv[j] = minus(v[nodes[j][1] as usize], v[nodes[j][0] as usize]);
    }
    for j in 0..B {
        given[j] = -c[j] * (dv[j][0] * dv[j][0] + dv[j][1] * dv[j][1] + dv[j][2] * dv[j][2]);
    }
    power.add(&given);
    for j in 0..B {
        let [a, b] = nodes[j];
        let force = times(c[j], dv[j]);
        f[a as usize] = plus(f[a as usize], force);
        f[b as usize] = minus(f[b as usize], force);
    }
}

impl ForceTerm for RelativeDashpots {
    fn info(&self) -> TermInfo {
        TermInfo { name: "relative dashpots", role: Role::Dissipative }
    }

    fn elements(&self) -> usize {
        self.0.elements()
    }

    fn velocity_dependent(&self) -> bool {
        true
    }

    fn symmetric(&self) -> bool {
        true
    }

    fn add(&self, at: NodeState<'_>, threads: &Threads, f: &mut [DVec3]) -> Tally {
        self.0.add(at, threads, f)
    }

    fn tangent(&self, _at: NodeState<'_>, w: Weights, sink: &mut dyn TangentSink) {
        let data = self.0.kernel();
        for (i, &nodes) in data.nodes.iter().enumerate() {
            sink.edge(nodes, DMat3::from_diagonal(DVec3::splat(w.c * data.coefficient.at(i))));
        }
    }
}
