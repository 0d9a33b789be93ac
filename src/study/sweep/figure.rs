//! Quantities over what varies: a curve, or a family of curves for several keys.

use super::plan::{SweepPlan, plain};
use super::run::SweepRow;
use super::table::{Quantity, named as column_named};
use super::vary::Vary;
use super::words::with_unit;
use crate::error::StudyError;
use crate::format_number::figures;
use crate::method_look::{curve_color, method_colors, method_mark};
use crate::model::quantity::OfLanding;
use crate::plot::chart::{Align, Axis, Chart, Line, MarginPanel, Marker, Note, PanelMark, PanelSide, Scale, Size};
use crate::report::style::failure;
use crate::row::RowStatus;
use serde_json::Value;

/// Quantities that are drawn if nobody asks for others.
const SHOWN: usize = 4;
/// Ratio of the largest to the smallest number above which an axis is logarithmic.
const WIDE: f64 = 100.0;
/// Longest name of a curve.
const LONGEST: usize = 40;
/// Significant digits in the name of a curve, the first that tell its number from the others.
const DIGITS: [usize; 3] = [3, 5, 8];
/// The key whose values are methods.
const METHOD: &str = "time.method";

/// What is drawn of a landing that nobody has asked for.
const LANDING: [OfLanding; 2] = [OfLanding::Speed, OfLanding::Drift];

/// The quantities that are drawn: the columns of `--plot`, else the quantities that are asked for, else the peaks of
/// the gauges and the landing, else motion and speed.
///
/// # Errors
/// A name that is no column of numbers.
pub(super) fn chosen<'q>(
    all: &'q [Quantity],
    (plan, rows): (&SweepPlan, &[SweepRow]),
    asked: &[String],
) -> Result<Vec<&'q Quantity>, StudyError> {
    if !asked.is_empty() {
        return asked.iter().map(|name| column_named(all, "--plot", name)).collect();
    }
    let by_case = plan.case.pointer("/study/quantities").and_then(Value::as_array);
    let in_case = |name: &str| by_case.is_some_and(|names| names.iter().any(|one| one.as_str() == Some(name)));
    let measured = |name: &str| rows.iter().any(|row| row.result.quantities.contains_key(name));
    // Those of a landing are always there.
    let of_landing = |name: &str| OfLanding::ALL.iter().any(|of| of.name() == name);
    let quantity = |Quantity { name, .. }: &&Quantity| measured(name) && (in_case(name) || !of_landing(name));
    let quantities: Vec<&Quantity> = all.iter().filter(quantity).collect();
    if !quantities.is_empty() {
        return Ok(quantities);
    }
    let peaks = || all.iter().filter(|quantity| quantity.name.ends_with(".peak"));
    // Sum and mean of a single spring or node are its largest value.
    let column = |quantity: &Quantity| rows.iter().map(|row| quantity.of(row)).collect::<Vec<_>>();
    let repeats = |quantity: &Quantity| {
        let largest = quantity.name.replace("_sum.", "_max.").replace("_mean.", "_max.");
        largest != quantity.name && peaks().any(|other| other.name == largest && column(other) == column(quantity))
    };
    let landing = all.iter().filter(|quantity| LANDING.iter().any(|of| of.name() == quantity.name));
    let peaks: Vec<&Quantity> = peaks().filter(|quantity| !repeats(quantity)).take(SHOWN).chain(landing).collect();
    let plain = ["displacement_end", "max_speed"];
    Ok(if peaks.is_empty() { all.iter().filter(|q| plain.contains(&q.name.as_str())).collect() } else { peaks })
}

/// The key along the horizontal axis: that with the most numbers; the first one where none has numbers.
pub(super) fn across(plan: &SweepPlan) -> Option<&Vary> {
    let numeric = plan.vary.iter().filter(|vary| vary.numbers().is_some());
    // The first of those with as many values.
    numeric.rev().max_by_key(|vary| vary.values.len()).or_else(|| plan.vary.first())
}

