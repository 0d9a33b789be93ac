//! Warnings that need the built scene: a step above the critical one, frames that do not fit on the disk. `check` and
//! `solve` use the same.

use std::path::Path;

use crate::analysis::critical::CriticalStep;
use crate::analysis::warnings::{Planned, mass_warning, step_warning};
use crate::case::spec::Problem;
use crate::format_number::figures;
use crate::model::stop::Stop;
use crate::output::space::{frame_bytes, free_bytes};
use crate::scene::Scene;
use crate::warning::{Warning, WarningCode};

/// The method of a case on its scene.
pub(super) fn planned<'a>(problem: &'a Problem, scene: &'a dyn Scene, stop: Stop<'a>) -> Planned<'a> {
    let step = problem.time.step.fixed().map(|step| step.min(problem.time.end));
    Planned { scene, method: &problem.method, step, end: problem.time.end, stop }
}

/// All warnings that need the built scene; `limit` is the critical step at its start.
pub(super) fn of_scene(planned: Planned<'_>, problem: &Problem, limit: CriticalStep, out: &Path) -> Vec<Warning> {
    let Planned { scene, .. } = planned;
    let all = [mass_warning(scene), step_warning(planned, limit), disk_warning(problem, scene, out)];
    all.into_iter().flatten().collect()
}

/// Warning for frames that will not fit on the disk of `out`.
fn disk_warning(problem: &Problem, scene: &dyn Scene, out: &Path) -> Option<Warning> {
    let every = problem.output.frames_every;
    let frames = 1.0 + every.map_or(1.0, |every| (problem.time.end / every).ceil());
    let fields = (&problem.output).into();
    let bytes = frame_bytes(scene, fields, problem.output.format.precision) as f64;
    let free = free_bytes(out)? as f64;
    (frames * bytes > free).then(|| {
        let text = format!(
            "the frames need about {} ({} of {} each), but only {} are free where {} is; raise output.frames.every",
            size(frames * bytes),
            figures(frames, 6),
            size(bytes),
            size(free),
            out.display()
        );
        Warning::new(WarningCode::DiskSpace, text)
    })
}

/// A number of bytes in the unit that suits it.
fn size(bytes: f64) -> String {
    let units = [(1e12, "TB"), (1e9, "GB"), (1e6, "MB"), (1e3, "kB")];
    let unit = units.into_iter().find(|(unit, _)| bytes >= *unit).unwrap_or((1.0, "bytes"));
    format!("{} {}", figures(bytes / unit.0, 3), unit.1)
}
