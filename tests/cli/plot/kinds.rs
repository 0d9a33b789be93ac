//! What a picture shows of gauges, steps and differences, on linear and on logarithmic axes.

use super::svg::Picture;
use super::{BLUE, Desk, GREEN, ORANGE, VERMILLION, largest};

/// Rate of the oscillator [1/s].
fn w0() -> f64 {
    1.5_f64.sqrt()
}

/// Frames half a second apart, and cubics between them: they leave (w0 h)^4 x0/384 = 0.0004 m of the closed form, where
/// straight lines leave (w0 h)^2 x0/8 = 0.09 m. Half a unit of the drawing is 0.0005 m and 0.0015 s, 0.004 m at the
/// largest speed. In the phase diagram the speed is off by h^3 w0^4 x0/125 = 0.005 m/s.
#[test]
fn curves_are_cubics_between_frames() {
    let desk = Desk::new();
    assert_eq!(desk.solve("oscillator", "out", &["--set", "output.frames.every=0.5"]), Some(0));
    desk.plot(&["out", "--kind", "displacement,phase"], &["out/displacement.svg", "out/phase.svg"]);
    let between = desk.picture("out/displacement.svg").between(BLUE);
    assert_eq!(between.len(), 40, "as many cubics as there are pieces of time");
    let error = largest(between.iter().map(|(t, x)| x - 2.0 * (w0() * t).cos()));
    assert!(error < 0.006, "{error} m from the closed form");
    let between = desk.picture("out/phase.svg").between(BLUE);
    let error = largest(between.iter().map(|(x, v)| x.hypot(v / w0()) - 2.0));
    assert!(between.len() == 40 && error < 0.01, "{error} m from the circle");
}

/// At most four charts by default, those of loads before others; noise and constants have none, peaks are told with
/// their times, and titles have words for people.
#[test]
fn four_charts_at_first() {
    let desk = Desk::new();
    let gauges = r#"output.gauges=[{"name": "anchor", "on": {"ids": [0]}, "of": "reaction"},
                                   {"name": "mass", "on": {"ids": [1]}, "of": "position"},
                                   {"name": "mass again", "on": {"ids": [1]}, "of": "acceleration"},
                                   {"name": "still", "on": {"ids": [0]}, "of": "position"}]"#;
    assert_eq!(desk.solve("oscillator", "out", &["--set", gauges, "--end", "6"]), Some(0));
    let ended = desk.run(&["plot", "out"]);
    let files: Vec<&str> = ended.stdout.lines().collect();
    assert_eq!(files, ["out/displacement.svg", "out/energy.svg", "out/gauges.svg"]);
    assert!(ended.stderr.starts_with("note: ") && ended.stderr.contains("--all"), "{}", ended.stderr);
    let charts: usize = files.iter().map(|file| Picture::panels(&desk.text(file)).len()).sum();
    assert_eq!(charts, 4);
    let gauges = desk.picture("out/gauges.svg");
    // k x0 = 6 N at the start, and 6/2 m/s^2.
    for words in
        ["oscillator: reaction (anchor)", "reaction [N]", "6 N at 0 s", "oscillator: largest acceleration (mass again)"]
    {
        assert!(gauges.says(words), "no {words} in {:?}", gauges.words());
    }
    assert_eq!(desk.run(&["plot", "out", "--quiet"]).stderr, "");
    // All of them: the position of what is held, and reactions across the motion, are not there.
    desk.plot(&["out", "--kind", "gauges"], &["out/gauges.svg"]);
    let all = desk.picture("out/gauges.svg");
    assert!(all.says("oscillator: position along x (mass)"), "{:?}", all.words());
    for words in ["along y", "along z", "still"] {
        assert!(!all.words().iter().any(|of| of.contains(words)), "{words} in {:?}", all.words());
    }
    desk.plot(&["out", "--kind", "gauges", "--gauge", "still"], &["out/gauges.svg"]);
    assert!(desk.picture("out/gauges.svg").says("oscillator: position along x (still)"), "it is asked for");
    // Nothing is asked for twice.
    let both = desk.run(&["plot", "out", "--all", "--kind", "energy"]);
    assert!(both.code == Some(2) && both.stderr.contains("--all"), "{}", both.stderr);
}

