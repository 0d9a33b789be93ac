//! Gas in closed volumes, from its specification.

use super::acting::Added;
use super::air_pressure::AirLaw;
use super::build::Builder;
use super::check_values::BuildError;
use crate::force::kernel::element_block::NodeVectors;
use crate::force::law::enclosure::Enclosure;
use crate::force::law::gas::{Gas, GasData, GasLaw};
use crate::force::law::series::scalar;
use crate::force::law::triangle::AreaVector;
use crate::model::spec::{GasFill, GasSpec};
use nalgebra::Vector3;
use std::collections::BTreeSet;
use std::sync::Arc;

/// [-] Volume over the power 3/2 of the area of its surface below which cloth lies flat; a sphere has 0.09.
const FLAT: f64 = 1e-9;

impl Builder<'_> {
    pub(super) fn gases(&mut self, start: &[Vector3<f64>]) -> Result<(), BuildError> {
        for gas in &self.spec.gases {
            let data = self.gas(gas, start)?;
            self.show_pressure(AirLaw::Gas(data.clone()));
            self.acting.gases.push((self.acting.terms.len(), data.clone()));
            let table = data.law.table.clone();
            self.acting.add(Added::term(Gas::new(data)).by([table]));
        }
        Ok(())
    }

    fn gas(&self, gas: &GasSpec, start: &[Vector3<f64>]) -> Result<GasData, BuildError> {
        let mut triangles = self.triangles(gas.triangles.iter().copied());
        let mut enclosure = Enclosure::new(triangles.clone());
        self.held_rims(&enclosure)?;
        let Some([first, ..]) = triangles.first() else {
            return Err(BuildError::Gas { reason: "has no triangles around it" });
        };
        let x = NodeVectors::Nodes(start);
        let [volume, _] = enclosure.volume(x, x, x.at(*first));
        let area: f64 = triangles.iter().map(|nodes| AreaVector::new(start, *nodes).s.norm()).sum();
        let flat = volume.abs() <= FLAT * area.powf(1.5);
        if flat && gas.volume.is_none() {
            let reason = "fills no volume at the start: give its \"volume\", or begin with an initial displacement";
            return Err(BuildError::Gas { reason });
        }
        if volume < 0.0 && !flat {
            triangles = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
            enclosure = Enclosure::new(triangles.clone());
        }
        let enclosed = if flat { volume } else { volume.abs() };
        let at_start = gas.volume.unwrap_or(enclosed);
        let by_pressure = matches!(gas.fill, GasFill::Pressure(_));
        let table = scalar(gas.fill.table());
        let law =
            GasLaw { ambient: gas.ambient, gamma: gas.gamma, at_start, table, by_pressure, filled: Arc::default() };
        let (enclosure, beside) = (Arc::new(enclosure), at_start - enclosed);
        Ok(GasData { triangles, enclosure, beside, law, stiffness: [].into() }.stiff_at(start))
    }

    /// Whether all nodes of all rims are held for ever where they are.
    fn held_rims(&self, enclosure: &Enclosure) -> Result<(), BuildError> {
        let held = self.spec.always_fixed();
        let moved = self.spec.motions.iter().flat_map(|motion| &motion.nodes);
        let moved: BTreeSet<u32> = moved.map(|(node, _)| *node).collect();
        let users = enclosure.rims().iter().flatten().map(|&node| self.numbering.user[node as usize]);
        match users.filter(|&node| held[node as usize] != [true; 3] || moved.contains(&node)).min() {
            Some(node) => Err(BuildError::OpenGas { node }),
            None => Ok(()),
        }
    }
}
