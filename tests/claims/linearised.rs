//! The assembled tangent of a case at its start, in the user's numbering, and its modes.

use canopy_fem::assembly::Assembler;
use canopy_fem::case::Case;
use canopy_fem::model::system::Weights;
use canopy_fem::scene::Scene;
use canopy_fem::simulation::build_scene;
use faer::{Mat, Side};

/// K of M u'' = -K u about the start of a case.
pub struct Linearised {
    stiffness: Assembler,
    /// node and axis of every unknown
    names: Vec<(usize, usize)>,
    /// [1/kg] of every unknown
    inverse_mass: Vec<f64>,
    nodes: usize,
}

/// Modes K phi = w^2 M phi, slowest first.
pub struct Modes {
    /// [1/s^2] w^2
    pub squares: Vec<f64>,
    /// displacement of every node, phi M phi = 1
    pub shapes: Vec<Vec<[f64; 3]>>,
}

impl Linearised {
    pub fn of(case: &Case) -> Self {
        let scene: Box<dyn Scene> = build_scene(case.problem().clone().take_system(), 1).expect("the case is good");
        let system = scene.interfaces().tangent;
        let mut stiffness = system.assembler().expect("small");
        system.assemble(system.initial_state().as_ref(), Weights { m: 0.0, c: 0.0, k: 1.0 }, &mut stiffness);
        let axis = |letter: &str| "xyz".find(letter).expect("a network's unknowns are x, y, z");
        let name = |&dof: &u32| {
            let (node, letter) = scene.name_of(dof as usize);
            (node as usize, axis(letter))
        };
        let names = stiffness.pattern.dof.iter().map(name).collect();
        let inverse_mass = stiffness.pattern.dof.iter().map(|&dof| system.inverse_mass()[dof as usize]).collect();
        Linearised { stiffness, names, inverse_mass, nodes: scene.reference().len() }
    }

    /// [N] K u; nothing at fixed degrees of freedom.
    pub fn times(&self, u: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let p: Vec<f64> = self.names.iter().map(|&(node, axis)| u[node][axis]).collect();
        let mut y = vec![0.0; p.len()];
        self.stiffness.pattern.multiply(self.stiffness.values(), &p, &mut y);
        self.by_node(|i| y[i])
    }

    fn by_node(&self, value: impl Fn(usize) -> f64) -> Vec<[f64; 3]> {
        let mut u = vec![[0.0; 3]; self.nodes];
        for (i, &(node, axis)) in self.names.iter().enumerate() {
            u[node][axis] = value(i);
        }
        u
    }

    /// All modes that move along `axes`, a choice of "xyz". K must not couple them to the other axes.
    pub fn modes(&self, axes: &str) -> Modes {
        let chosen = |i: usize| axes.contains(["x", "y", "z"][self.names[i].1]);
        let of: Vec<usize> = (0..self.names.len()).filter(|&i| chosen(i)).collect();
        let n = of.len();
        let mut a = Mat::<f64>::zeros(n, n);
        let (mut unit, mut column) = (vec![0.0; self.names.len()], vec![0.0; self.names.len()]);
        for (j, &dof) in of.iter().enumerate() {
            unit.fill(0.0);
            unit[dof] = 1.0;
            self.stiffness.pattern.multiply(self.stiffness.values(), &unit, &mut column);
            let others: f64 = (0..column.len()).filter(|&i| !chosen(i)).map(|i| column[i].abs()).sum();
            assert!(others <= 1e-12 * column[dof].abs(), "motion along {axes} drives another axis: {others} N/m");
            for (i, &row) in of.iter().enumerate() {
                a[(i, j)] = column[row] * (self.inverse_mass[row] * self.inverse_mass[dof]).sqrt();
            }
        }
        let eigen = a.self_adjoint_eigen(Side::Lower).expect("a symmetric matrix has eigenvalues");
        let (vectors, values) = (eigen.U(), eigen.S().column_vector());
        let place = |i: usize| of.binary_search(&i).ok();
        let shape =
            |j: usize| self.by_node(|i| place(i).map_or(0.0, |row| vectors[(row, j)] * self.inverse_mass[i].sqrt()));
        Modes { squares: (0..n).map(|j| values[j]).collect(), shapes: (0..n).map(shape).collect() }
    }
}

/// Largest share by which sorted numbers are off the expected ones; as many must be expected.
pub fn worst_share(found: &[f64], expected: impl IntoIterator<Item = f64>) -> f64 {
    let mut expected: Vec<f64> = expected.into_iter().collect();
    expected.sort_by(f64::total_cmp);
    assert_eq!(found.len(), expected.len());
    found.iter().zip(&expected).fold(0.0, |worst: f64, (f, e)| worst.max((f - e).abs() / e.abs()))
}
