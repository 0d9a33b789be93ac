//! Events by the state of a scene: they happen where theory has them, to rounding of what the scheme itself computes,
//! in every method, and a run that is resumed has the same bits.

use std::sync::atomic::AtomicBool;

use canopy_fem::drive::event::Fired;
use canopy_fem::drive::observer::{AcceptedStep, ObserveError, Observer, Point, Resumable, UpcomingStep, Wants};
use canopy_fem::drive::{self, RunSpec, Snapshot, Status};
use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::integrate::registry::{Family, methods};
use canopy_fem::model::spec::{Condition, EventSpec, Trigger, Watched};
use canopy_fem::model::state::State;
use canopy_fem::scene::build_network;
use canopy_fem::simulation::{bind, build_scene};
use serde_json::{Value, json};

use crate::common::run::{Run, case_of, network, run, run_with};

mod cuts;
mod wind;

/// [m/s^2]
const G: f64 = 9.81;
/// [kg], [m^2], [kg/m^3] of a body that falls in air
const BODY: [f64; 3] = [2.0, 0.8, 1.225];

fn fixed(method: &str, step: f64, end: f64) -> Value {
    json!({"end": end, "method": method, "step": step})
}

fn adaptive(method: &str, tolerance: f64, end: f64) -> Value {
    json!({"end": end, "method": method, "tolerance": {"relative": tolerance, "absolute": tolerance}})
}

/// A body that falls from z = 100 m, in air if `drag`, and one beside it that is held until an event.
fn fall(drag: bool, when: &Value, time: &Value) -> Value {
    let [mass, area, density] = BODY;
    let mut network = json!({
        "mesh": {"explicit": {"nodes": [[0, 0, 100], [1, 0, 100]], "springs": []}},
        "mass": {"nodal": mass},
        "supports": [{"on": {"ids": [1]}, "fix": "xyz", "when": when}],
        "gravity": [0, 0, -G]
    });
    if drag {
        network["aero"] =
            json!({"drag": [{"on": {"ids": [0]}, "drag_area": area}], "atmosphere": {"density": density}});
    }
    json!({"name": "fall", "system": {"network": network}, "time": time})
}

/// [s] When the only event happened.
fn time_of(ended: &Run) -> f64 {
    assert_eq!(ended.outcome.status, Status::Completed);
    let [event] = &ended.outcome.fired[..] else { panic!("one event: {:?}", ended.outcome.fired) };
    event.t
}

/// Conditions on the body that falls, with the times at which they are met without air and in it.
fn conditions() -> Vec<(Value, Option<f64>, f64)> {
    let [mass, area, density] = BODY;
    let terminal = (2.0 * mass * G / (density * area)).sqrt();
    let rate = G / terminal;
    let (depth, speed) = (33.3, 5.5);
    let q = 0.5 * density * speed * speed;
    let by_speed = (speed / terminal).atanh() / rate;
    let of = json!({"ids": [0]});
    vec![
        (
            json!({"of": of, "height_below": 100.0 - depth}),
            Some((2.0 * depth / G).sqrt()),
            (depth * rate * rate / G).exp().acosh() / rate,
        ),
        (json!({"of": of, "speed_above": speed}), Some(speed / G), by_speed),
        (json!({"of": of, "dynamic_pressure_above": q}), None, by_speed),
    ]
}

/// With adaptive steps an event is within 1e-10 of its time.
#[test]
fn adaptive_steps_end_at_events() {
    for method in ["dop853", "dormand-prince"] {
        for (when, free, in_air) in conditions() {
            for (drag, expected) in [(false, free), (true, Some(in_air))] {
                let Some(expected) = expected else { continue };
                let found = time_of(&run(&case_of(&fall(drag, &when, &adaptive(method, 1e-12, 6.0)), &[])));
                assert!((found - expected).abs() < 1e-10 * expected, "{method} {when} {drag}: {found} {expected}");
            }
        }
    }
}

