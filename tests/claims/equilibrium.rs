//! Equilibria found by `canopy-fem static`, from starts that are far, and the modes about them.
//!
//! * A node on two bars: W = 2 T sin(a), T = EA (1/(c cos a) - 1) with half the span c l0.
//! * A catenary of length 10 m over 8 m: parameter 3.3820187909, sag 2.6543750914, largest tension over w 6.0363938823.
//!   A polygon of n links takes the integrals behind it by the midpoint rule, so its error falls with n^-2.
//! * A net by force densities (Schek 1974): springs without rest length and of stiffness q pull with q l, so each
//!   coordinate solves its own linear equations. On a square grid with one q they are those of the discrete Laplacian,
//!   and z = x y, its solution, is the hypar.
//! * A chain of beads that hangs: w^2 = (g/l) x with L_N(x) = 0, and for many beads w = j01/2 sqrt(g/L)
//!   (`hanging_chain`).
//! * A strung chain: w = 2 sqrt(T/(m a)) sin(q a/2) across it.
//! * A square membrane, stretched alike in both directions: w^2 = (S/sigma)(pi/L)^2 (m^2 + n^2) across it. Right
//!   triangles of side h are the five-point Laplacian, whose modes have (2/h sin(m pi h/(2 L)))^2 in place of
//!   (m pi/L)^2.

use crate::chain::{G, Hanging, Strung};
use crate::claim::Claim;
use crate::common::run::case_of;
use crate::hanging_chain::zeros;
use canopy_fem::analysis::lowest::lowest;
use canopy_fem::case::Case;
use canopy_fem::model::stop::Stop;
use canopy_fem::scene::Scene;
use canopy_fem::simulation::build_scene;
use canopy_fem::statics::{Equilibrium, Stability, StaticSpec, find};
use serde_json::{Value, json};
use std::f64::consts::PI;

/// An equilibrium, in the user's numbering.
pub struct AtRest {
    pub scene: Box<dyn Scene>,
    pub found: Equilibrium,
    /// [m]
    pub positions: Vec<[f64; 3]>,
    /// [N] of the edges
    pub tensions: Vec<f64>,
    /// [N]
    pub reactions: Vec<[f64; 3]>,
}

impl AtRest {
    /// The equilibrium of a case, with 1e-10 of the forces left at most.
    pub fn of(case: &Case) -> Self {
        let problem = case.problem();
        let scene = build_scene(problem.system.clone(), 1).expect("the case is good");
        let spec = StaticSpec {
            at: 0.0,
            relative: 1e-10,
            max_iterations: 10_000,
            load_steps: 1,
            linear: problem.solver.linear,
        };
        let found = find(&*scene, spec, Stop::NEVER);
        assert_eq!(found.failure, None, "{}", problem.name);
        let (n, at) = (scene.reference().len(), &found.point);
        let (mut positions, mut velocities) = (vec![[0.0; 3]; n], vec![[0.0; 3]; n]);
        scene.trace(at.state.as_ref(), &mut positions, &mut velocities);
        let mut tensions = vec![0.0; scene.edges().len()];
        scene.edge_tension(at.state.as_ref(), &mut tensions, &mut vec![0.0; scene.edges().len()]);
        let mut reactions = vec![[0.0; 3]; n];
        scene.node_reactions(&at.forces, &mut reactions);
        AtRest { scene, found, positions, tensions, reactions }
    }

    /// [1/s^2] Squares of the lowest angular frequencies.
    fn squares(&self, count: usize) -> Vec<f64> {
        let modes = lowest(&*self.scene, self.found.point.state.as_ref(), count, Stop::NEVER).expect("modes");
        modes.modes.iter().map(|mode| mode.omega_squared).collect()
    }
}

pub fn claims() -> Vec<Claim> {
    [hanging_node(), catenary(), hypar(), modes()].concat()
}

