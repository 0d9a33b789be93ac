//! Work-precision diagrams: what an error costs, one line a method.

use super::parts::{Span, margin_panel, model_errors, nothing, rows, title};
use super::style::{Style, entry, legend, styles};
use super::{convergence, stiffness};
use crate::error::StudyError;
use crate::format_number::figures;
use crate::pareto::on_front;
use crate::plot::chart::{Align, Axis, Chart, Line, Marker, Note, PanelSide, Scale, Size, Stroke};
use crate::plot::layout::{Sample, legend_samples, svg_grid, svg_page};
use crate::ranking::Ranking;
use crate::recommendations::Recommendations;
use crate::row::{Row, StepSetting};
use crate::runner::Study;

/// A figure of the report.
#[derive(serde::Serialize)]
pub(super) struct Figure {
    /// name of its file
    pub file: &'static str,
    /// the picture
    #[serde(skip)]
    pub svg: String,
    /// the picture of the page, for wide screens
    pub wide: String,
    /// the picture of the page, for narrow screens
    pub narrow: String,
    /// pictures of the page of which a menu shows one, in place of the one above
    pub choices: Vec<Picture>,
}

/// A picture of the page with its name in a menu.
#[derive(serde::Serialize)]
pub(super) struct Picture {
    name: String,
    wide: String,
    narrow: String,
}

/// What the error in a work-precision diagram is the error of.
struct Choice<'a> {
    /// its name in the menu
    name: String,
    /// label of the axis
    label: String,
    /// one a variant
    rankings: Vec<Ranking<'a>>,
}

/// All choices: first what runs are ranked by, then each quantity, and the motion.
fn choices(study: &Study) -> Vec<Choice<'_>> {
    let plan = &study.plan;
    let numbers = || 0..plan.variants.len().max(1);
    let motion = || {
        let rankings = numbers().map(|number| Ranking::motion(plan.variants.get(number))).collect();
        Choice { name: "motion".to_owned(), label: MOTION.to_owned(), rankings }
    };
    let mut all = Vec::new();
    let set = Ranking::of(plan, 0).names();
    if set.len() > 1 {
        let rankings = numbers().map(|number| Ranking::of(plan, number)).collect();
        let name = format!("the worst of all {}", set.len());
        all.push(Choice { name, label: "error of the worst quantity [-]".to_owned(), rankings });
    } else if set.is_empty() {
        all.push(motion());
    }
    for quantity in plan.quantities() {
        let of = |number: usize| {
            let known = plan.variants.get(number).into_iter().flat_map(|variant| &variant.reference.quantities);
            Ranking::worst(known.filter(|other| other.name == quantity.name))
        };
        let unit = Ranking::worst(std::iter::once(quantity)).unit().to_owned();
        let relative = if quantity.scale.is_some() { ", relative" } else { "" };
        let label = format!("error of {}{relative} [{unit}]", quantity.name);
        all.push(Choice { name: quantity.name.clone(), label, rankings: numbers().map(of).collect() });
    }
    if !set.is_empty() {
        all.push(motion());
    }
    all
}

/// [px] Charts of the page: a single one, several side by side, and on narrow screens.
const PAGE: [Size; 3] =
    [Size { width: 1000, height: 600 }, Size { width: 560, height: 460 }, Size { width: 460, height: 440 }];

/// Label of the axis of errors of the motion.
pub(super) const MOTION: &str = "error, relative to the motion [-]";
/// The reference's error is part of the picture if it is at most so many decades off.
const FAR: f64 = 2.0;
/// Runs without a result whose cost is more than so many decades off that of all others stand at the end of the axis.
const CHEAP: f64 = 1.0;
/// [px] Height an entry of the legend needs, and what is around the legend.
const LEGEND: [u32; 2] = [22, 64];

