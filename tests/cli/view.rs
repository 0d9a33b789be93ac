//! The page of a run: what it holds against the frames and gauges of the run, how large it is, what is refused, and
//! what a browser shows of it.

mod browser;
mod data;
mod live;

use std::fs;

use crate::bench::Bench;

/// A sail with groups and gauges, whose frames hold what colours show.
fn bench() -> Bench {
    let bench = Bench::new();
    let case = fs::read_to_string(bench.path("sail.json")).expect("a case");
    let case = case.replace(
        r#""triangles": [[0,1,4]"#,
        r#""groups": {"sheet": {"triangles": [0, 1]}, "hem <&>": {"edges": [0, 1]},
        "clew": {"nodes": [5]}}, "triangles": [[0,1,4]"#,
    );
    let case = case.replace(
        r#""history": {"every": 1}"#,
        r#""history": {"every": 1}, "gauges": [{"name": "luff", "on": {"group": "hem <&>"}, "of": "tension"}]"#,
    );
    fs::write(bench.path("sail.json"), case).expect("written");
    bench
}

fn page(bench: &Bench, arguments: &[&str]) -> String {
    let ended = bench.run(&[&["view"], arguments].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    fs::read_to_string(bench.path(ended.stdout.trim())).expect("the page that is named")
}

/// One file that asks for nothing: no addresses but the name spaces of XML, no code from elsewhere.
#[test]
fn a_page_needs_nothing_else() {
    let bench = bench();
    assert_eq!(bench.solve(&[]).code, Some(0));
    let page = page(&bench, &["out"]);
    let addresses: Vec<&str> =
        page.split("http").skip(1).filter(|rest| rest.starts_with("://") || rest.starts_with("s://")).collect();
    assert!(addresses.iter().all(|rest| rest.starts_with("://www.w3.org/2000/svg")), "{addresses:?}");
    assert!(!page.contains(" src=") && !page.contains("@import") && !page.contains("<link"));
    assert!(page.contains("const live = false;"));
    // A name of a group cannot end the script that holds it.
    assert!(page.contains("hem \\u003c&>") && !page.contains("hem <"));
}

/// `solve --view` writes the same page; two runs share one in the folder that is asked for.
#[test]
fn pages_of_solve_and_of_two_runs() {
    let bench = bench();
    let ended = bench.solve(&["--view"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(ended.stdout.ends_with("  view            out/view.html\n"), "{}", ended.stdout);
    let by_solve = fs::read_to_string(bench.path("out/view.html")).expect("a page");
    assert_eq!(page(&bench, &["out"]), by_solve);
    assert_eq!(page(&bench, &["out/sail.pvd"]), by_solve);
    let ended = bench.run(&["solve", "sail.json", "--out", "other", "--set", "name=calm", "--end", "0.4", "--quiet"]);
    assert_eq!((ended.code, ended.stdout.as_str()), (Some(0), ""), "{}", ended.stderr);
    let both = data::runs(&page(&bench, &["out", "other", "--out", "both"]));
    assert!(bench.path("both/view.html").is_file());
    let names: Vec<&str> = both.iter().filter_map(|run| run["name"].as_str()).collect();
    assert_eq!(names, ["sail", "calm"]);
    assert_eq!(both.iter().map(data::frame_count).collect::<Vec<_>>(), [11, 5]);
    // Runs of one case have the names of their folders, and few frames are told.
    let ended = bench.run(&["solve", "sail.json", "--out", "short", "--end", "0.1", "--quiet"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let ended = bench.run(&["view", "out", "short", "--out", "both"]);
    assert!(ended.stderr.contains("The run wrote 2 frames; \"output.frames\""), "{}", ended.stderr);
    let both = data::runs(&fs::read_to_string(bench.path("both/view.html")).expect("a page"));
    let names: Vec<&str> = both.iter().filter_map(|run| run["name"].as_str()).collect();
    assert_eq!(names, ["sail, out", "sail, short"]);
}

/// A run that was killed has no summary: it is shown as far as it went, and the page says so.
#[test]
fn runs_that_were_killed_and_frames_that_are_not_finite() {
    let bench = bench();
    assert_eq!(bench.solve(&[]).code, Some(0));
    fs::remove_file(bench.path("out/summary.json")).expect("there");
    let gauges = fs::read_to_string(bench.path("out/gauges.csv")).expect("there");
    fs::write(bench.path("out/gauges.csv"), &gauges[..gauges.len() - 9]).expect("written");
    let ended = bench.run(&["view", "out"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(ended.stderr.contains("has no summary: it goes on, or was killed"), "{}", ended.stderr);
    let runs = data::runs(&fs::read_to_string(bench.path("out/view.html")).expect("a page"));
    assert_eq!(data::frame_count(&runs[0]), 11);
    // The unit of a gauge is known without a summary.
    assert_eq!(runs[0]["part"]["curves"]["heads"][0]["unit"], "N");
    data::spoil_point(&bench.path("out/frames/sail_000004.vtu"), f64::NAN);
    let ended = bench.run(&["view", "out"]);
    assert!(ended.stderr.contains("1 frame is left out: it has positions that are not finite"), "{}", ended.stderr);
    let runs = data::runs(&fs::read_to_string(bench.path("out/view.html")).expect("a page"));
    assert_eq!(data::frame_count(&runs[0]), 10);
    // A scene that has blown up would leave the others a dot.
    data::spoil_point(&bench.path("out/frames/sail_000007.vtu"), 1e7);
    let ended = bench.run(&["view", "out"]);
    assert!(
        ended.stderr.contains("1 frame is left out, in which the scene is 1000 times as large"),
        "{}",
        ended.stderr
    );
    let runs = data::runs(&fs::read_to_string(bench.path("out/view.html")).expect("a page"));
    assert_eq!(data::frame_count(&runs[0]), 9);
}

/// What cannot be shown is refused with a word on what was looked for.
#[test]
fn what_is_refused() {
    let bench = bench();
    assert_eq!(bench.solve(&[]).code, Some(0));
    let refused = |arguments: &[&str], words: &[&str]| {
        let ended = bench.run(&[&["view"], arguments].concat());
        assert_eq!((ended.code, ended.stdout.as_str()), (Some(2), ""), "{}", ended.stderr);
        for word in words {
            assert!(ended.stderr.contains(word), "\"{word}\" is not in: {}", ended.stderr);
        }
    };
    refused(&["nowhere"], &["nowhere is no folder", "canopy-fem solve"]);
    refused(&["out/frames"], &["without their list", "give the folder above it: out"]);
    refused(&["."], &["holds no frames", "no .pvd or .vtkhdf file"]);
    refused(&["out", "out", "out"], &["Usage"]);
    refused(&["out", "out", "--live"], &["--live shows one run"]);
    refused(&["nowhere", "--live"], &["nowhere is no folder"]);
    refused(&["out", "--port", "8000"], &["--live"]);
    fs::copy(bench.path("out/sail.pvd"), bench.path("out/other.pvd")).expect("copied");
    fs::rename(bench.path("out/summary.json"), bench.path("kept.json")).expect("moved");
    refused(&["out"], &["frames of several runs", "name the file of one"]);
    fs::rename(bench.path("kept.json"), bench.path("out/summary.json")).expect("moved");
    fs::write(bench.path("out/frames/sail_000002.vtu"), "torn").expect("written");
    refused(&["out"], &["sail_000002.vtu: is not a VTK file"]);
    fs::remove_file(bench.path("out/frames/sail_000002.vtu")).expect("there");
    refused(&["out"], &["sail_000002.vtu is not there", "moved or removed"]);
    fs::write(bench.path("out/sail.pvd"), "<VTKFile></VTKFile>").expect("written");
    refused(&["out"], &["lists no frames yet"]);
}
