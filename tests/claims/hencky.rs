//! Hencky's membrane (1915; corrected by Campbell 1956 and Fichter 1997): a flat, unstrained disc held at its edge
//! bulges under a uniform pressure across it. With q = p R/(E t), r = R rho, N_r = n E t q^(2/3), w' = -rho/(2 n)
//! q^(1/3):
//! ```text
//! n^2 (n'' + 3 n'/rho) = -1/8,     n'(1) + (1 - nu) n(1) = 0  (no radial displacement at the edge)
//! n = sum a_k rho^2k,   w(0) = R q^(1/3) int_0^1 rho/(2 n) drho
//! ```
//! The theory is of small strains (here q^(2/3) < 3e-5) and moderate slopes. nu = 1/3 is that of an equilateral net;
//! membranes have any.

mod series;

use crate::claim::Claim;
use crate::common::run::{Run, at_rest, case_of, run};
use crate::lattice::Lattice;
use canopy_fem::mesh::source::MeshSource;
use serde_json::{Value, json};
use series::{Series, follower_gain};
use std::collections::HashMap;
use std::path::Path;

/// [N/m] E t; radius and areal density are 1
const SHEET: f64 = 1e5;
/// [-] p R/(E t) of the comparison with the series
const LOAD: f64 = 1e-7;

/// How the pressure acts.
#[derive(Clone, Copy)]
enum Push {
    /// across the disc on the area at the start, which is that of the bulge the run starts from
    Dead,
    Follower,
    /// across the disc on the flat area
    Nodal,
}

/// A disc of springs under pressure, brought to rest by backward Euler: with w h = 3 a step leaves a third of what
/// moves. It starts from a bulge: a flat sheet without tension resists no small deflection, and Newton does not get off
/// it in such steps.
struct Disc {
    mesh: Value,
    springs: Value,
    mass: Value,
    pinned: Value,
    loads: Vec<Value>,
}

impl Disc {
    /// `membrane` wherever an edge has its two triangles; what the circle cuts has the same EA.
    fn net(lattice: &Lattice, pressure: f64, kind: Push) -> Self {
        let mut sides: HashMap<[u32; 2], u8> = HashMap::new();
        for [a, b, c] in &lattice.triangles {
            for (p, q) in [(a, b), (b, c), (c, a)] {
                *sides.entry([*p.min(q), *p.max(q)]).or_default() += 1;
            }
        }
        let whole = |s: &&[u32; 2]| sides.get(&[s[0].min(s[1]), s[0].max(s[1])]) == Some(&2);
        let sheet: Vec<usize> = (0..lattice.springs.len()).filter(|&i| whole(&&lattice.springs[i])).collect();
        let rigidity = 0.75_f64.sqrt() * SHEET * lattice.edge;
        // Whole triangles carry their pressure; the sixths of a cell that the circle has cut are forces on the node.
        let (mut loads, mut around) = (Vec::new(), lattice.triangles_around());
        match kind {
            Push::Dead => {
                loads.push(json!({"on": "all", "pressure": pressure, "kind": "dead", "direction": [0, 0, 1]}))
            }
            Push::Follower => loads.push(json!({"on": "all", "pressure": pressure, "kind": "follower"})),
            Push::Nodal => around.fill(0),
        }
        let free = |i: &u32| !lattice.pinned.contains(i);
        for (there, missing) in (0..6_usize).zip((1..=6).rev()) {
            let ids: Vec<u32> = (0..).zip(&around).filter(|(i, n)| **n == there && free(i)).map(|(i, _)| i).collect();
            if !ids.is_empty() {
                let force = f64::from(missing) / 6.0 * pressure * lattice.cell();
                loads.push(json!({"on": {"ids": ids}, "force": [0, 0, force]}));
            }
        }
        Disc {
            mesh: json!({"explicit": {
                "nodes": lattice.nodes, "springs": lattice.springs, "triangles": lattice.triangles
            }}),
            springs: json!([
                {"on": {"ids": sheet}, "membrane": {"modulus": 1e4 * SHEET, "thickness": 1e-4}},
                {"on": "all", "axial_rigidity": rigidity}
            ]),
            mass: json!({"nodal": lattice.cell()}),
            pinned: json!({"ids": lattice.pinned}),
            loads,
        }
    }