/// All figures a study has.
///
/// # Errors
/// The drawing library's.
pub(super) fn all(study: &Study, answers: &Recommendations) -> Result<Vec<Figure>, StudyError> {
    let styles = styles(study);
    let cpu = Cost { label: "processor time [s]", ranked: true, of: |row| row.cpu_seconds };
    let force = Cost {
        label: "force evaluations",
        ranked: false,
        of: |row| Some(row.measured.counters.force_evaluations as f64).filter(|n| *n > 0.0),
    };
    let choices = choices(study);
    let Some(first) = choices.first() else { return Ok(Vec::new()) };
    let mut time =
        figure("tradeoff.svg", study, &styles, |number| work_precision(study, &styles, number, first, &cpu))?;
    for choice in choices.iter().filter(|_| choices.len() > 1) {
        let [wide, narrow] = of_page(study, |number| work_precision(study, &styles, number, choice, &cpu))?;
        time.choices.push(Picture { name: choice.name.clone(), wide, narrow });
    }
    let work = figure("work.svg", study, &styles, |number| work_precision(study, &styles, number, first, &force))?;
    let mut made = vec![time, work];
    if convergence::has_runs(study) {
        made.push(figure("convergence.svg", study, &styles, |v| convergence::chart(study, &styles, v))?);
    }
    if study.plan.variants.len() > 1 {
        let svg = stiffness::picture(study, answers)?;
        made.push(Figure { file: "stiffness.svg", wide: svg.clone(), narrow: svg.clone(), svg, choices: Vec::new() });
    }
    Ok(made)
}

/// The legend of the page: every method, and what marks mean.
pub(super) fn page_legend(study: &Study) -> Vec<Sample> {
    legend_samples(&legend(study, &styles(study)))
}

/// A figure as a file and for the page.
fn figure(
    file: &'static str,
    study: &Study,
    styles: &[Style],
    chart: impl Fn(usize) -> Chart,
) -> Result<Figure, StudyError> {
    let [wide, narrow] = of_page(study, &chart)?;
    Ok(Figure { file, svg: picture(study, styles, &chart)?, wide, narrow, choices: Vec::new() })
}

/// The charts of all variants for the page, on wide and on narrow screens.
fn of_page(study: &Study, chart: impl Fn(usize) -> Chart) -> Result<[String; 2], StudyError> {
    let count = study.plan.variants.len().max(1);
    let charts = |size: Size| -> Vec<Chart> { (0..count).map(|v| Chart { size, ..chart(v) }).collect() };
    let [one, several, narrow] = PAGE;
    let wide = svg_page(&charts(if count == 1 { one } else { several }), count.min(2))?;
    Ok([wide, svg_page(&charts(narrow), 1)?])
}

/// One chart a variant, side by side, with the legend of all.
fn picture(study: &Study, styles: &[Style], chart: impl Fn(usize) -> Chart) -> Result<String, StudyError> {
    let count = study.plan.variants.len().max(1);
    let columns = count.min(2);
    let mut charts: Vec<Chart> = (0..count).map(chart).collect();
    let rows = charts.len().div_ceil(columns) as u32;
    if let Some(first) = charts.first_mut() {
        let mut entries = legend(study, styles);
        // What a chart itself gives a name stands below.
        first.lines.sort_by_key(|line| !line.label.is_empty());
        let own = first.lines.iter().filter(|line| !line.label.is_empty()).count();
        let needed = LEGEND[0] * (entries.len() + own) as u32 + LEGEND[1];
        entries.append(&mut first.lines);
        first.lines = entries;
        let width = if columns == 1 { 1000 } else { 640 };
        first.size = Size { width, height: needed.div_ceil(rows).max(if columns == 1 { 620 } else { 440 }) };
    }
    Ok(svg_grid(&charts, columns)?)
}

/// A measure of cost.
struct Cost {
    label: &'static str,
    /// whether the Pareto front is that of this cost
    ranked: bool,
    of: fn(&Row) -> Option<f64>,
}

