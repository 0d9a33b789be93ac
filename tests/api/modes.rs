//! The lowest modes of many small scenes, all of which a dense solver has too: free bodies, mechanisms, frequencies
//! that come many times over, states in compression that grow, pressures and air.

use crate::common::run::case_of;
use crate::common::{self, Random};
use canopy_fem::analysis::lowest::{LowModes, ModesError, lowest};
use canopy_fem::model::state::State;
use canopy_fem::model::stop::Stop;
use canopy_fem::model::system::Weights;
use canopy_fem::scene::Scene;
use canopy_fem::simulation::build_scene;
use nalgebra::DMatrix;
use serde_json::{Value, json};

/// A scene at its start, with K over its free degrees of freedom, scaled by the masses.
struct Dense {
    scene: Box<dyn Scene>,
    at: State,
    free: Vec<usize>,
    /// M^-1/2 K M^-1/2 [1/s^2]
    k: DMatrix<f64>,
    /// [kg] `[n_dof]`
    mass: Vec<f64>,
}

impl Dense {
    fn of(network: &Value) -> Self {
        let case = json!({"name": "modes", "system": {"network": network},
            "time": {"end": 1.0, "method": "newmark", "step": 0.1}});
        let scene = build_scene(case_of(&case, &[]).problem().system.clone(), 1).expect("the case is good");
        let at = scene.initial_state();
        let n = scene.n_dof();
        let mut mass = vec![0.0; n];
        scene.mass_times(&vec![1.0; n], &mut mass);
        let free: Vec<usize> = (0..n).filter(|&dof| scene.inverse_mass()[dof] > 0.0).collect();
        let mut k = DMatrix::zeros(free.len(), free.len());
        let mut image = vec![0.0; n];
        for (j, &column) in free.iter().enumerate() {
            let mut unit = vec![0.0; n];
            unit[column] = 1.0 / mass[column].sqrt();
            scene.tangent_times(at.as_ref(), Weights { m: 0.0, c: 0.0, k: 1.0 }, &unit, &mut image);
            free.iter().enumerate().for_each(|(i, &row)| k[(i, j)] = image[row] / mass[row].sqrt());
        }
        Dense { scene, at, free, k, mass }
    }

    fn modes(&self, count: usize) -> Result<LowModes, ModesError> {
        lowest(&*self.scene, self.at.as_ref(), count, Stop::NEVER)
    }

    /// The lowest `count` modes are those of the dense matrix, each with its multiplicity, and solve its equation.
    fn agrees(&self, count: usize, what: &str) -> LowModes {
        let symmetric = (&self.k + self.k.transpose()) * 0.5;
        let mut expected: Vec<f64> = symmetric.symmetric_eigenvalues().iter().copied().collect();
        expected.sort_by(f64::total_cmp);
        let largest = expected.iter().fold(1e-300, |most: f64, square| most.max(square.abs()));
        let found = self.modes(count).unwrap_or_else(|error| panic!("{what}, {count} modes: {error}"));
        let squares: Vec<f64> = found.modes.iter().map(|mode| mode.omega_squared).collect();
        assert_eq!(squares.len(), count, "{what}");
        for (i, (mode, expected)) in found.modes.iter().zip(&expected).enumerate() {
            let off = (mode.omega_squared - expected).abs();
            assert!(off <= 1e-9 * expected.abs() + 1e-12 * largest, "{what}: mode {i} of {count}: {squares:?}");
            assert!(off <= mode.error + 1e-13 * largest, "{what}: mode {i} is {off} off, and says {}", mode.error);
            let bound = 1e-7 * (expected.abs() + squares[count - 1].abs()) + 1e-12 * largest;
            assert!(mode.error <= bound, "{what}: mode {i} of {count}: {} for {bound}", mode.error);
            let q: Vec<f64> = self.free.iter().map(|&dof| mode.shape[dof] * self.mass[dof].sqrt()).collect();
            let q = nalgebra::DVector::from_vec(q);
            let left = (&symmetric * &q - &q * mode.omega_squared).norm();
            assert!(left <= mode.error + 1e-13 * largest, "{what}: mode {i} leaves {left}");
        }
        for (i, one) in found.modes.iter().enumerate() {
            for (j, other) in found.modes.iter().enumerate() {
                let product: f64 =
                    (0..self.mass.len()).map(|dof| one.shape[dof] * self.mass[dof] * other.shape[dof]).sum();
                let unit = if i == j { 1.0 } else { 0.0 };
                assert!((product - unit).abs() < 1e-6, "{what}: modes {i} and {j}: {product}");
            }
        }
        found
    }

