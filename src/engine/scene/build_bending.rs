//! From hinges and chains of a specification to the force terms of bending, in internal numbering.

use super::acting::Added;
use super::build::Builder;
use super::check_values::BuildError;
use crate::force::law::bending::{Bending, BendingData, BendingElement, Hinge};
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// What bending needs of the scene, by internal number.
#[derive(Clone, Copy)]
pub(super) struct AtRest<'a> {
    /// [m]
    pub x: &'a [Vector3<f64>],
    /// directions that are held in the whole run
    pub fixed: &'a [[bool; 3]],
}

impl AtRest<'_> {
    fn held(&self, nodes: &[u32]) -> bool {
        nodes.iter().all(|&node| self.fixed[node as usize] == [true; 3])
    }
}

/// The wing and the rigidity B [N m] of every hinge of a triangle, by the corner across from it.
type Hinges = [Option<(u32, f64)>; 3];

impl Builder<'_> {
    pub(super) fn bending(&mut self, rest: AtRest<'_>) -> Result<(), BuildError> {
        let triangles = self.triangle_elements(rest)?;
        self.bending_term(triangles);
        let chains = self.chain_elements(rest)?;
        self.bending_term(chains);
        Ok(())
    }

    /// The triangles beside hinges. Where several rules select an edge, their stiffnesses add up.
    fn triangle_elements(&self, rest: AtRest<'_>) -> Result<Vec<([u32; 6], BendingElement<6, 3>)>, BuildError> {
        let mut triangles: BTreeMap<[u32; 3], Hinges> = BTreeMap::new();
        for spec in &self.spec.bending {
            for given in &spec.hinges {
                let [a, b, c, d] = given.map(|node| self.node(node));
                for (corner, wing) in [(c, d), (d, c)] {
                    let mut corners = [a, b, corner];
                    corners.sort_unstable();
                    let hinges = triangles.entry(corners).or_default();
                    let across = corners.into_iter().zip(hinges).filter(|(other, _)| *other == corner);
                    for (_, hinge) in across {
                        let before = hinge.map_or(0.0, |(_, rigidity)| rigidity);
                        *hinge = Some((wing, before + spec.stiffness));
                    }
                }
            }
        }
        let mut list = Vec::with_capacity(triangles.len());
        for (corners, hinges) in triangles.into_iter().filter(|(corners, _)| !rest.held(corners)) {
            let hinge = |k: usize| {
                let (wing, rigidity) = hinges[k]?;
                let clamped = rest.held(&[corners[(k + 1) % 3], corners[(k + 2) % 3], wing]);
                Some(Hinge { wing: rest.x[wing as usize], rigidity, clamped })
            };
            let element = BendingElement::triangle(corners.map(|i| rest.x[i as usize]), [0, 1, 2].map(hinge));
            let [a, b, c] = corners;
            let wing = |k: usize| hinges[k].map_or(corners[k], |(wing, _)| wing);
            let ends = [a, b].map(|node| self.numbering.user[node as usize]);
            list.push(([a, b, c, wing(0), wing(1), wing(2)], element.ok_or(BuildError::Hinge { ends })?));
        }
        Ok(list)
    }

    fn chain_elements(&self, rest: AtRest<'_>) -> Result<Vec<([u32; 3], BendingElement<3, 1>)>, BuildError> {
        let mut list = Vec::new();
        for spec in &self.spec.bending {
            for given in &spec.chains {
                let nodes @ [a, b, c] = given.map(|node| self.node(node));
                let held = [rest.held(&[a, b]), rest.held(&[b, c])];
                if held == [true; 2] {
                    continue;
                }
                let [start, middle, end] = nodes.map(|node| rest.x[node as usize]);
                let lengths = [(middle - start).norm(), (end - middle).norm()];
                let element = BendingElement::chain(lengths, held, spec.flexural_rigidity);
                list.push((nodes, element.ok_or(BuildError::Hinge { ends: [given[0], given[1]] })?));
            }
        }
        Ok(list)
    }

    fn bending_term<const N: usize, const R: usize>(&mut self, mut list: Vec<([u32; N], BendingElement<N, R>)>) {
        if list.is_empty() {
            return;
        }
        list.sort_by_key(|(nodes, _)| (nodes.iter().copied().min(), *nodes));
        let (nodes, elements): (Vec<_>, Vec<_>) = list.into_iter().unzip();
        self.acting.add(Added::term(Bending::new(BendingData { nodes, elements })));
    }
}
