//! The cloth of a case as another model: membranes as a net of springs, and a net that stands for a sheet as membranes.
//!
//! A sheet gives an edge of length l the stiffness
//! ```text
//! k = E t A/l^2
//! ```
//! with the sum A of the areas of the sheet's triangles there (Van Gelder 1998). Such a net has a Poisson's ratio of
//! about 1/3, whatever the sheet has. All other springs stay: tapes and lines are bars in both models.

use super::schema::ClothModel;
use super::spec::SystemSpec;
use super::{Case, Problem, lower::geometry::Geometry};
use crate::format_number::first_few;
use crate::model::spec::{DashpotKind, DashpotSpec, MembraneSpec, NetworkSpec, SheetSpec, Slack, SpringGroup};

/// [-] Poisson's ratio that a regular net of equal springs has.
const OF_NETS: f64 = 1.0 / 3.0;
/// [-] Difference below which two numbers from the same rule are equal.
const SAME: f64 = 1e-9;

/// Why cloth has no other model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ClothModelError {
    /// No membranes, and no springs that stand for a sheet.
    #[error(
        "this case has no cloth of a known modulus: give membranes, or springs with \"membrane\": {{\"modulus\": ..., \"thickness\": ...}}"
    )]
    NoSheet,
    /// A membrane that is not isotropic.
    #[error(
        "a net of springs is isotropic, but a membrane has the moduli {along} and {across} Pa and the shear modulus {shear} Pa; give it one modulus"
    )]
    Orthotropic {
        /// [Pa] E1
        along: f64,
        /// [Pa] E2
        across: f64,
        /// [Pa] G12
        shear: f64,
    },
    /// Sides of triangles that are not among the edges of the mesh.
    #[error("not all sides of the triangles {} are edges of the mesh, so they cannot carry springs", first_few(.0))]
    Sides(Vec<u32>),
    /// Triangles of which some sides have springs of a sheet, and others have none, or those of another sheet.
    #[error(
        "triangles {} have springs of a sheet on some sides, and on the others those of another sheet, or none: membranes need one sheet on all",
        first_few(.0)
    )]
    Mixed(Vec<u32>),
    /// Triangles with both models.
    #[error("triangles {} are membranes and have springs of a sheet too", first_few(.0))]
    Both(Vec<u32>),
    /// Something that springs can do and membranes cannot.
    #[error("springs of a sheet have {what}, which a membrane cannot have{}{hint}", if hint.is_empty() { "" } else { "; " })]
    OnlySprings {
        /// what it is
        what: &'static str,
        /// what to do
        hint: &'static str,
    },
}

/// What a group of springs stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sheet {
    of: SheetSpec,
    wrinkling: bool,
    /// [s]
    damping_time: f64,
}

impl Case {
    /// The data of a run, with all cloth as one model. Cloth that has this model stays as it is.
    ///
    /// # Errors
    /// A case without cloth of a known modulus, or cloth that the model cannot stand for.
    pub fn as_model(&self, model: ClothModel) -> Result<Problem, ClothModelError> {
        let mut problem = self.problem.clone();
        let (SystemSpec::Network(spec), Some(geometry)) = (&mut problem.system, &self.geometry) else {
            return Err(ClothModelError::NoSheet);
        };
        if !has_sheets(spec) {
            return Err(ClothModelError::NoSheet);
        }
        match model {
            ClothModel::Net => as_net(spec, geometry)?,
            ClothModel::Membrane => as_membranes(spec, geometry)?,
        }
        Ok(problem)
    }

    /// Whether masses are scaled.
    pub fn has_scaled_masses(&self) -> bool {
        matches!(&self.problem.system, SystemSpec::Network(spec) if spec.mass_scaling.is_some())
    }

    /// Whether the case has cloth of a known modulus, which can be both models.
    pub fn has_sheets(&self) -> bool {
        matches!(&self.problem.system, SystemSpec::Network(spec) if has_sheets(spec))
    }
}

fn has_sheets(spec: &NetworkSpec) -> bool {
    !spec.membranes.is_empty() || spec.springs.iter().any(|group| group.sheet.is_some())
}

fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME * a.abs()
}

/// Puts springs on the edges of all membranes in place of these.
fn as_net(spec: &mut NetworkSpec, geometry: &Geometry) -> Result<(), ClothModelError> {
    for sheet in std::mem::take(&mut spec.membranes) {
        let [along, across] = sheet.modulus;
        if along != across || !same(sheet.shear, along / (2.0 * (1.0 + sheet.poisson))) {
            return Err(ClothModelError::Orthotropic { along, across, shear: sheet.shear });
        }
        let mut sides: Vec<Option<u32>> = vec![None; geometry.mesh.triangles.len()];
        sheet.triangles.iter().for_each(|&t| sides[t as usize] = Some(0));
        let mut group = SpringGroup {
            slack: if sheet.wrinkling { Slack::TensionOnly } else { Slack::None },
            sheet: Some(SheetSpec { modulus: along, thickness: sheet.thickness }),
            ..SpringGroup::default()
        };
        let mut stiffness = Vec::new();
        for edge in 0..geometry.length.len() {
            let k = geometry.net_stiffness(along * sheet.thickness, edge, |t| sides[t as usize].is_some());
            if k > 0.0 {
                group.edges.push(edge as u32);
                stiffness.push(k);
                group.rest_length.extend(geometry.mesh.cut_length(edge as u32));
                let triangles = geometry.topology.edge_triangles(edge);
                triangles.iter().for_each(|&t| sides[t as usize] = sides[t as usize].map(|sides| sides + 1));
            }
        }
        let few: Vec<u32> = sheet.triangles.iter().copied().filter(|&t| sides[t as usize] != Some(3)).collect();
        if !few.is_empty() {
            return Err(ClothModelError::Sides(few));
        }
        group.stiffness = stiffness.into();
        group.dashpot = (sheet.damping_time > 0.0).then(|| DashpotSpec {
            kind: DashpotKind::Axial,
            coefficient: group.stiffness.map(|k| k * sheet.damping_time),
            from_step: false,
        });
        spec.springs.push(group);
    }
    Ok(())
}