/// With fixed steps it is off by what the scheme is off: a fraction of a step is no error of its own.
#[test]
fn fixed_steps_find_events_to_the_order_of_the_scheme() {
    for (method, order) in [("improved-euler", 2), ("velocity-verlet", 2), ("rk4", 4), ("newmark", 2), ("esdirk4", 4)] {
        for (when, _, expected) in conditions() {
            let error = |step: f64| {
                let case = case_of(&fall(true, &when, &fixed(method, step, 6.0)), &[]);
                (time_of(&run(&case)) - expected).abs()
            };
            let step = if order == 4 { 0.4 } else { 0.1 };
            let (coarse, fine) = (error(step), error(0.25 * step));
            assert!(coarse < 1e-2, "{method} {when}: {coarse:e}");
            // Where the error is not that of Newton's iteration already, it falls as that of the scheme.
            assert!(fine < 1e-9 || fine < 2.0 * coarse / 4.0_f64.powi(order), "{method} {when}: {coarse:e} {fine:e}");
        }
    }
}

/// What is released falls from there as theory says, and a second event follows the first.
#[test]
fn events_follow_one_another() {
    let delay = 0.1234;
    let first = json!({"name": "main", "of": {"ids": [0]}, "height_below": 80.0});
    let case = |time: Value| {
        let mut case = fall(false, &first, &time);
        let network = &mut case["system"]["network"];
        network["mesh"]["explicit"]["nodes"] = json!([[0, 0, 100], [1, 0, 100], [2, 0, 100]]);
        let second = json!({"on": {"ids": [2]}, "fix": "xyz", "when": {"after": "main", "delay": delay}});
        network["supports"].as_array_mut().expect("a list").push(second);
        case
    };
    let met = (2.0 * 20.0 / G).sqrt();
    for time in [fixed("velocity-verlet", 0.01, 3.0), fixed("newmark", 0.013, 3.0), adaptive("dop853", 1e-12, 3.0)] {
        let ended = run(&case_of(&case(time.clone()), &[]));
        let times: Vec<f64> = ended.outcome.fired.iter().map(|event| event.t).collect();
        let near = |found: f64, expected: f64| (found - expected).abs() < 1e-9;
        assert!(times.len() == 2 && near(times[0], met) && near(times[1], met + delay), "{time}: {times:?}");
        let left = 3.0 - met - delay;
        for (node, fallen) in [(0, 3.0_f64), (1, 3.0 - met), (2, left)] {
            let expected = 100.0 - 0.5 * G * fallen * fallen;
            let z = ended.positions[node][2];
            assert!((z - expected).abs() < 1e-7, "{time}, node {node}: {z} {expected}");
        }
    }
}

/// A condition that holds at the start is met there, and what follows it counts from there.
#[test]
fn what_holds_at_the_start_happens_at_once() {
    let when = json!({"of": {"ids": [0]}, "height_above": 50.0});
    let ended = run(&case_of(&fall(false, &when, &fixed("velocity-verlet", 0.01, 1.0)), &[]));
    assert_eq!(time_of(&ended), 0.0);
    assert_eq!(ended.positions[0][2], ended.positions[1][2]);
    let never = json!({"of": {"ids": [0]}, "height_above": 500.0});
    let ended = run(&case_of(&fall(false, &never, &fixed("velocity-verlet", 0.01, 1.0)), &[]));
    assert_eq!((ended.outcome.fired.len(), &ended.outcome.unmet[..]), (0, &["supports[0]".to_owned()][..]));
    assert_eq!(ended.positions[1][2], 100.0);
}

/// [N/m] and strengths [N] of springs side by side, which a weight [kg] tears one after the other.
const TORN: [f64; 2] = [400.0, 9.0];
const STRENGTHS: [f64; 4] = [40.0, 45.0, 52.0, 70.0];

