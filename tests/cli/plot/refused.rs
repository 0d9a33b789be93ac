//! What cannot be plotted is refused with a word on what was looked for, before any file is written.

use super::Desk;

/// A run of the oscillator, changed by hand, and what plotting it then says.
fn refusal(change: impl FnOnce(&Desk), arguments: &[&str], words: &[&str]) {
    let desk = Desk::new();
    assert_eq!(desk.solve("oscillator", "out", &["--end", "1"]), Some(0));
    change(&desk);
    let ended = desk.run(&[&["plot"], arguments].concat());
    assert_eq!((ended.code, ended.stdout.as_str()), (Some(2), ""), "{}", ended.stderr);
    for word in words {
        assert!(ended.stderr.contains(word), "\"{word}\" is not in: {}", ended.stderr);
    }
    assert!(!desk.path("out/energy.svg").exists() && !desk.path("energy.svg").exists(), "{words:?}");
}

fn edit(desk: &Desk, file: &str, change: impl FnOnce(String) -> String) {
    let path = desk.path(file);
    let text = std::fs::read_to_string(&path).expect("written");
    std::fs::write(&path, change(text)).expect("written");
}

#[test]
fn folders_without_results() {
    refusal(|_| {}, &["nowhere"], &["nowhere is no folder", "canopy-fem solve"]);
    refusal(|_| {}, &["out/summary.json"], &["out/summary.json is no folder"]);
    refusal(|_| {}, &["out/frames"], &["out/frames holds no results", "summary.json is not there"]);
    let gone = |file: &'static str| move |desk: &Desk| std::fs::remove_file(desk.path(file)).expect("there");
    refusal(gone("out/history.csv"), &["out"], &["history.csv is not there"]);
    let frame = "frames/oscillator_000000.vtu";
    refusal(gone("out/frames/oscillator_000000.vtu"), &["out"], &[frame, "is not there", "displacements"]);
    refusal(|_| {}, &[], &["Usage"]);
}

#[test]
fn damaged_results_are_named_with_their_line() {
    let row = |n: usize, new: &'static str| {
        move |text: String| {
            let lines: Vec<&str> = text.lines().enumerate().map(|(i, l)| if i + 1 == n { new } else { l }).collect();
            lines.join("\n") + "\n"
        }
    };
    let word = row(4, "0.02,2,a,0,0,0,0,0,0,0,0,0");
    refusal(|d| edit(d, "out/history.csv", word), &["out"], &["out/history.csv, line 4", "\"a\"", "value 3"]);
    let short = row(3, "0.1,mass,1,0,0");
    refusal(|d| edit(d, "out/probes.csv", short), &["out"], &["out/probes.csv, line 3", "5 values where 9"]);
    let other = row(1, "time,name");
    refusal(|d| edit(d, "out/probes.csv", other), &["out"], &["out/probes.csv, line 1", "expected the header"]);
    let torn = |text: String| text[..text.len() - 3].to_owned();
    refusal(|d| edit(d, "out/probes.csv", torn), &["out"], &["out/probes.csv, line 12", "cut off"]);
    refusal(|d| edit(d, "out/summary.json", torn), &["out"], &["out/summary.json, line "]);
    let odd = |text: String| text.replace("\"completed\"", "\"finished\"");
    refusal(|d| edit(d, "out/summary.json", odd), &["out"], &["out/summary.json", "status"]);
    let empty = |d: &Desk| std::fs::write(d.path("out/frames/oscillator_000000.vtu"), "").expect("written");
    refusal(empty, &["out"], &["oscillator_000000.vtu: is not a VTK file"]);
}