/// Error against cost.
fn work_precision(study: &Study, styles: &[Style], number: usize, choice: &Choice<'_>, cost: &Cost) -> Chart {
    let variant = study.plan.variants.get(number);
    let ranking = choice.rankings.get(number).cloned().unwrap_or_default();
    let bound = ranking.bound();
    let models = || model_errors(variant).filter(|_| choice.label == MOTION);
    let place = |row: &Row| Some((ranking.error(row)?, (cost.of)(row)?));
    let points: Vec<(f64, f64)> = rows(study, number).filter_map(place).collect();
    let costs = rows(study, number).filter_map(cost.of).filter(|c| *c > 0.0);
    let x = Span::of(points.iter().map(|p| p.0)).unwrap_or(Span::EMPTY).reaching(bound, FAR);
    let x = models().fold(x, |span, (_, error)| span.reaching(error, FAR));
    let y = match Span::of(points.iter().map(|p| p.1)) {
        Some(span) => {
            costs.fold(span, |wide, c| if span.reaching(c, CHEAP).has(c) { wide.reaching(c, FAR) } else { wide })
        }
        None => Span::of(costs).unwrap_or(Span::EMPTY),
    };
    let (x, y) = (x.with_margin(), y.with_margin());
    let at = |(error, cost): (f64, f64)| (x.held(error), y.held(cost));
    let mut lines = Vec::new();
    for style in styles {
        for setting in [StepSetting::Step(0.0), StepSetting::Tolerance(0.0)] {
            let mut runs: Vec<(f64, (f64, f64), &Row)> = rows(study, number)
                .filter(|row| style.is_of(row))
                .filter_map(|row| Some((same_kind(row.job.setting, setting)?, at(place(row)?), row)))
                .collect();
            runs.sort_by(|a, b| b.0.total_cmp(&a.0));
            if !runs.is_empty() {
                let (points, of) = runs.into_iter().map(|(_, at, row)| (at, row.job.id.clone())).unzip();
                lines.push(Line { runs: of, ..style.line(setting, points) });
            }
        }
    }
    if cost.ranked {
        let own: Vec<&Row> = rows(study, number).collect();
        let front = own.iter().zip(on_front(&own, &ranking)).filter(|(_, on)| *on);
        lines.extend(staircase(front.filter_map(|(row, _)| place(row).map(at)).collect(), [x, y]));
    }
    let mut notes = Vec::new();
    lines.extend(upright("reference", bound, [x, y], &mut notes));
    for (name, error) in models() {
        lines.extend(upright(&name, error, [x, y], &mut notes));
    }
    if points.is_empty() {
        let text = if ranking.unknown().is_empty() {
            nothing(study)
        } else {
            "the error of the reference is not known here".to_owned()
        };
        notes.push(Note { at: (x.middle(), y.middle()), text, align: Align::Above });
    }
    Chart {
        title: title(study, variant, "what accuracy costs"),
        x: Axis { label: choice.label.clone(), scale: Scale::Log, range: Some(x.ends()) },
        y: Axis { label: cost.label.to_owned(), scale: Scale::Log, range: Some(y.ends()) },
        lines,
        notes,
        margin_panel: margin_panel(study, styles, number, PanelSide::Right, |row| {
            place(row).is_none().then(|| (cost.of)(row))
        }),
        ..Chart::default()
    }
}

/// The step or tolerance of a run if it is of the same kind as another one's.
pub(super) fn same_kind(setting: StepSetting, kind: StepSetting) -> Option<f64> {
    match (setting, kind) {
        (StepSetting::Step(h), StepSetting::Step(_)) => Some(h),
        (StepSetting::Tolerance(t), StepSetting::Tolerance(_)) => Some(t),
        _ => None,
    }
}

/// The front as a staircase: the least that an error costs.
fn staircase(mut front: Vec<(f64, f64)>, [x, y]: [Span; 2]) -> Option<Line> {
    front.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut points: Vec<(f64, f64)> = Vec::new();
    for (error, cost) in front {
        let from = points.last().map_or(x.ends().1, |last| last.0);
        points.extend([(from, cost), (error, cost)]);
    }
    let last = points.last()?.0;
    points.push((last, y.ends().1));
    Some(Line { points, ..entry("Pareto front", Stroke::Fine, Marker::None) })
}

/// A line at an error, such as the bound below which nothing is ranked, and its name.
fn upright(name: &str, error: f64, [x, y]: [Span; 2], notes: &mut Vec<Note>) -> Option<Line> {
    if error <= 0.0 {
        return None;
    }
    let text = format!("{name} {}", figures(error, 2));
    let (low, high) = y.ends();
    if !x.has(error) {
        let text = format!("← {text}");
        notes.push(Note { at: (x.ends().0, low), text, align: Align::Right });
        return None;
    }
    let align = if error > x.middle() { Align::Left } else { Align::Right };
    notes.push(Note { at: (error, low), text, align });
    Some(Line { points: vec![(error, low), (error, high)], ..entry(name, Stroke::Dashed, Marker::None) })
}
