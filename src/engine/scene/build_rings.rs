//! The rings of a canopy from its rows of cloth: bands, gaps between them, and what lets air through.

use super::check_values::BuildError;
use crate::force::kernel::element_block::NodeVectors;
use crate::force::law::axial_flow::CanopyAxis;
use crate::force::law::rings::{MOST_STATIONS, Passage, RingsData, Stations};
use crate::force::law::triangle::AreaVector;
use crate::model::spec::RingsSpec;
use nalgebra::Vector3;
use std::collections::HashMap;
use std::sync::Arc;

/// Positions [m] at the start and as cut.
#[derive(Clone, Copy)]
pub(super) struct Shapes<'a> {
    pub start: &'a [Vector3<f64>],
    pub cut: &'a [Vector3<f64>],
}

/// [-] Depth of a canopy over the length of its axis that counts as flat: rounding.
const FLAT: f64 = 1e-9;

const fn refused(reason: &'static str) -> BuildError {
    BuildError::Rings { row: None, reason }
}

const fn refused_at(row: usize, reason: &'static str) -> BuildError {
    BuildError::Rings { row: Some(row), reason }
}

/// The law of a canopy with these triangles, whose normals point outwards, and rows, in internal numbers. Of a canopy
/// with more rows than there can be bands every second row, every third, and so on is a ring.
pub(super) fn rings(
    spec: &RingsSpec,
    rows: &[Vec<u32>],
    triangles: Arc<[[u32; 3]]>,
    axis: CanopyAxis,
    shapes: Shapes<'_>,
    nominal_area: f64,
) -> Result<RingsData, BuildError> {
    let rows = turned(rows, &axis, shapes.start)?;
    let last = rows.len() - 1;
    let each = last.div_ceil(MOST_STATIONS);
    let count = last.div_ceil(each);
    let mut row_of = HashMap::new();
    for (row, nodes) in rows.iter().enumerate() {
        row_of.extend(nodes.iter().map(|&node| (node, row)));
    }
    let mut between: Vec<Vec<[u32; 3]>> = vec![Vec::new(); last];
    let mut bands = Vec::with_capacity(triangles.len());
    for nodes in triangles.iter() {
        let found = nodes.map(|node| row_of.get(&node).copied());
        let [Some(a), Some(b), Some(c)] = found else { return Err(refused("has triangles beside its rows")) };
        let (first, end) = (a.min(b).min(c), a.max(b).max(c));
        if end != first + 1 {
            return Err(refused_at(first, "has triangles that do not lie between two neighbouring rows"));
        }
        between[first].push(*nodes);
        bands.push((first / each) as u16);
    }
    let discharge = spec.slot_discharge;
    let area = |nodes: &[u32; 3]| AreaVector::new(shapes.cut, *nodes).s.norm();
    let (mut cloth, mut open) = (vec![0.0; count], vec![0.0; count]);
    for (row, faces) in between.iter_mut().enumerate() {
        let gap = faces.is_empty();
        if gap {
            *faces = gap_between(&rows[row], &rows[row + 1])
                .ok_or_else(|| refused_at(row, "has a gap between two rows with different numbers of nodes"))?;
        }
        let size: f64 = faces.iter().map(area).sum();
        cloth[row / each] += size;
        open[row / each] += size * if gap { 1.0 } else { spec.geometric_porosity };
    }
    let slots = cloth.iter().zip(&open).map(|(all, open)| if *all > 0.0 { discharge * open / all } else { 0.0 });
    let passage = Passage {
        cloth: spec.cloth.map(|cloth| [cloth.linear, cloth.quadratic]),
        slots: slots.collect(),
        vent: spec.vent_discharge,
    };
    let faces = between.chunks(each).map(<[_]>::concat).collect();
    let rings = (0..count).map(|i| i * each).chain([last]).map(|row| rows[row].clone()).collect();
    let stations = Stations::new(rings, faces, shapes.cut, nominal_area);
    let RingsSpec { outer_pressure_coefficient, damping, .. } = *spec;
    Ok(RingsData {
        triangles,
        bands: bands.into(),
        axis,
        stations: Arc::new(stations),
        passage: Arc::new(passage),
        outer: outer_pressure_coefficient,
        damping,
    })
}

/// The rows, right-handed about the outer normal: the skirt's area vector points away from the confluence.
fn turned(rows: &[Vec<u32>], axis: &CanopyAxis, start: &[Vector3<f64>]) -> Result<Vec<Vec<u32>>, BuildError> {
    let x = NodeVectors::Nodes(start);
    let [.., skirt] = rows else { return Err(refused("needs rows of cloth")) };
    let closed = |(i, row): &(usize, &Vec<u32>)| row.len() > 2 || (*i == 0 && row.len() == 1);
    let loops = "needs at least two rows, each a loop of three nodes or more; the first may be an apex";
    if rows.len() < 2 {
        return Err(refused(loops));
    }
    if let Some((row, _)) = rows.iter().enumerate().find(|row| !closed(row)) {
        return Err(refused_at(row, loops));
    }
    let [apex, confluence, middle] = [&axis.apex, &axis.confluence, skirt].map(|nodes| x.mean(nodes));
    let along = confluence - apex;
    let depth = (middle - apex).dot(&along);
    if (confluence - middle).dot(&along) <= 0.0 || depth < -FLAT * along.norm_squared() {
        let reason = "needs a skirt between its apex and its confluence at the start: the lines meet upstream of the cloth; \
                      take the start stretched, or move the confluence";
        return Err(refused_at(rows.len() - 1, reason));
    }
    let mouth = opening(skirt, start);
    if mouth == Vector3::zeros() {
        let reason = "has a mouth of no area at the start: open the skirt, as by a start_radius";
        return Err(refused_at(rows.len() - 1, reason));
    }
    let mut rows = rows.to_vec();
    if mouth.dot(&along) > 0.0 {
        rows.iter_mut().for_each(|row| row.reverse());
    }
    Ok(rows)
}

/// \[m^2\] Area vector of a loop.
fn opening(row: &[u32], x: &[Vector3<f64>]) -> Vector3<f64> {
    let at = |i: usize| x[row[i % row.len()] as usize] - x[row[0] as usize];
    (0..row.len()).map(|i| 0.5 * at(i).cross(&at(i + 1))).sum()
}

/// Faces that close a gap between two rows with as many nodes.
fn gap_between(above: &[u32], below: &[u32]) -> Option<Vec<[u32; 3]>> {
    if above.len() != below.len() {
        return None;
    }
    let next = |i: usize| (i + 1) % above.len();
    let faces = |i: usize| [[above[i], below[i], below[next(i)]], [above[i], below[next(i)], above[next(i)]]];
    Some((0..above.len()).flat_map(faces).collect())
}
