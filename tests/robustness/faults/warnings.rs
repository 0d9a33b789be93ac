//! Warnings before a run: every one fires where it should, with its code, and stays silent beside it; what is shipped
//! has none.

use canopy_fem::case::Case;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

use super::program::{Finished, program, program_with};

/// The codes of a case's warnings, sorted, and their texts.
pub(super) fn warnings(case: &Value) -> (Vec<String>, String) {
    let read = Case::from_text(case.to_string(), "case.json", PathBuf::new(), &[]).unwrap_or_else(|e| panic!("{e}"));
    let mut codes: Vec<String> = read.warnings().iter().map(|w| w.code.to_string()).collect();
    codes.sort();
    (codes, read.warnings().iter().map(|w| format!("{w}\n")).collect())
}

/// A case with values replaced, by JSON pointer.
pub(super) fn with(case: &Value, sets: &[(&str, Value)]) -> Value {
    let mut case = case.clone();
    for (pointer, value) in sets {
        let (above, key) = pointer.rsplit_once('/').expect("a pointer");
        let object = case.pointer_mut(above).expect("it is there").as_object_mut().expect("an object");
        object.insert(key.to_owned(), value.clone());
    }
    case
}

/// A sail of 1 m in a wind across it, held at its edge: nothing is to be said of it.
fn sail() -> Value {
    json!({"name": "sail", "system": {"network": {
        "mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": 4, "rows": 4}},
        "mass": {"areal_density": 0.05},
        "springs": [{"on": "all", "stiffness": 100.0}],
        "supports": [{"on": "outer", "fix": "xyz"}],
        "gravity": [0, 0, -9.81],
        "aero": {"wind": [0, 0, 10], "law": {"pressure_coefficient": {"cp": 1.2, "air_density": 1.225}}}}},
        "time": {"end": 4.0, "method": "newmark", "step": 1e-2}})
}

/// Two strips that meet at a point and share no node there.
fn strips() -> Value {
    json!({"name": "strips", "system": {"network": {
        "mesh": {"explicit": {"nodes": [[0,0,0],[1,0,0],[1,0,0],[2,0,0]], "springs": [[0,1],[2,3]]}},
        "mass": {"nodal": 0.1}, "springs": [{"on": "all", "stiffness": 100.0}],
        "supports": [{"on": {"ids": [0]}, "fix": "xyz"}], "gravity": [0, 0, -9.81]}},
        "time": {"end": 0.1, "method": "newmark", "step": 1e-3}})
}

/// Two triangles of membrane apart from each other, one of them held.
fn pieces() -> Value {
    json!({"name": "pieces", "system": {"network": {
        "mesh": {"explicit": {"nodes": [[0,0,0],[1,0,0],[0,1,0],[2,0,0],[3,0,0],[2,1,0]],
            "triangles": [[0,1,2],[3,4,5]]}},
        "mass": {"areal_density": 0.1},
        "membranes": [{"on": "all", "thickness": 1e-4, "modulus": 1e8, "poisson": 0.3, "wrinkling": true}],
        "supports": [{"on": {"ids": [0]}, "fix": "xyz"}], "gravity": [0, 0, -9.81]}},
        "time": {"end": 0.1, "method": "newmark", "step": 1e-3}})
}

/// Two masses on a spring that turn at 10 rad/s.
fn dumbbell(dashpot: Value) -> Value {
    json!({"name": "spin", "system": {"network": {
        "mesh": {"explicit": {"nodes": [[-0.5,0,0],[0.5,0,0]], "springs": [[0,1]]}}, "mass": {"nodal": 1.0},
        "springs": [{"on": "all", "stiffness": 1e4, "dashpot": dashpot}],
        "initial": {"velocity": [[0,-5,0],[0,5,0]]}}},
        "time": {"end": 1.0, "method": "rk4", "step": 1e-4}, "output": {"probes": [{"name": "p", "on": "all"}]}})
}

