//! Initial displacement and velocity.

use super::geometry::Geometry;
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{Initial, Vectors};
use crate::format_number::first_few;
use crate::model::spec::SpringGroup;

/// The network with which the initial state is checked.
#[derive(Debug)]
pub(super) struct Network<'a> {
    /// the mesh
    pub geometry: &'a Geometry,
    /// which of x, y, z is fixed, `[n_nodes][3]`
    pub fixed: &'a [[bool; 3]],
    /// springs, whose ends must not meet
    pub springs: &'a [SpringGroup],
}

/// Initial vectors of every node, `[n_nodes][3]`; empty = zero.
#[derive(Debug, Default)]
pub(super) struct InitialState {
    /// [m]
    pub displacement: Vec<[f64; 3]>,
    /// [m/s]
    pub velocity: Vec<[f64; 3]>,
}

/// Checks and resolves the `initial` section.
pub(super) fn initial(
    at: &Pointer,
    section: Option<&Initial>,
    network: &Network<'_>,
    faults: &mut Faults<'_>,
) -> InitialState {
    let mut start =
        InitialState { displacement: network.geometry.mesh.displacement.clone(), ..InitialState::default() };
    let (displacement, velocity) = section.map_or((None, None), |s| (s.displacement.as_ref(), s.velocity.as_ref()));
    if let Some(vectors) = displacement {
        let given = each(&at.key("displacement"), vectors, network.fixed, faults);
        start.displacement = sum(given, &start.displacement);
    }
    check_lengths(&at.key("displacement"), &start.displacement, network, faults);
    if let Some(vectors) = velocity {
        let at = at.key("velocity");
        start.velocity = each(&at, vectors, network.fixed, faults);
        if let Vectors::Each(_) = vectors {
            check_held(&at, &start.velocity, network.fixed, faults);
        }
    }
    start
}

/// The sum of two displacements of every node; an empty one is zero.
fn sum(mut given: Vec<[f64; 3]>, of_mesh: &[[f64; 3]]) -> Vec<[f64; 3]> {
    for (given, more) in given.iter_mut().zip(of_mesh) {
        given.iter_mut().zip(more).for_each(|(given, more)| *given += more);
    }
    given
}

/// One vector per node, `[n_nodes][3]`; a uniform one acts on the free degrees of freedom only.
fn each(at: &Pointer, vectors: &Vectors, fixed: &[[bool; 3]], faults: &mut Faults<'_>) -> Vec<[f64; 3]> {
    match vectors {
        Vectors::Same(v) => fixed.iter().map(|f| std::array::from_fn(|i| if f[i] { 0.0 } else { v[i] })).collect(),
        Vectors::Each(list) if list.len() == fixed.len() => list.clone(),
        Vectors::Each(list) => {
            let value = format!("{} vectors", list.len());
            faults.add_value(at, value, format!("one vector, or a list of {} (one per node)", fixed.len()), None);
            Vec::new()
        }
    }
}

fn check_held(at: &Pointer, velocity: &[[f64; 3]], fixed: &[[bool; 3]], faults: &mut Faults<'_>) {
    for (i, (v, f)) in velocity.iter().zip(fixed).enumerate() {
        if (0..3).any(|c| f[c] && v[c] != 0.0) {
            faults.add_hint(
                &at.index(i),
                "0 in the directions in which the node is held",
                "a support holds its node at rest; set the component to 0 or free it in the supports section",
            );
        }
    }
}

/// A displacement must not move both ends of a spring to the same position, where the spring has no direction.
fn check_lengths(at: &Pointer, displacement: &[[f64; 3]], network: &Network<'_>, faults: &mut Faults<'_>) {
    // Empty if it was refused already: then the mesh as given is checked, which is no fault of the displacement.
    if displacement.is_empty() {
        return;
    }
    let meet = |edge: u32| network.geometry.start_length(edge, displacement).is_some_and(|length| !length.is_normal());
    let edges: Vec<u32> = network.springs.iter().flat_map(|g| g.edges.iter().copied()).filter(|e| meet(*e)).collect();
    if !edges.is_empty() {
        let value = format!("springs without length on edges {}", first_few(&edges));
        let hint = "the displaced ends of a spring coincide, or are farther apart than a double can hold".to_owned();
        faults.add_value(at, value, "a displacement after which every spring has a length", Some(hint));
    }
}
