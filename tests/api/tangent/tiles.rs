//! Every force term on a net of several tiles: as many copies of a small scene as it takes, each of which must feel
//! what the small scene feels alone.

use super::{Sample, build, scenes::scenes};
use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::integrate::Counters;
use canopy_fem::integrate::implicit::SolverSpec;
use canopy_fem::integrate::registry::MethodChoice;
use canopy_fem::integrate::stepper::{Attempt, Stepper};
use canopy_fem::mesh::Mesh;
use canopy_fem::model::forces::{Forces, Tally};
use canopy_fem::model::point::Point;
use canopy_fem::model::spec::{
    BendingSpec, CanopySpec, GasSpec, LineDragSpec, MembraneSpec, NetworkSpec, NodalLoad, NodeDragSpec, PressureLoad,
    SpringGroup, SpringValues, SurfacePressureSpec,
};
use canopy_fem::model::state::{State, StateRef};
use canopy_fem::model::step_block::{StepSummary, Work};
use canopy_fem::model::system::System;
use canopy_fem::scene::{Network, Scene, build_network};

/// Strips have 2,048 nodes: some copies lie across the ends of strips.
const COPIES: usize = 1000;

/// Many of each thing, those of one kind together: node `i` of copy `c` is node `i COPIES + c`.
fn many<T: Clone>(things: &[T]) -> Vec<T> {
    things.iter().flat_map(|thing| vec![thing.clone(); COPIES]).collect()
}

/// The numbers of those.
fn renamed(numbers: &[u32]) -> Vec<u32> {
    numbers.iter().flat_map(|i| (0..COPIES as u32).map(move |c| i * COPIES as u32 + c)).collect()
}

fn between<const N: usize>(elements: &[[u32; N]]) -> Vec<[u32; N]> {
    let copies = 0..COPIES as u32;
    elements.iter().flat_map(|nodes| copies.clone().map(|c| nodes.map(|i| i * COPIES as u32 + c))).collect()
}

fn copied(spec: &NetworkSpec) -> NetworkSpec {
    let Mesh { nodes, edges, triangles, .. } = &spec.mesh;
    let mesh = Mesh { nodes: many(nodes), edges: between(edges), triangles: between(triangles), ..Mesh::default() };
    let springs = spec.springs.iter().map(|group| {
        let values = |values: &SpringValues| many(&values.of(group.edges.len()).collect::<Vec<_>>()).into();
        let mut dashpot = group.dashpot.clone();
        if let Some(dashpot) = &mut dashpot {
            dashpot.coefficient = values(&dashpot.coefficient);
        }
        let (stiffness, rest_length) = (values(&group.stiffness), many(&group.rest_length));
        SpringGroup { edges: renamed(&group.edges), stiffness, rest_length, dashpot, ..group.clone() }
    });
    let pressures = spec.pressures.iter().map(|p| PressureLoad { triangles: renamed(&p.triangles), ..p.clone() });
    let forces = spec.forces.iter().map(|f| NodalLoad { nodes: renamed(&f.nodes), ..f.clone() });
    // Each copy's canopy has an air speed of its own, and each gas a volume.
    let copy = |list: &[u32], c: usize| list.iter().map(|i| i * COPIES as u32 + c as u32).collect::<Vec<u32>>();
    let canopies = spec.canopies.iter().flat_map(|one| {
        (0..COPIES).map(|c| CanopySpec {
            triangles: copy(&one.triangles, c),
            pressure_coefficient: one.pressure_coefficient.clone(),
            skirt: copy(&one.skirt, c),
            apex: copy(&one.apex, c),
            confluence: copy(&one.confluence, c),
            air: one.air.clone(),
            apparent_mass: one.apparent_mass,
            inflow_loss: one.inflow_loss,
            glide: one.glide.clone(),
            nominal_area: one.nominal_area,
        })
    });
    let membranes = spec.membranes.iter().map(|m| MembraneSpec { triangles: renamed(&m.triangles), ..m.clone() });
    let bending = spec.bending.iter();
    let bending = bending.map(|b| BendingSpec { hinges: between(&b.hinges), chains: between(&b.chains), ..b.clone() });
    let gases = spec.gases.iter();
    let gases =
        gases.flat_map(|one| (0..COPIES).map(|c| GasSpec { triangles: copy(&one.triangles, c), ..one.clone() }));
    let zones = spec.surface_pressures.iter();
    let zones = zones.map(|z| SurfacePressureSpec { triangles: renamed(&z.triangles), ..z.clone() });
    let line_drag = spec.line_drag.iter().map(|d| LineDragSpec { edges: renamed(&d.edges), ..d.clone() });
    let node_drag = spec.node_drag.iter().map(|d| NodeDragSpec { nodes: renamed(&d.nodes), ..d.clone() });
    NetworkSpec {
        mesh,
        canopies: canopies.collect(),
        membranes: membranes.collect(),
        bending: bending.collect(),
        gases: gases.collect(),
        surface_pressures: zones.collect(),
        line_drag: line_drag.collect(),
        node_drag: node_drag.collect(),
        mass: many(&spec.mass),
        fixed: many(&spec.fixed),
        springs: springs.collect(),
        pressures: pressures.collect(),
        forces: forces.collect(),
        displacement: many(&spec.displacement),
        velocity: many(&spec.velocity),
        ..spec.clone()
    }
}

