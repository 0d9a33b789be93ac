//! What a scheme carries: saved, restored, and untouched by steps that are dropped.

use canopy_fem::force::batch::Threads;
use canopy_fem::integrate::Carried;
use canopy_fem::model::point::Point;
use canopy_fem::model::spec::*;
use canopy_fem::scene::{Network, build_network};

use crate::bench::{Walk, cases};
use crate::common::{patch, spring_group};

/// A sheet with every kind of term that a tangent or a carried vector could go wrong on.
fn sheet() -> Network {
    let mut spec = patch();
    let mut group = spring_group(&spec, Slack::TensionOnly);
    let coefficient = vec![0.5; group.edges.len()];
    group.dashpot = Some(DashpotSpec { kind: DashpotKind::Axial, coefficient, from_step: false });
    spec.springs = vec![group];
    spec.gravity = Some([0.0, 0.0, -9.81]);
    let wind = Series { t: vec![0.0, 1.0], value: vec![[0.0, 0.5, 5.0], [1.0, 0.0, 9.0]] };
    spec.air = Some(AirSpec { linear: 0.8, quadratic: 0.2, wind });
    spec.rayleigh = Some(RayleighSpec { mass: 0.1, stiffness: 1e-3 });
    build_network(spec, Threads::one()).expect("the fixture is sound")
}

/// What a scheme saves is all it needs: a new stepper that starts at the saved point and takes the saved vectors over goes on
/// with the same bits.
#[test]
fn a_restored_scheme_goes_on_with_the_same_bits() {
    let scene = sheet();
    for case in cases() {
        let mut whole = Walk::start(&case, &scene);
        (0..10).for_each(|_| whole.step(2e-3));
        let (carried, point): (Carried, Point) = (whole.stepper.save(), whole.from.clone());
        let mut second = Walk::from_point(&case, &scene, point);
        second.stepper.restore(&carried).expect("it fits");
        for step in 0..10 {
            whole.step(2e-3);
            second.step(2e-3);
            assert!(whole.bits() == second.bits(), "{}: step {step} after the restart differs", case.name());
        }
    }
}

/// Vectors of another scene or scheme are refused, not taken over.
#[test]
fn a_foreign_saved_state_is_refused() {
    let scene = sheet();
    for case in cases() {
        let mut walk = Walk::start(&case, &scene);
        let mut carried = walk.stepper.save();
        carried.vectors.push(vec![1.0; 3]);
        assert!(walk.stepper.restore(&carried).is_err(), "{} took a vector too many", case.name());
        let mut carried = walk.stepper.save();
        if let Some(first) = carried.vectors.first_mut() {
            first.pop();
            assert!(walk.stepper.restore(&carried).is_err(), "{} took a vector that is too short", case.name());
        }
    }
}

/// Rejecting a step is not accepting it: attempts that are dropped leave no trace in what follows.
#[test]
fn a_dropped_attempt_leaves_no_trace() {
    let scene = sheet();
    for case in cases() {
        let (mut plain, mut hesitant) = (Walk::start(&case, &scene), Walk::start(&case, &scene));
        for step in 0..12 {
            hesitant.attempt(7e-3);
            hesitant.attempt(5e-4);
            plain.step(2e-3);
            hesitant.step(2e-3);
            assert!(plain.bits() == hesitant.bits(), "{}: step {step} differs", case.name());
        }
    }
}
