//! Methods that solve springs one by one: `xpbd` spring by spring, `vbd` node by node. Against backward Euler, and
//! against their equations written out.

use crate::common::run::{Run, asset, case_of, changed, follow, run};
use canopy_fem::case::Case;
use canopy_fem::drive::Status;
use canopy_fem::interrupt::heeding;
use canopy_fem::simulation::{bind, build_scene};
use serde_json::{Value, json};
use std::cell::Cell;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

const G: f64 = 9.81;

fn with(method: &Value, case: &Value) -> Run {
    let done = run(&changed(&case_of(case, &[]), &[("time.method", &method.to_string())]));
    assert_eq!(done.outcome.status, Status::Completed, "{method}: {:?}", done.outcome.failure);
    done
}

fn apart(a: &Run, b: &Run) -> f64 {
    let all = |r: &Run| r.positions.iter().chain(&r.velocities).flatten().copied().collect::<Vec<f64>>();
    all(a).iter().zip(all(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Two masses on one spring along z, the lower one free, the upper one held if `held`; h^2 k/m is 10.
fn pair(held: bool, spring: Value) -> Value {
    let mut rule = json!({"on": "all", "stiffness": 1000.0});
    rule.as_object_mut().expect("an object").extend(spring.as_object().expect("an object").clone());
    let supports = if held { json!([{"on": {"ids": [0]}, "fix": "xyz"}]) } else { json!([]) };
    json!({
        "name": "pair",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0, 0, 0], [0, 0, -1]], "springs": [[0, 1]]}},
            "mass": {"nodal": [0.7, 0.5]},
            "springs": [rule],
            "supports": supports,
            "gravity": [0, 0, -G],
            "initial": {"velocity": [[0, 0, 0], [0, 0, -2.0]]}
        }},
        "solver": {"newton": {"relative": 1e-14}},
        "time": {"end": 2.0, "method": "backward-euler", "step": 0.0707}
    })
}

/// One spring along a line, of which `xpbd` needs one iteration. Springs that go slack and are taut again, dashpots of
/// both kinds, and reels are the same equations.
#[test]
fn one_spring_is_backward_euler() {
    let springs = [
        json!({}),
        json!({"dashpot": {"axial": {"coefficient": 3.0}}}),
        json!({"dashpot": {"relative": {"coefficient": 3.0}}}),
        json!({"slack": "tension-only", "rest_length": 1.02}),
        json!({"slack": "tension-only", "rest_length": 1.1, "dashpot": {"axial": {"coefficient": 3.0}}}),
        json!({"slack": "compression-only", "rest_length": 1.02}),
        json!({"rest_scale": {"table": [[0, 1], [1.0, 0.6]]}}),
    ];
    for spring in springs {
        for held in [true, false] {
            let case = pair(held, spring.clone());
            let exact = with(&json!("backward-euler"), &case);
            for method in [json!({"xpbd": {"substeps": 1, "iterations": 60}}), json!({"vbd": {"iterations": 900}})] {
                let off = apart(&with(&method, &case), &exact);
                assert!(off < 1e-10, "{method}, {spring}, held {held}: {off}");
            }
            let off = apart(&with(&json!({"xpbd": {"substeps": 1, "iterations": 1}}), &case), &exact);
            assert!(off < 1e-10, "one iteration, {spring}, held {held}: {off}");
        }
    }
}

/// Substeps are steps: eight of them in a step have the bits of eight steps, and their energy account.
#[test]
fn substeps_are_short_steps() {
    let mut case = pair(true, json!({"dashpot": {"axial": {"coefficient": 3.0}}}));
    case["system"]["network"]["loads"] = json!([{"on": {"ids": [1]}, "force": [1.0, 0, 0], "table": [[0, 0], [1, 1]]}]);
    let steps = |step: f64, substeps: u32| {
        let mut case = case.clone();
        case["time"] = json!({"end": 1.0, "step": step, "method": "xpbd"});
        with(&json!({"xpbd": {"substeps": substeps, "iterations": 2}}), &case)
    };
    let (long, short) = (steps(0.0625, 8), steps(0.0078125, 1));
    assert_eq!(long.state.x, short.state.x);
    assert_eq!(long.state.v, short.state.v);
    let [long, short] = [long, short].map(|run| run.outcome.ledger);
    // Where the works of a step's parts and those by its ends are quite different, the account takes the ones that
    // leave less unexplained: in a few steps.
    let close = |a: f64, b: f64| (a - b).abs() < 1e-3 * (a.abs() + b.abs());
    assert!(close(long.dissipated, short.dissipated) && long.dissipated > 0.1, "{long:?} {short:?}");
    assert!(close(long.external_work, short.external_work) && short.external_work != 0.0, "{long:?} {short:?}");
}

