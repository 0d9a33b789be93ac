//! Why there is no equilibrium, and what to do.

use super::Residual;
use super::resultants::Loose;
use crate::format_number::figures;
use crate::scene::Suspect;

/// Why a search has ended without an equilibrium.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StaticFailure {
    /// Nothing can move at the time of the loads.
    #[error("at t = {} s every node is held in x, y and z: there is nothing to find", figures(*at, 6))]
    AllHeld {
        /// [s] that time
        at: f64,
        /// [s] next event of the scene
        next: Option<f64>,
    },
    /// Loads that no support can balance.
    #[error("there is no equilibrium: {loose}")]
    NoSupport {
        /// the part
        loose: Loose,
    },
    /// The iterations that are allowed have been made, or none makes progress.
    #[error(
        "after {iterations} iterations {} N of {} N are left, most of it at {}{}",
        figures(residual.force, 3),
        figures(residual.scale, 3),
        place.node.map_or_else(|| "one unknown".to_owned(), |node| format!("node {node}")),
        loose.as_ref().map(|loose| format!("; {loose}")).unwrap_or_default()
    )]
    NotConverged {
        /// the forces left
        residual: Residual,
        /// where most of them are
        place: Suspect,
        /// Newton iterations made
        iterations: u64,
        /// a part that nothing holds, if there is one
        loose: Option<Box<Loose>>,
    },
    /// A node has gone far away.
    #[error(
        "{} has moved by more than a thousand sizes of the scene, and forces still push it{}",
        place.node.map_or_else(|| "a node".to_owned(), |node| format!("node {node}")),
        loose.as_ref().map(|loose| format!(": {loose}")).unwrap_or_default()
    )]
    Left {
        /// the node
        place: Suspect,
        /// a part that nothing holds, if there is one
        loose: Option<Box<Loose>>,
    },
    /// A force at the start is not finite.
    #[error(
        "a force at the start is not finite, at {}",
        place.node.map_or_else(|| "one unknown".to_owned(), |node| format!("node {node}"))
    )]
    NotFinite {
        /// where
        place: Suspect,
    },
    /// The matrix or its solver cannot be set up.
    #[error("{error}")]
    Solver {
        /// the reason
        error: String,
    },
    /// It was stopped from outside.
    #[error("the search was interrupted")]
    Interrupted,
}

impl StaticFailure {
    /// Where most is wrong.
    pub fn place(&self) -> Suspect {
        match self {
            StaticFailure::NotConverged { place, .. }
            | StaticFailure::Left { place, .. }
            | StaticFailure::NotFinite { place } => place.clone(),
            StaticFailure::NoSupport { loose } => Suspect { node: loose.nodes.first().copied(), ..Suspect::default() },
            StaticFailure::AllHeld { .. } | StaticFailure::Solver { .. } | StaticFailure::Interrupted => {
                Suspect::default()
            }
        }
    }

    /// What to do.
    pub fn advice(&self) -> String {
        let text = match self {
            StaticFailure::AllHeld { next: Some(next), .. } => {
                return format!("take a time at which supports have let go: at={}", figures(*next, 6));
            }
            StaticFailure::AllHeld { next: None, .. } => "free at least one direction of one node",
            StaticFailure::NoSupport { loose } => return hold(loose),
            StaticFailure::Left { loose: Some(loose), .. } => return hold(loose),
            StaticFailure::NotConverged { .. } => {
                "apply the loads in 20 steps, allow more iterations (solver.newton.max_iterations), or \
                 start nearer: take initial.from of a run with damping"
            }
            StaticFailure::Left { .. } => {
                "check what holds this node, and that its springs can carry it: tension-only springs push nothing"
            }
            StaticFailure::NotFinite { .. } => "check loads, wind and the start for a wrong unit",
            StaticFailure::Solver { .. } => "take \"linear\": \"auto\"",
            StaticFailure::Interrupted => "start it again",
        };
        text.to_owned()
    }
}

fn hold(Loose { axis, .. }: &Loose) -> String {
    format!(
        "hold a node of this part in {axis}, such as the payload or the point where the lines meet, or balance its loads; \
         a body that falls has an equilibrium only in a wind that carries it"
    )
}
