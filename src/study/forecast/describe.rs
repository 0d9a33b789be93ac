//! The text of a forecast: costs of force passes and tangents, runs of all methods, and what is recommended.

use std::fmt::Write;

use super::advice::{Advice, Choice};
use super::cost::{ForceCost, TangentCost};
use super::estimate::{Basis, Estimate};
use super::search::KnownBy;
use super::{Forecast, MethodForecast};
use crate::case::spec::Problem;
use crate::format_number::figures;
use crate::integrate::registry::Family;
use crate::solve::Prediction;

/// Factors below are within what predictions are worth.
const TIE: f64 = 1.3;

/// The forecast as text: the tangent, a force pass, the output, the runs of all methods, and what is recommended.
pub fn describe(problem: &Problem, forecast: &Forecast) -> String {
    let text = &mut String::new();
    describe_tangent(text, problem, forecast);
    let own = forecast.methods.iter().find(|row| row.method == problem.method.info.name);
    if let Some(row) = own {
        let _ = writeln!(text, "  memory          about {:.1} MB with output", row.memory_bytes as f64 / 1e6);
    }
    describe_force(text, &forecast.force);
    let output = &forecast.output;
    let _ = writeln!(
        text,
        "  output          {} frames of {:.3} MB, {} each; {} a row of history",
        figures(output.frames, 12),
        output.frame_bytes as f64 / 1e6,
        seconds(output.frame_seconds),
        seconds(output.row_seconds)
    );
    describe_runs(text, problem, forecast);
    if let Some(advice) = &forecast.advice {
        describe_advice(text, advice);
    }
    text.push('\n');
    std::mem::take(text)
}

fn describe_tangent(text: &mut String, problem: &Problem, forecast: &Forecast) {
    let needed = match problem.method.info.family {
        Family::Implicit => "",
        Family::Explicit | Family::MatrixFree => "not needed by this method; for implicit ones ",
    };
    let Some(tangent) = &forecast.tangent else {
        let why = forecast.tangent_refused.as_deref().unwrap_or("cannot be made");
        let _ = writeln!(text, "  tangent         {needed}{why}");
        return;
    };
    let &TangentCost { unknowns, matrix_nonzeros, linear_solver, .. } = tangent;
    let kind = if tangent.symmetric { "symmetric" } else { "not symmetric" };
    let factor = match tangent.factor_nonzeros {
        Some(entries) => format!("{entries} in its factor"),
        None if linear_solver == "cg" => spared(tangent),
        None => "factor known after the first factorisation".to_owned(),
    };
    let part =
        if linear_solver != "lu" && !tangent.symmetric { " of its symmetric part, kept over many steps" } else { "" };
    let unknowns = if unknowns == 1 { "1 unknown".to_owned() } else { format!("{unknowns} unknowns") };
    let _ = writeln!(
        text,
        "  tangent         {needed}{kind}, {unknowns}, {matrix_nonzeros} entries, {factor}; solver {linear_solver}{part}"
    );
    let _ = writeln!(
        text,
        "                  {} an assembly, {} a factorisation, {} a solve{}; {} to analyse, once",
        seconds(tangent.assembly_seconds),
        seconds(tangent.factorization_seconds),
        seconds(tangent.solve_seconds),
        if tangent.measured { "" } else { " (estimated from counts)" },
        seconds(tangent.analysis_seconds)
    );
}

/// The factor that conjugate gradients do without.
fn spared(tangent: &TangentCost) -> String {
    let iterations = tangent.cg_iterations;
    match tangent.prediction {
        Some(Prediction { factor_nonzeros, .. }) => format!(
            "{iterations} iterations a solve instead of a factor with {} entries ({:.1} MB)",
            figures(factor_nonzeros, 3),
            8e-6 * factor_nonzeros
        ),
        None => format!("{iterations} iterations a solve, no factor"),
    }
}

fn describe_force(text: &mut String, force: &ForceCost) {
    let _ = writeln!(text, "  force pass      {}", seconds(force.pass_seconds));
    for term in &force.terms {
        let (Some(elements), Some(spent)) = (term.elements, term.seconds) else { continue };
        let _ = writeln!(
            text,
            "    {:<28}  {:>9} alone  {elements} elements, {:.1} ns each",
            term.name,
            seconds(spent),
            1e9 * spent / elements.max(1) as f64
        );
    }
}

