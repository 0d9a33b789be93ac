//! Lift of canopies and bodies that glide.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::table::OverTime;

/// A lift beside the drag, L = `ratio` D. It is normal to the velocity against the air and lies in the vertical plane
/// of the `heading`: up and forward in a glide, along the heading in a vertical fall. In steady flight the path through
/// the air sinks by arctan(1/ratio). The wind carries both along, so the course over the ground is another one. Motion
/// across the plane is sideslip, which has drag and no lift. While a canopy fills, its lift grows with its drag.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Glide {
    /// [-] Lift over drag: of the canopy or body itself, whose payload and lines have drag of their own.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub ratio: f64,
    /// [deg] Heading as on a compass, from the y axis (north, 0) to the x axis (east, 90): a number, or
    /// `{"table": [[t, heading], ...]}` over time [s], linear between the rows, so 350, 370 goes through north.
    pub heading: OverTime,
}
