//! Contact of every kind at random states: energies are potentials, tangents are derivatives, forces of pairs balance,
//! and means over a step do exactly the work that energies lose.

use crate::common::{Random, patch, spring_group};
use canopy_fem::assembly::{MeanSystem, TangentSystem};
use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::model::spec::*;
use canopy_fem::model::state::StateRef;
use canopy_fem::model::system::{StepMean, System, Weights};
use canopy_fem::scene::{Network, Scene, build_network};
use canopy_fem_engine::contact::bodies::{Body, Contact, Contacts, Other};
use canopy_fem_engine::contact::near::{Near, Places};
use nalgebra::{Rotation3, Vector3};

const STATES: u64 = 6;
/// [m] so wide that most pairs of a mesh of 1 m touch.
const GAP: f64 = 0.6;

/// Two patches of cloth above each other and a line of three nodes beside them, all with springs.
fn two_patches() -> NetworkSpec {
    let (mut spec, above) = (patch(), patch());
    let n = spec.mesh.nodes.len() as u32;
    spec.mesh.nodes.extend(above.mesh.nodes.iter().map(|[x, y, z]| [x + 0.13, y + 0.21, z + 0.4]));
    spec.mesh.triangles.extend(above.mesh.triangles.iter().map(|t| t.map(|i| i + n)));
    spec.mesh.edges.extend(above.mesh.edges.iter().map(|e| e.map(|i| i + n)));
    spec.mesh.nodes.extend([[0.2, 0.1, 0.7], [1.1, 0.9, 0.8], [1.9, 1.8, 0.7]]);
    spec.mesh.edges.extend([[2 * n, 2 * n + 1], [2 * n + 1, 2 * n + 2]]);
    spec.mass = vec![0.3; 2 * n as usize + 3];
    spec.fixed = vec![[false; 3]; spec.mass.len()];
    spec.fixed[3] = [true; 3];
    spec.springs = vec![spring_group(&spec, Slack::None)];
    spec
}

fn all() -> ContactParts {
    let edges = two_patches().mesh.edges.len() as u32;
    ContactParts { triangles: (0..16).collect(), edges: vec![edges - 2, edges - 1], nodes: Vec::new() }
}

fn part(triangles: std::ops::Range<u32>) -> ContactParts {
    ContactParts { triangles: triangles.collect(), ..ContactParts::default() }
}

fn obstacle(shape: ObstacleShape) -> ContactSide {
    ContactSide::Obstacle(ObstacleSpec { shape, motion: None })
}

/// Every kind of contact, with a friction.
fn scenes(friction: f64) -> Vec<(&'static str, NetworkSpec)> {
    let nodes = vec![[0.0, 0.0, -0.6], [2.0, 0.2, -0.4], [0.4, 2.0, -0.5], [0.9, 0.8, -1.4]];
    let triangles = vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
    let motion = Some(Series { t: vec![0.0, 1.0], value: vec![[0.0; 3], [0.1, -0.2, 0.1]] });
    let moving = ObstacleShape::Sphere { center: [1.0, 1.0, -0.9], radius: 0.5 };
    let sides = vec![
        ("parts", part(0..8), ContactSide::Parts(part(8..16))),
        ("itself", all(), ContactSide::Itself),
        ("plane", all(), obstacle(ObstacleShape::Plane { point: [0.0, 0.0, -0.5], normal: [0.6, 0.0, 0.8] })),
        ("sphere", all(), obstacle(ObstacleShape::Sphere { center: [1.0, 1.0, -1.2], radius: 0.8 })),
        (
            "cylinder",
            all(),
            obstacle(ObstacleShape::Cylinder { from: [-0.5, 0.3, -0.7], to: [1.5, 1.2, -0.8], radius: 0.3 }),
        ),
        ("box", all(), obstacle(ObstacleShape::Box { min: [0.2, 0.3, -2.0], max: [1.5, 1.8, -0.5] })),
        ("surface", all(), obstacle(ObstacleShape::Surface { nodes, triangles })),
        ("moving sphere", all(), ContactSide::Obstacle(ObstacleSpec { shape: moving, motion })),
    ];
    let with = |(name, parts, other)| {
        let contacts = vec![ContactSpec { parts, other, gap: GAP, friction }];
        (name, NetworkSpec { contacts, ..two_patches() })
    };
    sides.into_iter().map(with).collect()
}

fn build(spec: NetworkSpec) -> Network {
    build_network(spec, Threads::one()).expect("the fixture is sound")
}

struct Sample {
    x: Vec<f64>,
    v: Vec<f64>,
}

