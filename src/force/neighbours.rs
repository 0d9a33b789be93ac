//! Sums over neighbours along springs: `out_i = sum_j k_ij u_j`, the second sweep of Kang's filter. Not a force term: no force of a scene
//! has this form.

use super::batch::{Records, Wants};
use super::coefficient::Column;
use super::edges::{EdgeBatch, EdgeKernel, Edges};
use super::fans::link_fans;
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
pub type Neighbours = EdgeBatch<Links>;

impl EdgeKernel for Links {
    const WANTS: Wants = Wants { x: true, v: false };

    fn elements(&self) -> &[[u32; 2]] {
        &self.nodes
    }

    fn numbers(&self) -> [Coefficient; 2] {
        [self.stiffness.clone(), Coefficient::Uniform(0.0)]
    }

    fn add(&self, tile: Edges<'_>, f: &mut Records) -> Tally {
        let ((fans, [of_fans, _]), (others, [of_others, _])) = (tile.fans(), tile.others());
        link_fans(of_fans, fans, tile.x, f);
        add_links(of_others, others, tile.x, f);
        Tally::default()
    }
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn add_links(k: Column<'_>, links: &[[u16; 2]], u: &Records, f: &mut Records) {
    for (i, &nodes) in links.iter().enumerate() {
        add_link(nodes, k.at(i), u, f);
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
