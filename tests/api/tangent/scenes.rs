//! The list of terms.

use crate::common::{patch, spring_group};
use canopy_fem::model::spec::*;

fn with_dashpots(slack: Slack, kind: DashpotKind) -> NetworkSpec {
    let mut spec = patch();
    let mut group = spring_group(&spec, slack);
    let coefficient = (0..group.edges.len()).map(|i| 5.0 + i as f64).collect();
    group.dashpot = Some(DashpotSpec { kind, coefficient, from_step: false });
    spec.springs = vec![group];
    spec
}

fn with_springs(slack: Slack) -> NetworkSpec {
    let mut spec = patch();
    spec.springs = vec![spring_group(&spec, slack)];
    spec
}

fn air(linear: f64, quadratic: f64) -> NetworkSpec {
    let wind = Series { t: vec![0.0, 1.0], value: vec![[1.0, -2.0, 4.0], [3.0, 0.5, -6.0]] };
    NetworkSpec { air: Some(AirSpec { linear, quadratic, wind }), ..patch() }
}

fn pressure(kind: PressureKind) -> NetworkSpec {
    let factor = Some(Series { t: vec![0.0, 2.0], value: vec![0.5, 1.5] });
    let load = PressureLoad { triangles: vec![0, 1, 4, 7], pressure: 30.0, kind, factor };
    NetworkSpec { pressures: vec![load], ..patch() }
}

/// Every term, alone in a scene, with its name.
pub fn scenes() -> Vec<(&'static str, NetworkSpec)> {
    let slacks = [
        ("plain", Slack::None),
        ("tension-only", Slack::TensionOnly),
        ("dead zone", Slack::DeadZone { eps: 0.11 }),
        ("compression limit", Slack::CompressionLimit { eps: 0.13 }),
    ];
    let mut list = Vec::new();
    for (name, slack) in slacks {
        list.push((name, with_springs(slack)));
        list.push((name, with_dashpots(slack, DashpotKind::Axial)));
    }
    list.push(("relative dashpots", with_dashpots(Slack::TensionOnly, DashpotKind::Relative)));
    let rayleigh = Some(RayleighSpec { mass: 0.7, stiffness: 0.02 });
    list.push(("rayleigh", NetworkSpec { rayleigh, ..with_springs(Slack::TensionOnly) }));
    list.push(("gravity", NetworkSpec { gravity: Some([1.0, -2.0, -9.81]), ..patch() }));
    list.push(("viscous air", air(3.0, 0.0)));
    list.push(("inertial air", air(0.0, 2.0)));
    list.push(("porous air", air(1.5, 2.5)));
    list.push(("follower pressure", pressure(PressureKind::Follower)));
    list.push(("dead pressure along a direction", pressure(PressureKind::Dead(Some([0.0, 0.6, 0.8])))));
    list.push(("dead pressure along the first normal", pressure(PressureKind::Dead(None))));
    let forces = vec![NodalLoad { nodes: vec![3, 8], force: [1.0, 2.0, 3.0], factor: None }];
    list.push(("nodal forces", NetworkSpec { forces, ..patch() }));
    list
}
