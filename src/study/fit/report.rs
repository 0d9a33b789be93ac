//! What a fit leaves for its reader: the values with their errors, the curves over the data, the case with the values.

use std::path::{Path, PathBuf};

use minijinja::context;
use serde::Serialize;

use super::estimate::Fitted;
use super::model::{Fit, OFFSET};
use crate::case::Case;
use crate::error::StudyError;
use crate::plan::PROGRAM;
use crate::plot::chart::{Axis, Chart, Line, Marker, Size, Stroke};
use crate::plot::layout::svg_grid;
use crate::report::{Machine, Rerun};
use crate::store::{remove, write_files};
use crate::template::{PageFigure, render};

/// All files a report has.
pub const FILES: [&str; 5] = ["fit.json", "fit.csv", "fit.svg", "fit.html", "fitted.json"];
/// [px] Charts of the page, on wide and on narrow screens.
const PAGE: [Size; 2] = [Size { width: 900, height: 480 }, Size { width: 460, height: 420 }];
/// [-] Correlation above which two values are told to be known together only.
const CORRELATED: f64 = 0.98;
/// Colours of the data and of the model.
const DATA: usize = 1;
const MODEL: usize = 0;

/// A fit and how it is shown.
pub struct FitReport<'a> {
    /// the case
    pub case: &'a Case,
    /// the fit
    pub fit: &'a Fit,
    /// how it was made
    pub how: &'a Rerun,
}

/// A point of the data beside the model.
#[derive(Serialize)]
struct Row<'a> {
    of: &'a str,
    t: f64,
    data: f64,
    model: f64,
    residual: f64,
}

