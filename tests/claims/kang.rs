//! Kang's scheme (thesis Eq. 55): one step against the equation written out, and its four artefacts against closed
//! forms, with kappa = h^2 k/m:
//! * gravity inside the filter falls with (1 + 2 n kappa)/(1 + n kappa)^2 of g where every node has n springs; the
//!   program keeps gravity outside and falls with g;
//! * that has its price at rest: k e/(1 + kappa) = m g, so a weight on one spring comes to rest 1 + kappa times as far
//!   down as it should;
//! * a spinning dumbbell at rest length has F = -+2 h k v, and a step leaves v + h F m/(m + h^2 k)^2 = v (1 +
//!   kappa^2)/(1 + kappa)^2;
//! * the two sweeps give a force on node i the weight w_i = [1 + kappa sum_j 1/(1 + n_j kappa)]/(1 + n_i kappa) in the
//!   total momentum. A spring between nodes of unequal weight moves the whole net by h k e (w_0 - w_1). In a chain of
//!   four stretched at its end that is h k e kappa^2/((1 + kappa)(1 + 2 kappa)^2). Weights are equal in rings, and also
//!   in stars and chains of three.

use crate::claim::Claim;
use crate::common::Random;
use crate::common::run::{Run, case_of, run};
use serde_json::{Value, json};

const STIFFNESS: f64 = 1000.0;
const MASS: f64 = 0.5;
const G: f64 = 9.81;
/// h^2 k/m from a well resolved spring to one that the step does not see at all
const KAPPAS: [f64; 4] = [0.01, 0.3, 1.0, 40.0];

/// [s] the step that makes h^2 k/m = kappa
fn step_of(kappa: f64) -> f64 {
    (kappa * MASS / STIFFNESS).sqrt()
}

/// Springs of one stiffness between free nodes; at rest where the nodes are given.
#[derive(Clone, Default)]
struct Net {
    nodes: Vec<[f64; 3]>,
    springs: Vec<[usize; 2]>,
    mass: Vec<f64>,
    displacement: Vec<[f64; 3]>,
    velocity: Vec<[f64; 3]>,
    /// [m/s^2] downwards
    gravity: f64,
    /// [1/s] Rayleigh damping by mass
    mass_damping: f64,
    /// [N] on every node
    load: [f64; 3],
}

impl Net {
    fn at_rest(nodes: Vec<[f64; 3]>, springs: Vec<[usize; 2]>) -> Self {
        let still = vec![[0.0; 3]; nodes.len()];
        let mass = vec![MASS; nodes.len()];
        Net { mass, displacement: still.clone(), velocity: still, nodes, springs, ..Net::default() }
    }

    fn chain(count: u8) -> Self {
        let nodes = (0..count).map(|i| [f64::from(i), 0.0, 0.0]).collect();
        Net::at_rest(nodes, (1..usize::from(count)).map(|i| [i - 1, i]).collect())
    }

    fn ring(count: u8) -> Self {
        let angle = |i: u8| std::f64::consts::TAU * f64::from(i) / f64::from(count);
        let nodes = (0..count).map(|i| [angle(i).cos(), angle(i).sin(), 0.0]).collect();
        Net::at_rest(nodes, (0..usize::from(count)).map(|i| [i, (i + 1) % usize::from(count)]).collect())
    }

    fn star(rays: u8) -> Self {
        let Net { nodes, .. } = Net::ring(rays);
        let springs = (1..=nodes.len()).map(|i| [0, i]).collect();
        Net::at_rest([[0.0; 3]].into_iter().chain(nodes).collect(), springs)
    }

    /// Five nodes in space, all joined but for two pairs, stretched, moving, with masses of their own.
    fn wild() -> Self {
        let mut random = Random(55);
        let nodes = (0..5).map(|_| random.vector()).collect();
        let springs = vec![[0, 1], [0, 2], [0, 3], [1, 2], [1, 4], [2, 3], [2, 4], [3, 4]];
        let mut net = Net::at_rest(nodes, springs);
        net.mass.iter_mut().for_each(|m| *m *= 1.5 + random.next());
        net.displacement.iter_mut().for_each(|u| *u = random.vector().map(|c| 0.3 * c));
        net.velocity.iter_mut().for_each(|v| *v = random.vector().map(|c| 20.0 * c));
        net
    }

    fn stretched_at_node_0(mut self, by: f64) -> Self {
        self.displacement[0][0] = by;
        self
    }

