mod common;
use canopy_fem::output::hermite::interpolate;
use canopy_fem::drive::observer::*;
use canopy_fem::model::state::State;
use canopy_fem::simulation::{bind, build_scene};
use std::sync::atomic::AtomicBool;
struct Frames { times: Vec<f64>, next: usize, found: Vec<State> }
impl Observer for Frames {
    fn started(&mut self, at: &Point, _l: LedgerRow) -> Result<(), ObserveError> { self.found.push(at.state.clone()); self.next = 1; Ok(()) }
    fn accepted(&mut self, s: StepView<'_>) -> Result<(), ObserveError> {
        while self.next < self.times.len() && self.times[self.next] <= s.to.state.t * (1.0 + 1e-14) {
            let (a, b) = (&s.from.state, &s.to.state);
            let mut out = a.clone();
            interpolate(a.as_ref(), b.as_ref(), ((self.times[self.next] - a.t) / (b.t - a.t)).min(1.0), &mut out);
            self.found.push(out); self.next += 1;
        }
        Ok(())
    }
    fn finished(&mut self, _l: &Point) -> Result<(), ObserveError> { Ok(()) }
}
fn frames(case: &canopy_fem::case::Case) -> (canopy_fem::drive::Outcome, Vec<State>) {
    let mut problem = case.problem().clone();
    let scene = build_scene(problem.take_system(), 1).unwrap();
    let mut stepper = bind(&problem, &*scene).unwrap();
    let end = problem.time.end;
    let mut f = Frames { times: (0..=20).map(|k| end * k as f64 / 20.0).collect(), next: 0, found: vec![] };
    let out = canopy_fem::drive::run(&*scene, &mut stepper, problem.run_spec(false), &mut [&mut f], &AtomicBool::new(false)).unwrap();
    (out, f.found)
}
fn main() {
    let args: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let (stem, end, methods, tols) = (&args[0], &args[1], &args[2], &args[3]);
    let tol = |t: f64| format!("{{\"relative\": {t:e}, \"absolute\": {:e}}}", t * 1e-2);
    let extra: Vec<(&str, &str)> = args[4..].iter().map(|a| a.split_once('=').unwrap()).collect();
    let with = |m: &str, t: f64| { let tt = tol(t); let mut sets = vec![("time.end", end.as_str()), ("time.step", "null"), ("time.tolerance", tt.as_str()), ("time.method", m)]; sets.extend(extra.iter().copied()); common::run::asset(stem, &sets) };
    let (ro, reference) = frames(&with("rk4", 1e-10));
    println!("reference rk4 1e-10: {} steps {} dropped", ro.steps, ro.rejected_steps);
    let x0 = &reference[0].x;
    let motion = reference.iter().flat_map(|s| s.x.iter().zip(x0)).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
    for m in methods.split(',') { for t in tols.split(',') {
        let t: f64 = t.parse().unwrap();
        let clock = std::time::Instant::now();
        let (o, f) = frames(&with(m, t));
        let err = f.iter().zip(&reference).flat_map(|(a, b)| a.x.iter().zip(&b.x)).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
        let allowed = t * motion + t * 1e-2;
        println!("{m:20} {t:8.0e} {:?} steps {:7} dropped {:5} passes {:8} newton {:6} err {err:9.2e} ratio {:8.3} {:.2}s {}", o.status, o.steps, o.rejected_steps, o.counters.force_evaluations, o.counters.newton_iterations, err / allowed, clock.elapsed().as_secs_f64(), o.failure.map_or(String::new(), |f| f.cause));
    } }
}
