//! Every force term against finite differences, at random states, slack and compressed springs included; and its energy
//! or power against its force; and what its information says against its forces. A failure names the term, the state
//! and the bad entry.

mod means;
mod scenes;
mod tiles;
mod torn;

use crate::common::{Random, spring_group, square};
use canopy_fem::assembly::{Assembler, TangentSystem};
use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::model::abilities::Events;
use canopy_fem::model::forces::Role;
use canopy_fem::model::spec::*;
use canopy_fem::model::state::StateRef;
use canopy_fem::model::system::{System, Weights};
use canopy_fem::scene::{Network, Scene, build_network};
use nalgebra::{Rotation3, Vector3};
use scenes::{scenes, uneven_scenes};

const STATES: u64 = 12;

struct Sample {
    t: f64,
    x: Vec<f64>,
    v: Vec<f64>,
}

impl Sample {
    fn new(scene: &Network, seed: u64) -> Self {
        let mut random = Random(seed);
        let mut state = scene.initial_state();
        // Up to 0.3 m off a mesh of 1 m: stretched, slack and compressed springs, tilted triangles.
        state.x.iter_mut().for_each(|x| *x += 0.3 * random.next());
        state.v.iter_mut().for_each(|v| *v = 2.0 * random.next());
        Sample { t: 0.5 + 0.4 * random.next(), x: state.x, v: state.v }
    }

    fn at(&self) -> StateRef<'_> {
        StateRef { t: self.t, x: &self.x, v: &self.v }
    }
}

fn force(scene: &Network, at: StateRef<'_>) -> Vec<f64> {
    let mut forces = scene.new_forces();
    scene.evaluate(at, &mut forces);
    forces.total
}

fn build(spec: NetworkSpec) -> Network {
    build_network(spec, Threads::one()).expect("the fixture is sound")
}

/// Fourth-order central difference of -f along one degree of freedom of x (or of v).
fn minus_slope(scene: &Network, sample: &Sample, dof: usize, of_velocity: bool) -> Vec<f64> {
    let d = 2e-4;
    let shifted = |s: f64| {
        let (mut x, mut v) = (sample.x.clone(), sample.v.clone());
        if of_velocity {
            v[dof] += s * d
        } else {
            x[dof] += s * d
        }
        force(scene, StateRef { t: sample.t, x: &x, v: &v })
    };
    let (p1, m1, p2, m2) = (shifted(1.0), shifted(-1.0), shifted(2.0), shifted(-2.0));
    (0..p1.len()).map(|i| -(8.0 * (p1[i] - m1[i]) - (p2[i] - m2[i])) / (12.0 * d)).collect()
}

#[test]
fn every_tangent_equals_its_finite_difference() {
    let mut compared = 0;
    for (name, spec) in scenes().into_iter().chain(uneven_scenes()) {
        let scene = build(spec);
        for seed in 0..STATES {
            let sample = Sample::new(&scene, seed);
            compared += compare(name, &scene, &sample, seed);
        }
    }
    assert!(compared > 100_000, "only {compared} entries were compared");
}