    fn after(&self, h: f64, steps: f64, dashpot: Option<Value>) -> Run {
        let mut spring = json!({"on": "all", "stiffness": STIFFNESS});
        if let Some(rule) = dashpot {
            spring["dashpot"] = rule;
        }
        let mut case = json!({
            "name": "kang",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": self.nodes, "springs": self.springs}},
                "mass": {"nodal": self.mass},
                "springs": [spring],
                "gravity": [0, 0, -self.gravity],
                "initial": {"displacement": self.displacement, "velocity": self.velocity}
            }},
            "time": {"end": steps * h, "method": "kang", "step": h}
        });
        let network = &mut case["system"]["network"];
        if self.mass_damping > 0.0 {
            network["damping"] = json!({"rayleigh": {"mass": self.mass_damping}});
        }
        if self.load != [0.0; 3] {
            network["loads"] = json!([{"on": "all", "force": self.load}]);
        }
        run(&case_of(&case, &[]))
    }

    /// Eq. 55 with k inside the sums, written out node by node: velocities after a step. What acts besides springs is
    /// part of F if `filtered`.
    fn eq55(&self, h: f64, filtered: bool) -> Vec<[f64; 3]> {
        let n = self.nodes.len();
        let x: Vec<[f64; 3]> = (0..n).map(|i| sum(self.nodes[i], self.displacement[i])).collect();
        let neighbours = |i: usize| {
            self.springs.iter().filter(move |s| s.contains(&i)).map(move |s| if s[0] == i { s[1] } else { s[0] })
        };
        let others = |i: usize| -> [f64; 3] {
            let weight = [0.0, 0.0, -self.mass[i] * self.gravity];
            std::array::from_fn(|c| weight[c] + self.load[c] - self.mass_damping * self.mass[i] * self.velocity[i][c])
        };
        let force = |i: usize| {
            let mut f = if filtered { others(i) } else { [0.0; 3] };
            for j in neighbours(i) {
                let (d, dv) = (difference(x[j], x[i]), difference(self.velocity[j], self.velocity[i]));
                let pull = STIFFNESS * (1.0 - length(difference(self.nodes[j], self.nodes[i])) / length(d));
                f = sum(f, std::array::from_fn(|c| pull * d[c] + h * STIFFNESS * dv[c]));
            }
            f
        };
        let d = |i: usize| self.mass[i] + h * h * STIFFNESS * neighbours(i).count() as f64;
        let velocity = |i: usize| {
            let from_neighbours = |c: usize| neighbours(i).map(|j| STIFFNESS * h * force(j)[c] / d(j)).sum::<f64>();
            let outside = if filtered { [0.0; 3] } else { others(i) };
            std::array::from_fn(|c| {
                let dv = (force(i)[c] * h + h * h * from_neighbours(c)) / d(i);
                self.velocity[i][c] + dv + h * outside[c] / self.mass[i]
            })
        };
        (0..n).map(velocity).collect()
    }
}

fn sum(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| a[c] + b[c])
}

fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| a[c] - b[c])
}