/// A node of weight W between two walls, on bars that are slack at the start where it lies on one of the walls' lines.
fn hanging_node() -> Vec<Claim> {
    let (weight, rigidity, rest, half_span) = (20.0, 500.0, 1.0, 0.8);
    let case = |start: [f64; 3]| {
        case_of(
            &json!({
                "name": "node",
                "system": {"network": {
                    "mesh": {"explicit": {
                        "nodes": [[-half_span, 0, 0], [0, 0, 0], [half_span, 0, 0]], "springs": [[0, 1], [1, 2]]
                    }},
                    "mass": {"nodal": weight / G},
                    "springs": [{
                        "on": "all", "axial_rigidity": rigidity, "rest_length": rest, "slack": "tension-only"
                    }],
                    "supports": [{"on": {"ids": [0, 2]}, "fix": "xyz"}],
                    "gravity": [0, 0, -G],
                    "initial": {"displacement": [[0, 0, 0], start, [0, 0, 0]]}
                }},
                "time": {"end": 1.0, "method": "newmark", "step": 0.1}
            }),
            &[],
        )
    };
    // Root of 2 T sin(a) = W in the depth.
    let (mut high, mut low) = (0.0, 10.0);
    for _ in 0..200 {
        let depth: f64 = 0.5 * (high + low);
        let length = depth.hypot(half_span);
        let up = 2.0 * rigidity * (length / rest - 1.0) * depth / length;
        *if up < weight { &mut high } else { &mut low } = depth;
    }
    let starts = [("level", [0.0; 3]), ("3 m above", [0.1, 0.05, 3.0]), ("at a wall", [-0.79, 0.0, 0.0])];
    let depth = |(what, start): (&str, [f64; 3])| {
        let rest = AtRest::of(&case(start));
        Claim::relative(format!("hanging node, start {what}: depth [m]"), -rest.positions[1][2], high, 1e-9)
    };
    starts.into_iter().map(depth).collect()
}

/// [m], [-] of the inextensible catenary: sag, and largest tension over the weight of a metre
const CATENARY: [f64; 2] = [2.6543750914, 6.0363938823];

/// Sag and largest tension over w of 10 m of line in `links` links of a rigidity [N] over 8 m, from a start.
fn polygon(links: usize, rigidity: f64, start: &dyn Fn(f64) -> [f64; 3]) -> [f64; 2] {
    let nodes: Vec<[f64; 3]> = (0..=links).map(|i| [8.0 * i as f64 / links as f64, 0.0, 0.0]).collect();
    let inner = |i: usize| if i == 0 || i == links { [0.0; 3] } else { start(i as f64 / links as f64) };
    let springs: Vec<[usize; 2]> = (0..links).map(|i| [i, i + 1]).collect();
    let rest = AtRest::of(&case_of(
        &json!({
            "name": "catenary",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": nodes, "springs": springs}},
                // 1 N/m
                "mass": {"nodal": 10.0 / links as f64 / G},
                "springs": [{"on": "all", "axial_rigidity": rigidity, "rest_length": 10.0 / links as f64}],
                "supports": [{"on": {"ids": [0, links]}, "fix": "xyz"}],
                "gravity": [0, 0, -G],
                "initial": {"displacement": (0..=links).map(inner).collect::<Vec<_>>()}
            }},
            "time": {"end": 1.0, "method": "newmark", "step": 0.1}
        }),
        &[],
    ));
    let [x, y, z] = rest.reactions[0];
    // Half a link's weight rests on the support itself, and the node there weighs a whole link's.
    [-rest.positions[links / 2][2], x.hypot(y).hypot(z - 5.0 / links as f64)]
}

fn catenary() -> Vec<Claim> {
    let arc = |s: f64| [0.0, 0.0, -6.0 * s * (1.0 - s)];
    let found = [32, 64].map(|links| polygon(links, 1e7, &arc));
    let mut claims = Vec::new();
    for (i, name) in ["sag [m]", "largest tension over w [m]"].into_iter().enumerate() {
        let errors = found.map(|values| values[i] - CATENARY[i]);
        // The next term of the error is n^-4; a stretch of 6e-7 is in both.
        claims.push(Claim::absolute(
            format!("catenary, order of {name} from 32 to 64 links"),
            (errors[0] / errors[1]).log2(),
            2.0,
            0.05,
        ));
        let extrapolated = found[1][i] + (found[1][i] - found[0][i]) / 3.0;
        claims.push(Claim::relative(format!("catenary, {name} extrapolated"), extrapolated, CATENARY[i], 3e-6));
    }
    // From above, through the level of its supports, and from a mess.
    let below = polygon(32, 1e5, &arc);
    let above = polygon(32, 1e5, &|s| [0.0, 0.0, 12.0 * s * (1.0 - s)]);
    let mess = polygon(32, 1e5, &|s| [(71.0 * s).sin(), (37.0 * s).cos(), 2.0 * (91.0 * s).sin()]);
    for (what, [sag, tension]) in [("from above", above), ("from a mess", mess)] {
        claims.push(Claim::relative(format!("catenary {what}: sag as from below"), sag, below[0], 1e-8));
        claims.push(Claim::relative(format!("catenary {what}: tension as from below"), tension, below[1], 1e-8));
    }
    claims
}

