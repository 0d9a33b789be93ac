//! Section 3.1: the parachute that could not be made stable, Table 4 and Figures 14 and 15.

use super::page::{Caption, Section, cell};
use super::readings::{Reading, blow_up};
use super::runs::{Failed, asset, changed, run, run_to_the_end};
use super::wire::wireframe;
use canopy_fem::analysis::critical::Spectrum;
use canopy_fem::analysis::limit::critical_step;
use canopy_fem::analysis::rates::Rates;
use canopy_fem::case::Case;
use canopy_fem::drive::{Outcome, Status};
use canopy_fem::plot::chart::{Axis, Chart, Line};
use canopy_fem::simulation::build_scene;
use rayon::prelude::*;
use std::path::Path;

/// Rows of Table 4 with the thesis' times of divergence [s]; the last four are not in it.
const TABLE_4: [(&str, &str, f64); 12] = [
    ("Explicit Euler", "explicit-euler", 3.3e-11),
    ("Velocity Verlet", "velocity-verlet", 3.4e-11),
    ("4th Runge-Kutta", "rk4", 3.4e-11),
    ("Newmark", "newmark", 3.5e-11),
    ("HHT", "hht", 3.5e-11),
    ("Euler Cromer", "euler-cromer", 3.4e-11),
    ("Improved Explicit Euler (Heun)", "improved-euler", 1.16e-10),
    ("Improved Explicit Euler (one pass)", "improved-euler-pec", 1.16e-10),
    ("Euler Richardson", "euler-richardson", 3.2e-11),
    ("Kang", "kang", f64::NAN),
    ("Backward Euler", "backward-euler", f64::NAN),
    ("Generalised alpha", "generalized-alpha", f64::NAN),
];

pub fn section(out: &Path) -> Result<Section, Failed> {
    let mut s = Section::new("Parachute");
    s.text(
        "Tables 3 and 4: 703 nodes, V = 1e12 m/s (3336 times the speed of light), steps of 1e-12 s. The \
            thesis does not give the mass, the cloth's porosity or its thickness: 1 kg/m^2, 0.9, pores of 1 mm \
            and 0.1 mm here, with Ergun's law as printed.",
    );
    table_4(&mut s)?;
    outlier(&mut s)?;
    who_acts(&mut s)?;
    pictures(out, &mut s)?;
    sensible_wind(out, &mut s)?;
    Ok(s)
}

fn table_4(s: &mut Section) -> Result<(), Failed> {
    let base = asset("parachute-original", &[])?;
    let outcomes: Vec<Result<Outcome, Failed>> = TABLE_4
        .par_iter()
        .map(|(_, method, _)| run_to_the_end(&changed(&base, &[("time.method", method)])?, |_| {}))
        .collect();
    let mut rows = Vec::new();
    for ((name, _, thesis), outcome) in TABLE_4.into_iter().zip(outcomes) {
        let outcome = outcome?;
        let thesis = if thesis.is_nan() { "-".to_owned() } else { format!("{thesis:.2e}") };
        let (how, time, term) = match (&outcome.failure, outcome.status) {
            (Some(f), Status::NotConverged) => ("step refused", format!("{:.2e}", f.time), f.term.clone()),
            (Some(f), _) => ("diverged", format!("{:.2e}", f.time), f.term.clone()),
            (None, _) => ("completed", format!("{:.2e}", outcome.t_end), None),
        };
        rows.push(vec![name.to_owned(), thesis, how.to_owned(), time, term.unwrap_or_else(|| "-".to_owned())]);
    }
    let heads = ["scheme", "thesis [s]", "ours", "at [s]", "force named by the report"];
    s.table(
        "Table 4: time of divergence, step 1e-12 s",
        &heads,
        rows,
        "Velocity Verlet, Runge-Kutta, Euler-Cromer and Euler-Richardson diverge within 3 steps of the \
            thesis' time. Not reproduced are explicit Euler, which goes the same way a few steps late and \
            holds to 4.6e-11 s, and Improved Euler (the table after next). Newmark and HHT do not diverge at \
            all: Newton's iteration carries them past the thesis' 3.5e-11 s until a step of 1e-12 s, in which \
            the air throws folded triangles over each other, has no solution that it finds; that step is \
            refused (next table). Every report names the air.",
    );
    implicit(s, &base)?;
    Ok(())
}

