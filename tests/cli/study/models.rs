//! Models of the cloth: what a net costs beside membranes, and that both come from either.

use canopy_fem::study::Study;
use canopy_fem::study::models::Model;
use serde_json::{Value, json};

use super::table::{counted, study};
use crate::bench::{Bench, Ended};

const FLAGS: [&str; 6] = ["--methods", "newmark", "--steps", "5e-3,1.25e-3", "--repeat", "1"];
/// [s] A power of two, so that a stiffness times it and over it is the same number.
const DAMPING: f64 = 1.0 / 1024.0;

fn with(flags: &[&'static str]) -> Vec<&'static str> {
    [&FLAGS[..], flags].concat()
}

/// A sheet of equilateral triangles, n a side, held on the left and pulled on the right to about this strain. A tape
/// goes along its lower side, beside the cloth that is given.
fn sheet(n: usize, strain: f64, (kind, cloth): (&str, Value)) -> Value {
    let (a, across) = (1.0 / n as f64, n + 1);
    let nodes = (0..across * across).map(|number| {
        let (i, j) = ((number % across) as f64, (number / across) as f64);
        [a * (i + j / 2.0), a * j * 0.75f64.sqrt(), 0.0]
    });
    let corners = (0..n * n).flat_map(|cell| {
        let first = cell / n * across + cell % n;
        [[first, first + 1, first + across], [first + 1, first + across + 1, first + across]]
    });
    let triangles: Vec<[usize; 3]> = corners.collect();
    let sides = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [a, c]]);
    let edges: std::collections::BTreeSet<[usize; 2]> = sides.map(|[a, b]| [a.min(b), a.max(b)]).collect();
    let tape: Vec<usize> = edges.iter().enumerate().filter(|(_, edge)| edge[1] < across).map(|(i, _)| i).collect();
    let side = |column: usize| (0..across).map(|j| j * across + column).collect::<Vec<_>>();
    let mut network = json!({
        "mesh": {"explicit": {"nodes": nodes.collect::<Vec<_>>(), "springs": edges, "triangles": triangles,
                              "groups": {"tape": {"edges": tape}}}},
        "mass": {"areal_density": 0.1},
        "springs": [{"on": {"group": "tape"}, "axial_rigidity": 1.0}],
        "supports": [{"on": {"ids": side(0)}, "fix": "xyz"}],
        "loads": [{"on": {"ids": side(n)}, "force": [87.0 * strain * a, 0, 0]}]
    });
    match kind {
        "membranes" => network["membranes"] = json!([cloth]),
        _ => network["springs"].as_array_mut().expect("a list").push(cloth),
    }
    json!({"name": "sheet", "system": {"network": network}, "time": {"end": 0.1, "method": "newmark", "step": 5e-3}})
}

fn membranes(poisson: f64) -> (&'static str, Value) {
    let damping = json!({"on": "all", "modulus": 1e5, "thickness": 1e-3, "poisson": poisson, "damping_time": DAMPING});
    ("membranes", damping)
}

fn springs() -> (&'static str, Value) {
    let sheet = json!({"modulus": 1e5, "thickness": 1e-3});
    ("springs", json!({"on": "all", "membrane": sheet, "dashpot": {"axial": {"time": DAMPING}}}))
}

fn tradeoff(bench: &Bench, case: &Value, out: &str, flags: &[&str]) -> Ended {
    std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
    bench.run(&[&["tradeoff", "case.json", "--out", out], flags].concat())
}

/// Both models of a case, and the error of the net.
fn compared(case: &Value) -> (Study, f64) {
    let bench = Bench::new();
    let ended = tradeoff(&bench, case, "out", &with(&["--models", "net,membrane"]));
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let found = study(&bench.path("out"));
    let error =
        found.plan.variants[0].models.iter().find_map(|report| report.error.as_ref()).expect("of the net").error;
    (found, error)
}

/// Of equilateral triangles with Poisson's ratio 1/3, net and membranes have the same energy to second order in the
/// strain. So their error falls with the strain, on two meshes alike; the constant is that of the two strain measures.
#[test]
fn a_taut_sheet_at_one_third_is_a_net() {
    for n in [3, 6] {
        let [large, small] = [1e-4, 1e-5].map(|strain| compared(&sheet(n, strain, membranes(1.0 / 3.0))).1);
        assert!(large < 1e-3, "{n} a side: {large:e}");
        assert!((large / small / 10.0 - 1.0).abs() < 0.05, "{n} a side: {large:e} and {small:e} at a tenth the strain");
    }
}

/// A sheet that is pulled along its edges is on the verge of wrinkling, and does so as it swings. Then the other edges
/// of a net go slack in turn, which is another motion at Poisson's ratio 1/3 too.
#[test]
fn a_wrinkling_sheet_is_no_net() {
    let mut wrinkled = membranes(1.0 / 3.0);
    wrinkled.1["wrinkling"] = json!(true);
    let [taut, wrinkled] = [membranes(1.0 / 3.0), wrinkled].map(|cloth| compared(&sheet(3, 1e-3, cloth)).1);
    assert!(taut < 0.01 && wrinkled > 0.1, "taut {taut:e}, wrinkled {wrinkled:e}");
}

