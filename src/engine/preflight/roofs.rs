//! Roofs in a free stream, whose law has no suction.

use super::air::{Sheets, directions};
use crate::format_number::figures;
use crate::mesh::unit_vector::unit_vector;
use crate::model::spec::NetworkSpec;
use crate::warning::{Warning, WarningCode};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::fmt;

/// [-] Mean square of the sine between wind and cloth below which the wind passes along a sheet: a pressure coefficient
/// of 1 then gives less than this share of the dynamic pressure, where roofs have suctions of about as much as it.
const ALONG: f64 = 0.1;

/// [-] The same of a sheet in the plane of the wind, of which another warning tells.
const IN_PLANE: f64 = 1e-8;

/// [-] Extent of the supports along the wind, over that of the sheet, from which on it is a roof: a flag has less.
const HELD: f64 = 0.5;

/// Cloth that is held like a roof in a wind that passes along it.
#[derive(Clone, Debug, PartialEq)]
pub struct RoofInStream {
    /// its first triangle
    pub first: u32,
    /// [-] number of triangles of all such sheets
    pub triangles: usize,
    /// [-] pressure on them over the dynamic pressure, at a pressure coefficient of 1
    pub share: f64,
}

/// A sheet as the winds meet it.
#[derive(Clone, Default)]
struct Sheet {
    triangles: Vec<u32>,
    /// [m^2]
    area: f64,
    /// \[m^2\] by wind: sum of the areas times squares of sines
    met: Vec<f64>,
    /// \[m\] by wind: least and largest place along it, of all nodes and of those with a support
    extents: Vec<[[f64; 2]; 2]>,
}

/// Finds sheets along which all winds of the table pass, and whose supports reach over half of them along these winds.
pub fn roofs(spec: &NetworkSpec) -> Option<RoofInStream> {
    let winds: Vec<Vector3<f64>> = directions(spec.air.as_ref()?.wind.value.iter().map(|w| Vector3::from(*w)))
        .into_iter()
        .filter_map(unit_vector)
        .collect();
    let displaced = |node: u32| spec.displacement.get(node as usize).map_or(Vector3::zeros(), |u| Vector3::from(*u));
    let place = |node: u32| spec.mesh.point(node) + displaced(node);
    let sheets = Sheets::new(spec);
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    let empty = Sheet { met: vec![0.0; winds.len()], extents: vec![[none; 2]; winds.len()], ..Sheet::default() };
    let mut found: BTreeMap<u32, Sheet> = BTreeMap::new();
    for (corners, triangle) in spec.mesh.triangles.iter().zip(0_u32..) {
        let sheet = found.entry(sheets.of(triangle)?).or_insert_with(|| empty.clone());
        let [a, b, c] = corners.map(place);
        let s = 0.5 * (b - a).cross(&(c - a));
        let normal = unit_vector(s).unwrap_or_default();
        sheet.triangles.push(triangle);
        sheet.area += s.norm();
        for ((wind, met), extents) in winds.iter().zip(&mut sheet.met).zip(&mut sheet.extents) {
            *met += s.norm() * normal.dot(wind).powi(2);
            for node in corners {
                let at = place(*node).dot(wind);
                let held = spec.fixed.get(*node as usize).is_some_and(|fixed| fixed.contains(&true));
                let counted = if held { 2 } else { 1 };
                extents.iter_mut().take(counted).for_each(|[low, high]| (*low, *high) = (low.min(at), high.max(at)));
            }
        }
    }
    let share = |sheet: &Sheet| sheet.met.iter().fold(0.0, |most: f64, met| most.max(met / sheet.area));
    let spans = |[[low, high], [first, last]]: &[[f64; 2]; 2]| last - first >= HELD * (high - low);
    let is_roof = |sheet: &&Sheet| {
        !winds.is_empty() && (IN_PLANE..ALONG).contains(&share(sheet)) && sheet.extents.iter().all(spans)
    };
    let roofs: Vec<&Sheet> = found.values().filter(is_roof).collect();
    Some(RoofInStream {
        first: roofs.iter().flat_map(|sheet| &sheet.triangles).copied().min()?,
        triangles: roofs.iter().map(|sheet| sheet.triangles.len()).sum(),
        share: roofs.iter().map(|sheet| share(sheet)).fold(0.0, f64::max),
    })
}

impl fmt::Display for RoofInStream {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let RoofInStream { first, triangles, share } = self;
        write!(
            f,
            "the wind passes along {triangles} triangles that supports hold on both sides (triangle {first} first): this law gives them \
             {} % of the dynamic pressure and no suction, where a roof has suctions of about all of it; give pressure coefficients \
             by zone, \"law\": {{\"surface_pressure\": {{group: cp}}}}",
            figures(100.0 * share, 2)
        )
    }
}

impl From<RoofInStream> for Warning {
    fn from(found: RoofInStream) -> Self {
        Warning::new(WarningCode::NoSuction, found.to_string())
    }
}