/// A square grid of `side` by `side` meshes whose rim is held on z = x y/side, and which starts flat inside.
fn net(side: usize) -> Value {
    let at = |i: usize, j: usize| i * (side + 1) + j;
    let rim = |i: usize, j: usize| i == 0 || j == 0 || i == side || j == side;
    let (mut nodes, mut springs, mut held) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..=side {
        for j in 0..=side {
            let (x, y) = (i as f64, j as f64);
            nodes.push([x, y, if rim(i, j) { x * y / side as f64 } else { 0.0 }]);
            held.extend(rim(i, j).then_some(at(i, j)));
            springs.extend((i < side && !(rim(i, j) && rim(i + 1, j))).then(|| [at(i, j), at(i + 1, j)]));
            springs.extend((j < side && !(rim(i, j) && rim(i, j + 1))).then(|| [at(i, j), at(i, j + 1)]));
        }
    }
    json!({
        "name": "hypar",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": nodes, "springs": springs}},
            "mass": {"nodal": 1.0},
            "springs": [{"on": "all", "stiffness": 7.0, "rest_length": 0.0}],
            "supports": [{"on": {"ids": held}, "fix": "xyz"}]
        }},
        "time": {"end": 1.0, "method": "newmark", "step": 0.1}
    })
}

/// The force densities of one half twice those of the other: no closed form, but linear equations.
fn hypar() -> Vec<Claim> {
    let side = 8;
    let even = AtRest::of(&case_of(&net(side), &[]));
    let off = |p: &[f64; 3]| (p[2] - p[0] * p[1] / side as f64).abs();
    let worst = even.positions.iter().map(off).fold(0.0, f64::max);
    let mut claims = vec![
        Claim::below("hypar net of one force density: z = x y/8, worst node off [m]", worst, 1e-9),
        // The equations are linear: the solves differ in the weight of the mass alone.
        Claim::below("hypar net: Newton iterations", even.found.counters.newton_iterations as f64, 20.0),
    ];
    let mut uneven = net(side);
    let edges = uneven["system"]["network"]["mesh"]["explicit"]["springs"].as_array().expect("edges").len();
    let half: Vec<usize> = (0..edges / 2).collect();
    uneven["system"]["network"]["springs"] = json!([
        {"on": {"ids": half}, "stiffness": 14.0, "rest_length": 0.0},
        {"on": "all", "stiffness": 7.0, "rest_length": 0.0}
    ]);
    let rest = AtRest::of(&case_of(&uneven, &[]));
    let apart = force_density_solution(&uneven, &rest);
    claims.push(Claim::below("net of two force densities: linear solution, worst node off [m]", apart, 1e-9));
    let longest = |(tension, [a, b]): (&f64, &[u32; 2])| {
        let (a, b) = (rest.positions[*a as usize], rest.positions[*b as usize]);
        let length = (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt();
        let ratio = tension / length;
        (ratio - 7.0).abs().min((ratio - 14.0).abs())
    };
    let worst = rest.tensions.iter().zip(rest.scene.edges()).map(longest).fold(0.0, f64::max);
    claims.push(Claim::below("net of two force densities: tension over length [N/m], worst off", worst, 1e-9));
    claims
}

/// [m] How far nodes are from the solution of sum q (x_j - x_i) = 0, by Gauss and Seidel.
fn force_density_solution(case: &Value, rest: &AtRest) -> f64 {
    let network = &case["system"]["network"];
    let pairs: Vec<[usize; 2]> = serde_json::from_value(network["mesh"]["explicit"]["springs"].clone()).expect("pairs");
    let mut x: Vec<[f64; 3]> = serde_json::from_value(network["mesh"]["explicit"]["nodes"].clone()).expect("nodes");
    let held: Vec<usize> = serde_json::from_value(network["supports"][0]["on"]["ids"].clone()).expect("nodes");
    let density = |edge: usize| if edge < pairs.len() / 2 { 14.0 } else { 7.0 };
    let mut ties = vec![Vec::new(); x.len()];
    for (edge, &[a, b]) in pairs.iter().enumerate() {
        ties[a].push((b, density(edge)));
        ties[b].push((a, density(edge)));
    }
    for _ in 0..2000 {
        for node in (0..x.len()).filter(|node| !held.contains(node)) {
            let all: f64 = ties[node].iter().map(|(_, q)| q).sum();
            x[node] = std::array::from_fn(|c| ties[node].iter().map(|(to, q)| q * x[*to][c]).sum::<f64>() / all);
        }
    }
    let off = |(a, b): (&[f64; 3], &[f64; 3])| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f64::max);
    x.iter().zip(&rest.positions).map(off).fold(0.0, f64::max)
}

