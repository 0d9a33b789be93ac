//! From a plain specification to the force terms of membranes, in internal numbering.

use super::acting::Added;
use super::build::Builder;
use super::check_values::BuildError;
use crate::force::law::membrane::{Membrane, MembraneData, RestShape};
use crate::force::law::rayleigh_membrane::{RayleighMembrane, RayleighMembraneData};
use crate::force::law::tension_field::Sheet;
use crate::model::spec::MembraneSpec;
use nalgebra::Vector3;

/// Membrane triangles of one rule, as the terms hold them, with their way back to the user's triangles.
#[derive(Clone, Debug)]
pub(super) struct MembraneBatch {
    /// arrays shared with the terms
    pub data: MembraneData,
    /// user's number of every triangle
    pub triangles: Vec<u32>,
    /// [m]
    pub thickness: f64,
}

impl MembraneBatch {
    /// In scaled axes: see [`crate::force::law::tension_field`].
    fn new(
        spec: &MembraneSpec,
        corners: impl Fn(u32) -> [u32; 3],
        cut: impl Fn(u32) -> Option<[Vector3<f64>; 3]>,
    ) -> Result<Self, BuildError> {
        let [one, two] = spec.modulus;
        let sheet = Sheet {
            poisson: spec.poisson * (two / one).sqrt(),
            compliance: one.sqrt() * two.sqrt() / spec.shear,
            wrinkles: spec.wrinkling,
        };
        let scale = spec.modulus.map(|modulus| (modulus * spec.thickness).sqrt().sqrt());
        let mut list: Vec<(u32, [u32; 3])> = spec.triangles.iter().map(|&t| (t, corners(t))).collect();
        list.sort_unstable_by_key(|(_, t)| (t[0].min(t[1]).min(t[2]), *t));
        let mut shapes = Vec::with_capacity(list.len());
        for (triangle, _) in &list {
            let [a, b, c] = cut(*triangle).ok_or(BuildError::RestShape { triangle: *triangle })?;
            let warp = spec.warp.map_or(b - a, Vector3::from);
            let shape = RestShape::new([b - a, c - a], warp, scale);
            shapes.push(shape.ok_or(BuildError::RestShape { triangle: *triangle })?);
        }
        let (triangles, nodes): (Vec<u32>, Vec<[u32; 3]>) = list.into_iter().unzip();
        let (damping_time, thickness) = (spec.damping_time, spec.thickness);
        let data = MembraneData { triangles: nodes.into(), shapes: shapes.into(), scale, sheet, damping_time };
        Ok(MembraneBatch { data, triangles, thickness })
    }
}

impl Builder<'_> {
    pub(super) fn membranes(&mut self) -> Result<(), BuildError> {
        for spec in &self.spec.membranes {
            let corners = |t: u32| self.spec.mesh.triangles[t as usize].map(|i| self.node(i));
            let batch = MembraneBatch::new(spec, corners, |t| self.spec.mesh.cut_corners(t))?;
            self.acting.add(Added::term(Membrane::new(batch.data.clone())));
            self.membranes.push(batch);
        }
        Ok(())
    }

    pub(super) fn rayleigh_membranes(&mut self, beta: f64, rest: &[Vector3<f64>]) {
        for MembraneBatch { data, .. } in &self.membranes {
            let triangles = data.triangles.clone();
            let rest = (0..triangles.len()).map(|i| data.at_rest(i, rest, beta)).collect();
            self.acting.add(Added::term(RayleighMembrane::new(RayleighMembraneData { triangles, rest })));
        }
    }
}
