//! The mixed iteration, whose unknowns are the tensions of springs beside the positions: stiff springs, slack ones, and
//! states far from the solution.

use crate::common::run::{case_of, run_with};
use canopy_fem::assembly::{MixedForm, TangentSystem};
use canopy_fem::case::Case;
use canopy_fem::drive::Status;
use canopy_fem::model::spring_state::{SheetState, SpringState, SpringTangent};
use canopy_fem::model::state::State;
use canopy_fem::model::stop::Stop;
use canopy_fem::model::system::Weights;
use canopy_fem::simulation::build_scene;
use canopy_fem::solve::LinearChoice;
use canopy_fem::statics::{self, Equilibrium, StaticSpec};
use serde_json::{Value, json};

const LAWS: [&str; 2] = ["both ways", "tension-only"];

/// A rule of springs with its slack law.
fn rule(mut springs: Value, law: &str) -> Value {
    if law != "both ways" {
        springs["slack"] = json!(law);
    }
    springs
}

/// A rope of 1 m between supports that are `1 - slack` apart, straight at the start, of links that are all compressed.
fn rope(links: usize, axial_rigidity: f64, slack: f64, law: &str) -> Case {
    let at = |i: usize| json!([(1.0 - slack) * i as f64 / links as f64, 0.0, 0.0]);
    let nodes: Vec<Value> = (0..=links).map(at).collect();
    let springs: Vec<[usize; 2]> = (0..links).map(|i| [i, i + 1]).collect();
    case_of(
        &json!({
            "name": "rope",
            "system": {"network": {
                "mesh": {"explicit": {"nodes": nodes, "springs": springs}},
                "mass": {"nodal": 1e-6},
                "springs": [rule(json!({"on": "all", "axial_rigidity": axial_rigidity,
                    "rest_length": 1.0 / links as f64, "linear_density": 0.1}), law)],
                "supports": [{"on": {"ids": [0, links]}, "fix": "xyz"}],
                "gravity": [0, 0, -9.81]}},
            "time": {"end": 1.0, "step": 0.01, "method": "newmark"}, "output": {}}),
        &[],
    )
}

/// A flat square sheet of 1 m, held along one side.
fn sheet(cells: usize, stiffness: f64, law: &str) -> Value {
    json!({
        "name": "sheet", "acknowledge": ["areal-density"],
        "system": {"network": {
            "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": cells, "rows": cells}},
            "mass": {"areal_density": 0.2},
            "springs": [rule(json!({"on": "all", "stiffness": stiffness}), law)],
            "supports": [{"on": {"box": [[-1e-9, -1e-9, -1], [1e-9, 1.000001, 1]]}, "fix": "xyz"}],
            "gravity": [0, 0, -9.81]}},
        "time": {"end": 0.6, "step": 0.01, "method": "backward-euler"}, "output": {}})
}

fn equilibrium(case: &Case) -> Equilibrium {
    let mut problem = case.problem().clone();
    let scene = build_scene(problem.take_system(), 1).expect("the case is good");
    let spec = StaticSpec { at: 0.0, relative: 1e-6, max_iterations: 3000, load_steps: 1, linear: LinearChoice::Auto };
    let found = statics::find(&*scene, spec, Stop::NEVER);
    assert!(found.failure.is_none(), "{:?}", found.failure);
    found
}

/// [m] Lowest height of a state.
fn lowest(found: &Equilibrium) -> f64 {
    found.point.state.x.iter().skip(2).step_by(3).fold(f64::INFINITY, |least, z| least.min(*z))
}

/// [m] Sag of an inextensible catenary of 1 m over a span: with u = span/(2 a), sinh(u)/u = 1/span, and a (cosh u - 1).
fn catenary_sag(span: f64) -> f64 {
    let (mut low, mut high): (f64, f64) = (1e-6, 20.0);
    for _ in 0..200 {
        let u = 0.5 * (low + high);
        if u.sinh() / u < 1.0 / span {
            low = u;
        } else {
            high = u;
        }
    }
    span / (2.0 * low) * (low.cosh() - 1.0)
}

/// Ropes of any length, stiffness and slack, which begin straight: at most 20 iterations, and the stiff ones hang as a
/// catenary, but for the length of their links.
#[test]
fn slack_ropes_find_their_catenary() {
    for law in LAWS {
        for links in [10, 100, 1000] {
            for axial_rigidity in [1e2, 1e5, 1e8] {
                for slack in [0.0, 0.05, 0.5] {
                    let found = equilibrium(&rope(links, axial_rigidity, slack, law));
                    let made = found.counters.newton_iterations;
                    assert!(made <= 20, "{law}, {links} links, {axial_rigidity} N, {slack}: {made} iterations");
                    if axial_rigidity == 1e8 && slack > 0.0 && links >= 100 {
                        let (sag, exact) = (-lowest(&found), catenary_sag(1.0 - slack));
                        let off = (sag / exact - 1.0).abs();
                        assert!(off < 4.0 / (links * links) as f64, "{law}, {links} links: {sag} for {exact}");
                    }
                }
            }
        }
    }
}