/// [kg/m^2]
const DRUM_DENSITY: f64 = 0.05;
/// [N/m] E t
const DRUM_STIFFNESS: f64 = 4e4;
const DRUM_POISSON: f64 = 0.3;
/// [-] stretch of the square in both directions
const DRUM_STRETCH: f64 = 1.01;

/// [N/m] S = E t e/(1 - nu) with the Green strain e.
fn drum_tension() -> f64 {
    DRUM_STIFFNESS * 0.5 * (DRUM_STRETCH * DRUM_STRETCH - 1.0) / (1.0 - DRUM_POISSON)
}

/// A square of 1 m in so many cells a side, stretched and held at its edge.
fn drum(cells: u32) -> Value {
    let side = cells + 1;
    let nodes: Vec<[f64; 3]> = (0..side * side)
        .map(|n| [f64::from(n % side), f64::from(n / side), 0.0].map(|c| c / f64::from(cells)))
        .collect();
    let displacement: Vec<[f64; 3]> = nodes.iter().map(|x| x.map(|c| (DRUM_STRETCH - 1.0) * c)).collect();
    let corners = (0..cells * cells).map(|cell| side * (cell / cells) + cell % cells);
    let triangles: Vec<[u32; 3]> =
        corners.flat_map(|a| [[a, a + 1, a + side + 1], [a, a + side + 1, a + side]]).collect();
    json!({
        "name": "drum",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": nodes, "springs": [], "triangles": triangles}},
            "mass": {"areal_density": DRUM_DENSITY},
            "membranes": [{"on": "all", "thickness": 1e-4, "modulus": DRUM_STIFFNESS / 1e-4, "poisson": DRUM_POISSON}],
            "supports": [{"on": "outer", "fix": "xyz"}],
            "initial": {"displacement": displacement}
        }},
        "time": {"end": 1.0, "method": "newmark", "step": 0.1}
    })
}

fn modes() -> Vec<Claim> {
    let mut claims = Vec::new();
    let chain = Hanging { beads: 40, mass: 1.0 / 40.0, link: 1.0 / 40.0, stiffness: 2000.0 * 40.0 };
    let rest = AtRest::of(&chain.at_rest());
    claims.push(Claim::is("hanging chain is stable", rest.found.stability == Some(Stability::Stable)));
    let squares = rest.squares(6);
    for (i, zero) in zeros(40).into_iter().take(3).enumerate() {
        // Each twice, along x and y.
        for square in &squares[2 * i..2 * i + 2] {
            let what = format!("hanging chain of 40 beads, mode {}: w^2 l/g, zero of L_40", i + 1);
            claims.push(Claim::relative(what, square * chain.link / G, zero, 1e-9));
        }
    }
    // x_1 of L_N tends to (j01/2)^2/(N + 1/2).
    let bessel = (2.404825557695773_f64 / 2.0).powi(2) * G;
    let first = |beads: usize| {
        let n = beads as f64;
        let chain = Hanging { beads, mass: 1.0 / n, link: 1.0 / (n + 0.5), stiffness: 2000.0 * n };
        AtRest::of(&chain.at_rest()).squares(1)[0]
    };
    let (coarse, fine) = (first(50) / bessel - 1.0, first(100) / bessel - 1.0);
    claims.push(Claim::below("hanging chain of 100 beads: w^2 of Bessel's chain, share off", fine.abs(), 1e-5));
    claims.push(Claim::absolute("its order from 50 to 100 beads", (coarse / fine).abs().log2(), 2.0, 0.1));
    let cells = 12;
    let squares = AtRest::of(&case_of(&drum(cells), &[])).squares(4);
    let wave = |m: f64| (2.0 * f64::from(cells) * (0.5 * m * PI / f64::from(cells)).sin()).powi(2);
    for (square, [m, n]) in squares.iter().zip([[1.0, 1.0], [1.0, 2.0], [2.0, 1.0], [2.0, 2.0]]) {
        let exact = drum_tension() / DRUM_DENSITY * (wave(m) + wave(n));
        claims.push(Claim::relative(format!("square membrane, mode {m}, {n}: w^2 sigma/S"), *square, exact, 1e-9));
    }
    let strung = Strung { beads: 30, mass: 0.01, link: 0.05, stiffness: 1e5, tension: 20.0 };
    let squares = AtRest::of(&strung.at_rest()).squares(8);
    for j in 1..=4 {
        let exact = strung.frequency(strung.tension / strung.link, j).powi(2);
        for square in &squares[2 * j - 2..2 * j] {
            claims.push(Claim::relative(
                format!("strung chain of 30 beads, mode {j} across: w^2"),
                *square,
                exact,
                1e-9,
            ));
        }
    }
    claims
}
