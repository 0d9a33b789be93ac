//! Sums over neighbours along springs: `out_i = sum_j k_ij u_j`, the second sweep of Kang's filter. Not a force term: no force of a scene
//! has this form.

use super::batch::{Batch, Elements, Kernel, Records, Wants};
use super::spring::Coefficient;
use super::window::{record, set_record};
use crate::model::forces::Tally;
use multiversion::multiversion;
use std::sync::Arc;

/// Springs by their ends and stiffness.
#[derive(Clone, Debug)]
pub struct Links {
    /// end nodes
    pub nodes: Arc<[[u32; 2]]>,
    /// [N/m] k
    pub stiffness: Coefficient,
}

/// A batch of links.
pub type Neighbours = Batch<Links, 2>;

impl Kernel<2> for Links {
    const WANTS: Wants = Wants { x: true, v: false };

    fn elements(&self) -> &[[u32; 2]] {
        &self.nodes
    }

    fn add(&self, tile: Elements<'_, 2>, f: &mut Records) -> Tally {
        add_links(self, tile, f);
        Tally::default()
    }
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn add_links(links: &Links, tile: Elements<'_, 2>, f: &mut Records) {
    match &links.stiffness {
        Coefficient::Uniform(k) => tile.nodes.iter().for_each(|&nodes| add_link(nodes, *k, tile.x, f)),
        Coefficient::Each(k) => {
            for (&nodes, k) in tile.nodes.iter().zip(&k[tile.range()]) {
                add_link(nodes, *k, tile.x, f);
            }
        }
    }
}

#[inline(always)]
fn add_link([a, b]: [u16; 2], k: f64, u: &Records, f: &mut Records) {
    add_scaled(f, a, k, record(u, b));
    add_scaled(f, b, k, record(u, a));
}

#[inline(always)]
fn add_scaled(f: &mut Records, node: u16, k: f64, u: [f64; 4]) {
    let sum = record(f, node);
    set_record(f, node, [sum[0] + k * u[0], sum[1] + k * u[1], sum[2] + k * u[2], sum[3] + k * u[3]]);
}
