//! The heavy elastica: a line of the length L, the weight w per length and the flexural rigidity B, clamped level at
//! one end, B theta'' = -w (L - s) cos(theta), theta(0) = 0, theta'(L) = 0. Its chord falls at 41.5 degrees at
//! w L^3/B = 8.004, which is how the stiffness of cloth is measured (Peirce 1930; ASTM D 1388).
//!
//! Lines are bent at their nodes, cloth in its triangles. What is held begins one edge before the clamp. A sheet
//! without contraction across (Poisson's ratio 0) hangs as the line at every width.
//!
//! A clamped disc under the load q per area sags by q a^4/(64 B) in its middle, whatever Poisson's ratio is.

use crate::claim::Claim;
use crate::common::Random;
use crate::common::run::{at_rest, case_of};
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// [N/m] weight
const W: f64 = 2.0;

/// w L^3/B
const LOADS: [f64; 4] = [1.0, 5.0, 10.0, 50.0];

/// w L^3/B of a chord at 41.5 degrees
const CHORD: f64 = 8.0042;

fn case(network: Value) -> Value {
    json!({
        "name": "elastica",
        "system": {"network": network},
        "time": {"end": 1.0, "method": "newmark", "step": 0.01},
        "solver": {"newton": {"relative": 1e-10}}
    })
}

/// [-] The tip over L, level and below: the curvature at the clamp is the one for which that at the tip is 0.
fn elastica(load: f64) -> [f64; 2] {
    const STEPS: usize = 1000;
    let h = 1.0 / STEPS as f64;
    // theta, its slope, and the place, by the classical Runge-Kutta method.
    let slopes = |s: f64, y: [f64; 4]| [y[1], -load * (1.0 - s) * y[0].cos(), y[0].cos(), y[0].sin()];
    let end = |curvature: f64| {
        (0..STEPS).fold([0.0, curvature, 0.0, 0.0], |y: [f64; 4], i| {
            let s = h * i as f64;
            let ahead = |k: [f64; 4], by: f64| [0, 1, 2, 3].map(|c| y[c] + by * k[c]);
            let one = slopes(s, y);
            let two = slopes(s + 0.5 * h, ahead(one, 0.5 * h));
            let three = slopes(s + 0.5 * h, ahead(two, 0.5 * h));
            let four = slopes(s + h, ahead(three, h));
            [0, 1, 2, 3].map(|c| y[c] + h / 6.0 * (one[c] + 2.0 * two[c] + 2.0 * three[c] + four[c]))
        })
    };
    // The whole moment at the clamp, w L^2/2, is too much.
    let (mut low, mut high) = (0.0, 0.5 * load);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if end(middle)[1] < 0.0 { low = middle } else { high = middle }
    }
    let [_, _, x, below] = end(low);
    [x, below]
}

/// The tip of a line of so many free edges, over L.
fn line(edges: usize, load: f64, law: &str) -> [f64; 2] {
    let h = 1.0 / edges as f64;
    let nodes: Vec<[f64; 3]> = (0..edges + 2).map(|i| [h * (i as f64 - 1.0), 0.0, 0.0]).collect();
    let springs: Vec<[usize; 2]> = (0..=edges).map(|i| [i, i + 1]).collect();
    let rest = at_rest(&case_of(
        &case(json!({
            "mesh": {"explicit": {"nodes": nodes, "springs": springs}},
            "springs": [{"on": "all", "axial_rigidity": 1e6 * W, "law": law, "linear_density": W}],
            "bending": [{"on": "all", "flexural_rigidity": W / load}],
            "supports": [{"on": {"ids": [0, 1]}, "fix": "xyz"}],
            "gravity": [0, 0, -1.0]
        })),
        &[],
    ));
    let [x, _, z] = rest.positions[edges + 1];
    [x, -z]
}

/// How squares are cut to triangles, and whether nodes inside are moved.
#[derive(Clone, Copy, Debug)]
enum Pattern {
    OneWay,
    OtherWay,
    Alternating,
    /// cut one way, nodes moved by up to 0.15 of an edge along x and y
    Disturbed,
}

/// A strip of the length 1 beyond its clamp, so many cells long and wide, and one column of cells that is held.
struct Strip {
    nodes: Vec<[f64; 3]>,
    triangles: Vec<[usize; 3]>,
    held: Vec<usize>,
    tip: Vec<usize>,
}

impl Strip {
    fn new(pattern: Pattern, [cells, across]: [usize; 2]) -> Self {
        let (h, side) = (1.0 / cells as f64, cells + 2);
        let mut random = Random(7);
        let node = |n: usize| {
            let (i, j) = (n % side, n / side);
            let inside = matches!(pattern, Pattern::Disturbed) && i > 1 && i + 1 < side && j > 0 && j < across;
            let moved = [0, 1].map(|_| if inside { 0.15 * random.next() } else { 0.0 });
            [h * (i as f64 - 1.0 + moved[0]), h * (j as f64 + moved[1]), 0.0]
        };
        let nodes: Vec<[f64; 3]> = (0..side * (across + 1)).map(node).collect();
        let cell = |c: usize| {
            let (i, j) = (c % (side - 1), c / (side - 1));
            let a = i + side * j;
            let [b, c, d] = [a + 1, a + side + 1, a + side];
            match pattern {
                Pattern::OtherWay => [[a, b, d], [b, c, d]],
                Pattern::Alternating if (i + j) % 2 == 1 => [[a, b, d], [b, c, d]],
                _ => [[a, b, c], [a, c, d]],
            }
        };
        let triangles = (0..(side - 1) * across).flat_map(cell).collect();
        let at = |column: usize| (0..nodes.len()).filter(move |n| n % side == column);
        let (held, tip) = (at(0).chain(at(1)).collect(), at(side - 1).collect());
        Strip { nodes, triangles, held, tip }
    }

