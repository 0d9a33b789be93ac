//! A value and where it is reached.

/// A largest or smallest value over the degrees of freedom of a system.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AtDof {
    /// the value, in a unit that its function names
    pub value: f64,
    /// the degree of freedom where it is reached
    pub dof: usize,
}