    fn agrees_for_all_counts(&self, what: &str) {
        let n = self.free.len();
        for count in [1, 2, 5, n / 2, n - 1, n] {
            if (1..=n).contains(&count) {
                self.agrees(count, what);
            }
        }
    }
}

/// Nodes in a box with springs between some of them, in tension and in compression, held in any way or not at all.
fn random_net(random: &mut Random) -> Value {
    let n = 4 + (random.next().abs() * 9.0) as usize;
    let nodes: Vec<[f64; 3]> = (0..n).map(|_| random.vector()).collect();
    let dense = 0.2 + 0.7 * random.next().abs();
    let pairs = (0..n).flat_map(|a| (a + 1..n).map(move |b| [a, b]));
    let edges: Vec<[usize; 2]> = pairs.filter(|[a, b]| *b == a + 1 || random.next().abs() < dense).collect();
    let stretched = 1.0 + 0.4 * random.next();
    let fixes = ["xyz", "z", "xy"];
    let held = (random.next().abs() * 3.0) as usize;
    let supports: Vec<Value> = (0..held)
        .map(|node| json!({"on": {"ids": [node]}, "fix": fixes[(random.next().abs() * 2.99) as usize]}))
        .collect();
    json!({
        "mesh": {"explicit": {"nodes": nodes, "springs": edges}},
        "mass": {"nodal": 0.1 + random.next().abs()},
        "springs": [{"on": "all", "stiffness": 10.0_f64.powf(3.0 + 2.0 * random.next()), "rest_scale": stretched}],
        "supports": supports
    })
}

#[test]
fn random_nets_have_all_their_modes() {
    let mut random = Random(57);
    for number in 0..60 {
        let network = random_net(&mut random);
        Dense::of(&network).agrees_for_all_counts(&format!("net {number}"));
    }
}

/// Alike arms around a held node: every frequency as often as there are arms, and twice as many zeros.
#[test]
fn frequencies_that_come_many_times_are_all_found() {
    for arms in [3, 7, 12, 30] {
        let turn = |arm: usize| 2.399963 * arm as f64;
        let ends = (0..arms).map(|arm| {
            let z: f64 = 1.0 - (2.0 * arm as f64 + 1.0) / arms as f64;
            let r = (1.0 - z * z).sqrt();
            [r * turn(arm).cos(), r * turn(arm).sin(), z]
        });
        let nodes: Vec<[f64; 3]> = std::iter::once([0.0; 3]).chain(ends).collect();
        let springs: Vec<[usize; 2]> = (1..=arms).map(|arm| [0, arm]).collect();
        let star = json!({
            "mesh": {"explicit": {"nodes": nodes, "springs": springs}},
            "mass": {"nodal": 0.5},
            "springs": [{"on": "all", "stiffness": 200.0}],
            "supports": [{"on": {"ids": [0]}, "fix": "xyz"}]
        });
        let dense = Dense::of(&star);
        dense.agrees_for_all_counts(&format!("{arms} arms"));
        let found = dense.agrees(2 * arms + 2, "arms");
        let frequencies: Vec<f64> = found.modes.iter().map(|mode| mode.frequency()).collect();
        assert!(frequencies[..2 * arms].iter().all(|f| *f == 0.0), "{frequencies:?}");
        let one = 400.0_f64.sqrt() / std::f64::consts::TAU;
        assert!(frequencies[2 * arms..].iter().all(|f| (f / one - 1.0).abs() < 1e-12), "{frequencies:?}");
    }
}

/// A free flat net without tension: every node moves freely across it.
#[test]
fn a_large_null_space_comes_whole() {
    let net = json!({
        "mesh": {"rectangle": {"width": 1, "height": 1, "columns": 6, "rows": 6}},
        "mass": {"areal_density": 0.2},
        "springs": [{"on": "all", "stiffness": 1000.0}]
    });
    let dense = Dense::of(&net);
    for count in [4, 20, 52, 70] {
        dense.agrees(count, "flat net");
    }
}

/// Three free bodies of the same kind that are not joined, and one that is other.
#[test]
fn parts_that_are_not_joined_are_all_found() {
    let mut random = Random(5);
    let body: Vec<[f64; 3]> = (0..5).map(|_| random.vector()).collect();
    let at = |x: f64| body.iter().map(move |node| [node[0] + x, node[1], node[2]]);
    let nodes: Vec<[f64; 3]> = [0.0, 5.0, 9.0].into_iter().flat_map(at).collect();
    let pairs = |first: usize| (0..5).flat_map(move |a| (a + 1..5).map(move |b| [first + a, first + b]));
    let springs: Vec<[usize; 2]> = [0, 5, 10].into_iter().flat_map(pairs).collect();
    let bodies = json!({
        "mesh": {"explicit": {"nodes": nodes, "springs": springs}},
        "mass": {"nodal": 0.3},
        "springs": [{"on": "all", "stiffness": 700.0}]
    });
    Dense::of(&bodies).agrees_for_all_counts("three bodies");
}

