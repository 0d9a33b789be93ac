//! The table of methods: one entry a scheme. Case files, `canopy-fem methods`, the JSON Schema and the tests
//! all read it, so a scheme is registered here and nowhere else.

use std::collections::BTreeMap;

/// What a step of the method needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// forces only
    Explicit,
    /// forces and the spring graph, no matrix
    MatrixFree,
    /// tangents and a sparse factorisation
    Implicit,
}

/// A real parameter of a method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterInfo {
    /// key in a case file
    pub name: &'static str,
    /// value if the case does not give one
    pub default: f64,
    /// smallest value
    pub min: f64,
    /// whether `min` itself is allowed
    pub min_included: bool,
    /// largest value, always allowed
    pub max: f64,
    /// one line for the schema and `methods`
    pub doc: &'static str,
}

/// What is known of a method before it runs.
#[derive(Debug)]
pub struct MethodInfo {
    /// name in a case file
    pub name: &'static str,
    /// order of accuracy, measured on a damped, time-forced, nonlinear problem
    pub order: u32,
    /// what a step needs
    pub family: Family,
    /// parameters, in the order the scheme takes them
    pub parameters: &'static [ParameterInfo],
    /// one line on stability
    pub stability: &'static str,
    /// paper or book with equation number
    pub source: &'static str,
}

/// A method with its parameters, checked.
#[derive(Clone, Debug)]
pub struct MethodChoice {
    /// the method
    pub info: &'static MethodInfo,
    /// one value for each of `info.parameters`
    pub values: Vec<f64>,
}

/// Why a method cannot be chosen.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
pub enum MethodError {
    /// No such method.
    #[error("there is no method \"{name}\"; the methods are {known}")]
    Unknown {
        /// what was asked for
        name: String,
        /// all names
        known: String,
    },
    /// No such parameter.
    #[error("{method} has no parameter \"{name}\"; it has {known}")]
    UnknownParameter {
        /// the method
        method: &'static str,
        /// what was given
        name: String,
        /// its parameters
        known: String,
    },
    /// A parameter is out of range.
    #[error("{method}: {name} = {value} is outside {range}")]
    OutOfRange {
        /// the method
        method: &'static str,
        /// the parameter
        name: &'static str,
        /// what was given
        value: f64,
        /// e.g. "[-0.3333, 0]"
        range: String,
    },
}

/// All methods, in the order `canopy-fem methods` prints them.
pub fn methods() -> &'static [MethodInfo] {
    &[]
}

impl MethodChoice {
    /// Looks up a method and checks its parameters; what is not given takes its default.
    ///
    /// # Errors
    /// An unknown name or parameter, or a value out of its range (never clamped).
    pub fn new(name: &str, given: &BTreeMap<String, f64>) -> Result<Self, MethodError> {
        let _ = given;
        Err(MethodError::Unknown { name: name.to_owned(), known: String::new() })
    }
}
