//! Values of a case's keys from measured curves: weighted least squares between gauges of runs and tables of data.
//!
//! ```text
//! case + --data + --vary --problem--> runs --model--> residuals --least_squares--> values --estimate--> errors --report--> json csv svg html
//! ```
//! The model is a whole run of `canopy-fem solve` without its files; its gauges are interpolated between steps. Runs of
//! a Jacobian are made at the same time, a thread each; results do not depend on the number of threads.

mod data;
mod estimate;
mod least_squares;
mod model;
mod parameter;
mod report;

pub use data::{DataSet, DataSource};
pub use estimate::{Estimate, Fitted, Noise};
pub use least_squares::{Ended, LeastSquares, Minimum};
pub use model::{Fit, FitSpec, StartResult};
pub use parameter::{Parameter, Range};
pub use report::{FILES, FitReport, clear};