/// A flat sheet finds where it hangs in at most 60 iterations, whatever its stiffness.
#[test]
fn flat_sheets_find_where_they_hang() {
    for law in LAWS {
        for stiffness in [10.0, 1e3, 1e5, 1e7] {
            let found = equilibrium(&case_of(&sheet(20, stiffness, law), &[]));
            let made = found.counters.newton_iterations;
            assert!(made <= 60, "{law}, {stiffness} N/m: {made} iterations");
            if stiffness >= 1e5 {
                assert!((lowest(&found) + 1.0).abs() < 1e-2, "{law}, {stiffness} N/m: {} m", lowest(&found));
            }
        }
    }
}

/// [N/m] The matrix with tensions t and stiffnesses k is the derivative of the forces sum (t + k dl) n by positions,
/// for any t and k: by central differences of n and l.
#[test]
fn the_matrix_of_the_mixed_iteration_agrees_with_differences() {
    let mut problem = case_of(&sheet(3, 1e3, "tension-only"), &[]).problem().clone();
    let scene = build_scene(problem.take_system(), 1).expect("the case is good");
    let system: &dyn TangentSystem = scene.interfaces().tangent;
    let mixed = system.mixed().expect("springs");
    let wave = |i: usize, w: f64| (1.0 + w * i as f64).sin();
    let mut state = scene.initial_state();
    state.x.iter_mut().enumerate().for_each(|(i, x)| *x += 0.05 * wave(i, 1.7));
    let springs_at = |state: &State| {
        let mut springs = vec![SpringState::idle([0; 2]); mixed.springs()];
        mixed.measure(state.as_ref(), 0.0, &mut springs);
        springs
    };
    let tangent = |i: usize| SpringTangent { tension: 30.0 * wave(i, 0.3), stiffness: 1e3 * wave(i, 0.9).abs() };
    let tangents: Vec<SpringTangent> = (0..mixed.springs()).map(tangent).collect();
    let mut assembler = system.assembler().expect("small");
    let form = MixedForm { springs: &tangents, sheets: &[], convex: false, definite: false, symmetric: true };
    mixed.assemble_mixed(state.as_ref(), Weights { m: 0.0, c: 0.0, k: 1.0 }, form, &mut assembler);

    let dof = assembler.pattern.dof.clone();
    let p: Vec<f64> = (0..dof.len()).map(|i| wave(i, 2.3)).collect();
    let mut product = vec![0.0; p.len()];
    assembler.pattern.multiply(assembler.values(), &p, &mut product);

    const STEP: f64 = 1e-6;
    let [ahead, behind] = [STEP, -STEP].map(|step| {
        let mut moved = state.clone();
        dof.iter().zip(&p).for_each(|(&dof, p)| moved.x[dof as usize] += step * p);
        springs_at(&moved)
    });
    let mut force = vec![0.0; state.x.len()];
    for (((now, ahead), behind), tangent) in springs_at(&state).iter().zip(&ahead).zip(&behind).zip(&tangents) {
        let stretch = (ahead.length - behind.length) / (2.0 * STEP);
        let change = (ahead.n - behind.n) * (tangent.tension / (2.0 * STEP)) + now.n * (tangent.stiffness * stretch);
        for (axis, change) in change.iter().enumerate() {
            let [a, b] = now.nodes.map(|node| 3 * node as usize + axis);
            force[a] += change;
            force[b] -= change;
        }
    }
    for (&dof, product) in dof.iter().zip(&product) {
        let expected = -force[dof as usize];
        assert!((product - expected).abs() < 1e-5 * 1e3, "{product} for {expected}");
    }
}

/// Soft springs that push while the sheet folds: as much of their compression is in the matrix as keeps it positive
/// definite.
#[test]
fn a_soft_sheet_that_pushes_finds_where_it_hangs() {
    let made = equilibrium(&case_of(&sheet(40, 10.0, LAWS[0]), &[])).counters.newton_iterations;
    assert!(made <= 120, "{made} iterations");
}

/// A flat sheet swings down in steps that are long beside every period of its springs: it completes in few iterations a
/// step, with the same bits on one thread and on two.
#[test]
fn flat_sheets_swing_down_in_long_steps() {
    for law in LAWS {
        for stiffness in [1e4, 1e6] {
            for step in ["0.01", "0.1"] {
                let case = case_of(&sheet(12, stiffness, law), &[("time.step", step)]);
                let [one, two] = [1, 2].map(|threads| run_with(&case, threads));
                let label = format!("{law}, {stiffness} N/m, {step} s");
                assert_eq!(one.outcome.status, Status::Completed, "{label}: {:?}", one.outcome.failure);
                assert!(one.state == two.state && one.outcome.counters == two.outcome.counters, "{label}");
                let mean = one.outcome.counters.newton_iterations as f64 / one.outcome.steps as f64;
                assert!(mean < 45.0 && one.most_iterations <= 100, "{label}: {mean}, {}", one.most_iterations);
                let lowest = one.positions.iter().fold(f64::INFINITY, |least: f64, x| least.min(x[2]));
                assert!(lowest > -1.05 && lowest < -0.5, "{label}: {lowest} m");
            }
        }
    }
}

