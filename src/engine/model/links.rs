//! Springs one by one, as methods take them that go from spring to spring or from node to node.

/// A spring with what damps it. Its tension along the unit vector n from a to b, of length l, is
/// ```text
/// T = k (l - rest) + c n . (v_b - v_a), but at least `least` and at most `most`;      force on a = T n, on b = -T n
/// ```
/// and a relative dashpot adds `relative` (v_b - v_a) on a, and the opposite on b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// its end nodes a and b
    pub nodes: [u32; 2],
    /// [N/m] k; 0 while it is cut
    pub stiffness: f64,
    /// [m] the length from which on it is taut
    pub rest: f64,
    /// [N] least tension; -inf if it never goes slack
    pub least: f64,
    /// [N] largest tension; inf but for springs that only push
    pub most: f64,
    /// [N s/m] c of the dashpot along it
    pub axial: f64,
    /// [N s/m] coefficient of the dashpot on the whole relative velocity
    pub relative: f64,
}

impl Link {
    /// A spring that carries nothing.
    pub const NONE: Link = Link {
        nodes: [0; 2],
        stiffness: 0.0,
        rest: 0.0,
        least: f64::NEG_INFINITY,
        most: f64::INFINITY,
        axial: 0.0,
        relative: 0.0,
    };

    /// [N] A tension within what it can carry.
    pub fn within(&self, tension: f64) -> f64 {
        tension.max(self.least).min(self.most)
    }
}

/// The springs of a scene one by one.
pub trait SpringLinks {
    /// Their number, which stays as it is in a run.
    fn count(&self) -> usize;

    /// Overwrites `out` `[count]` with all springs as they are at time `t` [s], always in the same order.
    fn at(&self, t: f64, out: &mut [Link]);

    /// Whether their rest lengths change over time.
    fn reeled(&self) -> bool;

    /// [N] The forces of everything else `[n_dof]`, if they are the same at all times and in all states.
    fn rest_forces(&self) -> Option<Vec<f64>>;
}

/// Why a scene has no such springs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoLinks {
    /// A spring is of another curve.
    #[error(
        "this method takes springs of a constant stiffness, and some of this scene have a curve (\"table\" or finite strain); take \
         backward-euler or another method"
    )]
    Curve,
    /// Air that canopies take along joins all their nodes.
    #[error(
        "this method solves spring by spring, and the air that a canopy takes along (\"apparent_mass\") joins all of its nodes; take \
         backward-euler or another method"
    )]
    ApparentMass,
}
