//! Drawing (on its way): the interface stands first.

use super::PlotError;
use super::chart::Chart;

pub(super) fn grid(_charts: &[Chart], _columns: usize) -> Result<String, PlotError> {
    Err(PlotError::Drawing("the drawing is not built yet".to_owned()))
}
