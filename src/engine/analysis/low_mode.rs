//! A mode of vibration, and why modes cannot be found.

use crate::assembly::PatternError;
use crate::solve::LinearError;

/// A mode of vibration.
#[derive(Clone, Debug)]
pub struct LowMode {
    /// [1/s^2] square of the angular frequency; below 0 for a motion that grows
    pub omega_squared: f64,
    /// [1/s^2] a square that the scene has is at most this far from it: |K phi - w^2 M phi|, and rounding in K phi
    pub error: f64,
    /// displacements phi with phi.M phi = 1 kg, `[n_dof]`; the largest component is positive
    pub shape: Vec<f64>,
    /// degree of freedom that moves most
    pub dof: usize,
}

impl LowMode {
    /// [Hz] Frequency; 0 for a motion that grows, and for one whose square may as well be 0.
    pub fn frequency(&self) -> f64 {
        let square = if self.omega_squared > self.error { self.omega_squared } else { 0.0 };
        square.sqrt() / std::f64::consts::TAU
    }

    /// [1/s] The rate r of a motion that grows as exp(r t); 0 for others.
    pub fn growth(&self) -> f64 {
        if self.omega_squared < -self.error { (-self.omega_squared).sqrt() } else { 0.0 }
    }
}

/// Why modes cannot be found.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
#[non_exhaustive]
pub enum ModesError {
    /// A scene without nodes.
    #[error("modes are those of a network, and this scene is none")]
    NoNetwork,
    /// More modes than the scene has.
    #[error("{asked} modes were asked for, but the scene has {unknowns} free degrees of freedom")]
    TooMany {
        /// modes
        asked: usize,
        /// unknowns
        unknowns: usize,
    },
    /// The matrix has no pattern.
    #[error(transparent)]
    Pattern(#[from] PatternError),
    /// The matrix cannot be factorised.
    #[error(transparent)]
    Linear(#[from] LinearError),
    /// The iteration has reached its bound.
    #[error("{found} of {asked} modes were found in {solves} solves; ask for fewer")]
    NotConverged {
        /// modes that are accurate
        found: usize,
        /// modes
        asked: usize,
        /// solves made
        solves: usize,
    },
    /// It was stopped.
    #[error("the search for modes was interrupted")]
    Stopped,
}
