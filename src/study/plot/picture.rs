//! The picture of a kind of chart.

use super::chart::{Chart, Size};
use super::curve::Plane;
use super::layout::svg_grid;
use super::panel::{Panel, PanelChart};
use super::view::{Kind, Results, View};
use super::{PlotError, columns, trajectory};

/// Size of a chart if there are several [px].
const PANEL: Size = Size { width: 640, height: 360 };

/// A picture of some charts.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// SVG text
    pub svg: String,
    /// what it does not show
    pub remarks: Vec<String>,
    /// its charts, and those that it leaves out as more than are wanted
    pub charts: [usize; 2],
}

/// The picture of a kind.
///
/// # Errors
/// Probes, nodes or gauges that do not exist, results that hold nothing of this kind, no selected time, nothing above 0
/// on a logarithmic axis, or a run to subtract that lacks a curve.
pub fn picture(results: &Results, view: &View, kind: Kind) -> Result<Picture, PlotError> {
    let (panels, file) = match kind {
        Kind::Displacement => (vec![trajectory::panel(results, view, Plane::Time)?], "frame"),
        Kind::Phase => (vec![trajectory::panel(results, view, Plane::Phase)?], "frame"),
        _ => (columns::panels(results, view, kind)?, "row"),
    };
    if panels.iter().all(Panel::is_empty) {
        let no_times = if results.base.is_some() { ", and no time is in both runs" } else { "" };
        return Err(PlotError::NotThere(format!("no {file} of the runs is within --from and --to{no_times}")));
    }
    let mut panels: Vec<Panel> = panels.into_iter().filter(|panel| !panel.is_empty()).collect();
    let most = view.most.unwrap_or(panels.len()).min(panels.len());
    let more = panels.len() - most;
    if more > 0 {
        panels.sort_by_key(|panel| panel.rank);
        panels.truncate(most);
    }
    let several = panels.len() > 1;
    let (mut charts, mut remarks, mut refused) = (Vec::new(), Vec::new(), None);
    let (mut left_out, mut all) = (0, 0);
    for panel in panels {
        match panel.chart(view.scales) {
            Ok(PanelChart { chart, left_out: without, all: points }) => {
                left_out += without;
                all += points;
                charts.push(if several { Chart { size: PANEL, ..chart } } else { chart });
            }
            Err(error) => {
                remarks.push(error.to_string());
                refused.get_or_insert(error);
            }
        }
    }
    if left_out > 0 {
        let stem = kind.stem();
        remarks.push(format!("{stem}: {left_out} of {all} points are not above 0 and not on the logarithmic axis"));
    }
    match refused {
        Some(error) if charts.is_empty() => Err(error),
        _ => Ok(Picture { svg: svg_grid(&charts, 2)?, remarks, charts: [charts.len(), more] }),
    }
}