/// A flat sheet of membranes, held along one side.
fn membrane_sheet(cells: usize, modulus: f64, wrinkling: bool) -> Value {
    let mut case = sheet(cells, 1.0, "both ways");
    let network = &mut case["system"]["network"];
    network.as_object_mut().expect("an object").remove("springs");
    network["membranes"] =
        json!([{"on": "all", "thickness": 1e-4, "modulus": modulus, "poisson": 0.3, "wrinkling": wrinkling}]);
    case
}

/// [N/m] The matrix with stresses S is the derivative of the forces A B^T (S + D dE) by positions, for any S: by
/// central differences of the strains' derivatives B.
#[test]
fn the_matrix_with_stresses_agrees_with_differences() {
    let mut problem = case_of(&membrane_sheet(3, 1e7, false), &[]).problem().clone();
    let scene = build_scene(problem.take_system(), 1).expect("the case is good");
    let system: &dyn TangentSystem = scene.interfaces().tangent;
    let mixed = system.mixed().expect("membranes");
    let wave = |i: usize, w: f64| (1.0 + w * i as f64).sin();
    let mut state = scene.initial_state();
    state.x.iter_mut().enumerate().for_each(|(i, x)| *x += 0.05 * wave(i, 1.7));
    let sheets_at = |state: &State| {
        let mut sheets = vec![SheetState::default(); mixed.sheets()];
        mixed.measure_sheets(state.as_ref(), 0.0, &mut sheets);
        sheets
    };
    let given = |i: usize| sheets_at(&state)[0].stiffness.column(0) * 0.1 * wave(i, 0.3);
    let stresses: Vec<_> = (0..mixed.sheets()).map(given).collect();
    let mut assembler = system.assembler().expect("small");
    let form = MixedForm { springs: &[], sheets: &stresses, convex: false, definite: false, symmetric: true };
    mixed.assemble_mixed(state.as_ref(), Weights { m: 0.0, c: 0.0, k: 1.0 }, form, &mut assembler);

    let dof = assembler.pattern.dof.clone();
    let p: Vec<f64> = (0..dof.len()).map(|i| wave(i, 2.3)).collect();
    let mut product = vec![0.0; p.len()];
    assembler.pattern.multiply(assembler.values(), &p, &mut product);

    const STEP: f64 = 1e-6;
    let [ahead, behind] = [STEP, -STEP].map(|step| {
        let mut moved = state.clone();
        dof.iter().zip(&p).for_each(|(&dof, p)| moved.x[dof as usize] += step * p);
        sheets_at(&moved)
    });
    let mut change = vec![0.0; state.x.len()];
    for (((now, ahead), behind), stress) in sheets_at(&state).iter().zip(&ahead).zip(&behind).zip(&stresses) {
        let rise = (ahead.stress - behind.stress) / (2.0 * STEP);
        for corner in 0..3 {
            let turn = (ahead.by_node[corner] - behind.by_node[corner]).transpose() * stress / (2.0 * STEP);
            let force = (turn + now.by_node[corner].transpose() * rise) * now.area;
            (0..3).for_each(|axis| change[3 * now.nodes[corner] as usize + axis] += force[axis]);
        }
    }
    let largest = change.iter().fold(0.0, |most: f64, change| most.max(change.abs()));
    for (&dof, product) in dof.iter().zip(&product) {
        let expected = change[dof as usize];
        assert!((product - expected).abs() < 1e-6 * largest, "{product} for {expected}");
    }
}

/// A flat sheet of membranes swings down in steps that are long beside every period of its own, taut or wrinkled. With
/// the stresses of its strains alone, Newton's iteration ends in the first step.
#[test]
fn membranes_swing_down_in_long_steps() {
    for wrinkling in [false, true] {
        let case = case_of(&membrane_sheet(12, 1e10, wrinkling), &[("time.step", "0.1"), ("time.end", "0.5")]);
        let [one, two] = [1, 2].map(|threads| run_with(&case, threads));
        assert_eq!(one.outcome.status, Status::Completed, "{wrinkling}: {:?}", one.outcome.failure);
        assert!(one.state == two.state && one.outcome.counters == two.outcome.counters, "{wrinkling}");
        assert_eq!(one.outcome.counters.lu_factorizations, 0, "{wrinkling}");
        let mean = one.outcome.counters.newton_iterations as f64 / one.outcome.steps as f64;
        assert!(mean < 40.0, "{wrinkling}: {mean}");
        let lowest = one.positions.iter().fold(f64::INFINITY, |least: f64, x| least.min(x[2]));
        assert!(lowest > -1.05 && lowest < -0.2, "{wrinkling}: {lowest} m");
    }
}