impl Sample {
    fn new(scene: &Network, seed: u64) -> Self {
        let (mut random, mut state) = (Random(seed + 1), scene.initial_state());
        state.x.iter_mut().for_each(|x| *x += 0.06 * random.next());
        state.v.iter_mut().for_each(|v| *v = random.next());
        state.v.iter_mut().zip(scene.inverse_mass()).filter(|(_, m)| **m == 0.0).for_each(|(v, _)| *v = 0.0);
        Sample { x: state.x, v: state.v }
    }

    fn at(&self) -> StateRef<'_> {
        StateRef { t: 0.4, x: &self.x, v: &self.v }
    }
}

/// An implicit step begins at this state: friction keeps its pressures.
fn implicit(scene: &Network, at: StateRef<'_>) {
    let touches = scene.touches().expect("contact");
    touches.set_explicit(false);
    touches.begin_step(at);
}

fn total(scene: &Network, at: StateRef<'_>) -> Vec<f64> {
    let mut forces = scene.new_forces();
    scene.evaluate(at, &mut forces);
    forces.total
}

/// The derivative of `of` by x + s d and v + s e in s, where differences of two widths agree as closely as results
/// should: not across a change of the closest features, nor where edges are almost parallel.
fn slope(of: impl Fn(f64) -> Vec<f64>, close: f64) -> Vec<Option<f64>> {
    let with = |d: f64| {
        let [p1, m1, p2, m2] = [d, -d, 2.0 * d, -2.0 * d].map(&of);
        (0..p1.len()).map(move |i| (8.0 * (p1[i] - m1[i]) - (p2[i] - m2[i])) / (12.0 * d)).collect::<Vec<f64>>()
    };
    let size = |values: &[f64]| values.iter().fold(1.0, |most: f64, value| most.max(value.abs()));
    let (wide, narrow) = (with(2e-5), with(1e-5));
    let close = close * size(&narrow);
    wide.iter().zip(&narrow).map(|(wide, narrow)| ((wide - narrow).abs() < close).then_some(*narrow)).collect()
}

fn moved(sample: &Sample, way: &[f64], [by_x, by_v]: [f64; 2]) -> Sample {
    let along = |of: &[f64], by: f64| of.iter().zip(way).map(|(value, way)| value + by * way).collect();
    Sample { x: along(&sample.x, by_x), v: along(&sample.v, by_v) }
}

/// Compares, and returns how many values were smooth enough.
fn compare(name: &str, found: &[f64], expected: &[Option<f64>], tolerance: f64) -> usize {
    let size = expected.iter().flatten().fold(1.0, |most: f64, value| most.max(value.abs()));
    let pairs = found.iter().zip(expected).filter_map(|(found, expected)| Some((found, (*expected)?)));
    let mut compared = 0;
    for (found, expected) in pairs {
        assert!((found - expected).abs() < tolerance * size, "{name}: {found} for {expected} of {size}");
        compared += 1;
    }
    compared
}

#[test]
fn tangents_are_derivatives_and_energies_are_potentials() {
    for (name, spec) in scenes(0.3) {
        let scene = build(spec);
        let (mut compared, mut touching) = (0, 0);
        for seed in 0..STATES {
            let (sample, mut random) = (Sample::new(&scene, seed), Random(100 + seed));
            implicit(&scene, sample.at());
            let mut forces = scene.new_forces();
            scene.evaluate(sample.at(), &mut forces);
            touching += usize::from(forces.tallies[forces.tallies.len() - 2].energy > 0.0);
            for _ in 0..8 {
                let way: Vec<f64> =
                    scene.inverse_mass().iter().map(|m| if *m > 0.0 { random.next() } else { 0.0 }).collect();
                for (w, by) in [([0.0, 1.0], [1.0, 0.0]), ([1.0, 0.0], [0.0, 1.0])] {
                    let [c, k] = w;
                    let mut product = vec![0.0; scene.n_dof()];
                    scene.tangent_times(sample.at(), Weights { m: 0.0, c, k }, &way, &mut product);
                    let of = |s: f64| total(&scene, moved(&sample, &way, by.map(|by| s * by)).at());
                    let expected = slope(|s| of(s).into_iter().map(|f| -f).collect(), 1e-5);
                    compared += compare(name, &product, &expected, 1e-4);
                }
                let energy = |s: f64| {
                    let (sample, mut forces) = (moved(&sample, &way, [s, 0.0]), scene.new_forces());
                    scene.evaluate(sample.at(), &mut forces);
                    vec![forces.tallies.iter().map(|tally| tally.energy).sum::<f64>()]
                };
                let dissipated = &forces.dissipative;
                let stored = forces.total.iter().zip(dissipated).map(|(f, d)| f - d);
                let power: f64 = stored.zip(&way).map(|(f, way)| -f * way).sum();
                compared += compare(name, &[power], &slope(energy, 1e-7), 1e-6);
            }
        }
        assert!(compared > 4000 && touching as u64 == STATES, "{name}: {compared} compared, {touching} touch");
    }
}