/// What the implicit schemes do there, at the thesis' step and below.
fn implicit(s: &mut Section, base: &Case) -> Result<(), Failed> {
    let mut jobs: Vec<(&str, &str)> = ["newmark", "hht", "generalized-alpha", "backward-euler"]
        .iter()
        .flat_map(|m| ["1e-12", "5e-13"].map(|h| (*m, h)))
        .collect();
    jobs.push(("backward-euler", "2e-13"));
    let outcomes: Vec<Result<Outcome, Failed>> = jobs
        .par_iter()
        .with_max_len(1)
        .map(|(method, h)| run(&changed(base, &[("time.method", method), ("time.step", h)])?, |_| {}))
        .collect();
    let mut rows = Vec::new();
    for ((method, h), outcome) in jobs.into_iter().zip(outcomes) {
        let outcome = outcome?;
        let end = match outcome.status {
            Status::Completed => "completed".to_owned(),
            _ => format!("a step refused at {:.2e}", outcome.t_end),
        };
        let newton = outcome.counters.newton_iterations as f64 / outcome.steps.max(1) as f64;
        rows.push(vec![method.to_owned(), h.to_owned(), end, format!("{newton:.1}"), cell(outcome.energy_error)]);
    }
    let heads = ["scheme", "step [s]", "end of the run to 1.5e-10 s", "iterations a step", "energy error"];
    s.table(
        "The implicit schemes on the same run (not in the thesis)",
        &heads,
        rows,
        "The air that stops the explicit schemes acts within 1e-12 s to 1e-11 s and ever faster as the \
            triangles stretch; an implicit step sees it at its end and follows. At 1e-12 s the schemes are \
            stable but one step moves nodes ten times as far as the triangles are wide, so the next state is \
            not the only solution and Newton may find none; below that every scheme completes the run. \
            Backward Euler damps most and is refused first, at the largest energy error. The thesis' Newmark \
            and HHT, solved once a step from a linear increment (Eq. 28-36), diverged with the explicit \
            schemes; such a scheme was not rebuilt here.",
    );
    Ok(())
}

/// The one outlier of Table 4 in every reading, and at smaller steps.
fn outlier(s: &mut Section) -> Result<(), Failed> {
    let base = asset("parachute-original", &[])?;
    let at_step =
        Reading::ALL.par_iter().map(|r| Ok((*r, blow_up(&base, *r, 1e-12)?))).collect::<Vec<Result<_, Failed>>>();
    let steps = [5e-13, 2e-13, 1.25e-13, 1e-13];
    let finer =
        steps.par_iter().map(|&h| Ok((h, blow_up(&base, Reading::Heun, h)?))).collect::<Vec<Result<_, Failed>>>();
    let mut rows = Vec::new();
    for entry in at_step {
        let (reading, time) = entry?;
        rows.push(vec![reading.name().to_owned(), "1e-12".to_owned(), when(time)]);
    }
    for entry in finer {
        let (h, time) = entry?;
        rows.push(vec![Reading::Heun.name().to_owned(), format!("{h:e}"), when(time)]);
    }
    let heads = ["reading of Improved Euler", "step [s]", "diverges at [s]"];
    s.table(
        "The outlier of Table 4: Improved Euler at 1.16e-10 s",
        &heads,
        rows,
        "Not reproduced: no reading of the scheme comes to half of it at the printed step. What moves the \
            time is the step: the smaller, the later, to any time one likes; Heun's passes 1.16e-10 s at an \
            eighth of 1e-12 s. A run with a smaller step, or a time axis counted in other steps, would give \
            the thesis' number; a property of the scheme does not.",
    );
    Ok(())
}

fn when(time: Option<f64>) -> String {
    time.map_or_else(|| "beyond 1.5e-10".to_owned(), |t| format!("{t:.2e}"))
}

