//! `canopy-fem plot` as a user meets it: cases are run, plotted, and the pictures read back.

#[cfg(feature = "pictures")]
mod formats;
mod kinds;
mod refused;
mod svg;

use std::path::{Path, PathBuf};
use svg::Picture;
use tempfile::TempDir;

const BLUE: &str = "#0072B2";
const VERMILLION: &str = "#D55E00";
const GREEN: &str = "#009E73";
const BLACK: &str = "#000000";
const ORANGE: &str = "#E69F00";

/// What the results of the oscillator hold.
const KINDS: [&str; 6] = ["displacement", "phase", "energy", "ledger", "steps", "tension"];
/// The charts of it to look at first.
const FIRST: [&str; 4] = ["displacement", "phase", "energy", "tension"];

/// A folder in which cases are run and plotted.
struct Desk(TempDir);

struct Ended {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

impl Desk {
    fn new() -> Self {
        Desk(TempDir::new().expect("a folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn run(&self, arguments: &[&str]) -> Ended {
        let mut program = assert_cmd::Command::new(assert_cmd::cargo::cargo_bin!("canopy-fem"));
        let output = program.current_dir(self.0.path()).args(arguments).output().expect("the program starts");
        let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
        Ended { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }

    /// Runs a case of `assets/cases` into a folder; the exit status.
    fn solve(&self, case: &str, out: &str, arguments: &[&str]) -> Option<i32> {
        let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/cases").join(format!("{case}.json"));
        let case = case.to_str().expect("UTF-8");
        self.run(&[&["solve", case, "--out", out, "--quiet"], arguments].concat()).code
    }

    /// Plots and expects files of these names, in this order, and nothing else.
    fn plot(&self, arguments: &[&str], files: &[impl AsRef<str>]) {
        let ended = self.run(&[&["plot"], arguments].concat());
        let complaints = ended.stderr.lines().filter(|line| !line.starts_with("note: ")).collect::<Vec<_>>();
        assert_eq!((ended.code, complaints), (Some(0), Vec::new()));
        assert_eq!(ended.stdout.lines().collect::<Vec<_>>(), files.iter().map(AsRef::as_ref).collect::<Vec<_>>());
    }

    /// A column of a table by its name.
    fn column(&self, file: &str, name: &str) -> Vec<f64> {
        let table = std::fs::read_to_string(self.path(file)).expect("written");
        let (header, rows) = table.split_once('\n').expect("a header");
        let column = header.split(',').position(|n| n == name).expect("a column of this name");
        rows.lines().map(|row| row.split(',').nth(column).expect("a cell").parse().expect("a number")).collect()
    }

    fn picture(&self, file: &str) -> Picture {
        Picture::read(&self.text(file))
    }

    fn text(&self, file: &str) -> String {
        std::fs::read_to_string(self.path(file)).expect("written")
    }
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.map(f64::abs).fold(0.0, f64::max)
}

/// The oscillator's pictures against its closed form x = 2 m cos(w0 t), w0^2 = 3/2 s^-2. A drawing unit is 0.1 px; in
/// the picture of 700 px by 440 px half a unit at the curve and at the numbers of both axes is 0.001 m and 0.003 s, and
/// 0.003 s are 0.007 m at the largest speed, 2.45 m/s. The scheme adds 2 m w0 t (w0 h)^2/24 = 0.0003 m.
#[test]
fn the_oscillator_is_drawn_as_it_moves() {
    let desk = Desk::new();
    assert_eq!(desk.solve("oscillator", "out", &[]), Some(0));
    desk.plot(&["out", "--all"], &KINDS.map(|kind| format!("out/{kind}.svg")));
    desk.plot(&["out"], &FIRST.map(|kind| format!("out/{kind}.svg")));
    let w0 = 1.5_f64.sqrt();

    let displacement = desk.picture("out/displacement.svg");
    assert!(displacement.says("2 m at 0 s"), "the peak is told: {:?}", displacement.words());
    assert!(displacement.says("oscillator: displacement of &quot;mass&quot; (node 1)"), "{:?}", displacement.words());
    assert!(displacement.says("displacement in x [m]") && displacement.says("time t [s]"));
    let curves = displacement.curves(BLUE);
    assert_eq!((curves.len(), curves[0].len()), (1, 201), "one line of one point a frame");
    let error = largest(curves[0].iter().map(|(t, x)| x - 2.0 * (w0 * t).cos()));
    assert!(error < 0.01, "{error} m from the closed form");
    let extreme = largest(curves[0].iter().map(|p| p.1));
    assert!((extreme - 2.0).abs() < 0.0015, "swings to {extreme} m");

    let phase = desk.picture("out/phase.svg");
    assert!(phase.says("velocity in x [m/s]"));
    let curves = phase.curves(BLUE);
    // Half a unit of speed, 0.001 m/s, is as long as 0.001 m here.
    let error = largest(curves[0].iter().map(|(x, v)| x.hypot(v / w0) - 2.0));
    assert!(error < 0.004, "{error} m from the circle");

    // 1/2 k x0^2 = 6 J, all of it elastic at the start. Half a unit is 0.0007 J; the scheme's energy leaves 6 J by (w0
    // h)^2/4 of it, 0.0002 J, at most; and 0.003 s are 0.02 J where the elastic energy changes fastest, by 6 J w0 a
    // second.
    let energy = desk.picture("out/energy.svg");
    let sum = energy.curves(BLACK);
    let error = largest(sum[0].iter().map(|(_, e)| e - 6.0));
    assert!(error < 0.002, "{error} J from 6 J");
    let elastic = energy.curves(VERMILLION);
    let error = largest(elastic[0].iter().map(|(t, e)| e - 6.0 * (w0 * t).cos().powi(2)));
    assert!(error < 0.05, "{error} J from the closed form");
    assert!(energy.says("kinetic") && energy.says("elastic"), "{:?}", energy.words());
    assert!(!energy.says("gravity") && !energy.says("dissipated"), "entries that are zero are left out");
}

/// Frames every 2.5 steps of explicit Euler lie on its spiral, r = 2 m (1 + (w0 h)^2)^(t/2h): between two steps the
/// velocity is that of the chord, which cuts the turn w0 h of a step by (w0 h)^2/8 of r.
#[test]
fn euler_spirals_between_its_steps() {
    let desk = Desk::new();
    let arguments = ["--method", "explicit-euler", "--step", "0.02", "--set", "output.frames.every=0.05"];
    assert_eq!(desk.solve("oscillator", "out", &arguments), Some(0));
    let [t, x, v] = ["t", "x", "vx"].map(|name| desk.column("out/probes.csv", name));
    let w0 = 1.5_f64.sqrt();
    let turn = w0 * 0.02;
    let off =
        |((t, x), v): ((&f64, &f64), &f64)| (x - 10.0).hypot(v / w0) / (2.0 * (1.0 + turn * turn).powf(t / 0.04)) - 1.0;
    let error = largest(t.iter().zip(&x).zip(&v).map(off));
    assert_eq!(t.len(), 401);
    assert!(error < 1.2 * turn * turn / 8.0, "{error} of the radius, a chord cuts {}", turn * turn / 8.0);
}

/// Several runs lie in one picture, told apart by what they differ in.
#[test]
fn several_runs_are_overlaid() {
    let desk = Desk::new();
    for method in ["explicit-euler", "newmark", "rk4"] {
        assert_eq!(desk.solve("oscillator", method, &["--method", method, "--step", "0.05"]), Some(0));
    }
    let files = ["both/displacement.svg", "both/energy.svg"];
    let asked = ["--kind", "displacement", "--kind", "energy", "--out", "both"];
    desk.plot(&[&["explicit-euler", "newmark", "rk4"], &asked[..]].concat(), &files);
    let picture = desk.picture("both/displacement.svg");
    for (method, color) in [("explicit-euler", BLUE), ("newmark", GREEN), ("rk4", ORANGE)] {
        assert!(picture.says(method), "{:?}", picture.words());
        let curves = picture.curves(color);
        assert_eq!(curves.len(), 1, "{method}");
        let extreme = largest(curves[0].iter().map(|p| p.1));
        // Explicit Euler grows by sqrt(1 + (w0 h)^2) a step; its last extreme is at about 18 s. A frame is at most 0.05
        // s from it.
        let expected = if method == "explicit-euler" { 2.0 * 1.00375_f64.powf(0.5 * 18.0 / 0.05) } else { 2.0 };
        assert!((extreme / expected - 1.0).abs() < 0.003, "{method} swings to {extreme} m, not {expected} m");
    }
    let energy = desk.picture("both/energy.svg");
    for panel in [
        "kinetic energy",
        "elastic energy",
        "numerical energy, the error of the scheme",
        "kinetic + elastic + gravity energy",
    ] {
        assert!(energy.says(&format!("oscillator: {panel}")), "{:?}", energy.words());
    }
    assert_eq!(energy.lines.iter().filter(|(c, p)| c == GREEN && p.len() > 2).count(), 4, "a line a panel");

    // The same method in another step; then the same in everything, told apart by its folder.
    assert_eq!(desk.solve("oscillator", "coarse", &["--method", "rk4", "--step", "0.1"]), Some(0));
    desk.plot(&["rk4", "coarse", "--kind", "phase"], &["phase.svg"]);
    let picture = desk.picture("phase.svg");
    assert!(picture.says("h = 0.05 s") && picture.says("h = 0.1 s"), "{:?}", picture.words());
    assert_eq!(desk.solve("oscillator", "again", &["--method", "rk4", "--step", "0.1"]), Some(0));
    desk.plot(&["again", "coarse", "--kind", "phase"], &["phase.svg"]);
    let picture = desk.picture("phase.svg");
    assert!(picture.says("again") && picture.says("coarse"), "{:?}", picture.words());
}

/// A pendulum shows its angle, unless a direction is asked for.
#[test]
fn a_pendulum_shows_its_angle() {
    let desk = Desk::new();
    assert_eq!(desk.solve("pendulum", "out", &["--end", "5"]), Some(0));
    desk.plot(&["out", "--kind", "displacement"], &["out/displacement.svg"]);
    let angle = desk.picture("out/displacement.svg");
    assert!(angle.says("pendulum: angle") && angle.says("angle θ [rad]"), "{:?}", angle.words());
    // It begins at 0.5 rad, and damping takes the rest of the swings below.
    let extreme = largest(angle.curves(BLUE)[0].iter().map(|p| p.1));
    assert!((extreme - 0.5).abs() < 0.001, "{extreme} rad");
    desk.plot(&["out", "--kind", "displacement", "--axis", "z"], &["out/displacement.svg"]);
    let height = desk.picture("out/displacement.svg");
    assert!(height.says("displacement in z [m]"), "{:?}", height.words());
    // It begins L (1 - cos 0.5 rad) above its lowest point; half a unit of this axis is 0.0001 m.
    let highest = largest(height.curves(BLUE)[0].iter().map(|p| p.1));
    assert!((highest - (1.0 - 0.5_f64.cos())).abs() < 2e-4, "{highest} m");
}

/// Beside an oscillator a pendulum's bob swings about 0 in x too; no title tells of nodes that only one of them has.
#[test]
fn unlike_cases_are_overlaid() {
    let desk = Desk::new();
    assert_eq!(desk.solve("oscillator", "oscillator", &["--end", "5"]), Some(0));
    assert_eq!(desk.solve("pendulum", "pendulum", &["--end", "5"]), Some(0));
    desk.plot(&["oscillator", "pendulum", "--kind", "displacement"], &["displacement.svg"]);
    let picture = desk.picture("displacement.svg");
    assert!(picture.says("displacement") && picture.says("displacement in x [m]"), "{:?}", picture.words());
    let bob = &picture.curves(VERMILLION)[0];
    // L sin 0.5 rad; half a unit is 0.0005 m.
    let (start, farthest) = (bob[0].1, largest(bob.iter().map(|p| p.1)));
    let expected = 0.5_f64.sin();
    assert!((start - expected).abs() < 2e-3 && (farthest - expected).abs() < 2e-3, "{start} m, {farthest} m");
    // c/m = 0.1/s leaves exp(-0.05 t) of the angle until the other side, half a swing of 2.04 s later. The nearest
    // frame is up to 0.025 s away, in which the bob comes back by g/L x t^2/2 = 0.0015 m.
    let other_side = bob.iter().map(|p| p.1).fold(0.0, f64::min);
    let expected = -(0.5 * (-0.05_f64 * 1.02).exp()).sin();
    assert!((other_side - expected).abs() < 3e-3, "{other_side} m, not {expected} m");

    let probes = r#"output.probes=[{"name": "mass", "on": "all"}]"#;
    assert_eq!(desk.solve("oscillator", "both", &["--end", "5", "--set", probes]), Some(0));
    desk.plot(&["oscillator", "both", "--kind", "displacement"], &["displacement.svg"]);
    let picture = desk.picture("displacement.svg");
    assert!(picture.says("oscillator: displacement of &quot;mass&quot;"), "{:?}", picture.words());
}

/// A bundle of nodes is one entry of the legend; probes, nodes and times can be chosen.
#[test]
fn parts_of_the_results_are_chosen() {
    let desk = Desk::new();
    let probes = r#"output.probes=[{"name": "edge", "on": {"ids": [697, 698, 699, 700, 701, 702]}},
                                   {"name": "one & only", "on": {"ids": [650]}}]"#;
    let short = ["--set", probes, "--end", "0.2", "--set", "output.frames.every=0.01"];
    assert_eq!(desk.solve("cloth-k1000", "out", &short), Some(0));
    let chart = |arguments: &[&str]| {
        desk.plot(&[&["out", "--kind", "displacement"], arguments].concat(), &["out/displacement.svg"]);
        desk.picture("out/displacement.svg")
    };
    let all = chart(&[]);
    assert!(all.says("displacement in z [m]"), "the wind blows along z: {:?}", all.words());
    assert!(all.says("edge") && all.says("one &amp; only"), "{:?}", all.words());
    assert_eq!([all.curves(BLUE).len(), all.curves(VERMILLION).len()], [6, 1]);
    let few = chart(&["--nodes", "698..699,702"]);
    assert!(["node 698", "node 699", "node 702"].iter().all(|n| few.says(n)), "{:?}", few.words());
    let one = chart(&["--probe", "one & only", "--from", "0.05", "--to", "0.15"]);
    let curve = &one.curves(BLUE)[0];
    assert_eq!(curve.len(), 11, "frames from 0.05 s to 0.15 s");
    assert!((curve[0].0 - 0.05).abs() < 1e-4 && (curve[10].0 - 0.15).abs() < 1e-4, "{curve:?}");
}

/// A run that diverged is drawn as far as it went, marked, and named so; beside a sound run it does not squeeze that
/// one flat.
#[test]
fn a_diverged_run_is_drawn() {
    let desk = Desk::new();
    let wild = ["--method", "explicit-euler", "--step", "0.9", "--end", "200", "--keep-going"];
    assert_eq!(desk.solve("oscillator", "wild", &wild), Some(3));
    assert_eq!(desk.solve("oscillator", "good", &["--step", "0.9"]), Some(0));
    desk.plot(&["wild", "--all"], &KINDS.map(|kind| format!("wild/{kind}.svg")));
    let alone = desk.picture("wild/displacement.svg");
    // Growth of sqrt(1 + (0.9 w0)^2) a step passes 1e4 times the scene's 10 m in the 30th: 2 m 1.488^30 = 3e5 m.
    assert!(alone.says("diverged at 27 s"), "{:?}", alone.words());
    // The energy grows at each of 30 steps; the median one is the 15th, and ten times what was made until then is
    // shown, with a margin of 4 % of twice that. Half a unit is 0.04 % of it.
    let made = desk.column("wild/history.csv", "numerical");
    let edge = 10.0 * (1.0 + 0.04 * 2.0) * -made[15];
    let energy = desk.picture("wild/energy.svg");
    let shown = largest(energy.curves(BLACK).iter().flatten().map(|p| p.1));
    assert!((shown / edge - 1.0).abs() < 2e-3, "{shown} J of {edge} J, and {} J at the end", made[30]);
    let crosses = energy.crosses(BLACK);
    let off = |(t, e): &(f64, f64)| (t - 27.0).abs().max((e / edge - 1.0).abs() / 0.02);
    assert!(crosses.len() == 2 && largest(crosses.iter().map(off)) < 0.1, "{crosses:?} J is not at {edge} J");
    desk.plot(&["wild", "good", "--kind", "displacement"], &["displacement.svg"]);
    let both = desk.picture("displacement.svg");
    let legend = "explicit-euler, diverged at 27 s";
    assert!(both.says(legend) && both.says("velocity-verlet"), "{:?}", both.words());
    // The frame begins 42 px below the top, under the title; no line is above it, from however far it came.
    let highest = both.lines.iter().flat_map(|(_, points)| points).map(|p| p.1).fold(f64::INFINITY, f64::min);
    assert!(highest >= 420.0, "a line at {highest} tenths of a pixel");
    let good = largest(both.curves(VERMILLION)[0].iter().map(|p| p.1));
    let wild = largest(both.curves(BLUE).iter().flatten().map(|p| p.1));
    // The sound one swings over 4 m; the frame leaves as much again to either side, and 4 % of the 12 m. The other is
    // cut there; half a unit is 0.0015 m.
    let edge = 2.0 + 4.0 + 0.04 * 12.0;
    assert!((good - 2.0).abs() < 0.01 && (wild - edge).abs() < 0.03, "{good} m and {wild} m, cut at {edge} m");
    // What is lost in a dashpot is nothing beside the energies of the blow-up, and shown all the same.
    assert_eq!(desk.solve("oscillator-damped", "damped", &[]), Some(0));
    desk.plot(&["wild", "damped", "--kind", "energy"], &["energy.svg"]);
    let energy = desk.picture("energy.svg");
    assert!(energy.says("dissipated energy") && energy.says("kinetic energy"), "{:?}", energy.words());
}

/// A run without probes has an energy account all the same; a long one is thinned.
#[test]
fn long_runs_without_probes() {
    let desk = Desk::new();
    let bare = ["--set", "output.probes=null", "--step", "0.001", "--set", "output.history.every=1"];
    assert_eq!(desk.solve("oscillator", "out", &bare), Some(0));
    desk.plot(&["out", "--all"], &KINDS[2..].iter().map(|kind| format!("out/{kind}.svg")).collect::<Vec<_>>());
    let curves = desk.picture("out/energy.svg").curves(VERMILLION);
    assert_eq!(curves.len(), 1);
    // 20001 rows are 500 sections of 40; each leaves its extremes in both directions, which are two to four points.
    assert!((1000..=2002).contains(&curves[0].len()), "20001 rows became {} points", curves[0].len());
    let extreme = largest(curves[0].iter().map(|p| p.1));
    assert!((extreme - 6.0).abs() < 0.01, "{extreme} J");
}