#[test]
fn what_is_not_in_the_results() {
    refusal(|_| {}, &["out", "--probe", "mast"], &["no probe is called \"mast\"", "there are: mass"]);
    refusal(|_| {}, &["out", "--nodes", "1,7"], &["node 7 was not probed"]);
    refusal(|_| {}, &["out", "--from", "3"], &["--from and --to"]);
    refusal(|_| {}, &["out", "--from", "1", "--to", "0.5"], &["--from 1 is not before --to 0.5"]);
    refusal(|_| {}, &["out", "--nodes", "3..1"], &["650..702"]);
    refusal(|_| {}, &["out", "--kind", "speed"], &["displacement", "phase", "energy"]);
    let bare = |d: &Desk| std::fs::remove_file(d.path("out/probes.csv")).expect("there");
    refusal(bare, &["out", "--kind", "phase"], &["no node was probed", "add probes"]);
}

/// Nothing above 0 on a logarithmic axis is a fault with the largest number, for what was named; by default the others
/// are drawn.
#[test]
fn logarithmic_axes_with_nothing_to_show() {
    let fallen = |d: &Desk| {
        assert_eq!(d.solve("oscillator", "out", &["--end", "0.5", "--force"]), Some(0));
        // The mass swings towards its rest position: its velocities are below 0.
    };
    let words = ["none of the", "above 0", "velocity in x [m/s]", "the largest is 0e0", "--log"];
    refusal(fallen, &["out", "--kind", "phase", "--log", "y"], &words);
    refusal(|_| {}, &["out", "--log", "z"], &["x", "y", "xy"]);
    let desk = Desk::new();
    assert_eq!(desk.solve("oscillator", "out", &["--end", "0.5"]), Some(0));
    let ended = desk.run(&["plot", "out", "--log", "y"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(ended.stderr.contains("warning: no phase: "), "{}", ended.stderr);
    assert!(ended.stdout.contains("out/displacement.svg") && !ended.stdout.contains("phase"), "{}", ended.stdout);
}

/// A difference needs the same nodes and gauges in both runs; the fault names what is missing, and what there is.
#[test]
fn differences_of_other_scenes() {
    let other = |changes: &'static [&'static str]| {
        move |d: &Desk| assert_eq!(d.solve("oscillator", "other", &[&["--end", "1"], changes].concat()), Some(0))
    };
    let node_0 = other(&["--set", r#"output.probes=[{"name": "anchor", "on": {"ids": [0]}}]"#]);
    let words = ["other has no probed node 1 to subtract", "it has: 0", "--nodes"];
    refusal(node_0, &["out", "--minus", "other"], &words);
    let gauges = |d: &Desk| {
        let gauge = |name: &str| format!(r#"output.gauges=[{{"name": "{name}", "on": "all", "of": "speed"}}]"#);
        let run = |out, name| d.solve("oscillator", out, &["--end", "1", "--force", "--set", &gauge(name)]);
        assert_eq!((run("out", "a"), run("other", "b")), (Some(0), Some(0)));
    };
    let words = ["other has no \"a, speed_mean\" to subtract", "it has: b, speed_mean, b, speed_max", "--gauge"];
    refusal(gauges, &["out", "--minus", "other"], &words);
    refusal(gauges, &["out", "--gauge", "c"], &["no gauge is called \"c\"", "there are: a"]);
    refusal(|_| {}, &["out", "--kind", "gauges"], &["nothing was measured", "add gauges"]);
    refusal(|_| {}, &["out", "--minus", "nowhere"], &["nowhere is no folder"]);
}

/// A program without other formats says how to get them, before it reads or writes anything.
#[cfg(not(feature = "pictures"))]
#[test]
fn formats_that_were_not_built() {
    let words = ["without --format png", "cargo install --path . --features pictures", "--format svg"];
    refusal(|_| {}, &["out", "--format", "svg,png"], &words);
}

/// What the system refuses is no fault of usage.
#[test]
fn pictures_that_cannot_be_written() {
    let desk = Desk::new();
    assert_eq!(desk.solve("oscillator", "out", &["--end", "1"]), Some(0));
    let ended = desk.run(&["plot", "out", "--out", "out/history.csv"]);
    assert_eq!(ended.code, Some(1), "{}", ended.stderr);
    assert!(ended.stderr.contains("out/history.csv"), "{}", ended.stderr);
}