/// Which force sets the limit: the air by seven orders.
fn who_acts(s: &mut Section) -> Result<(), Failed> {
    let fastest = |sets: &[(&str, &str)]| -> Result<(Rates, f64), Failed> {
        let case = asset("parachute-original", sets)?;
        let scene = build_scene(case.problem().system.clone(), 1)?;
        let rates = Spectrum::of(&*scene, scene.initial_state().as_ref()).rates();
        Ok((rates, critical_step(&case.problem().method, rates)))
    };
    let (_, springs) = fastest(&[("system.network.aero", "null")])?;
    let (air, _) = fastest(&[])?;
    let rows = vec![
        vec!["springs alone: 2/w, the limit of Verlet and Euler-Cromer".to_owned(), cell(springs)],
        vec!["air at t = 0, turning with the cloth: 1/w of its tangent in x".to_owned(), cell(1.0 / air.frequency)],
        vec!["air at t = 0, damping: m/(dF/dv)".to_owned(), cell(1.0 / air.damping)],
        vec!["step of the thesis".to_owned(), "1e-12".to_owned()],
        vec!["time of divergence".to_owned(), "3.4e-11".to_owned()],
    ];
    s.table(
        "Times in this scene [s]",
        &["what", "time [s]"],
        rows,
        "Table 4 says nothing about structural schemes: in 3.4e-11 s no spring oscillates, their fastest \
            motion takes a million times longer. All schemes diverge together because the same air, acting \
            within 1e-12 s to some 1e-11 s and faster as the triangles grow, is explicit in every one of them.",
    );
    Ok(())
}

fn pictures(out: &Path, s: &mut Section) -> Result<(), Failed> {
    let case = asset("parachute-original", &[])?;
    let edges = build_scene(case.problem().system.clone(), 1)?.edges().to_vec();
    let rows = [
        (
            "figure-14",
            "Figure 14: the canopy at 2.6e-11 s, velocity Verlet",
            2.6e-11,
            "Every free node has been thrown downstream, the outer ring is held; some nodes already fly apart \
            sideways.",
        ),
        (
            "figure-15",
            "Figure 15: the same canopy at 3.0e-11 s, its last state before the divergence",
            3.4e-11,
            "The thesis shows it at 3.4e-11 s; ours has by then left 1e4 m, so the last state before is shown: \
            single nodes are already 80 m away.",
        ),
    ];
    for (stem, caption, time, note) in rows {
        let mut at = Vec::new();
        run(&case, |seen| {
            if seen.t <= time * (1.0 + 1e-9) {
                at = seen.positions.to_vec();
            }
        })?;
        s.figure(out, Caption { stem, caption, note }, &[wireframe(&at, &edges)])?;
    }
    Ok(())
}

/// The same canopy in a wind that exists.
fn sensible_wind(out: &Path, s: &mut Section) -> Result<(), Failed> {
    let base = asset("parachute-50ms", &[])?;
    let runs = [("newmark", "1e-4", "0.05"), ("newmark", "1e-3", "0.5"), ("velocity-verlet", "1e-5", "0.5")];
    let results: Vec<Result<_, Failed>> = runs
        .par_iter()
        .map(|&(method, step, end)| {
            let case = changed(&base, &[("time.method", method), ("time.step", step), ("time.end", end)])?;
            let inner: Vec<usize> = case.problem().output.probes[0].nodes.iter().map(|&n| n as usize).collect();
            let mut points = Vec::new();
            let outcome = run(&case, |seen| {
                let height = inner.iter().map(|&n| seen.positions[n][2]).sum::<f64>() / inner.len() as f64;
                points.push((seen.t, height));
            })?;
            Ok((Line::new(format!("{method}, step {step} s"), points), outcome))
        })
        .collect();
    let mut lines = Vec::new();
    for result in results {
        let (line, outcome) = result?;
        if outcome.status != Status::Completed {
            return Err(format!("{}: {:?}", line.label, outcome.failure).into());
        }
        lines.push(line);
    }
    let chart = Chart {
        x: Axis::linear("time t [s]"),
        y: Axis::linear("height of the inner edge z [m]"),
        lines,
        ..Chart::default()
    };
    let caption = Caption {
        stem: "parachute-50ms",
        caption: "The same canopy at 50 m/s (not in the thesis)",
        note: "At 50 m/s the same canopy runs with Newmark at steps of 1e-4 s, 1e8 times the thesis' 1e-12 s, and \
            at 1e-3 s; every step converged. Velocity Verlet runs at 1e-5 s (its limit is 4.9e-5 s). The \
            thesis found that it exploded at 50 m/s as well, and blamed the missing fluid-structure coupling. \
            Not reproduced: here every scheme is stable far above 1e-12 s (explicit Euler, the worst, up to \
            1.4e-9 s), so neither the wind nor the step explains it; the cause is not in the text.",
    };
    s.figure(out, caption, &[chart])
}
