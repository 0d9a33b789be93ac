//! `canopy-fem solve`: the main job.

use super::doubts::{check_solver, disk_doubt, limit_of, step_doubt};
use super::progress::{Display, Progress};
use super::{CliError, Finished, SolveArgs, complain, fields};
use crate::assembly::write_matrix_market;
use crate::case::Case;
use crate::case::spec::Problem;
use crate::drive::observer::{LedgerRow, ObserveError, Observer, Point, StepView};
use crate::drive::{Failure, Outcome, RunSpec, Status};
use crate::figures::figures;
use crate::output::encode::VtuFormat;
use crate::output::folder::{ResultFolder, SUMMARY};
use crate::output::names::file_stem;
use crate::output::probes::Probe;
use crate::output::process::cpu_seconds;
use crate::output::recorder::{Recorder, RecorderSpec};
use crate::output::summary::{Cost, Summary};
use crate::scene::Scene;
use crate::simulation::{bind, build_scene};
use std::fmt::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Interrupts closer than this are one.
const SAME_INTERRUPT: Duration = Duration::from_millis(500);

pub(super) fn run(args: &SolveArgs) -> Result<Finished, CliError> {
    let (mut problem, source) = Case::from_file(&args.case.case, &args.case.overrides())?.split();
    if !args.quiet {
        problem.warnings.iter().for_each(|w| complain(&format!("warning: {w}")));
    }
    let scene = build_scene(problem.take_system(), usize::from(args.threads))?;
    check_solver(&problem, &*scene, source)?;
    let mut stepper = bind(&problem, &*scene)?;
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from("out").join(file_stem(&problem.name)));
    // Before any file is made, so that no interrupt leaves results without a summary.
    let stop = stop_on_interrupt();
    let folder = ResultFolder::prepare(&out, &problem.name, args.force)?;
    let limit = limit_of(&problem, &*scene);
    if !args.quiet {
        let doubts = [step_doubt(&problem, &*scene, limit), disk_doubt(&problem, &*scene, &out)];
        doubts.iter().flatten().for_each(|doubt| complain(&format!("warning: {doubt}")));
    }
    if let Some(dir) = &args.dump_matrices {
        let state = scene.initial_state();
        write_matrix_market(&*scene, state.as_ref(), dir, &|dof| scene.name_of(dof))?;
    }
    let mut recorder = Recorder::new(&*scene, &recorder_spec(&problem, &folder))?;
    let mut progress = Progress::new(problem.time.end, if args.quiet { Display::Quiet } else { Display::Terminal });
    let mut farthest = Farthest::new(&*scene);
    let spec = RunSpec {
        end: problem.time.end,
        step: problem.time.step,
        keep_going: args.keep_going,
        method: problem.method.info,
    };
    let (started, cpu) = (Instant::now(), cpu_seconds());
    let outcome =
        crate::drive::run(&*scene, &mut stepper, spec, &mut [&mut recorder, &mut progress, &mut farthest], &stop)?;
    let cost = Cost { cpu: cpu.and_then(|before| Some(cpu_seconds()? - before)), wall: started.elapsed() };
    let summary = Summary::new(&problem, &*scene, &outcome, limit.step, cost);
    summary.write(&folder.file(SUMMARY))?;
    if let Some(doubt) = energy_doubt(&outcome).filter(|_| !args.quiet) {
        complain(&doubt);
    }
    if let Some(failure) = &outcome.failure {
        complain(&describe(failure, outcome.status));
    }
    let text = if args.quiet { String::new() } else { report(&problem, &outcome, &summary, &folder, &farthest) };
    let code = match outcome.status {
        Status::Completed => 0,
        Status::Diverged | Status::NotConverged => 3,
        Status::Interrupted => 130,
    };
    Ok(Finished { text, code })
}

/// Energy made by the scheme, as a share of the energy exchanged, that makes a finished run doubtful.
const DOUBTFUL_GAIN: f64 = 0.1;

/// A word on a run that reached its end on energy its scheme made itself (Kuhl & Crisfield 1999 show it for Newmark).
fn energy_doubt(outcome: &Outcome) -> Option<String> {
    let doubtful =
        outcome.status == Status::Completed && outcome.energy_error > DOUBTFUL_GAIN && outcome.ledger.numerical < 0.0;
    doubtful.then(|| {
        format!(
            "warning: the scheme itself has made energy, up to {:.0} % of what was exchanged ({:.3e} J at the end); do not trust \
             this run: use a smaller step, some damping, or a method that damps, such as backward-euler",
            100.0 * outcome.energy_error,
            -outcome.ledger.numerical
        )
    })
}

