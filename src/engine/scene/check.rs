//! Checks of a specification before a scene is built from it.

use super::check_elements::{springs, surfaces};
use super::check_loads::loads;
use crate::force::law::bar_law::Bars;
use crate::model::spec::{MotionSpec, NetworkSpec, Series};

/// Why a scene cannot be built from a specification. The case reader finds these faults first, with more precise
/// messages; a library user may not.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum BuildError {
    /// A list does not have one entry per node, or per spring of its group.
    #[error("{what}: {found} entries where {expected} are needed")]
    Length {
        /// which list
        what: &'static str,
        /// its length
        found: usize,
        /// what it should be
        expected: usize,
    },
    /// A node, edge or triangle number is too large.
    #[error("{what} {index} does not exist; there are {count}")]
    Index {
        /// node, edge or triangle
        what: &'static str,
        /// the number
        index: u32,
        /// how many there are
        count: usize,
    },
    /// A free node without mass cannot be accelerated.
    #[error("node {node} is free and has the mass {mass} kg; a free node needs a positive finite mass")]
    Mass {
        /// user's number
        node: u32,
        /// [kg] its mass
        mass: f64,
    },
    /// Mass scaling that adds nothing.
    #[error(
        "mass scaling for steps of {step} s adds nothing: no node needs more than {needed:.3} of its mass for them; leave time.mass_scaling out"
    )]
    NothingToScale {
        /// [s] the step that is wanted
        step: f64,
        /// [-] largest share of a node's mass that is needed
        needed: f64,
    },
    /// Nothing is free at any time, or moved.
    #[error("the scene has no free degree of freedom")]
    NothingFree,
    /// A value is not a finite number.
    #[error("{what} {index} is not a finite number")]
    NotFinite {
        /// which list, or which value
        what: &'static str,
        /// index in its list; for nodal values the node
        index: usize,
    },
    /// A spring without a rest length, whose law depends on the strain.
    #[error("spring {spring} of its group has no rest length, which its law needs")]
    NoRestLength {
        /// place in its group
        spring: usize,
    },
    /// A material that no sheet has.
    #[error(
        "a membrane with the moduli {} and {} Pa, a Poisson's ratio of {poisson} and a shear modulus of {shear} Pa: thickness and \
         moduli must be above 0, the damping time not below, and poisson^2 E2 below E1",
        modulus[0],
        modulus[1]
    )]
    Membrane {
        /// [Pa] E1 and E2
        modulus: [f64; 2],
        /// [-] nu12
        poisson: f64,
        /// [Pa] G12
        shear: f64,
    },
    /// A triangle of a membrane without an area, or at right angles to the warp.
    #[error("triangle {triangle} of a membrane has no area, or the warp direction is at right angles to it")]
    RestShape {
        /// its number
        triangle: u32,
    },
    /// A hinge of a triangle without an area, or a chain with a segment of no length.
    #[error("bending between nodes {} and {}: a triangle has no area, or a segment no length", ends[0], ends[1])]
    Hinge {
        /// the first nodes
        ends: [u32; 2],
    },
    /// A table over time without rows, without one value per time, or with times that do not increase.
    #[error("the table of the {what} {reason}")]
    Table {
        /// what it is a table of
        what: &'static str,
        /// what is wrong with it
        reason: &'static str,
    },
    /// Canopies or drag without air.
    #[error("canopies and drag need a stream")]
    NoStream,
    /// A canopy without nodes that it needs.
    #[error("a canopy has no node of its {what}")]
    NoNodes {
        /// skirt, apex or confluence
        what: &'static str,
    },
    /// The skirt of a cavity is not on exactly one closed loop of the canopy's boundary.
    #[error("a cavity needs one closed loop of the boundary with the nodes of the skirt; there are {loops}")]
    Mouth {
        /// how many loops have some of its nodes
        loops: usize,
    },
    /// The mouth of a cavity has no area at the start.
    #[error("the mouth of a cavity has no area at the start")]
    ClosedMouth,
    /// A canopy whose drag area grows in no stage.
    #[error("a canopy that fills needs at least one stage")]
    NoStage,
    /// A coefficient of a cavity without a meaning.
    #[error("a cavity {reason}")]
    Cavity {
        /// what is wrong
        reason: &'static str,
    },
    /// A motion of what is not held.
    #[error("node {node} is moved along {axis} and not held there")]
    NotHeld {
        /// user's number
        node: u32,
        /// x, y or z
        axis: char,
    },
    /// A support has a velocity.
    #[error("node {node} is held along {axis} and has a velocity there; what is held stands still or has a motion")]
    MovingSupport {
        /// user's number
        node: u32,
        /// x, y or z
        axis: char,
    },
}

/// Rejects a specification that would panic or compute meaningless results.
pub(super) fn check(spec: &NetworkSpec) -> Result<(), BuildError> {
    nodes(spec)?;
    for release in &spec.releases {
        finite("time of a release", &[release.t])?;
        below("node", &release.nodes.iter().map(|(node, _)| *node).collect::<Vec<_>>(), spec.mesh.nodes.len())?;
    }
    spec.springs.iter().try_for_each(|group| finite("time of a cut", group.cut.as_slice()))?;
    spec.springs.iter().try_for_each(|group| springs(group, spec.mesh.edges.len()))?;
    surfaces(spec)?;
    loads(spec)?;
    tables(spec)?;
    masses(spec)?;
    stands_still(spec)
}

/// Rejects bars that would panic or compute meaningless results, in a network of `n` nodes.
pub(super) fn check_bars(bars: &Bars, n: usize) -> Result<(), BuildError> {
    length("rest lengths of bars", bars.rest_length.len(), bars.pairs.len())?;
    below("node of a bar", bars.pairs.as_flattened(), n)?;
    finite("rest length of bar", &bars.rest_length)
}

pub(super) fn length(what: &'static str, found: usize, expected: usize) -> Result<(), BuildError> {
    if found == expected { Ok(()) } else { Err(BuildError::Length { what, found, expected }) }
}

pub(super) fn below(what: &'static str, indices: &[u32], count: usize) -> Result<(), BuildError> {
    match indices.iter().find(|&&i| i as usize >= count) {
        None => Ok(()),
        Some(&index) => Err(BuildError::Index { what, index, count }),
    }
}

pub(super) fn finite(what: &'static str, values: &[f64]) -> Result<(), BuildError> {
    vectors(what, bytemuck::cast_slice::<_, [f64; 1]>(values))
}

/// The same for vectors.
pub(super) fn vectors<const N: usize>(what: &'static str, values: &[[f64; N]]) -> Result<(), BuildError> {
    match values.iter().position(|value| !value.iter().all(|c| c.is_finite())) {
        None => Ok(()),
        Some(index) => Err(BuildError::NotFinite { what, index }),
    }
}

pub(super) fn times<T>(what: &'static str, table: &Series<T>) -> Result<(), BuildError> {
    let refuse = |reason| Err(BuildError::Table { what, reason });
    if table.t.is_empty() {
        return refuse("has no rows");
    }
    if table.value.len() != table.t.len() {
        return refuse("has not one value a time");
    }
    if !table.t.iter().all(|t| t.is_finite()) || table.t.windows(2).any(|pair| pair[1] <= pair[0]) {
        return refuse("has times that do not increase");
    }
    Ok(())
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
    for MotionSpec { nodes, displacement } in &spec.motions {
        times("motion", displacement)?;
        vectors("motion", &displacement.value)?;
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