/// Three triangles at one edge, with a pressure on some.
fn branching(load: Value) -> Value {
    json!({"name": "fin", "system": {"network": {
        "mesh": {"explicit": {"nodes": [[0,0,0],[1,0,0],[0,1,0],[0,-1,0],[0,0,1]],
            "springs": [[0,1],[1,2],[2,0],[1,3],[3,0],[1,4],[4,0]], "triangles": [[0,1,2],[1,0,3],[0,1,4]]}},
        "mass": {"areal_density": 0.1}, "springs": [{"on": "all", "stiffness": 100}],
        "supports": [{"on": {"ids": [0, 1]}, "fix": "xyz"}], "loads": [load]}},
        "time": {"end": 0.1, "method": "newmark", "step": 1e-3}})
}

/// A dome of 2 m across over eight sides whose top is at this height [m], held all around.
fn dome(height: f64) -> Value {
    let corner = |i: u32| (f64::from(i) * std::f64::consts::FRAC_PI_4).sin_cos();
    let mut nodes: Vec<[f64; 3]> = (0..8).map(corner).map(|(y, x)| [x, y, 0.0]).collect();
    nodes.push([0.0, 0.0, height]);
    // Seen from above against the clock, so that normals look up; a top that is turned down has them down.
    let side = |i: u32| if height > 0.0 { [i, (i + 1) % 8, 8] } else { [(i + 1) % 8, i, 8] };
    let triangles: Vec<[u32; 3]> = (0..8).map(side).collect();
    json!({"name": "dome", "system": {"network": {
        "mesh": {"explicit": {"nodes": nodes, "triangles": triangles}},
        "mass": {"areal_density": 1.0},
        "membranes": [{"on": "all", "thickness": 1e-3, "modulus": 1e8, "poisson": 0.3}],
        "supports": [{"on": "outer", "fix": "xyz"}], "gravity": [0, 0, -9.81]}},
        "time": {"end": 0.1, "method": "newmark", "step": 1e-3}})
}

const N: &str = "/system/network";