/// A net cannot have Poisson's ratio 0: runs of the net come to its own error and stay there at smaller steps, those
/// of membranes do not. Everything that is written says so.
#[test]
fn a_sheet_at_zero_is_none() {
    let bench = Bench::new();
    let ended = tradeoff(&bench, &sheet(4, 1e-4, membranes(0.0)), "out", &with(&["--models", "net,membrane"]));
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let found = study(&bench.path("out"));
    let report = found.plan.variants[0].models.iter().find_map(|report| report.error.as_ref()).expect("of the net");
    assert!((0.05..0.5).contains(&report.error) && report.solution.error < 1e-6, "{report:?}");
    let finest = |model: Model| {
        let of_model = found.rows.iter().filter(|row| row.job.model == Some(model));
        of_model.filter_map(|row| row.measured.error).fold(f64::INFINITY, f64::min)
    };
    assert!((finest(Model::Net) / report.error - 1.0).abs() < 0.05, "{:e}", finest(Model::Net));
    assert!(finest(Model::Membrane) < 0.02 * report.error, "{:e}", finest(Model::Membrane));
    let error = canopy_fem::format_number::figures(report.error, 2);
    let said = format!("s a net the solution differs from that with membranes by {error} of the motion");
    let page = std::fs::read_to_string(bench.path("out/tradeoff.html")).expect("a page");
    assert!(ended.stdout.contains(&said) && page.contains(&said), "{}", ended.stdout);
    assert!(ended.stdout.contains(&format!("a step error below {error} is wasted on the net")), "{}", ended.stdout);
    let picture = std::fs::read_to_string(bench.path("out/tradeoff.svg")).expect("a picture");
    assert!(picture.contains(&format!("error of the net {error}")) && picture.contains("newmark (net)"));
    let table = std::fs::read_to_string(bench.path("out/tradeoff.csv")).expect("a table");
    let models: Vec<&str> = table.lines().map(|line| line.split(',').next().unwrap_or_default()).collect();
    assert_eq!((models[0], models.len()), ("model", 5), "{table}");
    assert_eq!([1, 2, 3, 4].iter().filter(|&&row| models[row] == "net").count(), 2, "{table}");
    let told: Value =
        serde_json::from_slice(&std::fs::read(bench.path("out/tradeoff.json")).expect("written")).expect("JSON");
    assert_eq!(told["answers"]["models"][0]["error"].as_f64(), Some(report.error));
}

/// Membranes at 1/3 and the springs that stand for them are the same two models, with dampers and tapes, and where they
/// wrinkle.
#[test]
fn either_model_gives_both() {
    for wrinkling in [false, true] {
        let bench = Bench::new();
        let [mut sheets, mut net] = [membranes(1.0 / 3.0), springs()];
        if wrinkling {
            sheets.1["wrinkling"] = json!(true);
            net.1["slack"] = json!("tension-only");
        }
        let both = [("membranes", sheets), ("springs", net)].map(|(out, cloth)| {
            let ended = tradeoff(&bench, &sheet(3, 1e-3, cloth), out, &with(&["--models", "membrane,net"]));
            assert_eq!(ended.code, Some(0), "{}", ended.stderr);
            study(&bench.path(out))
        });
        let [a, b] = &both;
        assert_eq!(a.plan.variants[0].models.len(), 2);
        for (a, b) in a.plan.variants[0].models.iter().zip(&b.plan.variants[0].models) {
            assert_eq!(a.model, b.model);
            assert_eq!(a.fingerprint.differences(&b.fingerprint), None, "{:?}", a.model);
        }
        assert_eq!(counted(&a.rows), counted(&b.rows));
    }
}

/// With one model only its runs are made, measured against membranes all the same.
#[test]
fn a_net_alone_is_measured_against_membranes() {
    let (both, error) = compared(&sheet(3, 1e-4, membranes(0.0)));
    let bench = Bench::new();
    let mut case = sheet(3, 1e-4, membranes(0.0));
    case["study"] = json!({"models": ["net"]});
    let ended = tradeoff(&bench, &case, "out", &FLAGS);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let alone = study(&bench.path("out"));
    let of_net = |study: &Study| -> Vec<Option<f64>> {
        let rows = study.rows.iter().filter(|row| row.job.model == Some(Model::Net));
        rows.map(|row| row.measured.error).collect()
    };
    assert_eq!((alone.rows.len(), of_net(&alone)), (2, of_net(&both)));
    assert_eq!(alone.plan.variants[0].models[0].error.as_ref().map(|e| e.error), Some(error));
}

