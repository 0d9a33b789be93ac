//! Lift of canopies and bodies that glide.

use super::Series;
use serde::Serialize;

/// A lift beside a drag, normal to the velocity against the air and in the vertical plane of a heading.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GlideSpec {
    /// [-] lift over drag, > 0, in flight without sideslip
    pub ratio: f64,
    /// [deg] heading over time, from the y axis (north) to the x axis (east)
    pub heading: Series<f64>,
}