    /// The mean of the free end, over L.
    fn hang(&self, load: f64) -> [f64; 2] {
        let rest = at_rest(&case_of(
            &case(json!({
                "mesh": {"explicit": {"nodes": self.nodes, "triangles": self.triangles}},
                "mass": {"areal_density": W},
                "membranes": [{"on": "all", "thickness": 1e-3, "modulus": 2e7 * W, "poisson": 0.0}],
                "bending": [{"on": "all", "stiffness": W / load}],
                "supports": [{"on": {"ids": self.held}, "fix": "xyz"}],
                "gravity": [0, 0, -1.0]
            })),
            &[],
        ));
        let mean = |axis: usize| {
            let sum: f64 = self.tip.iter().map(|&n| rest.positions[n][axis]).sum();
            sum / self.tip.len() as f64
        };
        [mean(0), -mean(2)]
    }
}

fn off(found: [f64; 2], expected: [f64; 2]) -> f64 {
    (found[0] - expected[0]).hypot(found[1] - expected[1])
}

fn lines(claims: &mut Vec<Claim>) {
    for load in LOADS {
        for law in ["linear", "green"] {
            let what = format!("line of 100 edges, {law}, w L^3/B = {load}: tip off over L");
            claims.push(Claim::below(what, off(line(100, load, law), elastica(load)), 1e-3));
        }
    }
    let tip = elastica(10.0);
    let order = (off(line(25, 10.0, "green"), tip) / off(line(50, 10.0, "green"), tip)).log2();
    claims.push(Claim::absolute("line, 25 and 50 edges: order of the tip's error", order, 2.0, 0.2));
    let [x, z] = line(100, CHORD, "green");
    claims.push(Claim::absolute(
        "line, w L^3/B = 8.0042: fall of the chord [degrees]",
        z.atan2(x).to_degrees(),
        41.5,
        0.0415,
    ));
}

/// The sag of the tip is compared, on three meshes each.
fn strips(claims: &mut Vec<Claim>) {
    for pattern in [Pattern::OneWay, Pattern::OtherWay, Pattern::Alternating] {
        for (width, load) in [(10, 5.0), (3, 5.0), (10, 50.0)] {
            let tip = elastica(load);
            let errors =
                [10, 20, 40].map(|cells| off(Strip::new(pattern, [cells, (cells / width).max(1)]).hang(load), tip));
            let what = format!("strip of cloth, {pattern:?}, 1/{width} wide, w L^3/B = {load}");
            claims.push(Claim::below(format!("{what}, 40 cells: tip off over L"), errors[2], 2e-3));
            let order = 0.5 * (errors[0] / errors[2]).log2();
            claims.push(Claim::between(format!("{what}, 10, 20, 40 cells: order"), order, 1.5, 2.6));
        }
    }
    for cells in [10, 20, 40] {
        // Too stiff by a percent, on finer meshes too.
        let error = off(Strip::new(Pattern::Disturbed, [cells, cells / 5]).hang(5.0), elastica(5.0));
        let what = format!("strip of cloth, {:?}, {cells} cells: tip off over L", Pattern::Disturbed);
        claims.push(Claim::below(what, error, 2e-2));
    }
}

/// [-] The sag in the middle of a clamped disc over q a^4/(64 B), on so many rings, each of which has six nodes more
/// than the one inside; one more is held.
fn disc(rings: usize) -> f64 {
    let of_ring = |i: usize| (6 * i).max(1);
    let start = |i: usize| (0..i).map(of_ring).sum::<usize>();
    let number = |i: usize, k: usize| start(i) + k % of_ring(i);
    let place = |i: usize, k: usize| {
        let (r, angle) = (i as f64 / rings as f64, TAU * k as f64 / of_ring(i) as f64);
        [r * angle.cos(), r * angle.sin(), 0.0]
    };
    let nodes: Vec<[f64; 3]> = (0..rings + 2).flat_map(|i| (0..of_ring(i)).map(move |k| place(i, k))).collect();
    let mut triangles = Vec::new();
    for (i, sector) in (0..=rings).flat_map(|i| (0..6).map(move |sector| (i, sector))) {
        let (inner, outer) = (sector * i, sector * (i + 1));
        triangles
            .extend((0..=i).map(|j| [number(i, inner + j), number(i + 1, outer + j), number(i + 1, outer + j + 1)]));
        let inwards = |j: usize| [number(i, inner + j), number(i + 1, outer + j + 1), number(i, inner + j + 1)];
        triangles.extend((0..i).map(inwards));
    }
    let held: Vec<usize> = (start(rings)..nodes.len()).collect();
    let (rigidity, load) = (2.0, 1e-3);
    let rest = at_rest(&case_of(
        &case(json!({
            "mesh": {"explicit": {"nodes": nodes, "triangles": triangles}},
            "mass": {"areal_density": 1.0},
            "bending": [{"on": "all", "stiffness": rigidity}],
            "supports": [{"on": "all", "fix": "xy"}, {"on": {"ids": held}, "fix": "z"}],
            "gravity": [0, 0, -load]
        })),
        &[],
    ));
    -rest.positions[0][2] / (load / (64.0 * rigidity))
}

fn discs(claims: &mut Vec<Claim>) {
    let errors = [8, 16].map(|rings| disc(rings) - 1.0);
    claims.push(Claim::between("clamped disc, 16 rings: sag over q a^4/(64 B), less 1", errors[1], 0.0, 7e-3));
    let order = (errors[0] / errors[1]).log2();
    claims.push(Claim::absolute("clamped disc, 8 and 16 rings: order of the sag", order, 2.0, 0.2));
}

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    lines(&mut claims);
    strips(&mut claims);
    discs(&mut claims);
    claims
}
