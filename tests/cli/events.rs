//! Events by state as the program tells them: report, summary, landing, resumed runs, and what is refused.

use crate::bench::{Bench, Ended, Results, contents};
use serde_json::{Value, json};

/// [m/s^2]
const G: f64 = 9.81;

/// A body that is thrown from 80 m, one that it releases at 60 m, and one that follows after 0.3 s.
fn case(method: &str) -> Value {
    json!({
        "name": "thrown",
        "system": {"network": {
            "mesh": {"explicit": {
                "nodes": [[0, 0, 80], [1, 0, 80], [2, 0, 80]], "springs": [],
                "groups": {"payload": {"nodes": [0]}}
            }},
            "mass": {"nodal": 1.0},
            "supports": [
                {"on": {"ids": [1]}, "fix": "xyz", "when": {"height_below": 60.0, "name": "main"}},
                {"on": {"ids": [2]}, "fix": "xyz", "when": {"after": "main", "delay": 0.3}}
            ],
            "gravity": [0, 0, -G],
            "initial": {"velocity": [[3, 4, 0], [0, 0, 0], [0, 0, 0]]}
        }},
        "time": {"end": 10.0, "method": method, "step": 0.01, "until": {"ground": 5.0}},
        "output": {"probes": [{"name": "bodies", "on": "all"}], "checkpoint": {"every": 0.1}},
        "acknowledge": ["loose-nodes"]
    })
}

fn write(bench: &Bench, case: &Value) {
    std::fs::write(bench.path("case.json"), case.to_string()).expect("written");
}

fn solve(bench: &Bench, case: &Value, arguments: &[&str]) -> Ended {
    write(bench, case);
    bench.run(&[&["solve", "case.json", "--out", "out"], arguments].concat())
}