#[test]
fn every_warning_fires_alone() {
    let law = |law: Value| ("/system/network/aero/law", law);
    let ergun = json!({"ergun": {"porosity": 0.1, "pore_diameter": 5e-5, "thickness": 1e-4, "air_density": 1.225, "air_viscosity": 1.81e-5}});
    let permeable = json!({"permeable": {"a": 1.6e6, "b": 4.8e5, "thickness": 1e-4}});
    let rectangle = |width: f64| json!({"rectangle": {"width": width, "height": width, "columns": 4, "rows": 4}});
    let mesh = |width: f64| ("/system/network/mesh", rectangle(width));
    let relative = json!({"relative": {"time": 5e-5}});
    let rayleigh = |key: &str| ("/system/network/damping", json!({"rayleigh": {key: 5e-5}}));
    let loop_ends =
        json!({"explicit": {"nodes": [[0,0,0],[1,0,0],[1,1,0],[0,0,1e-7]], "springs": [[0,1],[1,2],[2,3]]}});
    for (case, code, words) in [
        (with(&strips(), &[(&format!("{N}/mesh"), loop_ends)]), "coincident-nodes", "nodes 0 and 3 coincide"),
        (pieces(), "no-support", "nodes 3, 4, 5 are connected to no support"),
        (with(&sail(), &[(&format!("{N}/aero/wind"), json!([10, 1, 0]))]), "wind-in-plane", "of all 32 triangles"),
        (
            with(&sail(), &[(&format!("{N}/aero/wind"), json!([30, 0, 2]))]),
            "no-suction",
            "32 triangles that supports hold on both sides (triangle 0 first): this law gives them 0.44 % of",
        ),
        (
            with(
                &dome(1.0),
                &[(&format!("{N}/aero"), json!({"wind": [30, 0, 0], "law": {"pressure_coefficient": {"cp": 1.0}}}))],
            ),
            "no-suction",
            "and meets their outer and their inner face: this law lets it blow through the cloth",
        ),
        (
            with(&dome(1.0), &[(&format!("{N}/aero"), json!({"law": {"surface_pressure": {"all": -0.7}}}))]),
            "no-wind",
            "nothing on its 8 triangles",
        ),
        (
            with(
                &dome(-1.0),
                &[(&format!("{N}/aero"), json!({"wind": [30, 0, 0], "law": {"surface_pressure": {"all": -0.7}}}))],
            ),
            "inside-out",
            "the outer faces of 8 triangles with surface_pressure look down (triangle 0 first)",
        ),
        (with(&sail(), &[law(ergun), (&format!("{N}/aero/wind"), json!([0, 0, 50]))]), "air-pressure", "Pa at 50 m/s"),
        (with(&sail(), &[law(permeable)]), "air-pressure", "take \"pressure_coefficient\""),
        (
            with(&sail(), &[law(json!({"pressure_coefficient": {"cp": 1.6, "air_density": 1.225}}))]),
            "air-pressure",
            "1.6 times the dynamic pressure",
        ),
        (with(&sail(), &[(&format!("{N}/supports"), json!([]))]), "closing-canopy", "no inner pressure"),
        (
            with(
                &sail(),
                &[(&format!("{N}/supports"), json!([{"on": "outer", "fix": "xyz", "when": {"height_above": -1}}]))],
            ),
            "event-at-start",
            "waits for a height above -1 m",
        ),
        (with(&sail(), &[mesh(1000.0)]), "large-extent", "1000 m across"),
        (
            with(&sail(), &[mesh(499.0), (&format!("{N}/mass"), json!({"areal_density": 0.5}))]),
            "large-mass",
            "124500 kg",
        ),
        (with(&sail(), &[(&format!("{N}/gravity"), json!([0, 0, -9810]))]), "large-gravity", "mm/s^2"),
        (with(&sail(), &[("/time/step", json!(2.0))]), "long-step", "the wind covers 20 m in it, and the scene is 1 m"),
        (with(&sail(), &[(&format!("{N}/mass"), json!({"areal_density": 50.0}))]), "areal-density", "in grams?"),
        (
            branching(json!({"on": "all", "pressure": 10.0})),
            "branching-edge",
            "triangles 0, 1, 2 with pressure meet at the edge of nodes 0 and 1",
        ),
        (branching(json!({"on": "all", "pressure": 10.0, "kind": "dead"})), "branching-edge", "nodes 0 and 1"),
        (
            dumbbell(relative),
            "braked-rotation",
            "no support holds nodes 0, 1, and relative dashpots brake the rotation",
        ),
        (
            with(&dumbbell(Value::Null), &[rayleigh("stiffness")]),
            "braked-rotation",
            "Rayleigh damping with the stiffness",
        ),
        (with(&dumbbell(Value::Null), &[rayleigh("mass")]), "braked-rotation", "brakes rotation and translation"),
    ] {
        let (codes, texts) = warnings(&case);
        assert_eq!(codes, [code], "{texts}");
        assert!(texts.contains(words) && texts.ends_with(&format!("[{code}]\n")), "no \"{words}\" in {texts}");
    }
}