/// Springs of one of two groups are cut, and a support lets go: before and after.
#[test]
fn tangents_before_and_after_events() {
    let mut spec = scenes().into_iter().find(|(name, _)| *name == "reeled, tension-only").expect("listed").1;
    let all = spec.springs[0].clone();
    let some = |group: &SpringGroup, first: bool| {
        let keep: Vec<usize> = (0..group.edges.len()).filter(|i| (i % 3 == 0) == first).collect();
        let pick = |values: &SpringValues| keep.iter().filter_map(|&i| values.get(i)).collect();
        let dashpot = group.dashpot.as_ref().map(|d| DashpotSpec { coefficient: pick(&d.coefficient), ..d.clone() });
        SpringGroup {
            edges: keep.iter().map(|&i| group.edges[i]).collect(),
            stiffness: pick(&group.stiffness),
            rest_length: keep.iter().map(|&i| group.rest_length[i]).collect(),
            dashpot,
            ..group.clone()
        }
    };
    spec.springs = vec![some(&all, true), some(&all, false)];
    spec.rayleigh = Some(RayleighSpec { mass: 0.0, stiffness: 0.02 });
    spec.springs[0].cut = Some(0.3);
    spec.releases = vec![ReleaseSpec { t: 0.4, nodes: vec![(0, [true, false, true])], ..ReleaseSpec::default() }];
    let scene = build(spec);
    let mut products = Vec::new();
    for passed in 0..=2 {
        scene.pass_events(passed);
        let free = scene.inverse_mass().iter().filter(|m| **m > 0.0).count();
        for seed in 0..4 {
            let sample = Sample::new(&scene, seed);
            compare(&format!("after {passed} events"), &scene, &sample, seed);
            let p: Vec<f64> = (0..scene.n_dof()).map(|i| (0.7 * i as f64).sin()).collect();
            let mut y = vec![0.0; scene.n_dof()];
            // Rayleigh damping acts along slack springs too.
            scene.tangent_times(sample.at(), Weights { m: 0.0, c: 1.0, k: 1.0 }, &p, &mut y);
            products.push((free, y));
        }
    }
    assert_eq!([0, 4, 8].map(|i| products[i].0), [23, 23, 25], "two directions become free");
    assert!((0..4).all(|seed| products[seed].1 != products[4 + seed].1), "the cut changes the tangent");
    scene.pass_events(0);
}

/// What is prepared for many products gives those of the elements, with one element or another that is not stored, and
/// with sections of elements that have nodes in common: then with the same bits on any number of threads.
#[test]
fn prepared_products_are_those_of_the_elements() {
    let weights = [[1.0, 0.0], [0.0, 1.0], [1.7, 0.3]].map(|[k, c]| Weights { m: 0.0, c, k });
    let check = |name: &str, scene: &Network, sample: &Sample| {
        let products = scene.tangent_products(sample.at())?;
        let p: Vec<f64> = (0..scene.n_dof()).map(|i| (0.7 * i as f64).sin()).collect();
        let [mut y, mut expected] = [0; 2].map(|_| vec![0.0; scene.n_dof()]);
        let mut bits = Vec::new();
        // Twice, as sums are kept from product to product.
        for w in weights.into_iter().chain(weights) {
            products.times(w, &p, &mut y);
            scene.tangent_times(sample.at(), w, &p, &mut expected);
            let largest = expected.iter().fold(0.0, |most: f64, y| most.max(y.abs()));
            assert!(y.iter().all(|y| y.is_finite()), "{name}, {w:?}");
            let off = y.iter().zip(&expected).fold(0.0, |most: f64, (y, e)| most.max((y - e).abs()));
            assert!(off <= 1e-12 * largest, "{name}, {w:?}: off by {off} of {largest}");
            bits.extend(y.iter().map(|y| y.to_bits()));
        }
        Some(bits)
    };
    let mut prepared = 0;
    for (name, spec) in scenes().into_iter().chain(uneven_scenes()) {
        let scene = build(spec);
        prepared += usize::from(check(name, &scene, &Sample::new(&scene, 3)).is_some());
    }
    assert!(prepared > 10, "{prepared} scenes have springs alone or among others");
    let mut spec = square(120, 1e-3);
    spec.fixed[0] = [true; 3];
    let mut springs = spring_group(&spec, Slack::TensionOnly);
    springs.dashpot = Some(DashpotSpec { kind: DashpotKind::Relative, coefficient: 1e-3.into(), from_step: false });
    spec.springs = vec![springs];
    let bits = [1, 2, 3].map(|threads| {
        let scene = build_network(spec.clone(), Threads::new(threads).expect("threads")).expect("sound");
        check("a net", &scene, &Sample::new(&scene, 3)).expect("springs")
    });
    assert!(bits[0] == bits[1] && bits[0] == bits[2], "threads change bits");
}

