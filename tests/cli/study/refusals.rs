//! What a study cannot do: status 2, and what to do instead.

use crate::bench::Bench;
use crate::common::write_net;

#[test]
fn bad_options_are_refused_before_anything_is_made() {
    let bench = Bench::new();
    let cases: [(&[&str], &str); 14] = [
        (&["--methods", "rk5"], "there is no method"),
        (&["--methods", r#"{"hht": {"alpha": 1}}"#], "outside"),
        (&["--steps", "0"], "above 0"),
        (&["--steps", "1e-3..x"], "no number"),
        (&["--tolerances", "2"], "below 1"),
        (&["--repeat", "0"], "1..=1000"),
        (&["--budget", "soon"], "60s, 5min or 2h"),
        (&["--shard", "0/3"], "I from 1 to N"),
        (&["--shard", "1/3"], "holds no plan"),
        (&["--merge"], "holds no plan"),
        (&["--shard", "1/3", "--methods", "rk4"], "cannot be used with"),
        (&["--merge", "--steps", "1e-3"], "cannot be used with"),
        (&["--steps", "none", "--tolerances", "none"], "nothing to run"),
        (&["--set", "time.end=-1"], "time"),
    ];
    for (flags, why) in cases {
        let ended = bench.run(&[&["tradeoff", "sail.json", "--out", "out"], flags].concat());
        assert_eq!(ended.code, Some(2), "{flags:?}: {}", ended.stderr);
        assert!(ended.stderr.contains(why), "{flags:?}: {}", ended.stderr);
        assert!(!bench.path("out").exists(), "{flags:?} left something");
    }
    let ended = bench.run(&["tradeoff", "--merge"]);
    assert_eq!(ended.code, Some(2), "{}", ended.stderr);
}

/// A table whose study is gone is not written over unasked, and a quiet plan says nothing.
#[test]
fn nothing_is_lost_and_quiet_is_quiet() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("out")).expect("a folder");
    std::fs::write(bench.path("out/tradeoff.html"), "a page").expect("written");
    let flags = ["tradeoff", "sail.json", "--methods", "rk4", "--steps", "1e-2", "--out", "out", "--plan", "-q"];
    let ended = bench.run(&flags);
    assert!(ended.code == Some(2) && ended.stderr.contains("tradeoff.html exists"), "{}", ended.stderr);
    let ended = bench.run(&[&flags[..], &["--force"]].concat());
    assert_eq!((ended.code, ended.stdout.as_str(), ended.stderr.as_str()), (Some(0), "", ""));
}

/// Another case or other options in the same folder are refused until --force.
#[test]
fn another_study_is_not_mixed_in() {
    let bench = Bench::new();
    let flags = ["--methods", "rk4", "--steps", "1e-2", "--repeat", "1", "--out", "out"];
    let go = |more: &[&str]| bench.run(&[&["tradeoff", "sail.json"], &flags[..], more].concat());
    assert_eq!(go(&[]).code, Some(0));
    for (more, why) in [
        (&["--set", "time.end=0.5"][..], "time.end was 1.0 and is 0.5 now"),
        (&["--tolerances", "1e-2"], "were asked for"),
    ] {
        let ended = go(more);
        assert_eq!(ended.code, Some(2), "{}", ended.stderr);
        assert!(ended.stderr.contains(why) && ended.stderr.contains("--force"), "{}", ended.stderr);
        assert_eq!(go(&[more, &["--force"]].concat()).code, Some(0));
        assert_eq!(go(&["--force"]).code, Some(0));
    }
    std::fs::write(bench.path("out/tradeoff/plan.json"), "{}").expect("written");
    let ended = go(&[]);
    assert!(ended.code == Some(2) && ended.stderr.contains("no plan"), "{}", ended.stderr);
}

/// Nothing moves: there is nothing to be accurate about.
#[test]
fn a_scene_at_rest_has_no_error() {
    let bench = Bench::new();
    let text = std::fs::read_to_string(bench.path("sail.json")).expect("there");
    let mut case: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let network = case.pointer_mut("/system/network").and_then(|n| n.as_object_mut()).expect("there");
    for key in ["gravity", "aero", "loads"] {
        network.remove(key);
    }
    case["system"]["network"]["springs"][0]["rest_scale"] = 1.0.into();
    std::fs::write(bench.path("rest.json"), case.to_string()).expect("written");
    let ended = bench.run(&["tradeoff", "rest.json", "--out", "out"]);
    assert_eq!(ended.code, Some(2), "{}", ended.stderr);
    assert!(ended.stderr.contains("nothing moves"), "{}", ended.stderr);
}

/// A study whose mesh file holds another mesh now is not told as that of the case, though all its runs are there.
#[test]
fn another_mesh_in_the_same_file() {
    let bench = Bench::new();
    let flags =
        ["--set", r#"system.network.mesh={"file":"net.obj"}"#, "--set", "system.network.supports.0.on={\"ids\":[0]}"];
    let more = ["--methods", "rk4", "--steps", "1e-2", "--tolerances", "none", "--repeat", "1", "--out", "out"];
    let study = || bench.run(&[&["tradeoff", "sail.json"][..], &flags, &more].concat());
    write_net(&bench.path("net.obj"), 0.0);
    for _ in 0..2 {
        let ended = study();
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    }
    write_net(&bench.path("net.obj"), 0.25);
    let ended = study();
    assert_eq!(ended.code, Some(2), "{}", ended.stdout);
    assert!(ended.stderr.contains("system.network.mesh is not what it was"), "{}", ended.stderr);
}
