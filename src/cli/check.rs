//! `canopy-fem check`: all faults, what is modelled, and every method's critical step, without solving anything.

use super::doubts::{check_solver, disk_doubt, place, step_doubt};
use super::{CaseArgs, CliError};
use crate::analysis::critical::{Confidence, CriticalStep, Spectrum};
use crate::case::Case;
use crate::case::spec::{Problem, SystemSpec};
use crate::drive::clock::{Step, Tolerance};
use crate::figures::figures;
use crate::integrate::registry::{Family, MethodChoice, methods};
use crate::model::spec::NetworkSpec;
use crate::output::names::file_stem;
use crate::scene::Scene;
use crate::simulation::build_scene;
use crate::solve::solver_for;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;

pub(super) fn run(args: &CaseArgs) -> Result<String, CliError> {
    let (mut problem, source) = Case::from_file(&args.case, &args.overrides())?.split();
    let system = problem.take_system();
    let mut text = format!("{}: no faults\n", problem.name);
    describe_system(&mut text, &system);
    let scene = build_scene(system, 1)?;
    let scene = &*scene;
    check_solver(&problem, scene, source)?;
    describe_terms(&mut text, scene);
    describe_cost(&mut text, &problem, scene);
    let state = scene.initial_state();
    let mut spectrum = Spectrum::of(scene, state.as_ref());
    describe_limits(&mut text, &problem, scene, &mut spectrum);
    let limit = spectrum.critical_step(&problem.method);
    let out = PathBuf::from("out").join(file_stem(&problem.name));
    let doubts = [step_doubt(&problem, scene, limit), disk_doubt(&problem, scene, &out)];
    for warning in problem.warnings.iter().chain(doubts.iter().flatten()) {
        let _ = writeln!(text, "warning: {warning}");
    }
    Ok(text)
}

fn describe_system(text: &mut String, system: &SystemSpec) {
    match system {
        SystemSpec::Pendulum(p) => {
            let _ = writeln!(
                text,
                "  pendulum        L = {} m, m = {} kg, c = {} N m s",
                figures(p.length, 12),
                figures(p.mass, 12),
                figures(p.damping, 12)
            );
        }
        SystemSpec::Network(spec) => {
            let NetworkSpec { mesh, mass, fixed, springs, .. } = &**spec;
            let n_springs: usize = springs.iter().map(|g| g.edges.len()).sum();
            let dashpots: usize = springs.iter().filter(|g| g.dashpot.is_some()).map(|g| g.edges.len()).sum();
            let held = fixed.as_flattened().iter().filter(|f| **f).count();
            let _ = writeln!(
                text,
                "  network         {} nodes, {n_springs} springs, {dashpots} dashpots, {} triangles",
                mesh.nodes.len(),
                mesh.triangles.len()
            );
            let _ = writeln!(text, "  mass            {} kg", figures(mass.iter().sum::<f64>(), 7));
            let _ = writeln!(text, "  unknowns        {} ({held} degrees of freedom held)", 3 * fixed.len() - held);
        }
    }
}

fn describe_terms(text: &mut String, scene: &dyn Scene) {
    let mut names: Vec<&str> = scene.terms().iter().map(|t| t.name).collect();
    names.dedup();
    let _ = writeln!(text, "  forces          {}", names.join(", "));
}