fn length(a: [f64; 3]) -> f64 {
    a.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// One step of the program against Eq. 55 written out.
fn the_step(claims: &mut Vec<Claim>) {
    let net = Net { gravity: G, ..Net::wild() };
    let load = [30.0, -70.0, 110.0];
    // Below 1/h of the longest step: beyond 2/h the drag would turn velocities over, and the run would end.
    let damped = Net { mass_damping: 5.0, ..net.clone() };
    let nets = [
        ("", net.clone()),
        (", loads", Net { load, ..net }),
        (", damped by mass", damped.clone()),
        (", damped by mass, loads", Net { load, ..damped }),
    ];
    for (what, net) in nets {
        steps_of(claims, what, &net);
    }
}

fn steps_of(claims: &mut Vec<Claim>, acts: &str, net: &Net) {
    let fastest = net.velocity.iter().map(|v| length(*v)).fold(0.0, f64::max);
    for kappa in KAPPAS {
        let h = step_of(kappa);
        let by_hand = net.eq55(h, false);
        // A few tens of roundings of the fastest velocity. A dashpot's part comes to kappa times that and is taken out
        // again.
        let mut compare = |what: &str, dashpot: Option<Value>| {
            let cancelled = if dashpot.is_some() { kappa } else { 0.0 };
            let run = net.after(h, 1.0, dashpot);
            let off = run.velocities.iter().zip(&by_hand).map(|(a, b)| length(difference(*a, *b))).fold(0.0, f64::max);
            claims.push(Claim::below(
                format!("a net in motion{acts}, kappa {kappa}{what}: velocities off from Eq. 55 over the fastest"),
                off / fastest,
                2e-15 * (1.0 + cancelled),
            ));
        };
        compare("", None);
        // Without the rule that this dashpot is F's own viscous part, the difference would be of the order of 1.
        compare(", \"step\" dashpots", Some(json!({"relative": "step"})));
    }
}

fn gravity(claims: &mut Vec<Claim>) {
    for (name, valence, net) in [("dumbbell", 1.0, Net::chain(2)), ("ring of 6", 2.0, Net::ring(6))] {
        let net = Net { gravity: G, ..net };
        for kappa in KAPPAS {
            let h = step_of(kappa);
            let steps = 50.0;
            let run = net.after(h, steps, None);
            // One rounding of the velocity a step, and springs at rest only but for the rounding of positions.
            let off = run.velocities.iter().map(|v| (v[2] / (-G * h * steps) - 1.0).abs()).fold(0.0, f64::max);
            claims.push(Claim::below(
                format!("{name} falls with g, kappa {kappa}: worst share of g t lost in 50 steps"),
                off,
                5e-15,
            ));
            let filtered = net.eq55(h, true)[0][2] / (-G * h);
            let formula = (1.0 + 2.0 * valence * kappa) / (1.0 + valence * kappa).powi(2);
            claims.push(Claim::relative(
                format!("for information, Eq. 55 as printed: it filters gravity, {name}, kappa {kappa}, share of g"),
                filtered,
                formula,
                2e-15,
            ));
        }
    }
}

/// A damped weight on one spring, long after it has come to rest.
fn weight(claims: &mut Vec<Claim>) {
    // Beyond 1 the weight sinks so far that the first law stops the run.
    for kappa in KAPPAS.into_iter().filter(|kappa| *kappa <= 1.0) {
        let h = step_of(kappa);
        let case = json!({
            "name": "weight",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": [[0, 0, 0], [0, 0, -1]], "springs": [[0, 1]], "triangles": []}},
                "mass": {"nodal": MASS},
                "springs": [{"on": "all", "stiffness": STIFFNESS}],
                "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
                "gravity": [0, 0, -G]
            }},
            "time": {"end": 8000.0 * h, "method": "kang", "step": h}
        });
        let sunk = -1.0 - run(&case_of(&case, &[])).positions[1][2];
        claims.push(Claim::relative(
            format!("weight at rest on a spring, kappa {kappa}: deflection over m g/k"),
            sunk * STIFFNESS / (MASS * G),
            1.0 + kappa,
            1e-9,
        ));
    }
}

fn dumbbell(claims: &mut Vec<Claim>) {
    let mut net = Net::chain(2);
    let speed = 3.0;
    net.velocity = vec![[0.0, speed, 0.0], [0.0, -speed, 0.0]];
    for kappa in KAPPAS {
        let run = net.after(step_of(kappa), 1.0, None);
        let formula = (1.0 + kappa * kappa) / (1.0 + kappa).powi(2);
        claims.push(Claim::relative(
            format!("spinning dumbbell, kappa {kappa}: share of the speed that a step leaves"),
            run.velocities[0][1] / speed,
            formula,
            1e-15,
        ));
    }
}

/// Total momentum that one step makes out of nothing, over h k e.
fn momentum(claims: &mut Vec<Claim>) {
    let stretch = 0.1;
    for kappa in KAPPAS {
        let h = step_of(kappa);
        let made = |net: Net| {
            let run = net.stretched_at_node_0(-stretch).after(h, 1.0, None);
            let total: f64 = run.velocities.iter().map(|v| MASS * v[0]).sum();
            total / (h * STIFFNESS * stretch)
        };
        // Forces are differences of coordinates near 1 over a stretch of 0.1: ten roundings, times a few operations.
        let rounding = 5e-15;
        claims.push(Claim::absolute(
            format!("chain of 4 (springs a node: 1 2 2 1), kappa {kappa}: momentum made in a step over h k e"),
            made(Net::chain(4)),
            kappa * kappa / ((1.0 + kappa) * (1.0 + 2.0 * kappa).powi(2)),
            rounding,
        ));
        for (name, net) in
            [("ring of 6", Net::ring(6)), ("chain of 3", Net::chain(3)), ("star of 5 rays", Net::star(5))]
        {
            claims.push(Claim::below(
                format!("{name}, kappa {kappa}: momentum made in a step over h k e"),
                made(net),
                rounding,
            ));
        }
    }
}

pub fn claims() -> Vec<Claim> {
    let mut claims = Vec::new();
    the_step(&mut claims);
    gravity(&mut claims);
    weight(&mut claims);
    dumbbell(&mut claims);
    momentum(&mut claims);
    claims
}
