//! Checks of a specification before a scene is built from it.

use super::check_elements::{springs, surfaces};
use super::check_loads::loads;
use super::check_values::{BuildError, below, finite, length, times, vectors};
use crate::force::law::bar_law::Bars;
use crate::model::spec::{MotionSpec, NetworkSpec, Trigger, Watched};

/// Rejects a specification that would panic or compute meaningless results.
pub(super) fn check(spec: &NetworkSpec) -> Result<(), BuildError> {
    nodes(spec)?;
    for release in &spec.releases {
        finite("time of a release", if release.event.is_some() { &[] } else { std::slice::from_ref(&release.t) })?;
        below("node", &release.nodes.iter().map(|(node, _)| *node).collect::<Vec<_>>(), spec.mesh.nodes.len())?;
    }
    spec.springs.iter().try_for_each(|group| finite("time of a cut", group.cut.as_slice()))?;
    spec.springs.iter().try_for_each(|group| springs(group, spec.mesh.edges.len()))?;
    events(spec)?;
    surfaces(spec)?;
    loads(spec)?;
    tables(spec)?;
    masses(spec)?;
    stands_still(spec)
}

/// Events, and what refers to them.
fn events(spec: &NetworkSpec) -> Result<(), BuildError> {
    let count = spec.events.len();
    let cuts = spec.springs.iter().filter_map(|group| group.cut_by);
    let others = spec.events.iter().filter_map(|event| match event.trigger {
        Trigger::After { event, .. } => Some(event),
        Trigger::At(_) | Trigger::Told(_) | Trigger::When(_) => None,
    });
    let named = spec.releases.iter().filter_map(|release| release.event).chain(cuts).chain(others);
    below("event", &named.map(|event| event as u32).collect::<Vec<_>>(), count)?;
    spec.events.iter().try_for_each(|event| match &event.of {
        Watched::Nodes(nodes) => {
            below("node", &nodes.iter().map(|(node, _)| *node).collect::<Vec<_>>(), spec.mesh.nodes.len())
        }
        Watched::Springs { edges, .. } => below("edge", edges, spec.mesh.edges.len()),
    })
}

/// Rejects bars that would panic or compute meaningless results, in a network of `n` nodes.
pub(super) fn check_bars(bars: &Bars, n: usize) -> Result<(), BuildError> {
    length("rest lengths of bars", bars.rest_length.len(), bars.pairs.len())?;
    below("node of a bar", bars.pairs.as_flattened(), n)?;
    finite("rest length of bar", &bars.rest_length)
}

fn nodes(spec: &NetworkSpec) -> Result<(), BuildError> {
    let n = spec.mesh.nodes.len();
    length("mass", spec.mass.len(), n)?;
    length("fixed", spec.fixed.len(), n)?;
    for (what, list) in [("displacement", &spec.displacement), ("velocity", &spec.velocity)] {
        if !list.is_empty() {
            length(what, list.len(), n)?;
        }
        vectors(what, list)?;
    }
    vectors("position of node", &spec.mesh.nodes)?;
    below("node", spec.mesh.edges.as_flattened(), n)?;
    below("node", spec.mesh.triangles.as_flattened(), n)
}

fn masses(spec: &NetworkSpec) -> Result<(), BuildError> {
    let free = |f: &[bool; 3]| *f != [true; 3];
    if !spec.always_fixed().iter().any(free) && spec.motions.is_empty() {
        return Err(BuildError::NothingFree);
    }
    let massless = |(_, (m, f)): &(usize, (&f64, &[bool; 3]))| free(f) && !(**m > 0.0 && m.is_finite());
    match spec.mass.iter().zip(&spec.always_fixed()).enumerate().find(massless) {
        None => Ok(()),
        Some((node, (&mass, _))) => Err(BuildError::Mass { node: node as u32, mass }),
    }
}

/// Motions, rest lengths over time, and the base.
fn tables(spec: &NetworkSpec) -> Result<(), BuildError> {
    for MotionSpec { nodes, displacement, settlement } in &spec.motions {
        times("motion", displacement)?;
        vectors("motion", &displacement.value)?;
        vectors("settlement", std::slice::from_ref(settlement))?;
        if displacement.at(0.0) != [0.0; 3] {
            return Err(BuildError::Table { what: "motion", reason: "does not begin at 0" });
        }
        for (node, moved) in nodes {
            below("node", &[*node], spec.mesh.nodes.len())?;
            let held = spec.fixed.get(*node as usize).into_iter().flatten();
            if let Some((_, axis)) = held.zip(moved).zip(['x', 'y', 'z']).find(|((held, moved), _)| **moved && !**held)
            {
                return Err(BuildError::NotHeld { node: *node, axis });
            }
        }
    }
    for factor in spec.springs.iter().filter_map(|group| group.rest_scale.as_ref()) {
        times("rest_scale", factor)?;
        finite("rest_scale", &factor.value)?;
        if factor.value.iter().any(|s| *s <= 0.0) {
            return Err(BuildError::Table { what: "rest_scale", reason: "has a factor that is not above 0" });
        }
    }
    spec.base_acceleration.iter().try_for_each(|table| {
        times("base acceleration", table)?;
        vectors("base acceleration", &table.value)
    })
}