    fn unstructured(nodes: u32, seed: u64, pressure: f64) -> Self {
        Disc {
            mesh: json!({"disc": {"radius": 1.0, "nodes": nodes, "grading": 1.0, "seed": seed}}),
            springs: json!([{"on": "all", "membrane": {"modulus": 1e4 * SHEET, "thickness": 1e-4}}]),
            mass: json!({"areal_density": 1.0}),
            pinned: json!("outer"),
            loads: vec![json!({"on": "all", "pressure": pressure, "kind": "dead", "direction": [0, 0, 1]})],
        }
    }

    fn at_rest(self, load: f64) -> Run {
        // [rad/s] the slowest mode of a disc under the tension that will be: 2.4 sqrt(N/sigma)
        let rate = 2.4 * (0.4 * SHEET * load.powf(2.0 / 3.0)).sqrt();
        let h = 3.0 / rate;
        let source: MeshSource = serde_json::from_value(self.mesh.clone()).expect("a mesh section");
        let bulge = |p: &[f64; 3]| [0.0, 0.0, 0.6 * load.cbrt() * (1.0 - p[0] * p[0] - p[1] * p[1])];
        let nodes = source.build(Path::new("")).expect("a sound mesh").nodes;
        let displacement: Vec<[f64; 3]> = nodes.iter().map(bulge).collect();
        let case = json!({
            "name": "hencky",
            "system": {"network": {
                "mesh": self.mesh, "mass": self.mass, "springs": self.springs, "loads": self.loads,
                "supports": [{"on": self.pinned, "fix": "xyz"}],
                "initial": {"displacement": displacement}
            }},
            "time": {"end": 20.0 * h, "method": "backward-euler", "step": h}
        });
        let run = run(&case_of(&case, &[]));
        let (ledger, status) = (run.outcome.ledger, run.outcome.status);
        assert!(ledger.kinetic < 1e-12 * ledger.elastic, "not at rest: {status:?}, {ledger:?}");
        run
    }
}

/// Deflections of a run against the series, as shares of the deflection of the centre.
struct Errors {
    /// of the highest node
    centre: f64,
    /// of the worst node
    worst: f64,
}

fn height(run: &Run) -> f64 {
    run.positions.iter().map(|p| p[2]).fold(0.0, f64::max)
}

fn errors(run: &Run, series: &Series) -> Errors {
    let scale = LOAD.cbrt();
    let off = |p: &[f64; 3]| (p[2] / scale - series.deflection(p[0].hypot(p[1]))) / series.deflection(0.0);
    let top = run.positions.iter().max_by(|a, b| a[2].total_cmp(&b[2])).expect("a disc has nodes");
    Errors { centre: off(top), worst: run.positions.iter().map(|p| off(p).abs()).fold(0.0, f64::max) }
}

/// [-] N(0)/(E t q^(2/3)) from the six springs around the centre: N = sqrt 3 T/a.
fn tension(run: &Run, lattice: &Lattice) -> f64 {
    let from = |p: [f64; 3], q: [f64; 3]| (0..3).map(|c| (p[c] - q[c]).powi(2)).sum::<f64>().sqrt();
    let centre = (0..lattice.nodes.len()).find(|&i| from(lattice.nodes[i], [0.0; 3]) < 1e-12).expect("it has one");
    let ends = lattice.springs.iter().map(|s| s.map(|n| n as usize)).filter(|s| s.contains(&centre));
    let strains =
        ends.map(|[a, b]| from(run.positions[a], run.positions[b]) / from(lattice.nodes[a], lattice.nodes[b]) - 1.0);
    // T = (sqrt 3/2) E t a e in all six
    1.5 * strains.sum::<f64>() / 6.0 / LOAD.powf(2.0 / 3.0)
}