/// A net of 16 nodes in space that hangs from two corners, with slack springs and dashpots.
fn net() -> Value {
    json!({
        "name": "net",
        "system": {"network": {
            "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": 3, "rows": 3}},
            "mass": {"nodal": 0.02},
            "springs": [{"on": "all", "stiffness": 40.0, "slack": "tension-only", "dashpot": {"axial": {"coefficient": 0.05}}}],
            "supports": [{"on": {"ids": [0, 3]}, "fix": "xyz"}, {"on": {"ids": [5]}, "fix": "x"}],
            "gravity": [0, -1.0, -G]
        }},
        "solver": {"newton": {"relative": 1e-13}},
        "time": {"end": 0.3, "method": "backward-euler", "step": 0.01}
    })
}

/// Converged, vertex block descent is backward Euler of any net, in space too. Position-based dynamics is not, where
/// springs turn within a step; in short steps both meet.
#[test]
fn converged_block_descent_is_backward_euler() {
    let exact = with(&json!("backward-euler"), &net());
    let off = |method: Value| apart(&with(&method, &net()), &exact);
    let converged = off(json!({"vbd": {"iterations": 2000}}));
    assert!(converged < 1e-9, "{converged}");
    let rough = off(json!({"vbd": {"iterations": 2}}));
    assert!(rough > 1e-4, "{rough}");
    let [few, many] = [200, 2000].map(|iterations| off(json!({"xpbd": {"substeps": 1, "iterations": iterations}})));
    assert!(few > 1e-5 && (few - many).abs() < 0.1 * few, "{few} {many}");
}

/// [N/m], [kg], [m]
const K: [f64; 3] = [300.0, 500.0, 200.0];
const M: [f64; 4] = [1.0, 0.5, 0.4, 0.3];
const REST: [f64; 3] = [0.9, 1.0, 1.2];
const PUSH: f64 = 7.0;
const H: f64 = 0.05;

/// A chain along x from an anchor, which a force pulls at its end.
fn chain(method: &Value, steps: u32) -> Run {
    with(
        method,
        &json!({
            "name": "chain",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]],
                    "springs": [[0, 1], [1, 2], [2, 3]]}},
                "mass": {"nodal": M},
                "springs": [{"on": {"ids": [0]}, "stiffness": K[0], "rest_length": REST[0]},
                    {"on": {"ids": [1]}, "stiffness": K[1], "rest_length": REST[1]},
                    {"on": {"ids": [2]}, "stiffness": K[2], "rest_length": REST[2]}],
                "supports": [{"on": {"ids": [0]}, "fix": "xyz"}],
                "loads": [{"on": {"ids": [3]}, "force": [PUSH, 0, 0]}]
            }},
            "time": {"end": f64::from(steps) * H, "method": "xpbd", "step": H}
        }),
    )
}

/// The equations on a line, in the papers' variables: positions, and multipliers by alpha = 1/(k h^2).
struct Line {
    x: [f64; 4],
    v: [f64; 4],
}

impl Line {
    const START: Line = Line { x: [0.0, 1.0, 2.0, 3.0], v: [0.0; 4] };

    fn w(i: usize) -> f64 {
        if i == 0 { 0.0 } else { 1.0 / M[i] }
    }

    fn push(i: usize) -> f64 {
        if i == 3 { PUSH } else { 0.0 }
    }

    fn xpbd(&mut self, h: f64, iterations: usize, order: [usize; 3]) {
        let old = self.x;
        for i in 0..4 {
            self.v[i] += h * Line::w(i) * Line::push(i);
            self.x[i] += h * self.v[i];
        }
        let mut lambda = [0.0; 3];
        for _ in 0..iterations {
            for s in order {
                let (c, alpha) = (self.x[s + 1] - self.x[s] - REST[s], 1.0 / (K[s] * h * h));
                let d = (-c - alpha * lambda[s]) / (Line::w(s) + Line::w(s + 1) + alpha);
                self.x[s] -= Line::w(s) * d;
                self.x[s + 1] += Line::w(s + 1) * d;
                lambda[s] += d;
            }
        }
        self.v = std::array::from_fn(|i| (self.x[i] - old[i]) / h);
    }

