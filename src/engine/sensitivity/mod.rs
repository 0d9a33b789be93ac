//! Exact derivatives of a run: of its states with respect to parameters of its scene.
//!
//! A scheme says how a step is made of vectors and accelerations ([`StepForm`](crate::integrate::form::StepForm)). The
//! same rows hold for derivatives. What is left are the accelerations g = M^-1 f(t, x, v; p) of the stages, with
//! x = x^ + alpha g and v = v^ + beta g, where alpha = beta = 0 in an explicit stage:
//! ```text
//! W dg = -K dx^ - C dv^ + M e dp,     W = M + alpha K + beta C,     e = d(M^-1 f)/dp at a given state
//! ```
//! K and C are the exact tangents at the stage, so that the derivative is that of the discrete motion itself, not of
//! the motion that it approximates. e is found by [central differences of order four](difference) between scenes with
//! other values of the parameter, at one state. So every number that a scene is built from is a parameter, and no law
//! knows of it. The tangent-linear run ([`TangentRun`]) goes along with the run.
//!
//! Source: Griewank & Walther 2008, chapter 3 (the forward mode), on the steps as a whole.

mod apparent_slope;
pub mod difference;
mod error;
mod linearisation;
mod parameter;
mod tangent_run;

pub use error::SensitivityError;
pub use parameter::{Parameter, Switches};
pub use tangent_run::{StepEnds, TangentRun};