fn tearing(time: &Value) -> Value {
    let [stiffness, weight] = TORN;
    let mut nodes = vec![[0.0, 0.0, 0.0]];
    let (mut edges, mut rules) = (Vec::new(), Vec::new());
    for (i, strength) in STRENGTHS.iter().enumerate() {
        nodes.push([0.0, 0.0, 1.0 + i as f64]);
        edges.push([0, i + 1]);
        rules.push(json!({"on": {"ids": [i]}, "stiffness": stiffness, "strength": strength, "breaks": true}));
    }
    json!({
        "name": "tearing",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": nodes, "springs": edges}},
            "mass": {"points": [{"on": {"ids": [0]}, "mass": weight}]},
            "springs": rules,
            "supports": [{"on": {"ids": [1, 2, 3, 4]}, "fix": "xyz"}, {"on": {"ids": [0]}, "fix": "xy"}],
            "gravity": [0, 0, -G]
        }},
        "time": time
    })
}

/// [s] and [m/s] when each of the springs breaks, and how fast the weight then is: it moves harmonically between.
fn breaks() -> Vec<[f64; 2]> {
    let [stiffness, weight] = TORN;
    let [mut t, mut u, mut v] = [0.0; 3];
    let mut found = Vec::new();
    for (broken, strength) in STRENGTHS.iter().enumerate() {
        let w = ((STRENGTHS.len() - broken) as f64 * stiffness / weight).sqrt();
        let middle = G / (w * w);
        let (out, amplitude) = (strength / stiffness - middle, (u - middle).hypot(v / w));
        // u - middle = A sin(w t + phase), rising
        let phase = (u - middle).atan2(v / w);
        let rise = (out / amplitude).asin() - phase;
        t += rise / w;
        (u, v) = (strength / stiffness, w * (amplitude * amplitude - out * out).sqrt());
        found.push([t, v]);
    }
    found
}

/// Springs break one after the other, each at its strength; what they hold is dissipated, and nothing else.
#[test]
fn a_cascade_of_springs_that_break() {
    let expected = breaks();
    assert!(expected.iter().flatten().all(|x| x.is_finite()), "all of them break: {expected:?}");
    let energy: f64 = STRENGTHS.iter().map(|s| 0.5 * s * s / TORN[0]).sum();
    for (time, within) in [
        (adaptive("dop853", 1e-12, 1.0), 1e-10),
        (fixed("rk4", 1e-3, 1.0), 1e-8),
        (fixed("velocity-verlet", 1e-3, 1.0), 1e-4),
        (fixed("energy-momentum", 1e-3, 1.0), 1e-4),
    ] {
        let ended = run(&case_of(&tearing(&time), &[]));
        assert_eq!(ended.outcome.status, Status::Completed);
        let fired = &ended.outcome.fired;
        assert_eq!(fired.len(), STRENGTHS.len(), "{time}");
        for (i, (Fired { t, name, velocity, .. }, [expected, _])) in fired.iter().zip(&expected).enumerate() {
            assert!(
                (t - expected).abs() < within && name.starts_with(&format!("springs[{i}]")),
                "{time}: {name} {t} {expected}"
            );
            assert!(velocity[2] <= 0.0);
        }
        let ledger = ended.outcome.ledger;
        let off = (ledger.dissipated - energy).abs() / energy;
        assert!(
            off < within && ended.outcome.energy_error < 1e3 * within,
            "{time}: {off:e} {:e}",
            ended.outcome.energy_error
        );
        // Nothing holds the weight any more.
        let [t, v] = expected[3];
        let speed = -ended.velocities[0][2];
        assert!((speed - v - G * (1.0 - t)).abs() < 100.0 * within, "{time}: {speed}");
    }
}