#[test]
fn sane_neighbours_have_no_warning() {
    let at = |below: &str| format!("{N}/{below}");
    let table = json!({"table": [[0, 10, 0, 0], [1, 0, 10, 0], [2, 10, 0, 5]]});
    let cp = |cp: f64| json!({"pressure_coefficient": {"cp": cp, "air_density": 1.225}});
    let rectangle = |width: f64| json!({"rectangle": {"width": width, "height": width, "columns": 4, "rows": 4}});
    let apart = json!({"explicit": {"nodes": [[0,0,0],[1,0,0],[1,1,0],[0,0,1e-3]], "springs": [[0,1],[1,2],[2,3]]}});
    let together = json!({"explicit": {"nodes": [[0,0,0],[1,0,0],[1,1,0],[0,0,0]], "springs": [[0,1],[1,2],[2,3]]}});
    let bulge: Vec<[f64; 3]> = (0..25).map(|i| if i == 12 { [0.0, 0.0, 0.01] } else { [0.0; 3] }).collect();
    // A flag in a wind along it, as against a roof that is held all around.
    let pole = json!([{"on": {"box": [[0, 0, 0], [0, 1, 0]]}, "fix": "xyz"}]);
    let skirt = json!([{"on": "outer", "fix": "z"}]);
    let inside = json!([{"on": "all", "pressure": 50.0}]);
    let dead = json!({"on": "all", "pressure": 10.0, "kind": "dead", "direction": [0, 0, 1]});
    let membranes = pieces()["system"]["network"]["membranes"].clone();
    // A tape that only the cloth holds.
    let mut taped = pieces();
    taped["system"]["network"]["mesh"] = json!({"explicit": {
        "nodes": [[0,0,0],[1,0,0],[0,1,0],[1,1,0],[2,0,0]], "springs": [[3, 4]],
        "triangles": [[0,1,2],[1,3,2],[1,4,3]]
    }});
    taped["system"]["network"]["springs"] = json!([{"on": "all", "stiffness": 100.0}]);
    let both = json!([{"on": {"ids": [0, 3]}, "fix": "xyz"}]);
    for case in [
        sail(),
        with(&sail(), &[(&at("supports"), json!([{"on": "outer", "fix": "xyz", "when": {"height_below": -1}}]))]),
        with(&sail(), &[(&at("springs"), json!([])), (&at("membranes"), membranes)]),
        taped,
        with(&pieces(), &[(&at("supports"), both)]),
        with(&sail(), &[(&at("aero/wind"), json!([10, 0, 0.1])), (&at("supports"), pole.clone())]),
        with(&sail(), &[(&at("aero/wind"), json!([10, 0, 5]))]),
        with(&sail(), &[(&at("aero"), json!({"wind": [10, 0, 0.1], "law": {"surface_pressure": {"all": -0.7}}}))]),
        with(&sail(), &[(&at("aero/wind"), table)]),
        // Roof cloth is heavy, and a wind on the outer face of a dome only is no wind over it.
        dome(1.0),
        with(&dome(1.0), &[(&at("mass"), json!({"areal_density": 1.5}))]),
        with(&dome(1.0), &[(&at("aero"), json!({"wind": [0, 0, -30], "law": {"pressure_coefficient": {"cp": 1.0}}}))]),
        with(&dome(1.0), &[(&at("aero"), json!({"wind": [30, 0, 0], "law": {"surface_pressure": {"all": -0.7}}}))]),
        with(&sail(), &[(&at("aero/wind"), json!([0, 0, 0]))]),
        with(
            &sail(),
            &[
                (&at("aero/wind"), json!([10, 0, 0])),
                (&at("supports"), pole),
                (&at("initial"), json!({"displacement": bulge})),
            ],
        ),
        with(&sail(), &[(&at("aero/law"), cp(1.45))]),
        with(&sail(), &[(&at("supports"), skirt)]),
        with(&sail(), &[(&at("supports"), json!([])), (&at("loads"), inside)]),
        with(&sail(), &[(&at("supports"), json!([])), (&at("aero"), Value::Null)]),
        with(&sail(), &[(&at("mesh"), rectangle(400.0))]),
        with(&sail(), &[(&at("gravity"), json!([0, 0, -24.8]))]),
        with(&sail(), &[("/time/step", json!(0.2))]),
        with(&strips(), &[(&at("mesh"), apart)]),
        with(&strips(), &[(&at("mesh"), together), (&at("supports"), json!([{"on": {"ids": [0, 3]}, "fix": "xyz"}]))]),
        branching(json!({"on": {"ids": [0, 1]}, "pressure": 10.0})),
        branching(dead),
        dumbbell(json!({"axial": {"time": 5e-5}})),
        with(
            &dumbbell(json!({"relative": {"time": 5e-5}})),
            &[(&at("supports"), json!([{"on": {"ids": [0]}, "fix": "xyz"}])), (&at("initial"), Value::Null)],
        ),
    ] {
        let (codes, texts) = warnings(&case);
        assert!(codes.is_empty(), "{texts}of {case}");
    }
}

