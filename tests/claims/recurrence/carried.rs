//! What a scheme carries: saved, restored, and untouched by steps that are dropped.

use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::integrate::CarriedState;
use canopy_fem::model::point::Point;
use canopy_fem::model::spec::*;
use canopy_fem::scene::{Network, build_network};

use super::bench::{Case, Walk, cases};
use crate::claim::Claim;
use crate::common::{patch, spring_group};

/// A sheet with every kind of term that a tangent or a carried vector could go wrong on.
fn sheet() -> Network {
    let mut spec = patch();
    let mut group = spring_group(&spec, Slack::TensionOnly);
    group.dashpot = Some(DashpotSpec { kind: DashpotKind::Axial, coefficient: 0.5.into(), from_step: false });
    spec.springs = vec![group];
    spec.gravity = Some([0.0, 0.0, -9.81]);
    let wind = Series { t: vec![0.0, 1.0], value: vec![[0.0, 0.5, 5.0], [1.0, 0.0, 9.0]] };
    spec.air = Some(AirSpec { linear: 0.8, quadratic: 0.2, wind });
    spec.rayleigh = Some(RayleighSpec { mass: 0.1, stiffness: 1e-3 });
    build_network(spec, Threads::one()).expect("the fixture is sound")
}

pub fn claims() -> Vec<Claim> {
    let scene = sheet();
    let none = |what: &str, check: fn(&Case, &Network) -> usize| {
        let counts = cases().into_iter().map(|case| (case.name(), check(&case, &scene)));
        let (mut total, mut offenders) = (0, String::new());
        for (name, count) in counts.filter(|(_, count)| *count > 0) {
            total += count;
            offenders += &format!(" ({name}: {count})");
        }
        Claim::absolute(format!("all methods: {what}{offenders}"), total as f64, 0.0, 0.0)
    };
    vec![
        none("steps with other bits after a restart from what is saved", restarted),
        none("saved vectors too many or too short for the scene, accepted instead of refused", foreign),
        none("steps with other bits after attempts that were dropped", dropped),
    ]
}

/// What a scheme saves is all it needs: a new stepper that starts at the saved point and takes the saved vectors over
/// goes on with the same bits.
fn restarted(case: &Case, scene: &Network) -> usize {
    let mut whole = Walk::start(case, scene);
    (0..10).for_each(|_| whole.step(2e-3));
    let (carried, point): (CarriedState, Point) = (whole.stepper.save(), whole.from.clone());
    let mut second = Walk::from_point(case, scene, point);
    second.stepper.restore(&carried).expect("it fits");
    let mut step = || {
        whole.step(2e-3);
        second.step(2e-3);
        whole.bits() != second.bits()
    };
    (0..10).filter(|_| step()).count()
}

/// Vectors that another scene or scheme has saved are refused, not taken over.
fn foreign(case: &Case, scene: &Network) -> usize {
    let mut walk = Walk::start(case, scene);
    let mut too_many = walk.stepper.save();
    too_many.vectors.push(vec![1.0; 3]);
    let mut too_short = walk.stepper.save();
    // A scheme that carries nothing has nothing that could be too short.
    let shortened = too_short.vectors.first_mut().is_some_and(|v| v.pop().is_some());
    let mut taken = |carried: &CarriedState| walk.stepper.restore(carried).is_ok();
    usize::from(taken(&too_many)) + usize::from(shortened && taken(&too_short))
}

/// Rejecting a step is not accepting it: attempts that are dropped leave no trace in what follows.
fn dropped(case: &Case, scene: &Network) -> usize {
    let (mut plain, mut hesitant) = (Walk::start(case, scene), Walk::start(case, scene));
    let mut step = || {
        hesitant.attempt(7e-3);
        hesitant.attempt(5e-4);
        plain.step(2e-3);
        hesitant.step(2e-3);
        plain.bits() != hesitant.bits()
    };
    (0..12).filter(|_| step()).count()
}