/// Values of a run in few words: those of all keys, or of all but one; of a sample, its number.
pub(super) fn named(plan: &SweepPlan, row: &SweepRow, without: &str) -> String {
    if plan.sampled.is_some() {
        return format!("run {}", row.job.run);
    }
    let keys = plan.vary.iter().filter(|vary| vary.key != without);
    let word = |vary: &Vary| Some(format!("{} = {}", short(&vary.key), rounded(vary, row.job.values.get(&vary.key)?)));
    keys.filter_map(word).collect::<Vec<_>>().join(", ")
}

/// The other keys of a run with their values: the name of its curve.
fn curve(plan: &SweepPlan, row: &SweepRow) -> String {
    let name = named(plan, row, across(plan).map_or("", |vary| vary.key.as_str()));
    match name.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", name.get(..end).unwrap_or_default()),
        None => name,
    }
}

/// A value with as many digits as tell it from the other ones.
fn rounded(vary: &Vary, value: &serde_json::Value) -> String {
    let numbers = vary.numbers().unwrap_or_default();
    let (Some(x), false) = (value.as_f64(), numbers.is_empty()) else { return plain(value) };
    let alone = |digits: &usize| {
        let text = figures(x, *digits);
        numbers.iter().filter(|other| figures(**other, *digits) == text).count() <= 1
    };
    DIGITS.into_iter().find(alone).map_or_else(|| plain(value), |digits| figures(x, digits))
}

/// Colours and marks of the curves, each given by its first run: a curve of a method has the method's.
fn looks(picture: &Picture<'_>, curves: &[&SweepRow]) -> Vec<(usize, Marker)> {
    let mut others = picture.plan.vary.iter().filter(|vary| vary.key != picture.vary.key);
    let only = others.next().is_some_and(|vary| vary.key == METHOD) && others.next().is_none();
    let method = |row: &&'_ SweepRow| row.job.values.get(METHOD).and_then(method_name).filter(|_| only);
    let names: Option<Vec<String>> = curves.iter().map(method).collect();
    match names {
        Some(names) => {
            let marks = names.iter().map(|name| method_mark(name));
            method_colors(names.iter().map(String::as_str)).into_iter().zip(marks).collect()
        }
        None => (0..curves.len()).map(|number| (curve_color(number), Marker::Dot)).collect(),
    }
}

/// The name in a value of `time.method`: a word, or an object whose only key it is.
fn method_name(value: &serde_json::Value) -> Option<String> {
    value.as_str().map(str::to_owned).or_else(|| value.as_object()?.keys().next().cloned())
}

/// The end of a key, from its last word on that is no number of an entry.
pub(super) fn short(key: &str) -> &str {
    let word = key.rsplit('.').find(|word| word.parse::<usize>().is_err()).unwrap_or(key);
    key.rfind(word).and_then(|at| key.get(at..)).unwrap_or(key)
}

/// One chart a quantity.
pub(super) fn charts(plan: &SweepPlan, rows: &[SweepRow], shown: &[&Quantity], size: Size) -> Vec<Chart> {
    let Some(vary) = across(plan) else { return Vec::new() };
    shown.iter().map(|quantity| chart(&Picture { plan, rows, vary, quantity }, size)).collect()
}

struct Picture<'a> {
    plan: &'a SweepPlan,
    rows: &'a [SweepRow],
    vary: &'a Vary,
    quantity: &'a Quantity,
}

impl Picture<'_> {
    /// The place of a run along the axis: its value, or the number of a value that is no number.
    fn place(&self, row: &SweepRow) -> f64 {
        let value = row.job.values.get(&self.vary.key);
        let number = || self.vary.values.iter().position(|v| Some(v) == value).map_or(f64::NAN, |i| i as f64);
        match self.vary.numbers() {
            Some(_) => value.and_then(serde_json::Value::as_f64).unwrap_or(f64::NAN),
            None => number(),
        }
    }

    fn axis(&self) -> Axis {
        match self.vary.numbers() {
            Some(numbers) => {
                Axis { label: with_unit(&self.vary.key), scale: scale(&numbers, self.vary.log), range: None }
            }
            None => {
                let names = self.vary.values.iter().enumerate().map(|(i, v)| format!("{i} = {}", plain(v)));
                Axis::linear(format!("{}: {}", self.vary.key, names.collect::<Vec<_>>().join(", ")))
            }
        }
    }
}