fn compare(name: &str, scene: &Network, sample: &Sample, seed: u64) -> usize {
    let n = scene.n_dof();
    let mut product = vec![0.0; n];
    let free: Vec<bool> = scene.inverse_mass().iter().map(|m| *m > 0.0).collect();
    let mut compared = 0;
    for (of_velocity, w) in [(false, Weights { m: 0.0, c: 0.0, k: 1.0 }), (true, Weights { m: 0.0, c: 1.0, k: 0.0 })] {
        let matrix = if of_velocity { "-df/dv" } else { "-df/dx" };
        for j in (0..n).filter(|&j| free[j]) {
            let mut unit = vec![0.0; n];
            unit[j] = 1.0;
            scene.tangent_times(sample.at(), w, &unit, &mut product);
            let expected = minus_slope(scene, sample, j, of_velocity);
            for i in (0..n).filter(|&i| free[i]) {
                let scale = 1.0 + expected[i].abs();
                let error = (product[i] - expected[i]).abs() / scale;
                // A kink of the force inside the difference stencil spoils the difference, not the tangent.
                if error > 1e-6 && kink_nearby(scene, sample, j) {
                    continue;
                }
                assert!(
                    error < 1e-6,
                    "{name}, state {seed}: {matrix}[{:?}, {:?}] is {} by its formula and {} by differences",
                    scene.name_of(i),
                    scene.name_of(j),
                    product[i],
                    expected[i]
                );
                compared += 1;
            }
        }
    }
    compared
}

/// Whether the tangent itself changes by a jump across the difference stencil in direction `j`.
fn kink_nearby(scene: &Network, sample: &Sample, j: usize) -> bool {
    let w = Weights { m: 0.0, c: 0.3, k: 1.0 };
    let product = |shift_x: f64, shift_v: f64| {
        let (mut x, mut v) = (sample.x.clone(), sample.v.clone());
        x[j] += shift_x;
        v[j] += shift_v;
        let mut out = vec![0.0; x.len()];
        let ones: Vec<f64> = (0..x.len()).map(|i| (i as f64 * 0.7).sin()).collect();
        scene.tangent_times(StateRef { t: sample.t, x: &x, v: &v }, w, &ones, &mut out);
        out
    };
    let jump = |a: Vec<f64>, b: Vec<f64>| a.iter().zip(&b).any(|(a, b)| (a - b).abs() > 0.5);
    jump(product(-4e-4, 0.0), product(4e-4, 0.0)) || jump(product(0.0, -4e-4), product(0.0, 4e-4))
}

#[test]
fn the_assembled_matrix_is_the_one_the_terms_emit() {
    for (name, spec) in scenes() {
        let scene = build(spec);
        let mut assembler = scene.assembler().expect("small");
        for seed in 0..3 {
            let sample = Sample::new(&scene, seed);
            let w = Weights { m: 2.0, c: 0.3, k: 1.7 };
            scene.assemble(sample.at(), w, &mut assembler);
            let pattern = assembler.pattern.clone();
            let (mut y, mut expected) = (vec![0.0; pattern.n()], vec![0.0; scene.n_dof()]);
            for j in 0..pattern.n() {
                let (mut unit, mut full) = (vec![0.0; pattern.n()], vec![0.0; scene.n_dof()]);
                unit[j] = 1.0;
                full[pattern.dof[j] as usize] = 1.0;
                pattern.multiply(assembler.values(), &unit, &mut y);
                scene.tangent_times(sample.at(), w, &full, &mut expected);
                // The matrix leaves out what couples the whole scene.
                for which in 0..scene.rank_ones() {
                    let (mut u, mut g) = (vec![0.0; scene.n_dof()], vec![0.0; scene.n_dof()]);
                    scene.rank_one(which, sample.at(), w, &mut u, &mut g);
                    let amount: f64 = g.iter().zip(&full).map(|(g, full)| g * full).sum();
                    expected.iter_mut().zip(u).for_each(|(y, u)| *y -= amount * u);
                }
                for (i, &dof) in pattern.dof.iter().enumerate() {
                    let mass = if i == j { w.m / scene.inverse_mass()[dof as usize] } else { 0.0 };
                    let value = expected[dof as usize] + mass;
                    assert!(
                        (y[i] - value).abs() <= 1e-12 * (1.0 + value.abs()),
                        "{name}: W[{i}, {j}] {} {value}",
                        y[i]
                    );
                }
            }
        }
    }
}