/// Parts and coincident nodes of random nets are those that a comparison of all with all finds.
#[test]
fn random_nets_fall_into_their_parts() {
    let mut state = 7_u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) as usize) % below
    };
    let (mut apart, mut close) = (0, 0);
    for _ in 0..300 {
        let n = 3 + random(30);
        // Corners of a coarse lattice: many nodes share planes and lines, some a place.
        let nodes: Vec<[f64; 3]> = (0..n).map(|_| [random(9), random(9), random(2)].map(|x| x as f64)).collect();
        let mut springs: Vec<[usize; 2]> = (0..n + random(n)).map(|_| [random(n), random(n)]).collect();
        springs.retain(|[a, b]| a < b && nodes[*a] != nodes[*b]);
        springs.sort_unstable();
        springs.dedup();
        if springs.is_empty() {
            continue;
        }
        let held = springs[random(springs.len())][0];
        let mut part: Vec<usize> = (0..n).collect();
        for _ in 0..n {
            springs.iter().for_each(|&[a, b]| {
                let least = part[a].min(part[b]);
                (part[a], part[b]) = (least, least);
            });
        }
        let size = |p: usize| part.iter().filter(|q| **q == p).count();
        let free: Vec<usize> = (0..n).filter(|i| part[*i] != part[held] && size(part[*i]) > 1).collect();
        let pairs = (0..n).flat_map(|a| (a + 1..n).map(move |b| [a, b])).filter(|[a, b]| nodes[*a] == nodes[*b]);
        let pairs: Vec<[usize; 2]> = pairs.collect();
        let case = json!({"name": "net", "system": {"network": {
            "mesh": {"explicit": {"nodes": nodes, "springs": springs}}, "mass": {"nodal": 0.1},
            "springs": [{"on": "all", "stiffness": 10.0}], "supports": [{"on": {"ids": [held]}, "fix": "xyz"}]}},
            "time": {"end": 1.0, "method": "newmark", "step": 0.01}});
        let (codes, texts) = warnings(&case);
        let has = |code: &str| codes.iter().any(|c| c == code);
        assert_eq!(has("no-support"), !free.is_empty(), "{texts}of {case}");
        assert_eq!(has("coincident-nodes"), !pairs.is_empty(), "{texts}of {case}");
        if let Some(first) = free.first() {
            apart += 1;
            assert!(texts.contains(&format!("nodes {first}, ")), "{texts}of {case}");
        }
        if let Some([a, b]) = pairs.first() {
            close += 1;
            assert!(texts.contains(&format!("nodes {a} and {b} coincide")), "{texts}of {case}");
        }
    }
    assert!(apart > 30 && close > 30, "{apart} and {close}");
}

/// A million coincidences, or a sheet across the line of the search, are no trap: the work is bounded by the number of
/// nodes.
#[test]
fn many_nodes_at_one_place_are_found_at_once() {
    let nodes: Vec<[f64; 3]> = (0..20_000).map(|i| if i == 0 { [1.0, 0.0, 0.0] } else { [0.0; 3] }).collect();
    let case = with(&strips(), &[(&format!("{N}/mesh"), json!({"explicit": {"nodes": nodes, "springs": [[0, 1]]}}))]);
    let (_, texts) = warnings(&case);
    assert!(texts.contains("nodes 1 and 2 coincide, as do "), "{texts}");
}

pub(super) fn lines(text: &str) -> Vec<String> {
    text.lines().filter(|line| line.starts_with("warning: ")).map(str::to_owned).collect()
}

#[test]
fn check_and_solve_say_the_same_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let checked = program(folder.path(), &strips(), &["check"]);
    let solved = program(folder.path(), &strips(), &["solve"]);
    assert_eq!((checked.status, solved.status), (Some(0), Some(0)), "{}{}", checked.stderr, solved.stderr);
    let said = lines(&checked.stdout);
    assert_eq!(said, lines(&solved.stderr));
    assert!(said.len() == 2 && said[0].contains("nodes 2, 3 are connected to no support"), "{said:?}");
    assert!(said[1].contains("nodes 1 and 2 coincide"), "{said:?}");
}