/// A method has its colour and its mark, whatever it is beside.
#[test]
fn methods_have_their_own_looks() {
    let desk = Desk::new();
    for method in ["newmark", "rk4", "kang"] {
        assert_eq!(desk.solve("oscillator", method, &["--method", method, "--step", "0.02", "--end", "4"]), Some(0));
    }
    let looks = |runs: &[&str]| {
        desk.plot(&[runs, &["--kind", "displacement"]].concat(), &["displacement.svg"]);
        let picture = desk.picture("displacement.svg");
        let svg = desk.text("displacement.svg");
        assert_eq!(picture.words().iter().filter(|words| words.ends_with(" m at 0 s")).count(), 1, "one text for both");
        let marks = |ink: &str| svg.matches(&format!("<polygon fill=\"{ink}\"")).count();
        [GREEN, ORANGE].map(|ink| (picture.curves(ink).len(), marks(ink)))
    };
    // Marks along the curve, and one in the legend.
    let one = looks(&["newmark", "kang"])[0];
    assert!(one.0 == 1 && (5..=9).contains(&one.1), "{one:?}");
    assert_eq!(looks(&["rk4", "newmark"]), [one, one], "whatever the order");
}

/// Two gauges of the oscillator: the rows of the table are the points of the curves, and both are the closed form of
/// the spring's force, k x0 = 6 N, and of the speed, x0 w0. A quantity is a chart, with its unit; a gauge has its
/// colour in all of them; one can be chosen.
#[test]
fn gauges_are_drawn() {
    let desk = Desk::new();
    let gauges = r#"output.gauges=[{"name": "anchor", "on": {"ids": [0]}, "of": "reaction"},
                                   {"name": "mass & co", "on": {"ids": [1]}, "of": "speed"},
                                   {"name": "both", "on": "all", "of": "speed"}]"#;
    assert_eq!(desk.solve("oscillator", "out", &["--set", gauges, "--set", "output.fields=[]"]), Some(0));
    desk.plot(&["out", "--kind", "gauges"], &["out/gauges.svg"]);
    let panels = Picture::panels(&desk.text("out/gauges.svg"));
    assert_eq!(panels.len(), 5, "three of reactions, two of speed: nothing acts along y and z");
    let all = desk.picture("out/gauges.svg");
    for word in [
        "oscillator: reaction along x (anchor)",
        "oscillator: largest speed",
        "largest speed [m/s]",
        "reaction along x [N]",
    ] {
        assert!(all.says(word), "{word}: {:?}", all.words());
    }
    assert!(["anchor", "mass &amp; co", "both"].iter().all(|name| all.says(name)), "{:?}", all.words());
    let (table, speeds) = (desk.text("out/gauges.csv"), &panels[4].curves(VERMILLION)[0]);
    let rows = || table.lines().filter(|row| row.contains(",mass & co,speed_max,")).map(|row| row.split(','));
    let read: Vec<Vec<f64>> = rows().map(|row| row.filter_map(|cell| cell.parse().ok()).collect()).collect();
    // Decimation leaves extremes of the 2001 rows; half a unit is 0.0005 m/s, and 0.002 s, of up to x0 w0^2 = 3 m/s^2.
    assert!(read.len() > 1000 && speeds.len() > 500, "{} rows, {} points", read.len(), speeds.len());
    for (t, speed) in speeds {
        let near = read.iter().map(|row| (row[0] - t).abs().max((row[1] - speed).abs() / 3.0));
        let exact = 2.0 * w0() * (w0() * t).sin().abs();
        assert!(near.fold(f64::MAX, f64::min) < 0.01 && (speed - exact).abs() < 0.02, "{speed} m/s at {t} s");
    }
    let force = largest(panels[0].curves(BLUE)[0].iter().map(|p| p.1));
    assert!((force - 6.0).abs() < 0.02, "{force} N");
    desk.plot(&["out", "--kind", "gauges", "--gauge", "anchor"], &["out/gauges.svg"]);
    let one = desk.picture("out/gauges.svg");
    assert!(one.says("oscillator: reaction (anchor)") && !one.says("both"), "{:?}", one.words());
    // Without gauges of tension, only frames have it; here they have none either.
    let ended = desk.run(&["plot", "out", "--kind", "tension"]);
    assert_eq!(ended.code, Some(2));
    assert!(ended.stderr.contains("no gauge and no frame has tensions"), "{}", ended.stderr);
}

