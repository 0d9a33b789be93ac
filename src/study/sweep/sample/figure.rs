//! Figures of a sample: the distribution function of a number, the number over what makes its scatter, and where runs
//! landed.

use super::Sampled;
use super::scatter::{Distribution, Points, Scatter, landing_points};
use crate::error::StudyError;
use crate::plot::chart::{Axis, Chart, Line, Marker, Size, Stroke};
use crate::row::RowStatus;
use crate::sweep::figure::short;
use crate::sweep::table::Quantity;
use crate::sweep::words::with_unit;
use crate::sweep::{SweepPlan, SweepRow};

/// A chart and what it shows.
pub(in crate::sweep) struct Figure {
    pub chart: Chart,
    pub caption: String,
}

/// All figures of a sample.
///
/// # Errors
/// Columns of the ellipse that are not there.
pub(in crate::sweep) fn figures(
    plan: &SweepPlan,
    sampled: &Sampled,
    rows: &[SweepRow],
    shown: &[&Quantity],
    scatter: &Scatter,
) -> Result<Vec<Figure>, StudyError> {
    let mut all = Vec::new();
    for distribution in &scatter.quantities {
        let Some(quantity) = shown.iter().find(|quantity| quantity.name == distribution.name) else { continue };
        let of = Of { plan, sampled, rows, quantity, distribution };
        all.push(of.distribution_function());
        all.extend(of.over_strongest());
    }
    all.extend(landing(plan, sampled, rows, scatter)?);
    Ok(all)
}

/// One number of a sample.
struct Of<'a> {
    plan: &'a SweepPlan,
    sampled: &'a Sampled,
    rows: &'a [SweepRow],
    quantity: &'a Quantity,
    distribution: &'a Distribution,
}

impl Of<'_> {
    /// Runs of the sample that have the number.
    fn runs(&self) -> impl Iterator<Item = (f64, &SweepRow)> {
        let completed = self.rows.iter().filter(|row| row.result.status == RowStatus::Completed);
        let sample = completed.filter(|row| !self.sampled.indices || row.job.run % self.sampled.group() < 2);
        sample.filter_map(|row| Some((self.quantity.of(row)?, row)))
    }

    fn distribution_function(&self) -> Figure {
        let mut runs: Vec<(f64, &SweepRow)> = self.runs().collect();
        runs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let n = runs.len() as f64;
        let curve = Line {
            label: "runs".to_owned(),
            points: runs.iter().enumerate().map(|(i, (x, _))| (*x, (i as f64 + 0.5) / n)).collect(),
            runs: runs.iter().map(|(_, row)| row.job.id.clone()).collect(),
            marker: Marker::Dot,
            stroke: Stroke::Thin,
            color: Some(0),
            series: "runs".to_owned(),
            ..Line::default()
        };
        let within = |q: &super::scatter::Quantile| {
            let ends = [q.estimate.low.unwrap_or(q.estimate.value), q.estimate.high.unwrap_or(q.estimate.value)];
            [(ends[0], q.p), (ends[1], q.p), (f64::NAN, f64::NAN)]
        };
        let intervals = Line {
            label: "95 % intervals of percentiles".to_owned(),
            points: self.distribution.quantiles.iter().flat_map(within).collect(),
            marker: Marker::Tick,
            color: Some(1),
            series: "intervals".to_owned(),
            ..Line::default()
        };
        Figure {
            chart: Chart {
                title: format!("{}: {}", self.plan.name, self.quantity.words()),
                x: Axis::linear(self.quantity.label()),
                y: Axis { range: Some((0.0, 1.0)), ..Axis::linear("share of runs below [-]") },
                lines: vec![curve, intervals],
                ..Chart::default()
            },
            caption: format!(
                "Distribution of {}, with the intervals of the 1st, 5th, 50th, 95th and 99th percentile.",
                self.quantity.words()
            ),
        }
    }

    /// The number over the key with the largest index, if its values are numbers.
    fn over_strongest(&self) -> Option<Figure> {
        let share = |i: usize| self.distribution.indices.get(i).and_then(|index| Some(index.first?.value));
        let known = (0..self.sampled.inputs.len()).filter_map(|i| Some((i, share(i)?)));
        let (strongest, _) = known.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let [key] = self.sampled.inputs.get(strongest)?.keys.as_slice() else { return None };
        let points = self.runs().map(|(y, row)| Some((row.job.values.get(key)?.as_f64()?, y)));
        let points: Vec<(f64, f64)> = points.collect::<Option<_>>()?;
        let line = Line {
            label: "runs".to_owned(),
            points,
            runs: self.runs().map(|(_, row)| row.job.id.clone()).collect(),
            marker: Marker::Dot,
            stroke: Stroke::None,
            color: Some(0),
            series: "runs".to_owned(),
            ..Line::default()
        };
        Some(Figure {
            chart: Chart {
                title: format!("{}: {} over {}", self.plan.name, self.quantity.words(), short(key)),
                x: Axis::linear(with_unit(key)),
                y: Axis::linear(self.quantity.label()),
                lines: vec![line],
                ..Chart::default()
            },
            caption: format!("{} over {key}, which makes most of its scatter.", self.quantity.words()),
        })
    }
}

fn landing(
    plan: &SweepPlan,
    sampled: &Sampled,
    rows: &[SweepRow],
    scatter: &Scatter,
) -> Result<Option<Figure>, StudyError> {
    let (Some(landing), Some(Points { labels, points, .. })) = (&scatter.landing, landing_points(sampled, rows)?)
    else {
        return Ok(None);
    };
    let ellipse = &landing.ellipse;
    let outline = |label: &str, points: Vec<(f64, f64)>, color: usize| Line {
        label: label.to_owned(),
        points,
        color: Some(color),
        series: label.to_owned(),
        ..Line::default()
    };
    let runs = Line {
        label: "runs".to_owned(),
        points: points.iter().map(|(point, _)| (point[0], point[1])).collect(),
        runs: points.iter().map(|(_, row)| row.job.id.clone()).collect(),
        marker: Marker::Dot,
        stroke: Stroke::None,
        color: Some(0),
        series: "runs".to_owned(),
        ..Line::default()
    };
    let [x, y] = labels.map(Axis::linear);
    let lines = vec![
        runs,
        outline("95 % ellipse", ellipse.outline(), 1),
        outline("circle with half of the points", ellipse.half_circle(), 2),
    ];
    Ok(Some(Figure {
        chart: Chart {
            title: format!("{}: {}", plan.name, landing.columns.join(" and ")),
            x,
            y,
            lines,
            equal_units: true,
            size: Size::default(),
            ..Chart::default()
        },
        caption: "Each run in both columns, with the ellipse that holds 95 % of a normal distribution of the same \
                  covariance, and the circle around the mean that holds half of the runs."
            .to_owned(),
    }))
}