fn lattices(claims: &mut Vec<Claim>, series: &Series) {
    let solved = [8, 16, 32].map(|n| {
        let lattice = Lattice::disc(n);
        let run = Disc::net(&lattice, LOAD * SHEET, Push::Dead).at_rest(LOAD);
        (f64::from(n), errors(&run, series), tension(&run, &lattice) / series.n[0] - 1.0)
    });
    for (n, e, tension) in &solved {
        // The cut at the circle differs from net to net: C wanders between 0.024 and 0.047 for n = 5 .. 40.
        claims.push(Claim::between(
            format!("regular net, edge R/{n}: error of the centre's deflection = C (edge/R)^2, C"),
            e.centre * n * n,
            0.02,
            0.05,
        ));
        // Steepest at the edge, where the cut is.
        claims.push(Claim::below(
            format!("regular net, edge R/{n}: error of the worst node over the deflection of the centre"),
            e.worst,
            0.6 / (n * n),
        ));
        claims.push(Claim::below(
            format!("regular net, edge R/{n}: error of the centre's tension"),
            *tension,
            0.1 / (n * n),
        ));
    }
    let [_, (_, middle, _), (_, fine, _)] = &solved;
    // C's wandering is not extrapolated away; strains of 1e-5 are not the theory's small ones: 0.16 q^(2/3) = 3.5e-6.
    claims.push(Claim::absolute(
        "regular nets R/16 and R/32 extrapolated (order 2): deflection of the centre over the series'",
        1.0 + (4.0 * fine.centre - middle.centre) / 3.0,
        1.0,
        3e-5,
    ));
}

/// Nets without order are no sheet of Poisson ratio 1/3 at any fineness: their mean deflection does not tend to the
/// series'. Four seeds each gave -1.0e-3 .. -0.7e-3 at 600 nodes, 0.6e-3 .. 2.5e-3 at 1200, 1.3e-3 .. 1.6e-3 at 2400,
/// -0.8e-3 .. -0.4e-3 at 4800: to either side and without a trend. Only single nodes get better, and slowly.
fn unstructured(claims: &mut Vec<Claim>, series: &Series) {
    let mut worst_of = [600, 1200, 2400, 4800].map(|nodes| (nodes, 0.0_f64, 0.0_f64));
    for (nodes, mean, worst) in &mut worst_of {
        for seed in [1, 2] {
            let run = Disc::unstructured(*nodes, seed, LOAD * SHEET).at_rest(LOAD);
            let exact: f64 = run.reference.iter().map(|p| series.deflection(p[0].hypot(p[1]))).sum();
            let off = run.positions.iter().map(|p| p[2]).sum::<f64>() / LOAD.cbrt() / exact - 1.0;
            *mean = mean.max(off.abs());
            *worst = worst.max(errors(&run, series).worst);
        }
        claims.push(Claim::between(
            format!("the program's discs of {nodes} nodes, 2 seeds: error of the mean deflection, the larger"),
            *mean,
            3e-4,
            2e-3,
        ));
    }
    let [coarse, middle, fine, finest] = worst_of;
    // A method of order 1 in the edge would leave 1/2 of it, one of order 2 a quarter: this one does not converge.
    claims.push(Claim::between(
        "the program's discs: largest error of the mean of 2400 and 4800 nodes over that of 600 and 1200, not falling",
        fine.1.max(finest.1) / coarse.1.max(middle.1),
        0.75,
        3.0,
    ));
    // Order 1 would leave 0.35, order 2 an eighth.
    claims.push(Claim::between(
        "the program's discs: error of the worst node of 4800 over that of 600, falling slowly",
        finest.2 / coarse.2,
        0.2,
        0.8,
    ));
    claims.push(Claim::below(
        "the program's discs of 4800 nodes: error of the worst node over the centre's deflection",
        finest.2,
        8e-3,
    ));
}

