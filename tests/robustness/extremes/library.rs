//! What a program that uses the library may ask for, and no case can.

use crate::common::run::asset;
use canopy_fem::drive::clock::{Step, Tolerance};
use canopy_fem::drive::{RunError, RunSpec};
use canopy_fem::model::state::State;
use canopy_fem::simulation::{bind, build_scene};
use std::sync::atomic::AtomicBool;

type Change<'c> = &'c dyn Fn(RunSpec) -> RunSpec;

/// How a pendulum's run with another specification or another state is refused.
fn refused(method: &str, change: Change<'_>, state: Option<State>) -> RunError {
    let case = asset("pendulum", &[("time.method", &format!("\"{method}\"")), ("time.end", "0.1")]);
    let mut problem = case.problem().clone();
    let scene = build_scene(problem.take_system(), 1).expect("the case is good");
    let mut stepper = bind(&problem, &*scene).expect("the method fits the scene");
    let spec = change(problem.run_spec());
    let state = state.unwrap_or_else(|| scene.initial_state());
    let outcome = canopy_fem::drive::run_from(&*scene, &mut stepper, &spec, state, &mut [], &AtomicBool::new(false));
    outcome.map(|outcome| format!("{outcome:?}")).expect_err("there is no such run")
}

/// Neither endless nor silently something else.
#[test]
fn times_and_tolerances_that_are_none_are_refused() {
    for method in ["velocity-verlet", "newmark", "dormand-prince"] {
        for bad in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
            let good = Tolerance { relative: 1e-3, absolute: 1e-6 };
            let changes: [(&str, Change<'_>); 5] = [
                ("the step [s] is", &|spec| RunSpec { step: Step::Fixed(bad), ..spec }),
                ("the end [s] is", &|spec| RunSpec { end: bad, ..spec }),
                ("the time between frames [s] is", &|spec| RunSpec { frames_every: Some(bad), ..spec }),
                ("the relative tolerance is", &|spec| RunSpec {
                    step: Step::Adaptive(Tolerance { relative: bad, ..good }),
                    ..spec
                }),
                ("the absolute tolerance is", &|spec| RunSpec {
                    step: Step::Adaptive(Tolerance { absolute: bad, ..good }),
                    ..spec
                }),
            ];
            for (words, change) in changes {
                let error = refused(method, change, None);
                assert!(matches!(error, RunError::OutOfRange { .. }), "{method}: {error}");
                assert!(error.to_string().starts_with(&format!("{words} {bad}")), "{method}: {error}");
            }
        }
    }
}

#[test]
fn states_of_another_scene_are_refused() {
    let state = State { t: 0.0, x: vec![0.0; 3], v: vec![0.0] };
    let error = refused("velocity-verlet", &|spec| spec, Some(state));
    assert_eq!(error.to_string(), "the state has 3 degrees of freedom, the scene 1");
}