/// An acknowledged warning is a note of `check`, and `solve` does not print it; an unknown code is a fault with the
/// nearest one.
#[test]
fn a_case_acknowledges_warnings_by_their_codes() {
    let folder = tempfile::tempdir().expect("a folder");
    let known = with(&strips(), &[("/acknowledge", json!(["no-support", "coincident-nodes"]))]);
    let checked = program(folder.path(), &known, &["check"]);
    let solved = program(folder.path(), &known, &["solve"]);
    assert_eq!((solved.status, solved.stderr.as_str()), (Some(0), ""));
    assert!(lines(&checked.stdout).is_empty(), "{}", checked.stdout);
    let notes = checked.stdout.lines().filter(|line| line.starts_with("acknowledged: ")).count();
    assert_eq!(notes, 2, "{}", checked.stdout);
    let misspelt = with(&strips(), &[("/acknowledge", json!(["no-suport"]))]);
    let refused = program(folder.path(), &misspelt, &["check"]);
    assert_eq!(refused.status, Some(2));
    for words in ["/acknowledge/0: \"no-suport\"", "did you mean \"no-support\"?"] {
        assert!(refused.stderr.contains(words), "no {words} in {}", refused.stderr);
    }
}

/// The braked dumbbell keeps exp(-1) of its spin, and the run says so; with axial dashpots it keeps all of it, and
/// nothing is said.
#[test]
fn a_braked_spin_is_warned_of_before_and_after_the_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let spin = |dashpot: Value| {
        let ended = program(folder.path(), &dumbbell(dashpot), &["solve", "--force"]);
        assert_eq!(ended.status, Some(0), "{}", ended.stderr);
        let rows = std::fs::read_to_string(folder.path().join("out/spin/probes.csv")).expect("rows");
        let last = rows.lines().last().expect("a row").split(',').map(|cell| cell.parse().unwrap_or(f64::NAN));
        let last: Vec<f64> = last.collect();
        // Twice the x v_y - y v_x of one mass, over the 5 of the start.
        ((last[3] * last[7] - last[4] * last[6]) * 2.0 / 5.0, ended)
    };
    let (left, ended) = spin(json!({"relative": {"time": 5e-5}}));
    assert!((left - (-1.0_f64).exp()).abs() < 5e-3, "{left}");
    let said = lines(&ended.stderr);
    assert_eq!(said.len(), 2, "{said:?}");
    assert!(said[0].ends_with("[braked-rotation]") && said[1].ends_with("[energy-dissipated]"), "{said:?}");
    let (left, ended) = spin(json!({"axial": {"time": 5e-5}}));
    assert!((left - 1.0).abs() < 1e-3, "{left}");
    assert!(ended.stderr.is_empty(), "{}", ended.stderr);
}

/// A case whose reefing line is cut within the run, and a time [s] after that.
const REEFED: &str = "g12-reefed";
const AFTER_THE_CUT: &str = "4.1";

fn shipped() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/cases");
    let files = [folder.clone(), folder.join("big"), folder.join("parachute")]
        .into_iter()
        .flat_map(|f| std::fs::read_dir(f).expect("cases"));
    let mut paths: Vec<PathBuf> = files.map(|e| e.expect("an entry").path()).filter(|p| p.is_file()).collect();
    paths.sort();
    assert!(paths.len() >= 18, "{paths:?}");
    paths
}

/// Words of a command line, with what stands in single quotes as one word.
fn words(line: &str) -> Vec<String> {
    let parts = line.split('\'').enumerate();
    let plain = |part: &str| part.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    parts.flat_map(|(i, part)| if i % 2 == 1 { vec![part.to_owned()] } else { plain(part) }).collect()
}

fn silent(what: &str, ended: &Finished) {
    for text in [&ended.stdout, &ended.stderr] {
        assert!(!text.contains("warning"), "{what}: {text}");
    }
}