/// An event of a program's own that looks at springs of one group is no break: it happens at its tension, before those.
#[test]
fn an_event_on_springs_of_a_group_is_no_break() {
    let case = case_of(&tearing(&fixed("rk4", 1e-3, 1.0)), &[]);
    let (mut spec, limit) = (network(&case), 0.5 * STRENGTHS[0]);
    spec.events.push(EventSpec {
        name: "pulled".to_owned(),
        what: "a spring is pulled".to_owned(),
        stage: None,
        trigger: Trigger::When(Condition::TensionAbove(limit)),
        of: Watched::Springs { edges: vec![3], group: Some(3) },
        ends_run: false,
    });
    let scene = build_network(spec, Threads::one()).expect("the case is good");
    let mut stepper = bind(case.problem(), &scene).expect("the method fits");
    let run_spec: RunSpec = case.problem().run_spec();
    let outcome = drive::run(&scene, &mut stepper, &run_spec, &mut [], &AtomicBool::new(false)).expect("it runs");
    let [stiffness, weight] = TORN;
    let rest = weight * G / (4.0 * stiffness);
    let pulled = ((1.0 - limit / stiffness / rest).acos()) / (4.0 * stiffness / weight).sqrt();
    let expected = std::iter::once(pulled).chain(breaks().into_iter().map(|[t, _]| t));
    assert_eq!(outcome.fired.len(), 5, "{:?}", outcome.fired);
    for ((number, found), expected) in outcome.fired.iter().enumerate().zip(expected) {
        assert!(found.event == number && (found.t - expected).abs() < 1e-8, "{found:?}, not {number} at {expected} s");
    }
}

/// [m] What springs of one rule, side by side, are longer than their rest lengths before the weight pulls.
const STRETCHED: [f64; 6] = [0.004, 0.012, 0.0, 0.02, 0.008, 0.016];

/// The same with one rule: the springs that are stretched most break first, each at the strength of all.
#[test]
fn springs_of_one_rule_break_one_by_one() {
    let ([stiffness, weight], strength) = (TORN, 24.0);
    let anchors = STRETCHED.iter().enumerate().map(|(i, _)| json!([0, 0, i + 1]));
    let nodes: Vec<Value> = std::iter::once(json!([0, 0, 0])).chain(anchors).collect();
    let edges: Vec<[usize; 2]> = (1..nodes.len()).map(|i| [0, i]).collect();
    let held: Vec<usize> = (1..nodes.len()).collect();
    let rest: Vec<f64> = STRETCHED.iter().enumerate().map(|(i, more)| 1.0 + i as f64 - more).collect();
    let case = |time: &Value| {
        json!({
            "name": "one-rule",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": nodes, "springs": edges}},
                "mass": {"points": [{"on": {"ids": [0]}, "mass": weight}]},
                "springs": [{"on": "all", "stiffness": stiffness, "rest_length": rest, "strength": strength,
                             "breaks": true}],
                "supports": [{"on": {"ids": held}, "fix": "xyz"}, {"on": {"ids": [0]}, "fix": "xy"}],
                "gravity": [0, 0, -G]
            }},
            "time": time
        })
    };
    let mut order: Vec<usize> = (0..STRETCHED.len()).collect();
    order.sort_by(|a, b| STRETCHED[*b].total_cmp(&STRETCHED[*a]));
    // The weight moves harmonically between two breaks.
    let ([mut t, mut u, mut v], mut expected) = ([0.0; 3], Vec::new());
    for (broken, &spring) in order.iter().enumerate() {
        let left = &order[broken..];
        let w = (left.len() as f64 * stiffness / weight).sqrt();
        let middle = (weight * G / stiffness - left.iter().map(|i| STRETCHED[*i]).sum::<f64>()) / left.len() as f64;
        let breaks_at = strength / stiffness - STRETCHED[spring];
        let (out, amplitude) = (breaks_at - middle, (u - middle).hypot(v / w));
        t += ((out / amplitude).asin() - (u - middle).atan2(v / w)) / w;
        (u, v) = (breaks_at, w * (amplitude * amplitude - out * out).sqrt());
        expected.push((format!("edge {spring}"), t));
    }
    for (time, within) in [(adaptive("dop853", 1e-12, 1.0), 1e-10), (fixed("velocity-verlet", 1e-3, 1.0), 1e-4)] {
        let ended = run(&case_of(&case(&time), &[]));
        let fired = &ended.outcome.fired;
        assert_eq!(fired.len(), expected.len(), "{time}");
        for (found, (name, t)) in fired.iter().zip(&expected) {
            assert!((found.t - t).abs() < within && found.name.ends_with(name), "{time}: {found:?}, not {name} {t}");
        }
        let energy = STRETCHED.len() as f64 * 0.5 * strength * strength / stiffness;
        let ledger = ended.outcome.ledger;
        assert!((ledger.dissipated - energy).abs() < within * energy, "{time}: {}", ledger.dissipated);
    }
}