    fn vbd(&mut self, h: f64, iterations: usize, order: [usize; 3]) {
        let old = self.x;
        let y: [f64; 4] = std::array::from_fn(|i| old[i] + h * self.v[i] + h * h * Line::w(i) * Line::push(i));
        self.x = std::array::from_fn(|i| old[i] + h * self.v[i]);
        for _ in 0..iterations {
            for i in order {
                let (mut f, mut stiff) = (-M[i] / (h * h) * (self.x[i] - y[i]), M[i] / (h * h));
                f -= K[i - 1] * (self.x[i] - self.x[i - 1] - REST[i - 1]);
                stiff += K[i - 1];
                if i < 3 {
                    f += K[i] * (self.x[i + 1] - self.x[i] - REST[i]);
                    stiff += K[i];
                }
                self.x[i] += f / stiff;
            }
        }
        self.v = std::array::from_fn(|i| (self.x[i] - old[i]) / h);
    }

    fn off(&self, found: &Run) -> f64 {
        let off = |i: usize| [found.positions[i][0] - self.x[i], H * (found.velocities[i][0] - self.v[i])];
        (0..4).flat_map(off).map(f64::abs).fold(0.0, f64::max)
    }
}

/// Sweeps that have not converged are those of the papers, in the order of the scene, whose nodes are numbered from an
/// end of the chain.
#[test]
fn sweeps_follow_their_equations() {
    const STEPS: u32 = 40;
    for (substeps, iterations) in [(1, 1), (1, 3), (4, 1), (3, 2)] {
        let found = chain(&json!({"xpbd": {"substeps": substeps, "iterations": iterations}}), STEPS);
        let off = |order: [usize; 3]| {
            let mut line = Line::START;
            (0..STEPS * substeps).for_each(|_| line.xpbd(H / f64::from(substeps), iterations, order));
            line.off(&found)
        };
        let [forwards, backwards] = [off([0, 1, 2]), off([2, 1, 0])];
        assert!(forwards.min(backwards) < 1e-12, "{substeps} {iterations}: {forwards} {backwards}");
        assert!(forwards.max(backwards) > 1e-6, "the order matters: {forwards} {backwards}");
    }
    for iterations in [1, 2, 5] {
        let found = chain(&json!({"vbd": {"iterations": iterations}}), STEPS);
        let off = |order: [usize; 3]| {
            let mut line = Line::START;
            (0..STEPS).for_each(|_| line.vbd(H, iterations, order));
            line.off(&found)
        };
        let [forwards, backwards] = [off([1, 2, 3]), off([3, 2, 1])];
        assert!(forwards.min(backwards) < 1e-12, "{iterations}: {forwards} {backwards}");
        assert!(forwards.max(backwards) > 1e-6, "the order matters: {forwards} {backwards}");
    }
}

/// On one spring a step loses what backward Euler loses, m dv^2/2 + k dx^2/2. The account shows it, and also what
/// sweeps that have not converged lose beside that; it closes in every step.
#[test]
fn the_account_shows_what_sweeps_lose() {
    let case = pair(true, json!({}));
    for method in [json!({"xpbd": {"substeps": 1, "iterations": 1}}), json!({"vbd": {"iterations": 1}})] {
        let case = changed(&case_of(&case, &[]), &[("time.method", &method.to_string())]);
        let (mut before, mut lost) = ([-1.0, -2.0], 0.0);
        follow(&case, |seen| {
            let now = [seen.positions[1][2], seen.velocities[1][2]];
            let [dx, dv] = [now[0] - before[0], now[1] - before[1]];
            if seen.t > 0.0 {
                lost += 0.5 * 0.5 * dv * dv + 500.0 * dx * dx;
            }
            before = now;
            assert!((seen.ledger.numerical - lost).abs() < 1e-10, "{method}: {:?} {lost}", seen.ledger);
        });
        assert!(lost > 0.5, "{lost}");
    }
    let numerical = |method: Value| {
        let mut first = None;
        let case = changed(&case_of(&net(), &[]), &[("time.method", &method.to_string())]);
        let outcome = follow(&case, |seen| {
            let l = seen.ledger;
            let sum = l.kinetic + l.elastic + l.gravity - l.external_work + l.dissipated + l.numerical;
            assert!((sum - *first.get_or_insert(sum)).abs() < 1e-12, "{l:?}");
        });
        outcome.ledger.numerical
    };
    let converged = numerical(json!({"vbd": {"iterations": 500}}));
    let exact = numerical(json!("backward-euler"));
    assert!((converged - exact).abs() < 1e-6 * exact.abs(), "{converged} {exact}");
    let rough = numerical(json!({"vbd": {"iterations": 1}}));
    assert!((rough - exact).abs() > 0.05 * exact.abs(), "{rough} {exact}");
}

/// The work of sweeps is counted.
#[test]
fn sweeps_are_counted() {
    for (method, sweeps) in
        [(json!({"xpbd": {"substeps": 4, "iterations": 3}}), 12), (json!({"vbd": {"iterations": 7}}), 7)]
    {
        let counters = chain(&method, 5).outcome.counters;
        assert_eq!([counters.sweeps, counters.newton_iterations, counters.linear_solves], [5 * sweeps, 0, 0]);
    }
}