/// Friction is that of the pressures at the start of a step, and so is its tangent, where pairs have parted since.
#[test]
fn friction_of_parted_pairs_has_its_tangent() {
    let (_, spec) = scenes(0.3).remove(0);
    let scene = build(spec);
    let height: Vec<f64> = scene.initial_state().x.chunks(3).map(|x| x[2]).collect();
    let mut compared = 0;
    for seed in 0..STATES {
        let (mut sample, mut random) = (Sample::new(&scene, seed), Random(300 + seed));
        implicit(&scene, sample.at());
        let upper = (0..height.len()).filter(|node| height[*node] > 0.3);
        upper.for_each(|node| sample.x[3 * node + 2] += 0.5);
        let mut forces = scene.new_forces();
        scene.evaluate(sample.at(), &mut forces);
        let [touch, rub] = [2, 1].map(|i| forces.tallies[forces.tallies.len() - i]);
        assert!(touch.energy < 1e-3 && rub.power < -0.1, "{touch:?} {rub:?}");
        let way: Vec<f64> = scene.inverse_mass().iter().map(|m| if *m > 0.0 { random.next() } else { 0.0 }).collect();
        let mut product = vec![0.0; scene.n_dof()];
        scene.tangent_times(sample.at(), Weights { m: 0.0, c: 1.0, k: 0.0 }, &way, &mut product);
        let of = |s: f64| total(&scene, moved(&sample, &way, [0.0, s]).at());
        let expected = slope(|s| of(s).into_iter().map(|f| -f).collect(), 1e-5);
        assert!(product.iter().any(|f| f.abs() > 0.1), "no tangent");
        compared += compare("parted", &product, &expected, 1e-4);
    }
    assert!(compared > 100, "{compared}");
}

/// Whatever moves, and however far: where the patches of a sheet say that only pairs that are near can touch,
/// no other pair does.
#[test]
fn pairs_that_are_kept_are_all_that_touch() {
    let n = 12_u32;
    let node = |i: u32| Vector3::new(f64::from(i % n), f64::from(i / n % n), 0.5 * f64::from(i / (n * n)));
    let cell = |i: u32| [i, i + 1, i + n + 1];
    let cells = (0..2 * n * n).filter(|i| i % n < n - 1 && i / n % n < n - 1);
    let rest: Vec<Vector3<f64>> = (0..2 * n * n).map(node).collect();
    let contacts = Contacts {
        list: vec![Contact {
            body: Body::new(cells.map(cell).collect(), Vec::new(), Vec::new()),
            other: Other::Itself,
            thickness: 0.0,
            gap: 0.3,
            friction: 0.0,
            motion: None,
        }],
        stiffness: vec![vec![1.0; rest.len()]],
        inverse_mass: vec![1.0; rest.len()],
        rest: rest.clone(),
        skin: 0.4,
        ..Contacts::default()
    };
    let shifts = [[Vector3::zeros(); 2]];
    let (mut kept, mut lost, mut touching, mut turned) = (0, 0, 0, 0);
    for seed in 0..120 {
        let (mut random, mut near) = (Random(seed + 1), Near::default());
        near.look(Places { contacts: &contacts, t: 0.0, x: &rest, shifts: &shifts }, 0.0);
        let together = Vector3::new(random.next(), random.next(), random.next()) * 20.0;
        // Every other one turns as well, by up to a radian and more, and bends.
        let turns = seed % 2 == 1;
        let (size, down) = if turns { (0.002, 0.3) } else { (0.01, 0.35) };
        let (size, down) = (size * (1 + seed % 8) as f64, down * random.next().abs());
        let axis = Vector3::new(random.next(), random.next(), random.next());
        let turn = Rotation3::new(if turns { axis } else { Vector3::zeros() });
        let bend = if turns { 0.002 * random.next() } else { 0.0 };
        let mut moved = |x: &Vector3<f64>| {
            let noise = Vector3::new(random.next(), random.next(), random.next()) * size;
            turn * (x - Vector3::z() * (2.0 * x.z * down - bend * x.x * x.x)) + together + noise
        };
        let x: Vec<Vector3<f64>> = rest.iter().map(&mut moved).collect();
        let places = Places { contacts: &contacts, t: 0.0, x: &x, shifts: &shifts };
        if !near.covers(&[places], 1.0) {
            lost += 1;
            continue;
        }
        kept += 1;
        turned += usize::from(turns && axis.norm() > 0.2);
        let mut found = Near::default();
        found.look(places, 0.0);
        for pair in found.list().iter().filter(|pair| pair.beyond <= 0.0) {
            touching += 1;
            assert!(near.close().any(|close| close.key() == pair.key()), "{seed}: {pair:?} is missing");
        }
    }
    assert!(kept > 20 && lost > 20 && touching > 50, "{kept} kept, {lost} lost, {touching} touch");
    assert!(turned > 10, "{turned} of those that are kept have turned");
}