/// A weight on a line of which one part breaks, a part is cut by an event and the rest is released after it: every
/// method finds the same, in fixed steps and in adaptive ones.
fn chain(time: &Value) -> Value {
    json!({
        "name": "chain",
        "system": {"network": {
            "mesh": {"explicit": {
                "nodes": [[0, 0, 3], [0, 0, 2], [0, 0, 1], [0.5, 0, 3], [2, 0, 1]],
                "springs": [[0, 1], [1, 2], [3, 1]]
            }},
            "mass": {"nodal": 1.0},
            "springs": [
                {"on": {"ids": [0]}, "stiffness": 900.0, "strength": 25.0, "breaks": true},
                {"on": {"ids": [1]}, "stiffness": 900.0,
                 "when": {"name": "gone", "of": {"ids": [2]}, "height_below": 0.9}},
                {"on": {"ids": [2]}, "stiffness": 300.0}
            ],
            "supports": [{"on": {"ids": [0, 3]}, "fix": "xyz"},
                         {"on": {"ids": [4]}, "fix": "xyz", "when": {"after": "gone", "delay": 0.0217}}],
            "gravity": [0, 0, -G]
        }},
        "time": time
    })
}

#[test]
fn every_method_finds_the_same_events() {
    let exact = run(&case_of(&chain(&adaptive("dop853", 1e-12, 0.8)), &[]));
    let times = |run: &Run| run.outcome.fired.iter().map(|event| (event.name.clone(), event.t)).collect::<Vec<_>>();
    let expected = times(&exact);
    assert_eq!(expected.len(), 3, "{expected:?}");
    for method in methods() {
        // The first order, and the filter that damps, are off by more.
        let second = method.order >= 2 && method.family != Family::MatrixFree;
        let (within, tolerance) = if second { (2e-3, 1e-6) } else { (0.1, 1e-3) };
        for time in [fixed(method.name, 1e-3, 0.8), adaptive(method.name, tolerance, 0.8)] {
            let ended = run(&case_of(&chain(&time), &[]));
            assert_eq!(ended.outcome.status, Status::Completed, "{time}: {:?}", ended.outcome.failure);
            let found = times(&ended);
            let names = |list: &[(String, f64)]| list.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
            assert_eq!(names(&found), names(&expected), "{time}");
            for ((name, t), (_, expected)) in found.iter().zip(&expected) {
                assert!((t - expected).abs() < within, "{time}: {name} {t} {expected}");
            }
        }
    }
}

/// Takes a copy of the run before a step.
struct Copy {
    before: u64,
    taken: Option<Snapshot>,
    last: State,
}

impl Copy {
    fn before(step: u64) -> Self {
        Copy { before: step, taken: None, last: State::default() }
    }
}

impl Observer for Copy {
    fn resumable(&mut self, run: &Resumable<'_>) -> Result<(), ObserveError> {
        // Steps in two halves are shown at every second one only.
        if run.step >= self.before && self.taken.is_none() {
            self.taken = Some(run.snapshot());
        }
        Ok(())
    }