fn describe_runs(text: &mut String, problem: &Problem, forecast: &Forecast) {
    let _ = writeln!(
        text,
        "\n  method                step [s]       steps      a step     whole run    memory [MB]   (predicted, until t = {} s)",
        figures(problem.time.end, 12)
    );
    for row in &forecast.methods {
        let mark = if row.method == problem.method.info.name { '*' } else { ' ' };
        let _ = writeln!(text, "{mark} {:<20}  {}", row.method, run_of(row));
    }
    if forecast.methods.iter().any(|row| row.step_reduced) {
        text.push_str("  (< the case's step is not stable with this method: a smaller one)\n");
    }
    if forecast.methods.iter().any(|row| row.run.is_some_and(|run| run.doubtful)) {
        text.push_str("  (? adaptive steps that change along the run, of which only parts were tried: may cost many times more)\n");
    }
    if forecast.methods.iter().any(|row| row.run.is_some_and(|run| run.basis == Basis::Counts)) {
        text.push_str(
            "  (~ not tried: from the cost of a force pass and of a tangent, and iterations counted with another method, or two a step)\n",
        );
    }
}

fn run_of(row: &MethodForecast) -> String {
    let Some(run) = &row.run else {
        // The first clause; the rest of a diagnosis is for those who run it.
        let why = row.refused.as_deref().unwrap_or("no prediction");
        return why.split_once("; ").map_or(why, |(first, _)| first).to_owned();
    };
    let Estimate { steps, mean_step, step_seconds, cpu_seconds, basis, doubtful, .. } = *run;
    let step = match row.step {
        Some(step) => format!("{}{}", figures(step, 3), if row.step_reduced { " <" } else { "" }),
        None => format!("~{mean_step:.1e}"),
    };
    let memory = row.memory_bytes as f64 / 1e6;
    format!(
        "{step:<12} {:>7}  {:>10}    {:>10}{}   {memory:>9.1}",
        count(steps),
        seconds(step_seconds),
        seconds(cpu_seconds),
        match basis {
            Basis::Counts => '~',
            Basis::Steps if doubtful => '?',
            Basis::Steps => ' ',
        }
    )
}

fn describe_advice(text: &mut String, advice: &Advice) {
    let Advice { accuracy, compared, best, runner_up, factor, own_cheaper } = advice;
    let _ = write!(text, "\n  for {accuracy:e} use {}", options(best));
    if let (Some(other), Some(factor)) = (runner_up, factor) {
        let concluded = |choice: &Choice| choice.known_by == KnownBy::LocalErrors;
        let than = if *factor < 1.0 / TIE {
            format!(
                "single steps promise, by counted work, {} times cheaper integration with",
                figures(1.0 / factor, 2)
            )
        } else if *factor < TIE {
            "by counted work, output apart, about as cheap as".to_owned()
        } else {
            format!("by counted work, output apart, {} times cheaper than", figures(*factor, 2))
        };
        let but = if concluded(other) && !concluded(best) { ", which could not be compared" } else { "" };
        let _ = write!(text, ";\n  {than} {}{but}", options(other));
    }
    let _ = writeln!(text, "\n  ({}; `canopy-fem tradeoff` measures all methods)", known_by(best, *compared));
    if let Some(times) = own_cheaper {
        let _ = writeln!(
            text,
            "  (the run of the case itself is {} times cheaper by counted work; its error is not known)",
            figures(*times, 2)
        );
    }
}

/// How the error of what is recommended is known.
fn known_by(best: &Choice, compared: f64) -> String {
    let error = best.step_error.map_or_else(String::new, |error| format!("{error:.1e}"));
    let part = 100.0 * compared;
    match best.known_by {
        KnownBy::Run => format!("the step was run to the end: error {error} against dop853"),
        KnownBy::Part => format!("the step was run over the first {part:.1} %: error {error} expected at the end"),
        KnownBy::LongerSteps => {
            format!("longer steps were run over the first {part:.1} %: error {error} expected of this one at the end")
        }
        KnownBy::TwiceTheStep => format!(
            "error {error} expected from the difference of two runs, one with twice the step of the other; not compared with a reference"
        ),
        KnownBy::LocalErrors => "from the errors of single steps; what they add up to is not known".to_owned(),
    }
}

/// `newmark --step 9e-4 (0.2 s) or --tolerance 1e-3 (0.3 s)`
fn options(choice: &Choice) -> String {
    let Choice { method, tolerance, cpu_seconds, step, fixed, .. } = choice;
    let about = |spent: Option<f64>| spent.map_or_else(String::new, |spent| format!(" (about {})", seconds(spent)));
    let fixed = about(fixed.map(|fixed| fixed.cpu_seconds));
    format!("{method} --step {}{fixed} or --tolerance {tolerance:e}{}", figures(*step, 2), about(*cpu_seconds))
}

fn count(steps: f64) -> String {
    if steps < 1e7 { format!("{steps:.0}") } else { format!("{steps:.1e}") }
}

/// A time in the unit that suits it.
fn seconds(t: f64) -> String {
    let units = [(3600.0, "h"), (1.0, "s"), (1e-3, "ms"), (1e-6, "us")];
    let (unit, name) = units.into_iter().find(|(unit, _)| t >= *unit).unwrap_or((1e-9, "ns"));
    format!("{} {name}", figures(t / unit, 3))
}