fn describe_cost(text: &mut String, problem: &Problem, scene: &dyn Scene) {
    let info = problem.method.info;
    let n = scene.n_dof();
    // Two states with their forces, split by role where the scene has the role, and the scheme's own vectors.
    let vectors = if info.family == Family::Implicit { 16 } else { 14 };
    let mut bytes = 8 * vectors * n;
    let _ = writeln!(
        text,
        "  method          {}, order {}, {}",
        info.name,
        problem.method.order(),
        match problem.time.step {
            Step::Fixed(step) => format!("step {} s", figures(step, 12)),
            Step::Adaptive(Tolerance { relative, absolute }) =>
                format!("adaptive steps, tolerance {relative:e} of the motion and {absolute:e}"),
        }
    );
    if info.family == Family::Implicit {
        let kind = if scene.symmetric() { "symmetric" } else { "not symmetric" };
        let analysed = scene.assembler().map_err(|e| e.to_string()).and_then(|a| {
            let solver = solver_for(a.pattern.clone(), problem.solver.linear).map_err(|e| e.to_string())?;
            Ok((a.pattern.n(), solver.stats()))
        });
        match analysed {
            Ok((unknowns, stats)) => {
                let factor = match stats.factor_nonzeros {
                    Some(entries) => format!("{entries} in its factor"),
                    None => "factor known after the first factorisation".to_owned(),
                };
                bytes += 16 * stats.matrix_nonzeros + 8 * stats.factor_nonzeros.unwrap_or(8 * stats.matrix_nonzeros);
                let _ = writeln!(
                    text,
                    "  tangent         {kind}, {unknowns} unknowns, {} entries, {factor}; solver {}",
                    stats.matrix_nonzeros, stats.name
                );
            }
            Err(why) => {
                let _ = writeln!(text, "  tangent         {kind}; {why}");
            }
        }
    } else {
        let _ = writeln!(text, "  tangent         not needed by this method");
    }
    let _ = writeln!(text, "  memory          about {:.1} MB without output", bytes as f64 / 1e6);
}

fn describe_limits(text: &mut String, problem: &Problem, scene: &dyn Scene, spectrum: &mut Spectrum<'_>) {
    describe_rates(text, scene, spectrum);
    let _ =
        writeln!(text, "\n  method                critical step [s]   this step / critical   known by          set by");
    for info in methods() {
        let choice = if info.name == problem.method.info.name {
            Some(problem.method.clone())
        } else {
            MethodChoice::new(info.name, &BTreeMap::new()).ok()
        };
        let Some(choice) = choice else { continue };
        if info.family == Family::MatrixFree && scene.abilities().graph.is_none() {
            let _ = writeln!(text, "  {:<20}  needs a network", info.name);
            continue;
        }
        let mark = if info.name == problem.method.info.name { '*' } else { ' ' };
        if info.family == Family::MatrixFree && scene.velocity_dependent() {
            let _ = writeln!(
                text,
                "{mark} {:<20}  none for springs; air and dashpots outside the filter: not known",
                info.name
            );
            continue;
        }
        let limit = spectrum.critical_step(&choice);
        let _ = writeln!(text, "{mark} {:<20}  {}", info.name, describe_limit(limit, problem.time.step, scene));
    }
    text.push_str(
        "  (* the method of this case; all at t = 0; certified: proved to be no more than the width below the true limit, and not \
         above it)\n\n",
    );
}

fn describe_rates(text: &mut String, scene: &dyn Scene, spectrum: &Spectrum<'_>) {
    let rates = spectrum.rates();
    let bound = match spectrum.frequency_bound() {
        Some(bound) => format!("to {bound:.4e} rad/s (proved)"),
        None => "rad/s (an estimate)".to_owned(),
    };
    let at = place(scene, rates.frequency_dof);
    let _ = writeln!(text, "  fastest motion  w = {:.4e} {bound} around {at}, at t = 0", rates.frequency);
    if rates.damping > 0.0 {
        let at = place(scene, rates.damping_dof);
        let _ = writeln!(text, "  most damped     {:.4e} 1/s (an estimate) around {at}", rates.damping);
    }
}

fn describe_limit(limit: CriticalStep, step: Step, scene: &dyn Scene) -> String {
    if limit.step.is_infinite() {
        return "none found".to_owned();
    }
    if limit.step == 0.0 {
        return format!("{:<18}  grows at every step without damping", "0");
    }
    let known = match (limit.confidence, limit.width()) {
        (Confidence::Certified { .. }, Some(width)) => format!("certified, {:.2} %", 100.0 * width),
        _ => "estimate".to_owned(),
    };
    let used = step.fixed().map_or_else(
        || "adaptive".to_owned(),
        |step| format!("{:.3}{}", step / limit.step, if step > limit.step { "  too large" } else { "" }),
    );
    format!("{:<18.3e}  {used:<21}  {known:<16}  {}", limit.step, place(scene, limit.dof))
}
