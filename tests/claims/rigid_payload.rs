//! A rigid payload, free in space: four particles of a quarter of its mass with its moments of inertia, held by six
//! stiff bars. It turns as Euler's equations say; near its middle axis it turns over again and again (L. D. Landau and
//! E. M. Lifshitz, Mechanics, section 37). With I1 < I2 < I3, M^2 > 2 E I2 and w2 = 0 at the start:
//!
//! ```text
//! w1 = w1(0) cn(s),   w2 = -w1(0) sqrt(I1 (I3 - I1)/(I2 (I3 - I2))) sn(s),   w3 = w3(0) dn(s)
//! s = t sqrt((I3 - I2)(M^2 - 2 E I1)/(I1 I2 I3)),   k^2 = (I2 - I1)(2 E I3 - M^2)/((I3 - I2)(M^2 - 2 E I1))
//! ```
//! It turns over every 2 K(k) of s.

use crate::claim::Claim;
use crate::common::run::{case_of, follow};
use canopy_fem::case::spec::SystemSpec;
use canopy_fem::drive::Status;
use nalgebra::{Matrix3, Vector3};
use serde_json::{Value, json};
use std::f64::consts::FRAC_PI_2;

type Vector = Vector3<f64>;

/// [kg]
const MASS: f64 = 100.0;
/// [m] radii of gyration about x, y and z: the largest moment of inertia is about x, the least about z
const RADII: [f64; 3] = [0.5, 0.4, 0.35];
/// [rad/s] at the start
const TURN: [f64; 3] = [2.0, 0.0, 4.3];
/// [-] signs of the particles' places along x, y and z
const CORNERS: [[f64; 3]; 4] = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
/// [m] from the confluence to its centre
const BELOW: f64 = 1.0;
/// [N/m] of the bars; the pull of the particles stretches them by some 1e-5 of their length
const STIFFNESS: f64 = 1e8;
/// [-] nodes of the canopy and its lines, which rest without forces and come before the particles
const OTHERS: usize = 5;

/// Jacobi's sn, cn and dn of `s` for the modulus k with complementary modulus `other` = sqrt(1 - k^2), by the
/// arithmetic-geometric mean (Abramowitz and Stegun 16.4), and K(k).
fn jacobi(s: f64, other: f64) -> ([f64; 3], f64) {
    let (mut a, mut g) = (1.0, other);
    let mut ratios = Vec::new();
    while a - g > 1e-15 * a {
        let c = 0.5 * (a - g);
        (a, g) = (0.5 * (a + g), (a * g).sqrt());
        ratios.push(c / a);
    }
    let mut phi = a * s * 2.0_f64.powi(ratios.len() as i32);
    for ratio in ratios.iter().rev() {
        phi = 0.5 * (phi + (ratio * phi.sin()).asin());
    }
    let (sin, cos) = phi.sin_cos();
    ([sin, cos, (cos * cos + other * other * sin * sin).sqrt()], FRAC_PI_2 / a)
}

/// What Euler's equations say.
struct Theory {
    /// [kg m^2] about z, y and x: from the least
    inertia: [f64; 3],
    /// [1/s] ds/dt
    rate: f64,
    /// [-] sqrt(1 - k^2)
    other: f64,
}

impl Theory {
    fn new() -> Self {
        let [i3, i2, i1] = RADII.map(|k| MASS * k * k);
        let [w3, _, w1] = TURN;
        let (twice_energy, square) = (i1 * w1 * w1 + i3 * w3 * w3, (i1 * w1).powi(2) + (i3 * w3).powi(2));
        let rate = ((i3 - i2) * (square - twice_energy * i1) / (i1 * i2 * i3)).sqrt();
        let modulus = (i2 - i1) * (twice_energy * i3 - square) / ((i3 - i2) * (square - twice_energy * i1));
        Theory { inertia: [i1, i2, i3], rate, other: (1.0 - modulus).sqrt() }
    }

    /// [s] between two turns over
    fn half_period(&self) -> f64 {
        2.0 * jacobi(0.0, self.other).1 / self.rate
    }

