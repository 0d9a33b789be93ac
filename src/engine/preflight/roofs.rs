//! Roofs in the wind: a law of a free stream, which has no suction; coefficients by zone without a wind, or on the
//! wrong face.

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

/// [-] Share of the mean square of the sine that either face has at least, from which on the wind meets both: it would
/// have to blow through a dome.
const BOTH: f64 = 0.2;

/// Cloth that is held like a roof in a wind that passes along it, or over it as over a dome.
#[derive(Clone, Debug, PartialEq)]
pub struct RoofInStream {
    /// its first triangle
    pub first: u32,
    /// [-] number of triangles of all such sheets
    pub triangles: usize,
    /// [-] pressure on them over the dynamic pressure, at a pressure coefficient of 1
    pub share: f64,
    /// whether the wind meets the one face of some of them and the other face of the rest
    pub domed: bool,
}

/// A sheet as the winds meet it.
#[derive(Clone, Default)]
struct Sheet {
    triangles: Vec<u32>,
    /// [m^2]
    area: f64,
    /// \[m^2\] by wind: sums of the areas times squares of sines, where it meets the inner and the outer face
    met: Vec<[f64; 2]>,
    /// \[m\] by wind: least and largest place along it, of all nodes and of those with a support
    extents: Vec<[[f64; 2]; 2]>,
}

/// Finds sheets whose supports reach over half of them along all winds of the table, and along which these pass, or of
/// which they meet both faces.
pub fn roofs(spec: &NetworkSpec) -> Option<RoofInStream> {
    let winds: Vec<Vector3<f64>> = directions(spec.air.as_ref()?.wind.value.iter().map(|w| Vector3::from(*w)))
        .into_iter()
        .filter_map(unit_vector)
        .collect();
    let displaced = |node: u32| spec.displacement.get(node as usize).map_or(Vector3::zeros(), |u| Vector3::from(*u));
    let place = |node: u32| spec.mesh.point(node) + displaced(node);
    let sheets = Sheets::new(spec);
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    let empty = Sheet { met: vec![[0.0; 2]; winds.len()], extents: vec![[none; 2]; winds.len()], ..Sheet::default() };
    let mut found: BTreeMap<u32, Sheet> = BTreeMap::new();
    for (corners, triangle) in spec.mesh.triangles.iter().zip(0_u32..) {
        let sheet = found.entry(sheets.of(triangle)?).or_insert_with(|| empty.clone());
        let [a, b, c] = corners.map(place);
        let s = 0.5 * (b - a).cross(&(c - a));
        let normal = unit_vector(s).unwrap_or_default();
        sheet.triangles.push(triangle);
        sheet.area += s.norm();
        for ((wind, met), extents) in winds.iter().zip(&mut sheet.met).zip(&mut sheet.extents) {
            let sine = normal.dot(wind);
            met[usize::from(sine < 0.0)] += s.norm() * sine.powi(2);
            for node in corners {
                let at = place(*node).dot(wind);
                let held = spec.fixed.get(*node as usize).is_some_and(|fixed| fixed.contains(&true));
                let counted = if held { 2 } else { 1 };
                extents.iter_mut().take(counted).for_each(|[low, high]| (*low, *high) = (low.min(at), high.max(at)));
            }
        }
    }
    let share = |sheet: &Sheet| sheet.met.iter().fold(0.0, |most: f64, [a, b]| most.max((a + b) / sheet.area));
    let spans = |[[low, high], [first, last]]: &[[f64; 2]; 2]| last - first >= HELD * (high - low);
    let domed = |sheet: &Sheet| sheet.met.iter().all(|[a, b]| a.min(*b) >= BOTH * (a + b));
    let is_roof = |sheet: &&Sheet| {
        let passed = (IN_PLANE..ALONG).contains(&share(sheet)) || share(sheet) >= ALONG && domed(sheet);
        !winds.is_empty() && passed && sheet.extents.iter().all(spans)
    };
    let roofs: Vec<&Sheet> = found.values().filter(is_roof).collect();
    Some(RoofInStream {
        first: roofs.iter().flat_map(|sheet| &sheet.triangles).copied().min()?,
        triangles: roofs.iter().map(|sheet| sheet.triangles.len()).sum(),
        share: roofs.iter().map(|sheet| share(sheet)).fold(0.0, f64::max),
        domed: roofs.iter().any(|sheet| share(sheet) >= ALONG),
    })
}

impl fmt::Display for RoofInStream {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let RoofInStream { first, triangles, share, domed } = self;
        let cure = "give pressure coefficients by zone, \"law\": {\"surface_pressure\": {group: cp}}";
        if *domed {
            return write!(
                f,
                "the wind goes over {triangles} triangles that supports hold on both sides (triangle {first} first), and meets their \
                 outer and their inner face: this law lets it blow through the cloth, presses the lee side outwards from inside, \
                 and has no suction on top, where domes have suctions of about the dynamic pressure; {cure}"
            );
        }
        write!(
            f,
            "the wind passes along {triangles} triangles that supports hold on both sides (triangle {first} first): this law gives them \
             {} % of the dynamic pressure and no suction, where a roof has suctions of about all of it; {cure}",
            figures(100.0 * share, 2)
        )
    }
}