/// W of a scene as its symmetric assembler has it.
fn symmetric_matrix(scene: &Network, sample: &Sample, w: Weights, convex: bool) -> Vec<Vec<f64>> {
    let mut assembler = scene.symmetric_assembler().expect("small").expect("a network");
    assert!(assembler.pattern.symmetric);
    scene.assemble_symmetric(sample.at(), w, convex, &mut assembler);
    columns(&assembler)
}

/// W, both triangles, unknown by unknown.
fn columns(assembler: &Assembler) -> Vec<Vec<f64>> {
    let n = assembler.pattern.n();
    let column = |j: usize| {
        let (mut unit, mut y) = (vec![0.0; n], vec![0.0; n]);
        unit[j] = 1.0;
        assembler.pattern.multiply(assembler.values(), &unit, &mut y);
        y
    };
    (0..n).map(column).collect()
}

/// What a factor is made of that is kept: the exact W of terms with a symmetric one; the exact C of the air, which is
/// symmetric; and where it is asked to be convex, nothing that any motion could gain energy from.
#[test]
fn symmetric_tangents_are_symmetric_and_near() {
    let mut random = Random(7);
    for (name, spec) in scenes() {
        let scene = build(spec);
        let exact = |sample: &Sample, w: Weights| -> Vec<Vec<f64>> {
            let mut assembler = scene.assembler().expect("small");
            scene.assemble(sample.at(), w, &mut assembler);
            columns(&assembler)
        };
        for seed in 0..3 {
            let sample = Sample::new(&scene, seed);
            let w = Weights { m: 0.0, c: 0.4, k: 1.3 };
            let damping = Weights { m: 0.0, c: 1.0, k: 0.0 };
            // The damping is symmetric but for that of a lift, of which the symmetric form has nothing.
            let lifted = name.starts_with("gliding");
            let pairs = [(w, scene.symmetric()), (damping, !lifted)];
            for (w, _) in pairs.into_iter().filter(|(_, same)| *same) {
                let (found, expected) = (symmetric_matrix(&scene, &sample, w, false), exact(&sample, w));
                for (j, (found, expected)) in found.iter().zip(&expected).enumerate() {
                    for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
                        let off = (found - expected).abs();
                        assert!(off <= 1e-10 * (1.0 + expected.abs()), "{name}: W[{i}, {j}] {found}, exact {expected}");
                    }
                }
            }
            let convex = symmetric_matrix(&scene, &sample, w, true);
            for _ in 0..50 {
                let p: Vec<f64> = convex.iter().map(|_| random.next()).collect();
                let product =
                    convex.iter().zip(&p).map(|(row, a)| a * row.iter().zip(&p).map(|(w, b)| w * b).sum::<f64>());
                let energy: f64 = product.sum();
                assert!(energy >= -1e-9, "{name}: p.W p = {energy}");
            }
        }
    }
}

#[test]
fn symmetry_is_declared_truthfully() {
    for (name, spec) in scenes() {
        let scene = build(spec);
        let mut largest: f64 = 0.0;
        for seed in 0..STATES {
            let sample = Sample::new(&scene, seed);
            let (n, w) = (scene.n_dof(), Weights { m: 0.0, c: 0.5, k: 1.0 });
            let mut k = vec![vec![0.0; n]; n];
            for (j, column) in k.iter_mut().enumerate().filter(|(j, _)| scene.inverse_mass()[*j] > 0.0) {
                let mut unit = vec![0.0; n];
                unit[j] = 1.0;
                scene.tangent_times(sample.at(), w, &unit, column);
            }
            for (i, row) in k.iter().enumerate() {
                for (entry, column) in row.iter().zip(&k).take(i) {
                    largest = largest.max((entry - column[i]).abs());
                }
            }
        }
        assert_eq!(scene.symmetric(), largest < 1e-9, "{name}: largest difference {largest}");
    }
}