impl FitReport<'_> {
    /// Writes the files into a folder; returns what the command prints.
    ///
    /// # Errors
    /// A picture or a page that cannot be made, or the system's answer.
    pub fn write(&self, out: &Path) -> Result<String, StudyError> {
        let &FitReport { case, fit, how } = self;
        let set: Vec<(String, String)> = fit
            .estimate
            .values
            .iter()
            .filter(|value| value.parameter.key != OFFSET)
            .map(|value| (value.parameter.key.clone(), format!("{:?}", value.value)))
            .collect();
        let fitted = case.with(&set)?.into_problem().case_json;
        let pretty = |value: &serde_json::Value| serde_json::to_string_pretty(value).map(|text| text + "\n");
        let case_json = pretty(&fitted).map_err(|e| StudyError::Page(e.to_string()))?;
        let (charts, rows, doubts) = (self.charts(), self.rows(), self.doubts());
        let table = context! { rows };
        let points: usize = fit.estimate.noise.iter().map(|noise| noise.points).sum();
        let words = context! { fit, doubts, points, name => case.problem().name };
        let figures: Vec<PageFigure> = charts
            .iter()
            .map(|(chart, caption)| PageFigure::of(chart, caption.as_str(), PAGE))
            .collect::<Result<_, _>>()?;
        let page = context! {
            version => PROGRAM, command => how.command, machine => how.machine, figures, case_json, ..words.clone(),
        };
        let drawn: Vec<Chart> = charts.into_iter().map(|(chart, _)| chart).collect();
        let made = [
            ("fit.json", self.json()?),
            ("fit.csv", render("fit.csv", include_str!("../templates/fit.csv"), &table)?),
            ("fit.svg", svg_grid(&drawn, 2)?),
            ("fit.html", render("fit.html", include_str!("../templates/fit.html"), &page)?),
            ("fitted.json", case_json),
        ];
        let files: Vec<PathBuf> = write_files(out, &FILES, &made)?;
        render("fit.txt", include_str!("../templates/fit.txt"), &context! { files, ..words })
    }

    /// `fit.json`: all that is known of a fit.
    fn json(&self) -> Result<String, StudyError> {
        #[derive(Serialize)]
        struct Json<'a> {
            version: &'a str,
            command: &'a str,
            #[serde(flatten)]
            fit: &'a Fit,
            doubts: Vec<String>,
            machine: &'a Machine,
        }
        let &FitReport { fit, how: Rerun { command, machine }, .. } = self;
        let json = Json { version: PROGRAM, command, fit, doubts: self.doubts(), machine };
        let text = serde_json::to_string_pretty(&json);
        Ok(text.map_err(|e| StudyError::Page(format!("fit.json: {e}")))? + "\n")
    }

    fn rows(&self) -> Vec<Row<'_>> {
        let mut model = self.fit.fitted.iter();
        let mut rows = Vec::new();
        for set in &self.fit.data {
            for ((&t, &data), &model) in set.t.iter().zip(&set.value).zip(model.by_ref()) {
                rows.push(Row { of: &set.of, t, data, model, residual: data - model });
            }
        }
        rows
    }

    /// What a reader should know before using the values.
    fn doubts(&self) -> Vec<String> {
        let estimate = &self.fit.estimate;
        let mut doubts = Vec::new();
        let key = |value: &Fitted| value.parameter.key.clone();
        for value in &estimate.values {
            if !value.determined {
                doubts
                    .push(format!("{} is not determined by the data: fix it, or add data that it acts on", key(value)));
            } else if value.at_end_of_range {
                doubts.push(format!("{} is at an end of its range: widen the range", key(value)));
            }
        }
        for (i, row) in estimate.correlation.iter().enumerate() {
            for (j, correlation) in row.iter().enumerate().take(i) {
                let strong = correlation.filter(|correlation| correlation.abs() > CORRELATED);
                if let (Some(c), Some(a), Some(b)) = (strong, estimate.values.get(j), estimate.values.get(i)) {
                    doubts.push(format!(
                        "{} and {} are known together only: the correlation of their errors is {c:.3}",
                        key(a),
                        key(b)
                    ));
                }
            }
        }
        let chi = estimate.reduced_chi_square.filter(|chi| !(0.5..=2.0).contains(chi));
        if let Some(chi) = chi {
            doubts.push(format!(
                "the residuals are {:.2} times the noise that the data give: {}",
                chi.sqrt(),
                if chi > 1.0 {
                    "the model lacks something, and the errors are too small"
                } else {
                    "the noise is smaller than given"
                }
            ));
        }
        let ended = |start: &super::model::StartResult| start.ended == Some(super::least_squares::Ended::TooMany);
        if self.fit.starts.get(self.fit.best).is_some_and(ended) {
            doubts.push("the search did not come to a minimum within its iterations".to_owned());
        }
        doubts
    }

    /// For each set of data the curve over it, and the residuals.
    fn charts(&self) -> Vec<(Chart, String)> {
        let fit = self.fit;
        let offset = fit.estimate.values.iter().find(|value| value.parameter.key == OFFSET).map_or(0.0, |v| v.value);
        let time = || Axis::linear("time t [s]");
        let mut charts = Vec::new();
        let mut first = 0;
        for (number, set) in fit.data.iter().enumerate() {
            let unit = fit.units.get(number).map_or("", String::as_str);
            let shifted = || set.t.iter().map(|t| t + offset);
            let data: Vec<(f64, f64)> = shifted().zip(set.value.iter().copied()).collect();
            let column = fit.curves.1.get(number).map(Vec::as_slice).unwrap_or_default();
            let model: Vec<(f64, f64)> = fit.curves.0.iter().copied().zip(column.iter().copied()).collect();
            let at_data = fit.fitted.get(first..first + set.t.len()).unwrap_or_default();
            first += set.t.len();
            let rest: Vec<(f64, f64)> = shifted().zip(set.value.iter().zip(at_data).map(|(d, m)| d - m)).collect();
            let marks = |label: &str, points| Line {
                label: label.to_owned(),
                points,
                stroke: Stroke::None,
                marker: Marker::Dot,
                color: Some(DATA),
                ..Line::default()
            };
            let title = format!("{} over {}", set.of, set.short());
            charts.push((
                Chart {
                    title: title.clone(),
                    x: time(),
                    y: Axis::linear(format!("{} [{unit}]", set.of)),
                    lines: vec![marks("data", data), Line { color: Some(MODEL), ..Line::new("model", model) }],
                    ..Chart::default()
                },
                format!("{title}: dots are the data, the line is the run with the fitted values."),
            ));
            charts.push((
                Chart {
                    title: format!("residuals of {}", set.of),
                    x: time(),
                    y: Axis::linear(format!("data less model [{unit}]")),
                    lines: vec![marks("", rest)],
                    ..Chart::default()
                },
                format!("Data less model of {}. A pattern here is what the model lacks.", set.of),
            ));
        }
        charts
    }
}

/// Removes the report of an earlier fit.
///
/// # Errors
/// The system's answer.
pub fn clear(out: &Path) -> Result<(), StudyError> {
    FILES.iter().try_for_each(|file| remove(&out.join(file)))
}