impl From<RoofInStream> for Warning {
    fn from(found: RoofInStream) -> Self {
        Warning::new(WarningCode::NoSuction, found.to_string())
    }
}

/// Pressure coefficients on a surface around which no air moves.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CalmZones {
    /// \[-\] number of triangles with a coefficient
    pub triangles: usize,
}

/// Finds coefficients of a wind that is 0 at all times and heights.
pub fn calm_zones(spec: &NetworkSpec) -> Option<CalmZones> {
    let stream = spec.stream.as_ref()?;
    let profile = stream.profile.iter().flat_map(|profile| &profile.value);
    let still = stream.gusts.is_empty() && stream.wind.value.iter().chain(profile).all(|wind| *wind == [0.0; 3]);
    let triangles = spec.surface_pressures.iter().map(|zone| zone.triangles.len()).sum();
    (still && triangles > 0).then_some(CalmZones { triangles })
}

impl fmt::Display for CalmZones {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "there is no wind, so surface_pressure puts nothing on its {} triangles: p = cp q is 0; give \"aero\" a \"wind\"",
            self.triangles
        )
    }
}

impl From<CalmZones> for Warning {
    fn from(found: CalmZones) -> Self {
        Warning::new(WarningCode::NoWind, found.to_string())
    }
}

/// [-] Upward sum of area vectors over the area, from which on a sheet has an upper face.
const UPPER: f64 = 0.05;

/// [-] Volume over the power 3/2 of the area from which on a closed sheet has an inside; a sphere has 0.09.
const CLOSED: f64 = 1e-4;

/// Pressure coefficients on the inner or lower face of cloth.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InsideOut {
    /// the first triangle
    pub first: u32,
    /// \[-\] number of triangles of all such sheets
    pub triangles: usize,
    /// whether the sheet of the first triangle is closed
    pub closed: bool,
}

/// Finds sheets with coefficients whose right-hand normals look down, or, where they are closed, inwards. Sheets that
/// stand upright have neither.
pub fn inside_out(spec: &NetworkSpec) -> Option<InsideOut> {
    if spec.surface_pressures.is_empty() {
        return None;
    }
    let displaced = |node: u32| spec.displacement.get(node as usize).map_or(Vector3::zeros(), |u| Vector3::from(*u));
    let place = |node: u32| spec.mesh.point(node) + displaced(node);
    let sheets = Sheets::new(spec);
    // Of a sheet: its triangles, area, sum of area vectors, volume about its first corner.
    let mut found: BTreeMap<u32, (Vec<u32>, f64, Vector3<f64>, f64)> = BTreeMap::new();
    for &triangle in spec.surface_pressures.iter().flat_map(|zone| &zone.triangles) {
        let sheet = sheets.of(triangle)?;
        let [a, b, c] = spec.mesh.triangles.get(triangle as usize)?.map(&place);
        let s = 0.5 * (b - a).cross(&(c - a));
        let (list, area, sum, volume) = found.entry(sheet).or_default();
        list.push(triangle);
        *area += s.norm();
        *sum += s;
        *volume += s.dot(&(a - place(sheet))) / 3.0;
    }
    let wrong = |(_, area, sum, volume): &(Vec<u32>, f64, Vector3<f64>, f64)| {
        let closed = sum.norm() < UPPER * area && volume.abs() > CLOSED * area.powf(1.5);
        (if closed { *volume < 0.0 } else { sum.z < -UPPER * area }).then_some(closed)
    };
    let mut wrong: Vec<(u32, usize, bool)> = found
        .values()
        .filter_map(|sheet| Some((sheet.0.iter().copied().min()?, sheet.0.len(), wrong(sheet)?)))
        .collect();
    wrong.sort_unstable();
    let &(first, _, closed) = wrong.first()?;
    Some(InsideOut { first, triangles: wrong.iter().map(|(_, count, _)| count).sum(), closed })
}

impl fmt::Display for InsideOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let InsideOut { first, triangles, closed } = self;
        let (way, other) = if *closed { ("inwards", "out") } else { ("down", "up") };
        write!(
            f,
            "the outer faces of {triangles} triangles with surface_pressure look {way} (triangle {first} first): a positive cp pushes \
             onto the face that the right-hand normal looks out of; list the corners of these triangles the other way round, so that \
             normals look {other}, or change the signs"
        )
    }
}

impl From<InsideOut> for Warning {
    fn from(found: InsideOut) -> Self {
        Warning::new(WarningCode::InsideOut, found.to_string())
    }
}