/// The run ends on the ground; report and summary have the events and the landing.
#[test]
fn a_run_ends_on_the_ground() {
    let bench = Bench::new();
    let ended = solve(&bench, &case("velocity-verlet"), &[]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let landed = (2.0 * 75.0 / G).sqrt();
    let summary = bench.results().summary();
    let number = |value: &Value| value.as_f64().expect("a number");
    assert!((number(&summary["t_end"]) - landed).abs() < 1e-9, "{}", summary["t_end"]);
    let landing = &summary["landing"];
    let (down, along) = (G * landed, 5.0);
    for (key, expected) in [
        ("speed", down.hypot(along)),
        ("descent", down),
        ("drift", along * landed),
        ("heading", 3.0_f64.atan2(4.0).to_degrees()),
    ] {
        assert!((number(&landing[key]) - expected).abs() < 1e-7, "{key}: {landing}");
    }
    let events: Vec<(&str, &str)> = summary["events"]
        .as_array()
        .expect("events")
        .iter()
        .map(|event| (event["name"].as_str().expect("a name"), event["what"].as_str().expect("words")))
        .collect();
    assert_eq!(events, [("main", "release"), ("supports[1]", "release"), ("ground", "landing")]);
    let met = (2.0 * 20.0 / G).sqrt();
    for (event, expected) in [(0, met), (1, met + 0.3), (2, landed)] {
        assert!((number(&summary["events"][event]["time"]) - expected).abs() < 1e-9);
    }
    for line in ["event           t = 2.0", "main, release", "landing         t = 3.9", "towards 36.9 deg from north"] {
        assert!(ended.stdout.contains(line), "no \"{line}\" in {}", ended.stdout);
    }
    let again = solve(&bench, &case("velocity-verlet"), &["--resume"]);
    assert!(again.code == Some(0) && again.stdout.contains("nothing is left"), "{}{}", again.stdout, again.stderr);
}

/// An event that is not met is told, and the run goes on to its end.
#[test]
fn an_event_that_never_comes_is_told() {
    let bench = Bench::new();
    let ended = solve(&bench, &case("rk4"), &["--set", "time.end=1.5"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(ended.stdout.contains("never fired     main, supports[1], ground"), "{}", ended.stdout);
    let summary = bench.results().summary();
    assert_eq!(summary["never_fired"], json!(["main", "supports[1]", "ground"]));
    assert!(summary["events"].is_null() && summary["landing"].is_null());
}

/// A run that is stopped between the first event and the one that follows it goes on to the same files.
#[test]
fn a_resumed_run_has_the_same_files() {
    for method in ["velocity-verlet", "newmark"] {
        let (whole, parts) = (Bench::new(), Bench::new());
        assert_eq!(solve(&whole, &case(method), &[]).code, Some(0));
        for end in ["1.5", "2.15", "2.4"] {
            let arguments: &[&str] = if end == "1.5" { &[] } else { &["--resume"] };
            let ended = solve(&parts, &case(method), &[&["--end", end], arguments].concat());
            assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        }
        let ended = solve(&parts, &case(method), &["--resume"]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        let [one, other] = [&whole, &parts].map(|bench| {
            let all = contents(&bench.path("out"));
            let tables = all.into_iter().filter(|(path, _)| path.extension().is_some_and(|ending| ending == "csv"));
            tables.map(|(path, bytes)| (path.file_name().map(std::ffi::OsStr::to_owned), bytes)).collect::<Vec<_>>()
        });
        assert!(one.len() >= 2 && one == other, "{method}");
        let [one, other] = [&whole, &parts].map(|bench| bench.results().summary());
        assert_eq!((&one["events"], &one["landing"]), (&other["events"], &other["landing"]));
    }
}

/// `check` lists what a run waits for, and warns of what holds at the start.
#[test]
fn check_lists_events() {
    let bench = Bench::new();
    write(&bench, &case("newmark"));
    let ended = bench.run(&["check", "case.json"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    for line in ["event           main (release): a height below 60 m", "0.3 s after main", "ground (landing)"] {
        assert!(ended.stdout.contains(line), "no \"{line}\" in {}", ended.stdout);
    }
    let high = "system.network.supports.0.when.height_below=90";
    let ended = bench.run(&["check", "case.json", "--set", high]);
    assert!(ended.stdout.contains("[event-at-start]") || ended.stderr.contains("[event-at-start]"), "{}", ended.stdout);
}

/// Cloth that falls with slack lines until an event opens it is warned of, where Newton's iteration is to solve it.
#[test]
fn an_opening_of_slack_cloth_is_warned_of() {
    let bench = Bench::new();
    let case = format!("{}/docs/guide/cases/uav.json", env!("CARGO_MANIFEST_DIR"));
    let check = |sets: &[&str]| {
        let sets = sets.iter().flat_map(|set| ["--set", set]);
        let ended = bench.run(&[&["check", &case][..], &sets.collect::<Vec<_>>()].concat());
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        format!("{}{}", ended.stdout, ended.stderr)
    };
    let net = ["system.network.model=null", "time.tolerance=null", "time.step=0.002", "time.end=4"];
    let warned = check(&[&net[..], &["time.method=\"newmark\""]].concat());
    let words = "no pressure before the event \"shot\" opens it";
    assert!(warned.contains("[slack-opening]") && warned.contains(words), "{warned}");
    let held = r#"system.network.supports=[{"on":{"group":"canopy"},"fix":"xyz","when":{"after":"shot"}}]"#;
    for other in [
        check(&[&net[..], &["time.method=\"velocity-verlet\"", "time.step=1e-5"]].concat()),
        check(&[&net[..], &["time.method=\"newmark\"", held]].concat()),
        check(&["time.method=\"newmark\""]),
    ] {
        assert!(!other.contains("[slack-opening]"), "{other}");
    }
}

/// What contradicts itself is refused, with its place.
#[test]
fn what_cannot_be_meant_is_refused() {
    let bench = Bench::new();
    for (place, when, words) in [
        ("/system/network/supports/0", json!({}), "exactly one of"),
        ("/system/network/supports/0", json!({"height_below": 1.0, "descending": true}), "exactly one of"),
        ("/system/network/supports/0", json!({"height_below": 1.0, "delay": 1.0}), "only beside after"),
        ("/system/network/supports/0", json!({"dynamic_pressure_above": 1.0}), "aero with a canopy or drag"),
        ("/system/network/supports/0", json!({"tension_above": 1.0}), "a selection of edges with springs"),
        ("/system/network/supports/1", json!({"after": "mian"}), "main"),
        ("/system/network/supports/1", json!({"after": "supports[1]"}), "happens by itself"),
    ] {
        let mut bad = case("rk4");
        let one = bad.pointer_mut(place).expect("a support");
        one["when"] = when.clone();
        let ended = solve(&bench, &bad, &[]);
        assert!(ended.code == Some(2) && ended.stderr.contains(words), "{when}: {}{}", ended.stdout, ended.stderr);
    }
    let mut both = case("rk4");
    both["system"]["network"]["supports"][0]["until"] = json!(1.0);
    let ended = solve(&bench, &both, &[]);
    assert!(ended.code == Some(2) && ended.stderr.contains("not together with until"), "{}", ended.stderr);
    let mut twice = case("rk4");
    let more = json!({"on": {"ids": [1]}, "fix": "x", "until": 1.0});
    twice["system"]["network"]["supports"].as_array_mut().expect("a list").push(more);
    let ended = solve(&bench, &twice, &[]);
    assert!(ended.code == Some(2) && ended.stderr.contains("that an event releases"), "{}", ended.stderr);
    let mut rest = case("rk4");
    rest["time"]["until_rest"] = json!({"speed": 1e-3});
    let ended = solve(&bench, &rest, &[]);
    assert!(ended.code == Some(2) && ended.stderr.contains("events by state"), "{}", ended.stderr);
}

/// A run that ends on the ground before its time is judged there: its speed is steady, in the report and the stages.
#[test]
fn the_end_on_the_ground_is_steady() {
    let bench = Bench::new();
    let case = format!("{}/docs/guide/cases/uav.json", env!("CARGO_MANIFEST_DIR"));
    let ended = bench.run(&["solve", &case, "--out", "landed"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(ended.stdout.contains("  landing ") && ended.stdout.contains(" m/s steady (canopy"), "{}", ended.stdout);
    let summary = Results(bench.path("landed")).summary();
    let last = summary["stages"].as_array().and_then(|stages| stages.last()).expect("stages");
    let (from, to) = (last["from"].as_f64().expect("a time"), last["to"].as_f64().expect("a time"));
    assert!(last["name"] == "steady" && (from - 0.9 * to).abs() < 1e-9 * to, "{last}");
    assert_eq!(last["to"], summary["t_end"]);
}

/// A weight of 5 kg on three lines below a triangle of cloth that is held. Each line bears less than the weight.
fn torn(last_breaks: bool) -> Value {
    let line = |id: u32, strength: f64, breaks: bool| json!({"on": {"ids": [id]}, "stiffness": 2000.0, "strength": strength, "breaks": breaks});
    json!({
        "name": "torn",
        "system": {"network": {
            "mesh": {"explicit": {
                "nodes": [[1, 0, 1], [-0.5, 0.9, 1], [-0.5, -0.9, 1], [0, 0, 0]],
                "springs": [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]],
                "triangles": [[0, 1, 2]],
                "groups": {"payload": {"nodes": [3]}}
            }},
            "mass": {"nodal": [0.1, 0.1, 0.1, 5.0]},
            "springs": [
                {"on": {"ids": [0, 1, 2]}, "stiffness": 2000.0},
                line(3, 12.0, true), line(4, 15.0, true), line(5, 18.0, last_breaks)
            ],
            "supports": [{"on": {"ids": [0, 1, 2]}, "fix": "xyz"}],
            "gravity": [0, 0, -G]
        }},
        "time": {"end": 1.0, "method": "velocity-verlet", "step": 0.001}
    })
}

/// Where the last line breaks the payload is lost, and report and summary say when; one line that holds is enough.
#[test]
fn a_payload_whose_lines_all_break_is_lost() {
    let bench = Bench::new();
    let ended = solve(&bench, &torn(true), &[]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let summary = bench.results().summary();
    let events = summary["events"].as_array().expect("events");
    assert_eq!(events.len(), 3, "{events:?}");
    let (lost, last) = (&summary["payload_lost"], &events[2]);
    assert_eq!((&lost["time"], &lost["last"]), (&last["time"], &last["name"]));
    assert!(ended.stdout.contains("payload         lost at t = ") && ended.stdout.contains("edge 5 has broken"));
    let ended = solve(&bench, &torn(false), &["--force"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let summary = bench.results().summary();
    assert_eq!(summary["events"].as_array().map(Vec::len), Some(2));
    assert!(summary["payload_lost"].is_null() && !ended.stdout.contains("lost at"), "{}", ended.stdout);
}