/// The same discs as membranes: these are a sheet of any Poisson ratio, and they converge.
fn membranes(claims: &mut Vec<Claim>) {
    // C of w(0) = C (p a^4/(E t))^(1/3).
    for (poisson, published) in [(0.2, 0.67744), (0.3, 0.65344), (0.4, 0.62626)] {
        let series = Series::of(poisson);
        let centre = series.deflection(0.0);
        claims.push(Claim::absolute(format!("the series: w(0) for nu = {poisson}"), centre, published, 5e-6));
        let mut off = Vec::new();
        for nodes in [300, 1200] {
            let disc = Disc::unstructured(nodes, 1, LOAD * SHEET);
            let source: MeshSource = serde_json::from_value(disc.mesh.clone()).expect("a mesh section");
            let flat = source.build(Path::new("")).expect("a sound mesh").nodes;
            let bulge = |p: &[f64; 3]| [0.0, 0.0, 0.6 * LOAD.cbrt() * (1.0 - p[0] * p[0] - p[1] * p[1])];
            let displacement: Vec<[f64; 3]> = flat.iter().map(bulge).collect();
            let rest = at_rest(&case_of(
                &json!({
                    "name": "hencky",
                    "system": {"network": {
                        "mesh": disc.mesh, "mass": disc.mass, "loads": disc.loads,
                        "membranes": [{"on": "all", "thickness": 1e-4, "modulus": 1e4 * SHEET, "poisson": poisson}],
                        "supports": [{"on": disc.pinned, "fix": "xyz"}],
                        "initial": {"displacement": displacement}
                    }},
                    "time": {"end": 1.0, "method": "backward-euler", "step": 0.01}
                }),
                &[],
            ));
            let error = |(p, flat): (&[f64; 3], &[f64; 3])| {
                (p[2] / LOAD.cbrt() - series.deflection(flat[0].hypot(flat[1]))) / centre
            };
            let errors: Vec<f64> = rest.positions.iter().zip(&flat).map(error).collect();
            let mean = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
            let top = (0..flat.len()).max_by(|&i, &j| rest.positions[i][2].total_cmp(&rest.positions[j][2]));
            off.push((mean, top.map_or(f64::NAN, |i| errors[i])));
        }
        let [(coarse, _), (fine, top)] = off[..] else { return };
        claims.push(Claim::below(
            format!("membrane of 1200 nodes, nu = {poisson}: error of the highest node"),
            top,
            1e-2,
        ));
        // Half the edge: order 2 leaves a quarter.
        claims.push(Claim::between(
            format!("membranes of 300 and 1200 nodes, nu = {poisson}: ratio of the mean errors"),
            coarse / fine,
            3.0,
            5.5,
        ));
    }
}

fn follower(claims: &mut Vec<Claim>) {
    let (lattice, load) = (Lattice::disc(24), 1e-3_f64);
    let [dead, follower] =
        [Push::Nodal, Push::Follower].map(|kind| height(&Disc::net(&lattice, load * SHEET, kind).at_rest(load)));
    // The sixths cut off at the circle do not follow: 0.8 % at this edge, falling with its square. The next order in
    // q^(2/3) = 0.01 gives 0.4 %.
    claims.push(Claim::relative(
        "pressure that follows against one that does not, q = 1e-3, edge R/24: gain of the centre's deflection over q^(2/3)",
        (follower / dead - 1.0) / load.powf(2.0 / 3.0),
        follower_gain(1.0 / 3.0),
        2e-2,
    ));
}

pub fn claims() -> Vec<Claim> {
    let (series, published) = (Series::of(1.0 / 3.0), Series::of(0.3));
    // Fichter (NASA TP-3658, 1997) tabulates b0 = 4 n(0), Campbell (1956) the deflection; to their last digit.
    let mut claims = vec![
        Claim::absolute("the series: 4 n(0) for nu = 0.3 as published", 4.0 * published.n[0], 1.7244, 5e-5),
        Claim::absolute("the series: w(0) for nu = 0.3 as published", published.deflection(0.0), 0.653, 5e-4),
    ];
    lattices(&mut claims, &series);
    unstructured(&mut claims, &series);
    membranes(&mut claims);
    follower(&mut claims);
    claims
}