#[test]
fn energies_are_potentials_and_powers_are_force_times_velocity() {
    for (name, spec) in scenes() {
        let scene = build(spec);
        for seed in 0..STATES {
            let sample = Sample::new(&scene, seed);
            let mut forces = scene.new_forces();
            scene.evaluate(sample.at(), &mut forces);
            let role = |r: Role| scene.terms().iter().zip(&forces.tallies).filter(move |(i, _)| i.role == r);
            let dot = |f: &[f64]| f.iter().zip(&sample.v).map(|(f, v)| f * v).sum::<f64>();
            for (r, f) in [(Role::External, &forces.external), (Role::Dissipative, &forces.dissipative)] {
                let power: f64 = role(r).map(|(_, t)| t.power).sum();
                assert!((power - dot(f)).abs() < 1e-10 * (1.0 + power.abs()), "{name}: {r:?} power {power}");
                if r == Role::Dissipative {
                    assert!(power <= 0.0, "{name}: a dissipative term gave {power} W");
                }
            }
            conservative_power_is_minus_the_rate_of_energy(name, &scene, &sample);
        }
    }
}

fn conservative_power_is_minus_the_rate_of_energy(name: &str, scene: &Network, sample: &Sample) {
    let stored = |s: f64| {
        let x: Vec<f64> = sample.x.iter().zip(&sample.v).map(|(x, v)| x + s * v).collect();
        let mut forces = scene.new_forces();
        scene.evaluate(StateRef { t: sample.t, x: &x, v: &sample.v }, &mut forces);
        (forces.tallies.iter().map(|t| t.energy).sum::<f64>(), forces)
    };
    let d = 1e-5;
    let (plus, _) = stored(d);
    let (minus, _) = stored(-d);
    let (_, forces) = stored(0.0);
    let rest =
        |i: usize| forces.external.get(i).copied().unwrap_or(0.0) + forces.dissipative.get(i).copied().unwrap_or(0.0);
    // Fixed degrees of freedom move in this virtual motion, so their reactions belong to the forces.
    let mut total = forces.total.clone();
    let fixed = (0..total.len()).filter(|&i| scene.inverse_mass()[i] == 0.0).collect::<Vec<_>>();
    for (&dof, r) in fixed.iter().zip(&forces.reactions) {
        total[dof] = -r;
    }
    let weightless = |i: usize| scene.terms().iter().any(|t| t.role == Role::Gravity) && fixed.contains(&i);
    let power: f64 = (0..total.len()).filter(|&i| !weightless(i)).map(|i| (total[i] - rest(i)) * sample.v[i]).sum();
    let rate = (plus - minus) / (2.0 * d);
    if scene.terms().iter().any(|t| t.role == Role::Gravity) {
        return gravity_energy(name, scene, sample);
    }
    assert!((rate + power).abs() < 2e-3 * (1.0 + power.abs()), "{name}: energy rate {rate}, power {power}");
}

/// Gravity: nodes held in all directions carry no weight; the others lose m g . u.
fn gravity_energy(name: &str, scene: &Network, sample: &Sample) {
    let (mut forces, start) = (scene.new_forces(), scene.initial_state());
    scene.evaluate(sample.at(), &mut forces);
    let mut f = vec![Vector3::zeros(); scene.n_dof() / 3];
    f.iter_mut().zip(forces.total.chunks(3)).for_each(|(f, t)| *f = Vector3::from_column_slice(t));
    for (&dof, r) in
        (0..scene.n_dof()).filter(|&i| scene.inverse_mass()[i] == 0.0).collect::<Vec<_>>().iter().zip(&forces.reactions)
    {
        f[dof / 3][dof % 3] = -r;
    }
    let work: f64 = f
        .iter()
        .zip(sample.x.chunks(3).zip(start.x.chunks(3)))
        .map(|(f, (x, o))| f.dot(&(Vector3::from_column_slice(x) - Vector3::from_column_slice(o))))
        .sum();
    let energy: f64 = forces.tallies.iter().map(|t| t.energy).sum();
    assert!((energy + work).abs() < 1e-12 * (1.0 + work.abs()), "{name}: {energy} {work}");
}

