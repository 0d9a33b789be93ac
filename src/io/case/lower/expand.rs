//! Materials and defaults by type, written out as rules, so that the rest of the lowering knows numbers alone.
//!
//! What a case gives itself stays as it is. Rules that a parachute's materials bring come after those of the case, so
//! that these keep their numbers.

mod air;
mod rig;

use std::borrow::Cow;

use super::geometry::Geometry;
use crate::case::diagnostics::Faults;
use crate::case::materials::{MaterialTable, rigidity};
use crate::case::pointer::Pointer;
use crate::case::schema::{
    ClothMaterial, Dashpot, DashpotRule, EdgeSelection, ElasticLawRule, LineMaterial, Mass, Material, Membrane,
    MembraneRule, Modulus, Network, SlackRule, SpringRule,
};
use crate::mesh::source::MeshSource;

/// A network whose materials are written out.
#[derive(Debug)]
pub(super) struct Expanded {
    pub network: Network,
    /// what was taken for keys that the case leaves out, in words
    pub taken: Vec<String>,
}

/// The source of the mesh with all its sizes, and without materials. One with faults stays as it is, to be refused.
pub(super) fn source(mesh: &MeshSource) -> Cow<'_, MeshSource> {
    let MeshSource::Parachute(p) = mesh else { return Cow::Borrowed(mesh) };
    let mut sound = true;
    p.check("", &mut |_, _, _, _| sound = false);
    match p.resolved() {
        Ok(whole) if sound => Cow::Owned(MeshSource::Parachute(Box::new(whole.without_materials()))),
        _ => Cow::Borrowed(mesh),
    }
}

/// The network with its materials and defaults written out; `None` if it has none. `source` is that of its mesh.
pub(super) fn network(
    at: &Pointer,
    network: &Network,
    source: &MeshSource,
    geometry: Option<&Geometry>,
    table: MaterialTable<'_>,
    faults: &mut Faults<'_>,
) -> Option<Expanded> {
    let parachute = match &network.mesh {
        MeshSource::Parachute(parachute) => Some(parachute),
        _ => None,
    };
    let named = network.springs.iter().any(|rule| rule.material.is_some())
        || network.membranes.iter().any(|rule| rule.material.is_some());
    if !named && parachute.is_none() {
        return None;
    }
    let mut whole = network.clone();
    let (mut cloths, mut taken) = (Cloths::default(), Vec::new());
    for (i, rule) in whole.springs.iter_mut().enumerate() {
        let at = at.key("springs").index(i).key("material");
        // Edges without springs take no material: that is refused where springs are made.
        let Some(name) = (if rule.loads_only { None } else { rule.material.take() }) else { continue };
        match table.find(&at, &name, faults) {
            Some(Material::Line(line)) => fill_line(rule, line),
            Some(Material::Cloth(cloth)) => {
                fill_cloth(rule, cloth);
                cloths.add(&name, cloth);
            }
            None => {}
        }
    }
    for (i, rule) in whole.membranes.iter_mut().enumerate() {
        let at = at.key("membranes").index(i).key("material");
        let Some(name) = rule.material.take() else { continue };
        if let Some(cloth) = table.cloth(&at, &name, faults) {
            fill_membrane(rule, cloth);
            cloths.add(&name, cloth);
        }
    }
    let before = faults.count();
    if let (Some(parachute), Some(geometry)) = (parachute, geometry) {
        whole.mesh = source.clone();
        rig::resolved(parachute, source, &mut taken);
        let parts = rig::Parts { parachute, geometry, table };
        rig::add(at, &parts, &mut whole, &mut cloths, &mut taken, faults);
        // A material that is not known is told once.
        if faults.count() == before {
            air::add(&at.key("aero"), &parts, &mut whole, &mut taken, faults);
        }
    }
    if let Some(parachute) = parachute {
        air::fill_canopies(&at.key("aero"), parachute.kind, &mut whole, &mut taken, faults);
    }
    cloths.give_mass(&at.key("mass"), &mut whole.mass, faults);
    (whole != *network).then_some(Expanded { network: whole, taken })
}

/// The cloths of a case, by name with their masses per area [kg/m^2].
#[derive(Debug, Default)]
struct Cloths(Vec<(String, f64)>);

impl Cloths {
    fn add(&mut self, name: &str, cloth: &ClothMaterial) {
        self.0.push((name.to_owned(), cloth.areal_density));
    }

    fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Gives the mass per area, which is one for the whole mesh, unless the case does.
    fn give_mass(self, at: &Pointer, mass: &mut Option<Mass>, faults: &mut Faults<'_>) {
        if mass.as_ref().is_some_and(|mass| mass.areal_density.is_some()) {
            return;
        }
        let Some((first, density)) = self.0.first() else { return };
        if let Some((other, _)) = self.0.iter().find(|(_, other)| other != density) {
            let value = format!("cloths of different mass per area: \"{first}\" and \"{other}\"");
            let hint = "a mesh has one mass per area: give areal_density, or masses of nodes".to_owned();
            return faults.add_value(&at.key("areal_density"), value, "cloths of one mass per area", Some(hint));
        }
        mass.get_or_insert_with(Mass::default).areal_density = Some(*density);
    }
}

/// Whether a rule has a stiffness of its own.
fn is_stiff(rule: &SpringRule) -> bool {
    let table = matches!(rule.law, Some(ElasticLawRule::Table(_)));
    table || rule.stiffness.is_some() || rule.axial_rigidity.is_some() || rule.membrane.is_some()
}

/// Gives a rule what it leaves out of a material's slack and damping.
fn fill_motion(rule: &mut SpringRule, damping_time: Option<f64>) {
    rule.slack.get_or_insert(SlackRule::TensionOnly);
    if let Some(tau) = damping_time.filter(|tau| *tau > 0.0) {
        rule.dashpot.get_or_insert(Dashpot::Axial(DashpotRule::Time(tau)));
    }
}

/// Gives a rule what it leaves out of a line.
fn fill_line(rule: &mut SpringRule, line: &LineMaterial) {
    if !is_stiff(rule) {
        rule.axial_rigidity = rigidity(line);
    }
    rule.linear_density.get_or_insert(line.linear_density);
    rule.strength = rule.strength.or(line.strength);
    fill_motion(rule, line.damping_time);
}

/// Gives a rule what it leaves out of a cloth.
fn fill_cloth(rule: &mut SpringRule, cloth: &ClothMaterial) {
    if !is_stiff(rule) {
        let ClothMaterial { modulus, thickness, .. } = *cloth;
        rule.membrane = Some(Membrane { modulus, thickness });
    }
    fill_motion(rule, cloth.damping_time);
}

/// Gives a membrane what it leaves out of a cloth.
fn fill_membrane(rule: &mut MembraneRule, cloth: &ClothMaterial) {
    rule.thickness.get_or_insert(cloth.thickness);
    rule.modulus.get_or_insert(Modulus::Isotropic(cloth.modulus));
    rule.poisson = rule.poisson.or(cloth.poisson);
    rule.damping_time = rule.damping_time.or(cloth.damping_time);
    rule.strength = rule.strength.or(cloth.strength);
}

/// A rule for a group, without values.
fn rule_of(group: String) -> SpringRule {
    SpringRule {
        on: EdgeSelection::Group(group),
        material: None,
        stiffness: None,
        axial_rigidity: None,
        membrane: None,
        loads_only: false,
        law: None,
        rest_length: None,
        rest_scale: None,
        linear_density: None,
        cut: None,
        when: None,
        strength: None,
        breaks: false,
        slack: None,
        dashpot: None,
    }
}