/// Frames with tensions and reactions show their largest; the spring's force is k x0 = 6 N, and so is its support's.
#[test]
fn forces_in_frames_are_drawn() {
    let desk = Desk::new();
    let fields = r#"output.fields=["tension", "reaction"]"#;
    assert_eq!(desk.solve("oscillator", "out", &["--set", fields, "--end", "6"]), Some(0));
    let kinds = ["displacement", "phase", "energy", "ledger", "steps", "tension", "reaction"];
    desk.plot(&["out", "--all"], &kinds.map(|kind| format!("out/{kind}.svg")));
    let tension = desk.picture("out/tension.svg");
    let curve = &tension.curves(BLUE)[0];
    let error = largest(curve.iter().map(|(t, n)| n - 6.0 * (w0() * t).cos()));
    assert!(curve.len() > 50 && error < 0.05, "{error} N from the closed form");
    let total = &Picture::panels(&desk.text("out/reaction.svg"))[0].curves(BLUE)[0];
    let error = largest(total.iter().map(|(t, n)| n - 6.0 * (w0() * t).cos().abs()));
    assert!(error < 0.05, "{error} N from the closed form");
}

/// Steps of a run that makes them of different sizes: their sum is the time, and an implicit method has iterations.
#[test]
fn steps_are_drawn() {
    let desk = Desk::new();
    let adaptive = ["--method", "newmark", "--tolerance", "1e-3", "--end", "5"];
    assert_eq!(desk.solve("pendulum", "out", &adaptive), Some(0));
    desk.plot(&["out", "--kind", "steps"], &["out/steps.svg"]);
    let panels = Picture::panels(&desk.text("out/steps.svg"));
    let size = &panels[0].curves(BLUE)[0];
    assert!(
        panels[0].says("step size [s]") && panels[1].says("Newton iterations of a step [-]"),
        "{:?}",
        panels[1].words()
    );
    let sum: f64 = size.iter().map(|p| p.1).sum();
    assert_eq!(size.len(), desk.column("out/history.csv", "t").len() - 1);
    assert!((sum - 5.0).abs() < 0.02, "the steps are {sum} s together");
}