/// C of a scene whose terms all say that theirs is constant is the same at any two states.
#[test]
fn constant_damping_is_declared_truthfully() {
    let mut constant = 0;
    for (name, spec) in scenes() {
        let scene = build(spec);
        let mut damping = scene.terms().iter().filter(|info| info.velocity_dependent).peekable();
        let declared = damping.peek().is_some() && damping.all(|info| info.constant_damping);
        let of = |seed| {
            let mut assembler = scene.assembler().unwrap();
            scene.assemble(Sample::new(&scene, seed).at(), Weights { m: 0.0, c: 1.0, k: 0.0 }, &mut assembler);
            assembler.values().to_vec()
        };
        constant += usize::from(declared);
        assert!(!declared || (1..STATES).all(|seed| of(seed) == of(0)), "{name}: C changes with the state");
    }
    assert!(constant > 0);
}

/// What diagnoses ask of a term is what its forces do. A term that says nothing of itself would be missing from them in
/// silence.
#[test]
fn terms_are_what_they_say() {
    for (name, spec) in scenes() {
        let on_triangles = spec.air.is_some()
            || !spec.pressures.is_empty()
            || !spec.canopies.is_empty()
            || !spec.membranes.is_empty()
            || !spec.surface_pressures.is_empty()
            || !spec.gases.is_empty();
        let scene = build(spec);
        assert_eq!(scene.terms().iter().any(|t| t.on_triangles), on_triangles, "{name}: on_triangles");
        for (i, info) in scene.terms().iter().enumerate() {
            let (mut follows_velocity, mut turns) = (false, false);
            for seed in 0..STATES {
                let Sample { t, x, v } = Sample::new(&scene, seed);
                let [other, turned] = [v.iter().map(|v| 1.0 - v).collect(), turned(&x)];
                let [here, moving, there] = [(&x, &v), (&x, &other), (&turned, &v)].map(|(x, v)| {
                    let mut f = vec![0.0; scene.n_dof()];
                    scene.term_alone(i, StateRef { t, x, v }, &mut f).map(|_| f)
                });
                follows_velocity |= moving != here;
                turns |= info.role == Role::External && there != here;
            }
            assert_eq!(info.velocity_dependent, follows_velocity, "{name}, {}: velocity_dependent", info.name);
            assert_eq!(info.follower, turns, "{name}, {}: follower", info.name);
        }
    }
}

/// Diagnoses and the floor of rounding go by it: at rest no diagonal entry of an elastic K is above the stiffness that
/// is told.
#[test]
fn the_stiffness_of_nodes_is_that_of_their_springs() {
    let mut elastic = 0;
    for (name, spec) in scenes() {
        let scene = build(spec);
        if scene.terms().iter().all(|term| term.role != Role::Elastic) {
            continue;
        }
        elastic += 1;
        let (start, told) = (scene.initial_state(), scene.nodal_stiffness());
        for dof in (0..scene.n_dof()).filter(|&dof| scene.inverse_mass()[dof] > 0.0) {
            let (mut unit, mut product) = (vec![0.0; scene.n_dof()], vec![0.0; scene.n_dof()]);
            unit[dof] = 1.0;
            scene.tangent_times(start.as_ref(), Weights { m: 0.0, c: 0.0, k: 1.0 }, &unit, &mut product);
            let (place, found) = (scene.name_of(dof), product[dof]);
            assert!(found <= told[dof] * (1.0 + 1e-12), "{name}: K of {place:?} is {found}, told {}", told[dof]);
        }
    }
    assert!(elastic >= 4, "{elastic}");
}

/// A net turned as a whole about an axis that is none of it.
fn turned(x: &[f64]) -> Vec<f64> {
    let turn = Rotation3::new(Vector3::new(0.4, -0.7, 0.2));
    x.chunks(3).flat_map(|p| <[f64; 3]>::from(turn * Vector3::from_column_slice(p))).collect()
}
