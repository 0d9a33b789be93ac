//! An entry of the table, and a method chosen from it with its parameters.

use super::{methods, other_name};
use crate::integrate::implicit::SolverSpec;
use crate::integrate::linear_step::{LinearStep, Pencil};
use crate::integrate::stepper::Scheme;
use std::collections::BTreeMap;

/// What a step of the method needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Family {
    /// forces only
    Explicit,
    /// forces and the springs, no matrix
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
    /// whether only whole numbers are allowed
    pub whole: bool,
    /// one line for the schema and `methods`
    pub doc: &'static str,
}

/// Properties of a method.
#[derive(Debug)]
pub struct MethodInfo {
    /// name in a case file
    pub name: &'static str,
    /// order of accuracy with default parameters, measured on a damped, time-forced, nonlinear problem
    pub order: u32,
    /// order with other parameters, where it depends on them
    pub order_with: Option<fn(&[f64]) -> u32>,
    /// what a step needs
    pub family: Family,
    /// number of its colour in charts, 0 to 14, which no other method of its family has; a family has marks of its own
    pub color: usize,
    /// force passes a step: without and with velocity-dependent forces; 0 = as many as Newton needs
    pub evaluations: [u32; 2],
    /// parameters, in the order the scheme takes them
    pub parameters: &'static [ParameterInfo],
    /// one line on stability
    pub stability: &'static str,
    /// what a step is on linear scenes
    pub linear: LinearStep,
    /// paper or book, with equation number
    pub source: &'static str,
    /// makes the scheme from its checked parameter values
    pub build: fn(&[f64], SolverSpec) -> Scheme,
}

/// A method with its parameters, checked.
#[derive(Clone, Debug)]
pub struct MethodChoice {
    /// the method
    pub info: &'static MethodInfo,
    /// one value for each of `info.parameters`
    values: Vec<f64>,
}

/// Why a method cannot be chosen.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
pub enum MethodError {
    /// No such method.
    #[error("there is no method \"{name}\"; {}the methods are {known}", hint(name))]
    Unknown {
        /// the name given
        name: String,
        /// all names
        known: String,
    },
    /// No such parameter.
    #[error("{method} has no parameter \"{name}\"; it has {known}")]
    UnknownParameter {
        /// the method
        method: &'static str,
        /// the value given
        name: String,
        /// its parameters
        known: String,
    },
    /// A parameter is out of range.
    #[error("{method}: {name} = {value} is outside of what is allowed, {allowed}")]
    OutOfRange {
        /// the method
        method: &'static str,
        /// the parameter
        name: &'static str,
        /// the value given
        value: f64,
        /// e.g. "a number in [-0.3333, 0]"
        allowed: String,
    },
}

/// The method that is also called so.
fn hint(name: &str) -> String {
    other_name(name).map(|other| format!("{}; ", other.hint())).unwrap_or_default()
}

impl ParameterInfo {
    /// What is allowed as text, e.g. `a number in (0, 0.5]`.
    pub fn allowed(&self) -> String {
        let number = if self.whole { "a whole number" } else { "a number" };
        format!("{number} in {}{}, {}]", if self.min_included { '[' } else { '(' }, self.min, self.max)
    }

    /// Whether a value is allowed; a number that is not finite never is.
    pub fn allows(&self, value: f64) -> bool {
        let in_range = value <= self.max && (value > self.min || self.min_included && value == self.min);
        in_range && (!self.whole || value == value.trunc())
    }
}

impl MethodChoice {
    /// Looks up a method and checks its parameters; parameters that are not given have their defaults.
    ///
    /// # Errors
    /// An unknown name or parameter, or a value out of its range (never clamped).
    pub fn new(name: &str, given: &BTreeMap<String, f64>) -> Result<Self, MethodError> {
        let Some(info) = methods().iter().find(|m| m.name == name) else {
            let known = methods().iter().map(|m| m.name).collect::<Vec<_>>().join(", ");
            return Err(MethodError::Unknown { name: name.to_owned(), known });
        };
        Self::of(info, given)
    }

    /// A method that a program supplies, which need not be in the table: `info` says how to make it. See
    /// `examples/own_scheme.rs`.
    ///
    /// # Errors
    /// An unknown parameter, or a value out of its range.
    pub fn of(info: &'static MethodInfo, given: &BTreeMap<String, f64>) -> Result<Self, MethodError> {
        if let Some(unknown) = given.keys().find(|key| info.parameters.iter().all(|p| p.name != key.as_str())) {
            let known = match info.parameters {
                [] => "none".to_owned(),
                some => some.iter().map(|p| p.name).collect::<Vec<_>>().join(", "),
            };
            return Err(MethodError::UnknownParameter { method: info.name, name: unknown.clone(), known });
        }
        let mut values = Vec::with_capacity(info.parameters.len());
        for p in info.parameters {
            let value = given.get(p.name).copied().unwrap_or(p.default);
            if !p.allows(value) {
                return Err(MethodError::OutOfRange { method: info.name, name: p.name, value, allowed: p.allowed() });
            }
            values.push(value);
        }
        Ok(MethodChoice { info, values })
    }

    /// A method with the default of each of its parameters.
    ///
    /// # Errors
    /// An unknown name.
    pub fn with_defaults(name: &str) -> Result<Self, MethodError> {
        Self::new(name, &BTreeMap::new())
    }

    /// All methods with their defaults, except this one with its own parameters.
    pub fn among_all(&self) -> impl Iterator<Item = MethodChoice> {
        let defaults = |info: &MethodInfo| info.parameters.iter().map(|p| p.default).collect();
        methods().iter().map(move |info| match info.name == self.info.name {
            true => self.clone(),
            false => MethodChoice { info, values: defaults(info) },
        })
    }

    /// The scheme, ready to be bound to a scene.
    pub fn scheme(&self, solver: SolverSpec) -> Scheme {
        (self.info.build)(&self.values, solver)
    }

    /// [-] Order of accuracy with these parameters.
    pub fn order(&self) -> u32 {
        self.info.order_with.map_or(self.info.order, |order| order(&self.values))
    }

    /// Whether it is a partitioned method with these parameters ([`LinearStep::partitioned`]).
    pub fn partitioned(&self) -> bool {
        (self.info.linear.partitioned)(&self.values)
    }

    /// [-] Short steps of stiff springs in a step ([`LinearStep::substeps`]).
    pub fn substeps(&self) -> f64 {
        (self.info.linear.substeps)(&self.values)
    }

    /// Sweeps in a step ([`LinearStep::sweeps`]).
    pub fn sweeps(&self) -> f64 {
        (self.info.linear.sweeps)(&self.values)
    }

    /// The matrix of its stable steps ([`LinearStep::pencil`]), if it has one.
    pub fn pencil(&self) -> Option<Pencil> {
        self.info.linear.pencil.map(|pencil| pencil.in_steps(self.substeps()))
    }

    /// The parameters by name.
    pub fn parameters(&self) -> impl Iterator<Item = (&'static str, f64)> {
        self.info.parameters.iter().map(|p| p.name).zip(self.values.iter().copied())
    }
}
