//! Air loads that cannot act as expected.

use std::fmt;

use crate::mesh::unit_vector::unit_vector;
use nalgebra::Vector3;

use crate::format_number::figures;
use crate::mesh::components::components;
use crate::model::spec::{CanopyAir, NetworkSpec, PressureKind};
use crate::warning::{Warning, WarningCode};

/// [-] Sine of the angle between wind and triangle below which the wind is in its plane: a pressure proportional to the
/// square of the normal velocity is then below 1e-8 of the full one.
const IN_PLANE: f64 = 1e-4;

/// [-] Share of a wind velocity outside the directions of earlier rows of its table from which on it counts as another
/// direction.
const ANOTHER: f64 = 1e-6;

/// Triangles on which the air cannot act, because the wind relative to them lies in their plane.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WindInPlane {
    /// the first triangle
    pub first: u32,
    /// [-] their number
    pub triangles: usize,
    /// [-] number of all triangles
    pub of: usize,
}

/// Finds sheets with the wind in the plane of all their triangles, on the mesh as given and at the start, for all rows
/// of the wind table. A sheet starts to move if one triangle can push it out of the plane.
pub fn wind_in_plane(spec: &NetworkSpec) -> Option<WindInPlane> {
    let winds = directions(spec.air.as_ref()?.wind.value.iter().map(|w| Vector3::from(*w)));
    let vector = |list: &[[f64; 3]], node: u32| list.get(node as usize).map_or(Vector3::zeros(), |v| Vector3::from(*v));
    let in_plane = |corners: &[u32; 3]| {
        let v = corners.iter().map(|node| vector(&spec.velocity, *node)).sum::<Vector3<f64>>() / 3.0;
        let x = corners.map(|node| vector(&spec.mesh.nodes, node));
        let displaced = corners.map(|node| vector(&spec.mesh.nodes, node) + vector(&spec.displacement, node));
        let mut blown = winds.iter().map(|wind| *wind - v).filter(|u| *u != Vector3::zeros()).peekable();
        blown.peek().is_some() && blown.all(|u| along(x, u) && along(displaced, u))
    };
    let sheets = Sheets::new(spec);
    let across = spec.mesh.triangles.iter().zip(0_u32..).filter(|(corners, _)| !in_plane(corners));
    let (first, triangles) = sheets.without(across.map(|(_, triangle)| triangle), [].into_iter())?;
    Some(WindInPlane { first, triangles, of: spec.mesh.triangles.len() })
}

/// Connected components of triangles that share nodes.
pub(super) struct Sheets<'a> {
    triangles: &'a [[u32; 3]],
    /// by node: the smallest node of its sheet
    of_node: Vec<u32>,
}

impl<'a> Sheets<'a> {
    pub(super) fn new(spec: &'a NetworkSpec) -> Self {
        let triangles = &spec.mesh.triangles[..];
        let pairs = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [a, c]]);
        Sheets { triangles, of_node: components(spec.mesh.nodes.len(), pairs) }
    }

    /// The smallest node of the sheet of a triangle.
    pub(super) fn of(&self, triangle: u32) -> Option<u32> {
        let [node, ..] = self.triangles.get(triangle as usize)?;
        self.of_node.get(*node as usize).copied()
    }

    /// Sheets without any of the given triangles and nodes: the first triangle, and their number of triangles.
    fn without(&self, triangles: impl Iterator<Item = u32>, nodes: impl Iterator<Item = u32>) -> Option<(u32, usize)> {
        let by_node = nodes.filter_map(|node| self.of_node.get(node as usize).copied());
        let mut out = vec![false; self.of_node.len()];
        triangles.filter_map(|triangle| self.of(triangle)).chain(by_node).for_each(|sheet| out[sheet as usize] = true);
        let mut left =
            (0..self.triangles.len() as u32).filter(|t| self.of(*t).is_some_and(|sheet| !out[sheet as usize]));
        let first = left.next()?;
        Some((first, 1 + left.count()))
    }
}

/// Whether a wind lies in the plane of a triangle.
fn along([a, b, c]: [Vector3<f64>; 3], wind: Vector3<f64>) -> bool {
    let normal = unit_vector((b - a).cross(&(c - a))).unwrap_or_default();
    normal.dot(&wind).abs() <= IN_PLANE * wind.norm()
}

/// Winds whose directions span all directions of the table: one to three, or a single zero for calm air.
pub(super) fn directions(winds: impl Iterator<Item = Vector3<f64>>) -> Vec<Vector3<f64>> {
    let mut kept: Vec<Vector3<f64>> = Vec::new();
    let mut basis: Vec<Vector3<f64>> = Vec::new();
    for wind in winds {
        let rest = basis.iter().fold(wind, |rest, e| rest - e.dot(&rest) * *e);
        if rest.norm() > ANOTHER * wind.norm() && basis.len() < 3 {
            basis.push(unit_vector(rest).unwrap_or_default());
            kept.push(wind);
        }
    }
    if kept.is_empty() { vec![Vector3::zeros()] } else { kept }
}

