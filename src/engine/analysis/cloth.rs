//! Cloth that is strained more than cloth bears.

use crate::format_number::figures;
use crate::mesh::box_tree::Bounds;
use crate::mesh::{NamedParts, with_groups};
use crate::model::forces::Role;
use crate::model::observables::MembranePicture;
use crate::model::state::StateRef;
use crate::model::system::TermInfo;
use crate::scene::Scene;
use std::collections::HashSet;

/// [-] Strain above which cloth is no cloth any more: fabrics of nylon and polyester tear at about half of it.
pub const TORN: f64 = 0.5;

/// The most strained part of cloth in a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrainedCloth {
    /// [s] time of the state
    pub t: f64,
    /// [-] elongation over length at rest; of a membrane in the direction in which it is largest
    pub strain: f64,
    /// spring or triangle, user's number
    pub place: ClothPlace,
}

/// What is strained.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClothPlace {
    /// a spring on the side of a triangle
    Spring(u32),
    /// a membrane
    Triangle(u32),
}

impl StrainedCloth {
    /// The most strained spring on a side of a triangle, or membrane, in a state; `None` where nothing is strained by
    /// more than [`TORN`]. Allocates only there.
    pub fn of(scene: &dyn Scene, at: StateRef<'_>) -> Option<Self> {
        if scene.triangles().is_empty() || scene.max_strain(at) <= TORN {
            return None;
        }
        let (mut tension, mut strain) = (vec![0.0; scene.edges().len()], vec![0.0; scene.edges().len()]);
        scene.edge_tension(at, &mut tension, &mut strain);
        let key = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
        let sides = |&[a, b, c]: &[u32; 3]| [key([a, b]), key([b, c]), key([c, a])];
        let cloth: HashSet<[u32; 2]> = scene.triangles().iter().flat_map(sides).collect();
        let springs = (0_u32..).zip(scene.edges()).zip(&strain).filter(|((_, edge), _)| cloth.contains(&key(**edge)));
        let springs = springs.map(|((edge, _), strain)| (ClothPlace::Spring(edge), *strain));
        let mut membranes = vec![MembranePicture::default(); scene.triangles().len()];
        scene.triangle_membranes(at, &mut membranes);
        // Stretch^2 = 1 + 2 E of the Green strain E.
        let membranes =
            (0_u32..).zip(&membranes).map(|(triangle, of)| (ClothPlace::Triangle(triangle), of.elongation()));
        let strained = springs.chain(membranes).filter(|(_, strain)| *strain > TORN);
        let (place, strain) = strained.max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(StrainedCloth { t: at.t, strain, place })
    }

    /// In words, as a cause; `parts` are those of the scene.
    pub fn text(&self, parts: NamedParts<'_>) -> String {
        let place = match self.place {
            ClothPlace::Spring(spring) => with_groups("spring", spring, &parts.of_edge(spring)),
            ClothPlace::Triangle(triangle) => with_groups("triangle", triangle, &parts.of_triangle(triangle)),
        };
        format!(
            "the cloth is too soft for its loads: at t = {} s it is strained by {} % ({place})",
            figures(self.t, 4),
            figures(100.0 * self.strain, 3)
        )
    }
}

/// Why a state has no successor, as far as cloth is the cause: it is strained by more than [`TORN`], or its pressures
/// would strain it so.
pub fn too_soft(scene: &dyn Scene, at: StateRef<'_>) -> Option<String> {
    let strained = StrainedCloth::of(scene, at).map(|strained| strained.text(scene.parts()));
    strained.or_else(|| {
        let strain = strain_by_pressure(scene, at).filter(|strain| *strain > TORN && strain.is_finite())?;
        Some(format!(
            "the cloth is too soft for its loads: pressure times radius would strain it by about {} %",
            figures(100.0 * strain, 2)
        ))
    })
}

/// [-] About how much loads on triangles strain cloth. A net with a strain r in all directions has the tension
/// r sum k l0^2/(2 A) per width, a sphere of radius R under a pressure p needs p R/2, and forces at its nodes add up to
/// p A: so r = R sum |f|/sum k l0^2. R is half the extent of the cloth at the start, the least radius that a flat one
/// can have. `None` without cloth or such loads.
fn strain_by_pressure(scene: &dyn Scene, at: StateRef<'_>) -> Option<f64> {
    let on_cloth =
        |(number, term): (usize, &TermInfo)| (term.on_triangles && term.role == Role::External).then_some(number);
    let (mut total, mut one) = (vec![0.0; scene.n_dof()], vec![0.0; scene.n_dof()]);
    for term in scene.terms().iter().enumerate().filter_map(on_cloth) {
        one.fill(0.0);
        scene.term_alone(term, at, &mut one)?;
        total.iter_mut().zip(&one).for_each(|(sum, f)| *sum += f);
    }
    let load: f64 = total.chunks(3).map(|f| f.iter().map(|f| f * f).sum::<f64>().sqrt()).sum();
    let reference = scene.reference();
    let mut cloth = vec![false; reference.len()];
    scene.triangles().iter().flatten().for_each(|&node| cloth[node as usize] = true);
    let corners = reference.iter().zip(&cloth).filter(|(_, cloth)| **cloth).map(|(x, _)| x);
    let radius = 0.5 * Bounds::of(corners).extent();
    let square =
        |a: u32, b: u32| (0..3).map(|i| (reference[a as usize][i] - reference[b as usize][i]).powi(2)).sum::<f64>();
    let sides = || scene.triangles().iter().flat_map(|&[a, b, c]| [square(a, b), square(b, c), square(c, a)]);
    // Every spring is at two nodes, and every node has three degrees of freedom.
    let of_cloth =
        scene.nodal_stiffness().into_iter().enumerate().filter(|(dof, _)| cloth[scene.name_of(*dof).0 as usize]);
    let stiffness = of_cloth.map(|(_, k)| k).sum::<f64>() / 6.0;
    let work = stiffness * sides().sum::<f64>() / sides().count() as f64;
    (load > 0.0 && work > 0.0).then(|| radius * load / work)
}