    /// [kg m^2/s] angular momentum about the body's x, y and z
    fn momentum(&self, t: f64) -> Vector {
        let [i1, i2, i3] = self.inertia;
        let [sn, cn, dn] = jacobi(self.rate * t, self.other).0;
        let [w3, _, w1] = TURN;
        let across = -w1 * (i1 * (i3 - i1) / (i2 * (i3 - i2))).sqrt();
        Vector::new(i3 * w3 * dn, i2 * across * sn, i1 * w1 * cn)
    }
}

/// [m] distances of the particles from the centre along x, y and z
fn half_axes() -> [f64; 3] {
    let [x, y, z] = RADII.map(|k| k * k);
    [y + z - x, z + x - y, x + y - z].map(|sum| (0.5 * sum).sqrt())
}

/// How a payload is run.
#[derive(Clone, Copy)]
struct Run {
    method: &'static str,
    /// [s]
    step: f64,
    /// [N/m] of the bars
    stiffness: f64,
}

fn case(Run { method, step, stiffness }: Run, end: f64) -> Value {
    let turned = CORNERS.map(|signs| {
        let place = Vector::from(signs).component_mul(&Vector::from(half_axes()));
        <[f64; 3]>::from(Vector::from(TURN).cross(&place))
    });
    let velocity = [vec![[0.0; 3]; OTHERS], turned.to_vec()].concat();
    json!({
        "name": "payload",
        "system": {"network": {
            "mesh": {"parachute": {
                "type": "flat-circular", "nominal_diameter": 2.0, "gores": 3, "radial_segments": 1,
                "lines": {"length": 3.0}, "payload": {"radii_of_gyration": RADII, "below_riser": BELOW}
            }},
            "mass": {"areal_density": 0.05, "points": [
                {"on": {"group": "payload"}, "total": MASS}, {"on": {"group": "confluence"}, "mass": 1.0}
            ]},
            "springs": [{"on": {"group": "payload-bars"}, "stiffness": stiffness}],
            "initial": {"velocity": velocity}
        }},
        "time": {"end": end, "method": method, "step": step}
    })
}

/// What a run shows.
#[derive(Default)]
struct Seen {
    /// [s] when the angular momentum about the body's y axis changes its sign
    turns: Vec<f64>,
    /// [-] largest change of the angular momentum and of the energy over what they are, and the largest distance of the
    /// angular momentum in the body from theory
    off: [f64; 3],
}

impl Seen {
    /// [s] mean time between two turns over
    fn half_period(&self) -> f64 {
        match self.turns.as_slice() {
            [first, .., last] => (last - first) / (self.turns.len() - 1) as f64,
            _ => f64::NAN,
        }
    }
}

fn seen(run: Run, theory: &Theory) -> Seen {
    let axes = half_axes();
    let mut seen = Seen::default();
    let mut start: Option<(Vector, f64)> = None;
    let mut last = [0.0; 2];
    let outcome = follow(&case_of(&case(run, 4.2 * theory.half_period()), &[]), |now| {
        let [places, velocities] =
            [now.positions, now.velocities].map(|list| [0, 1, 2, 3].map(|i| Vector::from(list[OTHERS + i])));
        let centre = places.iter().sum::<Vector>() / 4.0;
        let momentum: Vector = places.iter().zip(&velocities).map(|(x, v)| 0.25 * MASS * (x - centre).cross(v)).sum();
        let energy = now.ledger.kinetic + now.ledger.elastic;
        let (first, present) = *start.get_or_insert((momentum, energy));
        let body = Vector::from([0, 1, 2].map(|c| {
            let axis: Vector = places.iter().zip(CORNERS).map(|(x, signs)| signs[c] * x).sum();
            momentum.dot(&axis) / (4.0 * axes[c])
        }));
        let off = [
            (momentum - first).norm() / first.norm(),
            (energy / present - 1.0).abs(),
            (body - theory.momentum(now.t)).norm() / first.norm(),
        ];
        seen.off.iter_mut().zip(off).for_each(|(most, off)| *most = most.max(off));
        if last[1] * body.y < 0.0 {
            seen.turns.push(last[0] + (now.t - last[0]) * last[1] / (last[1] - body.y));
        }
        last = [now.t, body.y];
    });
    assert_eq!(outcome.status, Status::Completed, "{}", run.method);
    seen
}