    fn wants(&self, _step: UpcomingStep) -> Wants {
        Wants::end_if(true)
    }

    fn accepted(&mut self, _step: AcceptedStep<'_>) -> Result<(), ObserveError> {
        Ok(())
    }

    fn finished(&mut self, last: &Point) -> Result<(), ObserveError> {
        self.last = last.state.clone();
        Ok(())
    }
}

/// Before, between and after the events: what follows has the bits of one run, and so have the events.
#[test]
fn a_run_goes_on_with_the_same_bits() {
    for method in methods() {
        let times = [fixed(method.name, 3e-3, 0.8), adaptive(method.name, 1e-3, 0.8)];
        for (time, case) in times.iter().flat_map(|time| [(time, chain(time)), (time, wind::blown(time))]) {
            let mut problem = case_of(&case, &[]).problem().clone();
            let scene = build_scene(problem.take_system(), 1).expect("the case is good");
            let spec: RunSpec = problem.run_spec();
            let stop = AtomicBool::new(false);
            let whole = |copy: &mut Copy| {
                let mut stepper = bind(&problem, &*scene).expect("the method fits");
                drive::run(&*scene, &mut stepper, &spec, &mut [copy], &stop).expect("it runs")
            };
            let mut none = Copy::before(u64::MAX);
            let outcome = whole(&mut none);
            for share in [0.2, 0.5, 0.6, 0.9] {
                let mut copy = Copy::before((share * outcome.steps as f64) as u64);
                whole(&mut copy);
                let snapshot = copy.taken.take().expect("a copy");
                let mut stepper = bind(&problem, &*scene).expect("the method fits");
                let mut rest = Copy::before(u64::MAX);
                let resumed =
                    drive::resume(&*scene, &mut stepper, &spec, snapshot, &mut [&mut rest], &stop).expect("it runs");
                assert!(resumed.fired == outcome.fired && resumed.steps == outcome.steps, "{time} {share}");
                assert!(rest.last == none.last, "{time} {share}");
            }
        }
    }
}

/// A run without events that wait makes the same steps as one whose events never come.
#[test]
fn events_that_never_come_change_no_bit() {
    for method in ["velocity-verlet", "rk4", "newmark", "kang"] {
        let never = json!({"of": {"ids": [0]}, "height_below": -1e6});
        let time = fixed(method, 0.01, 1.0);
        let mut plain = tearing(&time);
        for rule in plain["system"]["network"]["springs"].as_array_mut().expect("a list") {
            rule.as_object_mut().expect("a rule").remove("breaks");
        }
        plain["system"]["network"]["mass"] = json!({"nodal": TORN[1]});
        let mut waiting = plain.clone();
        let nodes = waiting["system"]["network"]["supports"].as_array_mut().expect("a list");
        nodes[0]["when"] = never;
        let [plain, waiting] = [plain, waiting].map(|case| run(&case_of(&case, &[])));
        assert!(plain.state == waiting.state, "{method}");
    }
}

/// Threads do not change where an event is found.
#[test]
fn two_threads_find_the_same() {
    let case = case_of(
        &json!({
            "name": "cloth",
            "system": {"network": {
                "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": 50, "rows": 50}},
                "mass": {"nodal": 1e-4},
                "springs": [{"on": "all", "stiffness": 20.0, "strength": 1e6}],
                "supports": [{"on": {"box": [[-0.01, -1, -1], [0.01, 1, 1]]}, "fix": "xyz",
                              "when": {"of": {"box": [[0.99, -1, -1], [1.01, 2, 1]]}, "height_below": -2e-4}}],
                "gravity": [0, 0, -G]
            }},
            "time": fixed("velocity-verlet", 5e-4, 0.02)
        }),
        &[],
    );
    let [one, two] = [1, 2].map(|threads| run_with(&case, threads));
    assert!(one.outcome.fired.len() == 1 && one.outcome.fired == two.outcome.fired);
    assert!(one.state == two.state);
}
