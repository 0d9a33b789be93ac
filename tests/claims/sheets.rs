//! Membranes in a state of constant strain, on a mesh without order: the patch test of finite elements (Irons &
//! Razzaque 1972). With x = F X the strain is E = (F^T F - 1)/2, the stress S = D E in the axes of the material, and
//! Cauchy's stress F S F^T/det F; inner nodes are in equilibrium. A rotation of the whole sheet strains nothing.

use crate::claim::Claim;
use crate::common::Random;
use crate::common::run::{Rest, as_given, at_rest, case_of};
use nalgebra::{Matrix2, Rotation3, Vector2, Vector3};
use serde_json::{Value, json};

/// Cells along a side; the sheet is 1 m long and wide.
const CELLS: usize = 6;
/// [m]
const THICKNESS: f64 = 2e-3;

/// A material, and the angle of its warp with the x axis [rad].
#[derive(Clone, Copy)]
struct Material {
    name: &'static str,
    modulus: [f64; 2],
    poisson: f64,
    shear: f64,
    warp: f64,
}

const ISOTROPIC: Material =
    Material { name: "isotropic", modulus: [3e6; 2], poisson: 0.3, shear: 3e6 / 2.6, warp: 0.0 };
const ORTHOTROPIC: Material =
    Material { name: "orthotropic", modulus: [5e6, 2e6], poisson: 0.4, shear: 4e5, warp: 0.6 };

impl Material {
    fn rule(&self) -> Value {
        let mut rule =
            json!({"on": "all", "thickness": THICKNESS, "modulus": self.modulus[0], "poisson": self.poisson});
        if self.modulus[0] != self.modulus[1] {
            rule["modulus"] = json!(self.modulus);
            rule["shear"] = json!(self.shear);
            rule["warp"] = json!([self.warp.cos(), self.warp.sin(), 0.0]);
        }
        rule
    }

    /// [Pa] Second Piola-Kirchhoff stress along x and y, and [J/m^2] the energy.
    fn stress(&self, e: Matrix2<f64>) -> (Matrix2<f64>, f64) {
        let turn = Matrix2::new(self.warp.cos(), -self.warp.sin(), self.warp.sin(), self.warp.cos());
        let (m, nu12) = (turn.transpose() * e * turn, self.poisson);
        let nu21 = nu12 * self.modulus[1] / self.modulus[0];
        let factor = 1.0 / (1.0 - nu12 * nu21);
        let s11 = factor * self.modulus[0] * (m[(0, 0)] + nu21 * m[(1, 1)]);
        let s22 = factor * self.modulus[1] * (m[(1, 1)] + nu12 * m[(0, 0)]);
        let s = Matrix2::new(s11, 2.0 * self.shear * m[(0, 1)], 2.0 * self.shear * m[(0, 1)], s22);
        (turn * s * turn.transpose(), 0.5 * THICKNESS * s.dot(&m))
    }
}

/// A square whose inner nodes are anywhere within a third of a cell.
struct Patch {
    nodes: Vec<[f64; 3]>,
    triangles: Vec<[usize; 3]>,
    rim: Vec<usize>,
}

