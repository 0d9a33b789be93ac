//! The pressure of the air on each of the user's triangles, for frames.

use crate::force::kernel::batch::Kernel;
use crate::force::kernel::faces::FaceKernel;
use crate::force::law::air::AirData;
use crate::force::law::canopy::CanopyData;
use crate::force::law::gas::GasData;
use crate::force::law::rings::RingsData;
use crate::force::law::surface_pressure::SurfacePressureData;
use crate::force::{Copies, NodeState};
use crate::mesh::Mesh;
use std::collections::HashMap;
use std::sync::Arc;

/// A law of the air with its way back to the user's triangles.
#[derive(Debug)]
pub(super) struct AirPressure {
    law: AirLaw,
    /// user's triangle of each triangle of the law, and 1, or -1 where the law has turned it
    places: Arc<[(u32, f64)]>,
}

/// The laws that put pressures on triangles.
#[derive(Debug)]
pub(super) enum AirLaw {
    /// air through cloth
    Cloth(AirData),
    /// air in a canopy
    Canopy(CanopyData),
    /// air in a canopy, ring by ring
    Rings(RingsData),
    /// gas in a volume
    Gas(GasData),
    /// wind on a zone
    Surface(SurfacePressureData),
}

impl AirPressure {
    /// A law on a mesh; `internal` is the scene's number of each of its nodes.
    pub(super) fn new(law: AirLaw, mesh: &Mesh, internal: &[u32]) -> Self {
        let numbered = mesh.triangles.iter().zip(0_u32..);
        let known: HashMap<[u32; 3], (u32, f64)> = numbered
            .map(|(corners, triangle)| {
                let (key, turn) = sorted(corners.map(|node| internal[node as usize]));
                (key, (triangle, turn))
            })
            .collect();
        let triangles = match &law {
            AirLaw::Cloth(data) => &data.triangles,
            AirLaw::Canopy(data) => &data.triangles,
            AirLaw::Rings(data) => &data.triangles,
            AirLaw::Surface(data) => &data.triangles,
            AirLaw::Gas(data) => &data.triangles,
        };
        let place = |&corners: &[u32; 3]| {
            let (key, turn) = sorted(corners);
            known.get(&key).map_or((u32::MAX, 0.0), |(triangle, of_mesh)| (*triangle, turn * of_mesh))
        };
        let places = triangles.iter().map(place).collect();
        Self { law, places }
    }

    /// That of another run.
    pub(super) fn for_run(&self, copies: &mut Copies) -> Self {
        let law = match &self.law {
            AirLaw::Cloth(data) => AirLaw::Cloth(data.for_run(copies)),
            AirLaw::Canopy(data) => AirLaw::Canopy(data.for_run(copies)),
            AirLaw::Rings(data) => AirLaw::Rings(data.for_run(copies).unwrap_or_else(|| data.clone())),
            AirLaw::Gas(data) => AirLaw::Gas(data.copy(copies)),
            AirLaw::Surface(data) => AirLaw::Surface(data.for_run(copies).unwrap_or_else(|| data.clone())),
        };
        AirPressure { law, places: self.places.clone() }
    }

    /// Adds the pressures [Pa] of its triangles, `[n_triangles]`, user's numbers.
    pub(super) fn add(&self, at: NodeState<'_>, out: &mut [f64]) {
        let mut set = |(triangle, turn): (u32, f64), pressure: f64| {
            if let Some(to) = out.get_mut(triangle as usize) {
                // Not a sum with 0, which would lose the sign of a pressure of -0.
                *to = if *to == 0.0 { turn * pressure } else { *to + turn * pressure };
            }
        };
        match &self.law {
            AirLaw::Cloth(data) => data.pressures(at).zip(self.places.iter()).for_each(|(p, place)| set(*place, p)),
            AirLaw::Canopy(data) => data.pressures(at).zip(self.places.iter()).for_each(|(p, place)| set(*place, p)),
            AirLaw::Gas(data) => data.pressures(at).zip(self.places.iter()).for_each(|(p, place)| set(*place, p)),
            AirLaw::Surface(data) => data.pressures(at).zip(self.places.iter()).for_each(|(p, place)| set(*place, p)),
            AirLaw::Rings(data) => {
                data.pressures(at).into_iter().zip(self.places.iter()).for_each(|(p, place)| set(*place, p));
            }
        }
    }
}

/// The nodes in ascending order, and 1 if they turn the same way in it, else -1.
fn sorted([a, b, c]: [u32; 3]) -> ([u32; 3], f64) {
    let mut nodes = [a, b, c];
    nodes.sort_unstable();
    let turned = [[a, b, c], [b, c, a], [c, a, b]].contains(&nodes);
    (nodes, if turned { 1.0 } else { -1.0 })
}
