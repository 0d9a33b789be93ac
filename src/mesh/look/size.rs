//! Units and axes, by the size and the shape of a mesh.

use super::Cloth;
use crate::format_number::figures;
use crate::{Mesh, Topology};
use nalgebra::Vector3;

/// [m] Extent beyond which lengths are taken to be in a smaller unit.
const LARGE: f64 = 100.0;
/// [m] Extent below which lengths are taken to be in kilometres.
const SMALL: f64 = 0.02;
/// [m] Extents of canopies with their lines.
const CANOPIES: [f64; 2] = [1.0, 100.0];
/// Units of length by their names, with their lengths [m]; the most usual ones first.
pub(crate) const UNITS: [(&str, f64); 5] =
    [("millimetres", 0.001), ("centimetres", 0.01), ("inches", 0.0254), ("feet", 0.3048), ("kilometres", 1000.0)];

/// What an extent [m] says of the unit, if no canopy has it.
pub fn units(extent: f64) -> Option<String> {
    if extent == 0.0 || (SMALL..=LARGE).contains(&extent) {
        return None;
    }
    let fits = |(_, scale): &&(&str, f64)| (CANOPIES[0]..=CANOPIES[1]).contains(&(scale * extent));
    let said = |(name, scale): &(&str, f64)| {
        format!("if these are {name}, {} m across: --scale {scale}", figures(scale * extent, 3))
    };
    let likely: Vec<String> = UNITS.iter().filter(fits).map(said).collect();
    let advice = if likely.is_empty() {
        "give the factor that makes metres of its unit: --scale".to_owned()
    } else {
        likely.join("; ")
    };
    Some(format!("it is {} m across; {advice}, or \"scale\" in a case", figures(extent, 3)))
}

/// [-] Deviation of a round rim from its mean radius.
const ROUND: f64 = 0.15;
/// Nodes of a round rim, at least.
const RIM: usize = 8;
/// [-] Least way from the cloth to its lines, over the extent of the cloth.
const LINES: f64 = 0.3;
/// [-] The same to the rim.
const DOME: f64 = 0.05;

/// What is said of a canopy along y.
pub const Y_IS_UP: &str =
    "the canopy opens along -y, so the y axis of its file seems to point up: --axes y-up, or \"axes\" in a case";

/// Whether a canopy hangs its lines, or opens its round rim, along -y: the y axis of its file points up.
pub fn canopy_along_y(mesh: &Mesh, topology: &Topology) -> bool {
    let cloth = Cloth::new(mesh, topology);
    let mean = |nodes: &[u32]| nodes.iter().map(|n| mesh.point(*n)).sum::<Vector3<f64>>() / nodes.len() as f64;
    let of_cloth: Vec<u32> = (0..mesh.nodes.len() as u32).filter(|node| cloth.of_triangle[*node as usize]).collect();
    let (mut ends, mut beside): (Vec<u32>, Vec<u32>) =
        cloth.lines().flat_map(|(_, pair)| pair).partition(|node| cloth.of_triangle[*node as usize]);
    beside.sort_unstable();
    beside.dedup();
    ends.sort_unstable();
    ends.dedup();
    let centre = mean(&of_cloth);
    let along_y = |way: Vector3<f64>, least: f64| way.norm() > least * cloth.extent && -way.y > 0.9 * way.norm();
    if !beside.is_empty() {
        return ends.len() >= 3 && along_y(mean(&beside) - centre, LINES);
    }
    let mut outer = topology.loops().iter().filter(|rim| rim.outer);
    let (Some(rim), None) = (outer.next(), outer.next()) else { return false };
    let middle = mean(&rim.nodes);
    let radius = |node: &u32| (mesh.point(*node) - middle).norm();
    let usual = rim.nodes.iter().map(radius).sum::<f64>() / rim.nodes.len() as f64;
    let round = rim.nodes.len() >= RIM && rim.nodes.iter().all(|node| (radius(node) / usual - 1.0).abs() < ROUND);
    round && along_y(middle - centre, DOME)
}