fn patch() -> Patch {
    let (mut random, side) = (Random(7), CELLS + 1);
    let (mut nodes, mut rim, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for (i, j) in (0..side * side).map(|n| (n % side, n / side)) {
        let inner = |c: usize| (1..CELLS).contains(&c);
        let moved = random.vector().map(|r| if inner(i) && inner(j) { r / 3.0 } else { 0.0 });
        nodes.push([(i as f64 + moved[0]) / CELLS as f64, (j as f64 + moved[1]) / CELLS as f64, 0.0]);
        if !(inner(i) && inner(j)) {
            rim.push(i + side * j);
        }
        if i < CELLS && j < CELLS {
            let at = i + side * j;
            let [a, b, c, d] = [at, at + 1, at + side + 1, at + side];
            triangles.extend(if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
        }
    }
    Patch { nodes, triangles, rim }
}

fn case(patch: &Patch, network: Value, moved: impl Fn(Vector3<f64>) -> Vector3<f64>) -> Value {
    let displacement: Vec<[f64; 3]> =
        patch.nodes.iter().map(|&p| (moved(p.into()) - Vector3::from(p)).into()).collect();
    let mut network = network;
    network["mesh"] = json!({"explicit": {"nodes": patch.nodes, "triangles": patch.triangles}});
    network["mass"] = json!({"areal_density": 1.0});
    network["initial"] = json!({"displacement": displacement});
    json!({
        "name": "patch",
        "system": {"network": network},
        "time": {"end": 1.0, "method": "newmark", "step": 0.01},
        "solver": {"newton": {"relative": 1e-14}}
    })
}

/// Largest distance of two lists of vectors.
fn apart(a: &[[f64; 3]], b: impl Iterator<Item = Vector3<f64>>) -> f64 {
    a.iter().zip(b).map(|(a, b)| (Vector3::from(*a) - b).norm()).fold(0.0, f64::max)
}

/// Stretched along both axes and sheared.
const F: Matrix2<f64> = Matrix2::new(1.12, 0.09, -0.03, 1.06);

/// The sheet is turned about this [rad].
const TURN: [f64; 3] = [0.7, -1.1, 2.3];

fn strained(material: Material, wrinkling: bool, claims: &mut Vec<Claim>) {
    let (patch, turn) = (patch(), Rotation3::new(Vector3::from(TURN)));
    let mut rule = material.rule();
    rule["wrinkling"] = json!(wrinkling);
    let network = json!({"membranes": [rule], "supports": [{"on": {"ids": patch.rim}, "fix": "xyz"}]});
    let place = |p: Vector3<f64>| {
        let flat = F * Vector2::new(p.x, p.y);
        turn * Vector3::new(flat.x, flat.y, 0.0)
    };
    // Inner nodes begin elsewhere, out of the plane too.
    let inner = |p: Vector3<f64>| (1e-9..1.0 - 1e-9).contains(&p.x) && (1e-9..1.0 - 1e-9).contains(&p.y);
    let start = |p: Vector3<f64>| place(p) + if inner(p) { Vector3::new(0.01, -0.02, 0.03) } else { Vector3::zeros() };
    let rest = at_rest(&case_of(&case(&patch, network, start), &[]));
    let name = format!("{}{}", material.name, if wrinkling { ", able to wrinkle but taut" } else { "" });
    let off = apart(&rest.positions, patch.nodes.iter().map(|&p| place(p.into())));
    claims.push(Claim::below(format!("{name}: inner nodes from x = F X [m]"), off, 1e-12));
    let (second, energy) = material.stress(0.5 * (F.transpose() * F - Matrix2::identity()));
    let cauchy = F * second * F.transpose() / F.determinant();
    let mut principal: [f64; 2] = cauchy.symmetric_eigenvalues().into();
    principal.sort_by(|a, b| b.total_cmp(a));
    let off = |of: &Rest| {
        let each = of.membranes.iter().flat_map(|m| [0, 1].map(|i| (m.stress[i] / principal[i] - 1.0).abs()));
        each.fold(0.0, f64::max)
    };
    claims.push(Claim::below(
        format!("{name}: principal stresses of all triangles, worst share off"),
        off(&rest),
        1e-12,
    ));
    claims.push(Claim::relative(format!("{name}: energy [J]"), rest.elastic, energy, 1e-12));
    // The force on the cut x = 1 is t F S e_x over its length of 1 m.
    let cut = patch.nodes.iter().zip(&rest.reactions).filter(|(p, _)| p[0] == 1.0);
    let along: Vector3<f64> = cut.map(|(_, r)| Vector3::from(*r)).sum();
    let (expected, size) = (F * second.column(0) * THICKNESS, second.norm() * THICKNESS);
    let expected = turn * Vector3::new(expected.x, expected.y, 0.0);
    claims.push(Claim::below(
        format!("{name}: force on the side x = 1, share off"),
        (along - expected).norm() / size,
        1e-12,
    ));
}

fn rigid(material: Material, claims: &mut Vec<Claim>) {
    let (patch, turn) = (patch(), Rotation3::new(Vector3::from(TURN)));
    let mut rule = material.rule();
    rule["wrinkling"] = json!(true);
    let network = json!({"membranes": [rule], "bending": [{"on": "all", "stiffness": 0.1}]});
    let moved = |p: Vector3<f64>| turn * p + Vector3::new(3.0, -2.0, 5.0);
    let given = as_given(&case_of(&case(&patch, network, moved), &[]));
    let strains = given.membranes.iter().flat_map(|m| m.strain);
    let strain = strains.fold(0.0, |worst: f64, e| worst.max(e.abs()));
    claims.push(Claim::below(format!("{}, turned and moved: largest strain", material.name), strain, 1e-12));
    let taut = given.membranes.iter().all(|m| m.wrinkling == 0.0);
    claims.push(Claim::is(format!("{}, turned and moved: all triangles are shown as taut", material.name), taut));
    let force = apart(&given.forces, std::iter::repeat(Vector3::zeros()));
    let size = material.modulus[0] * THICKNESS / CELLS as f64;
    claims.push(Claim::below(
        format!("{}, turned and moved: largest force over E t and the edge", material.name),
        force / size,
        1e-12,
    ));
}

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    for material in [ISOTROPIC, ORTHOTROPIC] {
        strained(material, false, &mut claims);
        strained(material, true, &mut claims);
        rigid(material, &mut claims);
    }
    claims
}