impl fmt::Display for WindInPlane {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let WindInPlane { first, triangles, of } = self;
        let which = if triangles == of { format!("all {of}") } else { format!("{triangles} of {of}") };
        write!(
            f,
            "the wind lies in the plane of {which} triangles (triangle {first} first), so the air exerts no force on them: turn the wind or the mesh, or give a small initial displacement across the wind; a roof needs pressure coefficients by zone, surface_pressure"
        )
    }
}

impl From<WindInPlane> for Warning {
    fn from(found: WindInPlane) -> Self {
        Warning::new(WarningCode::WindInPlane, found.to_string())
    }
}

/// A sheet in the air without a support.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FreeSheets {
    /// its first triangle
    pub first: u32,
    /// [-] number of triangles of all such sheets
    pub triangles: usize,
}

/// Finds sheets without a supported node: they hang on lines or are free. A pressure along the normals of one of their
/// triangles keeps a sheet open.
pub fn closing(spec: &NetworkSpec) -> Option<FreeSheets> {
    spec.air.as_ref()?;
    let inside = spec.pressures.iter().filter(|load| load.kind == PressureKind::Follower);
    let held = spec.fixed.iter().zip(0_u32..).filter(|(fixed, _)| fixed.contains(&true));
    let inside = inside.flat_map(|load| load.triangles.iter().copied());
    let (first, triangles) = Sheets::new(spec).without(inside, held.map(|(_, node)| node))?;
    Some(FreeSheets { first, triangles })
}

impl fmt::Display for FreeSheets {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "this air law gives no inner pressure: a canopy closes unless it is held open, and no support holds the cloth of {} triangles (triangle {} first); hold its skirt, or use aero.canopy, which knows the pressure inside a canopy that hangs over its lines",
            self.triangles, self.first
        )
    }
}

impl From<FreeSheets> for Warning {
    fn from(found: FreeSheets) -> Self {
        Warning::new(WarningCode::ClosingCanopy, found.to_string())
    }
}

/// Canopies whose pressure is that of a cavity.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cavities {
    /// [-] their number
    pub canopies: usize,
}

/// Finds canopies with a cavity.
pub fn cavities(spec: &NetworkSpec) -> Option<Cavities> {
    let canopies = spec.canopies.iter().filter(|canopy| matches!(canopy.air, CanopyAir::Cavity(_))).count();
    (canopies > 0).then_some(Cavities { canopies })
}

impl fmt::Display for Cavities {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let which = match self.canopies {
            1 => "the pressure in the canopy is".to_owned(),
            several => format!("the pressure in {several} canopies is"),
        };
        write!(
            f,
            "{which} that of a cavity, which is experimental: shape, filling time and speed of fall are of the right size, \
             opening loads are several times too large; take \"filling\" or \"schedule\" for opening loads"
        )
    }
}

impl From<Cavities> for Warning {
    fn from(found: Cavities) -> Self {
        Warning::new(WarningCode::ExperimentalModel, found.to_string())
    }
}

/// [-] Pressure over dynamic pressure above which a free stream cannot provide it: blunt bodies reach 1.4.
const MOST: f64 = 1.5;

/// A pressure beyond that of the flow.
#[derive(Clone, Debug, PartialEq)]
pub struct ExcessPressure {
    /// [Pa] pressure on cloth across the wind
    pub pressure: f64,
    /// [m/s] at this speed
    pub speed: f64,
    /// [-] pressure over dynamic pressure
    pub factor: f64,
    /// whether the law is a pressure coefficient already
    pub coefficient: bool,
}

/// A pressure law in a free stream.
#[derive(Clone, Copy, Debug)]
pub struct FreeStream {
    /// [Pa s/m] viscous coefficient
    pub linear: f64,
    /// [Pa s^2/m^2] inertial coefficient
    pub quadratic: f64,
    /// [kg/m^3] of the air
    pub density: f64,
    /// [m/s] fastest wind
    pub speed: f64,
    /// whether the law is a pressure coefficient
    pub coefficient: bool,
}

/// Compares the pressure jump dp = a V + b V^2 of a law with the dynamic pressure rho V^2/2 of the stream.
pub fn excess_pressure(stream: FreeStream) -> Option<ExcessPressure> {
    let FreeStream { linear, quadratic, density, speed, coefficient } = stream;
    let pressure = speed * (linear + quadratic * speed);
    let factor = pressure / (0.5 * density * speed * speed);
    (factor.is_finite() && factor > MOST).then_some(ExcessPressure { pressure, speed, factor, coefficient })
}

impl fmt::Display for ExcessPressure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [pressure, speed, factor] = [self.pressure, self.speed, self.factor].map(|x| figures(x, 3));
        let cure = if self.coefficient {
            "take a cp of at most 1.5"
        } else {
            "take \"pressure_coefficient\", or keep this law for cloth that is held across a duct, where the air must pass"
        };
        write!(
            f,
            "the law has {pressure} Pa at {speed} m/s, {factor} times the dynamic pressure; a free stream flows around such cloth and \
             exerts no more than about {MOST} times: {cure}"
        )
    }
}