/// Forces between parts of the scene add up to 0, and so do their moments; those of friction act a gap apart.
#[test]
fn forces_between_parts_balance() {
    for (name, spec) in scenes(0.0).into_iter().take(2) {
        let scene = build(NetworkSpec { springs: Vec::new(), fixed: vec![[false; 3]; spec.mass.len()], ..spec });
        for seed in 0..STATES {
            let sample = Sample::new(&scene, seed);
            let f = total(&scene, sample.at());
            let vectors = |of: &[f64]| of.chunks(3).map(|c| Vector3::new(c[0], c[1], c[2])).collect::<Vec<_>>();
            let (f, x) = (vectors(&f), vectors(&sample.x));
            let size: f64 = f.iter().map(Vector3::norm).sum();
            let moment: Vector3<f64> = f.iter().zip(&x).map(|(f, x)| x.cross(f)).sum();
            assert!(size > 0.1, "{name}: nothing touches");
            assert!(f.iter().sum::<Vector3<f64>>().norm() < 1e-13 * size, "{name}: force");
            assert!(moment.norm() < 1e-12 * size, "{name}: moment {moment}");
        }
    }
}

/// [s] half a step
const HALF: f64 = 0.02;

#[test]
fn means_do_the_work_of_their_energies_and_have_their_tangents() {
    let mut compared = 0;
    for (name, spec) in scenes(0.0).into_iter().take(7) {
        let scene = build(spec);
        for seed in 0..STATES {
            let (sample, mut random) = (Sample::new(&scene, seed), Random(200 + seed));
            implicit(&scene, sample.at());
            let mean = MeanSystem { system: &scene, mean: StepMean { half: HALF, dissipation: 0.0 } };
            let energy = |half: f64| {
                let (x, mut forces) = (moved(&sample, &sample.v, [half, 0.0]).x, scene.new_forces());
                scene.evaluate(StateRef { x: &x, ..sample.at() }, &mut forces);
                forces.tallies.iter().map(|tally| tally.energy).sum::<f64>()
            };
            let [begun, ended] = [-HALF, HALF].map(energy);
            let f = total_of_mean(&mean, sample.at());
            let work: f64 = f.iter().zip(&sample.v).map(|(f, v)| 2.0 * HALF * f * v).sum();
            assert!((work + ended - begun).abs() < 1e-12 * (begun + ended), "{name}: {work} J of {begun} to {ended}");
            let way: Vec<f64> =
                scene.inverse_mass().iter().map(|m| if *m > 0.0 { random.next() } else { 0.0 }).collect();
            let expected = slope(
                |s| {
                    let minus = |f: f64| -f;
                    total_of_mean(&mean, moved(&sample, &way, [s, s / HALF]).at()).into_iter().map(minus).collect()
                },
                1e-5,
            );
            compared += compare(name, &mean_times(&scene, &mean, &sample, &way), &expected, 1e-4);
        }
    }
    assert!(compared > 2000, "{compared}");
}

fn total_of_mean(mean: &MeanSystem<'_>, at: StateRef<'_>) -> Vec<f64> {
    let mut forces = mean.new_forces();
    mean.evaluate(at, &mut forces);
    forces.total
}

/// The assembled matrix of mean forces times a vector.
fn mean_times(scene: &Network, mean: &MeanSystem<'_>, sample: &Sample, way: &[f64]) -> Vec<f64> {
    let mut assembler = mean.assembler().expect("small");
    mean.assemble(sample.at(), Weights { m: 0.0, c: 1.0 / HALF, k: 1.0 }, &mut assembler);
    let (pattern, values) = (&assembler.pattern, assembler.values());
    let mut product = vec![0.0; scene.n_dof()];
    for j in 0..pattern.n() {
        let column = pattern.col_ptr[j] as usize..pattern.col_ptr[j + 1] as usize;
        for (i, value) in pattern.row_idx[column.clone()].iter().zip(&values[column]) {
            product[pattern.dof[*i as usize] as usize] += value * way[pattern.dof[j] as usize];
        }
    }
    product
}