/// Makes the triangles membranes whose sides have springs of a sheet, and takes these springs away.
fn as_membranes(spec: &mut NetworkSpec, geometry: &Geometry) -> Result<(), ClothModelError> {
    let edges = geometry.mesh.edges.len();
    let (mut of_edge, mut carries) = (vec![None::<Sheet>; edges], vec![false; edges]);
    for group in &spec.springs {
        let sheet = group.sheet.map(|sheet| of_group(group, sheet, geometry)).transpose()?;
        for &edge in &group.edges {
            carries[edge as usize] = true;
            of_edge[edge as usize] = sheet.or(of_edge[edge as usize]);
        }
    }
    let mut sides: Vec<Vec<usize>> = vec![Vec::new(); geometry.mesh.triangles.len()];
    for edge in 0..edges {
        geometry.topology.edge_triangles(edge).iter().for_each(|&t| sides[t as usize].push(edge));
    }
    let mut is_membrane = vec![false; sides.len()];
    spec.membranes.iter().flat_map(|sheet| &sheet.triangles).for_each(|&t| is_membrane[t as usize] = true);
    let (mut mixed, mut both) = (Vec::new(), Vec::new());
    let mut made: Vec<(Sheet, Vec<u32>)> = Vec::new();
    for (triangle, sides) in (0..).zip(&sides) {
        let Some(sheet) = sides.iter().find_map(|&edge| of_edge[edge]) else { continue };
        // A tape in place of the sheet's spring stays a bar.
        let whole = sides.iter().all(|&edge| of_edge[edge].map_or(carries[edge], |other| other == sheet));
        if !whole || sides.len() != 3 {
            mixed.push(triangle);
        } else if is_membrane[triangle as usize] {
            both.push(triangle);
        } else {
            match made.iter_mut().find(|(known, _)| *known == sheet) {
                Some((_, triangles)) => triangles.push(triangle),
                None => made.push((sheet, vec![triangle])),
            }
        }
    }
    if !mixed.is_empty() {
        return Err(ClothModelError::Mixed(mixed));
    }
    if !both.is_empty() {
        return Err(ClothModelError::Both(both));
    }
    spec.membranes.extend(made.into_iter().map(|(sheet, triangles)| sheet.of_triangles(triangles)));
    spec.springs.retain(|group| group.sheet.is_none());
    Ok(())
}

impl Sheet {
    fn of_triangles(self, triangles: Vec<u32>) -> MembraneSpec {
        let Sheet { of: SheetSpec { modulus, thickness }, wrinkling, damping_time } = self;
        let shear = modulus / (2.0 * (1.0 + OF_NETS));
        let (modulus, poisson) = ([modulus; 2], OF_NETS);
        let (warp, strength) = (None, None);
        MembraneSpec { triangles, thickness, modulus, poisson, shear, warp, wrinkling, damping_time, strength }
    }
}

/// A group of springs as a sheet, if a membrane can do what it does.
fn of_group(group: &SpringGroup, of: SheetSpec, geometry: &Geometry) -> Result<Sheet, ClothModelError> {
    let only = |what, hint| Err(ClothModelError::OnlySprings { what, hint });
    let as_meshed =
        |(&edge, &rest): (&u32, &f64)| geometry.mesh.cut_length(edge).is_some_and(|length| same(length, rest));
    if !group.edges.iter().zip(&group.rest_length).all(as_meshed) {
        return only("rest lengths other than those of the mesh", "stretch the cloth by its supports or loads");
    }
    if group.rest_scale.is_some() {
        return only("rest lengths that change over time", "");
    }
    if group.cut.is_some() {
        return only("a time when they are cut", "");
    }
    if group.cut_by.is_some() || !group.breaks.is_empty() {
        return only("an event that cuts or breaks them", "");
    }
    let wrinkling = match group.slack {
        Slack::None => false,
        Slack::TensionOnly => true,
        _ => return only("a slack other than tension-only", ""),
    };
    let damping_time = match &group.dashpot {
        None => 0.0,
        Some(DashpotSpec { kind: DashpotKind::Axial, coefficient, from_step: false }) => {
            let springs = group.edges.len();
            let times = || coefficient.of(springs).zip(group.stiffness.of(springs)).map(|(c, k)| c / k);
            match times().next() {
                Some(first) if times().all(|time| same(first, time)) => first,
                _ => return only("dashpots of different times", "give them as \"axial\": {\"time\": ...}"),
            }
        }
        Some(_) => {
            return only("dashpots that are relative or follow the step", "give them as \"axial\": {\"time\": ...}");
        }
    };
    Ok(Sheet { of, wrinkling, damping_time })
}