/// Logarithmic if the numbers are above 0 and wide apart.
fn scale(numbers: &[f64], asked: bool) -> Scale {
    let (low, high) = numbers.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), x| (low.min(*x), high.max(*x)));
    if low > 0.0 && (asked || high > WIDE * low) { Scale::Log } else { Scale::Linear }
}

fn chart(picture: &Picture<'_>, size: Size) -> Chart {
    let &Picture { plan, rows, quantity, .. } = picture;
    let mut names: Vec<String> = Vec::new();
    let mut curves: Vec<Vec<(f64, f64, &SweepRow)>> = Vec::new();
    for row in rows {
        let name = curve(plan, row);
        let number = names.iter().position(|other| *other == name).unwrap_or_else(|| {
            names.push(name);
            curves.push(Vec::new());
            names.len() - 1
        });
        // A run without a result interrupts its curve.
        let y = quantity.of(row).filter(|_| row.result.status == RowStatus::Completed);
        if let Some(curve) = curves.get_mut(number) {
            curve.push((picture.place(row), y.unwrap_or(f64::NAN), row));
        }
    }
    let first: Vec<&SweepRow> = curves.iter().filter_map(|curve| Some(curve.first()?.2)).collect();
    let looks = looks(picture, &first);
    let found: Vec<f64> = rows.iter().filter_map(|row| quantity.of(row)).collect();
    let (mut lines, mut marks) = (Vec::new(), Vec::new());
    for ((series, mut curve), (color, marker)) in names.into_iter().zip(curves).zip(looks) {
        curve.sort_by(|a, b| a.0.total_cmp(&b.0));
        marks.extend(curve.iter().filter(|(_, y, _)| y.is_nan()).map(|(x, _, row)| PanelMark {
            at: Some(*x),
            marker: failure(row.result.status).unwrap_or(Marker::Cross),
            color,
            series: series.clone(),
            run: row.job.id.clone(),
        }));
        lines.push(Line {
            label: series.clone(),
            points: curve.iter().map(|(x, y, _)| (*x, *y)).collect(),
            runs: curve.iter().map(|(_, _, row)| row.job.id.clone()).collect(),
            marker,
            color: Some(color),
            series,
            ..Line::default()
        });
    }
    let x = picture.axis();
    let nothing = Note { at: middle(picture, x.scale), text: "no run has this number".to_owned(), align: Align::Above };
    Chart {
        title: format!("{}: {}", plan.name, quantity.words()),
        lines,
        y: Axis { label: quantity.label(), scale: scale(&found, false), range: found.is_empty().then_some((0.0, 1.0)) },
        notes: if found.is_empty() { vec![nothing] } else { Vec::new() },
        margin_panel: (!marks.is_empty()).then(|| MarginPanel {
            side: PanelSide::Top,
            label: "no result".to_owned(),
            marks,
        }),
        x: Axis { range: ends(picture, x.scale), ..x },
        size,
        ..Chart::default()
    }
}

/// The ends of the axis, with a margin: runs without a result count too.
fn ends(picture: &Picture<'_>, scale: Scale) -> Option<(f64, f64)> {
    let places: Vec<f64> = picture.rows.iter().map(|row| picture.place(row)).collect();
    let (low, high) = places.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
    if !low.is_finite() || !high.is_finite() {
        return None;
    }
    Some(match scale {
        Scale::Log => {
            let margin = (high / low).powf(0.04).max(1.05);
            (low / margin, high * margin)
        }
        Scale::Linear => {
            let margin = if high > low { 0.04 * (high - low) } else { 0.05 * low.abs().max(1.0) };
            (low - margin, high + margin)
        }
    })
}

fn middle(picture: &Picture<'_>, scale: Scale) -> (f64, f64) {
    let (low, high) = ends(picture, scale).unwrap_or((0.0, 1.0));
    (if scale == Scale::Log { (low * high).sqrt() } else { f64::midpoint(low, high) }, 0.5)
}