pub fn claims() -> Vec<Claim> {
    let theory = Theory::new();
    let mut claims = inertia();
    let stiff = Run { method: "velocity-verlet", step: 1e-4, stiffness: STIFFNESS };
    let verlet = seen(stiff, &theory);
    let [momentum, energy, path] = verlet.off;
    claims.push(Claim::below("velocity-verlet: angular momentum lost, a share of it", momentum, 1e-9));
    claims.push(Claim::below("velocity-verlet: energy off, a share of it", energy, 1e-7));
    claims.push(Claim::below("velocity-verlet: distance from Jacobi's functions over the momentum", path, 1e-3));
    // The particles begin at rest in the bars and swing about their stretched places. The scheme keeps an energy that
    // differs from theirs by the square of the step.
    let finer = seen(Run { step: 5e-5, ..stiff }, &theory);
    let order = (energy / finer.off[1]).log2();
    claims.push(Claim::between("velocity-verlet: order of the energy's error", order, 1.7, 2.3));
    // Bars stretch as the inverse of their stiffness, and with them the moments of inertia grow.
    let soft = seen(Run { step: 2e-4, stiffness: 0.1 * STIFFNESS, ..stiff }, &theory);
    let late = |seen: &Seen| seen.half_period() / theory.half_period() - 1.0;
    claims.push(Claim::between(
        "period late with bars a tenth as stiff, times",
        late(&soft) / late(&verlet),
        9.0,
        11.0,
    ));
    let others = [("rk4", 1e-4, [1e-9, 2e-6]), ("newmark", 1e-3, [2e-5, 4e-5])];
    let others = others.map(|(method, step, bounds)| (method, seen(Run { method, step, ..stiff }, &theory), bounds));
    for (method, seen, [kept, lost]) in &others {
        claims.push(Claim::below(format!("{method}: angular momentum lost, a share of it"), seen.off[0], *kept));
        claims.push(Claim::below(format!("{method}: energy off, a share of it"), seen.off[1], *lost));
    }
    let all = others.iter().map(|(method, seen, _)| (*method, seen)).chain([("velocity-verlet", &verlet)]);
    for (method, seen) in all {
        claims.push(Claim::absolute(format!("{method}: turns over in 15.7 s"), seen.turns.len() as f64, 4.0, 0.0));
        let what = format!("{method}: time between two turns over [s]");
        claims.push(Claim::relative(what, seen.half_period(), theory.half_period(), 5e-5));
    }
    claims
}

/// The particles that the generator makes: their centre and their tensor of inertia about it.
fn inertia() -> Vec<Claim> {
    let case = case_of(&case(Run { method: "rk4", step: 1.0, stiffness: STIFFNESS }, 1.0), &[]);
    let SystemSpec::Network(network) = &case.problem().system else { panic!("a network") };
    let particles = &network.mesh.groups["payload"].nodes;
    let of = |node: &u32| (network.mass[*node as usize], Vector::from(network.mesh.nodes[*node as usize]));
    let mass: f64 = particles.iter().map(|node| of(node).0).sum();
    let centre = particles.iter().map(|node| of(node).0 * of(node).1).sum::<Vector>() / mass;
    let confluence = network.mesh.nodes[OTHERS - 1];
    let tensor: Matrix3<f64> = particles
        .iter()
        .map(|node| {
            let (m, x) = (of(node).0, of(node).1 - centre);
            m * (x.norm_squared() * Matrix3::identity() - x * x.transpose())
        })
        .sum();
    let expected = Matrix3::from_diagonal(&Vector::from(RADII.map(|k| MASS * k * k)));
    let off = centre - Vector::from(confluence) + BELOW * Vector::z();
    vec![
        Claim::relative("mass of the particles [kg]", mass, MASS, 1e-14),
        Claim::below("their centre off its place [m]", off.norm(), 1e-14),
        Claim::below(
            "their tensor of inertia off its own, a share",
            (tensor - expected).norm() / expected.norm(),
            1e-14,
        ),
    ]
}