/// The node of the small scene that a degree of freedom belongs to, and its axis.
fn original(copies: &Network, dof: usize) -> (u32, &'static str) {
    let (node, axis) = copies.name_of(dof);
    (node / COPIES as u32, axis)
}

#[test]
fn every_copy_feels_what_one_feels_alone() {
    for (name, spec) in scenes() {
        let (one, copies) = (build(spec.clone()), build_network(copied(&spec), Threads::one()).expect("sound"));
        let sample = Sample::new(&one, 3);
        let own = |dof: usize| {
            let place = original(&copies, dof);
            (0..one.n_dof()).find(|&i| one.name_of(i) == place).expect("the same node")
        };
        let own: Vec<usize> = (0..copies.n_dof()).map(own).collect();
        let spread = |values: &[f64]| own.iter().map(|&i| values[i]).collect::<Vec<f64>>();
        let (x, v) = (spread(&sample.x), spread(&sample.v));
        let (mut expected, mut found) = (one.new_forces(), copies.new_forces());
        one.evaluate(sample.at(), &mut expected);
        copies.evaluate(StateRef { t: sample.t, x: &x, v: &v }, &mut found);
        let sums = [
            (&found.total, &expected.total),
            (&found.external, &expected.external),
            (&found.dissipative, &expected.dissipative),
        ];
        for (found, expected) in sums.into_iter().filter(|(_, expected)| !expected.is_empty()) {
            for (dof, (found, expected)) in found.iter().zip(spread(expected)).enumerate() {
                let off = (found - expected).abs();
                let place = copies.name_of(dof);
                assert!(off < 1e-11 * (1.0 + expected.abs()), "{name}: {place:?} {found}, alone {expected}");
            }
        }
        // A canopy and a gas are terms of their own in every copy; other terms have all copies.
        let (terms, pieces) = (expected.tallies.len(), found.tallies.len());
        let found = found.tallies.chunks(pieces / terms).map(|all| {
            all.iter().fold(Tally::default(), |sum, one| Tally {
                energy: sum.energy + one.energy,
                power: sum.power + one.power,
            })
        });
        for (found, expected) in found.zip(&expected.tallies) {
            for (found, expected) in [(found.energy, expected.energy), (found.power, expected.power)] {
                let expected = COPIES as f64 * expected;
                assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{name}: {found}, {expected} alone");
            }
        }
    }
}

/// Steps made several at once, in which a scene's own state stands still, feel what steps one by one feel.
#[test]
fn a_block_of_steps_feels_what_steps_feel() {
    const STEPS: usize = 5;
    for (name, spec) in scenes() {
        let scene = build(spec);
        let choice = MethodChoice::with_defaults("velocity-verlet").expect("registered");
        let mut stepper = Stepper::bind(choice.scheme(SolverSpec::default()), scene.interfaces()).expect("it fits");
        let sample = Sample::new(&scene, 3);
        let state = State { t: sample.t, x: sample.x.clone(), v: sample.v.clone() };
        let mut from = Point { state, forces: scene.new_forces() };
        scene.evaluate(from.state.as_ref(), &mut from.forces);
        let (mut to, mut summaries, h) = (from.clone(), vec![StepSummary::default(); STEPS], 1e-4);
        summaries.iter_mut().zip(1..).for_each(|(summary, step)| summary.t = sample.t + f64::from(step) * h);
        let attempt = Attempt { from: &from, h, t_next: summaries[STEPS - 1].t };
        let mut counters = Counters::default();
        assert!(stepper.advance_block(attempt, &mut to, &mut summaries, &mut counters), "{name}");
        let passes = if scene.velocity_dependent() { 2 } else { 1 };
        assert_eq!(counters.force_evaluations, passes * STEPS as u64, "{name}");
        for summary in &summaries {
            let mut next = from.clone();
            let attempt = Attempt { from: &from, h, t_next: summary.t };
            stepper.attempt(attempt, &mut next, &mut Counters::default()).expect("an easy step");
            stepper.accept();
            assert_eq!(next.forces.tallies, summary.tallies, "{name}");
            assert_eq!(scene.kinetic_energy(&next.state.v), summary.nodes.kinetic, "{name}");
            let way = [&from.state.x, &next.state.x].map(Vec::as_slice);
            let work = |f: fn(&Forces) -> &[f64]| scene.work([f(&from.forces), f(&next.forces)], way);
            let (external, dissipative) = (work(|f| &f.external), work(|f| &f.dissipative));
            assert_eq!(summary.nodes.work, Work { external, dissipative }, "{name}");
            from = next;
        }
        assert_eq!((&to.state.x, &to.state.v), (&from.state.x, &from.state.v), "{name}");
        assert_eq!(to.forces, from.forces, "{name}");
    }
}
