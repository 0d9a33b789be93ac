//! Springs that have broken are as if they had never been: in forces, tangents, and all that is shown of them.

use super::scenes::scenes;
use super::{Sample, build};
use crate::common::{spring_group, square};
use canopy_fem::assembly::{MeanSystem, TangentSystem};
use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::model::abilities::{Events, Springs};
use canopy_fem::model::observables::Observables;
use canopy_fem::model::spec::*;
use canopy_fem::model::spring_state::SpringState;
use canopy_fem::model::system::{SpringGraph, StepMean, System, Weights};
use canopy_fem::scene::{Network, Scene, build_network};

/// Strength of springs [N] that break only where the test says so.
const STRENGTH: f64 = 1e9;

/// A scene whose springs can all break, and the same without those that `broken` names.
fn both(spec: &NetworkSpec, broken: impl Fn(usize) -> bool) -> [NetworkSpec; 2] {
    let (mut torn, mut without) = (spec.clone(), spec.clone());
    for group in &mut torn.springs {
        group.breaks = vec![STRENGTH; group.edges.len()];
    }
    for group in &mut without.springs {
        let kept: Vec<usize> = (0..group.edges.len()).filter(|&i| !broken(i)).collect();
        let pick = |values: &SpringValues| kept.iter().filter_map(|&i| values.get(i)).collect();
        *group = SpringGroup {
            edges: kept.iter().map(|&i| group.edges[i]).collect(),
            stiffness: pick(&group.stiffness),
            rest_length: kept.iter().map(|&i| group.rest_length[i]).collect(),
            dashpot: group.dashpot.as_ref().map(|d| DashpotSpec { coefficient: pick(&d.coefficient), ..d.clone() }),
            ..group.clone()
        };
    }
    [torn, without]
}

/// Breaks springs, by their places in their group.
fn tear(scene: &Network, springs: usize, broken: impl Fn(usize) -> bool) -> bool {
    let when = |i| if broken(i) { [0.1, 0.0] } else { [f64::INFINITY, 0.0] };
    let happened: Vec<[f64; 2]> = (0..springs).map(when).collect();
    scene.set_happened(&happened)
}

/// All that springs have a part in, at a state.
fn seen(scene: &Network, sample: &Sample) -> Vec<(&'static str, Vec<f64>)> {
    let (at, n) = (sample.at(), scene.n_dof());
    let mut forces = scene.new_forces();
    scene.evaluate(at, &mut forces);
    let energy = forces.tallies.iter().map(|tally| tally.energy).sum();
    let mut list = vec![("forces", forces.total.clone()), ("energy", vec![energy])];
    list.push(("damping forces", forces.dissipative.clone()));
    let mean = MeanSystem { system: scene, mean: StepMean { half: 0.01, dissipation: 0.2 } };
    mean.evaluate(at, &mut forces);
    list.push(("mean forces", forces.total));
    let p: Vec<f64> = (0..n).map(|i| (0.7 * i as f64).sin()).collect();
    let mut y = vec![0.0; n];
    for (name, w) in [("K", [1.0, 0.0]), ("C", [0.0, 1.0])] {
        scene.tangent_times(at, Weights { m: 0.0, k: w[0], c: w[1] }, &p, &mut y);
        list.push((name, y.clone()));
    }
    if let Some(products) = scene.tangent_products(at) {
        products.times(Weights { m: 0.0, k: 1.0, c: 0.3 }, &p, &mut y);
        list.push(("prepared products", y.clone()));
    }
    list.push(("stiffness at nodes", scene.nodal_stiffness()));
    list.push(("stiffness sums", scene.stiffness_sums()));
    scene.neighbour_sums(&p, 0..n, &mut y);
    list.push(("sums over neighbours", y.clone()));
    scene.neighbour_differences(&p, 0..n, &mut y);
    list.push(("differences to neighbours", y.clone()));
    scene.step_dashpots(&p, 0..n, &mut y);
    list.push(("dashpots in the filter", y.clone()));
    if let Some(mut filter) = scene.step_filter() {
        filter.select(at, 1e-3);
        filter.neighbour_sums(&p, 0..n, &mut y);
        list.push(("filter without slack springs", y.clone()));
    }
    list.push(("largest strain", vec![scene.max_strain(at)]));
    let bound = scene.sharper_rate_bound(at, Weights { m: 0.0, k: 1.0, c: 0.0 });
    list.push(("bound", vec![bound.value]));
    list
}

/// Tension and strain of every edge, with dashpots.
fn tensions(scene: &Network, sample: &Sample) -> [Vec<f64>; 2] {
    let [mut tension, mut strain] = [0; 2].map(|_| vec![0.0; scene.edges().len()]);
    scene.edge_tension(sample.at(), &mut tension, &mut strain);
    scene.add_axial_damping(sample.at(), &mut tension);
    [tension, strain]
}