/// Shards of both models come to what one process makes, and the same command makes nothing again; other models are
/// another study.
#[test]
fn models_can_be_shared() {
    let bench = Bench::new();
    let case = sheet(3, 1e-4, membranes(0.2));
    let whole = with(&["--models", "net,membrane"]);
    for (out, flags) in [("whole", &whole[..]), ("parts", &[&whole[..], &["--plan"]].concat()[..])] {
        let ended = tradeoff(&bench, &case, out, flags);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    }
    for part in [&["--shard", "1/2"][..], &["--shard", "2/2"], &["--merge"]] {
        let ended = bench.run(&[&["tradeoff", "--out", "parts"], part].concat());
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    }
    assert_eq!(counted(&study(&bench.path("whole")).rows), counted(&study(&bench.path("parts")).rows));
    let before = study(&bench.path("whole"));
    let ended = tradeoff(&bench, &case, "whole", &whole);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert_eq!(before, study(&bench.path("whole")), "seconds would differ");
    let ended = tradeoff(&bench, &case, "whole", &with(&["--models", "net"]));
    assert!(ended.code == Some(2) && ended.stderr.contains("models were asked for"), "{}", ended.stderr);
}

/// `check` names the command, and tells the error once it was measured, also at another step; not that of other cloth.
#[test]
fn check_tells_what_was_measured() {
    let bench = Bench::new();
    let case = sheet(3, 1e-4, membranes(0.0));
    std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
    let check = |flags: &[&str]| {
        let ended = bench.run(&[&["check", "case.json"], flags].concat());
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        ended.stdout
    };
    let before = check(&[]);
    assert!(before.contains("canopy-fem tradeoff case.json --models net,membrane measures"), "{before}");
    let ended = bench.run(&[&["tradeoff", "case.json"], &with(&["--models", "net,membrane"])[..]].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let sentence = ended.stdout.lines().find(|line| line.contains("as a net")).expect("a sentence").trim();
    let after = check(&["--set", "time.step=0.002"]);
    assert!(after.contains(sentence) && after.contains("(measured in out/sheet)"), "{after}");
    let told: Value = serde_json::from_str(&check(&["--json"])).expect("JSON");
    assert_eq!(told["models"][0]["sentence"], sentence);
    let other = check(&["--set", "system.network.membranes.0.poisson=0.3"]);
    assert!(!other.contains("as a net"), "{other}");
}

/// Cloth without a second model is refused, with the reason.
#[test]
fn cloth_without_a_second_model_is_refused() {
    let spring = |key: &str, value: Value| {
        let (kind, mut rule) = springs();
        rule[key] = value;
        sheet(2, 1e-4, (kind, rule))
    };
    let mut orthotropic = membranes(0.1);
    orthotropic.1["modulus"] = json!([1e5, 9e4]);
    orthotropic.1["shear"] = json!(1e4);
    orthotropic.1["warp"] = json!([1, 0, 0]);
    let mut sideless = sheet(2, 1e-4, membranes(0.1));
    sideless["system"]["network"]["springs"] = json!([]);
    sideless["system"]["network"]["mesh"]["explicit"]["springs"] = json!([]);
    sideless["system"]["network"]["mesh"]["explicit"]["groups"] = json!({});
    let both = {
        let mut case = sheet(2, 1e-4, springs());
        case["system"]["network"]["membranes"] = json!([membranes(0.1).1]);
        case
    };
    let partly = spring("on", json!({"ids": [0, 1, 2]}));
    for (case, words) in [
        (sheet(2, 1e-4, ("springs", json!({"on": "all", "stiffness": 80.0}))), "no cloth of a known modulus"),
        (sheet(2, 1e-4, orthotropic), "a net of springs is isotropic"),
        (sideless, "not all sides of the triangles 0, 1"),
        (both, "are membranes and have springs of a sheet too"),
        (partly, "membranes need one sheet on all"),
        (spring("rest_scale", json!(0.9)), "rest lengths other than those of the mesh"),
        (spring("rest_scale", json!({"table": [[0, 1], [1, 0.9]]})), "rest lengths that change over time"),
        (spring("cut", json!(0.05)), "a time when they are cut"),
        (spring("slack", json!({"dead_zone": 0.01})), "a slack other than tension-only"),
        (spring("dashpot", json!({"relative": {"time": 1e-3}})), "dashpots that are relative"),
        (spring("dashpot", json!({"axial": {"coefficient": 1e-3}})), "dashpots of different times"),
    ] {
        let bench = Bench::new();
        let ended = tradeoff(&bench, &case, "out", &["--models", "net,membrane"]);
        assert!(ended.code == Some(2) && ended.stderr.contains(words), "{words}: {}", ended.stderr);
    }
    let bench = Bench::new();
    let flags = ["--models", "net,membrane", "--stiffness-sweep", "1,10"];
    let ended = tradeoff(&bench, &sheet(2, 1e-4, springs()), "out", &flags);
    assert!(ended.code == Some(2) && ended.stderr.contains("models are compared at one stiffness"), "{}", ended.stderr);
    let path = format!("{}/assets/cases/pendulum.json", env!("CARGO_MANIFEST_DIR"));
    let ended = bench.run(&["tradeoff", &path, "--out", "pendulum", "--models", "net"]);
    assert!(ended.code == Some(2) && ended.stderr.contains("no cloth"), "{}", ended.stderr);
}