/// What comes with the program is checked and solved without a warning. The large annuli are made with few nodes here.
#[test]
fn shipped_cases_have_no_warning() {
    let folder = tempfile::tempdir().expect("a folder");
    for path in shipped() {
        let name = path.display().to_string();
        let big = name.contains("/big/");
        let small = ("system.network.mesh.annulus.nodes".to_owned(), "500".to_owned());
        let sets = if big { vec![small] } else { Vec::new() };
        let case = Case::from_file(&path, &sets).unwrap_or_else(|e| panic!("{e}"));
        assert!(case.warnings().is_empty(), "{name}: {:?}", case.warnings());
        // What a code stands for must be there: nothing is acknowledged in advance.
        let problem = case.problem();
        for code in &problem.acknowledge {
            assert!(problem.acknowledged.iter().any(|w| w.code == *code), "{name} acknowledges {code} for nothing");
        }
        let step = problem.time.step.fixed().expect("a step");
        let end = if name.contains(REEFED) { AFTER_THE_CUT.to_owned() } else { format!("{:e}", 5.0 * step) };
        let sets: Vec<String> = sets.iter().map(|(key, value)| format!("{key}={value}")).collect();
        let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", set.as_str()]).collect();
        let solved = program_with(folder.path(), &[&["solve", &name, "--end", &end][..], &sets].concat());
        assert_eq!(solved.status, Some(0), "{name}: {}", solved.stderr);
        if name.contains("parachute-original") {
            // Its air strains its cloth by hundreds of percent at once, which is told.
            assert_eq!(solved.stderr.matches("warning").count(), 1, "{}", solved.stderr);
            assert!(solved.stderr.contains("[strained-cloth]"), "{}", solved.stderr);
        } else {
            silent(&name, &solved);
        }
    }
}

/// The same for `check`, of which cloths of one mesh differ in numbers only.
#[test]
fn shipped_cases_are_checked_without_a_warning() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in
        ["cloth-k1000", "oscillator-damped", "pendulum", "spring-pendulum", "parachute-50ms", "parachute/c9-drop"]
    {
        let path = format!("{}/assets/cases/{name}.json", env!("CARGO_MANIFEST_DIR"));
        let checked = program_with(folder.path(), &["check", &path, "--end", "1e-2"]);
        assert_eq!(checked.status, Some(0), "{}", checked.stderr);
        silent(name, &checked);
    }
}

/// Commands of README and docs that solve a shipped case, made short, and the case that `init` writes.
#[test]
fn the_documents_and_init_lead_to_no_warning() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().expect("a folder");
    std::os::unix::fs::symlink(root.join("assets"), folder.path().join("assets")).expect("a link");
    let text = |name: &str| std::fs::read_to_string(root.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    let shown = text("README.md") + &text("docs/using.md");
    let blocks = shown.split("```sh").skip(1).filter_map(|rest| rest.split("```").next());
    let commands = blocks.flat_map(str::lines).filter_map(|line| line.split_once("solve assets/cases/"));
    let mut count = 0;
    for (_, rest) in commands {
        let rest = rest.split(" #").next().expect("a command");
        // One diverges, as it says; the other takes seconds to mesh.
        if rest.starts_with("parachute-original") || rest.starts_with("big/") {
            continue;
        }
        let end = if rest.contains(REEFED) { AFTER_THE_CUT } else { "0.02" };
        let line = format!("solve assets/cases/{rest} --end {end}");
        let mut args = words(&line);
        if !args.iter().any(|arg| arg == "--out") {
            args.extend(["--out".to_owned(), format!("out/{count}")]);
        }
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        let ended = program_with(folder.path(), &args);
        assert_eq!(ended.status, Some(0), "{line}: {}", ended.stderr);
        silent(&line, &ended);
        count += 1;
    }
    assert!(count >= 5, "{count} commands");
    assert_eq!(program_with(folder.path(), &["init", "mine"]).status, Some(0));
    let ended = program_with(folder.path(), &["solve", "mine.json", "--end", "0.05"]);
    assert_eq!(ended.status, Some(0), "{}", ended.stderr);
    silent("init", &ended);
}