/// The springs of the mixed iteration and those of schemes that go from spring to spring, by their edges' nodes.
fn springs_of(scene: &Network, sample: &Sample) -> [Vec<([u32; 2], f64)>; 2] {
    let mixed = scene.mixed().expect("springs");
    let mut states = vec![SpringState::idle([0; 2]); mixed.springs()];
    mixed.measure(sample.at(), 3.0, &mut states);
    let mixed = states.iter().map(|s| (s.nodes, s.tension)).collect();
    let mut links = Vec::new();
    if let Ok(all) = scene.links() {
        let mut found = vec![canopy_fem::model::links::Link::NONE; all.count()];
        all.at(sample.t, &mut found);
        links = found.iter().map(|link| (link.nodes, link.stiffness)).collect();
    }
    [mixed, links].map(|mut list: Vec<([u32; 2], f64)>| {
        list.retain(|(_, number)| *number != 0.0);
        list.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        list
    })
}

fn same(name: &str, torn: &Network, without: &Network, sample: &Sample) {
    for ((what, found), (_, expected)) in seen(torn, sample).into_iter().zip(seen(without, sample)) {
        let largest = expected.iter().fold(1e-6, |most: f64, y| most.max(y.abs()));
        for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
            let off = (found - expected).abs();
            assert!(off <= 1e-12 * largest, "{name}, {what}[{i}]: {found}, and {expected} where they never were");
        }
    }
    assert_eq!(springs_of(torn, sample), springs_of(without, sample), "{name}");
    let [[tension, strain], [expected, expected_strain]] = [torn, without].map(|scene| tensions(scene, sample));
    for edge in 0..tension.len() {
        let (is, was) = ([tension[edge], strain[edge]], [expected[edge], expected_strain[edge]]);
        if was[0].is_nan() {
            // An edge without a spring, and one whose spring has broken.
            assert!(is[0] == 0.0 && is[1].is_nan(), "{name}, edge {edge}: {is:?}");
        } else {
            assert!((is[0] - was[0]).abs() <= 1e-12 * (1.0 + was[0].abs()), "{name}, edge {edge}: {is:?} {was:?}");
            assert_eq!(is[1], was[1], "{name}, edge {edge}");
        }
    }
    let whole = |scene: &Network| {
        let mut edges = scene.whole_edges();
        edges.sort_unstable();
        edges
    };
    assert_eq!(whole(torn), whole(without), "{name}");
}

#[test]
fn broken_springs_are_as_if_they_had_never_been() {
    let mut compared = 0;
    for (name, spec) in scenes().into_iter().filter(|(_, spec)| !spec.springs.is_empty()) {
        let springs = spec.springs[0].edges.len();
        let some: [&dyn Fn(usize) -> bool; 3] = [&|i| i == 5, &|i| i % 3 == 0, &|i| i % 7 != 2];
        for broken in some {
            let [torn, without] = both(&spec, broken).map(build);
            let sample = Sample::new(&torn, 3);
            let before = seen(&torn, &sample);
            assert!(tear(&torn, springs, broken), "{name}: the scene is another one");
            assert!(!tear(&torn, springs, broken), "{name}: and the same after it");
            same(name, &torn, &without, &sample);
            assert!(tear(&torn, springs, |_| false));
            assert_eq!(seen(&torn, &sample), before, "{name}: whole again");
            compared += 1;
        }
    }
    assert!(compared > 60, "{compared}");
}

/// A net of several blocks, so that springs are in stars: a spring that can break is no force of its own, and any
/// number of threads gives the same bits.
#[test]
fn a_torn_net_has_the_terms_of_a_whole_one() {
    let mut spec = square(70, 1e-3);
    spec.fixed[0] = [true; 3];
    let broken = |i: usize| i % 11 == 3 || (4000..4100).contains(&i);
    for kind in [None, Some(DashpotKind::Axial), Some(DashpotKind::Relative)] {
        let mut springs = spring_group(&spec, Slack::TensionOnly);
        springs.dashpot = kind.map(|kind| DashpotSpec { kind, coefficient: 1e-3.into(), from_step: false });
        let count = springs.edges.len();
        spec.springs = vec![springs];
        let [torn, without] = both(&spec, broken);
        let scenes = [1, 2].map(|threads| {
            let scene = build_network(torn.clone(), Threads::new(threads).expect("threads")).expect("sound");
            tear(&scene, count, broken);
            scene
        });
        let without = build(without);
        assert_eq!(scenes[0].terms().len(), without.terms().len());
        let sample = Sample::new(&without, 5);
        same("a net", &scenes[0], &without, &sample);
        assert_eq!(seen(&scenes[0], &sample), seen(&scenes[1], &sample), "threads change bits");
    }
}