/// Schemes that move nodes by their velocity alone would move the support too.
fn stands_still(spec: &NetworkSpec) -> Result<(), BuildError> {
    for (node, (velocity, fixed)) in (0..).zip(spec.velocity.iter().zip(&spec.fixed)) {
        for ((v, held), axis) in velocity.iter().zip(fixed).zip(['x', 'y', 'z']) {
            if *held && *v != 0.0 {
                return Err(BuildError::MovingSupport { node, axis });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::model::spec::Series;
    use crate::model::spec::{
        AirSpec, DashpotKind, DashpotSpec, NodalLoad, PressureKind, PressureLoad, Slack, SpringGroup,
    };

    fn constant<T>(value: T) -> Series<T> {
        Series { t: vec![0.0], value: vec![value] }
    }

    /// A triangle that is held at one corner, with everything a network can have.
    fn triangle() -> NetworkSpec {
        NetworkSpec {
            mesh: Mesh {
                nodes: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
                edges: vec![[0, 1], [1, 2], [0, 2]],
                triangles: vec![[0, 1, 2]],
                ..Mesh::default()
            },
            mass: vec![1.0; 3],
            fixed: vec![[true; 3], [false; 3], [false; 3]],
            springs: vec![SpringGroup {
                edges: vec![0, 1, 2],
                stiffness: vec![1.0; 3].into(),
                rest_length: vec![1.0; 3],
                slack: Slack::DeadZone { eps: 0.1 },
                dashpot: Some(DashpotSpec {
                    kind: DashpotKind::Axial,
                    coefficient: vec![1.0; 3].into(),
                    from_step: false,
                }),
                ..SpringGroup::default()
            }],
            air: Some(AirSpec { linear: 1.0, quadratic: 1.0, wind: constant([0.0; 3]) }),
            pressures: vec![PressureLoad {
                triangles: vec![0],
                pressure: 1.0,
                kind: PressureKind::Follower,
                factor: Some(constant(1.0)),
            }],
            forces: vec![NodalLoad { nodes: vec![1], force: [0.0; 3], factor: None }],
            velocity: vec![[0.0; 3], [1.0; 3], [0.0; 3]],
            ..NetworkSpec::default()
        }
    }

    /// A specification that would panic or compute nonsense is refused before it can.
    #[test]
    fn what_a_library_user_can_get_wrong_is_refused() {
        type Spoil = fn(&mut NetworkSpec);
        let spoilt: [(Spoil, &str); 12] = [
            (|s| s.springs[0].stiffness = vec![1.0, f64::NAN, 1.0].into(), "stiffness 1 is not a finite number"),
            (|s| s.springs[0].rest_length[2] = f64::INFINITY, "rest_length 2 is not"),
            (|s| s.springs[0].slack = Slack::CompressionLimit { eps: f64::NAN }, "slack eps"),
            (|s| s.mesh.nodes[2][1] = f64::NAN, "position of node 2"),
            (|s| s.gravity = Some([0.0, 0.0, f64::NAN]), "gravity"),
            (|s| s.velocity[0] = [0.0, 2.0, 0.0], "node 0 is held along y and has a velocity"),
            (|s| s.air.iter_mut().for_each(|air| air.wind = Series { t: vec![], value: vec![] }), "wind has no rows"),
            (|s| s.air.iter_mut().for_each(|air| air.wind.t.push(1.0)), "wind has not one value a time"),
            (|s| s.air.iter_mut().for_each(|air| air.wind.value[0][2] = f64::NAN), "wind 0 is not"),
            (|s| s.pressures[0].factor = Some(Series { t: vec![1.0, 1.0], value: vec![1.0; 2] }), "do not increase"),
            (|s| s.forces[0].factor = Some(Series { t: vec![f64::NAN], value: vec![1.0] }), "do not increase"),
            (|s| s.forces[0].force[0] = f64::NAN, "force 0 is not"),
        ];
        assert_eq!(check(&triangle()), Ok(()));
        for (spoil, why) in spoilt {
            let mut spec = triangle();
            spoil(&mut spec);
            let told = check(&spec).expect_err(why).to_string();
            assert!(told.contains(why), "{told}");
        }
    }
}
