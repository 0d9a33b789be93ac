//! Why a picture cannot be made.

/// Any failure of this folder.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// No line has a point that can be drawn: finite, and above 0 on a logarithmic axis.
    #[error("chart \"{title}\": no line has a point that can be drawn")]
    NothingToDraw {
        /// title of the chart
        title: String,
    },
    /// A fixed range is empty, not finite, or not above 0 on a logarithmic axis.
    #[error("chart \"{title}\", axis \"{axis}\": {low} to {high} is no range to draw on")]
    BadRange {
        /// title of the chart
        title: String,
        /// label of the axis
        axis: String,
        /// its lower end
        low: f64,
        /// its upper end
        high: f64,
    },
    /// The drawing library refused.
    #[error("drawing failed: {0}")]
    Drawing(String),
}