/// The octahedron of many tests with loads: the stiffness of a closed surface under pressure is symmetric.
fn octahedron(load: &Value) -> Value {
    let mut network = common::octahedron();
    let members = network.as_object_mut().expect("an object");
    members.extend(load.as_object().expect("an object").clone());
    network
}

#[test]
fn pressure_and_air_are_part_of_the_stiffness() {
    let closed = Dense::of(&octahedron(&json!({"loads": [{"on": "all", "pressure": 300.0}]})));
    closed.agrees_for_all_counts("closed surface");
    assert!(closed.agrees(18, "closed surface").symmetric);
    let open = Dense::of(&octahedron(&json!({"loads": [{"on": {"ids": [0, 3]}, "pressure": 300.0}]})));
    open.agrees_for_all_counts("open surface");
    assert!(!open.agrees(18, "open surface").symmetric);
    let air = json!({"wind": [3, 1, 20], "law": {"pressure_coefficient": {"cp": 1.2, "air_density": 1.225}}});
    let air = Dense::of(&octahedron(&json!({"aero": air})));
    air.agrees_for_all_counts("air");
    assert!(!air.agrees(18, "air").symmetric);
}

/// With all modes, the motions that grow are those of the whole matrix, under a pressure that follows a surface that is
/// not closed.
#[test]
fn motions_that_grow_together_are_those_of_the_whole_stiffness() {
    for pressure in [300.0, 1e3, 3e3, 1e4] {
        let dense = Dense::of(&octahedron(&json!({
            "loads": [{"on": {"ids": [0, 5]}, "pressure": pressure}],
            "supports": [{"on": {"ids": [5]}, "fix": "xyz"}, {"on": {"ids": [3]}, "fix": "x"}]
        })));
        let found = dense.agrees(dense.free.len(), "open surface");
        // z^2 = -w^2 for every eigenvalue w^2, complex or not.
        let squares = dense.k.clone().complex_eigenvalues();
        let largest = squares.iter().fold(0.0, |most: f64, square| most.max(square.norm()));
        let roots = squares.iter().map(|square| (-square).sqrt()).filter(|z| z.re > 1e-5 * largest.sqrt());
        let fastest = roots.max_by(|a, b| a.re.total_cmp(&b.re));
        let growing = found.growing.first();
        match (fastest, growing) {
            (None, None) => {}
            (Some(z), Some(motion)) => {
                assert!((motion.rate / z.re - 1.0).abs() < 1e-6, "{pressure}: {motion:?} for {z}");
                let frequency = z.im.abs() / std::f64::consts::TAU;
                assert!((motion.frequency - frequency).abs() < 1e-6 * z.norm(), "{pressure}: {motion:?} for {z}");
            }
            other => panic!("{pressure}: {other:?}"),
        }
    }
}

/// A bar in compression with its end free to go aside: a mode that grows, at sqrt(force/(length mass)).
#[test]
fn a_mode_that_grows_has_a_rate() {
    let bar = json!({
        "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0], [2, 0, 0]], "springs": [[0, 1], [1, 2]]}},
        "mass": {"nodal": 2.0},
        "springs": [{"on": "all", "stiffness": 1000.0, "rest_length": 1.05}],
        "supports": [{"on": {"ids": [0, 2]}, "fix": "xyz"}]
    });
    let found = Dense::of(&bar).agrees(3, "bar");
    // Two bars with 50 N each push the middle aside.
    let rate = (2.0 * 50.0 / (1.0 * 2.0_f64)).sqrt();
    for mode in &found.modes[..2] {
        assert_eq!(mode.frequency(), 0.0);
        assert!((mode.growth() / rate - 1.0).abs() < 1e-9, "{} for {rate}", mode.growth());
    }
    assert!(found.symmetric && found.growing.len() == 2, "{:?}", found.growing);
}

#[test]
fn more_modes_than_there_are_is_an_error() {
    let dense = Dense::of(&octahedron(&json!({})));
    let error = dense.modes(19).expect_err("there are 18");
    assert_eq!(error, ModesError::TooMany { asked: 19, unknowns: 18 });
}