/// On a logarithmic axis, powers of ten are equally far apart, and the energy of a damped oscillator falls along a
/// straight line: what is drawn is the table's number. What is not above 0 is left out, and said.
#[test]
fn logarithmic_axes() {
    let desk = Desk::new();
    assert_eq!(desk.solve("oscillator-damped", "out", &[]), Some(0));
    let ended = desk.run(&["plot", "out", "--kind", "ledger", "--log", "y"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let left_out = "points are not above 0 and not on the logarithmic axis";
    assert!(ended.stderr.contains("warning: ledger: ") && ended.stderr.contains(left_out), "{}", ended.stderr);
    let panels = Picture::panels(&desk.text("out/ledger.svg"));
    let sum = &panels[0];
    let ticks = sum.log_ticks();
    let (first, last) = (ticks[0], ticks[ticks.len() - 1]);
    let unit = (last.0 / first.0).log10() / (last.1 - first.1);
    assert!(ticks.len() > 2, "{ticks:?}");
    for (number, place) in &ticks {
        let off = (number / first.0).log10() - unit * (place - first.1);
        assert!(off.abs() < 1.5 * unit.abs(), "{number} is {off} decades from its place");
    }
    let [t, kinetic, elastic] = ["t", "kinetic", "elastic"].map(|name| desk.column("out/history.csv", name));
    let (_, places) = sum.lines.iter().find(|(color, points)| color == BLUE && points.len() > 2).expect("a curve");
    let drawn: Vec<f64> = places.iter().map(|p| first.0 * 10f64.powf(unit * (p.1 - first.1))).collect();
    let ends = [(drawn[0], 0), (drawn[drawn.len() - 1], t.len() - 1)];
    for (value, row) in ends {
        let exact = kinetic[row] + elastic[row];
        assert!((value / exact).log10().abs() < 1.5 * unit.abs(), "{value} J, not {exact} J");
    }
}

/// The difference of two oscillators, of 3 N/m and 4 N/m, with frames and gauges at other times, is that of the closed
/// forms at the times of the first. Cubics with rates leave (w h)^4 x0/384 = 0.0001 m at h = 0.25 s, straight lines
/// would leave 0.03 m. Without rates they leave 0.016 h^3 w^4 x0 = 0.001 m/s. Half a unit is 0.001 m, and 0.003 s at
/// 5 m/s.
#[test]
fn differences_of_two_runs() {
    let desk = Desk::new();
    let gauge = |every| {
        format!(r#"output.gauges=[{{"name": "mass", "on": {{"ids": [1]}}, "of": "velocity", "every": {every}}}]"#)
    };
    let first = ["--method", "rk4", "--step", "0.02", "--set", "output.frames.every=0.1", "--set", &gauge(5)];
    let stiff = "system.network.springs.0.stiffness=4";
    let second =
        ["--method", "rk4", "--step", "0.025", "--set", "output.frames.every=0.25", "--set", stiff, "--set", &gauge(4)];
    assert_eq!(desk.solve("oscillator", "a", &first), Some(0));
    assert_eq!(desk.solve("oscillator", "b", &second), Some(0));
    desk.plot(&["a", "--minus", "b", "--kind", "displacement,gauges"], &["displacement.svg", "gauges.svg"]);
    let w = 2_f64.sqrt();
    let picture = desk.picture("displacement.svg");
    let curve = &picture.curves(BLUE)[0];
    let error = largest(curve.iter().map(|(t, x)| x - 2.0 * ((w0() * t).cos() - (w * t).cos())));
    assert!(curve.len() == 201 && error < 0.015, "{} points, {error} m", curve.len());
    assert!(picture.says("Δ displacement in x [m]"), "{:?}", picture.words());
    let title = "oscillator: displacement of &quot;mass&quot; (node 1), h = 0.02 s minus h = 0.025 s";
    assert!(picture.says(title), "{:?}", picture.words());
    let curve = &Picture::panels(&desk.text("gauges.svg"))[0].curves(BLUE)[0];
    let exact = |t: f64| 2.0 * (w * (w * t).sin() - w0() * (w0() * t).sin());
    let error = largest(curve.iter().map(|(t, v)| v - exact(*t)));
    assert!(curve.len() == 201 && error < 0.03, "{} points, {error} m/s", curve.len());
    // A run minus itself is nothing.
    desk.plot(&["a", "--minus", "a", "--kind", "energy"], &["energy.svg"]);
    let rest = desk.picture("energy.svg");
    assert!(rest.curves(VERMILLION)[0].iter().all(|p| p.1.abs() < 1e-9), "{:?}", rest.curves(VERMILLION)[0]);
}

/// A curve that an earlier one lies under is dashed, in the legend too; others are not.
#[test]
fn coinciding_curves_are_dashed() {
    let desk = Desk::new();
    for method in ["newmark", "rk4", "explicit-euler"] {
        assert_eq!(desk.solve("oscillator", method, &["--method", method, "--step", "0.01", "--end", "8"]), Some(0));
    }
    desk.plot(&["newmark", "rk4", "explicit-euler", "--kind", "displacement"], &["displacement.svg"]);
    let picture = desk.picture("displacement.svg");
    assert_eq!(picture.dashed, [ORANGE, ORANGE], "rk4's curve, and its sample in the legend");
    assert_eq!(picture.curves(BLUE).len(), 1);
}