/// What cannot be solved spring by spring is refused with a reason, before the first step.
#[test]
fn scenes_that_do_not_fit_are_refused() {
    let refusal = |case: &Case| {
        let mut problem = case.problem().clone();
        let scene = build_scene(problem.take_system(), 1).expect("the case is good");
        bind(&problem, &*scene).err().map(|e| e.to_string()).unwrap_or_default()
    };
    for method in ["xpbd", "vbd"] {
        let sets = [("time.method", method)];
        let curved = case_of(&pair(true, json!({"law": "green"})), &sets);
        assert!(refusal(&curved).contains("constant stiffness"), "{method}: {}", refusal(&curved));
        let drop = asset("parachute/c9-drop", &sets);
        let said = refusal(&drop);
        assert!(said.is_empty() || said.contains("apparent_mass"), "{method}: {said}");
        assert_eq!(refusal(&case_of(&net(), &sets)), "", "{method}");
        let pendulum = json!({"name": "bob", "system": {"pendulum": {"length": 1.0, "mass": 2.0, "gravity": 9.81, "angle": 0.1}},
            "time": {"end": 0.1, "step": 0.01, "method": method}});
        let e = Case::from_text(pendulum.to_string(), "test.json", PathBuf::new(), &[]).expect_err("no springs");
        assert!(e.to_string().contains("springs of a network"), "{e}");
    }
}

/// Numbers out of their ranges are faults of the case, with the range.
#[test]
fn numbers_of_sweeps_have_ranges() {
    for (method, key) in [
        (json!({"xpbd": {"substeps": 0}}), "substeps"),
        (json!({"xpbd": {"iterations": 0}}), "iterations"),
        (json!({"xpbd": {"substeps": 1.5}}), "substeps"),
        (json!({"xpbd": {"substeps": 100_000_000}}), "substeps"),
        (json!({"vbd": {"iterations": 0}}), "iterations"),
        (json!({"vbd": {"iterations": 1e9}}), "iterations"),
        (json!({"vbd": {"iterations": -3}}), "iterations"),
    ] {
        let mut case = net();
        case["time"]["method"] = method.clone();
        let e = Case::from_text(case.to_string(), "test.json", PathBuf::new(), &[]).expect_err("out of range");
        let text = e.to_string();
        assert!(text.contains(key) && text.contains("10000"), "{method}: {text}");
    }
}

/// A step of a hundred million sweeps ends soon after it is asked to.
#[test]
fn long_steps_can_be_interrupted() {
    for method in [json!({"xpbd": {"substeps": 10_000, "iterations": 10_000}}), json!({"vbd": {"iterations": 10_000}})]
    {
        let case = changed(&case_of(&net(), &[]), &[("time.method", &method.to_string())]);
        let mut problem = case.problem().clone();
        let scene = build_scene(problem.take_system(), 1).expect("the case is good");
        let mut stepper = bind(&problem, &*scene).expect("the method fits");
        let (asked, stop) = (Rc::new(Cell::new(0)), Arc::new(AtomicBool::new(false)));
        let (seen, flag) = (asked.clone(), stop.clone());
        let question = move || {
            seen.set(seen.get() + 1);
            flag.fetch_or(seen.get() > 100, Ordering::Relaxed) || seen.get() > 100
        };
        let go = || canopy_fem::drive::run(&*scene, &mut stepper, &problem.run_spec(), &mut [], &stop);
        let done = heeding(question, go).expect("it starts");
        assert_eq!((done.status, done.steps), (Status::Interrupted, 0), "{method}");
        assert!((100..120).contains(&asked.get()), "{method}: {}", asked.get());
    }
}

/// Neither fails at any step or stiffness: a net that falls in steps of a second on springs of 1e9 N/m stays a net.
#[test]
fn steps_of_any_size_are_made() {
    for method in [json!({"xpbd": {"substeps": 1, "iterations": 1}}), json!({"vbd": {"iterations": 3}})] {
        let mut case = net();
        case["system"]["network"]["springs"][0]["stiffness"] = json!(1e9);
        case["time"] = json!({"end": 30.0, "step": 1.0, "method": method});
        let positions = case_of(&case, &[]);
        let mut worst = 0.0_f64;
        crate::common::run::follow_on(&positions, |seen| {
            worst = seen.positions.iter().flatten().fold(worst, |worst, x| worst.max(x.abs()));
        });
        assert!(worst < 100.0, "{method}: {worst}");
    }
}
