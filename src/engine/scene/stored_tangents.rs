//! K and C of a network at a state, for many products: the blocks of two-node elements, as springs and dashpots are,
//! are stored if they are symmetric. All other terms find theirs again for every product.

use super::network::{Network, by_node, node_state};
use super::product::Product;
use crate::force::{ForceTerm, TangentForm, TangentSink};
use crate::model::state::StateRef;
use crate::model::system::Weights;
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// Elements of a section.
const SECTION: usize = 16_384;
/// Elements a node that are stored: a net of triangles has three springs a node. Bending has ten times as many.
const MOST_A_NODE: usize = 8;

/// Products with K and C at a state, again and again.
pub trait TangentProducts {
    /// y = (c C + k K) p, as [`Scene::tangent_times`](super::Scene::tangent_times).
    fn times(&self, w: Weights, p: &[f64], y: &mut [f64]);
}

/// K and C of a network at a state.
pub(super) struct StoredTangents<'a> {
    network: &'a Network,
    at: StateRef<'a>,
    stiffness: Stored<'a>,
    damping: Stored<'a>,
}

/// K or C.
struct Stored<'a> {
    elements: Vec<Edge>,
    /// of the elements, in their order, which mostly is that of nodes: then sections have few nodes in common
    sections: Vec<Section>,
    /// the terms that have other elements
    others: Vec<&'a dyn ForceTerm>,
}

/// Elements that one thread multiplies.
struct Section {
    /// what their nodes are among
    nodes: Range<usize>,
    /// [N] of the last product, for `nodes`
    sums: Mutex<Vec<Vector3<f64>>>,
}

/// The element `[[B, -B], [-B, B]]` with a symmetric B.
struct Edge {
    nodes: [u32; 2],
    /// [N/m] of K, [N s/m] of C: xx, xy, xz, yy, yz, zz
    block: [f64; 6],
}

impl<'a> StoredTangents<'a> {
    /// `None` where nothing can be stored.
    pub(super) fn of(network: &'a Network, at: StateRef<'a>) -> Option<Self> {
        let [stiffness, damping] = [[1.0, 0.0], [0.0, 1.0]].map(|[k, c]| {
            let w = Weights { m: 0.0, c, k };
            Stored::of(network, at, w)
        });
        let any = !stiffness.elements.is_empty() || !damping.elements.is_empty();
        any.then_some(StoredTangents { network, at, stiffness, damping })
    }
}

impl TangentProducts for StoredTangents<'_> {
    fn times(&self, w: Weights, p: &[f64], y: &mut [f64]) {
        let StoredTangents { network, at, stiffness, damping } = self;
        y.fill(0.0);
        let mut product = Product::<false>::new(p, y);
        network.emit_law_tangents(*at, w, TangentForm::EXACT, &mut product);
        network.emit_contact(*at, w, TangentForm::EXACT, &mut product);
        network.add_rank_ones::<false>(*at, w, p, y);
        let alone = |c, k| Weights { m: 0.0, c, k };
        for (factor, stored, w) in [(w.k, stiffness, alone(0.0, w.k)), (w.c, damping, alone(w.c, 0.0))] {
            if factor != 0.0 {
                let mut product = Product::<false>::new(p, y);
                stored
                    .others
                    .iter()
                    .for_each(|term| term.tangent(node_state(*at), w, TangentForm::EXACT, &mut product));
                stored.add(network, factor, by_node(p), bytemuck::cast_slice_mut(y));
            }
        }
        network.hold(y);
    }
}

impl<'a> Stored<'a> {
    fn of(network: &'a Network, at: StateRef<'a>, w: Weights) -> Self {
        let most = MOST_A_NODE * network.built.mass.len();
        let (mut edges, mut others) = (Edges { found: Vec::new(), most, others: false }, Vec::new());
        for term in network.force_terms() {
            let before = edges.found.len();
            edges.others = false;
            term.tangent(node_state(at), w, TangentForm::EXACT, &mut edges);
            if edges.others {
                edges.found.truncate(before);
                others.push(term);
            }
        }
        let mut elements = edges.found;
        elements.shrink_to_fit();
        let sections = elements.chunks(SECTION).map(Section::of).collect();
        Stored { elements, sections, others }
    }

    /// y += factor A p
    fn add(&self, network: &Network, factor: f64, p: &[Vector3<f64>], y: &mut [Vector3<f64>]) {
        let Stored { elements, sections, .. } = self;
        let multiply = |(elements, section): (&[Edge], &Section)| section.multiply(elements, factor, p);
        network.threads.workers().each_section(elements.chunks(SECTION).zip(sections), multiply);
        for Section { nodes, sums } in sections {
            let sums = sums.lock().unwrap_or_else(PoisonError::into_inner);
            y[nodes.clone()].iter_mut().zip(sums.iter()).for_each(|(y, sum)| *y += sum);
        }
    }
}

impl Section {
    fn of(elements: &[Edge]) -> Self {
        let nodes = || elements.iter().flat_map(|edge| edge.nodes);
        let first = nodes().min().unwrap_or(0) as usize;
        let nodes = first..nodes().max().map_or(first, |last| last as usize + 1);
        let sums = Mutex::new(vec![Vector3::zeros(); nodes.len()]);
        Section { nodes, sums }
    }

    fn multiply(&self, elements: &[Edge], factor: f64, p: &[Vector3<f64>]) {
        let (mut sums, first) = (self.sums.lock().unwrap_or_else(PoisonError::into_inner), self.nodes.start);
        sums.fill(Vector3::zeros());
        for Edge { nodes: [a, b], block: [xx, xy, xz, yy, yz, zz] } in elements {
            let (a, b) = (*a as usize, *b as usize);
            let d = (p[a] - p[b]) * factor;
            let force = Vector3::new(
                xx * d.x + xy * d.y + xz * d.z,
                xy * d.x + yy * d.y + yz * d.z,
                xz * d.x + yz * d.y + zz * d.z,
            );
            sums[a - first] += force;
            sums[b - first] -= force;
        }
    }
}

/// Stores two-node elements with symmetric blocks.
struct Edges {
    found: Vec<Edge>,
    /// how many may be stored
    most: usize,
    /// whether there was any other element
    others: bool,
}

impl TangentSink for Edges {
    fn pair(&mut self, _nodes: [u32; 2], _block: Matrix3<f64>) {
        self.others = true;
    }

    fn edge(&mut self, nodes: [u32; 2], b: Matrix3<f64>) {
        let stored = b != Matrix3::zeros();
        self.others |= b != b.transpose() || stored && self.found.len() >= self.most;
        if stored && !self.others {
            let block = [b[(0, 0)], b[(0, 1)], b[(0, 2)], b[(1, 1)], b[(1, 2)], b[(2, 2)]];
            self.found.push(Edge { nodes, block });
        }
    }

    fn segment(&mut self, _nodes: [u32; 2], _blocks: &[[Matrix3<f64>; 2]; 2]) {
        self.others = true;
    }

    fn triangle(&mut self, _nodes: [u32; 3], _blocks: &[[Matrix3<f64>; 3]; 3]) {
        self.others = true;
    }

    fn few(&mut self, _nodes: &[u32], _blocks: &[[Matrix3<f64>; 4]; 4]) {
        self.others = true;
    }
}