fn recorder_spec(problem: &Problem, folder: &ResultFolder) -> RecorderSpec {
    let output = &problem.output;
    RecorderSpec {
        name: problem.name.clone(),
        out_dir: folder.dir().to_owned(),
        frames_every: output.frames_every,
        end: problem.time.end,
        fields: fields(&output.fields),
        probes: output.probes.iter().map(|p| Probe { name: p.name.clone(), nodes: p.nodes.clone() }).collect(),
        history_every: output.history_every,
        format: VtuFormat::default(),
    }
}

/// Sets the flag at the first Ctrl-C; the run then ends after the step it is in. A second Ctrl-C ends the program at once,
/// unless it follows so closely that it is the same one, passed on by a wrapper.
fn stop_on_interrupt() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    let mut first: Option<Instant> = None;
    let handler = move || {
        flag.store(true, Ordering::Relaxed);
        if first.get_or_insert_with(Instant::now).elapsed() > SAME_INTERRUPT {
            std::process::exit(130);
        }
    };
    // Without a handler Ctrl-C still ends the program, only without a summary.
    if let Err(e) = ctrlc::set_handler(handler) {
        complain(&format!("warning: Ctrl-C will not be caught: {e}"));
    }
    stop
}

fn report(
    problem: &Problem,
    outcome: &Outcome,
    summary: &Summary,
    folder: &ResultFolder,
    far: &Farthest<'_>,
) -> String {
    let status = match outcome.status {
        Status::Completed => "completed",
        Status::Diverged => "diverged",
        Status::NotConverged => "not converged",
        Status::Interrupted => "interrupted",
    };
    let c = outcome.counters;
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{}: {status} at t = {} s after {} steps of {}",
        problem.name,
        figures(outcome.t_end, 12),
        outcome.steps,
        problem.method.info.name
    );
    let cpu = summary.cpu_seconds.map_or_else(|| "unknown".to_owned(), |s| format!("{s:.2} s"));
    let _ = writeln!(text, "  cost            {cpu} CPU, {:.2} s wall", summary.wall_seconds);
    let _ = writeln!(
        text,
        "  work            {} force passes, {} factorisations, {} Newton iterations",
        c.force_evaluations, c.factorizations, c.newton_iterations
    );
    let _ = writeln!(text, "  energy error    {:.2e} of the largest energy exchanged", outcome.energy_error);
    if let Some(step) = summary.critical_step {
        let _ = writeln!(
            text,
            "  critical step   about {step:.2e} s at the start ({:.2} of it used)",
            problem.time.step / step
        );
    }
    let _ = writeln!(text, "  displacement    {:.6} m at most at the end, node {}", far.distance, far.node);
    let _ = writeln!(text, "  results         {}", folder.dir().join(format!("{}.pvd", folder.stem())).display());
    text
}

fn describe(failure: &Failure, status: Status) -> String {
    let what = if status == Status::NotConverged { "could not be solved" } else { "diverged" };
    let mut text = format!("error: step {} ending at t = {:.6e} s {what}\n", failure.step, failure.time);
    let named = |what: &str, number: Option<u32>| number.map(|n| format!("{what} {n}"));
    let term = failure.term.as_ref().map(|t| format!("most force from {t}"));
    let place: Vec<String> =
        [named("node", failure.node), named("spring", failure.spring), term].into_iter().flatten().collect();
    if !place.is_empty() {
        let _ = writeln!(text, "  where   {}", place.join(", "));
    }
    let _ = writeln!(text, "  cause   {}", failure.cause);
    let _ = writeln!(text, "  advice  {}", failure.advice);
    text
}

/// The largest displacement at the end, for the report.
struct Farthest<'a> {
    scene: &'a dyn Scene,
    node: usize,
    /// [m]
    distance: f64,
}

impl<'a> Farthest<'a> {
    fn new(scene: &'a dyn Scene) -> Self {
        Farthest { scene, node: 0, distance: 0.0 }
    }
}

impl Observer for Farthest<'_> {
    fn started(&mut self, _at: &Point, _ledger: LedgerRow) -> Result<(), ObserveError> {
        Ok(())
    }

    fn accepted(&mut self, _step: StepView<'_>) -> Result<(), ObserveError> {
        Ok(())
    }

    fn finished(&mut self, last: &Point) -> Result<(), ObserveError> {
        let reference = self.scene.reference();
        let (mut x, mut v) = (vec![[0.0; 3]; reference.len()], vec![[0.0; 3]; reference.len()]);
        self.scene.trace(last.state.as_ref(), &mut x, &mut v);
        for (node, (x, o)) in x.iter().zip(reference).enumerate() {
            let d = (0..3).map(|c| (x[c] - o[c]).powi(2)).sum::<f64>().sqrt();
            if d > self.distance {
                (self.node, self.distance) = (node, d);
            }
        }
        Ok(())
    }
}
