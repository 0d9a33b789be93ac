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
//! The adjoint run ([`AdjointRun`]) goes back over the steps of a run. Its work does not depend on the number of
//! parameters, so that each spring and each node can be one. With u the derivatives of a quantity by the acceleration
//! of a stage,
//! ```text
//! W^T p = u,     by x^: -K^T p,     by v^: -C^T p,     by a parameter: p . (df/dp - dM/dp g)
//! ```
//! and the rows of the step take these to the vectors that it begins with. It needs the steps in reverse order: a
//! [`Recorder`] keeps them, and a [`Plan`] says which parts of a long run are made again, so that few are kept at once.
//!
//! Sources: Griewank & Walther 2008, chapter 3 (both modes) and chapter 12 (which steps to keep), on steps as a whole.

mod adjoint_run;
mod apparent_slope;
mod columns;
pub mod difference;
mod error;
mod linearisation;
mod parameter;
mod plan;
mod record;
mod tangent_run;

pub use adjoint_run::{AdjointRun, ElementKinds, ElementSlopes, Seed};
pub use error::SensitivityError;
pub use parameter::{Parameter, Switches, Varied};
pub use plan::{Plan, Segment};
pub use record::{Recorder, RecorderState, StepRecord};
pub use tangent_run::{StepEnds, TangentRun};
